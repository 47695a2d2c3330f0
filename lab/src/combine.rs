//! How several dents combine.

use anyhow::Result;

use crate::Options;

/// Writes nothing yet.
pub fn run(_options: &Options) -> Result<()> {
    Ok(())
}
