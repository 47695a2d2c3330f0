//! Deformed meshes into glTF.
