//! Memory of the host that deformed vertices are written to.

use super::check::{defs, enumerator};
use super::memory::{Stream, disjoint};
use super::result::{CrumpleResult, Failure};
use super::types::{CrumpleDirectionFormat, CrumpleStream};
use crate::deform::{Attribute, Encoding, RawStream, VertexMemory};
use crate::instance::Instance;
use crate::instance::options::Rule;
use std::mem::MaybeUninit;

/// Memory for the deformed vertices of one instance, in the mesh's order and space.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleHostBufferDef {
    pub struct_size: u32,
    /// Which mesh: 0 for the base mesh, or a number from crumple_example_set_add_lod(). Default 0.
    pub lod: u32,
    /// Any number of yours. Default 0.
    pub user_data: u64,
    /// Positions, m. Required.
    pub positions: CrumpleStream,
    /// Unit normals in normal_format. Absent: not written.
    pub normals: CrumpleStream,
    /// Tangents in tangent_format: xyz of unit length and orthogonal to the normal, w as in the mesh. Absent: not
    /// written.
    pub tangents: CrumpleStream,
    pub normal_format: MaybeUninit<CrumpleDirectionFormat>,
    pub tangent_format: MaybeUninit<CrumpleDirectionFormat>,
}

defs!(CrumpleHostBufferDef);

/// Checked memory of the host.
#[derive(Debug, Clone, Copy)]
pub(super) struct HostMemory {
    positions: Stream,
    normals: Option<Stream>,
    tangents: Option<Stream>,
    /// Formats of normals and tangents.
    formats: [Encoding; 2],
}

impl HostMemory {
    pub(super) fn new(def: &CrumpleHostBufferDef, instance: &Instance) -> Result<Self, Failure> {
        if def.lod > 0 && instance.options().rule != Rule::Marks {
            return Err(instance.needs_marks("a buffer of another level of detail than 0").into());
        }
        let mesh = instance.example_set().lod_mesh(def.lod as usize)?;
        let n = mesh.positions().len();
        let positions = Stream::new(def.positions, 12, n, "def.positions")?;
        let normal_format = enumerator(def.normal_format, "def.normal_format")?;
        let tangent_format = enumerator(def.tangent_format, "def.tangent_format")?;
        let bytes = |format, floats| if format == CrumpleDirectionFormat::Float { floats } else { 4 };
        let normals = Stream::new(def.normals, bytes(normal_format, 12), n, "def.normals")?;
        let tangents = Stream::new(def.tangents, bytes(tangent_format, 16), n, "def.tangents")?;
        disjoint(&[("def.positions", positions), ("def.normals", normals), ("def.tangents", tangents)])?;
        let lacks = |what: &str, why: &str| -> Failure {
            crate::base::error::Error::Mesh { what: format!("it has no {what} to deform{why}") }.into()
        };
        if normals.is_some() && mesh.normals().is_none() {
            return Err(lacks("normals", ", nor triangles to compute them from"));
        }
        if tangents.is_some() && mesh.tangents().is_none() {
            return Err(lacks("tangents", ""));
        }
        let positions = positions.ok_or_else(|| {
            Failure::new(CrumpleResult::CrumpleErrorNullPointer, "def.positions.data is null; a buffer needs positions")
        })?;
        Ok(Self { positions, normals, tangents, formats: [normal_format.into(), tangent_format.into()] })
    }

    /// The memory as the deformer sees it.
    ///
    /// # Safety
    /// The host's memory is still there, and nobody else touches it while a deform runs.
    pub(super) unsafe fn vertices(&self) -> Result<VertexMemory<'static>, Failure> {
        let raw = |s: &Stream, format| RawStream {
            data: s.data,
            size: (s.layout.span().end - s.layout.first) as usize,
            layout: Attribute { offset: 0, stride: s.layout.stride as usize, format },
        };
        let [normals, tangents] = [(&self.normals, self.formats[0]), (&self.tangents, self.formats[1])]
            .map(|(s, format)| s.as_ref().map(|s| raw(s, format)));
        // SAFETY: the caller's; `new` checked sizes, alignment, strides and that the streams are disjoint.
        Ok(unsafe { VertexMemory::from_raw(raw(&self.positions, Encoding::F32), normals, tangents) }?)
    }

    pub(super) fn streams(&self) -> impl Iterator<Item = Stream> {
        [Some(self.positions), self.normals, self.tangents].into_iter().flatten()
    }
}
