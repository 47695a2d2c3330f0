//! Any bytes as a baked set, with length and checksum made right.
#![no_main]

#[path = "../target.rs"]
mod target;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let mut file = data.to_vec();
    target::repair(&mut file);
    target::load_and_use(file);
});
