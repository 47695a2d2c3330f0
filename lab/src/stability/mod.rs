//! Sweeps over what breaks methods: impulses, frame rates, orders, scales, bad meshes.

use anyhow::Result;

use crate::Options;

/// Writes nothing yet; will write `stability_*.csv`.
pub fn run(_options: &Options) -> Result<()> {
    Ok(())
}
