//! Which of the compiler's counters a corpus reaches, for `cargo xtask fuzz --coverage`.

use std::fmt::Write;
use std::path::Path;

/// An entry of the table of places, in the order of the counters.
#[repr(C)]
struct Place {
    address: usize,
    flags: usize,
}

// The linker's names for the begin and the end of the compiler's two tables, and for the begin of the program.
unsafe extern "C" {
    #[link_name = "__start___sancov_cntrs"]
    static FIRST_COUNTER: u8;
    #[link_name = "__stop___sancov_cntrs"]
    static LAST_COUNTER: u8;
    #[link_name = "__start___sancov_pcs"]
    static FIRST_PLACE: Place;
    #[link_name = "__executable_start"]
    static PROGRAM: u8;
}

/// Runs all files of a folder, writes each place of the program to `report` with 1 if one of them reached it, and exits.
pub fn report(run: fn(&[u8]), folder: &Path, report: &Path) -> ! {
    let (first, count) =
        (&raw const FIRST_COUNTER, (&raw const LAST_COUNTER).addr() - (&raw const FIRST_COUNTER).addr());
    let mut reached = vec![false; count];
    for entry in std::fs::read_dir(folder).expect("a corpus") {
        run(&std::fs::read(entry.expect("an entry").path()).expect("a file"));
        for (i, reached) in reached.iter_mut().enumerate() {
            // SAFETY: a counter of this program. Other threads may count meanwhile, which a volatile read allows for.
            *reached |= unsafe { first.add(i).read_volatile() } != 0;
        }
    }
    // SAFETY: the compiler made as many places as counters.
    let places = unsafe { std::slice::from_raw_parts(&raw const FIRST_PLACE, count) };
    let mut text = String::new();
    for (place, reached) in places.iter().zip(reached) {
        // The address of a function that the linker dropped is 0.
        let Some(address) = place.address.checked_sub((&raw const PROGRAM).addr()) else { continue };
        writeln!(text, "{address:x} {}", u8::from(reached)).expect("a string");
    }
    std::fs::write(report, text).expect("a report");
    std::process::exit(0)
}
