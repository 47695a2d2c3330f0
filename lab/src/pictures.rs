//! The literature's visual tests (75 random hits), classic beside ours.

use anyhow::Result;

use crate::Options;

/// Draws nothing yet.
pub fn run(_options: &Options) -> Result<()> {
    Ok(())
}
