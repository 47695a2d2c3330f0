//! Example-based dents: an engine hands over a mesh and a few example deformations, reports impulses, and gets deformed
//! vertices.
//!
//! The pipeline, in the order a user meets it:
//!
//! 1. [`ExampleSet::build`] makes an example set from a base mesh and its examples (the same mesh after a collision).
//!    They come from plain arrays ([`MeshData`], [`ExampleData`]) or from files ([`import`]).
//! 2. [`Instance::new`] makes one dented copy. Instances share the set.
//! 3. [`Instance::submit`] takes a hit as the physics reports it, predicts its dent and stores a [`Mark`]. Any thread
//!    may submit through an [`Inbox`]. Parts of one contact share an id ([`Hit::contact`]).
//! 4. [`Instance::deform`] writes positions, normals and tangents to the caller's memory ([`VertexMemory`]). It writes
//!    only what changed ([`Tracker`]).
//!
//! Step 1 is needed only once. [`ExampleSet::save`] writes the set to a file, and [`ExampleSet::load`] uses the file's
//! arrays in place, without a copy.
//!
//! Damage is a short list of marks that can be read, saved, sent and repaired. Vertices are a pure function of it.
//!
//! # Features
//! - `gltf` and `obj` (default) read those formats.
//! - `vulkan` (default) records deformation into the host's command buffers.
//! - `wgpu` deforms on `wgpu` devices.
//! - `cli` builds the `crumple` command.
//! - `capi` exports the C functions.
//! - `host-allocator` lets a C host provide memory.
#![cfg_attr(not(fuzzing), deny(missing_docs))]
#![deny(unsafe_code)]

#[cfg(target_endian = "big")]
compile_error!("Crumple supports little-endian processors only: its files and packed numbers are little-endian");

mod bake;
#[allow(unsafe_code)]
mod base;
mod basis;
#[cfg(feature = "capi")]
#[allow(unsafe_code)]
mod capi;
mod classic;
mod contacts;
mod damage;
#[allow(unsafe_code)]
mod deform;
mod example;
#[cfg(feature = "gpu")]
mod gpu;
#[cfg(feature = "vulkan")]
pub mod graph;
mod instance;
mod io;
mod mesh;
mod predict;
mod select;
#[cfg(feature = "vulkan")]
#[allow(unsafe_code)]
pub mod vulkan;
#[cfg(feature = "wgpu")]
#[allow(unsafe_code)]
pub mod wgpu;

pub use bake::reorder::reorder;
pub use base::error::{Error, ErrorKind};
pub use base::math::Aabb;
pub use base::simd::SimdLevel;
pub use base::tasks::{Serial, TaskSystem, ThreadPool};
pub use basis::learn::{BasisOptions, BasisReport};
#[cfg(all(fuzzing, feature = "capi"))]
#[doc(hidden)]
pub use capi::entry_points;
pub use contacts::ContactLayer;
pub use contacts::options::{ContactOptions, Impulses};
pub use contacts::point::ContactPoint;
pub use contacts::report::{ContactHit, ContactReport};
pub use damage::mark::Mark;
pub use deform::{Attribute, DeformReport, Encoding, RawStream, Tracker, VertexMemory};
pub use example::blow::{Blow, Striker, StrikerShape};
pub use example::data::{Contact, Deltas, ExampleData};
pub use example::example::Example;
pub use example::options::{SetOptions, VertexMass};
pub use example::report::{LodReport, SetReport};
pub use example::set::ExampleSet;
pub use glam;
pub use instance::Instance;
pub use instance::archive::{load_all, save_all};
pub use instance::attach::{Attachment, Pose};
pub use instance::deform::{DeformJob, deform, deform_within, fold_all};
pub use instance::inbox::Inbox;
pub use instance::mapped::{Mapping, map_damage};
pub use instance::parts::PartDamage;
#[cfg(feature = "gltf")]
pub use io::export;
#[doc(hidden)]
pub use io::format::file_checksum;
#[cfg(feature = "gltf")]
pub use io::import;
pub use mesh::Mesh;
pub use mesh::data::MeshData;
pub use mesh::keep_out::{KeepOutReport, Solid};
pub use mesh::mirror::Mirror;
pub use mesh::nearest::Nearest;
pub use select::hit::{Cause, Chosen, Hit, HitStatus, Outcome, Selection, Space};
pub use select::options::{InstanceOptions, Rule};
