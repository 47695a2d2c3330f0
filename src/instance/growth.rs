//! Dents that grow or go back over time. Marks change at once. What is shown of a dent goes from where it was to where
//! its mark puts it, evenly over the growth time. So the vertices are a function of the marks, of the times at which
//! they changed, and of the time that the caller gives. Once nothing grows, nothing is kept and nothing costs.

use crate::damage::list::Damage;
use crate::damage::mark::Mark;
use crate::example::set::ExampleSet;

/// What is shown of an instance's dents while some of them grow.
#[derive(Debug, Default)]
pub(crate) struct Growth {
    /// How long a dent takes, s; 0: none.
    lasts: f64,
    /// The caller's time, s.
    now: f64,
    /// Sorted by mark.
    growing: Vec<Growing>,
    /// `None` if nothing grows.
    shown: Option<Damage>,
}

/// A dent on its way.
#[derive(Debug, Clone, Copy)]
struct Growing {
    mark: Mark,
    /// Strengths.
    from: f32,
    to: f32,
    /// s.
    began: f64,
}

impl Growth {
    /// The most dents that change at a time. Beyond it, those that began first are complete at once.
    pub(crate) const MAX: usize = 256;

    pub(crate) fn new(lasts: f32) -> Self {
        Growth { lasts: lasts.into(), ..Growth::default() }
    }

    pub(crate) fn is_on(&self) -> bool {
        self.lasts > 0.0
    }

    /// The damage to show.
    pub(crate) fn shown<'a>(&'a self, damage: &'a Damage) -> &'a Damage {
        self.shown.as_ref().unwrap_or(damage)
    }

    /// Dents go from what was shown, `before` if nothing grew, to `damage`.
    pub(crate) fn begin(&mut self, set: &ExampleSet, before: Damage, damage: &Damage) {
        let shown = self.shown.take().unwrap_or(before);
        let old = std::mem::take(&mut self.growing);
        shown.compare(damage, |mark, from, to| {
            let same = old.binary_search_by_key(&mark.key(), |g| g.mark.key()).map(|at| old[at]);
            match same {
                // Its way does not change.
                Ok(growing) if growing.to == to => self.growing.push(growing),
                _ if from != to => self.growing.push(Growing { mark: *mark, from, to, began: self.now }),
                _ => {}
            }
        });
        while self.growing.len() > Self::MAX {
            let began = |at: usize| self.growing[at].began;
            let first = (0..self.growing.len()).reduce(|a, b| if began(b) < began(a) { b } else { a });
            first.map(|at| self.growing.remove(at));
        }
        self.show(set, damage);
    }

    /// Sets the time, s.
    pub(crate) fn advance(&mut self, set: &ExampleSet, damage: &Damage, now: f64) {
        self.now = now;
        if self.shown.take().is_some() {
            self.show(set, damage);
        }
    }

    /// Shows all dents as their marks are.
    pub(crate) fn finish(&mut self) {
        self.growing.clear();
        self.shown = None;
    }

    /// Whether dents are shown that are on their way.
    pub(crate) fn is_growing(&self) -> bool {
        self.shown.is_some()
    }

    pub(crate) fn time(&self) -> f64 {
        self.now
    }

    fn show(&mut self, set: &ExampleSet, damage: &Damage) {
        let (now, lasts) = (self.now, self.lasts);
        let share = |g: &Growing| ((now - g.began) / lasts).clamp(0.0, 1.0) as f32;
        self.growing.retain(|g| share(g) < 1.0);
        let on_the_way: Vec<(Mark, f32)> =
            self.growing.iter().map(|g| (g.mark, g.from + (g.to - g.from) * share(g))).collect();
        self.shown = (!on_the_way.is_empty()).then(|| damage.shown_as(set, &on_the_way));
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        self.growing.len() * size_of::<Growing>() + self.shown.as_ref().map_or(0, Damage::memory_bytes)
    }
}
