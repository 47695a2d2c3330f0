//! Hands the compiler's version to the program, which writes it beside every figure. With the feature `gpu`, the literature's
//! kernel as SPIR-V too.

#[cfg(feature = "gpu")]
#[path = "../build/spirv.rs"]
mod spirv;

use std::process::Command;

fn main() {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let version = Command::new(rustc).arg("--version").output().ok().and_then(|o| String::from_utf8(o.stdout).ok());
    println!("cargo::rustc-env=LAB_RUSTC={}", version.as_deref().unwrap_or("rustc").trim());
    println!("cargo::rerun-if-changed=build.rs");
    #[cfg(feature = "gpu")]
    literature();
}

/// The classic kernel, with its operations as they are written, as the library's own are.
#[cfg(feature = "gpu")]
fn literature() {
    use naga::back::spv::{self, Capability, WriterFlags};
    use naga::valid::{Capabilities, ValidationFlags, Validator};
    const SOURCE: &str = "src/gpu/literature.wgsl";
    println!("cargo::rerun-if-changed={SOURCE}");
    let text = std::fs::read_to_string(SOURCE).unwrap_or_else(|e| panic!("{SOURCE}: {e}"));
    let module = naga::front::wgsl::parse_str(&text).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&text)));
    let info = Validator::new(ValidationFlags::all(), Capabilities::IMMEDIATES)
        .validate(&module)
        .unwrap_or_else(|e| panic!("{}", e.emit_to_string(&text)));
    let options = spv::Options {
        lang_version: (1, 3),
        flags: WriterFlags::empty(),
        capabilities: Some([Capability::Shader].into_iter().collect()),
        use_storage_input_output_16: false,
        force_loop_bounding: false,
        ..spv::Options::default()
    };
    let pipeline = spv::PipelineOptions { shader_stage: naga::ShaderStage::Compute, entry_point: "main".into() };
    let words = spv::write_vec(&module, &info, &options, Some(&pipeline)).expect("SPIR-V is written");
    let words = spirv::without_contraction(&spirv::with_folded_chains(&words));
    let bytes: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).collect();
    let out = std::env::var_os("OUT_DIR").expect("cargo sets OUT_DIR");
    let path = std::path::Path::new(&out).join("literature.spv");
    std::fs::write(&path, bytes).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
}
