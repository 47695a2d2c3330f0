//! What the camera sees, as a PNG.

use bevy::prelude::*;
use bevy::render::extract_resource::{ExtractResource, ExtractResourcePlugin};
use bevy::render::render_asset::RenderAssets;
use bevy::render::render_resource::{
    BufferDescriptor, BufferUsages, CommandEncoderDescriptor, MapMode, TexelCopyBufferInfo, TexelCopyBufferLayout,
    TextureFormat, TextureUsages,
};
use bevy::render::renderer::{RenderDevice, RenderQueue};
use bevy::render::texture::GpuImage;
use bevy::render::{Render, RenderApp, RenderSystems};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

// 256 bytes are what a copied row is a multiple of.
const SIZE: (u32, u32) = (960, 640);

/// The image that the camera draws into.
#[derive(Resource, Clone, ExtractResource)]
pub struct Picture(pub Handle<Image>);

pub fn target() -> Image {
    let mut image = Image::new_target_texture(SIZE.0, SIZE.1, TextureFormat::Rgba8UnormSrgb, None);
    image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
    image
}

/// Writes the picture of a frame, and ends the app.
pub struct PicturePlugin {
    pub path: PathBuf,
    pub frame: u32,
}

#[derive(Resource)]
struct Taking {
    path: PathBuf,
    frames_left: u32,
    done: Arc<AtomicBool>,
}

impl Plugin for PicturePlugin {
    fn build(&self, app: &mut App) {
        let done = Arc::new(AtomicBool::new(false));
        let taking = Taking { path: self.path.clone(), frames_left: self.frame, done: done.clone() };
        app.add_plugins(ExtractResourcePlugin::<Picture>::default()).add_systems(
            Last,
            move |mut exit: MessageWriter<AppExit>| {
                if done.load(Ordering::Relaxed) {
                    exit.write(AppExit::Success);
                }
            },
        );
        let take = take.after(RenderSystems::Render).run_if(resource_exists::<Picture>);
        app.sub_app_mut(RenderApp).insert_resource(taking).add_systems(Render, take);
    }
}

fn take(
    mut taking: ResMut<Taking>,
    picture: Res<Picture>,
    images: Res<RenderAssets<GpuImage>>,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
) {
    let Some(image) = images.get(&picture.0) else { return };
    taking.frames_left = taking.frames_left.saturating_sub(1);
    if taking.frames_left > 0 || taking.done.load(Ordering::Relaxed) {
        return;
    }
    let row = 4 * SIZE.0;
    let buffer = device.create_buffer(&BufferDescriptor {
        label: Some("picture"),
        size: u64::from(row * SIZE.1),
        usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor::default());
    let layout = TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
    let to = TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(image.texture.as_image_copy(), to, image.texture_descriptor.size);
    queue.submit([encoder.finish()]);
    buffer.slice(..).map_async(MapMode::Read, |mapped| mapped.expect("the picture is mapped"));
    device.poll(wgpu::PollType::wait_indefinitely()).expect("the device is there");
    let file = std::fs::File::create(&taking.path).expect("the picture's file");
    let mut png = png::Encoder::new(file, SIZE.0, SIZE.1);
    png.set_color(png::ColorType::Rgba);
    png.set_depth(png::BitDepth::Eight);
    let mut writer = png.write_header().expect("a PNG's head");
    writer.write_image_data(&buffer.slice(..).get_mapped_range()).expect("a PNG's pixels");
    println!("{}", taking.path.display());
    taking.done.store(true, Ordering::Relaxed);
}
