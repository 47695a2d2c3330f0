//! Builds an example set from plain arrays.

use crate::base::error::Error;
use crate::base::error::reserve;
use crate::base::math::{rotation_between, unit};
use crate::base::tasks::TaskSystem;
use crate::base::tasks::map;
use crate::example::blocks::{DeltaBlocks, Steps};
use crate::example::blow::Blow;
use crate::example::data::{Contact, Deltas, ExampleData};
use crate::example::example::Example;
use crate::example::mesh_lod::MeshLod;
use crate::example::options::{SetOptions, check_options};
use crate::example::report::SetReport;
use crate::example::set::{ExampleSet, Parts, deepest};
use crate::mesh::data::MeshData;
use crate::mesh::field::{Field, zeros};
use crate::mesh::mirror;
use crate::mesh::nearest::VertexIndex;
use crate::mesh::normals::{self, BlockTriangles};
use crate::mesh::rim::{self, Rim};
use crate::mesh::vertex_blocks::BLOCK;
use crate::mesh::{MAX_COORDINATE, Mesh, finite};
use glam::Vec3;
use std::hash::Hasher;
use std::sync::Arc;
use twox_hash::XxHash3_64;

/// Numbers that are hashed at once.
const PIECE: usize = 4096;
/// Vertices displaced by less than this share of an example's deepest displacement do not count for its support radius.
const SUPPORT: f32 = 0.01;

impl ExampleSet {
    /// Checks all input and builds the set. `tasks` runs the work.
    ///
    /// # Errors
    /// [`Error::Mesh`], [`Error::NoExamples`], [`Error::ExampleMismatch`], [`Error::IndexOutOfRange`],
    /// [`Error::NotFinite`], [`Error::InvalidArgument`] or [`Error::OutOfMemory`]. Each names the wrong value.
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
        let index = VertexIndex::new(mesh.positions(), mesh.weld());
        let seams = seam_groups(mesh.weld());
        let steps = options.tolerance.map_or(Steps::EXACT, |t| Steps::new(t, options.normal_tolerance));
        let around = BlockTriangles::new(mesh.triangles(), mesh.weld());
        let (smooth, around) = (&smooth[..], &around);
        let builder =
            ExampleBuilder { mesh: &mesh, index: &index, seams: &seams, smooth, around, options: &options, steps };
        let built = map(tasks, examples.iter().enumerate(), |(i, e)| builder.build(i, e));
        let (mut report, mut given) = (SetReport::default(), 0.0f32);
        let mut ready = reserve(examples.len(), "examples")?;
        let mut moves = reserve(examples.len(), "examples")?;
        for built in built {
            let built = built?;
            report.welded += built.welded;
            report.widest_weld = report.widest_weld.max(built.widest_weld);
            given = given.max(built.deepest);
            moves.push(built.moves);
            ready.push(built.example);
        }
        if deepest(&ready) == 0.0 {
            if let (Some(t), true) = (options.tolerance, given > 0.0) {
                let expected =
                    format!("below the largest displacement of the examples, {given} m; did you mean {t} mm?");
                return Err(Error::invalid("tolerance", format!("{t} m"), &expected));
            }
            return Err(Error::NoExamples {
                what: format!("none of the {} given moves a vertex by more than {} m", ready.len(), options.drop_below),
            });
        }
        if options.mirror {
            report.mirror_planes = mirror::planes(mesh.positions(), &index, &mesh.bounds());
        }
        let rim = if options.held_rims { Rim::find(&mesh, &moves) } else { Rim::default() };
        let mut set = Self::assemble(Parts {
            fingerprint: fingerprint(&mesh, &ready, &options),
            base: MeshLod::new(mesh, rim, ready.iter().filter_map(|e| e.whole.clone()).collect()),
            lods: Vec::new(),
            examples: ready,
            options,
            index,
            report,
            source_order: None,
        });
        set.learn(tasks)?;
        Ok(set)
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
    let mut h = XxHash3_64::default();
    // In pieces, which the hash takes faster than single numbers.
    let mut numbers: Vec<u32> = Vec::with_capacity(PIECE);
    let mut vec = |v: Vec3| {
        numbers.extend(v.to_array().map(|x| x.to_bits().to_le()));
        if numbers.len() + 3 > PIECE {
            h.write(bytemuck::cast_slice(&numbers));
            numbers.clear();
        }
    };
    mesh.positions().iter().for_each(|p| vec(*p));
    for e in examples {
        vec(e.contact_point);
        vec(e.contact_normal.unwrap_or(Vec3::ZERO));
        vec(e.contact_delta);
        e.whole.iter().flat_map(|whole| whole.iter()).for_each(|(v, d, _)| {
            vec(Vec3::new(f32::from_bits(v), 0.0, 0.0));
            vec(d);
        });
    }
    h.write(bytemuck::cast_slice(&numbers));
    h.write(&[u8::from(options.mirror), u8::from(options.held_rims)]);
    mesh.limits().parts().iter().for_each(|halves| h.write(bytemuck::cast_slice(halves)));
    h.finish()
}

struct Built {
    example: Example,
    /// Whether the example moves each vertex. Empty unless held rims are wanted.
    moves: Vec<bool>,
    welded: usize,
    widest_weld: f32,
    /// Longest displacement before rounding to the tolerance, m.
    deepest: f32,
}

struct ExampleBuilder<'a> {
    mesh: &'a Mesh,
    index: &'a VertexIndex,
    seams: &'a [Vec<u32>],
    smooth: &'a [Vec3],
    around: &'a BlockTriangles,
    options: &'a SetOptions,
    steps: Steps,
}

impl ExampleBuilder<'_> {
    fn build(&self, i: usize, data: &ExampleData) -> Result<Built, Error> {
        let mismatch = |what: String| Error::ExampleMismatch { index: i, name: data.name.clone(), what };
        let mut deltas = self.dense(&data.positions, "displacement", &mismatch)?;
        let small = |d: &Vec3| d.length() <= self.options.drop_below;
        deltas = deltas.map("an example's displacements", |d| if small(&d) { Vec3::ZERO } else { d })?;
        let (welded, widest_weld) = self.weld(&mut deltas);
        deltas.prune();
        let normals = match (&data.normals, self.mesh.normals()) {
            (Some(n), Some(_)) => Some(self.dense(n, "normal change", &mismatch)?),
            (None, Some(base)) => Some(self.computed_normals(&deltas, base)?),
            (_, None) => None,
        };
        let (given, given_normals) = (deltas, normals);
        let (deltas, normals) = self.rounded(&given, given_normals.as_ref(), &mismatch)?;
        let moved = deltas.moved().count();
        let (max_depth, deepest) = (deltas.longest(), given.longest());
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
        let blow = Blow { normal: data.blow.normal.or(data.contact_normal), ..data.blow };
        let blow = blow.checked(|part| format!("blow.{part} of example {i} '{}'", data.name))?;
        let support = given.moved().filter(|(_, d)| d.length() >= SUPPORT * deepest);
        let support_radius =
            support.map(|(v, _)| (self.mesh.positions()[v] - contact_point).length()).fold(0.0, f32::max);
        let mut blocks = [deltas.blocks(), normals.as_ref().map_or(&[], Field::blocks)].concat();
        blocks.sort_unstable();
        blocks.dedup();
        let whole = DeltaBlocks::of_blocks(blocks, &deltas, normals.as_deref(), self.steps);
        let example = Example {
            name: data.name.clone(),
            contact_vertex,
            contact_point,
            contact_normal,
            contact_delta,
            blow,
            depth,
            max_depth,
            support_radius,
            moved,
            whole: Some(Arc::new(whole)),
            followed: None,
        };
        let moves = if self.options.held_rims { rim::moves(&given) } else { Vec::new() };
        Ok(Built { example, moves, welded, widest_weld, deepest })
    }

    /// Rounds displacements and changes of normals as they will be stored.
    fn rounded(
        &self,
        deltas: &Field,
        normals: Option<&Field>,
        mismatch: &dyn Fn(String) -> Error,
    ) -> Result<(Field, Option<Field>), Error> {
        let least = self.options.tolerance.unwrap_or(0.0);
        let kept = deltas.map("an example's displacements", |d| self.steps.displacement(d, least))?;
        let longest = deltas.moved().map(|(_, d)| d.abs().max_element()).fold(0.0, f32::max);
        if self.steps.whole && longest > self.steps.position * Steps::MOST {
            return Err(mismatch(format!(
                "it moves a vertex by {longest} m, too far to be told to {least} m in a float; give a tolerance of at least {} m, or none",
                longest / Steps::MOST
            )));
        }
        let change = |n: &Field| n.map("an example's normals", |n| self.steps.normal_change(n));
        Ok((kept, normals.map(change).transpose()?))
    }

    /// Checks `deltas` and expands them to one vector per vertex.
    fn dense(&self, deltas: &Deltas, what: &str, mismatch: &dyn Fn(String) -> Error) -> Result<Field, Error> {
        let n = self.mesh.positions().len();
        let given: Vec<(u32, [f32; 3])> = match deltas {
            Deltas::Full(d) if d.len() != n => {
                return Err(mismatch(format!(
                    "it has {} {what}s, the base mesh {n} vertices; there must be as many, in the same order",
                    d.len()
                )));
            }
            Deltas::Full(d) => (0..).zip(d.iter().copied()).filter(|(_, d)| *d != [0.0; 3]).collect(),
            Deltas::Sparse { indices, values } => {
                if indices.len() != values.len() {
                    return Err(mismatch(format!(
                        "it has {} indices and {} {what}s; there must be as many",
                        indices.len(),
                        values.len()
                    )));
                }
                if let Some(v) = indices.iter().find(|v| **v as usize >= n) {
                    return Err(mismatch(format!("its index {v} is out of range; the base mesh has {n} vertices")));
                }
                if let Some(pair) = indices.windows(2).find(|pair| pair[0] >= pair[1]) {
                    return Err(mismatch(format!("its index {} follows {}; indices must increase", pair[1], pair[0])));
                }
                indices.iter().copied().zip(values.iter().copied()).collect()
            }
        };
        let mut field = Field::zero(n, "an example's displacements")?;
        let check = |(v, d): (u32, [f32; 3])| {
            let x = Vec3::from_array(d);
            if !x.is_finite() {
                return Err(mismatch(format!("its {what} of vertex {v} is {d:?}; every component must be finite")));
            }
            if x.abs().max_element() > MAX_COORDINATE {
                return Err(mismatch(format!("its {what} of vertex {v} is {d:?}; at most 1e9 m is possible")));
            }
            Ok((v as usize, x + Vec3::ZERO))
        };
        field.set(given.into_iter().map(check).collect::<Result<Vec<_>, Error>>()?);
        Ok(field)
    }

    /// Gives coincident vertices the mean of their displacements. Returns the number of vertices whose displacements
    /// differed, and the widest gap (m).
    fn weld(&self, deltas: &mut Field) -> (usize, f32) {
        let (mut count, mut widest) = (0, 0.0f32);
        let mut welded = Vec::new();
        for group in self.seams {
            let first = deltas[group[0] as usize];
            if group.iter().all(|v| deltas[*v as usize] == first) {
                continue;
            }
            let sum: glam::DVec3 = group.iter().map(|v| deltas[*v as usize].as_dvec3()).sum();
            let mean = (sum / group.len() as f64).as_vec3();
            for v in group {
                widest = widest.max((deltas[*v as usize] - first).length());
                welded.push((*v as usize, mean));
            }
            count += group.len();
        }
        deltas.set(welded);
        (count, widest)
    }

    /// Changes of the base normals. Each base normal turns like the smooth normal of the surface. Only the surroundings
    /// of moved vertices are computed.
    fn computed_normals(&self, deltas: &Field, base: &[Vec3]) -> Result<Field, Error> {
        let (triangles, weld) = (self.mesh.triangles(), self.mesh.weld());
        let triangle = |t: &u32| triangles[*t as usize];
        // The positions whose normal may change, each as its lowest vertex.
        let mut near: Vec<u32> = Vec::new();
        for t in self.around.of(deltas.blocks()).iter().map(triangle) {
            if t.iter().any(|v| deltas[*v as usize] != Vec3::ZERO) {
                near.extend(t.map(|v| weld[v as usize]));
            }
        }
        near.sort_unstable();
        near.dedup();
        let mut blocks: Vec<u32> = near.iter().map(|w| w / BLOCK as u32).collect();
        blocks.dedup();
        let mut wanted = zeros(base.len(), "an example's normals")?;
        near.iter().for_each(|w| wanted[*w as usize] = true);
        let mut sums = zeros(base.len(), "an example's normals")?;
        let position = |v: u32| self.mesh.positions()[v as usize] + deltas[v as usize];
        let around = self.around.of(&blocks);
        normals::add_corners(&mut sums, position, around.iter().map(triangle), weld, |w| wanted[w as usize]);
        let mut changed = Vec::new();
        for w in &near {
            let (a, b) = (self.smooth[*w as usize], normals::normal(sums[*w as usize]));
            if a == Vec3::ZERO || b == Vec3::ZERO || a == b {
                continue;
            }
            let turn = rotation_between(a, b);
            let others = self.seams.binary_search_by_key(w, |group| group[0]).map_or(&[][..], |g| &self.seams[g][1..]);
            let own = [*w].into_iter().chain(others.iter().copied()).map(|v| v as usize);
            changed.extend(own.map(|v| (v, turn * base[v] - base[v])));
        }
        let mut changes = Field::zero(base.len(), "an example's normals")?;
        changes.set(changed);
        changes.prune();
        Ok(changes)
    }

    fn contact_vertex(
        &self,
        data: &ExampleData,
        deltas: &Field,
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
                for (v, d) in deltas.moved() {
                    if d.length() > deltas[best].length() {
                        best = v;
                    }
                }
                Ok(best as u32)
            }
        }
    }
}
