//! One example of a set, ready for use.

use super::blocks::DeltaBlocks;
use super::blow::Blow;
use crate::basis::Rows;
use glam::Vec3;
use std::sync::Arc;

/// One example of a set.
#[derive(Debug)]
pub struct Example {
    pub(crate) name: String,
    pub(crate) contact_vertex: u32,
    pub(crate) contact_point: Vec3,
    pub(crate) contact_normal: Option<Vec3>,
    pub(crate) contact_delta: Vec3,
    pub(crate) blow: Blow,
    pub(crate) depth: f32,
    pub(crate) max_depth: f32,
    pub(crate) support_radius: f32,
    pub(crate) moved: usize,
    /// What it moves, whole; `None` in a set from a file without.
    pub(crate) whole: Option<Arc<DeltaBlocks>>,
    /// What it moves the set's nodes by, and how the vertices follow them. There once the set is made.
    pub(crate) followed: Option<(Arc<DeltaBlocks>, Arc<Rows>)>,
}

impl Example {
    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The vertex that was hit when the example was made.
    pub fn contact_vertex(&self) -> u32 {
        self.contact_vertex
    }

    /// Base position of the contact vertex, m.
    pub fn contact_point(&self) -> Vec3 {
        self.contact_point
    }

    /// Outward unit normal at the contact. `None` if the mesh has no normals and none was given.
    pub fn contact_normal(&self) -> Option<Vec3> {
        self.contact_normal
    }

    /// Displacement of the contact vertex as it was given, m. It is not rounded to a tolerance.
    pub fn contact_displacement(&self) -> Vec3 {
        self.contact_delta
    }

    /// The blow that made the dent, in the mesh's space. Its normal has length 1.
    pub fn blow(&self) -> &Blow {
        &self.blow
    }

    /// Length of the contact's displacement, m. 0 only for an empty example.
    pub fn depth(&self) -> f32 {
        self.depth
    }

    /// Length of the longest displacement as stored, m.
    pub fn max_depth(&self) -> f32 {
        self.max_depth
    }

    /// Distance from the contact to the farthest vertex whose given displacement is at least a hundredth of the
    /// longest, m.
    pub fn support_radius(&self) -> f32 {
        self.support_radius
    }

    /// Number of vertices that the example moves.
    pub fn moved_vertices(&self) -> usize {
        self.moved
    }

    /// Whether the example moves nothing. It is kept, so that indices match the file, but never chosen.
    pub fn is_empty(&self) -> bool {
        self.moved == 0
    }

    /// Displacement of vertex `v` as it is shown, m: it follows the set's nodes.
    pub fn delta(&self, v: u32) -> Vec3 {
        let Some((nodes, rows)) = &self.followed else {
            return self.whole.as_ref().map_or(Vec3::ZERO, |whole| whole.delta(v));
        };
        rows.at_vertex(v, |node| nodes.delta(node))
    }

    /// Change of the unit normal of vertex `v`, which the classic rules use; zero in a set from a file without
    /// [whole examples](super::options::SetOptions::whole_examples).
    pub fn normal_delta(&self, v: u32) -> Vec3 {
        self.whole.as_ref().map_or(Vec3::ZERO, |whole| whole.normal_delta(v))
    }
}
