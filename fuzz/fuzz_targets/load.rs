//! Any bytes as a baked set, with length and checksum made right. With `CRUMPLE_SEEDS=FOLDER` small sets are written there first.
#![no_main]

#[path = "../seeds.rs"]
mod seeds;
#[path = "../target.rs"]
mod target;

libfuzzer_sys::fuzz_target!(
    init: {
        if let Some(folder) = std::env::var_os("CRUMPLE_SEEDS") {
            seeds::write(folder.as_ref());
        }
    },
    |data: &[u8]| {
        let mut file = data.to_vec();
        target::repair(&mut file);
        target::load_and_use(file);
    }
);
