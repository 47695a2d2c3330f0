//! Damage that was saved with one revision of an example set, for another revision.

use super::archive::{are_many, of, pack, unpack_all};
use crate::base::error::{Error, reserve};
use crate::damage::dent::{frame_rotations, place};
use crate::damage::mark::{Mark, Pair};
use crate::damage::saved;
use crate::damage::told::Told;
use crate::example::example::Example;
use crate::example::set::ExampleSet;
use std::collections::HashMap;

/// What [`map_damage`] did with the marks.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mapping {
    /// Marks whose contact has a vertex at the same position in the new set.
    pub kept: usize,
    /// Marks that are now at another position, the nearest vertex.
    pub moved: usize,
    /// Marks left out because the nearest vertex is further than the greatest distance.
    pub too_far: usize,
    /// Marks left out because an example of theirs is missing in the new set.
    pub without_example: usize,
    /// The furthest that a mark moved, m.
    pub distance: f32,
    /// Indices of the examples, in the old set, that marks left out needed. Sorted.
    pub missing_examples: Vec<u16>,
}

/// Maps damage that was saved with the set `from` to the set `to`, another revision of it: a changed mesh, more or fewer
/// vertices, other examples. Returns bytes that [`Instance::load`](super::Instance::load) takes for `to`.
///
/// - A mark goes to the vertex nearest to its contact, at most `max_distance` away, m (0 to infinity).
/// - An example is the one of the same name. If a set has several of one name, the n-th is the n-th of the other set,
///   which must have as many. If it is missing and `to` predicts displacements, the mark becomes a hit told as the displacement
///   of its contact.
/// - A mark that does not fit is left out as a whole, and counted in the [`Mapping`].
///
/// Both meshes are in the same space: positions are compared as they are. Damage mapped to an equal mesh with the same
/// examples in any order is exact. `bytes` are those of [`Instance::save`](super::Instance::save) or
/// [`save_all`](super::archive::save_all), in which the damage of other sets stays as it is.
///
/// # Errors
/// [`Error::DamageMismatch`] for bytes that are cut short, or of another version or set, a classic rule or changes;
/// [`Error::InvalidArgument`] for a mark that `from` cannot have, or the distance.
pub fn map_damage(
    from: &ExampleSet,
    to: &ExampleSet,
    bytes: &[u8],
    max_distance: f32,
) -> Result<(Vec<u8>, Mapping), Error> {
    if max_distance.is_nan() || max_distance < 0.0 {
        return Err(Error::invalid("max_distance", max_distance, "0 or more, or infinite (m)"));
    }
    let mut mapper = Mapper { from, to, examples: matching(from, to), max_distance, mapping: Mapping::default() };
    let out = if are_many(bytes) {
        let each = unpack_all(bytes)?.into_iter().enumerate().map(|(at, one)| {
            let stays = !saved::belongs_to(from, one);
            if stays { Ok(one.to_vec()) } else { mapper.one(one).map_err(|error| of(at, error)) }
        });
        pack(each.collect::<Result<Vec<_>, _>>()?.into_iter())
    } else {
        mapper.one(bytes)?
    };
    mapper.mapping.missing_examples.sort_unstable();
    mapper.mapping.missing_examples.dedup();
    Ok((out, mapper.mapping))
}

/// The new index of each old example.
fn matching(from: &ExampleSet, to: &ExampleSet) -> Vec<Option<u16>> {
    let by_name = |set| {
        let mut names: HashMap<&str, Vec<u16>> = HashMap::new();
        for (i, e) in ExampleSet::examples(set).iter().enumerate() {
            names.entry(e.name()).or_default().push(i as u16);
        }
        names
    };
    let (old, new) = (by_name(from), by_name(to));
    let mut out = vec![None; from.examples().len()];
    for (name, old) in &old {
        let Some(new) = new.get(name).filter(|new| new.len() == old.len()) else { continue };
        old.iter().zip(new).for_each(|(old, new)| out[usize::from(*old)] = Some(*new));
    }
    out
}

struct Mapper<'a> {
    from: &'a ExampleSet,
    to: &'a ExampleSet,
    examples: Vec<Option<u16>>,
    max_distance: f32,
    mapping: Mapping,
}

impl Mapper<'_> {
    /// Maps the saved damage of one instance.
    fn one(&mut self, bytes: &[u8]) -> Result<Vec<u8>, Error> {
        let entries = saved::entries(self.from, bytes, saved::MARKS, size_of::<Mark>())?;
        let mut marks: Vec<Mark> = reserve(entries.len() / size_of::<Mark>(), "marks")?;
        for (i, bytes) in entries.chunks_exact(size_of::<Mark>()).enumerate() {
            let mark = saved::read_mark(bytes);
            mark.check(self.from, i)?;
            marks.extend(self.mark(mark)?);
        }
        marks.sort_by_key(Mark::key);
        let mut out = saved::header(self.to, saved::MARKS, marks.len());
        marks.iter().for_each(|mark| saved::write_mark(mark, &mut out));
        saved::seal(&mut out);
        Ok(out)
    }

    fn mark(&mut self, mark: Mark) -> Result<Option<Mark>, Error> {
        let mut mapped = mark;
        let mut missing = Vec::new();
        for pair in mapped.pairs.iter_mut().filter(|pair| !pair.is_none() && !mark.is_predicted()) {
            match self.examples[usize::from(pair.example)]
                .filter(|new| fits(&self.to.examples()[usize::from(*new)], *pair))
            {
                Some(new) => pair.example = new,
                None => missing.push(pair.example),
            }
        }
        if !missing.is_empty() {
            let Some(told) = self.as_displacement(&mark) else {
                self.mapping.missing_examples.append(&mut missing);
                self.mapping.without_example += 1;
                return Ok(None);
            };
            mapped = told;
        }
        let position = self.from.mesh().positions()[mark.contact as usize];
        let nearest = self.to.nearest_vertex(position.to_array())?;
        if nearest.distance > self.max_distance {
            self.mapping.too_far += 1;
            return Ok(None);
        }
        // A squared distance can round to 0.
        let stays = self.to.mesh().positions()[nearest.vertex as usize] == position;
        *(if stays { &mut self.mapping.kept } else { &mut self.mapping.moved }) += 1;
        self.mapping.distance = self.mapping.distance.max(nearest.distance);
        Ok(Some(Mark { contact: nearest.vertex, ..mapped }))
    }

    /// A mark of examples as a hit told as the displacement of its contact, if the new set predicts those.
    fn as_displacement(&self, mark: &Mark) -> Option<Mark> {
        self.to.rule().filter(|rule| rule.predicts()[1])?;
        let rotations = frame_rotations(self.from, mark.contact, &mark.pairs);
        let moved = place(self.from, mark.contact, mark.depth, &mark.pairs, &rotations).achieved;
        let normal = self.from.mesh().contact_normal(mark.contact)?;
        let pairs = Told::Displacement(moved.try_normalize()?).pairs(normal);
        Some(Mark { depth: moved.length(), pairs, ..*mark })
    }
}

/// Whether an example can be placed as the pair asks.
fn fits(example: &Example, pair: Pair) -> bool {
    !example.is_empty() && (pair.is_anchored() || example.stamp().is_some())
}
