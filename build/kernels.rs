//! Compiles the kernels: WGSL in `src/gpu` to SPIR-V for Vulkan 1.1 in `OUT_DIR`. The `Call` of a dispatch is an immediate (push
//! constant) for Vulkan. Only some wgpu devices have immediates, so it is a uniform buffer for wgpu. wgpu devices that take no
//! SPIR-V get the WGSL with the uniform buffer.

use crate::{layout, spirv};
use naga::back::pipeline_constants::process_overrides;
use naga::back::spv::{self, Capability, WriterFlags};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use std::path::Path;
use std::{env, fs};

const SOURCES: [&str; 2] = ["nodes", "classic"];
/// What some variants of the kernels cannot do.
const OVERRIDES: [&str; 3] = ["NORMALS", "TANGENTS", "PACKED"];

const IMMEDIATE: &str = "var<immediate> call: Call;";
const UNIFORM: &str = "@group(0) @binding(2) var<uniform> call: Call;";
/// `src/wgpu/pipelines.rs` replaces it.
const WORKGROUP: &str = "@workgroup_size(128)";

pub fn build() {
    println!("cargo::rerun-if-changed=src/gpu");
    let out = env::var_os("OUT_DIR").expect("cargo sets OUT_DIR");
    let write = |name: String, bytes: &[u8]| {
        let path = Path::new(&out).join(name);
        fs::write(&path, bytes).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    };
    let read = |name: &str| {
        let path = format!("src/gpu/{name}.wgsl");
        fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"))
    };
    let declared = read("layout");
    let module = naga::front::wgsl::parse_str(&declared).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&declared)));
    write("layout.rs".into(), layout::rust(&module).as_bytes());
    let common = declared + &read("common");
    assert!(common.contains(IMMEDIATE), "src/gpu/common.wgsl does not declare: {IMMEDIATE}");
    let (mut vulkan, mut wgpu) = (String::new(), String::new());
    for source in SOURCES {
        let text = common.clone() + &read(source);
        assert!(text.contains(WORKGROUP), "src/gpu/{source}.wgsl does not declare: {WORKGROUP}");
        let built = |text: &str, name: &str| {
            let (bytes, constant) = variants(text, name);
            write(format!("{name}.spv"), &bytes);
            constant
        };
        if cfg!(feature = "vulkan") {
            vulkan += &built(&text, source);
        }
        if cfg!(feature = "wgpu") {
            let text = text.replacen(IMMEDIATE, UNIFORM, 1);
            wgpu += &built(&text, &format!("{source}_uniform"));
            write(format!("{source}_uniform.wgsl"), text.as_bytes());
        }
    }
    for (name, modules) in [("vulkan", vulkan), ("wgpu", wgpu)] {
        write(format!("{name}_modules.rs"), format!("[{modules}]").as_bytes());
    }
}

/// The SPIR-V with all overrides on, and a `Module` in Rust: the file, and for each override the words that differ without it.
fn variants(text: &str, name: &str) -> (Vec<u8>, String) {
    let all = compile(text, &OVERRIDES);
    let mut off = String::new();
    for one in OVERRIDES {
        let others: Vec<&str> = OVERRIDES.into_iter().filter(|o| *o != one).collect();
        let without = compile(text, &others);
        assert_eq!(all.len(), without.len(), "{name}: {one} changes more than the values of words");
        let changed = all.iter().zip(&without).enumerate().filter(|(_, (a, b))| a != b);
        let changed: Vec<String> = changed.map(|(at, (_, word))| format!("({at}, {word})")).collect();
        off += &format!("(\"{one}\", &[{}]), ", changed.join(", "));
    }
    let file = format!("include_bytes!(concat!(env!(\"OUT_DIR\"), \"/{name}.spv\"))");
    (all.iter().flat_map(|w| w.to_le_bytes()).collect(), format!("Module {{ words: {file}, off: &[{off}] }}, "))
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
        // Every Vulkan 1.1 device has this. A module that asks for more can crash a driver.
        capabilities: Some([Capability::Shader].into_iter().collect()),
        use_storage_input_output_16: false,
        // Every loop ends, and no divisor is 0.
        force_loop_bounding: false,
        emit_int_div_checks: false,
        ..spv::Options::default()
    };
    let pipeline = spv::PipelineOptions { shader_stage: entry.0, entry_point: entry.1.into() };
    let words = spv::write_vec(&module, &info, &options, Some(&pipeline)).expect("SPIR-V is written");
    spirv::without_contraction(&spirv::with_folded_chains(&words))
}
