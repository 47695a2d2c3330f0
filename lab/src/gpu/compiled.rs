//! What a real driver's compiler makes of the kernels, without a card: Mesa's RADV compiles for an AMD chip that is named in
//! RADV_FORCE_FAMILY, and tells the number of instructions, the registers and how many subgroups fit on a SIMD.

use std::ffi::CStr;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use ash::{Entry, khr, vk};
use clap::Args;
use crumple::vulkan::kernels;

use super::literature;
use crate::table::Table;

/// An RDNA 2, an RDNA 3 and a GCN chip.
const FAMILIES: [&str; 3] = ["NAVI21", "GFX1100", "VEGA10"];
const FAMILY: &str = "RADV_FORCE_FAMILY";
const DRIVERS: &str = "/usr/share/vulkan/icd.d";
/// RADV's names of what is shown.
const STATISTICS: [&str; 6] =
    ["Instructions", "Branches", "VGPRs", "Subgroups per SIMD", "Latency", "Inverse Throughput"];

/// What the compiler is told.
#[derive(Args, Debug, Clone)]
pub struct Options {
    /// Writes compiled.csv here
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// Shows the table, from one process for each chip: the driver reads the chip's name when it is loaded.
pub fn run(options: &Options) -> Result<()> {
    if let Ok(family) = std::env::var(FAMILY) {
        return compile(&family);
    }
    let Some(driver) = driver() else {
        println!("compiled: left out, since Mesa's RADV is not there: apt-get install mesa-vulkan-drivers");
        return Ok(());
    };
    let columns: Vec<String> = ["chip", "driver", "kernel"].into_iter().chain(STATISTICS).map(str::to_owned).collect();
    let columns: Vec<String> = columns.iter().map(|c| c.to_lowercase().replace(' ', "_")).collect();
    let mut table = Table::new(&columns.iter().map(String::as_str).collect::<Vec<_>>());
    table.comment("command", "cargo xtask bench --gpu --only compiled");
    println!("compiled: by RADV, which assumes the trip counts of loops\n  {}", columns.join("  "));
    for family in FAMILIES {
        let mut compiler = Command::new(std::env::current_exe()?);
        compiler.arg("compiled").env(FAMILY, family).env("VK_DRIVER_FILES", &driver);
        let output = compiler.output().context("starting the compiler's process")?;
        ensure!(output.status.success(), "{family}: {}", String::from_utf8_lossy(&output.stderr));
        for row in String::from_utf8(output.stdout)?.lines() {
            println!("  {}", row.replace('\t', "  "));
            table.row(row.split('\t'))?;
        }
    }
    if let Some(out) = &options.out {
        table.write(out, "compiled.csv")?;
    }
    Ok(())
}

fn driver() -> Option<PathBuf> {
    let files = Path::new(DRIVERS).read_dir().ok()?;
    let named = |p: &PathBuf| p.file_name().is_some_and(|n| n.to_string_lossy().starts_with("radeon_icd"));
    files.filter_map(|f| Some(f.ok()?.path())).find(named)
}

/// Compiles every kernel in this process, and prints a line for each.
fn compile(family: &str) -> Result<()> {
    // SAFETY: the system's loader; everything below is destroyed with the process.
    let entry = unsafe { Entry::load() }?;
    let app = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_2);
    let info = vk::InstanceCreateInfo::default().application_info(&app);
    // SAFETY: valid arguments, here and below.
    let instance = unsafe { entry.create_instance(&info, None) }?;
    // SAFETY: as above.
    let physical = *unsafe { instance.enumerate_physical_devices() }?.first().context("no device")?;
    let mut names = vk::PhysicalDeviceDriverProperties::default();
    // SAFETY: as above.
    unsafe {
        instance.get_physical_device_properties2(
            physical,
            &mut vk::PhysicalDeviceProperties2::default().push_next(&mut names),
        );
    }
    let driver = names.driver_info_as_c_str()?.to_string_lossy().replace(',', "");
    let queues = [vk::DeviceQueueCreateInfo::default().queue_priorities(&[1.0])];
    let extensions = [khr::pipeline_executable_properties::NAME.as_ptr()];
    let mut feature =
        vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default().pipeline_executable_info(true);
    let info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_extension_names(&extensions)
        .push_next(&mut feature);
    // SAFETY: as above.
    let device = unsafe { instance.create_device(physical, &info, None) }?;
    let statistics = khr::pipeline_executable_properties::Device::new(&instance, &device);
    let layout = layout(&device)?;
    let theirs = ("the literature's".to_owned(), literature::words(128));
    for (name, words) in [theirs].into_iter().chain(kernels()) {
        let info = vk::ShaderModuleCreateInfo::default().code(&words);
        // SAFETY: valid SPIR-V with the layout's bindings.
        let found = unsafe {
            let module = device.create_shader_module(&info, None)?;
            let stage = vk::PipelineShaderStageCreateInfo::default()
                .stage(vk::ShaderStageFlags::COMPUTE)
                .module(module)
                .name(c"main");
            let info = vk::ComputePipelineCreateInfo::default()
                .flags(vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR)
                .stage(stage)
                .layout(layout);
            let pipelines = device.create_compute_pipelines(vk::PipelineCache::null(), &[info], None);
            let pipeline = pipelines.map_err(|(_, e)| e)?[0];
            let of = vk::PipelineExecutableInfoKHR::default().pipeline(pipeline);
            statistics.get_pipeline_executable_statistics(&of)?
        };
        let value = |name: &str| {
            let named = |s: &&vk::PipelineExecutableStatisticKHR<'_>| {
                CStr::from_bytes_until_nul(bytemuck::cast_slice(&s.name)).is_ok_and(|n| n.to_bytes() == name.as_bytes())
            };
            // SAFETY: RADV's statistics are 64-bit integers.
            found.iter().find(named).map_or("–".to_owned(), |s| unsafe { s.value.u64 }.to_string())
        };
        println!("{family}\t{driver}\t{name}\t{}", STATISTICS.map(value).join("\t"));
    }
    Ok(())
}

/// Four sets of eight buffers, and room for immediates: more than any kernel has.
fn layout(device: &ash::Device) -> Result<vk::PipelineLayout> {
    let binding = |n| {
        vk::DescriptorSetLayoutBinding::default()
            .binding(n)
            .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
            .descriptor_count(1)
            .stage_flags(vk::ShaderStageFlags::COMPUTE)
    };
    let bindings: Vec<_> = (0..8).map(binding).collect();
    let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
    let constants = [vk::PushConstantRange::default().stage_flags(vk::ShaderStageFlags::COMPUTE).size(64)];
    // SAFETY: valid arguments.
    unsafe {
        let sets = [device.create_descriptor_set_layout(&info, None)?; 4];
        let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets).push_constant_ranges(&constants);
        Ok(device.create_pipeline_layout(&info, None)?)
    }
}
