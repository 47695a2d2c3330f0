//! Physics engines with soft bodies and plasticity on the same impacts, each at several qualities.

use anyhow::Result;

use crate::Options;

/// Writes nothing yet; will write `peers_*.csv`.
pub fn run(_options: &Options) -> Result<()> {
    Ok(())
}
