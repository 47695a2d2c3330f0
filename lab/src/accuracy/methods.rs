//! The methods that are compared, each with its cost.

use std::sync::Arc;
use std::time::Duration;

use anyhow::Result;
use crumple::{
    ExampleSet, Hit, HitStatus, Instance, InstanceOptions, Rule, Selection, Serial, SetOptions, Tracker, VertexMemory,
};

use super::radial::Radial;
use crate::metric::length;
use crate::scene;
use crate::timing::median_us;
use crate::truth::{Body, Field, Impact};

/// One configuration.
pub struct Method {
    /// `classic`, `classic_clamped`, `radial`, `crumple`, `depth_only` (told the depth along the normal instead of the displacement),
    /// `defaults`, or `baked_` and a tolerance.
    pub name: &'static str,
    /// How many training impacts it has, a prefix.
    pub examples: usize,
    /// What it holds beside the mesh.
    pub bytes: usize,
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
/// The counts of a quick run, and of baked sets.
const FEW: [usize; 2] = [4, 24];
/// Sets baked to a tolerance, m.
const BAKED: [(&str, f32); 3] = [("baked_0.01mm", 1e-5), ("baked_0.1mm", 1e-4), ("baked_1mm", 1e-3)];
/// Above every dent, m: measures the dents' shapes, not how deep the deepest example happens to be.
const DEEP: f32 = 1.0;

/// Calls `visit` with each method in turn.
pub fn each(body: &Body, quick: bool, visit: &mut Visit) -> Result<()> {
    let timer = Timer::of(quick);
    let radial = Radial::fit(body);
    let method = Method { name: "radial", examples: 0, bytes: radial.bytes() };
    visit(&method, &mut |impact| {
        let mut field = Field::new();
        let us = timer.time(|| (), |()| radial.predict(body, impact, &mut field));
        Ok(answer(field, true, us, f64::NAN, body.vertices.len() as u64))
    })?;

    let deep = InstanceOptions { depth_limit: Some(DEEP), ..Default::default() };
    for n in EXAMPLES.into_iter().filter(|n| !quick || FEW.contains(n)) {
        // An example counts as moving a vertex from a tenth of a millimetre: without that the rule's choice falls on
        // examples that barely move the contact.
        let options = SetOptions { drop_below: 1e-4, ..SetOptions::default() };
        let set = scene::set(body, n, options)?;
        let classic = |selection| InstanceOptions { selection, ..InstanceOptions::classic(Rule::MostDisplaced) };
        let bytes = held(&set);
        measure(&set, "classic", n, bytes, classic(Selection::ClassicUnclamped), &timer, visit)?;
        measure(&set, "classic_clamped", n, bytes, classic(Selection::Classic), &timer, visit)?;

        let set = scene::set(body, n, SetOptions::default())?;
        // Before any hit: a set remembers its latest predictions.
        let bytes = held(&set);
        measure(&set, "crumple", n, bytes, deep, &timer, visit)?;
        measure(&set, "depth_only", n, bytes, deep, &timer, visit)?;
        measure(&set, "defaults", n, bytes, InstanceOptions::default(), &timer, visit)?;
        if FEW.contains(&n) {
            for (name, tolerance) in BAKED {
                let options = SetOptions { tolerance: Some(tolerance), ..SetOptions::default() };
                let set = loaded(scene::set(body, n, options)?)?;
                measure(&set, name, n, held(&set), deep, &timer, visit)?;
            }
        }
    }
    Ok(())
}

/// The set as a game has it: from a baked file.
fn loaded(set: Arc<ExampleSet>) -> Result<Arc<ExampleSet>> {
    Ok(Arc::new(ExampleSet::load(set.save()?, &Serial)?))
}

/// What a set holds beside positions and triangles, bytes.
fn held(set: &ExampleSet) -> usize {
    let mesh = size_of_val(set.mesh().positions()) + size_of_val(set.mesh().triangles());
    set.memory_bytes() - mesh
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

fn measure(
    set: &Arc<ExampleSet>,
    name: &'static str,
    examples: usize,
    bytes: usize,
    options: InstanceOptions,
    timer: &Timer,
    visit: &mut Visit,
) -> Result<()> {
    let method = Method { name, examples, bytes };
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
