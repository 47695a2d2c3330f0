//! The bodies of the independent elasto-plastic solver, as committed in `assets/solver`.

use crumple::import::{MeshChoice, gltf_file};
use crumple::{ExampleData, MeshData};

/// The base mesh and the 32 examples of `panel` or `tube`.
pub fn solver(body: &str) -> (MeshData, Vec<ExampleData>) {
    let path = super::repository().join(format!("assets/solver/{body}.glb"));
    let imported = gltf_file(&path, MeshChoice::First).expect("the committed asset");
    (imported.mesh, imported.examples)
}
