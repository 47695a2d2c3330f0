//! Divides the long edges of a surface, so that a coarse mesh can show a dent. New vertices come after the old ones, so
//! indices of levels of detail stay right. Whether an edge is divided depends on its ends' places alone, so seams stay
//! closed.

use godot::classes::mesh::ArrayType;
use godot::obj::EngineEnum;
use godot::prelude::*;
use std::collections::HashMap;

/// More vertices than this are refused.
const MOST: usize = 1_000_000;

/// The ends of the edge that each new vertex divides.
type Ends = Vec<[u32; 2]>;

/// Divides the triangles of a surface until no edge is longer than `longest`, m, with all that belongs to its vertices
/// and with its blend shapes.
pub fn divide(arrays: &mut VarArray, shapes: &mut [VarArray], longest: f32) -> Result<(), String> {
    for (kind, name) in [(ArrayType::BONES, "bones"), (ArrayType::WEIGHTS, "weights")] {
        if !arrays.at(kind.ord() as usize).is_nil() {
            return Err(format!("it has {name}; only meshes without a skeleton can be divided"));
        }
    }
    let get = |kind: ArrayType| arrays.at(kind.ord() as usize);
    let points: PackedVector3Array = get(ArrayType::VERTEX).try_to().map_err(|e| e.to_string())?;
    let count = points.len();
    let index: Vec<u32> = match get(ArrayType::INDEX).try_to::<PackedInt32Array>() {
        Ok(index) => index.as_slice().iter().map(|v| *v as u32).collect(),
        Err(_) => (0..count as u32).collect(),
    };
    let triangles: Vec<[u32; 3]> = index.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    if triangles.iter().flatten().any(|v| *v as usize >= count) {
        return Err("an index is not one of a vertex".into());
    }
    let mut positions: Vec<Vector3> = points.to_vec();
    let (triangles, ends) = divided(&mut positions, triangles, longest)?;
    if ends.is_empty() {
        return Ok(());
    }
    for kind in 0..ArrayType::MAX.ord() as usize {
        if kind != ArrayType::INDEX.ord() as usize {
            let value = extended(&arrays.at(kind), count, &ends)?;
            arrays.set(kind, &value);
        }
    }
    for shape in shapes {
        for kind in [ArrayType::VERTEX, ArrayType::NORMAL, ArrayType::TANGENT] {
            let kind = kind.ord() as usize;
            let value = extended(&shape.at(kind), count, &ends)?;
            shape.set(kind, &value);
        }
    }
    let index: PackedInt32Array = triangles.iter().flatten().map(|v| *v as i32).collect();
    arrays.set(ArrayType::INDEX.ord() as usize, &index.to_variant());
    Ok(())
}

fn divided(
    positions: &mut Vec<Vector3>,
    mut triangles: Vec<[u32; 3]>,
    longest: f32,
) -> Result<(Vec<[u32; 3]>, Ends), String> {
    let mut ends = Ends::new();
    loop {
        let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
        let mut next = Vec::with_capacity(triangles.len());
        for t in &triangles {
            let mut middle = |a: u32, b: u32| {
                let (p, q) = (positions[a as usize], positions[b as usize]);
                if p.distance_to(q) <= longest {
                    return None;
                }
                Some(*middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                    positions.push((p + q) * 0.5);
                    ends.push([a.min(b), a.max(b)]);
                    positions.len() as u32 - 1
                }))
            };
            let [a, b, c] = *t;
            match [middle(a, b), middle(b, c), middle(c, a)] {
                [None, None, None] => next.push(*t),
                [Some(m), Some(n), Some(o)] => next.extend([[a, m, o], [m, b, n], [o, n, c], [m, n, o]]),
                // Turned so that the divided edges come first.
                [Some(m), None, None] => next.extend([[a, m, c], [m, b, c]]),
                [None, Some(m), None] => next.extend([[b, m, a], [m, c, a]]),
                [None, None, Some(m)] => next.extend([[c, m, b], [m, a, b]]),
                [Some(m), Some(n), None] => next.extend([[a, m, n], [m, b, n], [a, n, c]]),
                [None, Some(m), Some(n)] => next.extend([[b, m, n], [m, c, n], [b, n, a]]),
                [Some(n), None, Some(m)] => next.extend([[c, m, n], [m, a, n], [c, n, b]]),
            }
            if positions.len() > MOST {
                return Err(format!("edges of {longest} m would give it more than {MOST} vertices"));
            }
        }
        triangles = next;
        if middles.is_empty() {
            return Ok((triangles, ends));
        }
    }
}

/// An array of a surface with the values of the new vertices.
fn extended(value: &Variant, count: usize, ends: &Ends) -> Result<Variant, String> {
    fn mixed<T: Copy>(values: &[T], ends: &Ends, mix: impl Fn(T, T) -> T) -> Vec<T> {
        let mut all = values.to_vec();
        for [a, b] in ends {
            all.push(mix(all[*a as usize], all[*b as usize]));
        }
        all
    }
    // By type: a conversion alone turns arrays of numbers into arrays of vectors.
    Ok(match value.get_type() {
        VariantType::NIL => Variant::nil(),
        VariantType::PACKED_VECTOR3_ARRAY => {
            let v = value.to::<PackedVector3Array>();
            PackedVector3Array::from(mixed(v.as_slice(), ends, |a, b| (a + b) * 0.5)).to_variant()
        }
        VariantType::PACKED_VECTOR2_ARRAY => {
            let v = value.to::<PackedVector2Array>();
            PackedVector2Array::from(mixed(v.as_slice(), ends, |a, b| (a + b) * 0.5)).to_variant()
        }
        VariantType::PACKED_COLOR_ARRAY => {
            let v = value.to::<PackedColorArray>();
            PackedColorArray::from(mixed(v.as_slice(), ends, |a, b| a.lerp(b, 0.5))).to_variant()
        }
        VariantType::PACKED_FLOAT32_ARRAY => {
            let mut all = value.to::<PackedFloat32Array>().to_vec();
            let width = all.len() / count;
            for [a, b] in ends {
                for k in 0..width {
                    let (p, q) = (all[*a as usize * width + k], all[*b as usize * width + k]);
                    // The fourth number of a tangent is a sign.
                    all.push(if width == 4 && k == 3 && p.abs() == 1.0 { p } else { (p + q) * 0.5 });
                }
            }
            PackedFloat32Array::from(all).to_variant()
        }
        other => return Err(format!("it has an array of type {other:?}, which cannot be divided")),
    })
}

#[cfg(test)]
mod tests {
    use super::divided;
    use godot::builtin::Vector3;

    #[test]
    fn no_edge_stays_long_and_the_area_stays() {
        let mut points = vec![Vector3::ZERO, Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.3, 0.0, 2.0)];
        let area = |points: &[Vector3], triangles: &[[u32; 3]]| -> Vector3 {
            let cross = |t: &[u32; 3]| {
                let [a, b, c] = t.map(|v| points[v as usize]);
                (b - a).cross(c - a)
            };
            triangles.iter().map(cross).fold(Vector3::ZERO, |sum, n| sum + n)
        };
        let whole = area(&points, &[[0, 1, 2]]);
        let (triangles, ends) = divided(&mut points, vec![[0, 1, 2]], 0.3).expect("few vertices");
        assert_eq!(points.len(), 3 + ends.len());
        let edges = triangles.iter().flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]);
        let lengths = edges.map(|edge| points[edge[0] as usize].distance_to(points[edge[1] as usize]));
        assert!(lengths.fold(0.0, f32::max) <= 0.3);
        assert!((area(&points, &triangles) - whole).length() < 1e-5, "triangles are turned or missing");
        assert!(divided(&mut points, triangles, 1e-6).is_err());
    }
}
