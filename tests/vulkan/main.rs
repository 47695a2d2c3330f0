//! Deformation recorded into Vulkan command buffers, on every driver there is, under core and synchronization validation: the
//! vertices are the CPU's, bit for bit, and nothing else is written.

mod harness;
#[path = "../scenes/mod.rs"]
mod scenes;
#[path = "../../build/spirv.rs"]
mod spirv;

mod errors;
mod frames;
mod import;
mod vertices;

use std::sync::Arc;

use crumple::vulkan::vk::Format;
use crumple::vulkan::{Attribute, BufferId, Encoding, Stream, TargetDef, encode};
use crumple::{DeformJob, ExampleSet, Instance, Serial, Tracker, VertexMemory, deform};

/// Where a test puts a mesh's vertices: offsets are from the start of the target.
#[derive(Debug, Clone, Copy)]
pub struct Plan {
    pub lod: usize,
    pub offset: u64,
    pub positions: (Stream, Encoding),
    pub normals: Option<(Stream, Encoding)>,
    pub tangents: Option<(Stream, Encoding)>,
    pub scale: [f32; 3],
    pub bias: [f32; 3],
    pub size: u64,
}

/// An encoding's Vulkan format.
pub fn format(attribute: Attribute, encoding: Encoding) -> Format {
    match (encoding, attribute) {
        (Encoding::F32, Attribute::Tangent) => Format::R32G32B32A32_SFLOAT,
        (Encoding::F32, _) => Format::R32G32B32_SFLOAT,
        (Encoding::F16x4, _) => Format::R16G16B16A16_SFLOAT,
        (Encoding::Snorm16x4, _) => Format::R16G16B16A16_SNORM,
        (Encoding::Snorm8x4, _) => Format::R8G8B8A8_SNORM,
    }
}

/// Words of a value.
pub fn words(attribute: Attribute, encoding: Encoding) -> usize {
    match (encoding, attribute) {
        (Encoding::F32, Attribute::Tangent) => 4,
        (Encoding::F32, _) => 3,
        (Encoding::F16x4 | Encoding::Snorm16x4, _) => 2,
        (Encoding::Snorm8x4, _) => 1,
    }
}

impl Plan {
    /// Everything that a mesh has, interleaved with gaps, in floats, from `offset` on.
    pub fn everything(set: &ExampleSet, lod: usize, offset: u64) -> Self {
        let mesh = set.lod_mesh(lod).unwrap();
        let encodings =
            [Some(Encoding::F32), mesh.normals().map(|_| Encoding::F32), mesh.tangents().map(|_| Encoding::F32)];
        Self::interleaved(set, lod, offset, encodings)
    }

    /// Positions, normals and tangents in these encodings, interleaved with gaps.
    pub fn interleaved(set: &ExampleSet, lod: usize, offset: u64, encodings: [Option<Encoding>; 3]) -> Self {
        let count = set.lod_mesh(lod).unwrap().positions().len() as u64;
        let attributes = [Attribute::Position, Attribute::Normal, Attribute::Tangent];
        let mut at = 4;
        let offsets = [0, 1, 2].map(|i| {
            let here = at;
            at += encodings[i].map_or(0, |e| 4 * words(attributes[i], e) as u64 + 4);
            here
        });
        let stream = |i: usize| {
            encodings[i].map(|e| (Stream { offset: offsets[i], stride: at, format: format(attributes[i], e) }, e))
        };
        let (bounds, limit) = (set.lod_mesh(lod).unwrap().bounds(), set.depth_limit());
        Plan {
            lod,
            offset,
            positions: stream(0).unwrap(),
            normals: stream(1),
            tangents: stream(2),
            scale: ((bounds.max - bounds.min) * 0.5 + limit).to_array(),
            bias: ((bounds.max + bounds.min) * 0.5).to_array(),
            size: at * count,
        }
    }

    pub fn def(&self, buffer: BufferId) -> TargetDef {
        TargetDef {
            lod: self.lod,
            buffer,
            offset: self.offset,
            size: self.size,
            positions: self.positions.0,
            normals: self.normals.map(|s| s.0),
            tangents: self.tangents.map(|s| s.0),
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
        let mut put = |stream: Option<(Stream, Encoding)>, attribute, v: usize, value: [f32; 4]| {
            let Some((stream, encoding)) = stream else { return };
            let at = (self.offset + stream.offset + v as u64 * stream.stride) as usize / 4;
            let n = words(attribute, encoding);
            to[at..at + n].copy_from_slice(&encode(encoding, value)[..n]);
        };
        for v in 0..count {
            let [x, y, z] = p[v];
            let position = if self.positions.1 == Encoding::Snorm16x4 {
                let k = |i: usize, x: f32| (x - self.bias[i]) / self.scale[i];
                [k(0, x), k(1, y), k(2, z), 1.0]
            } else {
                [x, y, z, 1.0]
            };
            put(Some(self.positions), Attribute::Position, v, position);
            let [x, y, z] = n[v];
            put(self.normals, Attribute::Normal, v, [x, y, z, 0.0]);
            put(self.tangents, Attribute::Tangent, v, t[v]);
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

/// The kernels as they are built: no chain of accesses goes on from another, and no operation may be contracted.
#[test]
fn chains_are_folded_and_nothing_is_contracted() {
    let op = |opcode: u32, words: &[u32]| [&[(words.len() as u32 + 1) << 16 | opcode], words].concat();
    let header = vec![0x0723_0203, 0x0001_0300, 0, 20, 0];
    let module = [
        header.clone(),
        op(71, &[7, 33, 0]),       // decorate %7 binding 0
        op(22, &[1, 32]),          // %1 = type float
        op(65, &[2, 9, 7, 3]),     // %9 = chain %7 [%3]
        op(65, &[2, 10, 9, 4]),    // %10 = chain %9 [%4]
        op(65, &[2, 11, 10, 5]),   // %11 = chain %10 [%5]
        op(129, &[1, 12, 13, 14]), // %12 = %13 + %14
    ]
    .concat();
    let folded = spirv::with_folded_chains(&module);
    let chains: Vec<&[u32]> = spirv::instructions(&folded).filter(|(o, _)| *o == 65).map(|(_, w)| &w[1..]).collect();
    assert_eq!(chains, [&[2, 9, 7, 3][..], &[2, 10, 7, 3, 4], &[2, 11, 7, 3, 4, 5]]);
    let exact = spirv::without_contraction(&module);
    assert_eq!(exact[header.len()..][..7], [4 << 16 | 71, 7, 33, 0, 3 << 16 | 71, 12, 42]);
    assert_eq!(exact.len(), module.len() + 3);
}
