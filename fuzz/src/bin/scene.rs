//! Random scenes: every SIMD level and number of threads gives the same bits, as does an update after each frame, and the
//! oracle of the tests agrees within rounding.
#![no_main]

use std::sync::{Arc, OnceLock};

use arbitrary::Unstructured;
use crumple::{
    Combine, Contact, Deltas, ExampleData, ExampleSet, Hit, Instance, InstanceOptions, MeshData, Placement, Seams,
    Serial, SetOptions, SimdLevel, TaskSystem, ThreadPool, Tracker, VertexMemory,
};
use crumple_fuzz::{seeds, target};
use oracle::vector::{add, from_f32, length, sub};
use oracle::{Model, marks};

#[path = "../../../tests/oracle/mod.rs"]
mod oracle;

target!(
    |data| {
        // Bytes that end early are a smaller scene.
        let _ = run(&mut Unstructured::new(data));
    },
    seeds: seeds::noise
);

/// Threads that take even the little work that a [`ThreadPool`] would leave to its caller.
struct Eager(ThreadPool);

impl TaskSystem for Eager {
    fn parallel_for(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
        self.0.parallel_for(count, task);
    }

    fn workers(&self) -> usize {
        self.0.workers()
    }
}

/// A number from `low` to `high`.
fn between(bytes: &mut Unstructured<'_>, low: f32, high: f32) -> arbitrary::Result<f32> {
    Ok(low + (high - low) * f32::from(bytes.arbitrary::<u16>()?) / 65535.0)
}

fn vector(bytes: &mut Unstructured<'_>, size: f32) -> arbitrary::Result<[f32; 3]> {
    Ok([between(bytes, -size, size)?, between(bytes, -size, size)?, between(bytes, -size, size)?])
}

/// A bent sheet with a seam, in a unit of 1 mm to 1 km.
fn mesh(bytes: &mut Unstructured<'_>, unit: f32) -> arbitrary::Result<MeshData> {
    let mut mesh = seeds::sheet([2, 6, 12, 16][bytes.choose_index(4)?]);
    let (along, across) = (between(bytes, -1.0, 1.0)?, between(bytes, -1.0, 1.0)?);
    for p in &mut mesh.positions {
        p[2] = along * p[0] * p[0] + across * p[0] * p[1];
        *p = p.map(|x| x * unit);
    }
    if bytes.ratio(1, 2)? {
        mesh.normals = Some(vec![[0.0, 0.0, 1.0]; mesh.positions.len()]);
    }
    Ok(mesh)
}

fn example(bytes: &mut Unstructured<'_>, mesh: &MeshData, unit: f32) -> arbitrary::Result<ExampleData> {
    let contact = bytes.choose_index(mesh.positions.len())?;
    let (centre, radius) = (mesh.positions[contact], unit * between(bytes, 0.05, 0.6)?);
    let push = vector(bytes, 0.2 * unit)?;
    let mut field: Vec<[f32; 3]> = Vec::new();
    for p in &mesh.positions {
        let d = [0, 1, 2].map(|k| (p[k] - centre[k]) / radius);
        let w = (1.0 - d.iter().map(|x| x * x).sum::<f32>()).max(0.0);
        field.push(push.map(|x| x * w * w));
    }
    let mut example = ExampleData::new("dent", Deltas::Full(field));
    example.placement = [Placement::Automatic, Placement::Anchored, Placement::Carried][bytes.choose_index(3)?];
    example.contact = bytes.ratio(1, 2)?.then_some(Contact::Vertex(contact as u32));
    Ok(example)
}

fn run(bytes: &mut Unstructured<'_>) -> arbitrary::Result<()> {
    let unit = [1.0, 1e-3, 1e3, 0.1][bytes.choose_index(4)?];
    let mesh = mesh(bytes, unit)?;
    let count = bytes.int_in_range(1..=6)?;
    let examples = (0..count).map(|_| example(bytes, &mesh, unit)).collect::<Result<Vec<_>, _>>()?;
    let combine = [Combine::Energies, Combine::Sum, Combine::Deepest][bytes.choose_index(3)?];
    let options = SetOptions {
        combine,
        seams: if bytes.arbitrary()? { Seams::Weld } else { Seams::Keep },
        strict: bytes.ratio(1, 4)?,
        mirror: bytes.arbitrary()?,
        held_rims: bytes.arbitrary()?,
        stamp_resolution: bytes.int_in_range(4..=24)?,
        tolerance: if bytes.arbitrary()? { Some(unit * [1e-6, 1e-4, 1e-2][bytes.choose_index(3)?]) } else { None },
        depth_limit: if bytes.arbitrary()? { Some(unit * between(bytes, 0.001, 0.5)?) } else { None },
        ..SetOptions::default()
    };
    let Ok(set) = ExampleSet::build(mesh, examples, options, &Serial) else { return Ok(()) };
    let set = Arc::new(set);
    let capacity = bytes.int_in_range(1..=16)?;
    let mut body =
        Instance::new(set.clone(), InstanceOptions { capacity, ..InstanceOptions::default() }).expect("options");
    let mut updated = Output::new(&set);
    for _ in 0..bytes.int_in_range(1..=3)? {
        for _ in 0..bytes.int_in_range(0..=6)? {
            let at = set.mesh().positions()[bytes.choose_index(set.vertex_count())?].to_array();
            let jitter = vector(bytes, 0.01 * unit)?;
            let hit = Hit::displacement([0, 1, 2].map(|k| at[k] + jitter[k]), vector(bytes, 0.3 * unit)?);
            body.submit(&hit).expect("a hit near the surface");
        }
        if bytes.ratio(1, 8)? {
            body.repair(between(bytes, 0.0, 1.0)?).expect("a share");
        }
        updated.update(&mut body, &Serial);
    }
    compare(&set, &mut body, &updated);
    Ok(())
}

fn compare(set: &ExampleSet, body: &mut Instance, updated: &Output) {
    static THREADS: OnceLock<Eager> = OnceLock::new();
    let threads = THREADS.get_or_init(|| Eager(ThreadPool::new(3).expect("three threads")));
    let best = SimdLevel::best();
    for level in SimdLevel::available() {
        level.force().expect("an available level");
        for tasks in [&Serial as &dyn TaskSystem, threads] {
            let mut fresh = Output::new(set);
            fresh.update(body, tasks);
            assert!(fresh.bits() == updated.bits(), "{level:?} with {} threads gives other bits", tasks.workers());
        }
    }
    best.force().expect("the best level");
    let (model, combine) = (Model::of(set), set.options().combine);
    // The oracle knows displacements as they are stored. With a tolerance they differ from those that the set learned from,
    // and rounding may decide whether a rim is held.
    if set.options().tolerance.is_some() || model.close || model.held.len() != set.report().held_vertices {
        return;
    }
    let list = marks::marks_of(&model, body.marks().expect("marks"), combine);
    let scaled = marks::scaled(&model, &list);
    let size = scaled.iter().map(|mark| marks::size(&model, mark).0).sum();
    let limit = marks::Limit { depth: f64::from(set.depth_limit()), give: 1.0 };
    for (v, position) in updated.positions.iter().enumerate() {
        if list.iter().any(|mark| marks::on_a_border(&model, mark, v)) {
            continue;
        }
        let (moved, _) = marks::displacement(&model, &scaled, v, combine, limit);
        let ought = add(model.positions[v], moved);
        let off = length(sub(from_f32(*position), ought));
        let allowed = marks::rounding(ought, size);
        let (options, marks) = (set.options(), body.marks().expect("marks"));
        assert!(
            off <= allowed,
            "vertex {v} at {position:?} is {off:e} m from {ought:?}; {allowed:e} is allowed: {marks:?}, {options:?}"
        );
    }
}

/// Memory for positions, normals and wear.
struct Output {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    wear: Vec<[f32; 4]>,
    tracker: Tracker,
}

impl Output {
    fn new(set: &ExampleSet) -> Self {
        let n = set.vertex_count();
        let normals = vec![[0.0; 3]; if set.mesh().normals().is_some() { n } else { 0 }];
        Self { positions: vec![[0.0; 3]; n], normals, wear: vec![[0.0; 4]; n], tracker: Tracker::new() }
    }

    fn update(&mut self, body: &mut Instance, tasks: &dyn TaskSystem) {
        let normals = (!self.normals.is_empty()).then_some(self.normals.as_mut_slice());
        let memory = VertexMemory::separate(&mut self.positions, normals, None).expect("separate arrays");
        body.deform(&mut self.tracker, memory.with_wear(&mut self.wear), tasks).expect("arrays of the set's length");
    }

    fn bits(&self) -> Vec<u32> {
        let vectors = [&self.positions, &self.normals].into_iter().flat_map(|list| list.as_flattened());
        vectors.chain(self.wear.as_flattened()).map(|x| x.to_bits()).collect()
    }
}
