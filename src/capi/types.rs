//! Values that several calls share.

use super::c_enum::c_enums;
use super::check::{enumerator, finite, positive_or};
use super::result::Failure;
use crate::base::math::Aabb;
use crate::contacts::options::Impulses;
use crate::deform::Encoding;
use crate::example::blow::{Striker, StrikerShape};
use crate::select::hit::{HitStatus, Selection, Space};
use bytemuck::{Pod, Zeroable};
use std::ffi::c_void;
use std::mem::MaybeUninit;

c_enums!(
    CrumpleDirectionFormat::Octahedral,
    CrumpleRule::Blend,
    HitStatus::Rigid,
    Impulses::ZeroIsUnknown,
    Selection::ClassicUnclamped,
    Space::World,
    StrikerShape::Wall,
);

/// A point or a vector.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub struct CrumpleVec3 {
    pub x: f32,
    pub y: f32,
    pub z: f32,
}

impl CrumpleVec3 {
    pub(super) fn array(self) -> [f32; 3] {
        [self.x, self.y, self.z]
    }

    /// The vector, unless it is zero, which stands for unknown.
    pub(super) fn known(self) -> Option<[f32; 3]> {
        (self != Self::default()).then_some(self.array())
    }
}

impl From<[f32; 3]> for CrumpleVec3 {
    fn from([x, y, z]: [f32; 3]) -> Self {
        Self { x, y, z }
    }
}

impl From<glam::Vec3> for CrumpleVec3 {
    fn from(v: glam::Vec3) -> Self {
        v.to_array().into()
    }
}

/// What struck a body, as far as it is known. 0 is unknown, which costs accuracy.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleStriker {
    /// Mass, kg; against a body that is free to move, the reduced mass m1 m2 / (m1 + m2).
    pub mass: f32,
    /// Radius of its surface at the contact, m: small for a corner, large for a flat face.
    pub radius: f32,
    /// Its velocity relative to the struck body before they touch, m/s.
    pub velocity: CrumpleVec3,
    pub shape: MaybeUninit<StrikerShape>,
    pub reserved: [u32; 2],
}

impl CrumpleStriker {
    /// The striker, of which zeros are unknown. `name` is the argument's.
    pub(super) fn read(self, name: &str) -> Result<Striker, Failure> {
        let field = |field: &str| format!("{name}.{field}");
        finite(self.velocity.array(), &field("velocity"))?;
        Ok(Striker {
            mass: positive_or(self.mass, &field("mass"), "kg", "an unknown one")?,
            radius: positive_or(self.radius, &field("radius"), "m", "an unknown one")?,
            velocity: self.velocity.known(),
            shape: enumerator(self.shape, &field("shape"))?,
        })
    }
}

/// An axis-aligned box, m.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub struct CrumpleAabb {
    pub min: CrumpleVec3,
    pub max: CrumpleVec3,
}

impl From<Aabb> for CrumpleAabb {
    fn from(bounds: Aabb) -> Self {
        Self { min: bounds.min.into(), max: bounds.max.into() }
    }
}

/// A range of vertices or triangles.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
pub struct CrumpleRange {
    pub first: u32,
    pub count: u32,
}

/// An array that Crumple writes. Element i is at data + offset + i * stride. Positions and normals are 3 floats,
/// tangents 4 floats, indices one uint32_t, unless the def has another format. Bytes between elements are not touched, so
/// streams may be interleaved. All fields zero: absent.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleStream {
    /// Start of the memory, aligned to 4 bytes. Null: absent.
    pub data: *mut c_void,
    /// Writable bytes at data: at least offset + (count - 1) * stride + the size of one element.
    pub size: usize,
    /// Bytes from data to the first element, a multiple of 4.
    pub offset: usize,
    /// Bytes from one element to the next: at least the size of one element, a multiple of 4. 0 is an error.
    pub stride: usize,
}

/// A base mesh with its examples: immutable, shared by any number of instances. An id; zero is null.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
pub struct CrumpleExampleSet {
    pub index: u32,
    pub generation: u16,
    pub context: u16,
}

/// A body in the scene: an example set, a transform and the damage. An id; zero is null.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
pub struct CrumpleInstance {
    pub index: u32,
    pub generation: u16,
    pub context: u16,
}

/// Registered memory of yours that receives an instance's deformed vertices. An id; zero is null.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
pub struct CrumpleBuffer {
    pub index: u32,
    pub generation: u16,
    pub context: u16,
}

/// The format of normals or tangents in memory of the CPU.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(dead_code)] // made by C
pub enum CrumpleDirectionFormat {
    /// 3 floats for a normal, 4 for a tangent. The default.
    Float = 0,
    /// Octahedral as in Godot: two uint16_t, 4 bytes in all, with the bits of a Vulkan buffer's R16G16_UNORM.
    /// docs/integration.md has the formula.
    Octahedral = 1,
}

impl From<CrumpleDirectionFormat> for Encoding {
    fn from(format: CrumpleDirectionFormat) -> Self {
        match format {
            CrumpleDirectionFormat::Float => Self::F32,
            CrumpleDirectionFormat::Octahedral => Self::Octahedral16x2,
        }
    }
}

/// How hits damage an instance.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(dead_code)] // made by C
pub enum CrumpleRule {
    /// Each hit leaves a mark. The number of marks is bounded and the order of hits does not matter. The default.
    Marks = 0,
    /// The classic rule "most displaced" of the paper, for comparison. The order of hits matters. The instance has
    /// no marks and needs memory for each vertex, and a set with whole examples: one that was made here, or baked with
    /// CrumpleExampleSetOptions::whole_examples.
    MostDisplaced = 1,
    /// The classic rule "blend", which uses blend_constant. Otherwise like CRUMPLE_RULE_MOST_DISPLACED.
    Blend = 2,
}
