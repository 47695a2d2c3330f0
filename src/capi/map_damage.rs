//! Damage of one revision of a set for another.

use super::check::{Out, array, write_array};
use super::context::{CrumpleContext, exclusive};
use super::result::CrumpleResult;
use super::types::CrumpleExampleSet;
use crate::instance::mapped::map_damage;
use std::ffi::c_void;

/// What crumple_example_set_map_damage() did with the marks.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleDamageMapping {
    /// Marks whose contact has a vertex at the same position in the new set.
    pub kept: u32,
    /// Marks that are now at another position, the nearest vertex.
    pub moved: u32,
    /// Marks left out because the nearest vertex is further than max_distance.
    pub too_far: u32,
    /// Marks left out because they tell a blow, and no example of the new set knows its own.
    pub without_blows: u32,
    /// The furthest that a mark moved, m.
    pub distance: f32,
    pub reserved: [u32; 3],
}

/// Maps damage that was saved with old_set to set, another revision of it: a changed mesh, other examples. Each mark
/// goes to the nearest vertex, at most max_distance away, m (0 to infinity). A mark that does not fit is left out. data is
/// what crumple_instance_save_damage() or crumple_context_save_damage() gave; in the latter, damage of other sets stays
/// as it is. out_mapping may be null. Errors: CRUMPLE_ERROR_DAMAGE_MISMATCH (not old_set's, or another version, a
/// classic rule, or cut short), CRUMPLE_ERROR_INVALID_ARGUMENT (a mark that old_set cannot have, or max_distance).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_map_damage(
    context: *mut CrumpleContext,
    set: CrumpleExampleSet,
    old_set: CrumpleExampleSet,
    data: *const c_void,
    size: usize,
    max_distance: f32,
    mapped: *mut c_void,
    capacity: usize,
    out_size: *mut usize,
    out_mapping: *mut CrumpleDamageMapping,
) -> CrumpleResult {
    exclusive("crumple_example_set_map_damage", context, |_, state| {
        let (out, mapping) = (Out::new(out_size, "out_size")?, Out::optional(out_mapping, "out_mapping")?);
        let bytes = array(data.cast::<u8>(), size, "data")?;
        let (to, from) = (&state.sets.get(set, "set")?.set, &state.sets.get(old_set, "old_set")?.set);
        let (new, done) = map_damage(from, to, bytes, max_distance)?;
        write_array(&new, mapped.cast::<u8>(), capacity, "mapped", out)?;
        mapping.write(CrumpleDamageMapping {
            kept: done.kept as u32,
            moved: done.moved as u32,
            too_far: done.too_far as u32,
            without_blows: done.without_blows as u32,
            distance: done.distance,
            reserved: [0; 3],
        });
        Ok(())
    })
}
