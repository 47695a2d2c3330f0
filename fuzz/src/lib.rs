//! What the fuzz targets share. A target is a file of `src/bin`: one call of [`target!`].

pub mod baked;
pub mod calls;
pub mod scene;
pub mod seeds;

pub use libfuzzer_sys;

/// Makes a program of libFuzzer that runs `run` with bytes. With `CRUMPLE_SEEDS=FOLDER` it first writes the seeds to that
/// folder: pairs of a file name and bytes.
#[macro_export]
macro_rules! target {
    ($run:expr, seeds: $seeds:expr) => {
        use $crate::libfuzzer_sys;
        libfuzzer_sys::fuzz_target!(init: $crate::begin($seeds), |data: &[u8]| {
            // The type annotation of a function lets a target pass a function or a closure.
            let run: fn(&[u8]) = $run;
            run(data)
        });
    };
}

/// What a target does before it is run.
pub fn begin(seeds: fn() -> seeds::Seeds) {
    let Some(folder) = std::env::var_os("CRUMPLE_SEEDS") else { return };
    seeds::write(seeds, folder.as_ref());
}
