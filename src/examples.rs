//! The example set: a base mesh and its examples, checked and made ready. Immutable, shared by all instances.

use crate::anchored::{Anchored, Bytes, Steps};
use crate::array::Array;
use crate::classic::Sparse;
use crate::error::{at_least_zero, positive, reserve};
use crate::images::{Around, Images};
use crate::learn::{Learned, learn};
use crate::math::{tangent_basis, unit};
use crate::mesh::{MAX_COORDINATE, Mesh, finite};
use crate::mirror::{self, Mirror};
use crate::nearest::{Nearest, VertexIndex};
use crate::rim::{self, Rim};
use crate::skin::Skin;
use crate::stamp::{Source, Stamp};
use crate::tasks::map;
use crate::{Contact, Deltas, Error, ExampleData, LodReport, MeshData, Placement, TaskSystem, normals};
use glam::Vec3;
use rstar::RTree;
use std::sync::{Arc, OnceLock};
use xxhash_rust::xxh3::Xxh3;

/// An automatic example is anchored within this share of its support radius around its own contact …
pub(crate) const ANCHORED_WITHIN: f32 = 0.1;
/// … for targets this share short of its own depth, but no deeper: an anchored example can be neither deepened nor
/// narrowed. (A tenth, as for the place; no training impact lies that near another, so the value could not be fitted.)
pub(crate) const ANCHORED_SIZE: f32 = 0.1;
/// Displacements below this share of an example's deepest do not count for its support radius.
const SUPPORT: f32 = 0.01;

/// How the dents of several marks combine at a vertex. The direction is always that of their sum.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Combine {
    /// Lengths add, up to the depth limit.
    Sum = 1,
    /// Energies add: the length is the root of the sum of squares. The default.
    #[default]
    Energies = 0,
    /// Only the deepest dent counts.
    Deepest = 2,
}

/// How an example is treated that moves vertices with the same base position apart.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Seams {
    /// The vertices stay together: each gets the mean of their displacements. The default.
    #[default]
    Weld = 0,
    /// The vertices move apart as in the example: a tear that the artist made.
    Keep = 1,
}

/// Mass of a vertex, for impulses that do not bring their own.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum VertexMass {
    /// Unknown: each impulse must bring a mass.
    #[default]
    None,
    /// The same for all, kg.
    Uniform(f32),
    /// One a vertex, kg.
    PerVertex(Vec<f32>),
}

/// How an example set is built.
#[derive(Debug, Clone, PartialEq)]
pub struct SetOptions {
    /// No vertex ever moves further than this, m. `None`: the deepest displacement of any example.
    pub depth_limit: Option<f32>,
    /// How the dents of several marks combine.
    pub combine: Combine,
    /// Whether carried examples may never be scaled above their own depth, as anchored ones never are.
    pub strict: bool,
    /// What becomes of examples that tear seams.
    pub seams: Seams,
    /// Mass of a vertex.
    pub mass: VertexMass,
    /// Displacements up to this length are dropped, m. 0 drops only exact zeros.
    pub drop_below: f32,
    /// Nodes along each side of a stamp: 4 to 128. With a tolerance, at most.
    pub stamp_resolution: u32,
    /// How far an example of weight 1 may put a vertex off, m. `None` keeps every displacement as an exact float. With a
    /// tolerance displacements are whole multiples of one step for the set, in the narrowest integers, and those no longer than
    /// the tolerance are dropped; stamps get the coarsest grid that holds it, if any of up to `stamp_resolution` nodes does
    /// ([`Stamp::error`] tells).
    pub tolerance: Option<f32>,
    /// With a tolerance: how far an example of weight 1 may turn a normal off, degrees; above 0 to 45.
    pub normal_tolerance: f32,
    /// Whether examples also serve mirrored, where the body is the same on both sides of a coordinate plane through the centre
    /// of its bounds.
    pub mirror: bool,
    /// Whether carried dents fall to zero towards edges of the sheet that the examples show to be held.
    pub held_rims: bool,
}

impl Default for SetOptions {
    fn default() -> Self {
        Self {
            depth_limit: None,
            combine: Combine::default(),
            strict: false,
            seams: Seams::default(),
            mass: VertexMass::default(),
            drop_below: 0.0,
            stamp_resolution: 32,
            tolerance: None,
            normal_tolerance: 1.0,
            mirror: true,
            held_rims: true,
        }
    }
}

/// One example of a set.
#[derive(Debug)]
pub struct Example {
    pub(crate) name: String,
    pub(crate) placement: Placement,
    pub(crate) contact_vertex: u32,
    pub(crate) contact_point: Vec3,
    pub(crate) contact_normal: Option<Vec3>,
    pub(crate) contact_delta: Vec3,
    pub(crate) depth: f32,
    /// Natural logarithm of `depth`: what selection compares.
    pub(crate) log_depth: f32,
    pub(crate) max_depth: f32,
    pub(crate) support_radius: f32,
    pub(crate) moved: usize,
    pub(crate) anchored: Arc<Anchored>,
    pub(crate) stamp: Option<Stamp>,
}

impl Example {
    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether it may be carried. [`Placement::Anchored`] where the mesh has no normals to carry it by.
    pub fn placement(&self) -> Placement {
        self.placement
    }

    /// The vertex that was hit when it was made.
    pub fn contact_vertex(&self) -> u32 {
        self.contact_vertex
    }

    /// Base position of that vertex, m.
    pub fn contact_point(&self) -> Vec3 {
        self.contact_point
    }

    /// Outward unit normal there.
    pub fn contact_normal(&self) -> Option<Vec3> {
        self.contact_normal
    }

    /// Displacement of the contact vertex as it was given, m: not rounded to a tolerance, since hits are compared with it.
    pub fn contact_displacement(&self) -> Vec3 {
        self.contact_delta
    }

    /// Length of that displacement, m. 0 only for an empty example.
    pub fn depth(&self) -> f32 {
        self.depth
    }

    /// Length of the longest displacement as stored, m.
    pub fn max_depth(&self) -> f32 {
        self.max_depth
    }

    /// Greatest distance from the contact of a vertex displaced by at least a hundredth of the deepest (as given), m.
    pub fn support_radius(&self) -> f32 {
        self.support_radius
    }

    /// Number of vertices it moves.
    pub fn moved_vertices(&self) -> usize {
        self.moved
    }

    /// Whether it moves nothing. Such an example is kept, so that indices stay the file's, but never chosen.
    pub fn is_empty(&self) -> bool {
        self.moved == 0
    }

    /// Displacement of vertex `v` as stored, m.
    pub fn delta(&self, v: u32) -> Vec3 {
        self.anchored.delta(v)
    }

    /// What a hit on vertex `v`, at position `p` (m), is compared with when the example stays where it was made: at its own
    /// contact the displacement as given, elsewhere as stored.
    pub(crate) fn met_at(&self, v: u32, p: Vec3) -> Vec3 {
        let stored = self.delta(v);
        // The other side of a seam that stays closed is the same place.
        let own = v == self.contact_vertex || (p == self.contact_point && stored == self.delta(self.contact_vertex));
        if own { self.contact_delta } else { stored }
    }

    /// Change of the unit normal of vertex `v`.
    pub fn normal_delta(&self, v: u32) -> Vec3 {
        self.anchored.normal_delta(v)
    }

    /// What is carried; `None` for an anchored or empty example.
    pub fn stamp(&self) -> Option<&Stamp> {
        self.stamp.as_ref()
    }

    pub(crate) fn anchored(&self) -> &Anchored {
        &self.anchored
    }

    pub(crate) fn log_depth(&self) -> f32 {
        self.log_depth
    }

    /// The stamp's frame: columns are x, y (in the surface) and z (the contact normal) in mesh space.
    pub fn frame(&self) -> glam::Mat3 {
        tangent_basis(self.contact_normal.unwrap_or(Vec3::Z))
    }
}

/// What building a set found out.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SetReport {
    /// Examples that move nothing.
    pub empty_examples: Vec<usize>,
    /// Coincident vertices that examples moved apart and that were welded, counted over all examples.
    pub welded: usize,
    /// The longest such gap, m.
    pub widest_weld: f32,
    /// Base normals of length zero that were replaced by computed ones.
    pub repaired_normals: usize,
    /// Triangles without area.
    pub degenerate_triangles: usize,
    /// Bytes of anchored displacements and normals, with their headers.
    pub anchored_bytes: usize,
    /// Of these, the normals'.
    pub normal_bytes: usize,
    /// Vertices that examples move, counted over all examples.
    pub moved_vertices: usize,
    /// Blocks of anchored displacements with 1, 2 and 4 bytes a number, counted over all examples.
    pub blocks_by_width: [usize; 3],
    /// Bytes of stamps.
    pub stamp_bytes: usize,
    /// Planes through the centre of the bounds that map the body onto itself; none where [`SetOptions::mirror`] is off.
    pub mirror_planes: Mirror,
    /// Vertices (seams counted) on edges that the examples show to be held.
    pub held_vertices: usize,
    /// Of each level of detail that was added; what stands above is the base mesh's alone.
    pub lods: Vec<LodReport>,
}

/// A base mesh with its examples. Immutable: share it (`Arc`) among the instances of the mesh and among threads.
///
/// ```
/// use crumple::{Deltas, ExampleData, ExampleSet, MeshData, Serial, SetOptions};
/// let mesh = MeshData {
///     positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
///     triangles: vec![[0, 1, 2]],
///     ..Default::default()
/// };
/// let dent = ExampleData::new("dent", Deltas::Sparse { indices: vec![0], values: vec![[0.0, 0.0, -0.1]] });
/// let set = ExampleSet::build(mesh, vec![dent], SetOptions::default(), &Serial)?;
/// assert_eq!(set.depth_limit(), 0.1);
/// # Ok::<(), crumple::Error>(())
/// ```
#[derive(Debug)]
pub struct ExampleSet {
    skin: Skin,
    /// Other meshes that show the same damage, from level of detail 1 on.
    lods: Vec<Skin>,
    examples: Vec<Example>,
    options: SetOptions,
    depth_limit: f32,
    index: VertexIndex,
    images: Images,
    learned: Learned,
    fingerprint: u64,
    report: SetReport,
    /// What the classic rules read, made for the first hit that needs it.
    sparse: Vec<OnceLock<Sparse>>,
    /// Of each vertex its number before [`reorder`](fn@crate::reorder); only for tools.
    source_order: Option<Array<u32>>,
    pub(crate) triangle_index: OnceLock<RTree<crate::attach::IndexedTriangle>>,
}

/// What a set is put together from, made or loaded.
pub(crate) struct Parts {
    pub skin: Skin,
    /// Levels of detail, each with its report.
    pub lods: Vec<(Skin, LodReport)>,
    pub examples: Vec<Example>,
    pub options: SetOptions,
    pub index: VertexIndex,
    pub learned: Learned,
    pub planes: Mirror,
    pub fingerprint: u64,
    pub welded: usize,
    pub widest_weld: f32,
    pub source_order: Option<Array<u32>>,
}

/// The longest displacement of any example, m, also of contacts before they are rounded.
pub(crate) fn deepest(examples: &[Example]) -> f32 {
    examples.iter().map(|e| e.max_depth.max(e.depth)).fold(0.0, f32::max)
}

impl ExampleSet {
    /// Checks everything and makes the examples ready; `tasks` runs the work.
    ///
    /// # Errors
    /// [`Error::Mesh`], [`Error::NoExamples`], [`Error::ExampleMismatch`], [`Error::IndexOutOfRange`],
    /// [`Error::NotFinite`], [`Error::InvalidArgument`] or [`Error::OutOfMemory`], each naming the value.
    pub fn build(
        mesh: MeshData,
        examples: Vec<ExampleData>,
        options: SetOptions,
        tasks: &dyn TaskSystem,
    ) -> Result<Self, Error> {
        check_options(&options, mesh.positions.len())?;
        if examples.is_empty() {
            return Err(Error::NoExamples { what: "0 were given; at least 1 is needed".into() });
        }
        if examples.len() >= usize::from(u16::MAX) {
            return Err(Error::NoExamples {
                what: format!("{} were given; at most 65534 are possible", examples.len()),
            });
        }
        let (mesh, smooth) = Mesh::new(mesh)?;
        let index = VertexIndex::new(mesh.positions(), mesh.weld(), tasks);
        let seams = seam_groups(mesh.weld());
        let steps = options.tolerance.map_or(Steps::EXACT, |t| Steps::new(t, options.normal_tolerance));
        let builder =
            ExampleBuilder { mesh: &mesh, index: &index, seams: &seams, smooth: &smooth, options: &options, steps };
        let built = map(tasks, examples.iter().enumerate(), |(i, e)| builder.build(i, e));
        let (mut welded, mut widest_weld) = (0, 0.0f32);
        let mut ready = reserve(examples.len(), "examples")?;
        let mut moves = reserve(examples.len(), "examples")?;
        for built in built {
            let built = built?;
            welded += built.welded;
            widest_weld = widest_weld.max(built.widest_weld);
            moves.push(built.moves);
            ready.push(built.example);
        }
        if deepest(&ready) == 0.0 {
            return Err(Error::NoExamples {
                what: format!("none of the {} given moves a vertex by more than {} m", ready.len(), options.drop_below),
            });
        }
        let planes =
            if options.mirror { mirror::planes(mesh.positions(), &index, &mesh.bounds()) } else { Mirror::NONE };
        let rim = if options.held_rims { Rim::find(&mesh, &moves) } else { Rim::default() };
        let mut set = Self::assemble(Parts {
            fingerprint: fingerprint(&mesh, &ready, &options),
            learned: Learned::nothing(ready.len()),
            skin: Skin::new(mesh, rim, ready.iter().map(|e| e.anchored.clone()).collect()),
            lods: Vec::new(),
            examples: ready,
            options,
            index,
            planes,
            welded,
            widest_weld,
            source_order: None,
        });
        set.learned = learn(&set, tasks);
        set.arrange();
        Ok(set)
    }

    /// Makes what was learned known to selection.
    fn arrange(&mut self) {
        self.images.arrange(&self.skin.mesh, &self.examples, &self.learned);
    }

    /// From parts that are as [`ExampleSet::build`] makes them.
    pub(crate) fn new(parts: Parts) -> Self {
        let mut set = Self::assemble(parts);
        set.arrange();
        set
    }

    fn assemble(p: Parts) -> Self {
        let mesh = &p.skin.mesh;
        let mut report = SetReport {
            welded: p.welded,
            widest_weld: p.widest_weld,
            repaired_normals: mesh.repaired_normals(),
            degenerate_triangles: mesh.degenerate_triangles(),
            mirror_planes: p.planes,
            held_vertices: p.skin.rim.vertices(),
            lods: p.lods.iter().map(|l| l.1).collect(),
            ..Default::default()
        };
        for (i, e) in p.examples.iter().enumerate() {
            let bytes: Bytes = e.anchored.bytes();
            report.anchored_bytes += bytes.total();
            report.normal_bytes += bytes.normals;
            report.moved_vertices += e.moved;
            report.blocks_by_width.iter_mut().zip(bytes.blocks).for_each(|(sum, n)| *sum += n);
            report.stamp_bytes += e.stamp.as_ref().map_or(0, Stamp::bytes);
            if e.is_empty() {
                report.empty_examples.push(i);
            }
        }
        Self {
            images: Images::new(mesh, &p.examples, p.planes),
            depth_limit: p.options.depth_limit.unwrap_or(deepest(&p.examples)),
            sparse: p.examples.iter().map(|_| OnceLock::new()).collect(),
            learned: p.learned,
            skin: p.skin,
            lods: p.lods.into_iter().map(|l| l.0).collect(),
            examples: p.examples,
            options: p.options,
            index: p.index,
            fingerprint: p.fingerprint,
            report,
            source_order: p.source_order,
            triangle_index: OnceLock::new(),
        }
    }

    /// The base mesh.
    pub fn mesh(&self) -> &Mesh {
        &self.skin.mesh
    }

    /// How many meshes show the damage: 1, the base mesh, and the levels of detail that were added.
    pub fn lod_count(&self) -> usize {
        1 + self.lods.len()
    }

    /// The mesh of a level of detail; 0 is the base mesh.
    ///
    /// # Errors
    /// [`Error::IndexOutOfRange`].
    pub fn lod_mesh(&self, lod: usize) -> Result<&Mesh, Error> {
        Ok(&self.lod(lod)?.mesh)
    }

    /// Number of vertices of the base mesh.
    pub fn vertex_count(&self) -> usize {
        self.skin.vertex_count()
    }

    /// The examples, in the order given.
    pub fn examples(&self) -> &[Example] {
        &self.examples
    }

    /// The options it was built with.
    pub fn options(&self) -> &SetOptions {
        &self.options
    }

    /// No vertex moves further than this, m, unless an instance sets its own limit.
    pub fn depth_limit(&self) -> f32 {
        self.depth_limit
    }

    /// A hash of all that marks depend on; saved damage carries it. The same on every platform.
    pub fn fingerprint(&self) -> u64 {
        self.fingerprint
    }

    /// What building it found out.
    pub fn report(&self) -> &SetReport {
        &self.report
    }

    /// Memory held for meshes and examples, bytes.
    pub fn memory_bytes(&self) -> usize {
        let images = self.images.bytes();
        self.skins().map(Skin::bytes).sum::<usize>()
            + self.index.bytes()
            + self.report.stamp_bytes
            + images
            + self.sparse.iter().filter_map(OnceLock::get).map(Sparse::bytes).sum::<usize>()
    }

    /// What it learned from its own examples, each left out in turn.
    pub fn learned(&self) -> &Learned {
        &self.learned
    }

    /// The vertex nearest to `point` (mesh space, m); the lowest index where several are equally near.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::InvalidArgument`] where the distance overflows.
    pub fn nearest_vertex(&self, point: [f32; 3]) -> Result<Nearest, Error> {
        let p = finite(point, || "point".into())?;
        self.index
            .nearest(p, self.mesh().positions())
            .ok_or_else(|| Error::invalid("point", p, "near enough that squared distances fit in f32"))
    }

    /// An example as the classic rules read it.
    pub(crate) fn sparse(&self, example: u32) -> &Sparse {
        let anchored = &self.skin.anchored[example as usize];
        self.sparse[example as usize].get_or_init(|| Sparse::new(anchored, self.mesh().normals().is_some()))
    }

    /// Of each vertex its number in the source, where the set was made from a [reordered](fn@crate::reorder) mesh and
    /// [told so](ExampleSet::set_source_order).
    pub fn source_order(&self) -> Option<&[u32]> {
        self.source_order.as_deref()
    }

    /// Keeps what [`reorder`](fn@crate::reorder) returned with the set, and with its file: of each vertex its number in the
    /// source. Nothing else depends on it.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] unless every number below the number of vertices is there once.
    pub fn set_source_order(&mut self, order: Vec<u32>) -> Result<(), Error> {
        crate::format::check_order(&order, self.vertex_count())
            .map_err(|(value, expected)| Error::invalid("the source order", value, &expected))?;
        self.source_order = Some(order.into());
        Ok(())
    }

    pub(crate) fn index(&self) -> &VertexIndex {
        &self.index
    }

    pub(crate) fn images(&self) -> &Images {
        &self.images
    }

    pub(crate) fn rim(&self) -> &Rim {
        &self.skin.rim
    }

    /// A hit on `contact` as examples are measured against it; `place_width` as a share of the diagonal.
    pub(crate) fn around(&self, contact: u32, direction: Vec3, size: f32, place_width: f32) -> Around<'_> {
        let negligible = 1e-6 * self.depth_limit;
        Around::new((self.mesh(), &self.examples, &self.images), (contact, direction, size), place_width, negligible)
    }

    /// What damage is shown on: the set's own mesh.
    pub(crate) fn skin(&self) -> &Skin {
        &self.skin
    }

    /// Everything that damage is shown on, the set's own mesh first.
    pub(crate) fn skins(&self) -> impl Iterator<Item = &Skin> {
        std::iter::once(&self.skin).chain(&self.lods)
    }

    /// The skin of a level of detail.
    pub(crate) fn lod(&self, lod: usize) -> Result<&Skin, Error> {
        self.skins().nth(lod).ok_or_else(|| Error::IndexOutOfRange {
            name: "the level of detail".into(),
            index: lod as u64,
            len: self.lod_count() as u64,
        })
    }

    pub(crate) fn push_lod(&mut self, skin: Skin, report: LodReport) {
        self.lods.push(skin);
        self.report.lods.push(report);
    }

    /// Mass of vertex `v`, kg.
    pub(crate) fn mass(&self, v: u32) -> Option<f32> {
        match &self.options.mass {
            VertexMass::None => None,
            VertexMass::Uniform(m) => Some(*m),
            VertexMass::PerVertex(m) => Some(m[v as usize]),
        }
    }
}

pub(crate) fn check_options(o: &SetOptions, vertices: usize) -> Result<(), Error> {
    if let Some(l) = o.depth_limit {
        positive("depth_limit", l, "m")?;
        if l > MAX_COORDINATE {
            return Err(Error::invalid("depth_limit", l, "at most 1e9 m"));
        }
    }
    at_least_zero("drop_below", o.drop_below, "m")?;
    if !(4..=128).contains(&o.stamp_resolution) {
        return Err(Error::invalid("stamp_resolution", o.stamp_resolution, "4 to 128"));
    }
    if let Some(t) = o.tolerance {
        positive("tolerance", t, "m")?;
        if !(o.normal_tolerance > 0.0 && o.normal_tolerance <= 45.0) {
            return Err(Error::invalid("normal_tolerance", o.normal_tolerance, "above 0 and at most 45 degrees"));
        }
    }
    match &o.mass {
        VertexMass::None => Ok(()),
        VertexMass::Uniform(m) => positive("vertex mass", *m, "kg"),
        VertexMass::PerVertex(m) => {
            if m.len() != vertices {
                return Err(Error::Mesh {
                    what: format!("{} vertex masses for {vertices} vertices; there must be as many", m.len()),
                });
            }
            m.iter().enumerate().try_for_each(|(i, m)| positive(&format!("mass of vertex {i}"), *m, "kg"))
        }
    }
}

/// Groups of two or more vertices at one position.
fn seam_groups(weld: &[u32]) -> Vec<Vec<u32>> {
    let mut pairs: Vec<(u32, u32)> =
        weld.iter().enumerate().filter(|(v, w)| **w as usize != *v).map(|(v, w)| (*w, v as u32)).collect();
    pairs.sort_unstable();
    pairs.chunk_by(|a, b| a.0 == b.0).map(|g| std::iter::once(g[0].0).chain(g.iter().map(|p| p.1)).collect()).collect()
}

fn fingerprint(mesh: &Mesh, examples: &[Example], options: &SetOptions) -> u64 {
    let mut h = Xxh3::new();
    let mut vec = |v: Vec3| v.to_array().iter().for_each(|x| h.update(&x.to_bits().to_le_bytes()));
    mesh.positions().iter().for_each(|p| vec(*p));
    for e in examples {
        vec(e.contact_point);
        vec(e.contact_normal.unwrap_or(Vec3::ZERO));
        vec(e.contact_delta);
        vec(Vec3::splat(e.placement as u8 as f32));
        e.anchored.iter().for_each(|(v, d, _)| {
            vec(Vec3::new(f32::from_bits(v), 0.0, 0.0));
            vec(d);
        });
    }
    h.update(&[options.combine as u8, u8::from(options.strict), options.stamp_resolution as u8]);
    h.update(&[u8::from(options.mirror), u8::from(options.held_rims)]);
    h.digest()
}

struct Built {
    example: Example,
    /// Which vertices it moves, for finding held rims.
    moves: Vec<bool>,
    welded: usize,
    widest_weld: f32,
}

struct ExampleBuilder<'a> {
    mesh: &'a Mesh,
    index: &'a VertexIndex,
    seams: &'a [Vec<u32>],
    smooth: &'a [Vec3],
    options: &'a SetOptions,
    steps: Steps,
}

impl ExampleBuilder<'_> {
    fn build(&self, i: usize, data: &ExampleData) -> Result<Built, Error> {
        let mismatch = |what: String| Error::ExampleMismatch { index: i, name: data.name.clone(), what };
        let mut deltas = self.dense(&data.positions, "displacement", &mismatch)?;
        for d in &mut deltas {
            if d.length() <= self.options.drop_below {
                *d = Vec3::ZERO;
            }
        }
        let (welded, widest_weld) = match self.options.seams {
            Seams::Weld => self.weld(&mut deltas),
            Seams::Keep => (0, 0.0),
        };
        let normals = match (&data.normals, self.mesh.normals()) {
            (Some(n), Some(_)) => Some(self.dense(n, "normal change", &mismatch)?),
            (None, Some(base)) => Some(self.computed_normals(&deltas, base)),
            (_, None) => None,
        };
        let (given, given_normals) = (deltas, normals);
        let (deltas, normals) = self.rounded(&given, given_normals.as_deref(), &mismatch)?;
        let moved = deltas.iter().filter(|d| **d != Vec3::ZERO).count();
        let longest = |deltas: &[Vec3]| deltas.iter().map(|d| d.length()).fold(0.0, f32::max);
        let (max_depth, deepest) = (longest(&deltas), longest(&given));
        let contact_vertex = self.contact_vertex(data, &given, &mismatch)?;
        let contact_point = self.mesh.positions()[contact_vertex as usize];
        let contact_delta = if moved > 0 { given[contact_vertex as usize] } else { Vec3::ZERO };
        let depth = contact_delta.length();
        if moved > 0 && depth == 0.0 {
            return Err(mismatch(format!(
                "it does not move its own contact, vertex {contact_vertex}; give a contact inside the dent, or none to take the deepest vertex"
            )));
        }
        let contact_normal =
            match data.contact_normal {
                Some(n) => {
                    let n = finite(n, || format!("contact normal of example {i} '{}'", data.name))?;
                    Some(unit(n).ok_or_else(|| {
                        mismatch("its contact normal has length 0; give a unit vector, or none".into())
                    })?)
                }
                None => self.mesh.contact_normal(contact_vertex),
            };
        // Carrying needs a normal wherever the body may be hit.
        let can_carry = self.mesh.normals().is_some();
        if data.placement == Placement::Carried && !can_carry {
            return Err(mismatch(
                "it is to be carried, but the mesh has neither normals nor triangles; give either".into(),
            ));
        }
        let placement = if can_carry { data.placement } else { Placement::Anchored };
        let support_radius = self
            .mesh
            .positions()
            .iter()
            .zip(&given)
            .filter(|(_, d)| d.length() >= SUPPORT * deepest && **d != Vec3::ZERO)
            .map(|(p, _)| (*p - contact_point).length())
            .fold(0.0, f32::max);
        let stamp = (placement != Placement::Anchored && moved > 0).then(|| {
            let source = Source {
                positions: self.mesh.positions(),
                index: self.index,
                deltas: &given,
                normals: given_normals.as_deref().zip(self.mesh.normals()),
                frame: tangent_basis(contact_normal.unwrap_or(Vec3::Z)),
                contact: contact_point,
                max_depth: deepest,
                support_radius,
            };
            Stamp::build(&source, self.options.stamp_resolution, self.options.tolerance)
        });
        let example = Example {
            name: data.name.clone(),
            placement,
            contact_vertex,
            contact_point,
            contact_normal,
            contact_delta,
            depth,
            log_depth: libm::logf(depth),
            max_depth,
            support_radius,
            moved,
            anchored: Arc::new(Anchored::new(&deltas, normals.as_deref(), self.steps)),
            stamp,
        };
        let moves = if self.options.held_rims { rim::moves(&given) } else { Vec::new() };
        Ok(Built { example, moves, welded, widest_weld })
    }

    /// Displacements and changes of normals as they will be stored.
    fn rounded(
        &self,
        deltas: &[Vec3],
        normals: Option<&[Vec3]>,
        mismatch: &dyn Fn(String) -> Error,
    ) -> Result<(Vec<Vec3>, Option<Vec<Vec3>>), Error> {
        let mut kept = reserve(deltas.len(), "an example's displacements")?;
        let least = self.options.tolerance.unwrap_or(0.0);
        kept.extend(deltas.iter().map(|d| self.steps.displacement(*d, least)));
        let longest = deltas.iter().map(|d| d.abs().max_element()).fold(0.0, f32::max);
        if self.steps.whole && longest > self.steps.position * Steps::MOST {
            return Err(mismatch(format!(
                "it moves a vertex by {longest} m, too far to be told to {least} m in a float; give a tolerance of at least {} m, or none",
                longest / Steps::MOST
            )));
        }
        let normals = normals.map(|n| n.iter().map(|n| self.steps.normal_change(*n)).collect());
        Ok((kept, normals))
    }

    /// One vector a vertex.
    fn dense(&self, deltas: &Deltas, what: &str, mismatch: &dyn Fn(String) -> Error) -> Result<Vec<Vec3>, Error> {
        let n = self.mesh.positions().len();
        let check = |v: u32, d: [f32; 3]| -> Result<Vec3, Error> {
            let x = Vec3::from_array(d);
            if !x.is_finite() {
                return Err(mismatch(format!("its {what} of vertex {v} is {d:?}; every component must be finite")));
            }
            if x.abs().max_element() > MAX_COORDINATE {
                return Err(mismatch(format!("its {what} of vertex {v} is {d:?}; at most 1e9 m is possible")));
            }
            Ok(x + Vec3::ZERO)
        };
        let mut out = reserve(n, "an example's displacements")?;
        match deltas {
            Deltas::Full(d) => {
                if d.len() != n {
                    return Err(mismatch(format!(
                        "it has {} {what}s, the base mesh {n} vertices; there must be as many, in the same order",
                        d.len()
                    )));
                }
                for (v, d) in d.iter().enumerate() {
                    out.push(check(v as u32, *d)?);
                }
            }
            Deltas::Sparse { indices, values } => {
                if indices.len() != values.len() {
                    return Err(mismatch(format!(
                        "it has {} indices and {} {what}s; there must be as many",
                        indices.len(),
                        values.len()
                    )));
                }
                out.resize(n, Vec3::ZERO);
                let mut last = None;
                for (v, d) in indices.iter().zip(values) {
                    if *v as usize >= n {
                        return Err(mismatch(format!("its index {v} is out of range; the base mesh has {n} vertices")));
                    }
                    if last.is_some_and(|l| l >= *v) {
                        return Err(mismatch(format!(
                            "its index {v} follows {}; indices must increase",
                            last.unwrap_or(0)
                        )));
                    }
                    last = Some(*v);
                    out[*v as usize] = check(*v, *d)?;
                }
            }
        }
        Ok(out)
    }

    /// Gives coincident vertices the mean of their displacements; how many differed, and the widest gap (m).
    fn weld(&self, deltas: &mut [Vec3]) -> (usize, f32) {
        let (mut count, mut widest) = (0, 0.0f32);
        for group in self.seams {
            let first = deltas[group[0] as usize];
            if group.iter().all(|v| deltas[*v as usize] == first) {
                continue;
            }
            let sum: glam::DVec3 = group.iter().map(|v| deltas[*v as usize].as_dvec3()).sum();
            let mean = (sum / group.len() as f64).as_vec3();
            for v in group {
                let d = &mut deltas[*v as usize];
                widest = widest.max((*d - first).length());
                *d = mean;
            }
            count += group.len();
        }
        (count, widest)
    }

    /// Changes of the base normals: each is turned as the smooth normal of the displaced surface turns.
    fn computed_normals(&self, deltas: &[Vec3], base: &[Vec3]) -> Vec<Vec3> {
        let (triangles, weld) = (self.mesh.triangles(), self.mesh.weld());
        let moved: Vec<Vec3> = self.mesh.positions().iter().zip(deltas).map(|(p, d)| *p + *d).collect();
        // Only around moved vertices, so that many small examples on a large mesh stay cheap.
        let mut near = vec![false; base.len()];
        for t in triangles {
            if t.iter().any(|v| deltas[*v as usize] != Vec3::ZERO) {
                t.iter().for_each(|v| near[weld[*v as usize] as usize] = true);
            }
        }
        let after = normals::smooth_where(&moved, triangles, weld, |w| near[w as usize]);
        (0..base.len())
            .map(|v| {
                let (a, b) = (self.smooth[v], after[v]);
                if a == Vec3::ZERO || b == Vec3::ZERO || a == b {
                    return Vec3::ZERO;
                }
                crate::math::rotation_between(a, b) * base[v] - base[v]
            })
            .collect()
    }

    fn contact_vertex(
        &self,
        data: &ExampleData,
        deltas: &[Vec3],
        mismatch: &dyn Fn(String) -> Error,
    ) -> Result<u32, Error> {
        match data.contact {
            Some(Contact::Vertex(v)) if (v as usize) < deltas.len() => Ok(v),
            Some(Contact::Vertex(v)) => Err(mismatch(format!(
                "its contact vertex {v} is out of range; the base mesh has {} vertices",
                deltas.len()
            ))),
            Some(Contact::Point(p)) => {
                let p = Vec3::from_array(p);
                let near = p.is_finite().then(|| self.index.nearest(p, self.mesh.positions())).flatten();
                near.map(|n| n.vertex)
                    .ok_or_else(|| mismatch(format!("its contact point is {p}; it must be finite and near the mesh")))
            }
            None => {
                let mut best = 0;
                for (v, d) in deltas.iter().enumerate() {
                    if d.length() > deltas[best].length() {
                        best = v;
                    }
                }
                Ok(best as u32)
            }
        }
    }
}
