//! Files: reads and writes baked sets, reads glTF and OBJ, writes glTF.

#[cfg(feature = "gltf")]
pub mod export;
pub(crate) mod format;
#[cfg(feature = "gltf")]
mod glb;
#[cfg(feature = "gltf")]
pub mod import;
