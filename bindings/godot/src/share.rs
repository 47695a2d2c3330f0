//! Shares the momentum that a body received in one step among the points that it touched.
//!
//! Neither of Godot's physics engines reports usable impulses of single points: Jolt reports the whole impulse at every
//! point, and Godot Physics reports 0 in the step of the impact. What both report truly is the change of velocity. So
//! the pushes `a` of the points along their normals are found by least squares,
//!
//! ```text
//! minimize |sum a n - J|^2 + |sum a (r x n) - L|^2 / gyration^2      with all a >= 0,
//! ```
//!
//! by projected gradient steps from zero. They treat points with equal normals alike, and the angular part tells a hit
//! corner from its neighbours. What is left of `J` is friction, shared in proportion.

use godot::builtin::Vector3;

/// The most steps, and the change, as a share of the whole, that ends them.
const STEPS: usize = 400;
const ENOUGH: f32 = 1e-4;
/// The most friction that counts, as a share of the push along the normal.
const FRICTION: f32 = 1.0;

/// A point that the body touches.
#[derive(Debug, Clone, Copy)]
pub struct Point {
    /// Unit normal, out of the other body.
    pub normal: Vector3,
    /// The point relative to the centre of mass, m.
    pub arm: Vector3,
}

/// The impulse that the body received at each point, N s. `linear` and `angular` are the changes of momentum that
/// contacts caused; the angular one is `None` if the body cannot turn. `gyration` is the radius of gyration, m.
pub fn impulses(points: &[Point], linear: Vector3, angular: Option<Vector3>, gyration: f32) -> Vec<Vector3> {
    let weight = if gyration > 0.0 && angular.is_some() { 1.0 / (gyration * gyration) } else { 0.0 };
    let angular = angular.unwrap_or(Vector3::ZERO);
    let turns: Vec<Vector3> = points.iter().map(|p| p.arm.cross(p.normal)).collect();
    // The trace is no less than the largest eigenvalue, so no step overshoots.
    let trace: f32 = turns.iter().map(|t| 1.0 + weight * t.length_squared()).sum();
    let mut push = vec![0.0f32; points.len()];
    for _ in 0..STEPS {
        let (mut j, mut l) = (linear, angular);
        for ((a, p), t) in push.iter().zip(points).zip(&turns) {
            j -= p.normal * *a;
            l -= *t * *a;
        }
        let mut change = 0.0;
        for ((a, p), t) in push.iter_mut().zip(points).zip(&turns) {
            let next = (*a + (p.normal.dot(j) + weight * t.dot(l)) / trace).max(0.0);
            change += (next - *a).abs();
            *a = next;
        }
        if change <= ENOUGH * linear.length() {
            break;
        }
    }
    let sum: f32 = push.iter().sum();
    if sum <= 0.0 {
        return vec![Vector3::ZERO; points.len()];
    }
    let normal: Vector3 = push.iter().zip(points).map(|(a, p)| p.normal * *a).fold(Vector3::ZERO, |s, v| s + v);
    let rest = linear - normal;
    let most = FRICTION * sum;
    let friction = if rest.length() > most { rest * (most / rest.length()) } else { rest };
    push.iter().zip(points).map(|(a, p)| p.normal * *a + friction * (*a / sum)).collect()
}

#[cfg(test)]
mod tests {
    use super::{Point, impulses};
    use godot::builtin::Vector3;

    fn near(a: Vector3, b: Vector3, tolerance: f32) -> bool {
        (a - b).length() <= tolerance
    }

    #[test]
    fn a_flat_hit_is_shared_evenly_and_a_corner_takes_its_own() {
        let corner = |x: f32, z: f32| Point { normal: Vector3::UP, arm: Vector3::new(x, -0.5, z) };
        let points = [corner(0.5, 0.5), corner(-0.5, 0.5), corner(0.5, -0.5), corner(-0.5, -0.5)];
        let flat = impulses(&points, Vector3::new(0.0, 8.0, 0.0), Some(Vector3::ZERO), 0.4);
        assert!(flat.iter().all(|j| near(*j, Vector3::new(0.0, 2.0, 0.0), 1e-3)), "{flat:?}");
        // The same momentum at the first corner turns the body.
        let angular = points[0].arm.cross(Vector3::new(0.0, 8.0, 0.0));
        let hit = impulses(&points, Vector3::new(0.0, 8.0, 0.0), Some(angular), 0.4);
        assert!(near(hit[0], Vector3::new(0.0, 8.0, 0.0), 0.4), "{hit:?}");
    }

    #[test]
    fn a_wall_takes_what_the_floor_does_not() {
        let floor = Point { normal: Vector3::UP, arm: Vector3::new(0.0, -0.5, 0.0) };
        let wall = Point { normal: Vector3::LEFT, arm: Vector3::new(0.5, 0.0, 0.0) };
        let shares = impulses(&[floor, wall], Vector3::new(-10.0, 0.2, 0.0), None, 0.0);
        assert!(near(shares[0], Vector3::new(0.0, 0.2, 0.0), 1e-2), "{shares:?}");
        assert!(near(shares[1], Vector3::new(-10.0, 0.0, 0.0), 1e-2), "{shares:?}");
        // A push away from everything touched is nobody's.
        assert_eq!(impulses(&[floor], Vector3::new(0.0, -3.0, 0.0), None, 0.0), [Vector3::ZERO]);
    }
}
