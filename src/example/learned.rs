//! What a set learned from its own examples by leaving each one out in turn.

/// How well the examples of a set predict each other, and the settings derived from that. Errors are relative L2 errors
/// of the displacement field around the example left out: 0 is perfect, 1 is as wrong as predicting no dent.
#[derive(Debug, Clone, PartialEq)]
pub struct Learned {
    /// Width of the place axes, as a share of the bounds' diagonal.
    pub place_width: f32,
    /// Error of each example when it is predicted from the others, carried. `None` if not tried or if no other could be
    /// used.
    pub carried_error: Vec<Option<f32>>,
    /// Error of each example when it is predicted from the others, anchored. `None` as for `carried_error`.
    pub anchored_error: Vec<Option<f32>>,
    /// Whether each automatic example is used anchored for hits around it.
    pub anchored: Vec<bool>,
}

impl Learned {
    /// Width of the place axes if there are too few examples to learn it.
    pub(crate) const DEFAULT_WIDTH: f32 = 1.3;

    /// The defaults for `n` examples, before learning.
    pub(crate) fn nothing(n: usize) -> Self {
        Learned {
            place_width: Self::DEFAULT_WIDTH,
            carried_error: vec![None; n],
            anchored_error: vec![None; n],
            anchored: vec![false; n],
        }
    }

    /// The example that the others predict worst, and its error. Another example near it would help most.
    pub fn worst(&self) -> Option<(usize, f32)> {
        let best = |i: usize| match (self.carried_error[i], self.anchored_error[i]) {
            (Some(c), Some(a)) if self.anchored[i] => Some(a.min(c)),
            (c, a) => c.or(a),
        };
        (0..self.anchored.len())
            .filter_map(|i| best(i).map(|e| (i, e)))
            .max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))
    }

    /// Error of an example, for the placement that it uses. `None` as for `carried_error`.
    pub fn error(&self, example: usize) -> Option<f32> {
        if self.anchored[example] { self.anchored_error[example] } else { self.carried_error[example] }
    }

    /// Median of the errors, each for the placement that its example uses.
    pub fn median(&self) -> Option<f32> {
        let mut errors: Vec<f32> = (0..self.anchored.len()).filter_map(|i| self.error(i)).collect();
        errors.sort_by(f32::total_cmp);
        errors.get(errors.len() / 2).copied()
    }
}
