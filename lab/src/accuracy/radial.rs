//! A dent without examples: one profile over the distance from the contact, `phi(r / (a |t|^b)) * t`, in the direction of
//! the target `t`. The profile is the mean over the training impacts, `b` the best of a grid, as one would fit it to have
//! something to put into a shader. Distance is the straight one, not along the surface.

use crate::metric::{dot64, length, sub};
use crate::truth::{Body, Field, Impact};

const BINS: usize = 25;
/// The profile ends here, in dent radii.
const END: f64 = 2.5;
/// Radius of a dent of median depth, m.
const RADIUS: f64 = 0.25;

pub struct Radial {
    a: f64,
    b: f64,
    /// At the bins' middles, in front the contact's own 1.
    profile: [f32; BINS + 1],
}

impl Radial {
    /// Fits to the training impacts that leave a dent.
    pub fn fit(body: &Body) -> Self {
        let train: Vec<&Impact> = body.train.iter().filter(|i| i.depth() > 1e-3).collect();
        let typical = crate::metric::median(&train.iter().map(|i| i.depth()).collect::<Vec<_>>());
        let mut samples = Vec::new();
        for impact in &train {
            let depth = impact.depth();
            for (p, u) in body.vertices.iter().zip(&impact.field) {
                samples.push((distance(*p, impact.point), depth, length(*u) / depth));
            }
        }
        let fits = (0..=8).map(|step| {
            let b = 0.1 * f64::from(step);
            let a = RADIUS / typical.powf(b);
            let bin = |r: f64, depth: f64| (r / (a * depth.powf(b)) / END * BINS as f64) as usize;
            let (mut sum, mut count) = ([0.0; BINS], [0usize; BINS]);
            for (r, depth, y) in &samples {
                if let k @ ..BINS = bin(*r, *depth) {
                    sum[k] += y;
                    count[k] += 1;
                }
            }
            let mean: [f64; BINS] = std::array::from_fn(|k| sum[k] / count[k].max(1) as f64);
            let wrong = samples.iter().map(|(r, depth, y)| {
                let fit = mean.get(bin(*r, *depth)).copied().unwrap_or(0.0);
                (y - fit).powi(2)
            });
            let wrong: f64 = wrong.sum();
            let profile = std::array::from_fn(|k| if k == 0 { 1.0 } else { mean[k - 1] as f32 });
            (wrong, Radial { a, b, profile })
        });
        fits.min_by(|x, y| x.0.total_cmp(&y.0)).map(|(_, fit)| fit).expect("a grid of nine")
    }

    /// Memory it needs.
    pub fn bytes(&self) -> usize {
        (self.profile.len() + 2) * size_of::<f32>()
    }

    /// Share of the target at this distance, in dent radii.
    fn at(&self, x: f32) -> f32 {
        if x >= END as f32 {
            return 0.0;
        }
        // The first value is the contact's own, the others lie at the bins' middles.
        let x = x / END as f32 * BINS as f32;
        let k = ((x + 0.5) as usize).min(BINS - 1);
        let (from, width) = if k == 0 { (0.0, 0.5) } else { (k as f32 - 0.5, 1.0) };
        let t = ((x - from) / width).min(1.0);
        self.profile[k] + t * (self.profile[k + 1] - self.profile[k])
    }

    /// The field of an impact, into memory that is reused; in f32, as an engine would.
    pub fn predict(&self, body: &Body, impact: &Impact, field: &mut Field) {
        field.clear();
        field.resize(body.vertices.len(), [0.0; 3]);
        let radius = (self.a * impact.depth().powf(self.b)) as f32;
        let (end, scale) = ((END as f32 * radius).powi(2), 1.0 / radius);
        let c = impact.point;
        for (v, (p, u)) in body.vertices.iter().zip(field).enumerate() {
            let d = [p[0] - c[0], p[1] - c[1], p[2] - c[2]];
            let squared = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
            if squared < end && !body.pinned.get(v).is_some_and(|pinned| *pinned) {
                let share = self.at(squared.sqrt() * scale);
                *u = impact.displacement.map(|t| share * t);
            }
        }
    }
}

fn distance(p: [f32; 3], q: [f32; 3]) -> f64 {
    let d = sub(p, q);
    dot64(d, d).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::truth::Truth;

    #[test]
    fn it_meets_the_target_at_the_contact_and_ends() {
        let body = Body::read(Truth::Shots, "panel").unwrap();
        let radial = Radial::fit(&body);
        let impact = &body.train[0];
        let mut field = Field::new();
        radial.predict(&body, impact, &mut field);
        assert_eq!(field[impact.contact_vertex as usize], impact.displacement);
        assert!(field.iter().all(|u| length(*u) <= 1.0001 * impact.depth()));
        assert_eq!(radial.at(0.0), 1.0);
        assert_eq!(radial.at(END as f32), 0.0);
        for k in 1..100 {
            let (x, y) = (k as f32 * 0.025 - 0.001, k as f32 * 0.025 + 0.001);
            assert!((radial.at(x) - radial.at(y)).abs() < 0.1, "no jump at {x} but at the end");
        }
    }
}
