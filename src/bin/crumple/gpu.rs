//! Deformation on a graphics device, for `crumple apply --gpu`.

use crate::vertices::Vertices;
use anyhow::Result;
use crumple::{ExampleSet, Instance};
use std::sync::Arc;
use std::time::Duration;

/// The result of a deformation on a device.
pub struct Done {
    /// The adapter's name and its graphics interface.
    pub adapter: String,
    /// From the first upload to the last vertex, without the readback.
    pub time: Duration,
}

#[cfg(not(feature = "wgpu"))]
pub fn deform(_: &Instance, _: &Arc<ExampleSet>, _: &str, _: &mut Vertices) -> Result<Done> {
    anyhow::bail!("--gpu: this build cannot use a GPU; build it with --features cli,wgpu")
}

/// Deforms an instance on the device whose name contains `adapter`. The instance's hits must be folded.
#[cfg(feature = "wgpu")]
pub fn deform(instance: &Instance, set: &Arc<ExampleSet>, adapter: &str, to: &mut Vertices) -> Result<Done> {
    use crumple::wgpu::wgpu::{BufferDescriptor, BufferUsages, PollType, VertexFormat};
    use crumple::wgpu::{Device, EncodeJob, HeadlessDef, Stream, TargetDef};
    let wanted = Some(adapter).filter(|name| !name.is_empty());
    let mut device = Device::headless(&HeadlessDef { adapter: wanted, ..HeadlessDef::default() })?;
    let info = device.device().adapter_info();
    // A vertex has its position, normal and tangent side by side.
    let mut stride = 0;
    let mut attribute = |there: bool, format: VertexFormat| {
        let stream = Stream { offset: stride, stride: 0, format };
        stride += if there { format.size() } else { 0 };
        there.then_some(stream)
    };
    let positions = attribute(true, VertexFormat::Float32x3);
    let normals = attribute(to.normals.is_some(), VertexFormat::Float32x3);
    let tangents = attribute(to.tangents.is_some(), VertexFormat::Float32x4);
    let [positions, normals, tangents] = [positions, normals, tangents].map(|s| s.map(|s| Stream { stride, ..s }));
    let size = stride * set.vertex_count() as u64;
    let usage = BufferUsages::VERTEX | BufferUsages::STORAGE | BufferUsages::COPY_SRC;
    let buffer = device.device().create_buffer(&BufferDescriptor {
        label: Some("vertices"),
        size,
        usage,
        mapped_at_creation: false,
    });
    let all = TargetDef::positions(&buffer, 0, size);
    let def = TargetDef { positions: positions.unwrap_or(all.positions), normals, tangents, ..all };
    let start = std::time::Instant::now();
    let mut target = device.add_target(set, &def)?;
    device.submit(&mut [EncodeJob { instance, target: &mut target }])?;
    device.device().poll(PollType::wait_indefinitely())?;
    let time = start.elapsed();
    device.read_vertices(set, &target, &mut to.memory()?)?;
    Ok(Done { adapter: format!("{} ({:?})", info.name, info.backend), time })
}
