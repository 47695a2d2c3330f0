//! Bodies, examples and hits that the tests share. Lengths in metres.
#![allow(dead_code)]

mod output;

pub use output::*;

use std::collections::HashMap;
use std::path::Path;
use std::sync::{Arc, OnceLock};

use proptest::prelude::{ProptestConfig, TestCaseError, prop_assert, prop_assert_eq};
use proptest::test_runner::RngSeed;

use crumple::glam::Vec3;
use crumple::import::{Imported, MeshChoice, gltf_file};
use crumple::{
    BasisOptions, Blow, Cause, Contact, Deltas, Example, ExampleData, ExampleSet, Hit, Instance, InstanceOptions,
    MeshData, Serial, SetOptions, Space, Striker, StrikerShape,
};

/// The repository's root. The lab's tests read its files too.
pub fn repository() -> &'static Path {
    let mut folders = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    folders.find(|folder| folder.join("assets/solver").is_dir()).expect("a folder around the package")
}

/// Number of random cases of a property: `count` in a test run, `CRUMPLE_SOAK` times as many in a soak run. A failure
/// prints its seed, which repeats the case. No regression files are written.
pub fn cases(count: u32) -> ProptestConfig {
    let soak = std::env::var("CRUMPLE_SOAK").ok().and_then(|s| s.parse().ok()).unwrap_or(1);
    // Test runs always have the same cases, so that a failure points at the last change. Soak runs have new ones.
    let rng_seed = if soak == 1 { RngSeed::Fixed(0x00C0_FFEE) } else { RngSeed::Random };
    let quiet = ProptestConfig { max_shrink_iters: 24, failure_persistence: None, ..ProptestConfig::default() };
    ProptestConfig { cases: count * soak, rng_seed, ..quiet }
}

/// A small generator (SplitMix64). A seed gives the same numbers on every platform.
#[derive(Debug, Clone)]
pub struct Dice(u64);

impl Dice {
    pub fn new(seed: u64) -> Self {
        Self(seed ^ 0x5DEE_CE66_D1CE_4E5B)
    }

    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A random index below `n`.
    pub fn index(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    /// A random number in [0, 1), a multiple of 2^-24 and so exact in f32.
    pub fn unit(&mut self) -> f32 {
        (self.next() >> 40) as f32 / 16_777_216.0
    }

    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    pub fn vector(&mut self, size: f32) -> [f32; 3] {
        [self.between(-size, size), self.between(-size, size), self.between(-size, size)]
    }

    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.index(i + 1));
        }
    }
}

fn sub(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn length(a: [f32; 3]) -> f32 {
    dot(a, a).sqrt()
}

/// A flat sheet of 1 m by 1 m in the plane z = 0, facing +z, with `n` by `n` squares.
pub fn sheet(n: usize) -> MeshData {
    let place = |i: usize| i as f32 / n as f32 - 0.5;
    let count = (n + 1) * (n + 1);
    let positions = (0..count).map(|k| [place(k / (n + 1)), place(k % (n + 1)), 0.0]).collect();
    let at = |i: usize, j: usize| (i * (n + 1) + j) as u32;
    // In optimised code valgrind takes `flat_map` over arrays for a use of values that nobody wrote.
    let mut triangles = Vec::new();
    for (i, j) in (0..n * n).map(|k| (k / n, k % n)) {
        triangles.extend([[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]);
    }
    MeshData {
        positions,
        normals: Some(vec![[0.0, 0.0, 1.0]; count]),
        tangents: Some(vec![[1.0, 0.0, 0.0, 1.0]; count]),
        triangles,
        ..MeshData::default()
    }
}

/// A closed sphere of radius 0.5 m: an icosahedron split `splits` times.
pub fn ball(splits: usize) -> MeshData {
    let g = (1.0 + 5f32.sqrt()) / 2.0;
    #[rustfmt::skip]
    let mut points: Vec<[f32; 3]> = vec![
        [-1.0, g, 0.0], [1.0, g, 0.0], [-1.0, -g, 0.0], [1.0, -g, 0.0], [0.0, -1.0, g], [0.0, 1.0, g],
        [0.0, -1.0, -g], [0.0, 1.0, -g], [g, 0.0, -1.0], [g, 0.0, 1.0], [-g, 0.0, -1.0], [-g, 0.0, 1.0],
    ];
    #[rustfmt::skip]
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4], [11, 10, 2], [10, 7, 6], [7, 1, 8],
        [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9], [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1],
    ];
    let unit = |p: [f32; 3]| {
        let l = length(p);
        [p[0] / l, p[1] / l, p[2] / l]
    };
    points.iter_mut().for_each(|p| *p = unit(*p));
    for _ in 0..splits {
        let mut middle: HashMap<(u32, u32), u32> = HashMap::new();
        let mut split = Vec::with_capacity(triangles.len() * 4);
        for [a, b, c] in triangles {
            let mut mid = |a: u32, b: u32| {
                *middle.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    let (p, q) = (points[a as usize], points[b as usize]);
                    points.push(unit([p[0] + q[0], p[1] + q[1], p[2] + q[2]]));
                    points.len() as u32 - 1
                })
            };
            let (ab, bc, ca) = (mid(a, b), mid(b, c), mid(c, a));
            split.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        triangles = split;
    }
    MeshData {
        normals: Some(points.clone()),
        positions: points.iter().map(|p| [0.5 * p[0], 0.5 * p[1], 0.5 * p[2]]).collect(),
        tangents: None,
        triangles,
        ..MeshData::default()
    }
}

/// A cube of side 1 m with hard edges (each face has its own vertices) and one UV seam: the vertices of the first
/// face's middle column exist twice, with the same normal and different tangents. `n` is the number of squares along an
/// edge and must be even.
pub fn cube(n: usize) -> MeshData {
    assert!(n.is_multiple_of(2));
    let side = sheet(n);
    let mut mesh = MeshData { normals: Some(Vec::new()), tangents: Some(Vec::new()), ..MeshData::default() };
    for face in 0..6 {
        let (axis, sign) = (face / 2, if face % 2 == 0 { 1.0f32 } else { -1.0 });
        // u x v = normal, so that the grid's triangles face outwards
        let (u, v) = if sign > 0.0 { ((axis + 1) % 3, (axis + 2) % 3) } else { ((axis + 2) % 3, (axis + 1) % 3) };
        let (mut normal, mut tangent) = ([0.0; 3], [0.0, 0.0, 0.0, 1.0]);
        (normal[axis], tangent[u]) = (sign, 1.0);
        let first = mesh.positions.len() as u32;
        mesh.triangles.extend(side.triangles.iter().map(|t| t.map(|v| first + v)));
        mesh.normals.as_mut().unwrap().extend(side.positions.iter().map(|_| normal));
        mesh.tangents.as_mut().unwrap().extend(side.positions.iter().map(|_| tangent));
        mesh.positions.extend(side.positions.iter().map(|[x, y, _]| {
            let mut p = [0.0; 3];
            (p[axis], p[u], p[v]) = (0.5 * sign, *x, *y);
            p
        }));
    }
    let column = n / 2;
    let first = mesh.positions.len() as u32;
    for j in 0..=n {
        let old = column * (n + 1) + j;
        mesh.positions.push(mesh.positions[old]);
        let normal = mesh.normals.as_ref().unwrap()[old];
        mesh.normals.as_mut().unwrap().push(normal);
        let t = mesh.tangents.as_ref().unwrap()[old];
        mesh.tangents.as_mut().unwrap().push([-t[0], -t[1], -t[2], -1.0]);
    }
    let face = (n + 1) * (n + 1);
    for triangle in &mut mesh.triangles[..2 * n * n] {
        let right = triangle.iter().any(|&v| (v as usize) < face && v as usize / (n + 1) > column);
        if right {
            for v in triangle.iter_mut() {
                if *v as usize / (n + 1) == column {
                    *v = first + (*v % (n as u32 + 1));
                }
            }
        }
    }
    mesh
}

/// The vertex nearest to `point`.
pub fn nearest(mesh: &MeshData, point: [f32; 3]) -> u32 {
    let away = |v: &u32| length(sub(mesh.positions[*v as usize], point));
    (0..mesh.positions.len() as u32).min_by(|a, b| away(a).total_cmp(&away(b))).unwrap()
}

/// Normals of the surface at deformed vertices, with twice the area of their triangles as their length.
pub fn area_normals(set: &ExampleSet, positions: &[[f32; 3]]) -> Vec<Vec3> {
    let mut sums = vec![Vec3::ZERO; set.vertex_count()];
    for t in set.mesh().triangles() {
        let p = t.map(|v| Vec3::from_array(positions[v as usize]));
        let n = (p[1] - p[0]).cross(p[2] - p[0]);
        t.iter().for_each(|v| sums[*v as usize] += n);
    }
    sums
}

/// Groups of vertices with bit-identical positions.
pub fn coincident(positions: &[[f32; 3]]) -> Vec<Vec<usize>> {
    let mut groups: HashMap<[u32; 3], Vec<usize>> = HashMap::new();
    for (v, p) in positions.iter().enumerate() {
        groups.entry(p.map(|x| (x + 0.0).to_bits())).or_default().push(v);
    }
    let mut groups: Vec<_> = groups.into_values().filter(|g| g.len() > 1).collect();
    groups.sort();
    groups
}

/// A smooth bowl of `depth` at vertex `contact`, pushed in against the normal there. It pulls the surface towards the
/// contact and ends at `radius`. It depends on position only, so that coincident vertices move together.
pub fn bowl(mesh: &MeshData, contact: u32, depth: f32, radius: f32) -> ExampleData {
    let c = mesh.positions[contact as usize];
    let n = mesh.normals.as_ref().unwrap()[contact as usize];
    let (mut indices, mut values) = (Vec::new(), Vec::new());
    for (v, p) in mesh.positions.iter().enumerate() {
        let r = sub(*p, c);
        let q = dot(r, r) / (radius * radius);
        if q < 1.0 {
            let w = depth * (1.0 - q) * (1.0 - q);
            indices.push(v as u32);
            values.push([0, 1, 2].map(|k| -w * n[k] - 0.3 * w * r[k] / radius));
        }
    }
    ExampleData {
        contact: Some(Contact::Vertex(contact)),
        ..ExampleData::new(format!("bowl at {contact}"), Deltas::Sparse { indices, values })
    }
}

/// Moves one vertex against z.
pub fn poke(vertex: u32, depth: f32) -> ExampleData {
    ExampleData::new("poke", Deltas::Sparse { indices: vec![vertex], values: vec![[0.0, 0.0, -depth]] })
}

/// Displacements of each of `count` vertices, m.
pub fn field(deltas: &Deltas, count: usize) -> Vec<Vec3> {
    match deltas {
        Deltas::Full(values) => values.iter().map(|u| Vec3::from(*u)).collect(),
        Deltas::Sparse { indices, values } => {
            let mut field = vec![Vec3::ZERO; count];
            indices.iter().zip(values).for_each(|(v, u)| field[*v as usize] = Vec3::from(*u));
            field
        }
    }
}

/// `count` vertices spread over the body, each the furthest from all before it.
pub fn spread(positions: &[[f32; 3]], count: usize, first: usize) -> Vec<u32> {
    let mut chosen = vec![first as u32];
    while chosen.len() < count {
        let far = |p: [f32; 3]| chosen.iter().map(|&c| length(sub(p, positions[c as usize]))).fold(f32::MAX, f32::min);
        let mut best = (0, -1.0);
        for (v, p) in positions.iter().enumerate() {
            let d = far(*p);
            if d > best.1 {
                best = (v as u32, d);
            }
        }
        chosen.push(best.0);
    }
    chosen
}

/// Bowls of different depths and radii, spread over the body.
pub fn bowls(mesh: &MeshData, count: usize, radius: f32, seed: u64) -> Vec<ExampleData> {
    let mut dice = Dice::new(seed);
    let first = dice.index(mesh.positions.len());
    spread(&mesh.positions, count, first)
        .into_iter()
        .map(|c| bowl(mesh, c, radius * dice.between(0.1, 0.4), radius * dice.between(0.7, 1.3)))
        .collect()
}

/// Files of these sets have whole examples, so that what is loaded takes classic rules.
pub fn build(mesh: MeshData, examples: Vec<ExampleData>, options: SetOptions) -> Arc<ExampleSet> {
    let options = SetOptions { whole_examples: true, ..options };
    Arc::new(ExampleSet::build(mesh, examples, options, &Serial).expect("a well-formed scene"))
}

/// A named body with its example set.
pub type Body = (&'static str, Arc<ExampleSet>);

fn made_up(which: usize) -> Arc<ExampleSet> {
    static SETS: [OnceLock<Arc<ExampleSet>>; 3] = [const { OnceLock::new() }; 3];
    let make = || {
        let (mesh, count, radius) = match which {
            0 => (sheet(24), 5, 0.3),
            1 => (ball(3), 6, 0.35),
            _ => (cube(10), 6, 0.45),
        };
        let examples = bowls(&mesh, count, radius, which as u64 + 1);
        build(mesh, examples, SetOptions::default())
    };
    SETS[which].get_or_init(make).clone()
}

pub fn sheet_set() -> Arc<ExampleSet> {
    made_up(0)
}

pub fn ball_set() -> Arc<ExampleSet> {
    made_up(1)
}

pub fn cube_set() -> Arc<ExampleSet> {
    made_up(2)
}

/// The synthetic bodies, built once: a flat sheet, a closed sphere, a cube with hard edges and a UV seam.
pub fn small_bodies() -> Vec<Body> {
    vec![("sheet", sheet_set()), ("ball", ball_set()), ("cube", cube_set())]
}

/// The synthetic bodies and the solver's panel.
pub fn bodies() -> Vec<Body> {
    let mut all = small_bodies();
    all.push(("panel", solver_set("panel", 8)));
    all
}

/// Options with a node at every position, so that vertices are where marks say, up to rounding.
pub fn every_node(options: SetOptions) -> SetOptions {
    SetOptions { basis: Some(BasisOptions { tolerance: 1e9, rounds: 0, nodes: usize::MAX }), ..options }
}

/// A bowl at a vertex, as deep as a law of its blow's energy (J) and of its place along x says.
pub fn struck(mesh: &MeshData, vertex: u32, energy: f32) -> ExampleData {
    let depth = 0.002 * energy.sqrt() * (1.0 + mesh.positions[vertex as usize][0]);
    let normal = mesh.normals.as_ref().unwrap()[vertex as usize];
    ExampleData { blow: blow(energy, normal), ..bowl(mesh, vertex, depth, 0.3) }
}

/// A blow of a ball of 5 kg against the normal.
pub fn blow(energy: f32, normal: [f32; 3]) -> Blow {
    let speed = (2.0 * energy / 5.0).sqrt();
    let velocity = Some(normal.map(|n| -speed * n));
    Blow::of_striker(Striker { mass: Some(5.0), velocity, radius: Some(0.1), shape: StrikerShape::Ball })
}

/// A set of this many struck examples, spread over the mesh.
pub fn learned(mesh: &MeshData, count: usize, seed: u64) -> Arc<ExampleSet> {
    let mut dice = Dice::new(seed);
    let first = dice.index(mesh.positions.len());
    let places = spread(&mesh.positions, count, first);
    let examples = places.into_iter().map(|v| struck(mesh, v, dice.between(20.0, 400.0))).collect();
    build(mesh.clone(), examples, SetOptions::default())
}

/// The mesh of the independent elasto-plastic solver's `panel` or `tube`, as committed in `assets/solver`, and the first `count` of its 32
/// examples.
pub fn solver(body: &str, count: usize) -> (MeshData, Vec<ExampleData>) {
    let path = repository().join(format!("assets/solver/{body}.glb"));
    let Imported { mesh, mut examples, .. } = gltf_file(&path, MeshChoice::First).expect("the committed asset");
    examples.truncate(count);
    (mesh, examples)
}

/// The set of a solver body.
pub fn solver_with(body: &str, count: usize, options: SetOptions) -> Arc<ExampleSet> {
    let (mesh, examples) = solver(body, count);
    build(mesh, examples, options)
}

pub fn solver_set(body: &str, count: usize) -> Arc<ExampleSet> {
    solver_with(body, count, SetOptions::default())
}

pub fn push(point: [f32; 3], displacement: [f32; 3]) -> Hit {
    Hit { point, cause: Cause::Displacement(displacement), space: Space::Local, contact: None }
}

/// The displacement of an example's contact, there.
pub fn own_hit(example: &Example) -> Hit {
    push(example.contact_point().into(), example.contact_displacement().into())
}

/// A hit near a random vertex, pushed inwards at up to about 60 degrees from the normal. Its length is 0.02 to 1.5
/// times the set's depth limit.
pub fn random_hit(set: &ExampleSet, dice: &mut Dice) -> Hit {
    let vertex = dice.index(set.vertex_count());
    hit_at(set, vertex, dice)
}

pub fn hit_at(set: &ExampleSet, vertex: usize, dice: &mut Dice) -> Hit {
    let at = set.mesh().positions()[vertex].to_array();
    let normal = set.mesh().normals().map_or([0.0, 0.0, 1.0], |n| n[vertex].to_array());
    let jitter = dice.vector(0.004);
    let sideways = dice.vector(0.8);
    let size = set.depth_limit() * dice.between(0.02, 1.5);
    push([0, 1, 2].map(|k| at[k] + jitter[k]), [0, 1, 2].map(|k| size * (sideways[k] - normal[k])))
}

/// `count` hits. Most are at random places; some repeat one of four hits, as a physics engine does.
pub fn random_hits(set: &ExampleSet, count: usize, seed: u64) -> Vec<Hit> {
    let mut dice = Dice::new(seed);
    let few: Vec<Hit> = (0..4).map(|_| random_hit(set, &mut dice)).collect();
    (0..count).map(|_| if dice.index(4) == 0 { few[dice.index(4)] } else { random_hit(set, &mut dice) }).collect()
}

/// Relative L2 norm of the difference between two fields.
pub fn relative_l2(is: &[Vec3], ought: &[Vec3]) -> f64 {
    let square = |v: Vec3| v.as_dvec3().length_squared();
    let wrong: f64 = is.iter().zip(ought).map(|(a, b)| square(*a - *b)).sum();
    (wrong / ought.iter().map(|b| square(*b)).sum::<f64>()).sqrt()
}

/// An instance with default options.
pub fn new(set: &Arc<ExampleSet>) -> Instance {
    Instance::new(set.clone(), InstanceOptions::default()).unwrap()
}

/// An instance with these options.
pub fn with(set: &Arc<ExampleSet>, options: InstanceOptions) -> Instance {
    Instance::new(set.clone(), options).unwrap()
}

/// An instance after these hits, which are not folded yet.
pub fn dented(set: &Arc<ExampleSet>, options: InstanceOptions, hits: &[Hit]) -> Instance {
    let instance = with(set, options);
    for hit in hits {
        instance.submit(hit).unwrap();
    }
    instance
}

pub fn base(set: &ExampleSet, v: usize) -> [f32; 3] {
    set.mesh().positions()[v].to_array()
}

pub fn distance(a: [f32; 3], b: [f32; 3]) -> f64 {
    Vec3::from(a).as_dvec3().distance(Vec3::from(b).as_dvec3())
}

/// The length that rounding a coordinate of this size to f32 can add.
pub fn rounding(p: [f32; 3]) -> f64 {
    f64::from(Vec3::from(p).abs().max_element()) * 1.1e-7
}

/// Checks what holds for any damage: positions are finite and within the limit, normals have unit length, tangents are orthogonal to
/// them, and vertices at one position stay at one, bit for bit.
pub fn check_sound(instance: &mut Instance) -> Result<(), TestCaseError> {
    let set = instance.example_set().clone();
    let limit = f64::from(instance.depth_limit());
    let out = Output::fresh(instance);
    for v in 0..set.vertex_count() {
        let (p, b) = (out.positions[v], base(&set, v));
        prop_assert!(p.iter().all(|x| x.is_finite()), "vertex {v} at {p:?}");
        let far = distance(p, b);
        prop_assert!(far <= limit * (1.0 + 1e-6) + rounding(p) + rounding(b), "vertex {v} moved {far}, limit {limit}");
        if set.mesh().normals().is_some() {
            let n = Vec3::from_array(out.normals[v]);
            prop_assert!((n.length() - 1.0).abs() < 1e-5, "normal of vertex {v}: {n}");
            if let Some(t) = set.mesh().tangents() {
                let [x, y, z, w] = out.tangents[v];
                let tangent = Vec3::new(x, y, z);
                prop_assert!((tangent.length() - 1.0).abs() < 1e-5, "tangent of vertex {v}: {tangent}");
                prop_assert!(tangent.dot(n).abs() < 1e-5, "tangent {tangent} of vertex {v} is not orthogonal to {n}");
                prop_assert_eq!(w, t[v].w);
            }
        }
    }
    let at_rest: Vec<[f32; 3]> = (0..set.vertex_count()).map(|v| base(&set, v)).collect();
    for group in coincident(&at_rest) {
        for &v in &group[1..] {
            let [one, other] = [out.bits(group[0]), out.bits(v)];
            prop_assert_eq!(&one[..3], &other[..3], "vertices {} and {}", group[0], v);
            // A UV seam is shaded as one surface.
            let same = set.mesh().normals().is_none_or(|n| n[v] == n[group[0]]);
            prop_assert!(!same || one[3..6] == other[3..6], "normals of vertices {} and {v}", group[0]);
        }
    }
    Ok(())
}

/// What tells marks apart: all but the energy.
pub fn key(mark: &crumple::Mark) -> Vec<u8> {
    bytemuck::bytes_of(&crumple::Mark { energy: 0, ..*mark }).to_vec()
}

/// FNV-1a: a hash that needs no crate and is the same on every platform.
pub fn fnv(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0000_0100_0000_01b3))
}

/// Godot's `Vector3::octahedron_encode`.
fn octahedron_encode(v: [f32; 3]) -> [f32; 2] {
    let sum = v[0].abs() + v[1].abs() + v[2].abs();
    let n = [v[0] / sum, v[1] / sum, v[2] / sum];
    let mut o = [0.0; 2];
    if n[2] >= 0.0 {
        o[0] = n[0];
        o[1] = n[1];
    } else {
        o[0] = (1.0 - n[1].abs()) * (if n[0] >= 0.0 { 1.0 } else { -1.0 });
        o[1] = (1.0 - n[0].abs()) * (if n[1] >= 0.0 { 1.0 } else { -1.0 });
    }
    [o[0] * 0.5 + 0.5, o[1] * 0.5 + 0.5]
}

/// What Godot's `RenderingServer` stores.
fn stored(o: [f32; 2]) -> [u16; 2] {
    o.map(|x| (x * 65535.0).clamp(0.0, 65535.0) as u16)
}

/// A normal as Godot stores it.
pub fn octahedral_normal(n: [f32; 3]) -> [u16; 2] {
    stored(octahedron_encode(n))
}

/// Godot's `Vector3::octahedron_tangent_encode`, stored.
pub fn octahedral_tangent(t: [f32; 4]) -> [u16; 2] {
    let mut res = octahedron_encode([t[0], t[1], t[2]]);
    res[1] = res[1].max(1.0 / 32767.0);
    res[1] = res[1] * 0.5 + 0.5;
    res[1] = if t[3] >= 0.0 { res[1] } else { 1.0 - res[1] };
    let vector = stored(res);
    if vector == [0, 65535] { [65535, 65535] } else { vector }
}
