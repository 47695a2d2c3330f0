//! Writes a set to a file.

use super::layout::{
    ALIGN, AnchoredRecord, BlowRecord, Entry, ExampleRecord, Header, Id, MAGIC, MeshRecord, SetRecord, UNHASHED,
    VERSION, file_checksum,
};
use crate::base::error::{Error, reserve};
use crate::base::tasks::Serial;
use crate::example::blocks::DeltaBlocks;
use crate::example::blow::Blow;
use crate::example::mesh_lod::MeshLod;
use crate::example::options::VertexMass;
use crate::example::set::ExampleSet;
use bytemuck::{Pod, bytes_of, cast_slice};
use std::borrow::Cow;
use std::mem::offset_of;
use std::sync::Arc;

/// The content of one section, as consecutive pieces.
struct Section<'a> {
    id: Id,
    mesh: u32,
    element: usize,
    pieces: Vec<Cow<'a, [u8]>>,
}

impl Section<'_> {
    fn length(&self) -> usize {
        self.pieces.iter().map(|p| p.len()).sum()
    }
}

/// A file that is laid out but not yet written.
pub(super) struct File<'a> {
    sections: Vec<Section<'a>>,
    table: Vec<Entry>,
    length: usize,
}

impl<'a> File<'a> {
    pub(super) fn new(set: &'a ExampleSet) -> Self {
        let mut file = File { sections: Vec::new(), table: Vec::new(), length: 0 };
        file.set(set);
        for (k, lod) in set.lods().enumerate() {
            let farthest = k.checked_sub(1).map_or(0.0, |lod| set.report().lods[lod].farthest);
            let examples = if holds_whole(set) { &lod.anchored[..] } else { &[] };
            file.mesh_lod(k as u32, (lod, examples), farthest);
        }
        // Its numbers were finite when it was learned.
        file.pieces(Id::Rule, 0, 1, vec![Cow::Owned(set.rule().predictor.to_bytes().unwrap_or_default())]);
        let nodes = &set.nodes().lod;
        file.mesh_lod(set.lod_count() as u32, (nodes, &nodes.anchored), 0.0);
        let (inner, leaves) = set.index().parts();
        file.array(Id::IndexInner, 0, inner);
        file.array(Id::IndexLeaves, 0, leaves);
        file.array(Id::SourceOrder, 0, set.source_order().unwrap_or_default());
        let mut at = size_of::<Header>() + file.sections.len() * size_of::<Entry>();
        for s in &file.sections {
            let offset = at.next_multiple_of(ALIGN);
            file.table.push(Entry {
                id: s.id as u32,
                mesh: s.mesh,
                offset: offset as u64,
                length: s.length() as u64,
                element: s.element as u32,
                flags: s.id.flags(),
            });
            at = offset + s.length();
        }
        file.length = at;
        file
    }

    pub(super) fn length(&self) -> usize {
        self.length
    }

    pub(super) fn bytes(&self) -> Result<Vec<u8>, Error> {
        let header = Header {
            magic: MAGIC,
            checksum: 0,
            length: self.length as u64,
            version: VERSION,
            sections: self.table.len() as u32,
            zero: [0; 32],
        };
        let mut out = reserve(self.length, "a baked set")?;
        out.extend_from_slice(bytes_of(&header));
        out.extend_from_slice(cast_slice(&self.table));
        for s in &self.sections {
            out.resize(out.len().next_multiple_of(ALIGN), 0);
            s.pieces.iter().for_each(|piece| out.extend_from_slice(piece));
        }
        let checksum = file_checksum(&out, &Serial);
        out[offset_of!(Header, checksum)..UNHASHED].copy_from_slice(&checksum.to_le_bytes());
        Ok(out)
    }

    /// Adds a section, unless it has no elements.
    fn pieces(&mut self, id: Id, mesh: u32, element: usize, pieces: Vec<Cow<'a, [u8]>>) {
        if pieces.iter().any(|p| !p.is_empty()) {
            self.sections.push(Section { id, mesh, element, pieces });
        }
    }

    fn array<T: Pod>(&mut self, id: Id, mesh: u32, elements: &'a [T]) {
        self.pieces(id, mesh, size_of::<T>(), vec![Cow::Borrowed(cast_slice(elements))]);
    }

    fn records<T: Pod>(&mut self, id: Id, mesh: u32, records: &[T]) {
        self.pieces(id, mesh, size_of::<T>(), vec![Cow::Owned(cast_slice(records).to_vec())]);
    }

    fn set(&mut self, set: &'a ExampleSet) {
        let (o, r) = (set.options(), set.report());
        let (mass_kind, mass) = match &o.mass {
            VertexMass::None => (0, 0.0),
            VertexMass::Uniform(m) => (1, *m),
            VertexMass::PerVertex(_) => (2, 0.0),
        };
        let record = SetRecord {
            fingerprint: set.fingerprint(),
            welded: r.welded as u64,
            examples: set.examples().len() as u32,
            meshes: set.lods().count() as u32,
            depth_limit: o.depth_limit.unwrap_or(0.0),
            drop_below: o.drop_below,
            tolerance: o.tolerance.unwrap_or(0.0),
            normal_tolerance: o.normal_tolerance,
            mass,
            widest_weld: r.widest_weld,
            mass_kind,
            mirror: o.mirror.into(),
            held_rims: o.held_rims.into(),
            planes: r.mirror_planes.bits(),
            whole_examples: holds_whole(set).into(),
            zero: [0; 3],
        };
        self.records(Id::Set, 0, &[record]);
        let examples: Vec<ExampleRecord> = set
            .examples()
            .iter()
            .map(|e| ExampleRecord {
                name: e.name().len() as u32,
                contact_vertex: e.contact_vertex(),
                moved: e.moved_vertices() as u32,
                support_radius: e.support_radius(),
                max_depth: e.max_depth(),
                contact_normal: e.contact_normal().unwrap_or_default().to_array(),
                contact_displacement: e.contact_displacement().to_array(),
                shape: e.blow().striker.shape as u32,
                blow: blow_of(e.blow()),
            })
            .collect();
        self.records(Id::Examples, 0, &examples);
        let names: Vec<u8> = set.examples().iter().flat_map(|e| e.name().bytes()).collect();
        self.records(Id::Names, 0, &names);
        if let VertexMass::PerVertex(masses) = &o.mass {
            self.array(Id::Masses, 0, masses);
        }
    }

    fn mesh_lod(&mut self, k: u32, (lod, examples): (&'a MeshLod, &'a [Arc<DeltaBlocks>]), farthest: f32) {
        let (mesh, arrays) = (&lod.mesh, lod.mesh.arrays());
        let record = MeshRecord {
            vertices: lod.vertex_count() as u32,
            repaired_normals: mesh.repaired_normals() as u32,
            degenerate_triangles: mesh.degenerate_triangles() as u32,
            farthest,
        };
        self.records(Id::Mesh, k, &[record]);
        self.array(Id::Positions, k, &arrays.positions);
        self.array(Id::Normals, k, arrays.normals.as_deref().unwrap_or_default());
        self.array(Id::Tangents, k, arrays.tangents.as_deref().unwrap_or_default());
        self.array(Id::Triangles, k, &arrays.triangles);
        self.array(Id::Weld, k, &arrays.weld);
        self.array(Id::ContactNormals, k, arrays.contact_normals.as_deref().unwrap_or_default());
        self.array(Id::RimBlocks, k, &lod.rim.blocks);
        self.array(Id::RimWindows, k, &lod.rim.windows);
        self.array(Id::RimHeld, k, &lod.rim.held);
        let [depths, gives] = mesh.limits().parts();
        self.array(Id::DepthLimits, k, depths);
        self.array(Id::Gives, k, gives);
        self.array(Id::Tiles, k, &lod.rows.tiles);
        self.array(Id::TileNodes, k, &lod.rows.nodes);
        self.array(Id::Weights, k, &lod.rows.weights);
        self.array(Id::Slopes, k, &lod.rows.slopes);
        self.array(Id::SlopeUnits, k, &lod.rows.slope_units);
        let records: Vec<AnchoredRecord> = examples
            .iter()
            .map(|a| AnchoredRecord { heads: a.heads.len() as u32, words: a.words.len() as u32 })
            .collect();
        self.records(Id::Anchored, k, &records);
        let heads = examples.iter().map(|a| Cow::Borrowed(cast_slice(&a.heads)));
        self.pieces(Id::Heads, k, size_of::<crate::example::blocks::Head>(), heads.collect());
        let words = examples.iter().map(|a| Cow::Borrowed(cast_slice(&a.words)));
        self.pieces(Id::Words, k, size_of::<u64>(), words.collect());
    }
}

/// Whether the file of a set holds its examples whole.
fn holds_whole(set: &ExampleSet) -> bool {
    set.options().whole_examples && set.has_whole_examples()
}

fn blow_of(b: &Blow) -> BlowRecord {
    let vector = |v: Option<[f32; 3]>| v.unwrap_or([f32::NAN; 3]);
    let number = |x: Option<f32>| x.unwrap_or(f32::NAN);
    BlowRecord {
        impulse: vector(b.impulse),
        duration: number(b.duration),
        normal: vector(b.normal),
        striker_mass: number(b.striker.mass),
        striker_velocity: vector(b.striker.velocity),
        striker_radius: number(b.striker.radius),
    }
}
