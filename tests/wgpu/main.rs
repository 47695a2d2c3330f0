//! Deformation on wgpu devices, on every Vulkan driver there is: the vertices are the CPU's, bit for bit, and nothing else is
//! written.

#[cfg(any(windows, target_os = "linux", target_os = "android", target_os = "freebsd"))]
mod adopted;
#[cfg(feature = "cli")]
mod command;
mod errors;
mod frames;
mod harness;
#[path = "../scenes/mod.rs"]
mod scenes;
mod vertices;

use std::sync::Arc;

use crumple::wgpu::wgpu::{Buffer, VertexFormat};
use crumple::wgpu::{Attribute, Encoding, Stream, TargetDef, encode};
use crumple::{DeformJob, ExampleSet, Instance, Serial, Tracker, VertexMemory, deform};

/// Where a test puts a mesh's vertices: offsets are from the start of the target.
#[derive(Debug, Clone, Copy)]
pub struct Plan {
    pub lod: usize,
    pub offset: u64,
    pub streams: [Option<(Stream, Encoding)>; 3],
    pub scale: [f32; 3],
    pub bias: [f32; 3],
    pub size: u64,
}

const ATTRIBUTES: [Attribute; 3] = [Attribute::Position, Attribute::Normal, Attribute::Tangent];

fn format(attribute: Attribute, encoding: Encoding) -> VertexFormat {
    match (encoding, attribute) {
        (Encoding::F32, Attribute::Tangent) => VertexFormat::Float32x4,
        (Encoding::F32, _) => VertexFormat::Float32x3,
        (Encoding::F16x4, _) => VertexFormat::Float16x4,
        (Encoding::Snorm16x4, _) => VertexFormat::Snorm16x4,
        (Encoding::Snorm8x4, _) => VertexFormat::Snorm8x4,
    }
}

fn words(attribute: Attribute, encoding: Encoding) -> usize {
    format(attribute, encoding).size() as usize / 4
}

impl Plan {
    /// Everything that a mesh has, interleaved with gaps, in floats, from `offset` on.
    pub fn everything(set: &ExampleSet, lod: usize, offset: u64) -> Self {
        let mesh = set.lod_mesh(lod).unwrap();
        let float = |there: bool| there.then_some(Encoding::F32);
        let encodings = [float(true), float(mesh.normals().is_some()), float(mesh.tangents().is_some())];
        Self::interleaved(set, lod, offset, encodings)
    }

    /// Positions, normals and tangents in these encodings, interleaved with gaps.
    pub fn interleaved(set: &ExampleSet, lod: usize, offset: u64, encodings: [Option<Encoding>; 3]) -> Self {
        let mesh = set.lod_mesh(lod).unwrap();
        let mut stride = 4;
        let mut streams = [None; 3];
        for i in 0..3 {
            let (Some(encoding), attribute) = (encodings[i], ATTRIBUTES[i]) else { continue };
            streams[i] = Some((Stream { offset: stride, stride: 0, format: format(attribute, encoding) }, encoding));
            stride += 4 * words(attribute, encoding) as u64 + 4;
        }
        streams.iter_mut().flatten().for_each(|(s, _)| s.stride = stride);
        let (bounds, limit) = (mesh.bounds(), set.depth_limit());
        Plan {
            lod,
            offset,
            streams,
            scale: ((bounds.max - bounds.min) * 0.5 + limit).to_array(),
            bias: ((bounds.max + bounds.min) * 0.5).to_array(),
            size: stride * mesh.positions().len() as u64,
        }
    }

    pub fn def<'a>(&self, buffer: &'a Buffer) -> TargetDef<'a> {
        let [positions, normals, tangents] = self.streams.map(|s| s.map(|s| s.0));
        TargetDef {
            lod: self.lod,
            buffer,
            offset: self.offset,
            size: self.size,
            positions: positions.unwrap(),
            normals,
            tangents,
            scale: self.scale,
            bias: self.bias,
        }
    }

    /// Writes what the buffer should hold: the CPU's vertices, converted.
    pub fn expect(&self, instance: &Instance, to: &mut [u32]) {
        let mesh = instance.example_set().lod_mesh(self.lod).unwrap();
        let count = mesh.positions().len();
        let (mut p, mut n, mut t) = (vec![[0.0; 3]; count], vec![[0.0; 3]; count], vec![[0.0; 4]; count]);
        let normals = mesh.normals().map(|_| n.as_mut_slice());
        let tangents = mesh.tangents().map(|_| t.as_mut_slice());
        let memory = VertexMemory::separate(&mut p, normals, tangents).unwrap();
        let mut tracker = Tracker::new();
        deform(&mut [DeformJob { lod: self.lod, instance, tracker: &mut tracker, memory }], &Serial).unwrap();
        let (scale, bias) = match self.streams[0].unwrap().1 {
            Encoding::Snorm16x4 => (self.scale, self.bias),
            _ => ([1.0; 3], [0.0; 3]),
        };
        for v in 0..count {
            let [x, y, z] = [0, 1, 2].map(|i| (p[v][i] - bias[i]) / scale[i]);
            let values = [[x, y, z, 1.0], [n[v][0], n[v][1], n[v][2], 0.0], t[v]];
            for (i, value) in values.into_iter().enumerate() {
                let Some((stream, encoding)) = self.streams[i] else { continue };
                let at = (self.offset + stream.offset + v as u64 * stream.stride) as usize / 4;
                let n = words(ATTRIBUTES[i], encoding);
                to[at..at + n].copy_from_slice(&encode(encoding, value)[..n]);
            }
        }
    }
}

/// Of a device that rounds otherwise than IEEE 754 says, which Vulkan allows in divisions and square roots, a float may be wrong
/// by so many units in the last place of itself or of 1 m, and a packed number by one step.
const ULPS: f32 = 64.0;

/// Whether a word is as near to what was wanted as such a device must come.
fn near(got: u32, wanted: u32) -> bool {
    let (g, w) = (f32::from_bits(got), f32::from_bits(wanted));
    let halves = |x: u32| [x as u16 as i16, (x >> 16) as u16 as i16];
    let bytes = |x: u32| x.to_le_bytes().map(|b| b as i8);
    (g - w).abs() <= ULPS * f32::EPSILON * w.abs().max(1.0)
        || halves(got).iter().zip(halves(wanted)).all(|(g, w)| g.abs_diff(w) <= 1)
        || bytes(got).iter().zip(bytes(wanted)).all(|(g, w)| g.abs_diff(w) <= 1)
}

/// Fails telling the first word that differs. Devices may take floats below 1.2e-38 for zero.
#[track_caller]
pub fn same(got: &[u32], wanted: &[u32], what: &str) {
    let (exact, untouched) = (harness::exact(), harness::POISON);
    let tiny = |x: u32| f32::from_bits(x).is_subnormal();
    let differ = |(got, wanted): (&u32, &u32)| {
        let allowed = tiny(*wanted) && *got << 1 == 0 || !exact && *wanted != untouched && near(*got, *wanted);
        got != wanted && !allowed
    };
    let wrong = got.iter().zip(wanted).filter(|p| differ(*p)).count();
    if let Some(at) = got.iter().zip(wanted).position(differ) {
        let (g, w) = (got[at], wanted[at]);
        let floats = (f32::from_bits(g), f32::from_bits(w));
        panic!("{what}: word {at} is {g:08x}, not {w:08x} ({floats:?}); {wrong} of {} words differ", got.len());
    }
    assert_eq!(got.len(), wanted.len());
}

pub fn folded(set: &Arc<ExampleSet>, hits: usize, seed: u64) -> Instance {
    let mut instance = Instance::new(set.clone(), Default::default()).unwrap();
    hit(&mut instance, hits, seed);
    instance
}

pub fn hit(instance: &mut Instance, hits: usize, seed: u64) {
    for hit in scenes::random_hits(&instance.example_set().clone(), hits, seed) {
        instance.submit(&hit).unwrap();
    }
    instance.fold();
}
