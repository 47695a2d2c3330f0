//! Crumple in Bevy's render world: records into a command buffer of Bevy's, into the vertex buffer that Bevy allocated.
//!
//! Bevy 0.19 has wgpu 29, and Crumple's feature `wgpu` another version, so what the two share is Vulkan: wgpu's `as_hal` gives the
//! raw handles.

use bevy::asset::AssetId;
use bevy::prelude::*;
use bevy::render::extract_resource::{ExtractResource, ExtractResourcePlugin};
use bevy::render::mesh::RenderMesh;
use bevy::render::mesh::allocator::{MeshAllocator, MeshAllocatorSettings};
use bevy::render::render_asset::RenderAssets;
use bevy::render::render_resource::{BufferUsages, CommandEncoderDescriptor};
use bevy::render::renderer::{RenderDevice, RenderQueue};
use bevy::render::{Render, RenderApp, RenderSystems};
use crumple::Instance;
use crumple::vulkan::vk::{AccessFlags, BufferUsageFlags, Format, PipelineStageFlags};
use crumple::vulkan::{Access, BufferDef, BufferId, Device, DeviceDef, Job, Stream, Target, TargetDef, vk};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use wgpu::hal::api::Vulkan;

/// The body and its mesh; the main world hits, the render world records.
#[derive(Resource, Clone, ExtractResource)]
pub struct Dented {
    pub mesh: AssetId<Mesh>,
    pub instance: Arc<Mutex<Instance>>,
}

pub struct DentsPlugin;

impl Plugin for DentsPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(ExtractResourcePlugin::<Dented>::default());
        // After the meshes of the frame are in their buffers, and before anything is drawn.
        let record = record.in_set(RenderSystems::PrepareBindGroups).run_if(resource_exists::<Dented>);
        app.sub_app_mut(RenderApp).add_systems(Render, record);
    }

    fn finish(&self, app: &mut App) {
        let world = app.sub_app_mut(RenderApp).world_mut();
        // Before the allocator is made: what writes a vertex buffer by a compute shader needs STORAGE.
        world.resource_mut::<MeshAllocatorSettings>().extra_buffer_usages |= BufferUsages::STORAGE;
        let device = world.resource::<RenderDevice>().wgpu_device().clone();
        let recorder = Recorder::new(device).expect("Bevy on Vulkan");
        world.insert_resource(recorder);
    }
}

#[derive(Resource)]
struct Recorder {
    crumple: Device,
    /// Where the mesh is, and what is shown there.
    place: Option<Place>,
    frame: u64,
    /// The last frame that the device is done with.
    done: Arc<AtomicU64>,
    /// Behind the rest: it goes last.
    device: wgpu::Device,
}

struct Place {
    buffer: bevy::render::render_resource::BufferId,
    id: BufferId,
    target: Target,
}

impl Recorder {
    fn new(device: wgpu::Device) -> Option<Self> {
        let def = {
            // SAFETY: the handles are only read, and used as long as the device is kept.
            let hal = unsafe { device.as_hal::<Vulkan>() }?;
            let instance = hal.shared_instance();
            DeviceDef::new(
                instance.entry().static_fn().get_instance_proc_addr,
                instance.raw_instance().handle(),
                hal.raw_physical_device(),
                hal.raw_device().handle(),
                hal.queue_family_index(),
            )
        };
        // SAFETY: handles of one device, which is kept until this is dropped.
        let crumple = unsafe { Device::new(&def) }.expect("a device of Vulkan 1.1");
        Some(Recorder { crumple, place: None, frame: 0, done: Arc::default(), device })
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        let _ = self.device.poll(wgpu::PollType::wait_indefinitely());
        self.crumple.completed(self.frame);
    }
}

/// The VkBuffer of a buffer. wgpu 29 has no function for that (30 has: `raw_handle`), but tells it first where it tells of the
/// buffer.
fn handle(buffer: &wgpu::Buffer) -> Option<vk::Buffer> {
    // SAFETY: only looked at.
    let hal = unsafe { buffer.as_hal::<Vulkan>() }?;
    let text = format!("{:?}", &*hal);
    let digits = text.strip_prefix("Buffer { raw: 0x")?.split(',').next()?;
    Some(vk::Handle::from_raw(u64::from_str_radix(digits, 16).ok()?))
}

/// Where the mesh's vertices lie: the whole buffer of Bevy's allocator, in which the mesh is one of many.
fn target_def(mesh: &RenderMesh, first: u32, buffer: BufferId) -> TargetDef {
    let layout = mesh.layout.0.layout();
    let stream = |id| {
        let index = mesh.layout.0.attribute_ids().iter().position(|i| *i == id)?;
        Some(Stream {
            offset: layout.attributes[index].offset,
            stride: layout.array_stride,
            format: Format::R32G32B32_SFLOAT,
        })
    };
    let offset = u64::from(first) * layout.array_stride;
    let size = u64::from(mesh.vertex_count) * layout.array_stride;
    TargetDef {
        positions: stream(Mesh::ATTRIBUTE_POSITION.id).expect("a mesh has positions"),
        normals: stream(Mesh::ATTRIBUTE_NORMAL.id),
        ..TargetDef::positions(buffer, offset, size)
    }
}

fn record(
    mut recorder: ResMut<Recorder>,
    dented: Res<Dented>,
    allocator: Res<MeshAllocator>,
    meshes: Res<RenderAssets<RenderMesh>>,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
) {
    let (Some(mesh), Some(slice)) = (meshes.get(dented.mesh), allocator.mesh_vertex_slice(&dented.mesh)) else {
        return;
    };
    let recorder = &mut *recorder;
    let instance = dented.instance.lock().expect("nobody panicked");
    recorder.crumple.completed(recorder.done.load(Ordering::Relaxed));
    if recorder.place.as_ref().is_none_or(|p| p.buffer != slice.buffer.id()) {
        // Bevy's allocator has moved the mesh into another buffer.
        if let Some(old) = recorder.place.take() {
            recorder.crumple.remove_buffer(old.id).expect("a buffer that was added");
        }
        let before = Access {
            stages: PipelineStageFlags::VERTEX_INPUT | PipelineStageFlags::TRANSFER,
            access: AccessFlags::VERTEX_ATTRIBUTE_READ | AccessFlags::TRANSFER_WRITE,
        };
        let def = BufferDef {
            buffer: handle(slice.buffer).expect("Bevy on Vulkan, with wgpu 29"),
            size: slice.buffer.size(),
            usage: BufferUsageFlags::VERTEX_BUFFER | BufferUsageFlags::STORAGE_BUFFER,
            queue_family: vk::QUEUE_FAMILY_IGNORED,
            before,
            after: Access::VERTEX_INPUT,
        };
        // SAFETY: a buffer of this device, which outlives the frames that use it.
        let id = unsafe { recorder.crumple.add_buffer(&def) }.expect("a buffer with STORAGE");
        let def = target_def(mesh, slice.range.start, id);
        let target = recorder.crumple.add_target(instance.example_set(), &def).expect("the mesh fits");
        recorder.place = Some(Place { buffer: slice.buffer.id(), id, target });
    }
    let Some(place) = &mut recorder.place else { return };
    let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor { label: Some("crumple") });
    recorder.frame += 1;
    let (frame, crumple) = (recorder.frame, &mut recorder.crumple);
    let mut jobs = [Job { instance: &instance, target: &mut place.target }];
    // SAFETY: nothing else is encoded; the command buffer is recording, outside a pass, of this device's family.
    let report = unsafe {
        encoder.as_hal_mut::<Vulkan, _, _>(|hal| {
            let commands = hal.expect("Bevy on Vulkan").raw_handle();
            crumple.record(commands, frame, &mut jobs)
        })
    };
    let report = report.expect("recorded");
    queue.submit([encoder.finish()]);
    let done = recorder.done.clone();
    queue.on_submitted_work_done(move || {
        done.fetch_max(frame, Ordering::Relaxed);
    });
    if report.blocks_written > 0 {
        println!("frame {frame}: {} blocks in {} dispatch", report.blocks_written, report.dispatches);
    }
}
