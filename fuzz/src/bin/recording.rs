//! Any bytes as a recording, with the header, the events' lengths and checksums and those of baked sets made right.
#![no_main]

use crumple_fuzz::{recording, seeds, target};

target!(
    |data| {
        let _ = crumple::replay(&recording::repaired(data), 1, &mut |_, call| drop(call.to_string()));
    },
    seeds: seeds::recordings
);
