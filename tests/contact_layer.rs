//! Contact points become blows: the points of a manifold are one, the steps of a touch are one, what rests is none, and
//! two bodies share.

mod scenes;

use std::sync::Arc;

use crumple::glam::{Mat4, Quat};
use crumple::{
    Blow, ContactLayer, ContactOptions, ContactPoint, ContactReport, Error, ErrorKind, ExampleData, ExampleSet, Hit,
    Impulses, Instance, InstanceOptions, Rule, SetOptions, Striker,
};
use proptest::prelude::*;
use scenes::{Dice, build, dented, displacements, new};

const STEP: f32 = 1.0 / 60.0;
const MASS: f32 = 8.0;

/// The blow of a body of this mass from above.
fn blow(speed: f32, mass: f32) -> Blow {
    let velocity = [0.0, 0.0, -speed];
    let striker = Striker { mass: Some(mass), velocity: Some(velocity), ..Striker::default() };
    Blow { impulse: Some(velocity.map(|v| mass * v)), normal: Some([0.0, 0.0, 1.0]), striker, ..Blow::default() }
}

/// A sheet whose examples know their blows: a striker of 8 kg at 100 m/s for each metre of `softness` times the depth.
fn set(softness: f32) -> Arc<ExampleSet> {
    let mesh = scenes::sheet(24);
    let mut dice = Dice::new(3);
    let place = |x: f32, y: f32| scenes::nearest(&mesh, [x, y, 0.0]);
    let places = [place(0.0, 0.0), place(-0.25, 0.2), place(0.25, -0.2), place(-0.2, -0.25), place(0.2, 0.25)];
    let examples = places.map(|v| {
        let depth = dice.between(0.03, 0.06);
        ExampleData { blow: blow(100.0 * depth / softness, MASS), ..scenes::bowl(&mesh, v, depth, 0.25) }
    });
    build(mesh, examples.to_vec(), SetOptions { depth_limit: Some(1.0), ..SetOptions::default() })
}

fn layer(options: ContactOptions) -> ContactLayer {
    ContactLayer::new(options).unwrap()
}

fn default() -> ContactLayer {
    layer(ContactOptions::default())
}

/// A point on the sheet, struck from above by a free body of 8 kg.
fn point(body: &Instance, at: [f32; 2], speed: f32, impulse: Option<f32>) -> ContactPoint {
    let mut p = ContactPoint::new(7, [Some(body.inbox().clone()), None], [at[0], at[1], 0.0], [0.0, 0.0, 1.0]);
    p.velocity = Some([0.0, 0.0, -speed]);
    p.masses = [Some(f32::INFINITY), Some(MASS)];
    p.impulse = impulse;
    p
}

fn depth(body: &mut Instance) -> f32 {
    displacements(body).iter().map(|d| d.length()).fold(0.0, f32::max)
}

fn same(a: f32, b: f32, within: f32) -> bool {
    (a - b).abs() <= within * a.abs().max(b.abs())
}

/// A step of the physics with these points.
fn stepped(contacts: &ContactLayer, points: &[ContactPoint]) -> ContactReport {
    contacts.report(points).unwrap();
    contacts.step(STEP).unwrap()
}

/// A point of a step: its place on the sheet, its speed and its impulse.
type Touch = ([f32; 2], f32, Option<f32>);

/// A point in the middle.
fn middle(speed: f32, impulse: f32) -> [Touch; 1] {
    [([0.0; 2], speed, Some(impulse))]
}

/// A body and its layer after steps of these points.
fn struck(
    set: &Arc<ExampleSet>,
    options: ContactOptions,
    seconds: f32,
    steps: &[impl AsRef<[Touch]>],
) -> (Instance, ContactLayer) {
    let (body, contacts) = (new(set), layer(options));
    for step in steps {
        let points = step.as_ref().iter().map(|(at, speed, impulse)| point(&body, *at, *speed, *impulse));
        contacts.report(&points.collect::<Vec<_>>()).unwrap();
        assert_eq!(contacts.step(seconds).unwrap().refusal, None);
    }
    (body, contacts)
}

/// The depth that they leave at 60 Hz.
fn left(set: &Arc<ExampleSet>, steps: &[impl AsRef<[Touch]>]) -> f32 {
    depth(&mut struck(set, ContactOptions::default(), STEP, steps).0)
}

/// The depth that a point in the middle leaves after a change.
fn left_by(set: &Arc<ExampleSet>, gain: f32, speed: f32, impulse: f32, change: impl Fn(&mut ContactPoint)) -> f32 {
    let (mut body, contacts) = (new(set), layer(ContactOptions { gain, ..Default::default() }));
    let mut p = point(&body, [0.0; 2], speed, Some(impulse));
    change(&mut p);
    assert_eq!(stepped(&contacts, &[p]).refusal, None);
    depth(&mut body)
}

/// The dent of one whole blow, told without the layer.
fn told(set: &Arc<ExampleSet>, speed: f32, mass: f32) -> f32 {
    depth(&mut dented(set, InstanceOptions::default(), &[Hit::blow([0.0; 3], blow(speed, mass))]))
}

#[test]
fn quick_a_contact_leaves_what_the_blow_leaves() {
    let set = set(1.0);
    let expected = told(&set, 5.0, MASS);
    assert!(expected > 0.02, "{expected}");
    // Each row of the table of what is known; last two free bodies, with their reduced mass.
    type Change = fn(&mut ContactPoint);
    let rows: [(Change, f32); 7] = [
        (|_| (), 1e-4),
        (|p| p.masses = [None; 2], 1e-4),
        (|p| p.velocity = None, 1e-4),
        (|p| p.impulse = None, 1e-4),
        (|p| (p.impulse, p.inverse_mass, p.masses) = (None, Some(1.0 / MASS), [None; 2]), 1e-4),
        (|p| (p.velocity, p.masses) = (None, [None; 2]), 0.25), // an impulse alone
        (|p| (p.impulse, p.masses) = (None, [Some(2.0 * MASS), Some(2.0 * MASS)]), 1e-4),
    ];
    for (row, (change, within)) in rows.into_iter().enumerate() {
        let got = left_by(&set, 1.0, 5.0, 40.0, change);
        assert!(same(got, expected, within), "row {row}: {got} instead of {expected}");
    }
}

#[test]
fn quick_the_points_of_a_manifold_are_one_blow() {
    let set = set(1.0);
    let expected = told(&set, 5.0, MASS);
    let corners = [[-0.02, -0.02], [0.02, -0.02], [-0.02, 0.02], [0.02, 0.02]];
    for (impulses, share) in [
        (Impulses::PerPoint, Some(10.0)),
        (Impulses::WholeAtEveryPoint, Some(40.0)),
        (Impulses::PerPoint, None),
        (Impulses::ZeroIsUnknown, Some(0.0)),
    ] {
        let options = ContactOptions { impulses, ..ContactOptions::default() };
        let got = depth(&mut struck(&set, options, STEP, &[corners.map(|at| (at, 5.0, share))]).0);
        assert!(same(got, expected, 1e-3), "{impulses:?} {share:?}: {got} instead of {expected}");
    }
    // Uneven shares move the centre, not the energy.
    let uneven = [0, 1, 2, 3].map(|i| (corners[i], 5.0, Some([25.0, 5.0, 5.0, 5.0][i])));
    assert!(same(left(&set, &[uneven]), expected, 0.1));
}

#[test]
fn quick_points_further_apart_than_a_dent_share_the_energy() {
    let set = set(1.0);
    let row: Vec<Touch> = (-4..=4).map(|i| ([0.1 * i as f32, 0.0], 5.0, Some(10.0))).collect();
    let options = ContactOptions { dent_radius: Some(0.15), ..Default::default() };
    let (mut body, contacts) = struck(&set, options, STEP, &[row]);
    let report = contacts.totals();
    assert!((3..=5).contains(&report.begun), "{report:?}");
    assert!(report.hits >= report.begun);
    assert!(depth(&mut body) < told(&set, 5.0, 90.0 / 5.0));
    assert!(body.marks().unwrap().len() >= 3);
}

#[test]
fn quick_the_steps_of_a_touch_are_one_dent() {
    let set = set(1.0);
    let expected = told(&set, 5.0, MASS);
    for parts in [1usize, 2, 4, 8, 20] {
        let slower = |i: usize| middle(5.0 * (1.0 - i as f32 / parts as f32), 40.0 / parts as f32);
        let steps: Vec<_> = (0..parts).map(slower).collect();
        let (mut body, contacts) = struck(&set, ContactOptions::default(), 0.08 / parts as f32, &steps);
        assert_eq!(body.marks().unwrap().len(), 1, "{parts} parts");
        let got = depth(&mut body);
        assert!(same(got, expected, 0.05), "{parts} parts: {got} instead of {expected}");
        assert_eq!(contacts.totals().begun, 1);
    }
    // The guess that the bodies stop each other counts once.
    assert!(same(left(&set, &[5.0, 4.0, 2.0, 1.0].map(|speed| [([0.0; 2], speed, None)])), expected, 1e-3));
    // Known velocities after the step add up to the same.
    let (mut body, contacts) = (new(&set), default());
    for (before, after) in [(5.0, 3.0), (3.0, 0.5), (0.5, 0.0)] {
        let mut p = point(&body, [0.0; 2], before, None);
        p.velocity_after = Some([0.0, 0.0, -after]);
        stepped(&contacts, &[p]);
    }
    assert!(same(depth(&mut body), expected, 1e-3));
}

#[test]
fn quick_a_touch_ends_by_separation_or_by_time() {
    let set = set(1.0);
    let (body, contacts) = (new(&set), default());
    let strike = |speed: f32| contacts.report(&[point(&body, [0.0; 2], speed, Some(10.0))]).unwrap();
    strike(5.0);
    assert_eq!(contacts.step(STEP).unwrap().open, 1);
    let ended: Vec<u64> = (0..4).map(|_| contacts.step(STEP).unwrap().ended).collect();
    assert_eq!(ended, [0, 0, 1, 0], "0.05 s without a point");
    // A pair that never separates ends by time, and then begins anew.
    let mut begun = 0;
    for _ in 0..60 {
        strike(5.0);
        let report = contacts.step(STEP).unwrap();
        assert!(report.open <= 1);
        begun += report.begun;
    }
    assert!((8..=10).contains(&begun), "{begun} in a second");
    // A much faster blow at the same place is another.
    let (_body, contacts) = struck(&set, Default::default(), STEP, &[middle(1.0, 10.0), middle(6.0, 10.0)]);
    assert_eq!(contacts.totals().begun, 2);
}

#[test]
fn quick_a_harder_impulse_dents_deeper() {
    let set = set(1.0);
    let factors = [1.0, 2.0, 4.0, 1000.0];
    let depths = factors.map(|factor| left(&set, &[middle(3.0, 24.0 * factor)]));
    assert!(depths.is_sorted_by(|a, b| b > &(a * 1.2)), "{depths:?}");
    // By the learned law: as a striker of so many times the mass.
    for (depth, factor) in depths.into_iter().zip(factors) {
        let expected = told(&set, 3.0, MASS * factor);
        assert!(same(depth, expected, 1e-3), "times {factor}: {depth} m instead of {expected} m");
    }
    // A gain is a factor of the impulse.
    let gain = |gain: f32, of_point: f32| left_by(&set, gain, 3.0, 24.0, |p| p.gain = of_point);
    assert!(same(gain(2.0, 2.0), depths[2], 1e-4));
    assert_eq!((gain(0.0, 1.0), gain(1.0, 0.0)), (0.0, 0.0));
}

#[test]
fn quick_what_a_solver_pushes_apart_is_no_blow() {
    let set = set(1.0);
    let expected = told(&set, 5.0, MASS);
    let got = |factor: f32| left(&set, &[[[-0.02, -0.02], [0.02, 0.02]].map(|at| (at, 5.0, Some(20.0 * factor)))]);
    // 40 N s stop the striker. Solvers push bodies apart that sank into each other.
    for factor in [1.0, 1.04, 1.2, 1.25] {
        assert!(same(got(factor), expected, 1e-3), "{factor} times what stops it: {} m", got(factor));
    }
    // Nor is what it pushes aside at points that do not approach.
    let (mut body, contacts) = (new(&set), default());
    let mut side = point(&body, [0.02, 0.0], 0.1, Some(30.0));
    (side.normal, side.velocity) = ([1.0, 0.0, 0.0], Some([0.0, 0.0, -5.0]));
    stepped(&contacts, &[point(&body, [0.0; 2], 5.0, Some(1.2 * 40.0)), side]);
    assert!(same(depth(&mut body), expected, 1e-3), "{} m instead of {expected} m", depth(&mut body));
    let factors = [1.25, 1.3, 1.5, 1.7, 1.75, 2.0];
    assert!(factors.map(got).is_sorted_by(|a, b| a < b), "{:?}", factors.map(got));
    assert!(same(got(2.0), told(&set, 5.0, 2.0 * MASS), 1e-3));
}

#[test]
fn quick_the_steps_of_a_touch_bring_no_more_than_the_approach() {
    let set = set(1.0);
    let expected = told(&set, 5.0, MASS);
    let first = middle(5.0, 30.0);
    // 40 N s stop the striker, in however many steps, and the solver pushes on.
    let got = left(&set, &[first, middle(2.0, 10.0), middle(1.0, 15.0)]);
    assert!(same(got, expected, 1e-3), "{got} m instead of {expected} m");
    let got = left(&set, &[middle(5.0, 35.0), middle(5.5, 15.0)]);
    assert!(same(got, told(&set, 5.5, 40.0 / 5.5 * (5.0 / 5.5)), 0.05), "{got} m");
    // A place further off gets what is left.
    let both = |second: f32| {
        let (mut body, contacts) = struck(&set, Default::default(), STEP, &[first, [([0.3, 0.0], 4.0, Some(second))]]);
        (depth(&mut body), contacts.totals())
    };
    let (deep, totals) = both(12.5);
    assert_eq!((totals.begun, totals.hits), (2, 2));
    assert_eq!(both(50.0 / 4.0 * 1.5).0, deep, "50 J of the 100 were left");
    // What is pushed as hard in one step counts, and so does a blow after the bodies separated.
    let hard = left(&set, &[first, middle(5.0, 120.0)]);
    assert!(hard > 1.2 * expected, "{hard} m");
    let again = left(&set, &[&first[..], &[], &[], &[], &[], &first]);
    let once = left(&set, &[first]);
    assert!(again > 1.2 * once, "{again} m after {once} m");
}

/// Bullet's continuous collision detection stops a striker in two steps. At 30 Hz the second may be as slow as gravity makes a body that
/// rests.
#[test]
fn quick_the_rest_of_a_blow_counts_however_slow_it_is() {
    let set = set(1.0);
    for hz in [30.0, 60.0, 240.0] {
        let run = |steps: &[[Touch; 1]]| depth(&mut struck(&set, Default::default(), 1.0 / hz, steps).0);
        let expected = told(&set, 2.0, MASS);
        let got = run(&[middle(2.0, 1.5 * MASS), middle(0.5, 0.5 * MASS)]);
        assert!(same(got, expected, 1e-3), "{hz} Hz: {got} m instead of {expected} m");
        // The weight of a body that lies there adds nothing to what stopped it.
        let mut steps = vec![middle(9.81 / hz, MASS * 9.81 / hz); 61];
        steps[0] = middle(2.0, 2.0 * MASS);
        let rests = run(&steps);
        assert!(same(rests, expected, 1e-3), "{hz} Hz: {rests} m instead of {expected} m");
    }
}

#[test]
fn quick_what_is_slow_or_weak_or_separates_leaves_nothing() {
    let set = set(1.0);
    let count = |speed: f32, impulse: f32| {
        let (mut body, contacts) = struck(&set, Default::default(), STEP, &[middle(speed, impulse); 600]);
        assert!(body.marks().unwrap().is_empty(), "{speed} m/s, {impulse} N s");
        contacts.totals()
    };
    // The slowest example came at about 3 m/s.
    assert_eq!(count(0.4, 1000.0).slow, 600, "rests under a large weight");
    assert_eq!(count(-3.0, 10.0).separating, 600);
    let weak = count(3.0, 0.01);
    assert!(weak.weak > 50 && weak.hits == 0, "{weak:?}");
}

/// Two sheets face to face: the lower one and its image, turned over.
fn face_to_face(lower: &Arc<ExampleSet>, upper: &Arc<ExampleSet>) -> [Instance; 2] {
    let over = new(upper);
    over.set_transform(Mat4::from_quat(Quat::from_rotation_x(std::f32::consts::PI))).unwrap();
    [new(lower), over]
}

fn head_on(sets: [&Arc<ExampleSet>; 2], masses: [f32; 2], speed: f32) -> [f32; 2] {
    let [mut a, mut b] = face_to_face(sets[0], sets[1]);
    let contacts = default();
    let mut p = point(&a, [0.0; 2], speed, None);
    p.bodies[1] = Some(b.inbox().clone());
    p.masses = masses.map(Some);
    contacts.report(&[p]).unwrap();
    assert_eq!(contacts.step(STEP).unwrap().hits, 2);
    [depth(&mut a), depth(&mut b)]
}

#[test]
fn quick_two_bodies_share_by_how_they_give_way() {
    let (set, soft) = (set(1.0), set(3.0));
    // Two equal bodies at 5 m/s each are as each against a wall.
    let [a, b] = head_on([&set, &set], [MASS, MASS], 10.0);
    assert!(same(a, b, 1e-3), "{a} and {b}");
    assert!(same(a, told(&set, 5.0, MASS), 1e-3), "{a}");
    // The softer one takes more, whichever comes first, and the other less than against its like.
    let [hard, softer] = head_on([&set, &soft], [MASS, 100.0], 10.0);
    let [softer_too, hard_too] = head_on([&soft, &set], [MASS, 100.0], 10.0);
    assert!(softer > 1.2 * hard, "{softer} and {hard}");
    assert!(same(hard, hard_too, 1e-3) && same(softer, softer_too, 1e-3));
    // A body that does not dent leaves all to the other.
    let rigid = left_by(&set, 1.0, 10.0, 0.0, |p| (p.impulse, p.masses) = (None, [Some(MASS), Some(MASS)]));
    assert!(same(rigid, told(&set, 10.0, MASS / 2.0), 1e-3));
}

#[test]
fn quick_wrong_points_are_refused_whole_with_name_and_value() {
    let set = set(1.0);
    let (body, contacts) = (new(&set), default());
    let classic = Instance::new(set.clone(), InstanceOptions::classic(Rule::MostDisplaced)).unwrap();
    type Change = fn(&mut ContactPoint);
    let cases: [(Change, &str); 12] = [
        (|p| p.point[1] = f32::NAN, "points[1].point is [0.0, NaN, 0.0]; every component must be finite"),
        (|p| p.normal = [0.0; 3], "points[1].normal is [0.0, 0.0, 0.0]; it must be longer than 0"),
        (|p| p.normal[0] = f32::INFINITY, "points[1].normal is"),
        (|p| p.impulse = Some(-1.0), "points[1].impulse is -1; it must be at least 0 and finite, N·s"),
        (|p| p.impulse = Some(f32::NAN), "points[1].impulse is NaN"),
        (|p| p.velocity = Some([f32::NAN; 3]), "points[1].velocity is"),
        (|p| p.velocity_after = Some([f32::INFINITY; 3]), "points[1].velocity_after is"),
        (
            |p| p.masses[1] = Some(0.0),
            "points[1].masses[1] is 0; it must be above 0 kg; infinity for a body that nothing moves",
        ),
        (|p| p.masses[0] = Some(f32::NAN), "points[1].masses[0] is NaN"),
        (|p| p.inverse_mass = Some(0.0), "points[1].inverse_mass is 0; it must be above 0 and finite, 1/kg"),
        (|p| p.radii[1] = Some(-1.0), "points[1].radii[1] is -1; it must be above 0 and finite, m"),
        (
            |p| (p.impulse, p.masses) = (None, [Some(f32::INFINITY); 2]),
            "points[1].impulse is absent; it must be given (N·s), or the velocity and the masses, of which at most one is \
             infinite",
        ),
    ];
    let right = || point(&body, [0.0; 2], 5.0, Some(40.0));
    for (change, message) in cases {
        let mut wrong = right();
        change(&mut wrong);
        let error = contacts.report(&[right(), wrong]).expect_err(message).to_string();
        assert!(error.starts_with(message), "{error}");
    }
    let error = contacts.report(&[right(), point(&classic, [0.0; 2], 5.0, Some(40.0))]).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::WrongRule);
    // None of the right ones was taken.
    assert_eq!(contacts.step(STEP).unwrap().points, 0);
    for seconds in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        contacts.report(&[right()]).unwrap();
        let error = contacts.step(seconds).unwrap_err().to_string();
        assert!(error.starts_with("seconds is") && error.ends_with("it must be above 0 and finite, s"), "{error}");
    }
    assert_eq!(contacts.step(STEP).unwrap().points, 4, "a wrong step loses nothing");
    for options in [
        ContactOptions { gain: -1.0, ..Default::default() },
        ContactOptions { gain: f32::NAN, ..Default::default() },
        ContactOptions { min_speed: Some(f32::INFINITY), ..Default::default() },
        ContactOptions { min_energy: Some(-0.5), ..Default::default() },
        ContactOptions { dent_radius: Some(0.0), ..Default::default() },
        ContactOptions { touch_time: 0.0, ..Default::default() },
        ContactOptions { separation_time: -1.0, ..Default::default() },
        ContactOptions { max_points: 0, ..Default::default() },
        ContactOptions { max_touches: 1 << 20, ..Default::default() },
    ] {
        assert!(matches!(contacts.set_options(options), Err(Error::InvalidArgument { .. })), "{options:?}");
    }
}

#[test]
fn quick_memory_is_bounded_and_counters_tell() {
    let set = set(1.0);
    let (body, contacts) = (new(&set), layer(ContactOptions { max_points: 10, max_touches: 4, ..Default::default() }));
    let many = |count: u64| -> Vec<ContactPoint> {
        (0..count).map(|pair| ContactPoint { pair, ..point(&body, [0.0; 2], 5.0, Some(40.0)) }).collect()
    };
    let error = contacts.report(&many(11)).unwrap_err().to_string();
    let expected = "points is 11 since the last step; it must be at most 10 (max_points): call step after each step of the \
                    physics";
    assert_eq!(error, expected);
    let report = stepped(&contacts, &many(10));
    assert_eq!((report.hits, report.crowded, report.open), (10, 6, 4));
    // A point that the body refuses does not keep the others back.
    let mut far = point(&body, [0.0; 2], 5.0, Some(40.0));
    far.point = [1e6, 0.0, 0.0];
    far.pair = 0;
    let report = stepped(&contacts, &[far, ContactPoint { pair: 50, ..point(&body, [0.0; 2], 5.0, Some(40.0)) }]);
    assert_eq!((report.hits, report.refused), (1, 1));
    assert!(matches!(report.refusal, Some(Error::ContactTooFar { .. })));
    contacts.clear();
    let report = contacts.step(STEP).unwrap();
    assert_eq!((report.points, report.open), (0, 0));
}

#[test]
fn quick_a_pair_s_number_may_be_used_again_and_bodies_may_go() {
    let set = set(1.0);
    let contacts = default();
    let (first, mut second) = (new(&set), new(&set));
    stepped(&contacts, &[point(&first, [0.0; 2], 5.0, Some(20.0))]);
    let report = stepped(&contacts, &[point(&second, [0.0; 2], 5.0, Some(40.0))]);
    assert_eq!((report.begun, report.ended, report.open), (1, 1, 1));
    assert!(same(depth(&mut second), told(&set, 5.0, MASS), 1e-4), "nothing of the first pair is left");
    contacts.report(&[point(&first, [0.0; 2], 5.0, Some(20.0))]).unwrap();
    drop(first);
    drop(second);
    let report = contacts.step(STEP).unwrap();
    assert_eq!((report.hits, report.refused, report.open), (0, 0, 0));
}

proptest! {
    #![proptest_config(scenes::cases(40))]

    /// Whatever engines report, in any order, of either body first and on any thread, leaves the same dents: the layer neither fails nor
    /// dents without a cause, and its counts agree.
    #[test]
    fn any_points_are_taken_or_refused_in_any_order(seed: u64) {
        let run = |order: u64| {
            let (mut bodies, contacts) = (both_sets().each_ref().map(new), default());
            let (mut dice, mut order) = (Dice::new(seed), Dice::new(order));
            let report = |some: &[ContactPoint]| some.iter().filter(|p| contacts.report(std::slice::from_ref(*p)).is_ok()).count();
            for _ in 0..20 {
                let mut points: Vec<ContactPoint> = (0..dice.index(10)).map(|_| any_point(&bodies, &mut dice)).collect();
                order.shuffle(&mut points);
                points.iter_mut().filter(|p| order.index(2) == 0 && differ(p)).for_each(turn);
                let (some, others) = points.split_at(points.len() / 2);
                let taken = std::thread::scope(|scope| {
                    let some = scope.spawn(|| report(some));
                    report(others) + some.join().unwrap()
                }) as u64;
                let told = contacts.step(dice.between(0.001, 0.1)).unwrap();
                assert!(told.points == taken && told.slow + told.separating <= 2 * taken, "{told:?}");
                for body in &mut bodies {
                    assert!(displacements(body).iter().all(|d| d.is_finite()));
                }
            }
            let totals = contacts.totals();
            assert!(totals.begun == totals.ended + totals.open, "{totals:?}");
            (bodies.map(|mut body| body.save()), totals)
        };
        prop_assert!(run(1) == run(2));
    }
}

fn differ(p: &ContactPoint) -> bool {
    let [a, b] = p.bodies.each_ref().map(|body| body.as_ref().map(Arc::as_ptr));
    a != b
}

/// Reports the other body first.
fn turn(p: &mut ContactPoint) {
    p.bodies.reverse();
    p.masses.reverse();
    p.radii.reverse();
    p.normal = p.normal.map(|x| -x);
    for velocity in [&mut p.velocity, &mut p.velocity_after].into_iter().flatten() {
        *velocity = velocity.map(|x| -x);
    }
}

/// A hard set and a soft one.
fn both_sets() -> &'static [Arc<ExampleSet>; 2] {
    static SETS: std::sync::OnceLock<[Arc<ExampleSet>; 2]> = std::sync::OnceLock::new();
    SETS.get_or_init(|| [1.0, 3.0].map(set))
}

/// Numbers of all sizes, and now and then one that is none.
fn any_number(dice: &mut Dice) -> f32 {
    const ODD: [f32; 8] = [0.0, -1.0, f32::NAN, f32::INFINITY, f32::MAX, f32::MIN_POSITIVE, 1e-30, -f32::MAX];
    if dice.index(12) == 0 { ODD[dice.index(8)] } else { 10f32.powf(dice.between(-4.0, 4.0)) }
}

fn any_point(bodies: &[Instance; 2], dice: &mut Dice) -> ContactPoint {
    let body = |dice: &mut Dice| {
        let which = dice.index(3);
        bodies.get(which).map(|body| body.inbox().clone())
    };
    let mut p = ContactPoint::new(dice.next() % 4, [body(dice), body(dice)], dice.vector(0.5), dice.vector(1.0));
    let maybe = |dice: &mut Dice| (dice.index(3) > 0).then(|| any_number(dice));
    p.impulse = maybe(dice);
    p.velocity = (dice.index(3) > 0).then(|| dice.vector(10.0));
    p.velocity_after = (dice.index(4) == 0).then(|| dice.vector(10.0));
    p.masses = [maybe(dice), maybe(dice)];
    p.inverse_mass = (dice.index(6) == 0).then(|| any_number(dice));
    p.radii = [maybe(dice), None];
    p
}
