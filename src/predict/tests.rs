//! The promises of the rule, on a sheet whose dents are known.

use super::kernel::{factors, matern};
use super::kriging::{Kriging, covariance};
use super::linear::add;
use super::{Blow, Body, Fields, Hit, Prediction, Predictor, Sample, Scratch, Told};
use crate::base::tasks::Serial;
use crate::basis::field::GROUP;
use crate::mesh::mirror::Mirror;
use glam::Vec3;
use proptest::prelude::*;

const N: usize = 25;

/// A square sheet of one metre a side, facing z.
struct Sheet {
    points: Vec<Vec3>,
    normals: Vec<Vec3>,
}

impl Sheet {
    fn new() -> Self {
        let points = (0..N * N).map(|k| Vec3::new((k / N) as f32 - 12.0, (k % N) as f32 - 12.0, 0.0) / 24.0);
        Self { points: points.collect(), normals: vec![Vec3::Z; N * N] }
    }

    fn body(&self, mirror: u8) -> Body {
        Body::new(&self.points, &self.normals, &[], Mirror::from_bits(mirror), Vec3::ZERO)
    }

    /// A dent whose depth grows with the root of the energy, and is twice as deep on the right as on the left.
    fn dent(&self, contact: Vec3, energy: f32) -> Vec<Vec3> {
        let depth = 0.002 * energy.sqrt() * (1.5 + contact.x);
        let width = 0.1 * (depth / 0.01).powf(0.4);
        let at = |p: &Vec3| {
            let r = (*p - contact).length() / width;
            if r < 3.0 { Vec3::NEG_Z * depth * (1.0 - r * r / 9.0).powi(4) } else { Vec3::ZERO }
        };
        self.points.iter().map(at).collect()
    }
}

fn blow(energy: f32, mass: f32) -> Blow {
    let velocity = Some(Vec3::NEG_Z * (2.0 * energy / mass).sqrt());
    Blow { velocity, mass: Some(mass), radius: Some(0.1), ..Blow::default() }
}

/// Places of examples, on points of the sheet, and energies.
fn places(count: usize) -> Vec<(Vec3, f32)> {
    let at = |k: usize| ((k * 7 + 3) % 19 + 3, (k * 11 + 5) % 17 + 4);
    (0..count)
        .map(|k| {
            let (i, j) = at(k);
            (Vec3::new(i as f32 - 12.0, j as f32 - 12.0, 0.0) / 24.0, 10.0 * (1 + (k * 5) % 13) as f32)
        })
        .collect()
}

struct Set {
    sheet: Sheet,
    hits: Vec<(Vec3, f32)>,
    fields: Vec<Vec<Vec3>>,
}

impl Set {
    fn new(count: usize) -> Self {
        let (sheet, hits) = (Sheet::new(), places(count));
        let fields = hits.iter().map(|(p, e)| sheet.dent(*p, *e)).collect();
        Self { sheet, hits, fields }
    }

    fn samples<'a>(&'a self) -> Vec<Sample<'a>> {
        let body = self.sheet.body(0);
        let sample = |(source, ((contact, energy), field)): (u32, (&(Vec3, f32), &'a Vec<Vec3>))| Sample {
            contact: *contact,
            normal: Vec3::Z,
            blow: Some(blow(*energy, 5.0)),
            field,
            moved: field[body.nearest(*contact)],
            source,
        };
        (0..).zip(self.hits.iter().zip(&self.fields)).map(sample).collect()
    }

    fn learn(&self, mirror: u8) -> Rule {
        self.learn_from(mirror, &self.samples())
    }

    fn learn_from(&self, mirror: u8, samples: &[Sample<'_>]) -> Rule {
        let fields = samples.iter().map(|s| s.field.to_vec()).collect();
        Rule { predictor: Predictor::learn(self.sheet.body(mirror), samples, &Serial), fields }
    }
}

/// A rule and what it was learned from.
struct Rule {
    predictor: Predictor,
    fields: Vec<Vec<Vec3>>,
}

impl std::ops::Deref for Rule {
    type Target = Predictor;

    fn deref(&self) -> &Predictor {
        &self.predictor
    }
}

impl Fields for Rule {
    fn moved(&self, sample: usize, f: &mut dyn FnMut(usize, Vec3)) {
        self.fields[sample].iter().enumerate().for_each(|(v, u)| f(v, *u));
    }
}

fn predict(p: &Rule, hit: &Hit) -> (Prediction, Vec<Vec3>) {
    let mut scratch = Scratch::default();
    let (told, groups) = p.predict(hit, p, &mut scratch);
    let mut field: Vec<Vec3> = groups.iter().flat_map(|u| (0..GROUP).map(|i| u.map(|along| along[i]).into())).collect();
    field.resize(p.body.count, Vec3::ZERO);
    (told, field)
}

/// What a blow of 5 kg leaves.
fn hit(p: &Rule, contact: Vec3, energy: f32) -> (Prediction, Vec<Vec3>) {
    strike(p, contact, &blow(energy, 5.0))
}

fn strike(p: &Rule, contact: Vec3, blow: &Blow) -> (Prediction, Vec<Vec3>) {
    match p.strike(blow, Vec3::Z) {
        Some(strike) => predict(p, &Hit { contact, normal: Vec3::Z, told: Told::Strike(strike) }),
        None => (Prediction::default(), vec![Vec3::ZERO; p.body.count]),
    }
}

fn error(a: &[Vec3], b: &[Vec3]) -> f32 {
    let sum = |f: &dyn Fn(usize) -> Vec3| (0..a.len()).map(|i| f(i).length_squared()).sum::<f32>();
    (sum(&|i| a[i] - b[i]) / sum(&|i| b[i])).sqrt()
}

#[test]
fn kriging_weights_have_the_values_of_the_textbook() {
    let at = |x: f64| std::array::from_fn(|k| if k == 0 { x } else { 0.0 });
    let unit = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -30.0];
    let points = [at(0.0), at(1.0)];
    let kriging = Kriging::new(&points, &unit, true);
    let weights = |x: f64| {
        // What is predicted of a row that is 1 at one point.
        let (mut mean, coefficients) = kriging.coefficients(&[1.0, 0.0, 0.0, 1.0], 2);
        for (p, row) in points.iter().zip(coefficients.chunks_exact(2)) {
            add(&mut mean, covariance(p, &at(x), &factors(&unit)), row);
        }
        mean
    };
    // By symmetry; at a point; and from 2 equations and the multiplier: w = 1/2 + (k1 - k2) / (2 (1 - k12)).
    assert!((weights(0.5)[0] - 0.5).abs() < 1e-6);
    assert!((weights(1.0)[1] - 1.0).abs() < 1e-4);
    let (k1, k2, k12) = (matern(3.0 * 0.04), matern(3.0 * 0.64), matern(3.0));
    assert!((weights(0.2)[0] - (0.5 + (k1 - k2) / (2.0 * (1.0 - k12)))).abs() < 1e-4);
    for x in [-3.0, 0.1, 0.9, 40.0] {
        assert!((weights(x).iter().sum::<f64>() - 1.0).abs() < 1e-9);
    }
    // Left out, each is predicted by the other alone.
    let missed = kriging.missed(&[2.0, 5.0], 1, &[vec![0], vec![1]]);
    assert!((missed[0] + 3.0).abs() < 1e-4 && (missed[1] - 3.0).abs() < 1e-4);
}

#[test]
fn an_examples_own_blow_gives_the_example() {
    for count in [1, 3, 20] {
        let set = Set::new(count);
        let p = set.learn(0);
        for ((contact, energy), field) in set.hits.iter().zip(&set.fields) {
            let (told, got) = hit(&p, *contact, *energy);
            let worst = got.iter().zip(field).map(|(a, b)| (*a - *b).length()).fold(0.0, f32::max);
            assert!(worst < 1e-5, "{count} examples: {worst} m off, {told:?}");
        }
    }
}

#[test]
fn more_examples_predict_better() {
    let tests =
        [(Vec3::new(0.1, -0.15, 0.0), 55.0), (Vec3::new(-0.2, 0.1, 0.0), 25.0), (Vec3::new(0.27, 0.2, 0.0), 90.0)];
    let errors = [4, 40].map(|count| {
        let set = Set::new(count);
        let p = set.learn(0);
        tests.iter().map(|(c, e)| error(&hit(&p, *c, *e).1, &set.sheet.dent(*c, *e))).sum::<f32>() / 3.0
    });
    assert!(errors[1] < 0.12 && errors[1] < 0.7 * errors[0], "{errors:?}");
}

#[test]
fn the_order_of_samples_does_not_matter() {
    let set = Set::new(12);
    let mut samples = set.samples();
    let one = set.learn(0);
    samples.reverse();
    let other = set.learn_from(0, &samples);
    let (own, energy) = set.hits[4];
    for (at, energy) in [(Vec3::new(0.13, 0.02, 0.0), 33.0), (own, energy)] {
        assert_eq!(hit(&one, at, energy), hit(&other, at, energy));
    }
    let errors: Vec<f32> = other.errors().iter().rev().copied().collect();
    assert_eq!(one.errors(), errors);
}

#[test]
fn a_symmetric_body_dents_symmetrically() {
    let mut set = Set::new(10);
    // Dents that agree with a mirror in x: deeper towards both sides.
    let Set { sheet, hits, fields } = &mut set;
    for ((contact, energy), field) in hits.iter().zip(fields) {
        for (p, u) in sheet.points.iter().zip(field) {
            let r = (*p - *contact).length() / (0.11 * energy.cbrt().sqrt());
            *u = Vec3::NEG_Z * 0.002 * (1.0 + 4.0 * contact.x.abs()) * energy.sqrt() * (1.0 - r * r).max(0.0);
        }
    }
    let p = set.learn(1);
    assert!(p.blow.as_ref().unwrap().examples.len() > set.hits.len(), "images count");
    let mirror = Mirror::from_bits(1);
    for contact in [Vec3::new(0.2, 0.1, 0.0), set.hits[2].0] {
        let (_, left) = hit(&p, contact, 40.0);
        let (_, right) = hit(&p, mirror.direction(contact), 40.0);
        let back: Vec<Vec3> = (0..N * N).map(|k| mirror.direction(right[(N - 1 - k / N) * N + k % N])).collect();
        assert!(error(&back, &left) < 2e-3, "{}", error(&back, &left));
    }
}

#[test]
fn a_told_displacement_is_kept() {
    let p = Set::new(20).learn(0);
    for depth in [0.004, 0.02, 0.04] {
        let contact = Vec3::new(2.0, -3.0, 0.0) / 24.0;
        let h = Hit { contact, normal: Vec3::Z, told: Told::Displacement(Vec3::NEG_Z * depth) };
        let (told, field) = predict(&p, &h);
        let at = field[14 * N + 9].length();
        assert!((at - depth).abs() < 1e-3 * depth && (told.depth - depth).abs() < 1e-3 * depth, "{at} {told:?}");
    }
}

#[test]
fn blows_out_of_the_body_and_weak_ones_leave_nothing() {
    let set = Set::new(8);
    let p = set.learn(0);
    let contact = Vec3::new(0.1, 0.1, 0.0);
    let away = Blow { velocity: Some(Vec3::Z * 5.0), mass: Some(5.0), ..Blow::default() };
    let nothing = Blow { mass: Some(5.0), ..Blow::default() };
    let zero = Hit { contact, normal: Vec3::Z, told: Told::Displacement(Vec3::ZERO) };
    let nothings = [away, nothing, blow(1e-3, 5.0)].map(|blow| strike(&p, contact, &blow));
    for (told, field) in nothings.into_iter().chain([predict(&p, &zero)]) {
        assert!(told.size == 0.0 && field.iter().all(|u| *u == Vec3::ZERO), "{told:?}");
    }
    // Examples that know no blow: only displacements can be told.
    let samples: Vec<Sample> = set.samples().into_iter().map(|s| Sample { blow: None, ..s }).collect();
    let p = set.learn_from(0, &samples);
    assert!(!p.knows_blows() && hit(&p, contact, 40.0).0.size == 0.0);
    let h = Hit { contact, normal: Vec3::Z, told: Told::Displacement(Vec3::NEG_Z * 0.01) };
    assert!(predict(&p, &h).0.size > 0.0);
}

#[test]
fn an_impulse_tells_what_mass_and_velocity_tell() {
    let p = Set::new(16).learn(0);
    let contact = Vec3::new(0.1, -0.05, 0.0);
    let known = blow(50.0, 5.0);
    let impulse = Blow { impulse: known.velocity.map(|v| v * 5.0), velocity: None, ..known };
    let both = [known, impulse].map(|b| strike(&p, contact, &b).0.size);
    assert!((both[0] / both[1] - 1.0).abs() < 1e-4, "{both:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn a_harder_blow_is_never_smaller(x in -0.45f32..0.45, y in -0.45f32..0.45, energy in 0.1f32..900.0, more in 1.0f32..8.0, near in 0usize..20) {
        static LEARNED: std::sync::LazyLock<(Set, Rule)> = std::sync::LazyLock::new(|| {
            let mut set = Set::new(20);
            // Some contradict the others.
            set.fields[3].iter_mut().for_each(|u| *u *= 0.4);
            set.fields[7].iter_mut().for_each(|u| *u *= 2.5);
            let p = set.learn(0);
            (set, p)
        });
        let (set, p) = &*LEARNED;
        let beside = set.hits[near].0 + Vec3::new(x, y, 0.0) * 0.03;
        for contact in [Vec3::new(x, y, 0.0), beside] {
            let [weak, hard] = [energy, energy * more].map(|e| hit(p, contact, e).0);
            prop_assert!(hard.size >= weak.size * (1.0 - 1e-6), "{weak:?} {hard:?}");
            let size = |f: &Vec<Vec3>| f.iter().map(|u| u.length_squared()).sum::<f32>().sqrt();
            let largest = set.fields.iter().map(size).fold(0.0, f32::max);
            prop_assert!(hard.size < 2.1 * largest, "{hard:?} {largest}");
        }
    }
}
