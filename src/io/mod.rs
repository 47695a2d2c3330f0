//! Files: baked sets, glTF and OBJ in, glTF out.

#[cfg(feature = "gltf")]
pub mod export;
pub(crate) mod format;
#[cfg(any(feature = "gltf", feature = "obj"))]
pub mod import;
