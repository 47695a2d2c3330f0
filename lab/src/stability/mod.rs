//! Sweeps over what breaks methods: impulses, the rims of examples, crowds of hits, orders, frame rates, examples that
//! contradict each other, supports and scales far from the usual, broken meshes, examples that fold the surface.

mod hits;
mod impulse;
mod inversion;
mod meshes;
mod opposite;
mod order;
mod rates;
mod rim;
mod scale;
mod sheet;
mod support;

use std::sync::Arc;

use anyhow::Result;
use crumple::{Blow, ExampleSet, Hit, Instance, InstanceOptions, Rule, Selection, Serial, SetOptions};

use crate::truth::{Body, Field, Truth};
use crate::{Options, scene};

/// Examples of the bodies from the shots.
pub const EXAMPLES: usize = 24;

type Sweep = fn(&Options) -> Result<()>;

/// Writes `stability_*.csv`.
pub fn run(options: &Options) -> Result<()> {
    let sweeps: [(&str, Sweep); 10] = [
        ("impulse", impulse::run),
        ("rim", rim::run),
        ("hits", hits::run),
        ("order", order::run),
        ("rates", rates::run),
        ("opposite", opposite::run),
        ("support", support::run),
        ("scale", scale::run),
        ("meshes", meshes::run),
        ("inversion", inversion::run),
    ];
    for (name, sweep) in sweeps {
        let start = std::time::Instant::now();
        sweep(options)?;
        println!("stability: {name}, {:.1} s", start.elapsed().as_secs_f64());
    }
    Ok(())
}

/// Who is put to the test.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// The library's defaults.
    Ours,
    /// The classic rule, most displaced, its weight at most 1.
    Classic,
    /// The same with blending by 0.5.
    Blend,
    /// Most displaced, the weight as the literature has it.
    Unclamped,
}

impl Method {
    pub const ALL: [Method; 4] = [Method::Ours, Method::Classic, Method::Blend, Method::Unclamped];

    pub fn name(self) -> &'static str {
        match self {
            Method::Ours => "crumple",
            Method::Classic => "classic, clamped",
            Method::Blend => "classic, blend 0.5",
            Method::Unclamped => "classic, as is",
        }
    }

    pub fn options(self) -> InstanceOptions {
        match self {
            Method::Ours => InstanceOptions::default(),
            Method::Classic => InstanceOptions::classic(Rule::MostDisplaced),
            Method::Blend => InstanceOptions::classic(Rule::Blend(0.5)),
            Method::Unclamped => InstanceOptions {
                selection: Selection::ClassicUnclamped,
                ..InstanceOptions::classic(Rule::MostDisplaced)
            },
        }
    }

    pub fn instance(self, set: &Arc<ExampleSet>) -> Result<Instance> {
        Ok(Instance::new(set.clone(), self.options())?)
    }

    /// The field after these hits, one after the other, m.
    pub fn after(self, set: &Arc<ExampleSet>, hits: &[Hit]) -> Result<Field> {
        scene::field_after(set, &self.options(), hits)
    }
}

/// A body of the shots with all library defaults.
pub fn shots(body: &'static str) -> Result<(Body, Arc<ExampleSet>)> {
    let body = Body::read(Truth::Shots, body)?;
    let set = scene::set(&body, EXAMPLES, SetOptions::default())?;
    Ok((body, set))
}

/// The same with examples that do not know their blows: impulses become displacements by the paper's formula.
pub fn without_blows(body: &Body) -> Result<Arc<ExampleSet>> {
    let mut examples = scene::examples(body, EXAMPLES);
    examples.iter_mut().for_each(|e| e.blow = Blow::default());
    Ok(Arc::new(ExampleSet::build(scene::mesh(body), examples, SetOptions::default(), &Serial)?))
}

/// SplitMix64: the same numbers everywhere.
pub struct Dice(u64);

impl Dice {
    pub fn new(seed: u64) -> Self {
        Self(seed ^ 0x5DEE_CE66_D1CE_4E5B)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub fn index(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.index(i + 1));
        }
    }
}

/// A hit at a random vertex, within about 40 degrees of the inward normal, `share` of the deepest example deep.
pub fn random_hit(set: &ExampleSet, dice: &mut Dice, share: f64) -> Hit {
    let mesh = set.mesh();
    let v = dice.index(set.vertex_count());
    let n = mesh.contact_normal(v as u32).map_or([0.0, 0.0, 1.0], |n| n.to_array());
    let aside = [0; 3].map(|_: i32| dice.between(-0.5, 0.5));
    let d = [0, 1, 2].map(|k| aside[k] - f64::from(n[k]));
    let size = share * deepest_example(set) / (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
    Hit::displacement(mesh.positions()[v].to_array(), d.map(|x| (size * x) as f32))
}

/// The longest displacement of all examples, m.
pub fn deepest_example(set: &ExampleSet) -> f64 {
    set.examples().iter().map(|e| e.max_depth()).fold(0.0, f32::max).into()
}

/// Of the bits of a field.
pub fn hash(field: &Field) -> u64 {
    let bytes = field.iter().flatten().flat_map(|x| x.to_bits().to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0000_0100_0000_01b3))
}

pub fn finite(field: &Field) -> bool {
    field.iter().flatten().all(|x| x.is_finite())
}

/// The largest difference at any vertex, m.
pub fn apart(a: &Field, b: &Field) -> f64 {
    crate::metric::max_error_mm(a, b) / 1e3
}
