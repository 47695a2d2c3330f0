//! The number formats of vertex attributes in the caller's memory, and the octahedral one, which the CPU writes too.

/// The number format of a vertex attribute. Memory of the CPU takes [`F32`](Encoding::F32), and for normals and tangents
/// [`Octahedral16x2`](Encoding::Octahedral16x2).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Encoding {
    /// 32-bit floats: three for positions and normals, four for tangents.
    F32 = 0,
    /// Four 16-bit floats (IEEE binary16), rounded to nearest even. A larger number becomes 65504.
    F16x4 = 1,
    /// Four 16-bit integers; -32767 to 32767 stand for -1 to 1.
    Snorm16x4 = 2,
    /// Four 8-bit integers; -127 to 127 stand for -1 to 1.
    Snorm8x4 = 3,
    /// Two 16-bit integers; 0 to 65535 stand for 0 to 1. They are the coordinates of a normal or tangent on an unfolded
    /// octahedron, as in Godot. A normal's words are `x` and `y` of
    ///
    /// ```text
    /// n = v / (|v.x| + |v.y| + |v.z|)
    /// (a, b) = (n.x, n.y)                                          if n.z >= 0
    ///          ((1 - |n.y|) * sign(n.x), (1 - |n.x|) * sign(n.y))  else, with sign(0) = 1
    /// (x, y) = (a, b) * 0.5 + 0.5
    /// ```
    ///
    /// times 65535, rounded towards zero. A tangent has `y' = max(y, 1/32767) * 0.5 + 0.5` in place of `y` if its fourth
    /// number is 0 or above, else `1 - y'`; of its words (0, 65535) becomes (65535, 65535), which stands for the same vector.
    /// Decoded normals are off by at most 0.0075 degrees, tangents by 0.0115.
    Octahedral16x2 = 4,
}

/// A vector on the unfolded octahedron, each number 0 to 1. A vector without a length is z. The kernels in `src/gpu` do
/// the same operations, and so does Godot's `Vector3::octahedron_encode`.
fn octahedral([x, y, z]: [f32; 3]) -> [f32; 2] {
    let length = x.abs() + y.abs() + z.abs();
    if !(length > 0.0 && length <= f32::MAX) {
        return [0.5, 0.5];
    }
    let [x, y, z] = [x / length, y / length, z / length];
    let sign = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
    let folded = [(1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y)];
    let [a, b] = if z >= 0.0 { [x, y] } else { folded };
    [a * 0.5 + 0.5, b * 0.5 + 0.5]
}

fn words([x, y]: [f32; 2]) -> u32 {
    u32::from((x * 65535.0) as u16) | u32::from((y * 65535.0) as u16) << 16
}

/// A tangent in [`Encoding::Octahedral16x2`], x in the lower half.
pub(crate) fn octahedral_tangent([x, y, z, sign]: [f32; 4]) -> u32 {
    let [x, y] = octahedral([x, y, z]);
    let y = if y > 1.0 / 32767.0 { y } else { 1.0 / 32767.0 } * 0.5 + 0.5;
    let words = words([x, if sign >= 0.0 { y } else { 1.0 - y }]);
    // Godot takes (0, 65535) for compressed data.
    if words == 0xFFFF_0000 { 0xFFFF_FFFF } else { words }
}
