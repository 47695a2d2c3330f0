//! Points bound to the surface of a set's base mesh, and where they are on an instance.

use crate::base::error::Error;
use crate::example::set::ExampleSet;
use crate::mesh::finite;
use crate::mesh::surface::closest;
use bytemuck::{Pod, Zeroable};

/// A point bound to the surface nearest to it. Plain data; belongs to the set that made it.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Attachment {
    /// The triangle's vertices; all the same for a mesh without triangles.
    pub vertices: [u32; 3],
    /// Barycentric weights of the surface point; they sum to 1.
    pub weights: [f32; 3],
    /// The attached point at rest, in the mesh's space, m.
    pub point: [f32; 3],
}

/// Where an attached point is.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Pose {
    /// Position in the mesh's space, m.
    pub position: [f32; 3],
    /// Rotation since rest, a unit quaternion (x, y, z, w).
    pub rotation: [f32; 4],
}

impl ExampleSet {
    /// Binds a point to the nearest surface, or to the nearest vertex if the mesh has no triangles. The point keeps its
    /// distance from the surface and turns with it.
    ///
    /// The first call builds a spatial index of the triangles.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::InvalidArgument`] for a point too far away for f32; [`Error::OutOfMemory`].
    pub fn attach(&self, point: [f32; 3]) -> Result<Attachment, Error> {
        let p = finite(point, || "point".into())?;
        let vertex = self.nearest_vertex(point)?.vertex;
        let single = Attachment { vertices: [vertex; 3], weights: [1.0, 0.0, 0.0], point };
        Ok(match self.surface().nearest(p) {
            Some(t) => Attachment { vertices: t.vertices, weights: closest(t.corners(), p).map(|w| w as f32), point },
            None => single,
        })
    }
}
