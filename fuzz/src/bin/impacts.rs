//! Any text as the list of impacts that the command reads.
#![no_main]

use crumple_fuzz::{seeds, target};

#[allow(dead_code)]
#[path = "../../../src/bin/crumple/impacts.rs"]
mod impacts;

target!(
    |data| {
        if let Ok(text) = std::str::from_utf8(data) {
            let _ = impacts::parse(text).map_err(|error| format!("{error:#}"));
        }
    },
    seeds: seeds::impacts
);
