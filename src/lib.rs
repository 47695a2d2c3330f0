//! Example-based dents: an engine hands over a mesh and a few example deformations, reports
//! impulses, and gets deformed vertices.
#![deny(missing_docs)]

mod data;
mod error;
#[cfg(feature = "gltf")]
pub mod export;
#[cfg(any(feature = "gltf", feature = "obj"))]
pub mod import;

pub use data::{Contact, Deltas, ExampleData, MeshData, Placement};
pub use error::{Error, ErrorKind};
