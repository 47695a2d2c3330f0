//! The tests that both graphics backends pass. `tests/vulkan` and `tests/wgpu` include this folder. Each has a module `backend`
//! with the same items: `Gpu`, a device with the library on it; `Buffer` and `Target`; `on_each_device`; and the formats.

pub mod compare;
pub mod encode;
pub mod engine;
pub mod frames;
pub mod layout;
pub mod refusals;
pub mod scene;
pub mod vertices;

use std::sync::Arc;

use crumple::{ExampleSet, Instance};

use crate::scenes;

/// Limits below a device's own, and a workgroup size.
#[derive(Debug, Clone, Copy)]
pub struct Lowered {
    /// Workgroups in a row.
    pub workgroups: Option<u32>,
    /// Bytes of a storage buffer's binding.
    pub binding_bytes: Option<u64>,
    pub workgroup_size: u32,
}

impl Default for Lowered {
    fn default() -> Self {
        Lowered { workgroups: None, binding_bytes: None, workgroup_size: 128 }
    }
}

/// An instance with hits.
pub fn folded(set: &Arc<ExampleSet>, hits: usize, seed: u64) -> Instance {
    let mut instance = Instance::new(set.clone(), Default::default()).unwrap();
    hit(&mut instance, hits, seed);
    instance
}

pub fn hit(instance: &mut Instance, hits: usize, seed: u64) {
    for hit in scenes::random_hits(&instance.example_set().clone(), hits, seed) {
        instance.submit(&hit).unwrap();
    }
    instance.fold();
}
