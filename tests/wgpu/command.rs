//! `crumple apply --gpu`.

use std::process::Command;

use crate::backend::on_each_device;

#[test]
fn the_command_deforms_on_the_gpu() {
    let program = env!("CARGO_BIN_EXE_crumple");
    let folder = tempfile::tempdir().unwrap();
    let root = env!("CARGO_MANIFEST_DIR");
    let (body, impacts) = (format!("{root}/assets/demo/hood.glb"), format!("{root}/assets/demo/hood.json"));
    let apply = |out: &std::path::Path, gpu: Option<String>| {
        let mut command = Command::new(program);
        command.args(["apply", &body, "--impacts", &impacts, "-o"]).arg(out).args(gpu);
        let output = command.output().unwrap();
        let text = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
        (output.status.success(), text.into_owned())
    };
    let cpu = folder.path().join("cpu.glb");
    assert!(apply(&cpu, None).0);
    on_each_device(|gpu| {
        let name = gpu.device.name.clone();
        let out = folder.path().join("gpu.glb");
        let (ok, text) = apply(&out, Some(format!("--gpu={name}")));
        assert!(ok && text.contains(&name), "{text}");
        if text.contains("the CPU's are the same") {
            assert!(std::fs::read(&cpu).unwrap() == std::fs::read(&out).unwrap());
        } else {
            assert!(text.contains("the CPU's positions are within"), "{text}");
        }
    });
    let (ok, text) = apply(&folder.path().join("none.glb"), Some("--gpu=a card that nobody has".into()));
    assert!(!ok && text.contains("a card that nobody has") && text.contains("there are"), "{text}");
    assert!(!folder.path().join("none.glb").exists());
}
