//! The vertices that a command deforms, on the CPU or on a graphics device.

use crate::table::count;
use anyhow::Result;
use crumple::glam::{Vec3, Vec4};
use crumple::{Instance, Mesh, ThreadPool, Tracker, VertexMemory};
use std::time::{Duration, Instant};

/// The vertices, with the attributes that the mesh has.
#[derive(Clone)]
pub struct Vertices {
    pub positions: Vec<[f32; 3]>,
    pub normals: Option<Vec<[f32; 3]>>,
    pub tangents: Option<Vec<[f32; 4]>>,
}

impl Vertices {
    /// The undeformed mesh.
    pub fn at_rest(mesh: &Mesh) -> Self {
        Vertices {
            positions: mesh.positions().iter().map(Vec3::to_array).collect(),
            normals: mesh.normals().map(|n| n.iter().map(Vec3::to_array).collect()),
            tangents: mesh.tangents().map(|t| t.iter().map(Vec4::to_array).collect()),
        }
    }

    /// The memory for a deform to write to.
    pub fn memory(&mut self) -> Result<VertexMemory<'_>> {
        let Vertices { positions, normals, tangents } = self;
        Ok(VertexMemory::separate(positions, normals.as_deref_mut(), tangents.as_deref_mut())?)
    }
}

/// The deformed mesh.
pub struct Deformed {
    pub vertices: Vertices,
    /// Time to fold the hits and to evaluate every vertex.
    pub time: Duration,
    /// The device and, for a GPU, how its vertices compare with the CPU's.
    pub by: String,
}

impl Deformed {
    /// Deforms on the pool of this many threads, 0 for all cores; then on the GPU whose name contains `gpu`, if there is one given.
    pub fn new(instance: &mut Instance, pool: &ThreadPool, threads: u32, gpu: Option<&str>) -> Result<Self> {
        let mut vertices = Vertices::at_rest(instance.example_set().mesh());
        let start = Instant::now();
        instance.deform(&mut Tracker::new(), vertices.memory()?, pool)?;
        let time = start.elapsed();
        let Some(adapter) = gpu else {
            let by = if threads == 0 { "all cores".into() } else { count(threads as usize, "thread", "threads") };
            return Ok(Deformed { vertices, time, by });
        };
        let mut seen = Vertices::at_rest(instance.example_set().mesh());
        let (adapter, time) = on_gpu(instance, adapter, &mut seen)?;
        let compared = compared(&seen, &vertices);
        let by = format!("{adapter}, including the upload of the mesh and its examples; {compared}");
        Ok(Deformed { vertices: seen, time, by })
    }
}

/// Describes how the GPU's vertices compare with the CPU's.
fn compared(gpu: &Vertices, cpu: &Vertices) -> String {
    if (&gpu.positions, &gpu.normals, &gpu.tangents) == (&cpu.positions, &cpu.normals, &cpu.tangents) {
        return "the CPU's are the same".into();
    }
    let off = |(a, b): (&[f32; 3], &[f32; 3])| (Vec3::from(*a) - Vec3::from(*b)).length();
    let most = gpu.positions.iter().zip(&cpu.positions).map(off).fold(0.0, f32::max);
    format!("the CPU's positions are within {:.1e} mm", most * 1e3)
}

#[cfg(not(feature = "wgpu"))]
fn on_gpu(_: &Instance, _: &str, _: &mut Vertices) -> Result<(String, Duration)> {
    anyhow::bail!("--gpu: this build cannot use a GPU; build it with --features cli,wgpu")
}

/// Deforms an instance on the device whose name contains `adapter`. The instance's hits must be folded. Returns the adapter's name with
/// its graphics interface, and the time from the first upload to the last vertex, without the readback.
#[cfg(feature = "wgpu")]
fn on_gpu(instance: &Instance, adapter: &str, to: &mut Vertices) -> Result<(String, Duration)> {
    use crumple::wgpu::wgpu::{BufferDescriptor, BufferUsages, PollType, VertexFormat};
    use crumple::wgpu::{Device, HeadlessDef, Job, Stream, TargetDef};
    let set = instance.example_set();
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
    device.submit(&mut [Job { instance, target: &mut target }])?;
    device.device().poll(PollType::wait_indefinitely())?;
    let time = start.elapsed();
    device.read_vertices(set, &target, &mut to.memory()?)?;
    Ok((format!("{} ({:?})", info.name, info.backend), time))
}
