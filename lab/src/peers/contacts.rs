//! A real engine's knowledge, end to end: each hit again in rapier, with the body rigid and fixed. What its contact reports is
//! all that Crumple is told. The difference to the blow itself is the error that the engine adds.

use anyhow::Result;
use crumple::{Blow, Hit, InstanceOptions, Placement, SetOptions, Striker};
use rapier3d::prelude::*;

use crate::Options;
use crate::metric::{dot64, length, median, quantile, relative_l2, sub};
use crate::scene;
use crate::table::{Table, num};
use crate::truth::{self, Body, Impact, Truth};

/// Bodies whose strikers are balls. The box is struck by poles, too.
const BODIES: [(Truth, &str); 4] =
    [(Truth::Shots, "panel"), (Truth::Shots, "tube"), (Truth::Structure, "door"), (Truth::Steel, "hood")];
const RATES: [f32; 3] = [30.0, 60.0, 240.0];
const EXAMPLES: [usize; 2] = [8, 24];
const FRICTION: f32 = 0.4;
/// The ball's way before the touch, m, beside a part of a step that differs from hit to hit.
const RUN_UP: f32 = 0.1;
/// The impulses of this long after the touch are one contact, s.
const CONTACT: f32 = 0.05;
/// Above every dent, m.
const DEEP: f32 = 1.0;

/// What the engine reports of a contact.
struct Report {
    point: [f32; 3],
    /// Out of the body.
    normal: [f32; 3],
    /// On the body, N s.
    impulse: [f32; 3],
    /// Before the touch, m/s.
    velocity: [f32; 3],
}

pub fn run(options: &Options) -> Result<()> {
    let mut table = Table::new(&[
        "truth",
        "body",
        "test",
        "examples",
        "hz",
        "rel_l2_median",
        "rel_l2_p90",
        "told_blow_median",
        "told_blow_p90",
        "point_off_mm_median",
        "point_off_mm_p90",
        "normal_off_deg_median",
        "impulse_off_median",
        "missed",
        "n",
    ]);
    table.comment("command", "cargo xtask lab --only contacts");
    table.comment(
        "engine",
        format!("rapier3d {}, body fixed, ball with continuous collision detection", super::VERSION),
    );
    table.comment(
        "rel_l2",
        "Crumple is told the contact that the engine reports; a hit that it misses counts as no dent",
    );
    table.comment("told_blow", "Crumple is told the blow itself");
    for (truth, name) in BODIES {
        let body = Body::read(truth, name)?;
        let (test, hits) = if body.play.is_empty() { ("heldout", &body.heldout) } else { ("play", &body.play) };
        let hits: Vec<&Impact> = hits.iter().take(if options.quick { 4 } else { usize::MAX }).collect();
        let train = if body.train_free.is_empty() { body.train.clone() } else { body.train_free.clone() };
        let body = Body { train, ..body.clone() };
        for examples in EXAMPLES {
            let set = scene::set(&body, examples, Placement::Automatic, SetOptions::default())?;
            let ours = InstanceOptions { depth_limit: Some(DEEP), ..Default::default() };
            let error = |hit: Option<Hit>, impact: &Impact| -> Result<f64> {
                let Some(hit) = hit else { return Ok(1.0) };
                Ok(relative_l2(&scene::field_after(&set, &ours, &[hit])?, &impact.field))
            };
            let known: Vec<(&Impact, truth::Blow)> =
                hits.iter().filter_map(|i| i.blow.map(|b| (*i, b.in_engine()))).collect();
            let told = |(i, b): &(&Impact, truth::Blow)| error(Some(Hit::blow(i.point, scene::blow(b))), i);
            let told: Vec<f64> = known.iter().map(told).collect::<Result<_>>()?;
            for hz in RATES {
                let report = |(index, (i, b)): (usize, &(&Impact, truth::Blow))| strike(&body, i, b, hz, index);
                let reports: Vec<Option<Report>> = known.iter().enumerate().map(report).collect::<Result<_>>()?;
                let pairs = || known.iter().zip(&reports);
                let errors: Vec<f64> =
                    pairs().map(|((i, b), r)| error(r.as_ref().map(|r| hit(r, b)), i)).collect::<Result<_>>()?;
                let found = || pairs().filter_map(|((i, b), r)| Some((i, b, r.as_ref()?)));
                let off: Vec<f64> = found()
                    .map(|(i, _, r)| {
                        let d = sub(r.point, i.point);
                        1e3 * dot64(d, d).sqrt()
                    })
                    .collect();
                let turned: Vec<f64> = found().map(|(_, b, r)| angle_deg(b.normal, r.normal)).collect();
                let impulse: Vec<f64> =
                    found().map(|(_, b, r)| (length(r.impulse) / length(b.impulse) - 1.0).abs()).collect();
                let missed = reports.iter().filter(|r| r.is_none()).count();
                let numbers = [
                    median(&errors),
                    quantile(&errors, 0.9),
                    median(&told),
                    quantile(&told, 0.9),
                    median(&off),
                    quantile(&off, 0.9),
                    median(&turned),
                    median(&impulse),
                ];
                let head = [truth.name(), name, test].map(str::to_owned).into_iter();
                let head = head.chain([examples.to_string(), num(hz.into())]);
                table.row(head.chain(numbers.map(num)).chain([missed.to_string(), known.len().to_string()]))?;
            }
        }
        println!("contacts: {} {name}", truth.name());
    }
    println!("{}", table.write(&options.out, "told_engine.csv")?.display());
    Ok(())
}

/// What Crumple is told: the report, and the striker, which the game made.
fn hit(report: &Report, known: &truth::Blow) -> Hit {
    let striker = Striker { mass: Some(known.mass), velocity: Some(report.velocity), radius: Some(known.radius) };
    let blow = Blow { impulse: Some(report.impulse), duration: None, normal: Some(report.normal), striker };
    Hit::blow(report.point, blow)
}

fn angle_deg(a: [f32; 3], b: [f32; 3]) -> f64 {
    let cosine = dot64(a.map(f64::from), b.map(f64::from)) / (length(a) * length(b));
    cosine.clamp(-1.0, 1.0).acos().to_degrees()
}

/// Lets the ball fly at the fixed body. `None` if they never touch. The impulse is what the ball loses in momentum: the contact's
/// own sum has no friction.
fn strike(body: &Body, impact: &Impact, blow: &truth::Blow, hz: f32, index: usize) -> Result<Option<Report>> {
    let mut world = PhysicsWorld::new();
    world.gravity = Vector::ZERO;
    world.integration_parameters.dt = 1.0 / hz;
    let vertices: Vec<Vector> = body.vertices.iter().map(|p| vector(*p)).collect();
    let mesh = ColliderBuilder::trimesh_with_flags(vertices, body.triangles.clone(), TriMeshFlags::FIX_INTERNAL_EDGES)?;
    let (_, mesh) = world.insert(RigidBodyBuilder::fixed(), mesh.friction(FRICTION).restitution(0.0));
    let velocity = vector(blow.velocity);
    // The touch falls into another part of the step at each hit.
    let phase = (0.618 * index as f32).fract() * velocity.length() / hz;
    let centre = vector(impact.point) + vector(blow.normal) * blow.radius;
    let start = centre - vector(impact.direction) * (RUN_UP + phase);
    let ball = RigidBodyBuilder::dynamic().translation(start).linvel(velocity).ccd_enabled(true).can_sleep(false);
    let collider = ColliderBuilder::ball(blow.radius).mass(blow.mass).friction(FRICTION).restitution(0.0);
    let (ball, collider) = world.insert(ball, collider);
    let mut report: Option<Report> = None;
    let (mut since, mut flown) = (0.0, 0.0);
    let most = 4.0 * (RUN_UP + phase + blow.radius) / velocity.length() + 2.0 / hz;
    while since < CONTACT && (report.is_some() || flown < most) {
        let before = world.bodies[ball].linvel();
        world.step();
        flown += 1.0 / hz;
        let lost = (before - world.bodies[ball].linvel()) * blow.mass;
        if let Some(r) = &mut report {
            since += 1.0 / hz;
            r.impulse = (vector(r.impulse) + lost).to_array();
        } else if lost.length() > 1e-3 * blow.mass * before.length() {
            let Some(pair) = world.contact_pair(mesh, collider) else { continue };
            let Some((manifold, contact)) = pair.find_deepest_contact() else { continue };
            // The mesh is fixed at the origin, so its local points are the world's.
            let first = pair.collider1 == mesh;
            let point = if first { contact.local_p1 } else { contact.local_p2 };
            let normal = manifold.data.normal * if first { 1.0 } else { -1.0 };
            report = Some(Report {
                point: point.to_array(),
                normal: normal.to_array(),
                impulse: lost.to_array(),
                velocity: before.to_array(),
            });
        }
    }
    Ok(report)
}

fn vector(v: [f32; 3]) -> Vector {
    Vector::new(v[0], v[1], v[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_engine_reports_about_the_blow() {
        let body = Body::read(Truth::Shots, "panel").unwrap();
        for (index, impact) in body.train.iter().take(4).enumerate() {
            let blow = impact.blow.unwrap().in_engine();
            let report = strike(&body, impact, &blow, 240.0, index).unwrap().expect("a touch");
            let off = sub(report.point, impact.point);
            assert!(dot64(off, off).sqrt() < 0.02, "{off:?}");
            assert!(angle_deg(report.normal, blow.normal) < 5.0);
            assert!(angle_deg(report.velocity, blow.velocity) < 0.1);
            let along = |v: [f32; 3]| dot64(v.map(f64::from), blow.normal.map(f64::from));
            assert!((along(report.impulse) / along(blow.impulse) - 1.0).abs() < 0.1);
        }
    }
}
