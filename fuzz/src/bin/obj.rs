//! Any bytes as OBJ files: a base and its examples, with a zero byte between them.
#![no_main]

use crumple::import::obj_slices;
use crumple_fuzz::{seeds, target};

target!(
    |data| {
        let mut files = data.split(|byte| *byte == 0);
        let base = files.next().unwrap_or_default();
        let examples: Vec<_> = files.take(8).map(|bytes| ("example", bytes)).collect();
        if let Ok(imported) = obj_slices(("base", base), &examples) {
            seeds::build_and_use(imported);
        }
    },
    seeds: seeds::obj
);
