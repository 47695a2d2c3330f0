//! A set in several contexts.

use super::context::look_into;
use super::prelude::*;

/// Gives a set to another context too, without a copy, such as one that loads levels on another thread. Destroying the
/// set in one does not affect the other. Both contexts are in use during the call. Add levels of detail before.
/// CRUMPLE_ERROR_INVALID_ARGUMENT: other is context.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_example_set_share(
    context: *mut CrumpleContext,
    set: CrumpleExampleSet,
    other: *mut CrumpleContext,
    out_set: *mut CrumpleExampleSet,
) -> CrumpleResult {
    exclusive("crumple_example_set_share", other, |_, state| {
        let out = Out::new(out_set, "out_set")?;
        if context == other {
            return Err(Failure::invalid("other is context itself; its ids of the set already work there"));
        }
        let entry = look_into(context, |state| Ok(state.sets.get(set, "set")?.clone()))?;
        state.sets.reserve()?;
        granted()?;
        out.answer(state.sets.insert(entry))
    })
}
