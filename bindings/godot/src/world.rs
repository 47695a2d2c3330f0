//! What nodes share: sets made of meshes, and the list of nodes whose mesh is out of date.

use crate::node::CrumpleMeshInstance3D;
use crate::set::CrumpleExampleSet;
use godot::classes::ArrayMesh;
use godot::prelude::*;
use std::cell::RefCell;
use std::collections::{HashMap, HashSet};

#[derive(Default)]
struct World {
    /// The set made of a mesh. Nodes keep it alive.
    sets: HashMap<InstanceId, InstanceId>,
    stale: HashSet<InstanceId>,
}

thread_local! {
    static WORLD: RefCell<World> = RefCell::default();
}

/// The set of a mesh that has blend shapes. Nodes with the same mesh get the same set.
pub fn set_of(mesh: &Gd<ArrayMesh>) -> Gd<CrumpleExampleSet> {
    let known = WORLD.with_borrow(|world| world.sets.get(&mesh.instance_id()).copied());
    if let Some(set) = known.and_then(|id| Gd::<CrumpleExampleSet>::try_from_instance_id(id).ok()) {
        return set;
    }
    let set = CrumpleExampleSet::of_mesh(mesh.clone());
    WORLD.with_borrow_mut(|world| {
        world.sets.retain(|_, set| Gd::<CrumpleExampleSet>::try_from_instance_id(*set).is_ok());
        world.sets.insert(mesh.instance_id(), set.instance_id());
    });
    set
}

/// Notes that a node's mesh is out of date. It is brought up to date when the running process or physics step ends.
pub fn mark(node: &Gd<CrumpleMeshInstance3D>) {
    if WORLD.with_borrow_mut(|world| world.stale.insert(node.instance_id())) {
        // By name: a call that waits must not hold on to the library, which the editor may load again.
        node.clone().call_deferred("_show_stale", &[]);
    }
}

/// Brings all meshes up to date. Of the calls of a step, the first does it.
pub fn show() {
    let stale = WORLD.with_borrow_mut(|world| std::mem::take(&mut world.stale));
    if !stale.is_empty() {
        let nodes = stale.into_iter().filter_map(|id| Gd::try_from_instance_id(id).ok());
        CrumpleMeshInstance3D::show(nodes.collect());
    }
}
