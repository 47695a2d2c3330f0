//! Collisions in time: a touch begins when a point first comes near, goes on for some steps, and ends.
//!
//! A touch is one contact of Crumple's: its impulses add up to one dent, at any rate of steps. A touch that began
//! without speed rests, and one that lasts holds the body up; neither dents.

use godot::builtin::{Rid, Vector3};
use std::num::NonZeroU64;

/// A touch that was not seen for this many seconds has ended.
const GONE: f64 = 0.05;
/// Slower touches rest, m/s.
const SLOW: f32 = 0.05;

/// A point that two bodies touch at, in one step.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    pub other: Rid,
    /// In the body's own space, m.
    pub local: Vector3,
    /// Points nearer than this belong to one touch, m.
    pub near: f32,
    /// The speed at which the two came together before the step, m/s.
    pub closing: f32,
}

#[derive(Debug)]
struct Touch {
    seen: Seen,
    id: NonZeroU64,
    begin: f64,
    last: f64,
    open: bool,
    struck: bool,
}

/// The touches of one body.
#[derive(Debug, Default)]
pub struct Touches {
    list: Vec<Touch>,
}

impl Touches {
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Whether a point belongs to a touch that does not dent any more.
    pub fn rests(&mut self, other: Rid, local: Vector3, near: f32, now: f64) -> bool {
        let same = |t: &&mut Touch| t.seen.other == other && t.seen.local.distance_to(local) < near;
        match self.list.iter_mut().find(same) {
            Some(touch) if !touch.open => {
                touch.last = now;
                true
            }
            _ => false,
        }
    }

    /// Finds the touch that a point belongs to, or begins one. `rest` is the speed that gravity adds in a step, m/s.
    /// Returns the contact's id while the touch dents, and whether it has struck before.
    pub fn see(&mut self, seen: Seen, now: f64, rest: f32, last: &mut u64) -> Option<(NonZeroU64, bool)> {
        let same = |t: &&mut Touch| t.seen.other == seen.other && t.seen.local.distance_to(seen.local) < seen.near;
        if let Some(touch) = self.list.iter_mut().find(same) {
            touch.last = now;
            return touch.open.then_some((touch.id, touch.struck));
        }
        *last += 1;
        let id = NonZeroU64::new(*last)?;
        let open = seen.closing > SLOW + 1.5 * rest;
        self.list.push(Touch { seen, id, begin: now, last: now, open, struck: false });
        open.then_some((id, false))
    }

    /// Notes that a touch has got an impulse.
    pub fn strike(&mut self, id: NonZeroU64) {
        self.list.iter_mut().filter(|touch| touch.id == id).for_each(|touch| touch.struck = true);
    }

    /// Ends touches that are gone, or that have lasted for `time` seconds. Calls `ended` with the contacts that end.
    pub fn pass(&mut self, now: f64, time: f64, mut ended: impl FnMut(NonZeroU64)) {
        self.list.retain_mut(|touch| {
            let gone = now - touch.last > GONE;
            if touch.open && (gone || now - touch.begin > time) {
                touch.open = false;
                ended(touch.id);
            }
            !gone
        });
    }
}

#[cfg(test)]
mod tests {
    use super::{Seen, Touches};
    use godot::builtin::{Rid, Vector3};

    #[test]
    fn a_touch_dents_until_its_time_is_over_and_a_slow_one_never() {
        let (mut touches, mut last) = (Touches::default(), 0);
        let seen = |x: f32, closing| Seen { other: Rid::new(7), local: Vector3::new(x, 0.0, 0.0), near: 0.3, closing };
        let first = touches.see(seen(0.0, 3.0), 0.0, 0.16, &mut last);
        let id = first.expect("a fast touch").0;
        assert_eq!(touches.see(seen(0.1, 0.0), 0.05, 0.16, &mut last), first, "the same place goes on");
        assert_ne!(touches.see(seen(1.0, 3.0), 0.05, 0.16, &mut last), first, "another place is another contact");
        assert_eq!(touches.see(seen(2.0, 0.2), 0.05, 0.16, &mut last), None, "a slow touch rests");
        touches.strike(id);
        assert_eq!(touches.see(seen(0.0, 0.0), 0.06, 0.16, &mut last), Some((id, true)));
        let mut ended = Vec::new();
        touches.pass(0.11, 0.1, |id| ended.push(id));
        assert!(ended.contains(&id));
        assert_eq!(touches.see(seen(0.0, 3.0), 0.12, 0.16, &mut last), None, "what lasts holds the body up");
        touches.pass(1.0, 0.1, |_| ());
        assert!(touches.is_empty());
    }
}
