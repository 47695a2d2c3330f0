//! Draws the frames that `examples-c/vehicle.cpp` wrote as one animation (APNG).

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use clap::Args;
use glam::Vec3;
use obj::{ObjData, ObjMaterial};

use crate::pictures::picture::{Body, Camera, Finish, Image, Margins, View, photograph};

const SIZE: [usize; 2] = [480, 240];
const MARGINS: Margins = Margins { side: 0.02, top: 0.04, bottom: 0.04 };
/// What the camera sees, m: the pole and the road before it.
const SCENE: [Vec3; 2] = [Vec3::new(-3.6, -1.8, 0.0), Vec3::new(4.6, 1.8, 1.9)];
/// Objects behind this x are not drawn: they would make the shadows of the rest coarse.
const BEHIND: f32 = -7.0;
/// Materials and their reflectances.
const MATERIALS: [(&str, Vec3); 6] = [
    ("red", Vec3::new(0.55, 0.04, 0.03)),
    ("blue", Vec3::new(0.03, 0.13, 0.42)),
    ("glass", Vec3::new(0.16, 0.24, 0.28)),
    ("plastic", Vec3::new(0.06, 0.06, 0.065)),
    ("tyre", Vec3::new(0.02, 0.02, 0.02)),
    ("steel", Vec3::new(0.42, 0.42, 0.40)),
];

#[derive(Args, Debug, Clone)]
pub struct Options {
    /// The folder that `vehicle` wrote its frames to: frame_00.obj and so on
    frames: PathBuf,
    /// The picture
    #[arg(short, long, value_name = "FILE.png", default_value = "docs/images/vehicle.png")]
    output: PathBuf,
    /// Frames a second
    #[arg(long, default_value_t = 12)]
    rate: u16,
}

pub fn run(options: &Options) -> Result<()> {
    let mut paths: Vec<PathBuf> = std::fs::read_dir(&options.frames)
        .with_context(|| format!("reading {}", options.frames.display()))?
        .map(|entry| Ok(entry?.path()))
        .collect::<Result<_>>()?;
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "obj"));
    paths.sort();
    ensure!(!paths.is_empty(), "{} has no frame_NN.obj; run `vehicle` first", options.frames.display());
    let view = View { up: Vec3::Z, toward: Vec3::new(0.42, 1.0, 0.62).normalize() };
    let corners: Vec<Vec3> = (0..8).map(|i| pick(i, SCENE)).collect();
    let camera = Camera::framing(&corners, view, SIZE[0] as f32 / SIZE[1] as f32, MARGINS);
    let images = paths.iter().map(|path| Ok(Frame::read(path)?.draw(&camera, view))).collect::<Result<Vec<Image>>>()?;
    write(&images, options)
}

/// A corner of a box.
fn pick(i: usize, [low, high]: [Vec3; 2]) -> Vec3 {
    Vec3::select(glam::BVec3::new(i & 1 == 0, i & 2 == 0, i & 4 == 0), low, high)
}

struct Frame {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    /// The number of each vertex's material, as a share of all.
    values: Vec<f32>,
}

impl Frame {
    fn read(path: &Path) -> Result<Self> {
        let file = File::open(path).with_context(|| format!("reading {}", path.display()))?;
        let data = ObjData::load_buf(file).with_context(|| path.display().to_string())?;
        let mut frame = Frame {
            positions: data.position.iter().map(|p| Vec3::from(*p)).collect(),
            triangles: Vec::new(),
            values: vec![0.0; data.position.len()],
        };
        for group in data.objects.iter().flat_map(|object| &object.groups) {
            let Some(ObjMaterial::Ref(name)) = &group.material else { continue };
            let at = MATERIALS.iter().position(|(material, _)| material == name);
            let at = at.with_context(|| format!("{} has the unknown material {name}", path.display()))?;
            for polygon in &group.polys {
                let [a, b, c] = polygon.0[..] else { continue };
                let triangle = [a.0, b.0, c.0];
                if triangle.iter().all(|v| frame.positions[*v].x > BEHIND) {
                    triangle.iter().for_each(|v| frame.values[*v] = at as f32 / (MATERIALS.len() - 1) as f32);
                    frame.triangles.push(triangle.map(|v| v as u32));
                }
            }
        }
        Ok(frame)
    }

    fn draw(mut self, camera: &Camera, view: View) -> Image {
        // The studio takes its floor and the reach of its shadows from all positions; here they are the same in all frames.
        let seen = |p: &Vec3| p.clamp(SCENE[0] - Vec3::X * 3.0, SCENE[1] + Vec3::X);
        self.positions = self.positions.iter().map(|p| if p.x > BEHIND { *p } else { seen(p) }).collect();
        self.positions.extend((0..8).map(|i| pick(i, SCENE)));
        self.values.resize(self.positions.len(), 0.0);
        let mut normals = vec![Vec3::ZERO; self.positions.len()];
        for t in &self.triangles {
            let [a, b, c] = t.map(|v| self.positions[v as usize]);
            t.iter().for_each(|v| normals[*v as usize] += (b - a).cross(c - a));
        }
        normals.iter_mut().for_each(|n| *n = n.normalize_or(Vec3::Z));
        let colour = |share: f32| MATERIALS[(share * (MATERIALS.len() - 1) as f32).round() as usize].1;
        let body =
            Body { positions: &self.positions, normals: &normals, triangles: &self.triangles, values: &self.values };
        photograph(body, camera, view, SIZE, &Finish::Heat { colour: &colour, maximum: 1.0 })
    }
}

/// Writes an animation, in which a frame has only the pixels that differ from the frame before it.
fn write(images: &[Image], options: &Options) -> Result<()> {
    let file = BufWriter::new(File::create(&options.output)?);
    let mut encoder = png::Encoder::new(file, SIZE[0] as u32, SIZE[1] as u32);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    encoder.set_animated(images.len() as u32, 0)?;
    encoder.set_frame_delay(1, options.rate)?;
    encoder.set_blend_op(png::BlendOp::Over)?;
    let mut writer = encoder.write_header()?;
    let mut before: Option<&Image> = None;
    for image in images {
        let pixels = image.rgb.as_chunks::<3>().0;
        let same = |i: usize, rgb: &[u8; 3]| before.is_some_and(|b| b.rgb[3 * i..3 * i + 3] == *rgb);
        let rgba = pixels
            .iter()
            .enumerate()
            .flat_map(|(i, rgb)| if same(i, rgb) { [0; 4] } else { [rgb[0], rgb[1], rgb[2], 255] });
        writer.write_image_data(&rgba.collect::<Vec<u8>>())?;
        before = Some(image);
    }
    writer.finish()?;
    println!(
        "{}: {} frames, {} kB",
        options.output.display(),
        images.len(),
        std::fs::metadata(&options.output)?.len() / 1000
    );
    Ok(())
}
