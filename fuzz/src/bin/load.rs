//! Any bytes as a baked set, with length and checksum made right.
#![no_main]

use crumple_fuzz::{baked, seeds, target};

target!(
    |data| {
        let mut file = data.to_vec();
        baked::repair(&mut file);
        baked::load_and_use(file);
    },
    seeds: seeds::baked
);
