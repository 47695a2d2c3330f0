//! Checks the arrays of a file, whatever wrote it. Each check is a scan that compilers can vectorise.

use super::layout::wrong;
use crate::base::error::Error;
use crate::basis::{MOST_WEIGHT, Rows, TILE};
use crate::example::blocks::{DeltaBlocks, GROUP, Numbers, Stored, Width, words};
use crate::mesh::MAX_COORDINATE;
use crate::mesh::nearest::{Leaf, vertices_known};
use crate::mesh::rim::Rim;
use crate::mesh::vertex_blocks::{BLOCK, block_range};
use glam::Vec3;
use std::fmt::Display;

/// The longest displacement that a file may have, m. No built set reaches it, and its square is far below the largest
/// float.
pub(super) const MAX_DISPLACEMENT: f32 = 4.0 * MAX_COORDINATE;

/// Every element must be right, each of which is a `what`.
fn every<T: Copy + Display>(
    (what, name): (&str, &str),
    all: &[T],
    right: impl Fn(T) -> bool,
    expected: impl Display,
) -> Result<(), Error> {
    // Without a branch for each of them.
    if all.iter().fold(true, |good, x| good & right(*x)) {
        return Ok(());
    }
    let at = all.iter().position(|x| !right(*x)).unwrap_or(0);
    Err(wrong(format!("{what} {at} of {name}"), all[at], expected))
}

/// Every number must be finite and at most `limit` in magnitude.
pub(super) fn numbers(name: &str, all: &[f32], limit: f32) -> Result<(), Error> {
    every(("number", name), all, |x| x.abs() <= limit, format_args!("finite and within {limit:e}"))
}

/// Every vector must have length 1, to a thousandth.
pub(super) fn units(name: &str, all: &[Vec3]) -> Result<(), Error> {
    every(("vector", name), all, |v| (v.length_squared() - 1.0).abs() <= 2e-3, "of length 1")
}

/// Every index must be below `len`, which is below 2^32.
pub(super) fn indices(name: &str, all: &[u32], len: usize) -> Result<(), Error> {
    every(("index", name), all, |i| (i as usize) < len, format_args!("below {len}"))
}

/// The number must be finite, from `low` to `high`.
pub(super) fn between(name: impl Display, x: f32, low: f32, high: f32) -> Result<(), Error> {
    if x >= low && x <= high { Ok(()) } else { Err(wrong(name, x, format!("{low:e} to {high:e}"))) }
}

/// All vertices of the leaves must be below `vertices`.
pub(super) fn leaves(all: &[Leaf], vertices: usize) -> Result<(), Error> {
    if vertices_known(all, vertices) { Ok(()) } else { Err(no_tree()) }
}

pub(super) fn no_tree() -> Error {
    wrong("the spatial index", "no tree of the mesh's vertices", "one, with all its nodes")
}

/// Tiles must follow each other, with nodes that exist, weights whose sums stay exact, and the same weights for all vertices at one
/// position.
pub(super) fn rows(rows: &Rows, weld: &[u32], nodes: usize) -> Result<(), Error> {
    indices("section tile nodes", &rows.nodes, nodes)?;
    let mut first = 0;
    for (t, tile) in rows.tiles.iter().enumerate() {
        if tile.first != first || tile.count % 2 != 0 || tile.count as usize > rows.nodes.len() - first as usize {
            let value = format!("{} and {}", tile.first, tile.count);
            let expected = format!("{first} and an even number within section tile nodes");
            return Err(wrong(format!("the first node and the number of nodes of tile {t}"), value, expected));
        }
        first += tile.count;
        let mut sums = [0u32; TILE];
        for pairs in rows.weights_of(t).chunks_exact(2 * TILE) {
            for (sum, pair) in sums.iter_mut().zip(pairs.chunks_exact(2)) {
                *sum += u32::from(pair[0].unsigned_abs()) + u32::from(pair[1].unsigned_abs());
            }
        }
        let most = sums.into_iter().max().unwrap_or(0);
        if tile.most != most || most > MOST_WEIGHT as u32 {
            let expected = format!("{most}, the largest in section weights, and at most {MOST_WEIGHT}");
            return Err(wrong(format!("the sum of weights of tile {t}"), tile.most, expected));
        }
    }
    if first as usize != rows.nodes.len() {
        return Err(wrong("the length of section tile nodes", rows.nodes.len(), format!("{first}, as tiles have")));
    }
    for (at, unit) in rows.slope_units.iter().enumerate() {
        between(format_args!("slope unit {at}"), *unit, f32::MIN_POSITIVE, f32::MAX)?;
    }
    let row = |v: usize| {
        let mut row: Vec<(u32, i32)> = rows.of(v as u32).collect();
        row.sort_unstable();
        row
    };
    match (0..weld.len()).find(|v| weld[*v] as usize != *v && row(*v) != row(weld[*v] as usize)) {
        Some(v) => Err(wrong(format!("the weights of vertex {v}"), "others", format!("those of vertex {}", weld[v]))),
        None => Ok(()),
    }
}

/// Each vertex must map to the lowest vertex at its position, and that vertex to itself. The indices are in range.
pub(super) fn weld(weld: &[u32], positions: &[Vec3]) -> Result<(), Error> {
    let bits = |p: Vec3| p.to_array().map(f32::to_bits);
    for (v, w) in weld.iter().enumerate().filter(|(v, w)| *v != **w as usize) {
        let w = *w as usize;
        if w > v || weld[w] as usize != w || bits(positions[w]) != bits(positions[v]) {
            return Err(wrong(format!("the weld of vertex {v}"), w, "the lowest vertex at its position"));
        }
    }
    Ok(())
}

/// Checks the windows of a mesh with this number of vertices, on a body with this diagonal (m).
pub(super) fn rim(rim: &Rim, vertices: usize) -> Result<(), Error> {
    let blocks = vertices.div_ceil(BLOCK);
    if rim.blocks.len() != blocks && !(rim.blocks.is_empty() && rim.windows.is_empty()) {
        return Err(wrong("the number of rim blocks", rim.blocks.len(), format!("{blocks}, or none")));
    }
    let known = |w: &u32| *w == Rim::CLEAR || (*w as usize) < rim.windows.len();
    if let Some(at) = rim.blocks.iter().position(|w| !known(w)) {
        let most = rim.windows.len();
        return Err(wrong(format!("the window of block {at}"), rim.blocks[at], format!("below {most}, or 2^32 - 1")));
    }
    for w in rim.windows.iter() {
        let one = 1f32.to_bits();
        if w.iter().fold(0, |m, x| x.to_bits().max(m)) > one {
            let bad = w.iter().copied().find(|x| x.to_bits() > one).unwrap_or_default();
            return Err(wrong("a factor of section rim windows", bad, "0 to 1"));
        }
    }
    indices("section rim held", &rim.held, vertices)?;
    if !rim.held.is_sorted_by(|a, b| a < b) {
        return Err(wrong("section rim held", "not in order", "increasing"));
    }
    Ok(())
}

/// Checks one example's blocks on a mesh with this number of vertices. `name` identifies the example in errors.
pub(super) fn anchored(a: &DeltaBlocks, vertices: usize, name: &str) -> Result<(), Error> {
    let (mut at, mut next) = (0, 0);
    for (i, h) in a.heads.iter().enumerate() {
        let bad = |field: &str, value: &dyn Display, expected: &dyn Display| {
            Err(wrong(format!("{field} of block {i} of {name}"), value, expected))
        };
        let blocks = vertices.div_ceil(BLOCK);
        if h.block < next || h.block as usize >= blocks {
            return bad("the number", &h.block, &format!("{next} to {}", blocks - 1));
        }
        next = h.block + 1;
        let len = block_range(h.block as usize, vertices).len();
        let possible = u16::MAX >> (BLOCK / GROUP - len.div_ceil(GROUP));
        if (h.groups | h.normal_groups) & !possible != 0 || h.groups | h.normal_groups == 0 {
            let value = format!("{:#x}, {:#x}", h.groups, h.normal_groups);
            return bad("the groups", &value, &format!("some of {possible:#x}"));
        }
        for width in [h.width, h.normal_width] {
            if Width::of(width).is_none_or(|w| !a.steps.whole && w != Width::F32) {
                return bad("a width", &width, &if a.steps.whole { "1, 2 or 4" } else { "4" });
            }
        }
        if h.zero != 0 {
            return bad("the rest", &h.zero, &"0");
        }
        if h.at as usize != at {
            return bad("the place", &h.at, &format!("{at}, where the block before it ends"));
        }
        at += words(h.groups, h.width) + words(h.normal_groups, h.normal_width);
        if at > a.words.len() {
            return bad("the end", &at, &format!("at most {}, the words there are", a.words.len()));
        }
        for (name, stored) in [("a displacement", a.displacements(h)), ("a change of a normal", a.normals(h))] {
            // Beyond this, floats do not hold whole numbers of steps reliably.
            let most = if a.steps.whole { crate::example::blocks::Steps::MOST } else { MAX_COORDINATE };
            if let Numbers::F32(n) = stored.numbers
                && let Err(e) = numbers(name, n, most)
            {
                return bad(name, &e, &format!("finite and within {most:e}"));
            }
            if let Some(v) = (len..len.next_multiple_of(GROUP)).find(|v| stored.at(*v) != Vec3::ZERO) {
                return bad(name, &stored.at(v), &"0 beyond the last vertex");
            }
        }
        let found = length(&a.displacements(h));
        if h.longest != found || found > MAX_DISPLACEMENT {
            return bad("the longest displacement", &h.longest, &format!("{found}, at most {MAX_DISPLACEMENT:e} m"));
        }
    }
    if at != a.words.len() {
        return Err(wrong(format!("the number of words of {name}"), a.words.len(), at));
    }
    Ok(())
}

fn length(stored: &Stored<'_>) -> f32 {
    fn longest<T: Copy + Into<f32>>(numbers: &[T], step: f32) -> f32 {
        let square = |v: &[T]| (Vec3::new(v[0].into(), v[1].into(), v[2].into()) * step).length_squared();
        numbers.chunks_exact(3).map(square).fold(0.0, f32::max).sqrt()
    }
    match stored.numbers {
        Numbers::I8(n) => longest(n, stored.step),
        Numbers::I16(n) => longest(n, stored.step),
        Numbers::F32(n) => longest(n, stored.step),
    }
}
