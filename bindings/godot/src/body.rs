//! One dented copy of a set: Crumple's instance, its vertices in memory, and Godot's mesh that shows them.

use crate::set::Built;
use crumple::{DeformJob, Instance, InstanceOptions, Tracker, VertexMemory};
use godot::classes::mesh::ArrayType;
use godot::classes::rendering_server::ArrayFormat;
use godot::classes::{ArrayMesh, RenderingServer};
use godot::obj::EngineEnum;
use godot::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// Changed ranges with a smaller gap, in vertices, are uploaded as one: a call costs more than some kilobytes.
const GAP: u32 = 512;

pub struct Body {
    pub built: Arc<Built>,
    pub instance: Instance,
    shown: Option<Shown>,
}

/// What exists once the body was dented.
struct Shown {
    tracker: Tracker,
    positions: Vec<[f32; 3]>,
    /// In the format of Godot's vertex buffers.
    normals: Vec<[u16; 2]>,
    tangents: Vec<[u16; 2]>,
    mesh: Gd<ArrayMesh>,
    layouts: Vec<Layout>,
}

/// The place of normals and tangents in a surface's vertex buffer, in bytes.
struct Layout {
    offset: usize,
    stride: usize,
    tangent: usize,
}

impl Body {
    pub fn new(built: Arc<Built>, options: InstanceOptions) -> Result<Self, crumple::Error> {
        let instance = Instance::new(built.set.clone(), options)?;
        Ok(Self { built, instance, shown: None })
    }

    /// Takes other options. The damage stays, and contacts end. After an error nothing has changed.
    pub fn renew(&mut self, options: InstanceOptions) -> Result<(), crumple::Error> {
        let mut instance = Instance::new(self.built.set.clone(), options)?;
        instance.copy_damage_from(&mut self.instance)?;
        self.instance = instance;
        Ok(())
    }

    /// The mesh that shows the body: the set's until it is dented.
    pub fn mesh(&self) -> Gd<ArrayMesh> {
        self.shown.as_ref().map_or_else(|| self.built.pristine.clone(), |shown| shown.mesh.clone())
    }

    /// Makes the body's own mesh, if there is damage to show. Returns whether it is new.
    pub fn prepare(&mut self) -> bool {
        self.instance.fold();
        if self.shown.is_some() || self.instance.marks().is_ok_and(<[_]>::is_empty) {
            return false;
        }
        let mesh = surfaces_mesh(&self.built);
        let base = self.built.set.mesh();
        let count = base.positions().len();
        let layouts = (0..self.built.surfaces.len()).map(|i| Layout::of(&mesh, i as i32)).collect();
        self.shown = Some(Shown {
            tracker: Tracker::new(),
            positions: vec![[0.0; 3]; count],
            normals: vec![[0; 2]; if base.normals().is_some() { count } else { 0 }],
            tangents: vec![[0; 2]; if base.tangents().is_some() { count } else { 0 }],
            mesh,
            layouts,
        });
        true
    }

    /// The job that brings the vertices up to date. `None` if nothing is shown.
    pub fn job(&mut self) -> Option<DeformJob<'_, '_>> {
        let shown = self.shown.as_mut()?;
        let mut memory = VertexMemory::separate(&mut shown.positions, None, None).ok()?;
        if !shown.normals.is_empty() {
            memory = memory.with_octahedral_normals(&mut shown.normals);
        }
        if !shown.tangents.is_empty() {
            memory = memory.with_octahedral_tangents(&mut shown.tangents);
        }
        Some(DeformJob { lod: 0, instance: &self.instance, tracker: &mut shown.tracker, memory })
    }

    /// Uploads what the last job changed, and moves the mesh's bounds along.
    pub fn upload(&mut self) {
        let Some(shown) = &mut self.shown else { return };
        if shown.tracker.changed().is_empty() {
            return;
        }
        let ranges = merged(shown.tracker.changed());
        for (i, (surface, layout)) in self.built.surfaces.iter().zip(&shown.layouts).enumerate() {
            let own = surface.first as u32..(surface.first + surface.count) as u32;
            for range in ranges.iter().map(|r| r.start.max(own.start)..r.end.min(own.end)).filter(|r| !r.is_empty()) {
                let all = range.start as usize..range.end as usize;
                let first = all.start - surface.first;
                let bytes = bytes_of(&shown.positions[all.clone()]);
                shown.mesh.surface_update_vertex_region(i as i32, (first * 12) as i32, &bytes);
                if layout.stride > 0 && surface.has_normals {
                    let tangents = if surface.has_tangents { &shown.tangents[all.clone()] } else { &[] };
                    let bytes = layout.interleaved(&shown.normals[all], tangents);
                    let offset = layout.offset + first * layout.stride;
                    shown.mesh.surface_update_vertex_region(i as i32, offset as i32, &bytes);
                }
            }
        }
        if let Some(bounds) = shown.tracker.bounds() {
            let mut aabb = aabb(bounds);
            // Surfaces that do not dent are seen too.
            if self.built.surfaces.iter().any(|surface| surface.count == 0) {
                aabb = aabb.merge(self.built.pristine.get_aabb());
            }
            shown.mesh.set_custom_aabb(aabb);
        }
    }
}

fn surfaces_mesh(built: &Built) -> Gd<ArrayMesh> {
    crate::surfaces::make(&built.surfaces)
}

fn aabb(bounds: crumple::Aabb) -> Aabb {
    let vector = |v: crumple::glam::Vec3| Vector3::new(v.x, v.y, v.z);
    let (min, max) = (vector(bounds.min), vector(bounds.max));
    Aabb::new(min, max - min)
}

/// Increasing ranges, with small gaps closed.
fn merged(ranges: &[Range<u32>]) -> Vec<Range<u32>> {
    let mut out: Vec<Range<u32>> = Vec::new();
    for range in ranges {
        match out.last_mut() {
            Some(last) if range.start - last.end < GAP => last.end = range.end,
            _ => out.push(range.clone()),
        }
    }
    out
}

fn bytes_of(positions: &[[f32; 3]]) -> PackedByteArray {
    let mut bytes = PackedByteArray::new();
    bytes.resize(12 * positions.len());
    for (to, value) in bytes.as_mut_slice().chunks_exact_mut(4).zip(positions.as_flattened()) {
        to.copy_from_slice(&value.to_le_bytes());
    }
    bytes
}

impl Layout {
    fn of(mesh: &Gd<ArrayMesh>, surface: i32) -> Self {
        let server = RenderingServer::singleton();
        let format = ArrayFormat::from_ord(mesh.surface_get_format(surface).ord());
        let count = mesh.surface_get_array_len(surface);
        let offset = |kind: ArrayType| server.mesh_surface_get_format_offset(format, count, kind.ord()) as usize;
        let normal = offset(ArrayType::NORMAL);
        Self {
            offset: normal,
            stride: server.mesh_surface_get_format_normal_tangent_stride(format, count) as usize,
            tangent: offset(ArrayType::TANGENT).saturating_sub(normal),
        }
    }

    /// The bytes of vertices: each normal, and its tangent if there is one.
    fn interleaved(&self, normals: &[[u16; 2]], tangents: &[[u16; 2]]) -> PackedByteArray {
        let mut bytes = PackedByteArray::new();
        bytes.resize(self.stride * normals.len());
        let put = |to: &mut [u8], [x, y]: [u16; 2]| {
            to[..2].copy_from_slice(&x.to_le_bytes());
            to[2..4].copy_from_slice(&y.to_le_bytes());
        };
        let vertices = bytes.as_mut_slice().chunks_exact_mut(self.stride);
        for (i, (vertex, normal)) in vertices.zip(normals).enumerate() {
            put(vertex, *normal);
            if let (Some(tangent), true) = (tangents.get(i), self.stride >= self.tangent + 4) {
                put(&mut vertex[self.tangent..], *tangent);
            }
        }
        bytes
    }
}
