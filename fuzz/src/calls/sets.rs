//! Calls that make, read and destroy example sets.

use std::ffi::{CStr, CString};
use std::mem::MaybeUninit;
use std::ptr::null;
use std::sync::OnceLock;

use crumple::Deltas;
use crumple::entry_points::*;

use super::arguments::{boolean, enumerator};
use super::{Host, Step};
use crate::seeds;

/// The path of a file of the tests.
macro_rules! fixture {
    ($name:literal) => {
        CStr::from_bytes_with_nul(concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/fixtures/", $name, "\0").as_bytes())
            .expect("a path with a zero at its end")
    };
}

impl Host<'_> {
    fn create_set(&mut self) -> Step<CrumpleResult> {
        let context = self.context()?;
        let mut mesh = seeds::sheet(2 + 2 * u32::from(self.bytes.arbitrary::<u8>()? & 1));
        if self.bytes.ratio(1, 8)? {
            let at = self.bytes.choose_index(mesh.positions.len())?;
            mesh.positions[at][2] = self.number()?;
        }
        if self.bytes.ratio(1, 8)? {
            let at = self.bytes.choose_index(mesh.triangles.len())?;
            mesh.triangles[at][0] = self.word()?;
        }
        let mut values = vec![0.5; 4 * mesh.positions.len()];
        let at = self.bytes.choose_index(values.len())?;
        values[at] = self.number()?;
        let dents = seeds::dents(&mesh, 2);
        let add = |(p, d): (&[f32; 3], &[f32; 3])| [0, 1, 2].map(|k| p[k] + d[k]);
        let targets: Vec<Vec<[f32; 3]>> = dents
            .iter()
            .map(|dent| {
                let Deltas::Full(deltas) = &dent.positions else { unreachable!("dents are full") };
                mesh.positions.iter().zip(deltas).map(add).collect()
            })
            .collect();
        let indices = [0u32, 1, 3];
        let name = CString::new("d\u{e9}lle").expect("no zero");
        let mut examples = Vec::new();
        for target in &targets {
            let mut def = self.patched(crumple_example_def_default())?;
            def.name = if self.bytes.ratio(1, 2)? { name.as_ptr() } else { null() };
            let empty = Self::no_input();
            (def.target_positions, def.target_normals) = (self.input(target)?, empty);
            (def.delta_indices, def.position_deltas, def.normal_deltas) = (empty, empty, empty);
            if self.bytes.ratio(1, 4)? {
                def.target_positions = empty;
                def.delta_count = 3;
                def.delta_indices = self.input(&indices)?;
                def.position_deltas = self.input(&target[..3])?;
            }
            examples.push(def);
        }
        let mut mesh_def = self.mesh_def(&mesh)?;
        let mut def = self.patched(CrumpleExampleSetDef { example_count: 2, ..crumple_example_set_def_default() })?;
        let masses = self.bytes.ratio(1, 4)?;
        def.options.vertex_masses =
            if masses { self.input(&values[..mesh.positions.len()])? } else { Self::no_input() };
        self.mesh(&mut mesh_def, &mesh, &values)?;
        def.mesh = &mesh_def;
        def.examples = examples.as_ptr();
        def.example_count = def.example_count.min(2);
        let mut set = CrumpleExampleSet::default();
        // SAFETY: the arrays live across the call.
        let result = unsafe { crumple_example_set_create(context, &def, &mut set) };
        self.keep_set(set);
        Ok(result)
    }

    fn add_lod(&mut self) -> Step<CrumpleResult> {
        let (context, set) = (self.context()?, self.set()?);
        let mesh = seeds::sheet(4);
        let values = vec![0.5; 4 * mesh.positions.len()];
        let mut def = self.mesh_def(&mesh)?;
        self.mesh(&mut def, &mesh, &values)?;
        let mut lod = 0;
        // SAFETY: the arrays live across the call.
        Ok(unsafe { crumple_example_set_add_lod(context, set, &def, &mut lod) })
    }

    /// Depth limits of a small mesh, from solids that may be open, far or without a size.
    fn keep_out(&mut self) -> Step<CrumpleResult> {
        let (mesh, solid) = (seeds::sheet(2), seeds::tetrahedron());
        let (values, mut limits) = (vec![0.5; 4 * mesh.positions.len()], vec![0.0; mesh.positions.len()]);
        let defs = [&mesh, &solid].map(|mesh| {
            let mut def = self.mesh_def(mesh)?;
            self.mesh(&mut def, mesh, &values)?;
            Ok(def)
        });
        let [mesh, solid] = defs;
        let (mesh, solids) = (mesh?, [solid?]);
        let mut capsules = Vec::new();
        for _ in 0..self.bytes.int_in_range(0..=2)? {
            capsules.push(CrumpleCapsule { a: self.point()?, b: self.point()?, radius: self.number()? });
        }
        let (given, count, solid_count) = (capsules.as_ptr(), capsules.len() as u32, self.word()?.min(1));
        // SAFETY: a mesh cannot have more vertices than its positions, which the limits have room for.
        Ok(unsafe { crumple_mesh_keep_out(&mesh, given, count, solids.as_ptr(), solid_count, limits.as_mut_ptr()) })
    }

    /// # Safety
    /// None is needed; the calls in it are unsafe.
    pub(super) unsafe fn set_call(&mut self, call: u8) -> Step<CrumpleResult> {
        match call {
            0..=1 => return self.create_set(),
            2 => return self.add_lod(),
            3 => return self.keep_out(),
            _ => {}
        }
        let (context, set, mut new) = (self.context()?, self.set()?, CrumpleExampleSet::default());
        let result = match call {
            4 => {
                let other = self.context()?;
                crumple_example_set_is_valid(other, set);
                crumple_example_set_share(context, set, other, &mut new)
            }
            5 => crumple_example_set_destroy(context, set),
            6..=7 => {
                let (bytes, kind) = (self.saved_bytes()?, enumerator(self.word()? & 1));
                let (data, size) = (bytes.as_ptr().cast(), bytes.len());
                self.saved.push(bytes); // it may be kept
                crumple_example_set_load_baked_memory(context, data, size, kind, &mut new)
            }
            8 => {
                let files = gltf_files();
                let file = &files[self.bytes.choose_index(files.len())?];
                let mut def = self.patched(crumple_gltf_def_default())?;
                (def.path, def.mesh_name, def.options.vertex_masses) = (null(), null(), Self::no_input());
                def.join_nodes = boolean(self.bytes.arbitrary()?);
                for patterns in [&mut def.nodes, &mut def.targets, &mut def.rigid, &mut def.glass, &mut def.moving] {
                    *patterns = [null(), c"*".as_ptr(), c"!*e*\nP?n*".as_ptr()][self.bytes.choose_index(3)?];
                }
                crumple_example_set_load_gltf_memory(context, file.as_ptr().cast(), file.len(), &def, &mut new)
            }
            9 => {
                let mut def = crumple_gltf_def_default();
                (def.path, def.join_nodes) = (self.path(fixture!("nodes.glb"))?, boolean(self.bytes.arbitrary()?));
                crumple_example_set_load_gltf(context, &def, &mut new)
            }
            10 => {
                let examples = [self.path(fixture!("plate_dent.obj"))?, self.path(fixture!("plate.obj"))?];
                let mut def = crumple_obj_def_default();
                (def.base_path, def.example_paths) = (self.path(fixture!("plate.obj"))?, examples.as_ptr());
                def.example_count = self.word()?.min(2);
                crumple_example_set_load_obj(context, &def, &mut new)
            }
            11 => crumple_example_set_load_baked(context, self.path(fixture!("nodes.glb"))?, &mut new),
            12 => {
                self.save(|data, capacity, size| crumple_example_set_save_baked(context, set, data, capacity, size));
                CrumpleResult::CrumpleOk
            }
            13 => {
                let (old, distance, bytes) = (self.set()?, self.number()?, self.saved_bytes()?);
                let (from, size) = (bytes.as_ptr().cast(), bytes.len());
                let mut mapping = MaybeUninit::uninit();
                self.save(|data, capacity, out| {
                    let mapping = mapping.as_mut_ptr();
                    crumple_example_set_map_damage(
                        context, set, old, from, size, distance, data, capacity, out, mapping,
                    )
                });
                CrumpleResult::CrumpleOk
            }
            14 => {
                let mut info = MaybeUninit::<CrumpleExampleSetInfo>::uninit();
                let result = crumple_example_set_get_info(context, set, info.as_mut_ptr());
                if result == CrumpleResult::CrumpleOk {
                    CStr::from_ptr(info.assume_init_ref().name).to_str().expect("UTF-8");
                }
                result
            }
            15 => crumple_example_set_get_example(context, set, self.word()?, MaybeUninit::uninit().as_mut_ptr()),
            16 => crumple_example_set_get_primitive(context, set, self.word()?, MaybeUninit::uninit().as_mut_ptr()),
            17 => {
                let (name, mut lod) = (self.path(c"hood")?, 0);
                let result = crumple_example_set_find_part(context, set, name, &mut lod);
                let mut part = MaybeUninit::<CrumplePart>::uninit();
                if crumple_example_set_get_part(context, set, lod, part.as_mut_ptr()) == CrumpleResult::CrumpleOk {
                    CStr::from_ptr(part.assume_init_ref().name).to_str().expect("UTF-8");
                }
                result
            }
            18 => {
                let streams = self.buffer_def()?;
                let def = CrumpleMeshCopyDef {
                    lod: streams.lod,
                    positions: streams.positions,
                    normals: streams.normals,
                    tangents: streams.tangents,
                    ..crumple_mesh_copy_def_default()
                };
                crumple_example_set_copy_mesh(context, set, &def)
            }
            19 => {
                let (point, mut vertex, mut distance) = (self.point()?, 0, 0.0);
                crumple_example_set_find_nearest_vertex(context, set, point, &mut vertex, &mut distance)
            }
            _ => {
                let (point, mut at) = (self.point()?, MaybeUninit::uninit());
                let result = crumple_example_set_attach_point(context, set, point, at.as_mut_ptr());
                if result == CrumpleResult::CrumpleOk {
                    self.attachments.push(at.assume_init());
                }
                result
            }
        };
        self.keep_set(new);
        Ok(result)
    }

    /// Remembers a set if there is one.
    fn keep_set(&mut self, set: CrumpleExampleSet) {
        if set.generation != 0 {
            self.sets.push(set);
        }
    }
}

/// glTF files of one mesh, and of bodies of several nodes.
fn gltf_files() -> &'static [Vec<u8>] {
    static FILES: OnceLock<Vec<Vec<u8>>> = OnceLock::new();
    FILES.get_or_init(|| seeds::gltf().iter().map(|(_, parts)| seeds::glb(parts)).collect())
}
