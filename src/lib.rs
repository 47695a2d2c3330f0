//! Example-based dents: an engine hands over a mesh and a few example deformations, reports impulses, and gets deformed
//! vertices.
//!
//! The pipeline, in the order a user meets it:
//!
//! 1. [`ExampleSet::build`]: a base mesh and its examples (the same mesh after a collision), from plain arrays
//!    ([`MeshData`], [`ExampleData`]) or from files ([`import`]).
//! 2. [`Instance::new`]: one dented copy. Instances share the set.
//! 3. [`Instance::submit`]: a hit as the physics reports it. Examples are chosen and the hit becomes a [`Mark`]. Any
//!    thread may submit ([`Inbox`]). Parts of one contact share an id ([`Hit::contact`]).
//! 4. [`Instance::deform`]: marks become positions, normals and tangents in the caller's memory ([`VertexMemory`]), only
//!    where something changed ([`Tracker`]).
//!
//! The work of step 1 needs doing only once: [`ExampleSet::save`] is a file from which [`ExampleSet::load`] has the same set at once, with the
//! arrays where they lie in it.
//!
//! Damage is the short list of marks: read it, save it, send it, repair it. Vertices are a pure function of it.
//!
//! # Features
//! `gltf` and `obj` (default) read those formats; `vulkan` (default) records deformation into the host's command buffers; `wgpu` deforms on `wgpu` devices; `cli` builds the `crumple` command; `capi` exports the C functions; `host-allocator`
//! lets a C host provide memory.
#![deny(missing_docs)]

mod anchored;
mod array;
mod attach;
#[cfg(feature = "capi")]
mod capi;
mod classic;
mod contacts;
mod damage;
mod data;
mod deform;
mod dent;
mod error;
mod examples;
#[cfg(feature = "gltf")]
pub mod export;
mod few;
mod format;
#[cfg(feature = "gpu")]
mod gpu;
mod images;
#[cfg(any(feature = "gltf", feature = "obj"))]
pub mod import;
mod instance;
mod learn;
mod lod;
mod math;
mod mesh;
mod mirror;
mod nearest;
mod normals;
mod reorder;
mod rim;
mod select;
mod simd;
mod skin;
mod stamp;
mod tasks;
mod tolerance;
#[cfg(feature = "vulkan")]
pub mod vulkan;
mod weights;
#[cfg(feature = "wgpu")]
pub mod wgpu;

pub use attach::{Attachment, Frame};
#[cfg(feature = "capi")]
pub use capi::replay::{Difference, Replay, replay};
pub use damage::{Mark, Pair};
pub use data::{Contact, Deltas, ExampleData, MeshData, Placement};
pub use deform::{Attribute, DeformJob, DeformReport, RawStream, Tracker, VertexMemory, deform};
pub use error::{Error, ErrorKind};
pub use examples::{Combine, Example, ExampleSet, Seams, SetOptions, SetReport, VertexMass};
#[doc(hidden)]
pub use format::file_checksum;
pub use glam;
pub use instance::{Inbox, Instance, InstanceOptions, Rule};
pub use learn::Learned;
pub use lod::LodReport;
pub use math::Aabb;
pub use mesh::Mesh;
pub use mirror::Mirror;
pub use nearest::Nearest;
pub use reorder::reorder;
pub use select::{Cause, Chosen, Hit, HitStatus, Outcome, Selection, Space};
pub use simd::SimdLevel;
pub use stamp::{Stamp, StampError, StampSample};
pub use tasks::{Serial, TaskSystem, ThreadPool};
pub use tolerance::pixel_tolerance;
