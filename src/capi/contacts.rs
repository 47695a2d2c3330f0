//! Contact points of a physics engine, from which the context makes hits.

use super::context::StepHit;
use super::prelude::*;
use crate::contacts::options::{ContactOptions, Impulses};
use crate::contacts::point::ContactPoint;
use crate::contacts::report::ContactReport;
use crate::example::blow::StrikerShape;
use crate::instance::inbox::Inbox;
use std::sync::Arc;

/// Options of a context's contacts. A touch is what leaves one dent: points of one pair that lie near each other, from the
/// step in which they first push until the bodies separate or touch_time is over.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleContactOptionsDef {
    pub struct_size: u32,
    /// What the impulses of points mean. Default CRUMPLE_IMPULSES_PER_POINT.
    pub impulses: MaybeUninit<Impulses>,
    /// Factor of the energy of every blow, at least 0. Default 1: what the physics says.
    pub gain: f32,
    /// Points that approach more slowly than this leave nothing, m/s. Default -1: a quarter of the speed of the set's slowest
    /// example, at least 0.5 m/s, which is above what gravity adds in a step of 1/30 s.
    pub min_speed: f32,
    /// Touches of less energy than this leave nothing, J. Default -1: a sixteenth of the energy of the set's weakest example.
    pub min_energy: f32,
    /// Points of a pair that are nearer to each other than this are one touch, m, in the mesh's space. Default -1: half of the median
    /// support radius of the set's examples.
    pub dent_radius: f32,
    /// How long a touch lasts at most, s, above 0. Bodies that push longer begin another one, if they are fast enough. Default
    /// 0.1.
    pub touch_time: f32,
    /// A touch ends when its pair was not reported for longer than this, s, at least 0. Default 0.05.
    pub separation_time: f32,
    /// The most points between two steps, 1 to 16777216. Default 65536.
    pub max_points: u32,
    /// The most touches at a time, 1 to 65536. Beyond it, the oldest ends early. Default 1024.
    pub max_touches: u32,
}

/// A point at which two bodies touch in a step of the physics. Vectors are in world space; keep the instances' transforms
/// up to date. Give the impulse, or the velocity and what the bodies weigh; best all of them:
///
///   known                  impulse J    approach speed v    energy of the blow
///   impulse and velocity   given        given               J v / 2
///   impulse and masses     given        J / m               J J / 2 m
///   velocity and masses    m v          given               m v v / 2
///   impulse alone          given        unknown             the set's law of impulses
///
/// m is the reduced mass: 1 / inverse_mass if given, else m_a m_b / (m_a + m_b), which is the mass of the free body if
/// nothing moves the other. Without a velocity, a body on which others rest looks struck: give velocities.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleContactPointDef {
    pub struct_size: u32,
    /// Whether velocity is known. Default false.
    pub has_velocity: MaybeUninit<bool>,
    /// Whether velocity_after is known. Default false: the bodies stop each other.
    pub has_velocity_after: MaybeUninit<bool>,
    /// The two bodies as one number, the same in every step in which they touch.
    pub pair: u64,
    /// The bodies a and b. Default null: a body that does not dent.
    pub bodies: [CrumpleInstance; 2],
    /// Where they touch, m.
    pub point: CrumpleVec3,
    /// From a to b: out of a. Required; any length above 0.
    pub normal: CrumpleVec3,
    /// Velocity of b relative to a at the point, before the step, m/s.
    pub velocity: CrumpleVec3,
    /// The same after the step, for points without an impulse.
    pub velocity_after: CrumpleVec3,
    /// Length of the normal impulse of the step, N s. Default -1: the reduced mass times the change of the approach speed.
    pub impulse: f32,
    /// Masses of a and b, kg; INFINITY for a static or kinematic body. Default 0: unknown.
    pub masses: [f32; 2],
    /// Inverse of the effective mass of the two at the point along the normal, with rotation, 1/kg. Default 0: 1/m_a +
    /// 1/m_b.
    pub inverse_mass: f32,
    /// Radii of the surfaces of a and b at the point, m: small for a corner, large for a flat face. Default 0: unknown.
    pub radii: [f32; 2],
    /// Shapes of a and b at the point. Default unknown.
    pub shapes: [MaybeUninit<StrikerShape>; 2],
    /// Factor of the point's energy, for the materials of the pair, at least 0. Default 1.
    pub gain: f32,
}

defs!(CrumpleContactOptionsDef, CrumpleContactPointDef);

/// What steps of a context's contacts did.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrumpleContactReport {
    pub points: u64,
    pub hits: u64,
    /// Touches that began, that ended, and that are open after the step.
    pub begun: u64,
    pub ended: u64,
    pub open: u64,
    /// Points that approached too slowly: resting, rolling and sliding bodies.
    pub slow: u64,
    /// Points that pushed while the bodies separated. If all do so, normal or velocity points the wrong way.
    pub separating: u64,
    /// Touches that ended with too little energy for a dent.
    pub weak: u64,
    /// Touches that ended early because there were too many.
    pub crowded: u64,
    /// Hits that instances refused.
    pub refused: u64,
    /// Why the first of them was refused; CRUMPLE_OK if none was.
    pub refusal: CrumpleResult,
    pub reserved: [u32; 3],
}

impl From<&ContactReport> for CrumpleContactReport {
    fn from(r: &ContactReport) -> Self {
        CrumpleContactReport {
            points: r.points,
            hits: r.hits,
            begun: r.begun,
            ended: r.ended,
            open: r.open,
            slow: r.slow,
            separating: r.separating,
            weak: r.weak,
            crowded: r.crowded,
            refused: r.refused,
            refusal: r.refusal.clone().map_or(CrumpleResult::CrumpleOk, |error| Failure::from(error).result),
            reserved: [0; 3],
        }
    }
}

#[unsafe(no_mangle)]
pub extern "C" fn crumple_contact_options_def_default() -> CrumpleContactOptionsDef {
    let o = ContactOptions::default();
    CrumpleContactOptionsDef {
        gain: o.gain,
        min_speed: -1.0,
        min_energy: -1.0,
        dent_radius: -1.0,
        touch_time: o.touch_time,
        separation_time: o.separation_time,
        max_points: o.max_points,
        max_touches: o.max_touches,
        ..zeroed()
    }
}

/// Changes the options of the context's contacts. Touches that last go on with them. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_context_set_contact_options(
    context: *mut CrumpleContext,
    options: *const CrumpleContactOptionsDef,
) -> CrumpleResult {
    concurrent("crumple_context_set_contact_options", context, |context| {
        let def = self::def(options, "options")?;
        // Minus one stands for what the set says.
        let given = |x: f32| (x != -1.0).then_some(x);
        Ok(context.contacts.set_options(ContactOptions {
            gain: def.gain,
            min_speed: given(def.min_speed),
            min_energy: given(def.min_energy),
            dent_radius: given(def.dent_radius),
            touch_time: def.touch_time,
            separation_time: def.separation_time,
            impulses: enumerator(def.impulses, "options.impulses")?,
            max_points: def.max_points,
            max_touches: def.max_touches,
        })?)
    })
}

#[unsafe(no_mangle)]
pub extern "C" fn crumple_contact_point_def_default() -> CrumpleContactPointDef {
    CrumpleContactPointDef { impulse: -1.0, gain: 1.0, ..zeroed() }
}

/// Takes contact points of the current step of the physics: all, or none if one is wrong. Report every point of every
/// pair, also of bodies that rest or slide, and call crumple_context_step_contacts() after the step. A touch leaves one
/// dent, at any rate of steps. Bodies that rest, roll, slide or jitter leave none. Two instances share the energy of a
/// blow, and the one that gives way more easily takes more. Any thread. Errors: CRUMPLE_ERROR_INVALID_ARGUMENT (names the
/// point and its field; also more than max_points since the last step), CRUMPLE_ERROR_WRONG_RULE (a classic rule).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_context_report_contacts(
    context: *mut CrumpleContext,
    points: *const CrumpleContactPointDef,
    count: u32,
) -> CrumpleResult {
    concurrent("crumple_context_report_contacts", context, |context| {
        let points = array(points, count as usize, "points")?;
        context.contacts.report_each(points.iter().enumerate().map(|(i, def)| read(context, def, i)))
    })
}

/// Ends a step of the physics that lasted so many seconds. It turns the points reported since the last call into hits,
/// which the next read of the damage applies; crumple_context_get_contact_hits() in crumple_contacts.h returns them. Call
/// it once after each step, also if nothing touched. These hits have contact ids of 2^63 and above; give smaller ids to
/// your own. out_report may be null. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_context_step_contacts(
    context: *mut CrumpleContext,
    seconds: f32,
    out_report: *mut CrumpleContactReport,
) -> CrumpleResult {
    concurrent("crumple_context_step_contacts", context, |context| {
        let out = Out::optional(out_report, "out_report")?;
        let mut hits = context.contact_hits();
        let earlier = hits.len();
        let report = context.contacts.step_each(seconds, |hit| {
            // An instance that was destroyed during the call gets no more hits.
            let found = context.inboxes().iter().find(|(_, inbox)| Arc::ptr_eq(inbox, hit.inbox)).map(|(id, _)| id);
            let of = |instance| StepHit { pair: hit.pair, instance, hit: *hit.hit, outcome: *hit.outcome };
            hits.extend(found.map(of));
        })?;
        hits.drain(..earlier);
        out.answer((&report).into())
    })
}

/// Ends all touches and forgets the points that wait, as after loading a saved game. Dents stay. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_context_clear_contacts(context: *mut CrumpleContext) -> CrumpleResult {
    concurrent("crumple_context_clear_contacts", context, |context| {
        context.contacts.clear();
        Ok(())
    })
}

unsafe fn read(context: &Context, def: &CrumpleContactPointDef, i: usize) -> Result<ContactPoint, Failure> {
    // Names are made for errors alone: reporting costs no memory.
    let of = |failure: Failure| Failure { message: format!("points[{i}].{}", failure.message), ..failure };
    let def = self::def(def, "def").map_err(of)?;
    let inboxes = context.inboxes();
    let body = |id: CrumpleInstance, name: &str| -> Result<Option<Arc<Inbox>>, Failure> {
        let given = id != CrumpleInstance::default();
        given.then(|| Ok(inboxes.get(id, name).map_err(of)?.clone())).transpose()
    };
    let shape = |side: usize, name: &str| enumerator(def.shapes[side], name).map_err(of);
    let known = |x: f32| (x != 0.0).then_some(x);
    let vector = |given: MaybeUninit<bool>, v: CrumpleVec3| boolean(given).then(|| v.array());
    let bodies = [body(def.bodies[0], "bodies[0]")?, body(def.bodies[1], "bodies[1]")?];
    Ok(ContactPoint {
        impulse: (def.impulse != -1.0).then_some(def.impulse),
        velocity: vector(def.has_velocity, def.velocity),
        velocity_after: vector(def.has_velocity_after, def.velocity_after),
        masses: def.masses.map(known),
        inverse_mass: known(def.inverse_mass),
        radii: def.radii.map(known),
        shapes: [shape(0, "shapes[0]")?, shape(1, "shapes[1]")?],
        gain: def.gain,
        ..ContactPoint::new(def.pair, bodies, def.point.array(), def.normal.array())
    })
}
