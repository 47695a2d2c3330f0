//! Vectors of three f64.

pub type V = [f64; 3];

pub fn from_f32(a: [f32; 3]) -> V {
    a.map(f64::from)
}

pub fn add(a: V, b: V) -> V {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub fn sub(a: V, b: V) -> V {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub fn scale(s: f64, a: V) -> V {
    a.map(|x| s * x)
}

pub fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn length(a: V) -> f64 {
    dot(a, a).sqrt()
}

/// Unit length, or zero.
pub fn unit(a: V) -> V {
    let l = length(a);
    if l > 0.0 { scale(1.0 / l, a) } else { [0.0; 3] }
}

pub fn lerp(a: V, b: V, t: f64) -> V {
    add(a, scale(t, sub(b, a)))
}

/// The rows of a rotation.
pub type Matrix = [V; 3];

pub fn apply(m: Matrix, a: V) -> V {
    [dot(m[0], a), dot(m[1], a), dot(m[2], a)]
}

pub fn transpose(m: Matrix) -> Matrix {
    [0, 1, 2].map(|i| [m[0][i], m[1][i], m[2][i]])
}

pub fn product(a: Matrix, b: Matrix) -> Matrix {
    let b = transpose(b);
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| dot(a[i], b[j])))
}

/// The smallest rotation that takes unit vector `a` to unit vector `b` (Rodrigues). The vectors must not be opposite.
pub fn smallest_rotation(a: V, b: V) -> Matrix {
    let v = cross(a, b);
    let c = dot(a, b);
    let k = [[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]];
    [0, 1, 2].map(|i| {
        [0, 1, 2].map(|j| {
            let square: f64 = (0..3).map(|l| k[i][l] * k[l][j]).sum();
            f64::from(u8::from(i == j)) + k[i][j] + square / (1.0 + c)
        })
    })
}

/// The same for any two vectors. If they are opposite (to within a cosine of 1e-4), a half turn comes first. Its axis
/// is the direction at right angles to `a` that is nearest to z, or to x if `a` is along z.
pub fn rotation_between(a: V, b: V) -> Matrix {
    let (a, b) = (unit(a), unit(b));
    if dot(a, b) >= -0.9999 {
        return smallest_rotation(a, b);
    }
    let towards = if a[2].abs() < 0.99 { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] };
    let u = unit(sub(towards, scale(dot(a, towards), a)));
    let half = [0, 1, 2].map(|i| [0, 1, 2].map(|j| 2.0 * u[i] * u[j] - f64::from(u8::from(i == j))));
    product(smallest_rotation(scale(-1.0, a), b), half)
}
