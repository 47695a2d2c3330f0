//! What bodies show, in memory of the CPU. The fuzz target of scenes reads it too.

use crumple::glam::Vec3;
use crumple::{
    DeformJob, DeformReport, ExampleSet, Instance, Serial, TaskSystem, ThreadPool, Tracker, VertexMemory, deform,
};

/// Threads that share even the little work that a [`ThreadPool`] leaves to its caller.
pub struct Eager(pub ThreadPool);

impl TaskSystem for Eager {
    fn parallel_for(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
        self.0.parallel_for(count, task);
    }

    fn workers(&self) -> usize {
        self.0.workers()
    }
}

/// Memory for all attributes of the mesh or of a level of detail, and its tracker.
#[derive(Debug, Clone)]
pub struct Output {
    pub lod: usize,
    pub positions: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
    pub tangents: Vec<[f32; 4]>,
    pub tracker: Tracker,
    has_normals: bool,
    has_tangents: bool,
}

/// A value that no deform writes.
pub const POISON: f32 = -1.234e33;

impl Output {
    pub fn new(set: &ExampleSet) -> Self {
        Self::level(set, 0)
    }

    pub fn level(set: &ExampleSet, lod: usize) -> Self {
        let mesh = set.lod_mesh(lod).unwrap();
        let count = mesh.positions().len();
        Self {
            lod,
            positions: vec![[POISON; 3]; count],
            normals: vec![[POISON; 3]; count],
            tangents: vec![[POISON; 4]; count],
            tracker: Tracker::new(),
            has_normals: mesh.normals().is_some(),
            has_tangents: mesh.tangents().is_some(),
        }
    }

    pub fn memory(&mut self) -> (&mut Tracker, VertexMemory<'_>) {
        let normals = self.has_normals.then_some(self.normals.as_mut_slice());
        let tangents = self.has_tangents.then_some(self.tangents.as_mut_slice());
        let memory = VertexMemory::separate(&mut self.positions, normals, tangents).unwrap();
        (&mut self.tracker, memory)
    }

    pub fn update_with(&mut self, instance: &mut Instance, tasks: &dyn TaskSystem) -> DeformReport {
        instance.fold();
        let lod = self.lod;
        let (tracker, memory) = self.memory();
        deform(&mut [DeformJob { lod, instance, tracker, memory }], tasks).unwrap()
    }

    pub fn update(&mut self, instance: &mut Instance) -> DeformReport {
        self.update_with(instance, &Serial)
    }

    /// A full evaluation of the instance into new memory.
    pub fn fresh(instance: &mut Instance) -> Self {
        Self::fresh_level(instance, 0)
    }

    pub fn fresh_level(instance: &mut Instance, lod: usize) -> Self {
        let mut output = Self::level(&instance.example_set().clone(), lod);
        output.update(instance);
        output
    }

    pub fn poison(&mut self) {
        self.positions.fill([POISON; 3]);
        self.normals.fill([POISON; 3]);
        self.tangents.fill([POISON; 4]);
    }

    /// All floats of vertex `v`, as bits.
    pub fn bits(&self, v: usize) -> [u32; 10] {
        let (p, n, t) = (self.positions[v], self.normals[v], self.tangents[v]);
        [p[0], p[1], p[2], n[0], n[1], n[2], t[0], t[1], t[2], t[3]].map(f32::to_bits)
    }

    pub fn position_bits(&self) -> Vec<[u32; 3]> {
        self.positions.iter().map(|p| p.map(f32::to_bits)).collect()
    }

    pub fn all_bits(&self) -> Vec<[u32; 10]> {
        (0..self.positions.len()).map(|v| self.bits(v)).collect()
    }
}

/// Deforms positions alone into new memory.
pub fn positions(instance: &mut Instance) -> (Vec<[f32; 3]>, DeformReport) {
    positions_with(instance, &Serial)
}

pub fn positions_with(instance: &mut Instance, tasks: &dyn TaskSystem) -> (Vec<[f32; 3]>, DeformReport) {
    let mut out = vec![[0.0; 3]; instance.example_set().vertex_count()];
    let memory = VertexMemory::separate(&mut out, None, None).unwrap();
    let report = instance.deform(&mut Tracker::new(), memory, tasks).unwrap();
    (out, report)
}

/// How far each vertex has moved, m.
pub fn displacements(instance: &mut Instance) -> Vec<Vec3> {
    let set = instance.example_set().clone();
    let base = set.mesh().positions();
    positions(instance).0.iter().zip(base).map(|(p, b)| Vec3::from_array(*p) - *b).collect()
}
