use std::collections::BTreeSet;

use super::aims::GOALS;
use super::*;

#[test]
fn the_tables_hold_together() {
    let names: BTreeSet<&str> = WORKLOADS.iter().map(|w| w.name).collect();
    assert_eq!(names.len(), WORKLOADS.len(), "names of workloads differ");
    for w in WORKLOADS {
        assert!(w.sizes.iter().all(|s| s.is_sorted() && s.is_empty() == (w.name == "library")), "{}", w.name);
        assert!(w.name.chars().all(|c| c.is_ascii_lowercase()), "{}", w.name);
    }
    let record = WORKLOADS.iter().find(|w| w.name == "record").unwrap();
    assert!(record.sizes[..3].iter().all(|s| s.last() == Some(&1000)), "what the aim is for");
    let goals: BTreeSet<&str> = GOALS.iter().map(|g| g.name).collect();
    assert_eq!(goals.len(), GOALS.len(), "names of aims differ");
    assert!(GOALS.iter().all(|g| !g.about.is_empty()));
}

/// Every workload at its smallest on each device there is: results agree with the CPU's, every aim stands beside a figure, and
/// what is written can be read. Left out aloud where there is no driver; CRUMPLE_REQUIRE_GPU asks for one.
#[test]
fn every_workload_runs() {
    let devices = match Loader::open().and_then(|loader| loader.devices()) {
        Ok(devices) => devices,
        Err(e) if std::env::var("CRUMPLE_REQUIRE_GPU").is_ok_and(|v| v != "0") => panic!("{e:#}"),
        Err(e) => return eprintln!("left out: {e:#}"),
    };
    // Any file will do.
    let library = std::env::current_exe().unwrap();
    for gpu in &devices {
        let bench = Bench::new(gpu, Scale::Least, Some(library.clone())).unwrap();
        for w in WORKLOADS {
            bench.run(w).unwrap_or_else(|e| panic!("{} on {}: {e:#}", w.name, gpu.name));
        }
        let findings = bench.findings.borrow();
        let names: BTreeSet<&str> = findings.rows().iter().map(|r| r.name.as_str()).collect();
        assert_eq!(names.len(), findings.rows().len(), "names of figures differ: {names:?}");
        for goal in GOALS {
            let stands = findings
                .rows()
                .iter()
                .any(|r| r.aim == Some(goal.aim) && r.judged == (goal.everywhere || !gpu.software));
            assert!(stands, "no figure beside the aim {:?}", goal.name);
        }
        let directory = std::env::temp_dir().join(format!("crumple-lab-gpu-{}", std::process::id()));
        let path = findings.write(gpu, &directory, "a test").unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::remove_dir_all(&directory).unwrap();
        let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
        assert_eq!(reader.records().filter(|r| r.is_ok()).count(), findings.rows().len());
    }
}
