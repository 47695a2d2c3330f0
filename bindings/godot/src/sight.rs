//! An area around a body that does not move. The physics server tells which bodies enter and leave it.

use crate::physics;
use godot::builtin::{Aabb, Basis, Callable, Rid, Transform3D, Variant};
use godot::classes::PhysicsServer3D;
use godot::classes::physics_server_3d::AreaBodyStatus;
use godot::prelude::*;

pub struct Sight {
    area: Rid,
    shape: Rid,
    bounds: Aabb,
    space: Rid,
}

impl Sight {
    /// An area that tells of bodies near `owner`.
    pub fn new(owner: Rid) -> Self {
        let mut server = PhysicsServer3D::singleton();
        let (area, shape) = (server.area_create(), server.box_shape_create());
        server.area_add_shape(area, shape);
        server.area_set_monitorable(area, false);
        server.area_set_collision_layer(area, 0);
        server.area_set_collision_mask(area, u32::MAX);
        let seen = move |arguments: &[&Variant]| {
            // The status, the body, its node's id, its shape, and the area's shape.
            let [status, body, id, part, ..] = arguments else { return };
            let entered = status.try_to::<i32>().is_ok_and(|status| status == AreaBodyStatus::ADDED.ord());
            let (Ok(body), Ok(id), Ok(part)) = (body.try_to::<Rid>(), id.try_to::<i64>(), part.try_to::<i64>()) else {
                return;
            };
            if body != owner {
                physics::seen((owner, part), body, id, entered);
            }
        };
        server.area_set_monitor_callback(area, &Callable::from_fn("crumple_sight", seen));
        Self { area, shape, bounds: Aabb::default(), space: Rid::Invalid }
    }

    /// Moves the area to these bounds in a space.
    pub fn follow(&mut self, bounds: Aabb, space: Rid) {
        let mut server = PhysicsServer3D::singleton();
        if bounds != self.bounds {
            self.bounds = bounds;
            server.shape_set_data(self.shape, &(bounds.size * 0.5).to_variant());
            server.area_set_transform(self.area, Transform3D::new(Basis::IDENTITY, bounds.center()));
        }
        if space != self.space {
            self.space = space;
            server.area_set_space(self.area, space);
        }
    }

    /// Removes the area. The server outlives nodes, so this is not left to `drop`, which may come later.
    pub fn end(self) {
        let mut server = PhysicsServer3D::singleton();
        server.free_rid(self.area);
        server.free_rid(self.shape);
    }
}
