//! A host's render graph, in its simplest form, executes the passes that `crumple::graph` plans.

use std::collections::HashMap;

use ash::vk;
use crumple::graph::{self, Dispatch, Graph, GraphBuffer, Job, Passes, Target, TargetDef};
use crumple::{Error, Instance, InstanceOptions, Rule};

use crate::backend::Encoding;
use crate::gpu::compare::Expected;
use crate::gpu::layout::TestLayout;
use crate::gpu::{folded, hit};
use crate::harness::{Engine, Seen, on_each_device};
use crate::scenes;

/// The host's part: buffers and pipelines by the numbers of the plan.
struct RenderGraph<'e> {
    engine: &'e Engine<'e>,
    set_layouts: [vk::DescriptorSetLayout; 2],
    layout: vk::PipelineLayout,
    pipelines: HashMap<u32, vk::Pipeline>,
    storages: HashMap<u32, Seen>,
    vertices: HashMap<u64, Seen>,
}

impl<'e> RenderGraph<'e> {
    fn new(engine: &'e Engine<'e>) -> Self {
        let binding = |n| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(n)
                .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                .descriptor_count(1)
                .stage_flags(vk::ShaderStageFlags::COMPUTE)
        };
        let set_layouts = [vec![binding(0), binding(1)], vec![binding(0)]].map(|bindings| {
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            // SAFETY: valid arguments, here and below; all is destroyed in `drop`.
            unsafe { engine.device.create_descriptor_set_layout(&info, None) }.unwrap()
        });
        let push = [vk::PushConstantRange::default().stage_flags(vk::ShaderStageFlags::COMPUTE).size(32)];
        let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&set_layouts).push_constant_ranges(&push);
        // SAFETY: as above.
        let layout = unsafe { engine.device.create_pipeline_layout(&info, None) }.unwrap();
        let (pipelines, storages, vertices) = (HashMap::new(), HashMap::new(), HashMap::new());
        RenderGraph { engine, set_layouts, layout, pipelines, storages, vertices }
    }

    fn pipeline(&mut self, number: u32) -> vk::Pipeline {
        *self.pipelines.entry(number).or_insert_with(|| {
            let words = graph::kernel(number).unwrap();
            let device = &self.engine.device;
            // SAFETY: as above.
            unsafe {
                let info = vk::ShaderModuleCreateInfo::default().code(&words);
                let module = device.create_shader_module(&info, None).unwrap();
                let stage = vk::PipelineShaderStageCreateInfo::default()
                    .stage(vk::ShaderStageFlags::COMPUTE)
                    .module(module)
                    .name(c"main");
                let info = vk::ComputePipelineCreateInfo::default().stage(stage).layout(self.layout);
                let pipelines = device.create_compute_pipelines(vk::PipelineCache::null(), &[info], None).unwrap();
                device.destroy_shader_module(module, None);
                pipelines[0]
            }
        })
    }

    fn execute(&mut self, passes: &Passes) {
        self.storages.retain(|number, _| !passes.freed.contains(number));
        for upload in &passes.uploads {
            let size = upload.storage_size;
            let storage = self.storages.entry(upload.storage).or_insert_with(|| self.engine.buffer(size));
            assert_eq!(storage.size, size);
            storage.write(upload.offset, &upload.words);
        }
        if passes.dispatches.is_empty() {
            assert!(passes.work.is_empty());
            return;
        }
        let work = self.engine.buffer(4 * passes.work.len() as u64);
        work.write(0, &passes.work);
        let engine = self.engine;
        let sizes = [vk::DescriptorPoolSize::default()
            .ty(vk::DescriptorType::STORAGE_BUFFER)
            .descriptor_count(3 * passes.dispatches.len() as u32)];
        let info =
            vk::DescriptorPoolCreateInfo::default().max_sets(2 * passes.dispatches.len() as u32).pool_sizes(&sizes);
        // SAFETY: as above.
        let pool = unsafe { engine.device.create_descriptor_pool(&info, None) }.unwrap();
        engine.run(|commands| passes.dispatches.iter().for_each(|d| self.dispatch(commands, pool, d, work.handle)));
        // SAFETY: the device is done.
        unsafe { engine.device.destroy_descriptor_pool(pool, None) };
    }

    fn dispatch(&mut self, commands: vk::CommandBuffer, pool: vk::DescriptorPool, d: &Dispatch, work: vk::Buffer) {
        let (pipeline, device) = (self.pipeline(d.kernel), &self.engine.device);
        let buffers = [self.storages[&d.storage].handle, work, self.vertices[&d.buffer].handle];
        let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&self.set_layouts);
        // SAFETY: as above.
        unsafe {
            let sets = device.allocate_descriptor_sets(&info).unwrap();
            for (i, buffer) in buffers.into_iter().enumerate() {
                let whole = [vk::DescriptorBufferInfo { buffer, offset: 0, range: vk::WHOLE_SIZE }];
                let write = vk::WriteDescriptorSet::default()
                    .dst_set(sets[i / 2])
                    .dst_binding(i as u32 % 2)
                    .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                    .buffer_info(&whole);
                device.update_descriptor_sets(&[write], &[]);
            }
            let (point, compute) = (vk::PipelineBindPoint::COMPUTE, vk::ShaderStageFlags::COMPUTE);
            device.cmd_bind_pipeline(commands, point, pipeline);
            device.cmd_bind_descriptor_sets(commands, point, self.layout, 0, &sets, &[]);
            device.cmd_push_constants(commands, self.layout, compute, 0, bytemuck::bytes_of(&d.constants));
            device.cmd_dispatch(commands, d.groups[0], d.groups[1], 1);
            // The next frame's uploads are copies by the CPU, and dispatches of one buffer need no order.
            let barrier = vk::MemoryBarrier::default()
                .src_access_mask(vk::AccessFlags::SHADER_WRITE)
                .dst_access_mask(vk::AccessFlags::HOST_READ | vk::AccessFlags::SHADER_WRITE);
            let (from, to) = (vk::PipelineStageFlags::COMPUTE_SHADER, vk::PipelineStageFlags::HOST);
            let to = to | vk::PipelineStageFlags::COMPUTE_SHADER;
            device.cmd_pipeline_barrier(commands, from, to, vk::DependencyFlags::empty(), &[barrier], &[], &[]);
        }
    }
}

impl Drop for RenderGraph<'_> {
    fn drop(&mut self) {
        let device = &self.engine.device;
        // SAFETY: nothing uses them any more.
        unsafe {
            self.pipelines.values().for_each(|pipeline| device.destroy_pipeline(*pipeline, None));
            device.destroy_pipeline_layout(self.layout, None);
            self.set_layouts.iter().for_each(|layout| device.destroy_descriptor_set_layout(*layout, None));
        }
    }
}

fn def(layout: &TestLayout, number: u64, size: u64) -> TargetDef {
    let [positions, normals, tangents] = layout.streams.map(|s| s.map(|s| s.0));
    TargetDef {
        lod: layout.lod,
        buffer: GraphBuffer { number, size },
        offset: layout.offset,
        size: layout.size,
        positions: positions.unwrap(),
        normals,
        tangents,
        scale: layout.scale,
        bias: layout.bias,
    }
}

#[test]
fn a_hosts_render_graph_writes_the_vertices() {
    let sets = [scenes::cube_set(), scenes::sheet_set(), scenes::ball_set()];
    let packed = [Encoding::Snorm16x4, Encoding::Octahedral16x2, Encoding::Snorm8x4];
    on_each_device(|engine| {
        let mut host = RenderGraph::new(engine);
        let mut graph = Graph::default();
        let mut instances: Vec<Instance> = (0..9).map(|i| folded(&sets[i % 3], i, i as u64)).collect();
        // Three in one buffer, floats and packed ones in buffers apart.
        let (mut layouts, mut sizes) = (Vec::new(), [8; 3]);
        for (i, instance) in instances.iter().enumerate() {
            let set = instance.example_set();
            let layout = match i / 3 {
                0 => TestLayout::interleaved(set, 0, sizes[0], [Some(Encoding::F32), None, None]),
                1 => TestLayout::everything(set, 0, sizes[1]),
                _ => {
                    let there = TestLayout::everything(set, 0, 0).streams;
                    let encodings = [0, 1, 2].map(|i: usize| there[i].map(|_| packed[i]));
                    TestLayout::interleaved(set, 0, sizes[2], encodings)
                }
            };
            sizes[i / 3] += layout.size + 8;
            layouts.push(layout);
        }
        let mut targets: Vec<Target> = Vec::new();
        for (i, (instance, layout)) in instances.iter().zip(&layouts).enumerate() {
            let number = 100 + i as u64 / 3;
            let size = sizes[i / 3];
            host.vertices.entry(number).or_insert_with(|| engine.buffer(size));
            targets.push(graph.add_target(instance.example_set(), &def(layout, number, size)).unwrap());
        }
        let mut expected: Vec<Expected> = sizes.iter().map(|size| Expected::poison(*size as usize / 4)).collect();
        for frame in 0..4 {
            let mut jobs: Vec<Job<'_, Target>> =
                instances.iter().zip(&mut targets).map(|(instance, target)| Job { instance, target }).collect();
            let (report, passes) = graph.plan(&mut jobs).unwrap();
            assert_eq!(report.dispatches as usize, passes.dispatches.len());
            assert_eq!(passes.uploads.is_empty(), frame > 0);
            assert!(frame > 0 || passes.dispatches.len() == 3);
            host.execute(passes);
            instances.iter_mut().zip(&layouts).enumerate().for_each(|(i, (b, l))| l.expect(b, &mut expected[i / 3]));
            for (i, expected) in expected.iter().enumerate() {
                let got = host.vertices[&(100 + i as u64)].words();
                expected.compare(got, &engine.tested, &format!("buffer {i}, frame {frame}"));
            }
            instances.iter_mut().step_by(frame + 2).for_each(|instance| hit(instance, 2, frame as u64));
        }
        // Storages of meshes that no target shows are given back.
        targets.clear();
        let (report, passes) = graph.plan(&mut []).unwrap();
        assert_eq!((report.dispatches, passes.freed.len()), (0, host.storages.len()));
        host.execute(passes);
        assert!(host.storages.is_empty());
    });
}

#[test]
fn a_render_graph_refuses_what_it_cannot_write() {
    let set = scenes::cube_set();
    let mut graph = Graph::default();
    let layout = TestLayout::everything(&set, 0, 0);
    let small = graph.add_target(&set, &def(&layout, 1, layout.size - 4)).unwrap_err();
    assert!(matches!(small, Error::BufferTooSmall { .. }), "{small}");
    let mut target = graph.add_target(&set, &def(&layout, 1, layout.size)).unwrap();
    let classic = Instance::new(set.clone(), InstanceOptions::classic(Rule::MostDisplaced)).unwrap();
    let refused = graph.plan(&mut [Job { instance: &classic, target: &mut target }]).unwrap_err();
    assert!(matches!(refused, Error::WrongRule { .. }), "{refused}");
    let other = Graph::default().plan(&mut [Job { instance: &folded(&set, 1, 1), target: &mut target }]).map(drop);
    assert!(other.unwrap_err().to_string().contains("another device"));
    // Nothing was lost.
    let instance = folded(&set, 1, 1);
    let (report, passes) = graph.plan(&mut [Job { instance: &instance, target: &mut target }]).unwrap();
    assert_eq!((report.vertices_written, passes.uploads.len()), (set.vertex_count() as u64, 1));
    assert!(graph::kernel(36).is_none());
}
