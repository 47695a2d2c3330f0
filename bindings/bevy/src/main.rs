//! A body panel that Bevy draws, dented in Bevy's own vertex buffer; headless, into a PNG.
//!
//! `cargo run -- out.png`. Needs a Vulkan device; `VK_DRIVER_FILES` chooses among drivers.

mod dents;
mod picture;

use bevy::app::ScheduleRunnerPlugin;
use bevy::asset::RenderAssetUsages;
use bevy::camera::RenderTarget;
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::settings::{Backends, RenderCreation, WgpuSettings};
use bevy::window::ExitCondition;
use crumple::{Deltas, ExampleData, ExampleSet, Hit, Instance, MeshData, SetOptions};
use dents::{Dented, DentsPlugin};
use picture::{Picture, PicturePlugin};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Frames after which the picture is taken.
const FRAMES: u32 = 20;
/// Vertices along a side of the panel, less one.
const SIDE: usize = 96;

fn main() -> AppExit {
    let path = std::env::args().nth(1).unwrap_or_else(|| "dented.png".into());
    let vulkan = WgpuSettings { backends: Some(Backends::VULKAN), ..default() };
    let window = WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() };
    let render = RenderPlugin {
        render_creation: RenderCreation::Automatic(Box::new(vulkan)),
        synchronous_pipeline_compilation: true,
        ..default()
    };
    App::new()
        .add_plugins(DefaultPlugins.set(window).set(render))
        .add_plugins(ScheduleRunnerPlugin::run_loop(Duration::ZERO))
        .add_plugins((DentsPlugin, PicturePlugin { path: path.into(), frame: FRAMES }))
        .insert_resource(ClearColor(Color::srgb(0.9, 0.9, 0.92)))
        .add_systems(Startup, build)
        .add_systems(Update, hit)
        .run()
}

/// A panel of 1.6 m by 1 m, bulging by 0.15 m.
fn panel() -> MeshData {
    let mut mesh = MeshData::default();
    let mut normals = Vec::new();
    for i in 0..=SIDE {
        for j in 0..=SIDE {
            let (u, v) = (2.0 * i as f32 / SIDE as f32 - 1.0, 2.0 * j as f32 / SIDE as f32 - 1.0);
            mesh.positions.push([0.8 * u, 0.5 * v, 0.15 * (1.0 - u * u) * (1.0 - 0.5 * v * v)]);
            let slope = Vec3::new(-0.3 * u * (1.0 - 0.5 * v * v) / 0.8, -0.15 * v * (1.0 - u * u) / 0.5, 0.0);
            normals.push((Vec3::Z - slope).normalize().to_array());
        }
    }
    let at = |i: usize, j: usize| (i * (SIDE + 1) + j) as u32;
    for i in 0..SIDE {
        for j in 0..SIDE {
            mesh.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            mesh.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    mesh.normals = Some(normals);
    mesh
}

/// The panel as an artist dented it: a bowl with a raised rim.
fn example(mesh: &MeshData) -> ExampleData {
    let (mut indices, mut values) = (Vec::new(), Vec::new());
    for (i, p) in mesh.positions.iter().enumerate() {
        let r = Vec2::new(p[0], p[1]).length() / 0.28;
        if r < 1.0 {
            let fade = (1.0 - r * r) * (1.0 - r * r);
            indices.push(i as u32);
            values.push([0.0, 0.0, -0.09 * fade * (1.0 - 2.5 * r * r)]);
        }
    }
    ExampleData::new("bowl", Deltas::Sparse { indices, values })
}

fn build(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) {
    let data = panel();
    let indices = data.triangles.iter().flatten().copied().collect();
    let mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::RENDER_WORLD)
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, data.positions.clone())
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, data.normals.clone().expect("the panel has normals"))
        .with_inserted_indices(Indices::U32(indices));
    let mesh = meshes.add(mesh);
    let bowl = example(&data);
    let set = ExampleSet::build(data, vec![bowl], SetOptions::default(), &crumple::Serial).expect("a set");
    let instance = Instance::new(Arc::new(set), Default::default()).expect("an instance");
    commands.insert_resource(Dented { mesh: mesh.id(), instance: Arc::new(Mutex::new(instance)) });

    let paint = StandardMaterial {
        base_color: Color::srgb(0.65, 0.08, 0.06),
        perceptual_roughness: 0.35,
        double_sided: true,
        cull_mode: None,
        ..default()
    };
    commands.spawn((Mesh3d(mesh), MeshMaterial3d(materials.add(paint))));
    commands.spawn((
        DirectionalLight { illuminance: 6000.0, ..default() },
        Transform::from_xyz(-2.0, 2.5, 1.5).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    let image = images.add(picture::target());
    commands.insert_resource(Picture(image.clone()));
    commands.spawn((
        Camera3d::default(),
        RenderTarget::Image(image.into()),
        Tonemapping::None,
        Transform::from_xyz(0.5, -0.3, 1.75).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

/// What a physics engine would report.
fn hit(dented: Res<Dented>, mut frame: Local<u32>) {
    *frame += 1;
    let (point, depth) = match *frame {
        5 => ([-0.4, 0.12, 0.11], 0.07),
        8 => ([0.3, -0.1, 0.13], 0.09),
        11 => ([0.05, 0.28, 0.14], 0.04),
        14 => ([0.42, 0.22, 0.1], 0.05),
        _ => return,
    };
    let mut instance = dented.instance.lock().expect("nobody panicked");
    instance.submit(&Hit::displacement(point, [0.0, 0.0, -depth])).expect("a hit on the panel");
    instance.fold();
}
