//! Looks for what probably is not meant: other units, other axes, absolute targets.

use super::Imported;
use super::words::cut;
use crate::base::math::Aabb;
use crate::example::data::{Deltas, ExampleData};
use glam::Vec3;

/// A body wider than this is probably in another unit, m.
const LARGE: f32 = 100.0;

/// Appends what is odd about a body.
pub(super) fn look(imported: &Imported, notes: &mut Vec<String>) {
    let positions: Vec<Vec3> = imported.mesh.positions.iter().map(|p| Vec3::from(*p)).collect();
    let bounds = Aabb::of_slice(&positions);
    let size = bounds.diagonal();
    let scale = imported
        .node_transform
        .map_or(1.0, |columns| glam::Mat4::from_cols_array_2d(&columns).determinant().abs().cbrt());
    if size * scale > LARGE {
        notes.push(format!(
            "the body is {:.0} m across; if the file's unit is the centimetre, give --unit cm",
            size * scale
        ));
    }
    let is_absolute = |example: &&ExampleData| is_absolute(example, &positions, size);
    let absolute: Vec<&ExampleData> = imported.examples.iter().filter(is_absolute).collect();
    if let Some(first) = absolute.first() {
        notes.push(format!(
            "'{}'{} of {} examples seem to hold positions instead of displacements: they move most vertices by their own \
             coordinates; export relative targets",
            cut(&first.name),
            if absolute.len() == 1 { ", 1".to_owned() } else { format!(" and others, {}", absolute.len()) },
            imported.examples.len()
        ));
        return;
    }
    let deepest = |example: &ExampleData| values(example).map(|(_, v)| v.length()).fold(0.0, f32::max);
    let worst = imported.examples.iter().map(|example| (example, deepest(example))).max_by(|a, b| a.1.total_cmp(&b.1));
    let Some((example, depth)) = worst.filter(|(_, depth)| *depth > size && size > 0.0) else { return };
    let more = imported.examples.iter().filter(|other| deepest(other) > size).count() - 1;
    let others = if more == 0 { String::new() } else { format!(" (as {more} others)") };
    notes.push(format!(
        "'{}' moves a vertex by {depth:.3} m{others}, more than the body's size of {size:.3} m; {}",
        cut(&example.name),
        guess(example, &positions, size)
    ));
}

/// The displacements of an example that are not zero.
fn values(example: &ExampleData) -> impl Iterator<Item = (u32, Vec3)> {
    let (indices, values) = match &example.positions {
        Deltas::Sparse { indices, values } => (indices.as_slice(), values.as_slice()),
        Deltas::Full(_) => (&[][..], &[][..]),
    };
    indices.iter().copied().zip(values.iter().map(|v| Vec3::from(*v)))
}

/// Whether most vertices are moved by about their own coordinates.
fn is_absolute(example: &ExampleData, positions: &[Vec3], size: f32) -> bool {
    let near = |(v, d): &(u32, Vec3)| (*d - positions[*v as usize]).length() <= 1e-3 * size && d.length() > 0.01 * size;
    let count = values(example).filter(near).count();
    count >= 3 && 2 * count > positions.len()
}

/// What an example that moves the body by more than its size probably is.
fn guess(example: &ExampleData, positions: &[Vec3], size: f32) -> String {
    let mut after = positions.to_vec();
    values(example).for_each(|(v, d)| after[v as usize] += d);
    let ratio = Aabb::of_slice(&after).diagonal() / size;
    let units = [
        (1000.0, "millimetres"),
        (100.0, "centimetres"),
        (39.37, "inches"),
        (0.01, "another unit"),
        (0.001, "another unit"),
    ];
    if let Some((times, name)) = units.iter().find(|(times, _)| (ratio / times - 1.0).abs() < 0.3) {
        let times =
            if *times > 1.0 { format!("{times} times as large") } else { format!("1/{:.0} as large", 1.0 / times) };
        return format!("it is {times}: is it in {name}? Export base and examples in one unit");
    }
    let off = |turned: fn(Vec3) -> Vec3| {
        let all = after.iter().zip(positions).map(|(a, p)| (turned(*a) - *p).length());
        all.fold(0.0, f32::max)
    };
    let turns: [fn(Vec3) -> Vec3; 3] =
        [|p| Vec3::new(p.x, p.z, p.y), |p| Vec3::new(p.x, -p.z, p.y), |p| Vec3::new(p.x, p.z, -p.y)];
    if turns.into_iter().any(|turned| off(turned) < 0.5 * size) {
        return "with y and z exchanged it fits: export base and examples with the same axes".into();
    }
    "is it in another unit, turned, or of another mesh?".into()
}
