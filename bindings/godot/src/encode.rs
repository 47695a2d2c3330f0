//! Godot's packing of normals and tangents: octahedral, two numbers of 16 bits. The arithmetic is that of Godot's
//! `Vector3::octahedron_encode`, so an undamaged mesh gets the bytes that Godot gave it.

/// A unit vector on the octahedron, each number 0 to 1.
fn octahedron(v: [f32; 3]) -> [f32; 2] {
    let length = v[0].abs() + v[1].abs() + v[2].abs();
    if length == 0.0 || !length.is_finite() {
        return [0.5, 0.5];
    }
    let n = v.map(|x| x / length);
    let sign = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
    let (x, y) =
        if n[2] >= 0.0 { (n[0], n[1]) } else { ((1.0 - n[1].abs()) * sign(n[0]), (1.0 - n[0].abs()) * sign(n[1])) };
    [x * 0.5 + 0.5, y * 0.5 + 0.5]
}

fn packed(o: [f32; 2]) -> [u16; 2] {
    o.map(|x| (x * 65535.0).clamp(0.0, 65535.0) as u16)
}

/// Packs a normal.
pub fn normal(n: [f32; 3]) -> [u16; 2] {
    packed(octahedron(n))
}

/// Packs a tangent; its last number is the handedness, +1 or -1.
pub fn tangent(t: [f32; 4]) -> [u16; 2] {
    let [x, y] = octahedron([t[0], t[1], t[2]]);
    let y = y.max(1.0 / 32767.0) * 0.5 + 0.5;
    let packed = packed([x, if t[3] >= 0.0 { y } else { 1.0 - y }]);
    // Godot writes the one of these two, which mean the same, that it does not take for compressed data.
    if packed == [0, 65535] { [65535, 65535] } else { packed }
}

#[cfg(test)]
mod tests {
    use super::{normal, tangent};

    #[test]
    fn axes_lie_where_godot_puts_them() {
        assert_eq!(normal([0.0, 0.0, 1.0]), [32767, 32767]);
        assert_eq!(normal([1.0, 0.0, 0.0]), [65535, 32767]);
        assert_eq!(normal([0.0, 0.0, -1.0]), [65535, 65535]);
        assert_eq!(tangent([1.0, 0.0, 0.0, 1.0]), [65535, 49151]);
        assert_eq!(tangent([1.0, 0.0, 0.0, -1.0]), [65535, 16383]);
    }
}
