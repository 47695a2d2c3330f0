//! The paper's equations 4.4-4.7 and figures 4.2 and 4.3, in cases small enough to work by hand. `oracle_rules.rs` has them at random.

mod scenes;

use std::sync::Arc;

use crumple::{
    Deltas, ExampleData, ExampleSet, Hit, Instance, InstanceOptions, MeshData, Rule, SetOptions, VertexMass,
};
use scenes::{build, positions, push, with};

/// A row of four vertices, 1 m apart, in two triangles, with these examples.
fn row(examples: &[&[(u32, [f32; 3])]], options: SetOptions) -> Arc<ExampleSet> {
    let mesh = MeshData {
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 3], [1, 2, 3]],
        ..MeshData::default()
    };
    let example = |moved: &&[(u32, [f32; 3])]| {
        let (indices, values) = moved.iter().copied().unzip();
        ExampleData::new("an example", Deltas::Sparse { indices, values })
    };
    build(mesh, examples.iter().map(example).collect(), options)
}

fn classic(set: &Arc<ExampleSet>, rule: Rule) -> Instance {
    with(set, InstanceOptions::classic(rule))
}

/// Hits vertex 0. Returns the chosen example with its weight, and where the vertex is then.
fn hit(body: &mut Instance, displacement: [f32; 3]) -> (u32, f32, [f32; 3]) {
    let chosen = body.submit(&push([0.0, 0.1, 0.0], displacement)).unwrap().classic.expect("an example was chosen");
    (chosen.example, chosen.weight, positions(body).0[0])
}

#[track_caller]
fn assert_near(a: [f32; 3], b: [f32; 3]) {
    assert!((0..3).all(|k| (a[k] - b[k]).abs() <= 1e-6), "{a:?} is not {b:?}");
}

#[test]
fn quick_equation_4_4_impulse_times_duration_over_mass() {
    let target = |vertex_mass, mass| {
        let options = SetOptions { mass: vertex_mass, ..SetOptions::default() };
        let body = classic(&row(&[&[(0, [0.0, 0.0, -2.0])]], options), Rule::MostDisplaced);
        body.preview(&Hit::impulse([0.0; 3], [0.0, 0.0, -10.0], 0.02, mass)).unwrap().target
    };
    // The mass is the hit's own, else the vertex's.
    let each = VertexMass::PerVertex(vec![8.0, 1.0, 1.0, 1.0]);
    assert_near(target(VertexMass::Uniform(4.0), None), [0.0, 0.0, -0.05]);
    assert_near(target(VertexMass::Uniform(4.0), Some(0.5)), [0.0, 0.0, -0.4]);
    assert_near(target(each, None), [0.0, 0.0, -0.025]);
}

/// Three hits at vertex 0 (base at the origin):
///
/// 1. "If we need a displacement that is 0.8 meters but in example that vertex is displaced 2.0 meters ... 0.4": the first example, w = 0.4.
///    r = (0, 0, -0.8); longer than 0, so cur = r.
/// 2. The second, w = 0.5: r = lerp((0, 0, -0.8), (1, 0, -1), 0.5) = (0.5, 0, -0.9); 1.06 >= 0.64, so cur = r.
/// 3. The third, w = 0.5: r = lerp((0.5, 0, -0.9), (1, 0, 0), 0.5) = (0.75, 0, -0.45); 0.765 < 1.06, so cur stays (most displaced) or
///    becomes lerp((0.5, 0, -0.9), r, 0.25) = (0.5625, 0, -0.7875) (blend, k = 0.25).
#[test]
fn quick_figure_4_3_step_by_step() {
    let set = row(
        &[&[(0, [0.0, 0.0, -2.0]), (1, [0.0, 0.0, -1.0])], &[(0, [1.0, 0.0, -1.0])], &[(0, [1.0, 0.0, 0.0])]],
        SetOptions::default(),
    );
    for (rule, third) in [
        (Rule::MostDisplaced, [0.5, 0.0, -0.9]),
        (Rule::Blend(0.0), [0.5, 0.0, -0.9]),
        (Rule::Blend(0.25), [0.5625, 0.0, -0.7875]),
    ] {
        let mut body = classic(&set, rule);
        for (target, example, weight, at) in [
            ([0.0, 0.0, -0.8], 0, 0.4, [0.0, 0.0, -0.8]),
            ([0.5, 0.0, -0.5], 1, 0.5, [0.5, 0.0, -0.9]),
            ([0.5, 0.0, 0.0], 2, 0.5, third),
        ] {
            let (chosen, w, shown) = hit(&mut body, target);
            assert!(chosen == example && (w - weight).abs() < 1e-6, "{chosen} with {w}");
            assert_near(shown, at);
        }
        assert_near(positions(&mut body).0[1], [1.0, 0.0, -0.4]);
    }
}

/// What random hits do not meet. "if LengthSq(resultDisp) >= LengthSq(curDisp)": at w = 1 the result is the example itself, whatever was there
/// before.
#[test]
fn quick_the_first_of_equal_cosines_and_the_last_of_equal_lengths_win() {
    let down = |z| [(0, [0.0, 0.0, z])];
    let set = row(&[&down(-1.0), &down(-2.0), &down(-1.0), &down(1.0)], SetOptions::default());
    let mut body = classic(&set, Rule::MostDisplaced);
    assert_eq!(hit(&mut body, [0.0, 0.0, -1.0]), (0, 1.0, [0.0, 0.0, -1.0]));
    assert_eq!(hit(&mut body, [0.0, 0.0, 1.0]), (3, 1.0, [0.0, 0.0, 1.0]));
}
