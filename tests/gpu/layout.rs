//! Where a test puts a mesh's vertices, and what they should be there.

use crumple::{DeformJob, ExampleSet, Instance, Serial, Tracker, VertexMemory, deform};

use super::compare::{Bounds, Expected};
use super::encode::encode;
use crate::backend::{Attribute, BufferRef, Def, Encoding, Stream, format};

pub const ATTRIBUTES: [Attribute; 3] = [Attribute::Position, Attribute::Normal, Attribute::Tangent];

/// Where a test puts a mesh's vertices. The offsets of streams count from the start of the target.
#[derive(Debug, Clone, Copy)]
pub struct TestLayout {
    pub lod: usize,
    pub offset: u64,
    pub streams: [Option<(Stream, Encoding)>; 3],
    pub scale: [f32; 3],
    pub bias: [f32; 3],
    pub size: u64,
}

/// Words of a value.
pub fn words(attribute: Attribute, encoding: Encoding) -> usize {
    match (encoding, attribute) {
        (Encoding::F32, Attribute::Tangent) => 4,
        (Encoding::F32, _) => 3,
        (Encoding::F16x4 | Encoding::Snorm16x4, _) => 2,
        (Encoding::Snorm8x4 | Encoding::Octahedral16x2, _) => 1,
    }
}

impl TestLayout {
    /// Every attribute of the mesh, in floats, interleaved with gaps.
    pub fn everything(set: &ExampleSet, lod: usize, offset: u64) -> Self {
        let mesh = set.lod_mesh(lod).unwrap();
        let float = |there: bool| there.then_some(Encoding::F32);
        let (normals, tangents) = (mesh.normals().is_some(), mesh.tangents().is_some());
        let encodings = [float(true), float(normals), float(tangents)];
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
        TestLayout {
            lod,
            offset,
            streams,
            scale: ((bounds.max - bounds.min) * 0.5 + limit).to_array(),
            bias: ((bounds.max + bounds.min) * 0.5).to_array(),
            size: stride * mesh.positions().len() as u64,
        }
    }

    /// The definition of a target in a buffer.
    pub fn def<'a>(&self, buffer: BufferRef<'a>) -> Def<'a> {
        let [positions, normals, tangents] = self.streams.map(|s| s.map(|s| s.0));
        Def {
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
    pub fn expect(&self, instance: &mut Instance, to: &mut Expected) {
        let bounds = Bounds::of(instance);
        let mesh = instance.example_set().lod_mesh(self.lod).unwrap();
        let count = mesh.positions().len();
        let (mut p, mut n, mut t) = (vec![[0.0; 3]; count], vec![[0.0; 3]; count], vec![[0.0; 4]; count]);
        let normals = mesh.normals().map(|_| n.as_mut_slice());
        let tangents = mesh.tangents().map(|_| t.as_mut_slice());
        let mut packed = [vec![[0u16; 2]; count], vec![[0u16; 2]; count]];
        let is_packed = |i: usize| self.streams[i].is_some_and(|(_, encoding)| encoding == Encoding::Octahedral16x2);
        let [packed_n, packed_t] = &mut packed;
        let mut memory = VertexMemory::separate(&mut p, normals, tangents).unwrap();
        memory = if is_packed(1) { memory.with_octahedral_normals(packed_n) } else { memory };
        memory = if is_packed(2) { memory.with_octahedral_tangents(packed_t) } else { memory };
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
                let scale = if i == 0 { scale } else { [1.0; 3] };
                let words = match is_packed(i) {
                    true => [u32::from(packed[i - 1][v][0]) | u32::from(packed[i - 1][v][1]) << 16, 0, 0, 0],
                    false => encode(encoding, value),
                };
                to.put(at, ATTRIBUTES[i], encoding, &words[..n], bounds, scale);
            }
        }
    }
}
