//! How near single dents come to the truth, and what they cost.

use anyhow::Result;

use crate::Options;

/// Writes nothing yet.
pub fn run(_options: &Options) -> Result<()> {
    Ok(())
}
