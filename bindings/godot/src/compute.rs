//! Vertices written by Godot's `RenderingDevice`: it executes the passes that [`crumple::graph`] plans.

use crate::node::CrumpleMeshInstance3D;
use crate::tasks;
use crumple::graph::{self, Format, Graph, GraphBuffer, Job, Passes, Stream, Target, TargetDef};
use crumple::{Attribute, DeformJob, Encoding, ExampleSet, Tracker, VertexMemory};
use godot::classes::rendering_device::{ShaderStage, UniformType};
use godot::classes::{RdShaderSpirv, RdUniform, RenderingDevice, RenderingServer};
use godot::prelude::*;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Writes the vertices of nodes into storage buffers of a [RenderingDevice], with compute shaders.
///
/// It is for games that draw with a [RenderingDevice] of their own. A [CrumpleMeshInstance3D] shows itself without this
/// class: Godot 4.6 gives no access to the buffers of a mesh.
///
/// Vertices are floats: 3 for a position (m) and a normal, 4 for a tangent. They are those of the processor, bit for bit, if
/// the device rounds as IEEE 754 requires.
#[derive(GodotClass)]
#[class(no_init, base = RefCounted)]
pub struct CrumpleComputeWriter {
    device: Arc<Mutex<Device>>,
    /// Whether it is the device that draws the game.
    main: bool,
    graph: Graph,
    targets: Vec<Entry>,
    last: i64,
    base: Base<RefCounted>,
}

/// A node, and the place of its vertices.
struct Entry {
    number: i64,
    node: InstanceId,
    set: Arc<ExampleSet>,
    size: usize,
    streams: [Option<Attribute>; 3],
    target: Target,
}

#[godot_api]
impl CrumpleComputeWriter {
    /// Makes a writer for a device: [method RenderingServer.get_rendering_device] or a local one. Free a local device after
    /// the writer. Returns `null` if there is no device, which is printed.
    #[func]
    fn create(device: Option<Gd<RenderingDevice>>) -> Option<Gd<Self>> {
        let Some(device) = device else {
            godot_error!("CrumpleComputeWriter.create: there is no device; use the Forward+ or Mobile renderer");
            return None;
        };
        let main = RenderingServer::singleton().get_rendering_device().is_some_and(|main| main == device);
        let device = Device { id: device.instance_id(), kernels: HashMap::new(), storages: HashMap::new(), work: None };
        let device = Arc::new(Mutex::new(device));
        let (graph, targets) = (Graph::default(), Vec::new());
        Some(Gd::from_init_fn(|base| Self { device, main, graph, targets, last: 0, base }))
    }

    /// Adds a node, and the place of its vertices in a storage buffer of `buffer_size` bytes. Each of the other arguments is
    /// the offset of the first vertex's value and the stride, in bytes, multiples of 4. Zeros omit normals or tangents.
    /// Vertices are counted over all surfaces of triangles, as [method CrumpleMeshInstance3D.get_vertex] does.
    ///
    /// Returns the target's number, or 0 after an error, which is printed. The next [method write] writes every vertex. The
    /// buffer must live until the target is removed.
    #[func]
    fn add_target(
        &mut self,
        node: Option<Gd<CrumpleMeshInstance3D>>,
        buffer: Rid,
        buffer_size: i64,
        positions: Vector2i,
        #[opt(default = Vector2i::ZERO)] normals: Vector2i,
        #[opt(default = Vector2i::ZERO)] tangents: Vector2i,
    ) -> i64 {
        match self.add(node, buffer, buffer_size, [positions, normals, tangents]) {
            Ok(number) => number,
            Err(error) => {
                godot_error!("CrumpleComputeWriter.add_target: {error}");
                0
            }
        }
    }

    /// Removes a target. The buffer keeps what it holds. Targets of freed nodes are removed by [method write].
    #[func]
    fn remove_target(&mut self, target: i64) {
        self.targets.retain(|entry| entry.number != target);
    }

    /// Brings all targets up to date: only what changed since the last call. It records into the device; for a local one call
    /// [method RenderingDevice.submit] afterwards. Call it once a frame, on the main thread, or on that of a local device.
    ///
    /// Returns the number of vertices that it writes, or -1 after an error, which is printed.
    #[func]
    fn write(&mut self) -> i64 {
        match self.plan() {
            Ok((vertices, passes)) => {
                self.on_device(move |device| device.execute(&passes));
                vertices
            }
            Err(error) => {
                godot_error!("CrumpleComputeWriter.write: {error}");
                -1
            }
        }
    }

    /// Returns what the target's buffer should hold, computed by the processor: `buffer_size` bytes, with zeros where no vertex
    /// is. It tells whether a device rounds as the processor does. Returns an empty array after an error, which is printed.
    #[func]
    fn compute_expected(&self, target: i64) -> PackedByteArray {
        self.expected(target).map(PackedByteArray::from).unwrap_or_else(|error| {
            godot_error!("CrumpleComputeWriter.compute_expected: {error}");
            PackedByteArray::new()
        })
    }
}

impl CrumpleComputeWriter {
    fn add(
        &mut self,
        node: Option<Gd<CrumpleMeshInstance3D>>,
        buffer: Rid,
        buffer_size: i64,
        places: [Vector2i; 3],
    ) -> Result<i64, String> {
        let node = node.ok_or("there is no node")?;
        let set = node.bind().set().ok_or("the node has no examples, or was never in the tree")?;
        if buffer.is_invalid() {
            return Err("the buffer is not valid".into());
        }
        let size =
            u64::try_from(buffer_size).map_err(|_| format!("buffer_size is {buffer_size}; it must be above 0"))?;
        let mut streams = [None; 3];
        for ((stream, place), name) in streams.iter_mut().zip(places).zip(["positions", "normals", "tangents"]) {
            let (Ok(offset), Ok(stride)) = (usize::try_from(place.x), usize::try_from(place.y)) else {
                return Err(format!("{name} is {place}; neither number may be below 0"));
            };
            *stream = (place != Vector2i::ZERO).then_some(Attribute { offset, stride, format: Encoding::F32 });
        }
        let graph_buffer = GraphBuffer { number: buffer.to_u64(), size };
        let stream = |i: usize, format| {
            streams[i].map(|a: Attribute| Stream { offset: a.offset as u64, stride: a.stride as u64, format })
        };
        let def = TargetDef {
            positions: stream(0, Format::R32G32B32_SFLOAT).ok_or("positions has no stride")?,
            normals: stream(1, Format::R32G32B32_SFLOAT),
            tangents: stream(2, Format::R32G32B32A32_SFLOAT),
            ..TargetDef::positions(graph_buffer, 0, size)
        };
        let target = self.graph.add_target(&set, &def).map_err(|error| error.to_string())?;
        self.last += 1;
        let (number, node) = (self.last, node.instance_id());
        self.targets.push(Entry { number, node, set, size: size as usize, streams, target });
        Ok(number)
    }

    fn plan(&mut self) -> Result<(i64, Passes), String> {
        let mut nodes = Vec::new();
        self.targets.retain(|entry| {
            let node = Gd::<CrumpleMeshInstance3D>::try_from_instance_id(entry.node);
            let kept = node.is_ok();
            nodes.extend(node);
            kept
        });
        let bound: Vec<_> = nodes.iter().map(Gd::bind).collect();
        for (node, entry) in bound.iter().zip(&self.targets) {
            match node.body().as_mut() {
                Some(body) if Arc::ptr_eq(&body.built.set, &entry.set) => body.instance.fold(),
                _ => return Err(format!("target {}: its node has other examples; remove and add it", entry.number)),
            }
        }
        // Shared, since two targets may show one node.
        let bodies: Vec<_> = bound.iter().map(|node| node.shared_body()).collect();
        let mut jobs: Vec<_> = bodies
            .iter()
            .zip(&mut self.targets)
            .filter_map(|(body, entry)| {
                Some(Job { instance: &body.as_ref()?.instance, target: &mut entry.target })
            })
            .collect();
        let (report, passes) = self.graph.plan(&mut jobs).map_err(|error| error.to_string())?;
        Ok((report.vertices_written as i64, passes.clone()))
    }

    fn expected(&self, target: i64) -> Result<Vec<u8>, String> {
        let entry = self.targets.iter().find(|entry| entry.number == target);
        let entry = entry.ok_or_else(|| format!("there is no target {target}"))?;
        let node = Gd::<CrumpleMeshInstance3D>::try_from_instance_id(entry.node).map_err(|_| "its node was freed")?;
        let node = node.bind();
        let mut body = node.body();
        let instance = &mut body.as_mut().ok_or("its node has no examples")?.instance;
        instance.fold();
        let mut bytes = vec![0; entry.size];
        let [positions, normals, tangents] = entry.streams;
        let positions = positions.ok_or("it has no positions")?;
        let memory = VertexMemory::interleaved(&mut bytes, positions, normals, tangents);
        let memory = memory.map_err(|error| error.to_string())?;
        let mut jobs = [DeformJob { lod: 0, instance, tracker: &mut Tracker::new(), memory }];
        tasks::with(|tasks| crumple::deform(&mut jobs, tasks)).map_err(|error| error.to_string())?;
        Ok(bytes)
    }

    /// Calls `work` where the device may be used: the one that draws the game belongs to the render thread.
    fn on_device(&self, work: impl Fn(&mut Device) + Send + Sync + 'static) {
        let device = self.device.clone();
        let work = move || work(&mut device.lock().unwrap_or_else(PoisonError::into_inner));
        if self.main {
            let call = Callable::from_sync_fn("crumple_compute", move |_| work());
            RenderingServer::singleton().call_on_render_thread(&call);
        } else {
            work();
        }
    }
}

impl Drop for CrumpleComputeWriter {
    fn drop(&mut self) {
        self.on_device(Device::clear);
    }
}

/// What Crumple has on a device, by the numbers of the plans. The buffers of vertices are the game's: their numbers are RIDs.
struct Device {
    id: InstanceId,
    /// Shaders and their pipelines.
    kernels: HashMap<u32, (Rid, Rid)>,
    storages: HashMap<u32, Rid>,
    /// The buffer of the frame's work, and its size in bytes.
    work: Option<(Rid, usize)>,
}

impl Device {
    /// `None` if the game has freed it, and with it all that was on it.
    fn device(&self) -> Option<Gd<RenderingDevice>> {
        Gd::try_from_instance_id(self.id).ok()
    }

    fn execute(&mut self, passes: &Passes) {
        let Some(mut rd) = self.device() else {
            godot_error!("CrumpleComputeWriter.write: the device was freed");
            return;
        };
        for number in &passes.freed {
            if let Some(storage) = self.storages.remove(number) {
                rd.free_rid(storage);
            }
        }
        for upload in &passes.uploads {
            let make = || rd.storage_buffer_create(upload.storage_size as u32);
            let storage = *self.storages.entry(upload.storage).or_insert_with(make);
            update(&mut rd, storage, upload.offset as u32, &upload.words);
        }
        if passes.dispatches.is_empty() {
            return;
        }
        let work = self.work_buffer(&mut rd, 4 * passes.work.len());
        update(&mut rd, work, 0, &passes.work);
        let mut sets = Vec::new();
        for dispatch in &passes.dispatches {
            let kernel = self.kernel(&mut rd, dispatch.kernel);
            let Some(storage) = self.storages.get(&dispatch.storage) else { return };
            let first = uniform_set(&mut rd, &[*storage, work], kernel.0, 0);
            sets.push((kernel.1, [first, uniform_set(&mut rd, &[Rid::new(dispatch.buffer)], kernel.0, 1)]));
        }
        // The engine orders the list after the copies, and before what reads the buffers.
        let list = rd.compute_list_begin();
        for (dispatch, (pipeline, sets)) in passes.dispatches.iter().zip(&sets) {
            rd.compute_list_bind_compute_pipeline(list, *pipeline);
            rd.compute_list_bind_uniform_set(list, sets[0], 0);
            rd.compute_list_bind_uniform_set(list, sets[1], 1);
            let constants = bytes(&dispatch.constants);
            rd.compute_list_set_push_constant(list, &constants, constants.len() as u32);
            rd.compute_list_dispatch(list, dispatch.groups[0], dispatch.groups[1], 1);
        }
        rd.compute_list_end();
        sets.iter().flat_map(|(_, sets)| sets).filter(|set| set.is_valid()).for_each(|set| rd.free_rid(*set));
    }

    fn kernel(&mut self, rd: &mut Gd<RenderingDevice>, number: u32) -> (Rid, Rid) {
        *self.kernels.entry(number).or_insert_with(|| {
            let mut code = RdShaderSpirv::new_gd();
            code.set_stage_bytecode(ShaderStage::COMPUTE, &bytes(&graph::kernel(number).unwrap_or_default()));
            let shader = rd.shader_create_from_spirv(&code);
            (shader, rd.compute_pipeline_create(shader))
        })
    }

    fn work_buffer(&mut self, rd: &mut Gd<RenderingDevice>, size: usize) -> Rid {
        if let Some((buffer, held)) = self.work {
            if held >= size {
                return buffer;
            }
            rd.free_rid(buffer);
        }
        let size = size.next_power_of_two();
        let buffer = rd.storage_buffer_create(size as u32);
        self.work = Some((buffer, size));
        buffer
    }

    fn clear(&mut self) {
        let storages = self.storages.drain().map(|(_, storage)| storage);
        // A shader takes its pipeline with it.
        let shaders = self.kernels.drain().map(|(_, (shader, _))| shader);
        let all: Vec<Rid> = storages.chain(shaders).chain(self.work.take().map(|(work, _)| work)).collect();
        if let Some(mut rd) = self.device() {
            all.into_iter().filter(|rid| rid.is_valid()).for_each(|rid| rd.free_rid(rid));
        }
    }
}

fn update(rd: &mut Gd<RenderingDevice>, buffer: Rid, offset: u32, words: &[u32]) {
    rd.buffer_update(buffer, offset, 4 * words.len() as u32, &bytes(words));
}

fn uniform_set(rd: &mut Gd<RenderingDevice>, buffers: &[Rid], shader: Rid, set: u32) -> Rid {
    let uniforms = buffers.iter().enumerate().map(|(binding, buffer)| {
        let mut uniform = RdUniform::new_gd();
        uniform.set_uniform_type(UniformType::STORAGE_BUFFER);
        uniform.set_binding(binding as i32);
        uniform.add_id(*buffer);
        uniform
    });
    rd.uniform_set_create(&uniforms.collect(), shader, set)
}

fn bytes(words: &[u32]) -> PackedByteArray {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}
