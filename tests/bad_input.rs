//! Wrong input, and input that only looks wrong. Each error has a type, names the value and what would be right, and
//! changes nothing.

mod scenes;

use std::num::NonZeroU64;
use std::sync::Arc;

use crumple::glam::{Mat4, Vec3, Vec4};
use crumple::{
    Attachment, Attribute, BasisOptions, Blow, Cause, Contact, Deltas, Encoding, Error, ErrorKind, ExampleData,
    ExampleSet, Hit, HitStatus, Instance, InstanceOptions, Mark, MeshData, Rule, Selection, Serial, SetOptions, Space,
    Tracker, VertexMass, VertexMemory, load_all, map_damage, save_all,
};
use twox_hash::XxHash3_64;

use scenes::{Dice, Output, check_sound, dented, new, push, random_hit, with};

/// Asserts that a result is this kind of error and that its text has all these words.
macro_rules! refused {
    ($result:expr, $variant:ident, $($word:expr),+ $(,)?) => {{
        let error = match $result {
            Ok(_) => panic!("{} was accepted", stringify!($result)),
            Err(e) => e,
        };
        assert!(matches!(error, Error::$variant { .. }), "{} gave {error:?}", stringify!($result));
        let text = error.to_string();
        $(assert!(text.contains($word), "'{}' does not say '{}'", text, $word);)+
        error
    }};
}

/// Asserts that every change with every value gives an input that is refused with this kind of error, whose text has
/// all the words between the dots. `VALUE` stands for the value.
macro_rules! refuses {
    ($input:ty, $kind:ident, $values:expr; $(|$i:ident, $v:pat_param| $change:expr => $words:literal),+ $(,)?) => {$(
        for value in $values {
            let mut input = <$input>::good();
            let ($i, $v) = (&mut input, value);
            $change;
            let error = input.make().expect_err($words);
            assert_eq!(error.kind(), ErrorKind::$kind, "{error}");
            for word in $words.split(" … ").map(|word| word.replace("VALUE", &value.to_string())) {
                assert!(error.to_string().contains(&word), "'{error}' does not say '{word}'");
            }
        }
    )+};
}

/// An input that a test can spoil before it builds something from it.
trait Made {
    fn good() -> Self;
    fn make(self) -> Result<(), Error>;
}

/// The input of a set: a mesh, one example, options.
type Input = (MeshData, Vec<ExampleData>, SetOptions);

impl Made for Input {
    fn good() -> Self {
        (triangle(), vec![dent()], SetOptions::default())
    }

    fn make(self) -> Result<(), Error> {
        build_with(self.0, self.1, self.2).map(drop)
    }
}

impl Made for InstanceOptions {
    fn good() -> Self {
        InstanceOptions::default()
    }

    fn make(self) -> Result<(), Error> {
        Instance::new(set(), self).map(drop)
    }
}

impl Made for Hit {
    fn good() -> Self {
        good()
    }

    /// A refused hit leaves the body as it was.
    fn make(self) -> Result<(), Error> {
        let mut instance = instance();
        let made = instance.submit(&self).map(drop);
        if made.is_err() {
            assert_eq!(instance.preview(&self).map(drop), made);
            still_usable(&mut instance, &[]);
        }
        made
    }
}

const NAN: f32 = f32::NAN;
const INF: f32 = f32::INFINITY;

fn triangle() -> MeshData {
    MeshData {
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        normals: Some(vec![[0.0, 0.0, 1.0]; 3]),
        tangents: Some(vec![[1.0, 0.0, 0.0, 1.0]; 3]),
        triangles: vec![[0, 1, 2]],
        ..MeshData::default()
    }
}

fn dent() -> ExampleData {
    ExampleData::new("a dent", Deltas::Sparse { indices: vec![0, 1], values: vec![[0.0, 0.0, -0.2], [0.0, 0.0, -0.1]] })
}

fn build(mesh: MeshData, examples: Vec<ExampleData>) -> Result<ExampleSet, Error> {
    build_with(mesh, examples, SetOptions::default())
}

fn build_with(mesh: MeshData, examples: Vec<ExampleData>, options: SetOptions) -> Result<ExampleSet, Error> {
    ExampleSet::build(mesh, examples, options, &Serial)
}

fn set() -> Arc<ExampleSet> {
    Arc::new(build(triangle(), vec![dent()]).unwrap())
}

fn instance() -> Instance {
    new(&set())
}

fn good() -> Hit {
    push([0.0; 3], [0.0, 0.0, -0.1])
}

/// Asserts that the instance still works: it takes a hit, and its damage is then `marks` and that hit's mark.
#[track_caller]
fn still_usable(instance: &mut Instance, marks: &[Mark]) {
    assert_eq!(instance.marks().unwrap(), marks, "a refused call changed the damage");
    let hit = good();
    assert_eq!(instance.submit(&hit).unwrap().status, HitStatus::Marked);
    let out = Output::fresh(instance);
    assert!(out.positions.iter().flatten().all(|x| x.is_finite()));
    assert!(out.positions[0][2] < -0.09);
    instance.set_marks(marks).unwrap();
}

// ----------------------------------------------------------------------------------------------------------------- meshes

#[test]
fn quick_meshes_that_do_not_hold_together() {
    refuses! { Input, Mesh, [0.0];
        |i, _| i.0 = MeshData::default() => "0 vertices",
        |i, _| i.0.normals.as_mut().unwrap().truncate(2) => "normals … 2 … 3",
        |i, _| i.0.tangents.as_mut().unwrap().push([1.0, 0.0, 0.0, 1.0]) => "tangents … 4 … 3",
        |i, _| i.2.mass = VertexMass::PerVertex(vec![1.0]) => "1 vertex masses … 3 vertices",
        |i, _| i.0.depth_limits = Some(vec![1.0; 2]) => "2 depth_limits for 3 positions",
    }
    refuses! { Input, IndexOutOfRange, [3, u32::MAX];
        |i, v| i.0.triangles.push([0, v, 1]) => "triangle 1 … VALUE … below 3",
    }
}

#[test]
fn quick_sets_with_numbers_that_are_none() {
    refuses! { Input, NotFinite, [NAN, INF, -INF];
        |i, v| i.0.positions[1][2] = v => "positions[1] … finite",
        |i, v| i.0.normals.as_mut().unwrap()[2][0] = v => "normals[2]",
        |i, v| i.0.tangents.as_mut().unwrap()[0][3] = v => "tangents[0]",
        |i, v| i.1[0].contact_normal = Some([0.0, v, 0.0]) => "contact normal … a dent",
    }
    refuses! { Input, InvalidArgument, [1e30];
        |i, v| i.0.positions[0][0] = v => "positions[0] … 1e9",
    }
    refuses! { Input, InvalidArgument, [-1.0, NAN, -INF];
        |i, v| i.0.depth_limits = Some(vec![0.5, v, 0.5]) => "depth_limits[1] … at least 0 m",
    }
    refuses! { Input, InvalidArgument, [-0.1, 1.1, NAN, INF];
        |i, v| i.0.stiffness = Some(vec![0.5, v, 0.5]) => "stiffness[1] … 0 to 1",
    }
}

#[test]
fn quick_zero_length_normals_and_degenerate_triangles_are_repaired_and_reported() {
    let mut mesh = scenes::cube(4);
    mesh.normals.as_mut().unwrap()[7] = [0.0; 3];
    mesh.normals.as_mut().unwrap()[8] = [1e-44, 0.0, 0.0];
    mesh.triangles.extend([[0, 0, 1], [5, 5, 5], [0, 1, 2]]);
    mesh.tangents = None;
    let examples = scenes::bowls(&scenes::cube(4), 3, 0.5, 1);
    let set = build(mesh, examples).unwrap();
    assert_eq!(set.report().repaired_normals, 1);
    // 0, 1 and 2 are collinear
    assert_eq!(set.report().degenerate_triangles, 3);
    check_sound(&mut new(&Arc::new(set))).unwrap();
}

// --------------------------------------------------------------------------------------------------------------- examples

#[test]
fn quick_no_examples() {
    let still = || ExampleData::new("still", Deltas::Full(vec![[0.0; 3]; 3]));
    let error = refused!(build(triangle(), vec![]), NoExamples, "0 were given", "at least 1");
    assert_eq!(error.kind(), ErrorKind::ExampleMismatch);
    refused!(build(triangle(), vec![still(), still()]), NoExamples, "2 given", "moves");
    refused!(build(triangle(), vec![still(); 65_535]), NoExamples, "65535", "65534");
    let dropped = SetOptions { drop_below: 0.3, ..SetOptions::default() };
    refused!(build_with(triangle(), vec![dent()], dropped), NoExamples, "0.3 m");
}

#[test]
fn quick_an_empty_example_keeps_its_index_and_tells_nothing() {
    let still = ExampleData::new("still", Deltas::Sparse { indices: vec![], values: vec![] });
    let set = Arc::new(build(triangle(), vec![still, dent()]).unwrap());
    assert_eq!(set.report().empty_examples, [0]);
    assert!(set.examples()[0].is_empty());
    assert_eq!(set.example_errors(), [0.0, 1.0]);
    let (mut instance, mut alone) = (new(&set), new(&Arc::new(build(triangle(), vec![dent()]).unwrap())));
    instance.submit(&good()).unwrap();
    alone.submit(&good()).unwrap();
    assert_eq!(Output::fresh(&mut instance).positions, Output::fresh(&mut alone).positions);
}

#[test]
fn quick_examples_of_another_vertex_count_or_order() {
    fn sparse(indices: &[u32], count: usize) -> Deltas {
        Deltas::Sparse { indices: indices.to_vec(), values: vec![[0.1; 3]; count] }
    }
    refuses! { Input, ExampleMismatch, [4];
        |i, n| i.1.push(ExampleData { positions: Deltas::Full(vec![[0.1; 3]; n]), ..dent() }) => "example 1 'a dent' … VALUE … 3 vertices",
        |i, _| i.1[0].positions = sparse(&[0, 3], 2) => "index 3 … 3 vertices",
        |i, _| i.1[0].positions = sparse(&[0, u32::MAX], 2) => "4294967295",
        |i, _| i.1[0].positions = sparse(&[1, 0], 2) => "index 0 follows 1 … increase",
        |i, _| i.1[0].positions = sparse(&[1, 1], 2) => "index 1 follows 1 … increase",
        |i, _| i.1[0].positions = sparse(&[0, 1], 3) => "2 indices … 3",
        |i, _| i.1[0].normals = Some(Deltas::Full(vec![[0.0; 3]; 2])) => "normal … 2 … 3 vertices",
    }
}

#[test]
fn quick_examples_with_numbers_that_are_none() {
    fn full(v: f32) -> Deltas {
        Deltas::Full(vec![[0.1; 3], [0.1; 3], [0.1, v, 0.1]])
    }
    refuses! { Input, ExampleMismatch, [NAN, INF, -INF];
        |i, v| i.1[0].positions = full(v) => "vertex 2 … finite",
        |i, v| i.1[0].normals = Some(full(v)) => "normal … vertex 2 … finite",
        |i, v| i.1[0].contact = Some(Contact::Point([0.0, v, 0.0])) => "contact … a dent … finite",
    }
    refuses! { Input, ExampleMismatch, [1e30];
        |i, v| i.1[0].positions = full(v) => "1e30 … 1e9",
    }
    // The other parts of a blow are in src/example/blow.rs.
    refuses! { Input, InvalidArgument, [-1.0];
        |i, v| i.1[0].blow.striker.mass = Some(v) => "blow.striker.mass of example 0 'a dent' is VALUE",
    }
}

#[test]
fn quick_contacts_that_cannot_be() {
    fn two(first: f32) -> Deltas {
        Deltas::Sparse { indices: vec![0, 1], values: vec![[0.0, 0.0, -first], [0.0, 0.0, -0.1]] }
    }
    let error = build(triangle(), vec![ExampleData { contact: Some(Contact::Vertex(3)), ..dent() }]).unwrap_err();
    assert!(matches!(error.kind(), ErrorKind::IndexOutOfRange | ErrorKind::ExampleMismatch), "{error:?}");
    assert!(error.to_string().contains('3'), "{error}");
    refuses! { Input, ExampleMismatch, [0.0];
        |i, _| i.1[0].contact = Some(Contact::Vertex(2)) => "vertex 2 … does not move",
        |i, _| i.1[0].contact = Some(Contact::Point([0.0, 0.9, 0.0])) => "vertex 2",
        |i, _| i.1[0].contact_normal = Some([0.0; 3]) => "contact normal … length 0",
    }
    // The squares of such displacements are 0 in f32. Larger ones are in stability.rs.
    refuses! { Input, ExampleMismatch, [1e-30, 1e-38, 1e-44];
        |i, v| (i.1[0].contact, i.1[0].positions) = (Some(Contact::Vertex(0)), two(v)) => "does not move its own contact",
    }
}

#[test]
fn quick_options_of_a_set_out_of_range() {
    refuses! { Input, InvalidArgument, [0.0, -1.0, NAN, INF];
        |i, v| i.2.depth_limit = Some(v) => "depth_limit",
        |i, v| i.2.mass = VertexMass::Uniform(v) => "mass … kg",
        |i, v| i.2.mass = VertexMass::PerVertex(vec![1.0, v, 1.0]) => "mass of vertex 1",
        |i, v| i.2.basis = Some(BasisOptions { tolerance: v, rounds: 1, nodes: 0 }) => "tolerance",
    }
    refuses! { Input, InvalidArgument, [2e9];
        |i, v| i.2.depth_limit = Some(v) => "depth_limit",
    }
    refuses! { Input, InvalidArgument, [-1e-9, NAN, INF];
        |i, v| i.2.drop_below = v => "drop_below",
    }
}

// -------------------------------------------------------------------------------------------------------------- instances

#[test]
fn quick_options_of_an_instance_out_of_range() {
    refuses! { InstanceOptions, InvalidArgument, [0, 65_536, u32::MAX];
        |o, v| o.capacity = v => "capacity … 65535",
    }
    refuses! { InstanceOptions, InvalidArgument, [0.0, -1.0, NAN, INF, 2e9];
        |o, v| o.depth_limit = Some(v) => "depth_limit … m",
    }
    refuses! { InstanceOptions, InvalidArgument, [0.0, -1.0, NAN, INF];
        |o, v| o.compliance = Some(v) => "compliance is VALUE; it must be above 0 and finite, m per N·s",
    }
    refuses! { InstanceOptions, InvalidArgument, [0.1];
        |o, v| *o = InstanceOptions { grow_time: v, ..InstanceOptions::classic(Rule::MostDisplaced) } => "grow_time is VALUE; it must be 0",
    }
    refuses! { InstanceOptions, InvalidArgument, [-1.0, NAN, INF];
        |o, v| o.yield_impulse = v => "yield_impulse … N·s",
        |o, v| o.yield_displacement = v => "yield_displacement",
        |o, v| o.max_contact_distance = Some(v) => "max_contact_distance",
    }
    refuses! { InstanceOptions, InvalidArgument, [-0.1, 1.1, NAN, INF];
        |o, v| *o = InstanceOptions::classic(Rule::Blend(v)) => "blend … 0 to 1",
    }
    refuses! { InstanceOptions, InvalidArgument, [0];
        |o, _| o.selection = Selection::ClassicUnclamped => "ClassicUnclamped … Marks",
    }
}

/// Changes the hit's impulse, which is [0, 0, -1] N s in 0.1 s on 1 kg along the normal otherwise.
fn struck(hit: &mut Hit, change: impl Fn(&mut Blow, &mut Option<f32>)) {
    let mut blow = Blow { normal: Some([0.0, 0.0, 1.0]), ..Blow::of_impulse([0.0, 0.0, -1.0], 0.1) };
    let mut mass = Some(1.0);
    change(&mut blow, &mut mass);
    hit.cause = Cause::Impulse { blow, mass };
}

#[test]
fn quick_hits_with_numbers_that_are_none_or_absent() {
    refuses! { Hit, NotFinite, [NAN, INF, -INF];
        |h, v| h.point[0] = v => "point",
        |h, v| (h.point[2], h.space) = (v, Space::World) => "point",
        |h, v| h.cause = Cause::Displacement([0.0, v, -0.1]) => "displacement",
        |h, v| (h.cause, h.space) = (Cause::Displacement([v, 0.0, -0.1]), Space::World) => "displacement",
        |h, v| struck(h, |b, _| b.impulse = Some([0.0, 0.0, v])) => "impulse",
        |h, v| (struck(h, |b, _| b.impulse = Some([v, 0.0, 0.0])), h.space = Space::World) => "impulse",
    }
    refuses! { Hit, InvalidArgument, [0.0, -0.0, -1.0, NAN, INF];
        |h, v| struck(h, |b, _| b.duration = Some(v)) => "duration … above 0 … s",
        |h, v| struck(h, |_, mass| *mass = Some(v)) => "mass … above 0 … kg",
    }
    refuses! { Hit, InvalidArgument, [0.0];
        |h, _| struck(h, |_, mass| *mass = None) => "mass … absent",
        |h, _| struck(h, |b, _| b.normal = Some([0.0; 3])) => "normal is [0.0, 0.0, 0.0]",
        |h, _| struck(h, |b, _| b.impulse = None) => "impulse is absent … striker's mass",
        |h, _| struck(h, |b, _| b.duration = None) => "duration is absent",
    }
}

#[test]
fn quick_zero_and_tiny_hits_are_too_weak_not_wrong() {
    let mut instance = instance();
    for size in [0.0, -0.0, 1e-30, 1e-38, 1e-44] {
        let outcome = instance.submit(&push([0.0; 3], [0.0, 0.0, -size])).unwrap();
        assert_eq!((outcome.status, outcome.achieved, outcome.mark), (HitStatus::BelowYield, [0.0; 3], None));
        let cause = Cause::Impulse { blow: Blow::of_impulse([0.0, 0.0, -size], 1e-3), mass: Some(1.0) };
        assert_eq!(instance.submit(&Hit { cause, ..good() }).unwrap().status, HitStatus::BelowYield);
    }
    still_usable(&mut instance, &[]);
}

#[test]
fn quick_contacts_far_away() {
    let mut instance = instance();
    for far in [5.0f32, 3000.0, 1e10, 1e30, f32::MAX] {
        for k in 0..3 {
            let mut point = [0.0; 3];
            point[k] = -far;
            let error = refused!(instance.submit(&Hit { point, ..good() }), ContactTooFar, "at most 1.414");
            let Error::ContactTooFar { distance, .. } = error else { unreachable!() };
            assert!(distance >= 0.99 * far, "{distance}");
        }
    }
    let options = InstanceOptions { max_contact_distance: Some(0.01), ..InstanceOptions::default() };
    let near = with(&set(), options);
    refused!(near.submit(&push([0.0, 0.0, 0.02], [0.0, 0.0, -0.1])), ContactTooFar, "0.02 m", "0.01 m");
    near.submit(&push([0.0, 0.0, 0.009], [0.0, 0.0, -0.1])).unwrap();
    still_usable(&mut instance, &[]);
}

#[test]
fn quick_hits_that_pull_where_examples_push_reach_nothing() {
    let mut instance = instance();
    let outcome = instance.submit(&push([0.0; 3], [0.0, 0.0, 0.1])).unwrap();
    assert_eq!((outcome.status, outcome.mark, outcome.shortfall()), (HitStatus::NothingReaches, None, outcome.target));
    still_usable(&mut instance, &[]);
}

#[test]
fn quick_transforms_that_cannot_be_undone() {
    let mut instance = instance();
    let mut nan = Mat4::IDENTITY;
    nan.y_axis.z = NAN;
    refused!(instance.set_transform(nan), NotFinite, "transform");
    let flat = Mat4::from_scale(Vec3::new(1.0, 0.0, 1.0));
    refused!(instance.set_transform(flat), InvalidArgument, "transform", "determinant");
    let perspective = Mat4::from_cols(Vec4::X, Vec4::Y, Vec4::new(0.0, 0.0, 1.0, -1.0), Vec4::W);
    refused!(instance.set_transform(perspective), InvalidArgument, "transform", "affine");
    // the previous transform is still in use
    let outcome = instance.preview(&Hit { space: Space::World, ..good() }).unwrap();
    assert_eq!(outcome.contact_vertex, 0);
    still_usable(&mut instance, &[]);
}

#[test]
fn quick_calls_out_of_range() {
    let mut instance = instance();
    for bad in [-0.1, 1.1, NAN, INF] {
        refused!(instance.repair(bad), InvalidArgument, "keep", "0", "1");
        if bad != 1.1 {
            refused!(instance.set_depth_limit(Some(bad)), InvalidArgument, "depth_limit");
        }
    }
    refused!(instance.repair_around([0.0; 3], 0.0, 0.5), InvalidArgument, "radius is 0; it must be above 0");
    refused!(instance.repair_around([0.0; 3], NAN, 0.5), InvalidArgument, "radius is NaN");
    refused!(instance.repair_around([0.0; 3], 1.0, 1.5), InvalidArgument, "keep is 1.5");
    refused!(instance.repair_around([NAN; 3], 1.0, 0.5), NotFinite, "point is");
    refused!(instance.set_time(f64::INFINITY), NotFinite, "time is inf");
    refused!(instance.displaced(3), IndexOutOfRange, "vertex", "3", "below 3");
    refused!(instance.displaced(u32::MAX), IndexOutOfRange, "4294967295");
    for bad in [NAN, INF] {
        refused!(instance.example_set().attach([bad, 0.0, 0.0]), NotFinite, "point");
        refused!(instance.example_set().nearest_vertex([0.0, bad, 0.0]), NotFinite, "point");
    }
    let good = instance.example_set().attach([0.2, 0.2, 0.1]).unwrap();
    let foreign = Attachment { vertices: [0, 1, 9], ..good };
    refused!(instance.attached_pose(&foreign), IndexOutOfRange, "attachment", "9", "below 3");
    refused!(instance.attached_pose(&Attachment { point: [NAN; 3], ..good }), NotFinite, "attachment");
    refused!(instance.attached_pose(&Attachment { weights: [INF; 3], ..good }), NotFinite, "attachment");
    still_usable(&mut instance, &[]);
}

#[test]
fn quick_classic_instances_have_no_marks_contacts_or_parts() {
    for (rule, name) in [(Rule::MostDisplaced, "MostDisplaced"), (Rule::Blend(0.5), "Blend")] {
        let mut instance = with(&set(), InstanceOptions::classic(rule));
        instance.submit(&good()).unwrap();
        let error = refused!(instance.marks(), WrongRule, "marks", "Marks", name);
        assert_eq!(error.kind(), ErrorKind::WrongRule);
        refused!(instance.set_marks(&[]), WrongRule, "set_marks");
        refused!(instance.repair_around([0.0; 3], 1.0, 0.5), WrongRule, "");
        let part = good().of_contact(NonZeroU64::MIN);
        refused!(instance.submit(&part), WrongRule, "");
        refused!(instance.preview(&part), WrongRule, "");
        refused!(instance.end_contact(NonZeroU64::MIN), WrongRule, "");
        refused!(instance.release(1), WrongRule, "");
        refused!(instance.set_rigid(1, true), WrongRule, "");
        assert_eq!(instance.contact_count(), 0);
        assert!((Output::fresh(&mut instance).positions[0][2] + 0.1).abs() < 1e-6);
    }
}

// ------------------------------------------------------------------------------------------------------------------ marks

#[test]
fn quick_marks_that_are_none() {
    let mut instance = instance();
    instance.submit(&good()).unwrap();
    let marks = instance.marks().unwrap().to_vec();
    let ok = marks[0];
    let mut bad: Vec<(Mark, &str)> = vec![
        (Mark { contact: 3, ..ok }, "contact"),
        (Mark { contact: u32::MAX, ..ok }, "contact"),
        (Mark { energy: 0, ..ok }, "hits"),
        (Mark { told: 1, ..ok }, "told"),
        (Mark { told: 2, ..ok }, "told"),
        (Mark { mass: 7, ..ok }, "striker, strength, mass and radius"),
        (Mark { reserved: 1, ..ok }, "reserved"),
    ];
    for depth in [0.0, -1.0, NAN, INF, 2e9] {
        bad.push((Mark { depth, ..ok }, "depth"));
    }
    for (mark, name) in bad {
        let error = refused!(instance.set_marks(&[ok, mark]), InvalidArgument, name, "mark 1");
        assert_eq!(error.kind(), ErrorKind::InvalidArgument);
        still_usable(&mut instance, &marks);
        // the same in a saved file: the bytes of its one mark are replaced
        let mut bytes = instance.save();
        let end = bytes.len() - 8;
        bytes[end - 32..end].copy_from_slice(bytemuck::bytes_of(&mark));
        assert!(instance.load(&sealed(bytes)).is_err_and(|e| e.to_string().contains(name)), "{mark:?}");
        still_usable(&mut instance, &marks);
    }
}

/// Saved damage that was changed, with the checksum of its bytes.
fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let (damage, checksum) = bytes.split_last_chunk_mut().unwrap();
    *checksum = XxHash3_64::oneshot(damage).to_le_bytes();
    bytes
}

#[test]
fn quick_every_flipped_bit_and_every_other_length_of_saved_damage() {
    let set = scenes_set();
    let other = Arc::new(build(triangle(), vec![dent()]).unwrap());
    for options in [InstanceOptions::default(), InstanceOptions::classic(Rule::MostDisplaced)] {
        let mut dice = Dice::new(7);
        let mut instance = dented(&set, options, &[(); 4].map(|_| random_hit(&set, &mut dice)));
        let (one, all) = (instance.save(), save_all([&mut instance]));
        let mut fresh = with(&set, options);
        let clean = fresh.save();
        let flipped = |bytes: &[u8], bit: usize| {
            let mut bytes = bytes.to_vec();
            bytes[bit / 8] ^= 1 << (bit % 8);
            bytes
        };
        for bit in 0..one.len() * 8 {
            refused!(fresh.load(&flipped(&one, bit)), DamageMismatch, "");
            refused!(map_damage(&set, &set, &flipped(&one, bit), INF), DamageMismatch, "");
        }
        for len in 0..one.len() {
            refused!(fresh.load(&one[..len]), DamageMismatch, "bytes");
        }
        refused!(fresh.load(&[&one[..], &[0]].concat()), DamageMismatch, "bytes");
        for bit in 0..all.len() * 8 {
            refused!(load_all(&mut [&mut fresh], &flipped(&all, bit), &Serial), DamageMismatch, "");
            // also where it is none of the damage to map
            refused!(map_damage(&other, &other, &flipped(&all, bit), INF), DamageMismatch, "");
        }
        assert!(fresh.save() == clean);
        load_all(&mut [&mut fresh], &all, &Serial).unwrap();
        assert!(fresh.save() == one);
    }
}

#[test]
fn quick_saved_damage_of_another_kind_set_or_version() {
    let mut instance = instance();
    instance.submit(&good()).unwrap();
    let marks = instance.marks().unwrap().to_vec();
    let bytes = instance.save();
    let changed = |at: usize| {
        let mut bytes = bytes.clone();
        bytes[at] ^= 0x40;
        sealed(bytes)
    };
    refused!(instance.load(&changed(0)), DamageMismatch, "begins");
    let error = refused!(instance.load(&changed(4)), DamageMismatch, "version");
    assert_eq!(error.kind(), ErrorKind::DamageMismatch);
    refused!(instance.load(&changed(6)), DamageMismatch, "kind");
    refused!(instance.load(&changed(8)), DamageMismatch, "example set");
    refused!(instance.load(b"glTF\x02\0\0\0 and so on, at least forty bytes of it"), DamageMismatch, "begins");
    // the same mesh with another example is another set
    let other = ExampleData { positions: Deltas::Full(vec![[0.0, 0.0, -0.1]; 3]), ..dent() };
    let other = Arc::new(build(triangle(), vec![other]).unwrap());
    let mut other = new(&other);
    refused!(other.load(&bytes), DamageMismatch, "example set");
    refused!(other.copy_damage_from(&mut instance), DamageMismatch, "example set");
    assert!(other.marks().unwrap().is_empty());
    let mut classic = with(instance.example_set(), InstanceOptions::classic(Rule::MostDisplaced));
    refused!(classic.load(&bytes), DamageMismatch, "rule");
    refused!(classic.copy_damage_from(&mut instance), DamageMismatch, "rule");
    refused!(instance.copy_damage_from(&mut classic), DamageMismatch, "rule");
    still_usable(&mut instance, &marks);
}

fn scenes_set() -> Arc<ExampleSet> {
    static SET: std::sync::OnceLock<Arc<ExampleSet>> = std::sync::OnceLock::new();
    SET.get_or_init(|| {
        let mesh = scenes::sheet(8);
        let examples = scenes::bowls(&mesh, 3, 0.4, 1);
        scenes::build(mesh, examples, SetOptions::default())
    })
    .clone()
}

// ----------------------------------------------------------------------------------------------------------------- memory

#[test]
fn quick_memory_that_is_laid_out_wrong() {
    let mut bytes = vec![0u8; 4096];
    let at = |offset, stride| Attribute { offset, stride, format: Encoding::F32 };
    let mut positions = |p, normal, tangent| VertexMemory::interleaved(&mut bytes, p, normal, tangent).map(drop);
    // src/base/strided.rs has other offsets and strides, and sizes
    refused!(positions(at(0, 8), None, None), InvalidArgument, "position", "8", "at least the 12 bytes");
    refused!(positions(at(0, 12), None, Some(at(12, 12))), InvalidArgument, "offset", "stride");
    refused!(positions(at(1, 12), None, None), Misaligned, "position", "1", "multiple of 4");
    refused!(positions(at(0, 13), None, None), Misaligned, "position", "13", "multiple of 4");
    refused!(positions(at(0, 24), Some(at(8, 24)), None), InvalidArgument, "position", "normal");
    // octahedral values have 4 bytes, of normals and tangents alone
    let octahedral = |offset, stride| Attribute { format: Encoding::Octahedral16x2, ..at(offset, stride) };
    positions(at(0, 20), Some(octahedral(12, 20)), Some(octahedral(16, 20))).unwrap();
    refused!(positions(octahedral(0, 12), None, None), InvalidArgument, "position format", "Octahedral16x2", "F32");
    refused!(positions(at(0, 20), Some(octahedral(14, 20)), None), Misaligned, "normal offset", "14");
    refused!(positions(at(0, 20), None, Some(octahedral(12, 18))), InvalidArgument, "position", "tangent");
    refused!(positions(at(0, 12), Some(octahedral(12, 2)), None), InvalidArgument, "position", "normal");
    for format in [Encoding::F16x4, Encoding::Snorm16x4, Encoding::Snorm8x4] {
        let normal = Attribute { format, ..at(12, 32) };
        refused!(positions(at(0, 32), Some(normal), None), InvalidArgument, "normal format", "F32 or Octahedral16x2");
    }
}

#[test]
fn quick_memory_that_is_too_small() {
    let mut instance = instance();
    instance.submit(&good()).unwrap();
    let mut tracker = Tracker::new();
    let mut bytes = [0xA5u8; 48];
    let place = Attribute { offset: 4, stride: 16, format: Encoding::F32 };
    let memory = VertexMemory::interleaved(&mut bytes[..47], place, None, None).unwrap();
    refused!(instance.deform(&mut tracker, memory, &Serial), BufferTooSmall, "position", "47", "48");
    assert!(bytes.iter().all(|b| *b == 0xA5), "something was written");
    let memory = VertexMemory::interleaved(&mut bytes, place, None, None).unwrap();
    assert_eq!(instance.deform(&mut tracker, memory, &Serial).unwrap().vertices_written, 3);
    tracker.invalidate(); // memory that is up to date is not checked
    let (mut positions, mut normals) = ([[0.0; 3]; 3], [[0.0; 3]; 2]);
    let memory = VertexMemory::separate(&mut positions, Some(&mut normals), None).unwrap();
    refused!(instance.deform(&mut tracker, memory, &Serial), BufferTooSmall, "normal", "24", "36");
    assert_eq!(positions, [[0.0; 3]; 3]);
    let (mut packed, memory) = ([[0; 2]; 2], VertexMemory::separate(&mut positions, None, None).unwrap());
    let memory = memory.with_octahedral_normals(&mut packed);
    refused!(instance.deform(&mut tracker, memory, &Serial), BufferTooSmall, "normal", "8", "12");
}

#[test]
fn quick_outputs_that_the_mesh_has_not() {
    let bare = MeshData { normals: None, tangents: None, triangles: Vec::new(), ..triangle() };
    let set = Arc::new(build(bare, vec![dent()]).unwrap());
    let mut instance = new(&set);
    let mut tracker = Tracker::new();
    let (mut positions, mut normals, mut tangents) = ([[0.0; 3]; 3], [[0.0; 3]; 3], [[0.0; 4]; 3]);
    let memory = VertexMemory::separate(&mut positions, Some(&mut normals), None).unwrap();
    refused!(instance.deform(&mut tracker, memory, &Serial), Unsupported, "normal");
    let memory = VertexMemory::separate(&mut positions, None, Some(&mut tangents)).unwrap();
    let error = refused!(instance.deform(&mut tracker, memory, &Serial), Unsupported, "tangent");
    assert_eq!(error.kind(), ErrorKind::Unsupported);
    instance.submit(&good()).unwrap();
    let memory = VertexMemory::separate(&mut positions, None, None).unwrap();
    instance.deform(&mut tracker, memory, &Serial).unwrap();
    assert!((positions[0][2] + 0.1).abs() < 1e-5);
}

#[test]
fn quick_tolerances_that_cannot_be_are_named() {
    let values = vec![[0.0, 0.0, -0.002], [0.0, 0.0, -0.1]];
    let positions = Deltas::Sparse { indices: vec![0, 1], values };
    let example = ExampleData { positions, contact: Some(Contact::Vertex(0)), ..dent() };
    let build = |tolerance| {
        let options = SetOptions { tolerance: Some(tolerance), ..SetOptions::default() };
        build_with(triangle(), vec![example.clone()], options)
    };
    assert!(build(0.001).is_ok() && build(0.005).is_ok());
    refused!(build(1e-12), ExampleMismatch, "0.1", "give a tolerance of at least");
    refused!(build(-1.0), InvalidArgument, "tolerance", "-1");
    refused!(build(f32::NAN), InvalidArgument, "tolerance", "NaN");
    // a tolerance in millimetres, given as metres, drops everything
    refused!(build(0.1), InvalidArgument, "tolerance is 0.1 m", "largest displacement", "0.1 mm?");
}

#[test]
fn quick_a_failed_deform_of_several_writes_none() {
    let (mut a, mut b) = (instance(), instance());
    a.submit(&good()).unwrap();
    a.fold();
    b.fold();
    let (mut first, mut second) = ([[7.0f32; 3]; 3], [[7.0f32; 3]; 2]);
    let (mut one, mut two) = (Tracker::new(), Tracker::new());
    let memory = VertexMemory::separate(&mut first, None, None).unwrap();
    let whole = crumple::DeformJob { lod: 0, instance: &a, tracker: &mut one, memory };
    let memory = VertexMemory::separate(&mut second, None, None).unwrap();
    let short = crumple::DeformJob { lod: 0, instance: &b, tracker: &mut two, memory };
    refused!(crumple::deform(&mut [whole, short], &Serial), BufferTooSmall, "24", "36");
    assert_eq!((first, second), ([[7.0; 3]; 3], [[7.0; 3]; 2]));
    let memory = VertexMemory::separate(&mut first, None, None).unwrap();
    assert_eq!(a.deform(&mut one, memory, &Serial).unwrap().vertices_written, 3);
}
