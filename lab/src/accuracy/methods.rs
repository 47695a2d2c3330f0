//! The methods that are compared, each with its cost.

use std::sync::Arc;
use std::time::Duration;

use anyhow::Result;
use crumple::{
    ExampleSet, Hit, HitStatus, Instance, InstanceOptions, Placement, Rule, Selection, Serial, SetOptions, Tracker,
    VertexMemory,
};

use super::radial::Radial;
use crate::metric::length;
use crate::scene;
use crate::timing::median_us;
use crate::truth::{Body, Field, Impact};

/// One configuration.
pub struct Method {
    /// `classic`, `classic_clamped`, `radial`, `anchored`, `carried`, `automatic`, `depth_only` (automatic, told the depth along the
    /// normal instead of the displacement), `defaults`, or `baked_` and a tolerance (automatic).
    pub name: &'static str,
    /// How many training impacts it has, a prefix.
    pub examples: usize,
    pub k: u32,
    /// Nodes along the longest side of a stamp; 0 where there are none.
    pub stamp: u32,
    pub anchored_bytes: usize,
    pub stamp_bytes: usize,
    pub other_bytes: usize,
}

/// What a method makes of an impact.
pub struct Answer {
    pub field: Field,
    /// Whether any example answered.
    pub answered: bool,
    /// Cost on one thread, positions only, µs.
    pub us: f64,
    pub us_with_normals: f64,
    /// Vertices that move.
    pub moved: usize,
    /// Vertices that were written: whole blocks.
    pub written: u64,
}

type Visit<'a> = dyn FnMut(&Method, &mut dyn FnMut(&Impact) -> Result<Answer>) -> Result<()> + 'a;

const EXAMPLES: [usize; 5] = [4, 8, 16, 24, 32];
/// The counts at which K and stamp sizes are varied.
const VARIED: [usize; 2] = [4, 24];
const STAMPS: [u32; 6] = [8, 12, 16, 24, 32, 48];
const K: u32 = 3;
/// Automatic sets baked to a tolerance, m.
const BAKED: [(&str, f32); 3] = [("baked_0.01mm", 1e-5), ("baked_0.1mm", 1e-4), ("baked_1mm", 1e-3)];
/// Above every dent, m: measures the dents' shapes, not how deep the deepest example happens to be.
const DEEP: f32 = 1.0;

/// Calls `visit` with each method in turn.
pub fn each(body: &Body, quick: bool, visit: &mut Visit) -> Result<()> {
    let timer = Timer::of(quick);
    let radial = Radial::fit(body);
    let method = Method { other_bytes: radial.bytes(), ..named("radial", 0, 0, 0) };
    visit(&method, &mut |impact| {
        let mut field = Field::new();
        let us = timer.time(|| (), |()| radial.predict(body, impact, &mut field));
        Ok(answer(field, true, us, f64::NAN, body.vertices.len() as u64))
    })?;

    let default_stamp = SetOptions::default().stamp_resolution;
    for n in EXAMPLES.into_iter().filter(|n| !quick || VARIED.contains(n)) {
        let library = |placement, stamp_resolution| {
            scene::set(body, n, placement, SetOptions { stamp_resolution, ..SetOptions::default() })
        };
        let deep = |k| InstanceOptions { examples_per_hit: k, depth_limit: Some(DEEP), ..Default::default() };

        // An example counts as moving a vertex from a tenth of a millimetre: without that the rule's choice falls on
        // examples that barely move the contact.
        let options = SetOptions { drop_below: 1e-4, ..SetOptions::default() };
        let set = scene::set(body, n, Placement::Anchored, options)?;
        let classic = |selection| InstanceOptions { selection, ..InstanceOptions::classic(Rule::MostDisplaced) };
        measure(&set, "classic", n, 1, 0, classic(Selection::ClassicUnclamped), &timer, visit)?;
        measure(&set, "classic_clamped", n, 1, 0, classic(Selection::Classic), &timer, visit)?;

        let ks = |name: &str| match name {
            _ if !VARIED.contains(&n) || quick => K..=K,
            "anchored" => K..=K,
            _ => 1..=4,
        };
        for (name, placement) in
            [("anchored", Placement::Anchored), ("carried", Placement::Carried), ("automatic", Placement::Automatic)]
        {
            let set = library(placement, default_stamp)?;
            let stamp = if placement == Placement::Anchored { 0 } else { default_stamp };
            for k in ks(name) {
                measure(&set, name, n, k, stamp, deep(k), &timer, visit)?;
            }
            if placement == Placement::Automatic {
                measure(&set, "depth_only", n, K, stamp, deep(K), &timer, visit)?;
                measure(&set, "defaults", n, K, stamp, InstanceOptions::default(), &timer, visit)?;
            }
        }
        if VARIED.contains(&n) {
            for (name, tolerance) in BAKED {
                let options = SetOptions { tolerance: Some(tolerance), ..SetOptions::default() };
                let set = scene::set(body, n, Placement::Automatic, options)?;
                measure(&set, name, n, K, default_stamp, deep(K), &timer, visit)?;
            }
        }
        if VARIED.contains(&n) && !quick {
            for stamp in STAMPS.into_iter().filter(|s| *s != default_stamp) {
                let set = library(Placement::Automatic, stamp)?;
                measure(&set, "automatic", n, K, stamp, deep(K), &timer, visit)?;
            }
        }
    }
    Ok(())
}

fn named(name: &'static str, examples: usize, k: u32, stamp: u32) -> Method {
    Method { name, examples, k, stamp, anchored_bytes: 0, stamp_bytes: 0, other_bytes: 0 }
}

/// How often an impact is repeated.
pub struct Timer {
    runs: usize,
    budget: Duration,
}

impl Timer {
    pub fn of(quick: bool) -> Self {
        Timer { runs: if quick { 2 } else { 25 }, budget: Duration::from_millis(if quick { 0 } else { 4 }) }
    }

    /// Median time, µs.
    pub fn time<S>(&self, prepare: impl FnMut() -> S, work: impl FnMut(&mut S)) -> f64 {
        median_us(self.runs, self.budget, prepare, work)
    }
}

pub fn answer(field: Field, answered: bool, us: f64, us_with_normals: f64, written: u64) -> Answer {
    let moved = field.iter().filter(|u| length(**u) > 0.0).count();
    Answer { field, answered, us, us_with_normals, moved, written }
}

#[expect(clippy::too_many_arguments, reason = "a row of a table")]
fn measure(
    set: &Arc<ExampleSet>,
    name: &'static str,
    examples: usize,
    k: u32,
    stamp: u32,
    options: InstanceOptions,
    timer: &Timer,
    visit: &mut Visit,
) -> Result<()> {
    let report = set.report();
    let method = Method {
        anchored_bytes: report.anchored_bytes,
        stamp_bytes: if stamp == 0 { 0 } else { report.stamp_bytes },
        ..named(name, examples, k, stamp)
    };
    let hit = |impact: &Impact| match name {
        "depth_only" => scene::along_normal(set, impact),
        _ => scene::hit(impact),
    };
    visit(&method, &mut |impact| library(set, &options, hit(impact), timer))
}

/// The library's answer: what an engine pays from the contact to the vertices, other instances being left aside.
pub fn library(set: &Arc<ExampleSet>, options: &InstanceOptions, hit: Hit, timer: &Timer) -> Result<Answer> {
    let mut body = Instance::new(set.clone(), *options)?;
    let answered = body.submit(&hit)?.status == HitStatus::Marked;
    let field = scene::displacements(&mut body)?;
    let count = set.vertex_count();
    let (mut written, mut failed) = (0, None);
    let mut cost = |with_normals: bool| {
        let (mut positions, mut normals) = (vec![[0.0f32; 3]; count], vec![[0.0f32; 3]; count]);
        let body = std::cell::RefCell::new((&mut body, Tracker::new(), &mut positions, &mut normals));
        let deform = || {
            let (body, tracker, positions, normals) = &mut *body.borrow_mut();
            let normals = with_normals.then_some(&mut normals[..]);
            VertexMemory::separate(positions, normals, None).and_then(|m| body.deform(tracker, m, &Serial))
        };
        let undamaged = || {
            body.borrow_mut().0.reset();
            if let Err(e) = deform() {
                failed = Some(e);
            }
        };
        timer.time(undamaged, |()| {
            let hit = body.borrow_mut().0.submit(&hit);
            match hit.and_then(|_| deform()) {
                Ok(report) => written = report.vertices_written,
                Err(e) => panic!("what worked once must work again: {e}"),
            }
        })
    };
    let us = cost(false);
    let us_with_normals = cost(true);
    if let Some(e) = failed {
        return Err(e.into());
    }
    Ok(answer(field, answered, us, us_with_normals, written))
}
