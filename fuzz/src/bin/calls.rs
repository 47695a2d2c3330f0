//! The C interface, driven by bytes.
#![no_main]

use crumple_fuzz::{calls, seeds, target};

target!(calls::run, seeds: seeds::noise);
