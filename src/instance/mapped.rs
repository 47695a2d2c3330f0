//! Damage that was saved with one revision of an example set, for another revision.

use super::archive::{are_many, of, pack, unpack};
use crate::base::error::{Error, reserve};
use crate::damage::mark::Mark;
use crate::damage::saved;
use crate::example::set::ExampleSet;

/// What [`map_damage`] did with the marks.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Mapping {
    /// Marks whose contact has a vertex at the same position in the new set.
    pub kept: usize,
    /// Marks that are now at another position, the nearest vertex.
    pub moved: usize,
    /// Marks left out because the nearest vertex is further than the greatest distance.
    pub too_far: usize,
    /// Marks left out because they tell a blow, and no example of the new set knows its own.
    pub without_blows: usize,
    /// The furthest that a mark moved, m.
    pub distance: f32,
}

/// Maps damage that was saved with the set `from` to the set `to`, another revision of it: a changed mesh, more or fewer
/// vertices, other examples. Returns bytes that [`Instance::load`](super::Instance::load) takes for `to`.
///
/// - A mark goes to the vertex nearest to its contact, at most `max_distance` away, m (0 to infinity).
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
    let mut mapper = Mapper { from, to, max_distance, mapping: Mapping::default() };
    let out = if are_many(bytes) {
        let each = unpack(bytes, None)?.into_iter().enumerate().map(|(at, one)| {
            let stays = !saved::belongs_to(from, one);
            if stays { Ok(one.to_vec()) } else { mapper.one(one).map_err(|error| of(at, error)) }
        });
        pack(each.collect::<Result<Vec<_>, _>>()?.into_iter())
    } else {
        mapper.one(bytes)?
    };
    Ok((out, mapper.mapping))
}

struct Mapper<'a> {
    from: &'a ExampleSet,
    to: &'a ExampleSet,
    max_distance: f32,
    mapping: Mapping,
}

impl Mapper<'_> {
    /// Maps the saved damage of one instance.
    fn one(&mut self, bytes: &[u8]) -> Result<Vec<u8>, Error> {
        let before = saved::marks(self.from, bytes)?;
        let mut marks: Vec<Mark> = reserve(before.len(), "marks")?;
        for mark in before {
            marks.extend(self.mark(mark)?);
        }
        marks.sort_by_key(Mark::key);
        Ok(saved::of_marks(self.to, &marks))
    }

    fn mark(&mut self, mark: Mark) -> Result<Option<Mark>, Error> {
        if mark.told == 1 && !self.to.predicts_blows() {
            self.mapping.without_blows += 1;
            return Ok(None);
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
        Ok(Some(Mark { contact: nearest.vertex, ..mark }))
    }
}
