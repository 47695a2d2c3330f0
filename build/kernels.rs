//! The kernels: WGSL in `src/gpu`, SPIR-V for Vulkan 1.1 in `OUT_DIR`.

use crate::spirv;
use naga::back::pipeline_constants::process_overrides;
use naga::back::spv::{self, Capability, WriterFlags};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use std::path::Path;
use std::{env, fs};

/// Kernel, its source, and the overrides that are on in it.
const KERNELS: &[(&str, &str, &[&str])] = &[
    ("marks_positions", "marks", &[]),
    ("marks_normals", "marks", &["NORMALS"]),
    ("marks_tangents", "marks", &["NORMALS", "TANGENTS"]),
    ("classic_positions", "classic", &[]),
    ("classic_normals", "classic", &["NORMALS"]),
    ("classic_tangents", "classic", &["NORMALS", "TANGENTS"]),
];

pub fn build() {
    println!("cargo::rerun-if-changed=src/gpu");
    let out = env::var_os("OUT_DIR").expect("cargo sets OUT_DIR");
    let read = |name: &str| {
        let path = format!("src/gpu/{name}.wgsl");
        fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"))
    };
    let common = read("common");
    for (name, source, on) in KERNELS {
        let text = common.clone() + &read(source);
        let words = compile(&text, on);
        let bytes: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).collect();
        let path = Path::new(&out).join(format!("{name}.spv"));
        fs::write(&path, bytes).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    }
}

fn compile(text: &str, on: &[&str]) -> Vec<u32> {
    let module = naga::front::wgsl::parse_str(text).unwrap_or_else(|e| panic!("{}", e.emit_to_string(text)));
    let info = Validator::new(ValidationFlags::all(), Capabilities::IMMEDIATES)
        .validate(&module)
        .unwrap_or_else(|e| panic!("{}", e.emit_to_string(text)));
    let constants = on.iter().map(|name| (name.to_string(), 1.0)).collect();
    let entry = (naga::ShaderStage::Compute, "main");
    let (module, info) =
        process_overrides(&module, &info, Some(entry), &constants).expect("every override has a value");
    let options = spv::Options {
        lang_version: (1, 3),
        flags: WriterFlags::empty(),
        // No more than every Vulkan 1.1 device has: a module that asks for more can crash a driver that lacks it.
        capabilities: Some([Capability::Shader].into_iter().collect()),
        use_storage_input_output_16: false,
        // Each loop ends, and no divisor is 0.
        force_loop_bounding: false,
        emit_int_div_checks: false,
        ..spv::Options::default()
    };
    let pipeline = spv::PipelineOptions { shader_stage: entry.0, entry_point: entry.1.into() };
    let words = spv::write_vec(&module, &info, &options, Some(&pipeline)).expect("SPIR-V is written");
    spirv::without_contraction(&spirv::with_folded_chains(&words))
}
