//! Depth limits and stiffness of single vertices. `widths.rs` has SIMD levels, `format.rs` files with limits,
//! `oracle_rules.rs` seams, and `bad_input.rs` wrong values.

mod scenes;

use crumple::glam::Vec3;
use crumple::*;
use scenes::{Dice, Output, cube, new, sheet, with};

const PLACES: [[f32; 3]; 2] = [[-0.2, -0.1, 0.0], [0.2, 0.1, 0.0]];

/// A set of this sheet with two dents of 0.2 m.
fn body(mesh: MeshData) -> std::sync::Arc<ExampleSet> {
    let upward = MeshData { normals: Some(vec![[0.0, 0.0, 1.0]; mesh.positions.len()]), ..mesh.clone() };
    let dents = PLACES.map(|place| scenes::bowl(&upward, scenes::nearest(&mesh, place), 0.2, 0.4));
    scenes::build(mesh, dents.to_vec(), SetOptions::default())
}

/// Positions and normals.
fn shown(body: &mut Instance) -> (Vec<Vec3>, Vec<Vec3>) {
    let Output { positions, normals, .. } = Output::fresh(body);
    (positions.into_iter().map(Vec3::from).collect(), normals.into_iter().map(Vec3::from).collect())
}

fn random_hit(dice: &mut Dice) -> Hit {
    let d = [dice.between(-0.3, 0.3), dice.between(-0.3, 0.3), dice.between(-0.6, 0.6)];
    Hit::displacement([dice.unit() - 0.5, dice.unit() - 0.5, 0.0], d)
}

const CAPSULE: ([f32; 3], [f32; 3], f32) = ([-0.4, -0.3, -0.12], [0.4, 0.2, -0.06], 0.05);

/// Distance from the capsule's surface, m; negative inside.
fn outside(p: Vec3) -> f64 {
    let (a, b) = (Vec3::from(CAPSULE.0).as_dvec3(), Vec3::from(CAPSULE.1).as_dvec3());
    let t = ((p.as_dvec3() - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
    p.as_dvec3().distance(a + (b - a) * t) - f64::from(CAPSULE.2)
}

fn kept_out() -> MeshData {
    let mut mesh = sheet(32);
    let solid = Solid::Capsule { a: CAPSULE.0, b: CAPSULE.1, radius: CAPSULE.2 };
    let report = mesh.keep_out(&[solid], &Serial).unwrap();
    assert_eq!((report.limited, report.inside), (33 * 33, 0));
    mesh
}

#[test]
fn no_vertex_enters_a_solid() {
    let mesh = kept_out();
    let mut dice = Dice::new(1);
    let mut entered_without = false;
    let classic = [Rule::MostDisplaced, Rule::Blend(0.3)].map(InstanceOptions::classic);
    for options in [InstanceOptions::default()].into_iter().chain(classic) {
        let (rule, options) = (options.rule, InstanceOptions { depth_limit: Some(1.0), ..options });
        let (mut free, mut held) = (with(&body(sheet(32)), options), with(&body(mesh.clone()), options));
        for _ in 0..100 {
            for _ in 0..200 {
                let hit = random_hit(&mut dice);
                free.submit(&hit).unwrap();
                held.submit(&hit).unwrap();
            }
            let least = shown(&mut held).0.into_iter().map(outside).fold(f64::INFINITY, f64::min);
            assert!(least >= 0.0, "{rule:?}: {least}");
            entered_without |= shown(&mut free).0.into_iter().any(|p| outside(p) < 0.0);
        }
    }
    assert!(entered_without);
}

#[test]
fn a_closed_mesh_keeps_out_as_its_solid() {
    let cube = cube(4);
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    cube.positions.iter().for_each(|p| (low, high) = (low.min(Vec3::from(*p)), high.max(Vec3::from(*p))));
    let solid = Solid::Mesh { positions: cube.positions, triangles: cube.triangles };
    let mut dice = Dice::new(7);
    let points: Vec<Vec3> =
        (0..500).map(|_| low + (high - low) * (2.0 * Vec3::new(dice.unit(), dice.unit(), dice.unit()) - 0.5)).collect();
    let mut mesh = MeshData { positions: points.iter().map(|p| p.to_array()).collect(), ..MeshData::default() };
    let report = mesh.keep_out(std::slice::from_ref(&solid), &Serial).unwrap();
    let mut inside = 0;
    for (p, limit) in points.iter().zip(mesh.depth_limits.unwrap()) {
        let distance = (low - *p).max(*p - high).max(Vec3::ZERO).length();
        assert!(limit <= distance && limit >= distance - 1e-5, "{p}: {limit} {distance}");
        inside += usize::from(distance == 0.0);
    }
    assert!(inside > 20 && report.inside == inside);
    let Solid::Mesh { positions, mut triangles } = solid else { panic!() };
    triangles.pop();
    let capsule = Solid::Capsule { a: [0.0; 3], b: [0.0; 3], radius: -1.0 };
    for (solid, why) in [(Solid::Mesh { positions, triangles }, "3 open edges"), (capsule, "radius of solid 0")] {
        let error = sheet(3).keep_out(&[solid], &Serial).unwrap_err().to_string();
        assert!(error.contains(why), "{error}");
    }
}

#[test]
fn normals_of_vertices_that_cannot_move_stay() {
    // Around each dent lie vertices whose displacement is 0 and whose normal turns, since their triangles tilt.
    for options in [InstanceOptions::default(), InstanceOptions::classic(Rule::MostDisplaced)] {
        let rule = options.rule;
        let mut turned_at_rest = 0;
        for held in [None, Some(true), Some(false)] {
            let mut mesh = sheet(32);
            let n = mesh.positions.len();
            match held {
                None => {}
                Some(true) => mesh.stiffness = Some((0..n).map(|v| ((v + 1) % 2) as f32).collect()),
                Some(false) => {
                    let limits = (0..n).map(|v| if v % 2 == 0 { 0.0 } else { f32::INFINITY });
                    mesh.depth_limits = Some(limits.collect());
                }
            }
            let mut body = with(&body(mesh.clone()), options);
            for place in PLACES {
                let outcome = body.submit(&Hit::displacement(place, [0.06, 0.0, -0.2])).unwrap();
                assert_eq!(outcome.status, HitStatus::Marked);
            }
            let (positions, normals) = shown(&mut body);
            for v in (0..n).step_by(2) {
                let at_rest = positions[v] == Vec3::from(mesh.positions[v]);
                if held.is_none() {
                    turned_at_rest += usize::from(at_rest && normals[v] != Vec3::Z);
                } else {
                    assert!(at_rest && normals[v] == Vec3::Z, "{rule:?}: {v} {}", normals[v]);
                }
            }
        }
        assert!(turned_at_rest > 10, "{turned_at_rest}");
    }
}

#[test]
fn skins_that_move_alike_hardly_cross() {
    // Two sheets, 1 mm apart, with the limits of one: both take the same displacements and the same limits.
    let mut mesh = kept_out();
    let n = mesh.positions.len();
    let second: Vec<[f32; 3]> = mesh.positions.iter().map(|p| [p[0], p[1], p[2] - 0.001]).collect();
    let second_triangles: Vec<[u32; 3]> = mesh.triangles.iter().map(|t| t.map(|v| v + n as u32)).collect();
    mesh.positions.extend(second);
    mesh.triangles.extend(second_triangles);
    (mesh.normals, mesh.tangents) = (None, None);
    let limits = mesh.depth_limits.clone().unwrap();
    mesh.depth_limits.as_mut().unwrap().extend(limits);
    let mut body = new(&body(mesh));
    let mut dice = Dice::new(5);
    for _ in 0..100 {
        for _ in 0..20 {
            body.submit(&random_hit(&mut dice)).unwrap();
        }
        let all = shown(&mut body).0;
        let closest = (0..n).map(|v| (all[v] - all[n + v]).z).fold(f32::INFINITY, f32::min);
        // Each skin has nodes of its own and follows those of the other too.
        assert!(closest > -0.01 * body.depth_limit(), "{closest}");
    }
}
