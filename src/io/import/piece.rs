//! The pieces of a body: meshes of the file, and how they lie in the body.

use super::document::Document;
use super::extras::Impact;
use super::primitives::{Primitive, deltas};
use super::surface::Surface;
use super::{Imported, PartKind};
use crate::base::error::Error;
use crate::base::math::to_f32;
use crate::example::data::Contact;
use crate::mesh::data::MeshData;
use glam::{DMat3, DMat4, DVec3};

/// A body, and how its vertices lie in the file. The exporter uses it to write vertices back.
pub(crate) struct Body<'d> {
    pub pieces: Vec<Piece<'d>>,
    pub imported: Imported,
}

/// One mesh of the file, as a node shows it.
pub(crate) struct Piece<'d> {
    pub mesh: usize,
    /// The nodes that show it so: one of a joined body, or those that show a single mesh.
    pub nodes: Vec<usize>,
    pub name: String,
    pub primitives: Vec<Primitive<'d>>,
    /// In the mesh's own space and the file's unit, with every target at weight zero.
    pub surface: Surface,
    /// The dents that the file shows by default, with their weights.
    pub shown: Vec<(usize, f32)>,
    /// The targets that are dents, in order.
    pub dents: Vec<usize>,
    /// The names of all targets.
    pub(super) names: Vec<String>,
    /// From the mesh's own space to the body's, m.
    pub to_body: DMat4,
    pub first_vertex: usize,
    /// What the node does when it is hit, and each primitive.
    pub(super) kind: PartKind,
    pub(super) kinds: Vec<PartKind>,
    pub(super) targets: Vec<Target>,
}

/// A target that is a dent, as it is read: displacements and changes of normals of vertices, by their indices.
#[derive(Default)]
pub(super) struct Target {
    pub name: String,
    pub moved: Vec<(u32, [f32; 3])>,
    pub turned: Option<Vec<(u32, [f32; 3])>>,
    pub impact: Impact,
}

/// What is added to vertices, in the mesh's own space and the file's unit.
pub(crate) struct Offsets {
    pub positions: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
}

impl Piece<'_> {
    /// Its arrays in the body's space.
    pub(super) fn placed(&self) -> MeshData {
        let mut mesh = self.surface.data.clone();
        if self.kinds.contains(&PartKind::Rigid) {
            let stiffness = mesh.stiffness.get_or_insert_with(|| vec![0.0; mesh.positions.len()]);
            for (primitive, _) in self.primitives.iter().zip(&self.kinds).filter(|(_, kind)| **kind == PartKind::Rigid)
            {
                stiffness[primitive.vertices()].fill(1.0);
            }
        }
        place(&mut mesh, self.to_body);
        mesh
    }

    /// What the dents that the file shows by default add to each vertex. `None` if it shows none.
    pub fn shown_offsets(&self, doc: &Document<'_>) -> Result<Option<Offsets>, Error> {
        if self.shown.is_empty() {
            return Ok(None);
        }
        let count = self.surface.data.positions.len();
        let mut out = Offsets { positions: vec![[0.0; 3]; count], normals: vec![[0.0; 3]; count] };
        let add = |to: &mut [[f32; 3]], deltas: &[(u32, [f32; 3])], weight: f32| {
            for (i, delta) in deltas {
                let slot = &mut to[*i as usize];
                *slot = std::array::from_fn(|k| slot[k] + weight * delta[k]);
            }
        };
        for (target, weight) in &self.shown {
            let deltas = deltas(doc, &self.primitives, *target)?;
            add(&mut out.positions, &deltas.positions, *weight);
            add(&mut out.normals, &deltas.normals, *weight);
        }
        Ok(Some(out))
    }

    /// Its targets in the body's space, where its normals are `placed`.
    pub(super) fn placed_targets(&mut self, placed: Option<&[[f32; 3]]>) -> Vec<Target> {
        let mut targets = std::mem::take(&mut self.targets);
        if self.to_body == DMat4::IDENTITY {
            return targets;
        }
        let linear = DMat3::from_mat4(self.to_body);
        let normals = linear.inverse().transpose();
        for Target { moved, turned, impact, .. } in &mut targets {
            moved.iter_mut().for_each(|(_, v)| *v = to_f32(linear * DVec3::from(v.map(f64::from))));
            if let (Some(placed), Some(own)) = (placed, &self.surface.data.normals) {
                for (v, change) in turned.iter_mut().flatten() {
                    let (own, placed) = (own[*v as usize], placed[*v as usize]);
                    let after = unit_mapped(normals, std::array::from_fn(|k| own[k] + change[k]));
                    *change = std::array::from_fn(|k| after[k] - placed[k]);
                }
            }
            if let Some(Contact::Point(p)) = &mut impact.contact {
                *p = to_f32(self.to_body.transform_point3(DVec3::from(p.map(f64::from))));
            }
            impact.normal = impact.normal.map(|n| unit_mapped(normals, n));
            impact.blow = impact.blow.transformed(linear);
        }
        targets
    }
}

fn unit_mapped(linear: DMat3, v: [f32; 3]) -> [f32; 3] {
    to_f32((linear * DVec3::from(v.map(f64::from))).normalize_or_zero())
}

/// Takes a mesh to the body's space.
fn place(mesh: &mut MeshData, to_body: DMat4) {
    let linear = DMat3::from_mat4(to_body);
    if to_body == DMat4::IDENTITY {
        return;
    }
    let normals = linear.inverse().transpose();
    for p in &mut mesh.positions {
        *p = to_f32(to_body.transform_point3(DVec3::from(p.map(f64::from))));
    }
    mesh.normals.iter_mut().flatten().for_each(|n| *n = unit_mapped(normals, *n));
    let mirrored = linear.determinant() < 0.0;
    for tangent in mesh.tangents.iter_mut().flatten() {
        let [x, y, z, w] = *tangent;
        let [x, y, z] = unit_mapped(linear, [x, y, z]);
        *tangent = [x, y, z, if mirrored { -w } else { w }];
    }
    if mirrored {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    let scale = linear.determinant().abs().cbrt() as f32;
    mesh.depth_limits.iter_mut().flatten().for_each(|limit| *limit *= scale);
}
