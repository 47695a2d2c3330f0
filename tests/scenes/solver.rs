//! The bodies of the independent elasto-plastic solver, as committed in `assets/solver`.

use std::path::Path;

use crumple::import::{MeshChoice, gltf_file};
use crumple::{ExampleData, MeshData};

/// The base mesh and the 32 examples of `panel` or `tube`.
pub fn solver(body: &str) -> (MeshData, Vec<ExampleData>) {
    let path = repository().join(format!("assets/solver/{body}.glb"));
    let imported = gltf_file(&path, MeshChoice::First).expect("the committed asset");
    (imported.mesh, imported.examples)
}

/// The repository's root. The lab's tests read its files too.
pub fn repository() -> &'static Path {
    let mut folders = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    folders.find(|folder| folder.join("assets/solver").is_dir()).expect("a folder around the package")
}
