//! Any bytes as glTF: JSON, a zero byte and the binary chunk, which become a GLB file; or a file as it is.
#![no_main]

use crumple::import::{MeshChoice, Patterns, gltf_slice, gltf_solids};
use crumple::{ExampleSet, Serial, SetOptions};
use crumple_fuzz::{baked, seeds, target};

target!(
    |data| {
        let file = if data.starts_with(b"glTF") { data.to_vec() } else { seeds::glb(data) };
        if let Ok(solids) = gltf_solids(&file, None, None) {
            drop(solids);
        }
        let all = Patterns::default();
        if let Ok(body) = gltf_slice(&file, None, MeshChoice::Nodes(all.clone())) {
            let parts = body.part_meshes();
            let _ = crumple::export::deformed_glb(&file, None, MeshChoice::Nodes(all.clone()), &body.mesh.positions, None, None);
            if let Ok(mut set) = ExampleSet::build(body.mesh, body.examples, SetOptions::default(), &Serial) {
                parts.into_iter().for_each(|part| drop(set.add_lod(part, &Serial)));
                baked::load_and_use(set.save().expect("a small set"));
            }
        }
        let Ok(imported) = gltf_slice(&file, None, MeshChoice::First) else { return };
        let mesh = &imported.mesh;
        let count = mesh.positions.len() as u32;
        assert!(mesh.triangles.as_flattened().iter().all(|v| *v < count), "a triangle has a vertex of {count}");
        // A file that can be read can be written again with other vertices.
        let (normals, tangents) = (mesh.normals.as_deref(), mesh.tangents.as_deref());
        let _ = crumple::export::deformed_glb(&file, None, MeshChoice::First, &mesh.positions, normals, tangents);
        seeds::build_and_use(imported);
    },
    seeds: seeds::gltf
);
