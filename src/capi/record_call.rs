//! The calls that a recording holds.

use super::ids::Id;
use serde::{Deserialize, Serialize};
use std::fmt;

/// An id of the recorded context as a number.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub(super) struct Number(pub(super) u64);

impl Number {
    pub(super) fn of<I: Id>(id: I) -> Self {
        let (index, generation, context) = id.parts();
        Self(u64::from(index) | u64::from(generation) << 32 | u64::from(context) << 48)
    }
}

/// Shows the index, and the generation where it is not the first.
impl fmt::Debug for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 >> 32 & 0xffff {
            1 => write!(f, "{}", self.0 as u32),
            generation => write!(f, "{}.{generation}", self.0 as u32),
        }
    }
}

/// Bytes of a file or of saved damage.
#[derive(Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Bytes(#[serde(with = "serde_bytes")] pub(super) Vec<u8>);

impl fmt::Debug for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} bytes", self.0.len())
    }
}

macro_rules! calls {
    ($($(#[$doc:meta])* $function:literal $name:ident { $($field:ident: $type:ty),* $(,)? })*) => {
        /// A call with what was read from its arguments. The order of the calls is part of the file format.
        #[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
        pub(super) enum Call {
            $($(#[$doc])* $name { $($field: $type),* },)*
        }

        impl Call {
            /// The C function.
            pub(super) fn function(&self) -> &'static str {
                match self {
                    $(Call::$name { .. } => $function,)*
                }
            }
        }
    };
}

calls! {
    /// A set was made in any way, or got a level of detail: the bytes that `crumple_example_set_save_baked` gives now.
    "crumple_example_set_load_baked_memory" Set { set: Number, bytes: Bytes }
    "crumple_example_set_destroy" DestroySet { set: Number }
    "crumple_instance_create" CreateInstance {
        set: Number, rule: u32, selection: u32, examples_per_hit: u32, mark_capacity: u32, depth_limit: f32, yield_impulse: f32,
        yield_displacement: f32, max_contact_distance: f32, blend_constant: f32, tolerance: f32, compliance: f32, grow_time: f32, local_to_world: [f32; 16],
    }
    "crumple_instance_destroy" DestroyInstance { instance: Number }
    "crumple_instance_set_transform" SetTransform { instance: Number, local_to_world: [f32; 16] }
    "crumple_instance_set_depth_limit" SetDepthLimit { instance: Number, depth_limit: f32 }
    /// Also `crumple_instance_set_view`, with the tolerance that it sets.
    "crumple_instance_set_tolerance" SetTolerance { instance: Number, tolerance: f32 }
    "crumple_instance_submit_impulse" SubmitImpulse { instance: Number, hit: ImpulseHit }
    "crumple_instance_preview_impulse" PreviewImpulse { instance: Number, hit: ImpulseHit }
    "crumple_instance_submit_displacement" SubmitDisplacement { instance: Number, hit: DisplacementHit }
    "crumple_instance_preview_displacement" PreviewDisplacement { instance: Number, hit: DisplacementHit }
    "crumple_instance_end_contact" EndContact { instance: Number, contact_id: u64 }
    "crumple_instance_get_marks" GetMarks { instance: Number }
    "crumple_instance_set_marks" SetMarks { instance: Number, marks: Bytes }
    "crumple_instance_save_damage" SaveDamage { instance: Number }
    "crumple_instance_load_damage" LoadDamage { instance: Number, bytes: Bytes }
    "crumple_instance_repair_damage" RepairDamage { instance: Number, keep: f32 }
    "crumple_instance_reset_damage" ResetDamage { instance: Number }
    "crumple_instance_copy_damage" CopyDamage { instance: Number, source: Number }
    /// Host memory or a Vulkan buffer. A replay uses its own memory for both.
    "crumple_buffer_register_host" RegisterBuffer { instance: Number, lod: u32, vertices: u32, normals: bool, tangents: bool }
    "crumple_buffer_unregister" UnregisterBuffer { buffer: Number }
    "crumple_buffer_invalidate" InvalidateBuffer { buffer: Number }
    "crumple_buffer_set_memory" SetBufferMemory { buffer: Number, lod: u32, vertices: u32, normals: bool, tangents: bool }
    "crumple_context_deform" Deform { all: bool, buffers: Vec<Number> }
    /// Also `crumple_vulkan_submit`. The library does not read what the device writes.
    "crumple_vulkan_record" Record { all: bool, buffers: Vec<Number> }
    "crumple_instance_get_attached_frame" AttachedFrame { instance: Number, vertices: [u32; 3], weights: [f32; 3], point: [f32; 3] }
    "crumple_instance_get_info" InstanceInfo { instance: Number }
    "crumple_instance_get_contact" GetContact { instance: Number, contact_id: u64 }
    "crumple_instance_release_part" ReleasePart { instance: Number, part: u32 }
    "crumple_instance_mount_part" MountPart { instance: Number, part: Number, mounted: bool }
    "crumple_instance_set_part_rigid" SetPartRigid { instance: Number, part: u32, rigid: bool }
    "crumple_instance_measure_part" MeasurePart { instance: Number, lod: u32 }
    "crumple_instance_repair_around" RepairAround { instance: Number, point: [f32; 3], radius: f32, keep: f32 }
    "crumple_context_set_time" SetTime { time: f64 }
    "crumple_instance_save_changes" SaveChanges { instance: Number, since: u64 }
    "crumple_context_save_damage" SaveAll { instances: Vec<Number> }
    "crumple_context_load_damage" LoadAll { instances: Vec<Number>, bytes: Bytes }
    "crumple_context_set_vertex_budget" SetVertexBudget { vertices: u64 }
    /// `RegisterBuffer` and `SetBufferMemory` with wear.
    "crumple_buffer_register_host" RegisterWornBuffer { instance: Number, lod: u32, vertices: u32, normals: bool, tangents: bool }
    "crumple_buffer_set_memory" SetWornBufferMemory { buffer: Number, lod: u32, vertices: u32, normals: bool, tangents: bool }
    "crumple_instance_set_threshold" SetThreshold {
        instance: Number, number: u32, measure: u32, lod: u32, vertices: [u32; 3], weights: [f32; 3], point: [f32; 3], limit: f32,
    }
    "crumple_context_get_passed" GetPassed { capacity: u32 }
    /// `RegisterBuffer` and `SetBufferMemory` with octahedral normals or tangents.
    "crumple_buffer_register_host" RegisterPackedBuffer { instance: Number, lod: u32, vertices: u32, written: Written }
    "crumple_buffer_set_memory" SetPackedBufferMemory { buffer: Number, lod: u32, vertices: u32, written: Written }
}

/// What a buffer receives besides positions.
#[derive(Clone, Copy, PartialEq, Debug, Default, Serialize, Deserialize)]
pub(super) struct Written {
    pub(super) normals: bool,
    pub(super) tangents: bool,
    pub(super) wear: bool,
    pub(super) octahedral_normals: bool,
    pub(super) octahedral_tangents: bool,
}

impl Written {
    /// In floats.
    pub(super) fn floats([normals, tangents, wear]: [bool; 3]) -> Self {
        Self { normals, tangents, wear, ..Self::default() }
    }

    /// Whether a buffer in floats receives the same.
    pub(super) fn is_floats(&self) -> bool {
        !(self.normals && self.octahedral_normals || self.tangents && self.octahedral_tangents)
    }
}

#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
pub(super) struct ImpulseHit {
    pub(super) space: u32,
    pub(super) point: [f32; 3],
    pub(super) impulse: [f32; 3],
    pub(super) duration: f32,
    pub(super) mass: f32,
    pub(super) normal: [f32; 3],
    pub(super) striker_mass: f32,
    pub(super) striker_radius: f32,
    pub(super) striker_velocity: [f32; 3],
    pub(super) contact_id: u64,
}

#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
pub(super) struct DisplacementHit {
    pub(super) space: u32,
    pub(super) point: [f32; 3],
    pub(super) displacement: [f32; 3],
    pub(super) contact_id: u64,
}
