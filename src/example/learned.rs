//! What a set learned from its own examples, each left out in turn.

/// How well the examples of a set predict each other, and what follows. Errors are relative L2 errors of the displacement
/// field around the example left out: 0 is perfect, predicting no dent is 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Learned {
    /// Width of the place axes, as a share of the bounds' diagonal.
    pub place_width: f32,
    /// Error of each example when the others predict it carried; `None` where it was not tried or nothing answered.
    pub carried_error: Vec<Option<f32>>,
    /// The same when the others stay where they were made.
    pub anchored_error: Vec<Option<f32>>,
    /// Whether each automatic example stays in place for hits around it.
    pub anchored: Vec<bool>,
}

impl Learned {
    /// Width of the place axes where too little is known to learn it.
    pub(crate) const DEFAULT_WIDTH: f32 = 1.3;

    /// Nothing known yet, of `n` examples.
    pub(crate) fn nothing(n: usize) -> Self {
        Learned {
            place_width: Self::DEFAULT_WIDTH,
            carried_error: vec![None; n],
            anchored_error: vec![None; n],
            anchored: vec![false; n],
        }
    }

    /// The example that the others predict worst: one more near it would help most.
    pub fn worst(&self) -> Option<(usize, f32)> {
        let best = |i: usize| match (self.carried_error[i], self.anchored_error[i]) {
            (Some(c), Some(a)) if self.anchored[i] => Some(a.min(c)),
            (c, a) => c.or(a),
        };
        (0..self.anchored.len())
            .filter_map(|i| best(i).map(|e| (i, e)))
            .max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))
    }

    /// Median of the errors of the placement that each example has.
    pub fn median(&self) -> Option<f32> {
        let of = |i: usize| if self.anchored[i] { self.anchored_error[i] } else { self.carried_error[i] };
        let mut errors: Vec<f32> = (0..self.anchored.len()).filter_map(of).collect();
        errors.sort_by(f32::total_cmp);
        errors.get(errors.len() / 2).copied()
    }
}
