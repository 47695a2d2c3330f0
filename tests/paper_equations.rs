//! The paper's equations 4.4-4.7 and figures 4.2 and 4.3, in cases small enough to work by hand.

mod scenes;

use std::sync::Arc;

use crumple::{
    Blow, Cause, Deltas, ExampleData, ExampleSet, Hit, HitStatus, Instance, InstanceOptions, MeshData, Outcome, Rule,
    Selection, SetOptions, Space, VertexMass,
};
use scenes::{build, positions, push};

/// A row of four vertices, 1 m apart, in two triangles.
fn row() -> MeshData {
    MeshData {
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, 1.0, 0.0]],
        normals: None,
        tangents: None,
        triangles: vec![[0, 1, 3], [1, 2, 3]],
        ..MeshData::default()
    }
}

fn example(name: &str, moved: &[(u32, [f32; 3])]) -> ExampleData {
    let (indices, values) = moved.iter().copied().unzip();
    ExampleData::new(name, Deltas::Sparse { indices, values })
}

const DEEP: usize = 0;
const SLANTED: usize = 1;
const SIDEWAYS: usize = 2;
const ELSEWHERE: usize = 3;

/// Three examples that move vertex 0, each in a different direction, and one that does not.
fn set_with(options: SetOptions) -> Arc<ExampleSet> {
    let examples = vec![
        example("deep", &[(0, [0.0, 0.0, -2.0]), (1, [0.0, 0.0, -1.0])]),
        example("slanted", &[(0, [1.0, 0.0, -1.0])]),
        example("sideways", &[(0, [1.0, 0.0, 0.0])]),
        example("elsewhere", &[(2, [0.0, 1.0, 0.0])]),
    ];
    build(row(), examples, options)
}

fn set() -> Arc<ExampleSet> {
    set_with(SetOptions::default())
}

fn classic_instance(set: &Arc<ExampleSet>, rule: Rule, selection: Selection) -> Instance {
    Instance::new(set.clone(), InstanceOptions { rule, selection, ..InstanceOptions::default() }).unwrap()
}

fn hit(displacement: [f32; 3]) -> Hit {
    push([0.0, 0.1, 0.0], displacement)
}

#[track_caller]
fn assert_near(a: [f32; 3], b: [f32; 3]) {
    assert!((0..3).all(|k| (a[k] - b[k]).abs() <= 1e-6), "{a:?} is not {b:?}");
}

fn weight(outcome: &Outcome) -> (usize, f32) {
    let chosen = outcome.classic.expect("an example was chosen");
    (chosen.example as usize, chosen.weight)
}

#[test]
fn quick_equation_4_4_impulse_times_duration_over_mass() {
    let instance = classic_instance(&set(), Rule::MostDisplaced, Selection::Classic);
    let cause = Cause::Impulse { blow: Blow::of_impulse([0.0, 0.0, -10.0], 0.02), mass: Some(0.5) };
    let outcome = instance.preview(&Hit { point: [0.0; 3], cause, space: Space::Local, contact: None }).unwrap();
    assert_near(outcome.target, [0.0, 0.0, -0.4]);
}

#[test]
fn quick_the_mass_is_the_hits_own_else_the_vertex_s() {
    let cause = |mass| Cause::Impulse { blow: Blow::of_impulse([0.0, 0.0, -10.0], 0.02), mass };
    let target = |set: &Arc<ExampleSet>, mass| {
        let instance = classic_instance(set, Rule::MostDisplaced, Selection::Classic);
        instance
            .preview(&Hit { point: [0.0; 3], cause: cause(mass), space: Space::Local, contact: None })
            .unwrap()
            .target
    };
    let uniform = set_with(SetOptions { mass: VertexMass::Uniform(4.0), ..SetOptions::default() });
    assert_near(target(&uniform, None), [0.0, 0.0, -0.05]);
    assert_near(target(&uniform, Some(2.0)), [0.0, 0.0, -0.1]);
    let each = set_with(SetOptions { mass: VertexMass::PerVertex(vec![8.0, 1.0, 1.0, 1.0]), ..SetOptions::default() });
    assert_near(target(&each, None), [0.0, 0.0, -0.025]);
}

#[test]
fn quick_equation_4_7_the_papers_own_numbers() {
    // "If we need a displacement that is 0.8 meters but in example that vertex is displaced 2.0 meters ... 0.4"
    let mut instance = classic_instance(&set(), Rule::MostDisplaced, Selection::Classic);
    let outcome = instance.submit(&hit([0.0, 0.0, -0.8])).unwrap();
    let (chosen, w) = weight(&outcome);
    assert_eq!(chosen, DEEP);
    assert!((w - 0.4).abs() < 1e-6, "{w}");
    let moved = positions(&mut instance).0;
    assert_near(moved[0], [0.0, 0.0, -0.8]);
    assert_near(moved[1], [1.0, 0.0, -0.4]);
    assert_near(moved[2], [2.0, 0.0, 0.0]);
    assert_near(moved[3], [1.0, 1.0, 0.0]);
}

#[test]
fn quick_figure_4_2_takes_the_best_direction_not_the_best_size() {
    let instance = classic_instance(&set(), Rule::MostDisplaced, Selection::Classic);
    let chosen = |t| weight(&instance.preview(&hit(t)).unwrap()).0;
    assert_eq!(chosen([0.0, 0.0, -0.1]), DEEP);
    assert_eq!(chosen([0.7, 0.0, -0.7]), SLANTED);
    assert_eq!(chosen([0.9, 0.1, -0.2]), SIDEWAYS);
    // halfway between slanted and deep in angle, but a little nearer to deep
    assert_eq!(chosen([0.40, 0.0, -1.0]), DEEP);
    assert_eq!(chosen([0.43, 0.0, -1.0]), SLANTED);
}

#[test]
fn quick_figure_4_2_only_examples_that_affect_the_vertex() {
    let instance = classic_instance(&set(), Rule::MostDisplaced, Selection::Classic);
    // exactly along the displacement of vertex 2 by `elsewhere`, which cannot be chosen at vertex 0
    let outcome = instance.preview(&hit([0.1, 1.0, 0.0])).unwrap();
    assert_ne!(weight(&outcome).0, ELSEWHERE);
    let outcome = instance.preview(&push([2.0, -0.1, 0.0], [0.0, 0.5, 0.0])).unwrap();
    assert_eq!(weight(&outcome), (ELSEWHERE, 0.5));
    // no example moves vertex 3
    let outcome = instance.preview(&push([1.0, 1.1, 0.0], [0.0, 0.5, 0.0])).unwrap();
    assert_eq!(outcome.status, HitStatus::NothingReaches);
    assert_near(outcome.shortfall(), [0.0, 0.5, 0.0]);
}

#[test]
fn quick_the_first_example_wins_where_cosines_are_equal() {
    let twins = vec![
        example("first", &[(0, [0.0, 0.0, -1.0])]),
        example("second", &[(0, [0.0, 0.0, -2.0])]),
        example("third", &[(0, [0.0, 0.0, -1.0])]),
    ];
    let set = build(row(), twins, SetOptions::default());
    let instance = classic_instance(&set, Rule::MostDisplaced, Selection::Classic);
    assert_eq!(weight(&instance.preview(&hit([0.0, 0.0, -0.5])).unwrap()), (0, 0.5));
}

#[test]
fn quick_the_weight_is_clamped_to_one_unless_asked_otherwise() {
    let set = set();
    let clamped = classic_instance(&set, Rule::MostDisplaced, Selection::Classic);
    let outcome = clamped.preview(&hit([9.0, 0.0, -9.0])).unwrap();
    assert_eq!(weight(&outcome), (SLANTED, 1.0));
    assert!(outcome.clamped);
    let free = classic_instance(&set, Rule::MostDisplaced, Selection::ClassicUnclamped);
    let (chosen, w) = weight(&free.preview(&hit([9.0, 0.0, -9.0])).unwrap());
    assert_eq!(chosen, SLANTED);
    assert!((w - 9.0).abs() < 1e-5, "{w}");
}

/// Figure 4.3 worked by hand for three hits at vertex 0 (base at the origin).
///
/// 1. deep, w = 0.4: r = (0, 0, -0.8); longer than 0, so cur = r.
/// 2. slanted, w = 0.5: r = lerp((0, 0, -0.8), (1, 0, -1), 0.5) = (0.5, 0, -0.9); 1.06 >= 0.64, so cur = r.
/// 3. sideways, w = 0.5: r = lerp((0.5, 0, -0.9), (1, 0, 0), 0.5) = (0.75, 0, -0.45); 0.765 < 1.06, so cur stays (most displaced) or
///    becomes lerp((0.5, 0, -0.9), r, 0.25) = (0.5625, 0, -0.7875) (blend, k = 0.25).
fn three_hits(rule: Rule) -> Vec<[f32; 3]> {
    let set = set();
    let mut instance = classic_instance(&set, rule, Selection::Classic);
    let mut steps = Vec::new();
    for t in [[0.0, 0.0, -0.8], [0.5, 0.0, -0.5], [0.5, 0.0, 0.0]] {
        instance.submit(&hit(t)).unwrap();
        steps.push(positions(&mut instance).0[0]);
    }
    steps
}

#[test]
fn quick_figure_4_3_step_by_step() {
    for (rule, third) in [
        (Rule::MostDisplaced, [0.5, 0.0, -0.9]),
        (Rule::Blend(0.0), [0.5, 0.0, -0.9]),
        (Rule::Blend(0.25), [0.5625, 0.0, -0.7875]),
    ] {
        let steps = three_hits(rule);
        assert_near(steps[0], [0.0, 0.0, -0.8]);
        assert_near(steps[1], [0.5, 0.0, -0.9]);
        assert_near(steps[2], third);
    }
}

#[test]
fn quick_equal_lengths_count_as_most_displaced() {
    // "if LengthSq(resultDisp) >= LengthSq(curDisp)": at w = 1 the result is the example itself, whatever was there
    // before
    let examples = vec![example("down", &[(0, [0.0, 0.0, -1.0])]), example("up", &[(0, [0.0, 0.0, 1.0])])];
    let set = build(row(), examples, SetOptions::default());
    let mut instance = classic_instance(&set, Rule::MostDisplaced, Selection::Classic);
    instance.submit(&hit([0.0, 0.0, -1.0])).unwrap();
    assert_near(positions(&mut instance).0[0], [0.0, 0.0, -1.0]);
    instance.submit(&hit([0.0, 0.0, 1.0])).unwrap();
    assert_near(positions(&mut instance).0[0], [0.0, 0.0, 1.0]);
}

#[test]
fn quick_a_vertex_whose_normal_alone_changes_is_not_blended() {
    // only the first example moves vertex 1; the second dents vertex 0 beside it, which turns the normal of vertex 1
    let examples = vec![example("right", &[(1, [0.0, 0.0, -1.0])]), example("left", &[(0, [0.0, 0.0, -1.0])])];
    let set = build(row(), examples, SetOptions::default());
    assert_ne!(set.examples()[1].normal_delta(1).to_array(), [0.0; 3]);
    let mut instance = classic_instance(&set, Rule::Blend(0.5), Selection::Classic);
    instance.submit(&push([1.0, 0.0, 0.0], [0.0, 0.0, -1.0])).unwrap();
    assert_near(positions(&mut instance).0[1], [1.0, 0.0, -1.0]);
    instance.submit(&hit([0.0, 0.0, -1.0])).unwrap();
    assert_near(positions(&mut instance).0[1], [1.0, 0.0, -1.0]);
}
