//! The body that is read from a glTF: one mesh in its own space, or the meshes of nodes joined in the scene's.

use super::document::Document;
use super::extras;
use super::join::{self, Group};
use super::nodes::Nodes;
use super::piece::{Body, Piece, Target};
use super::primitives::{deltas, primitives, target_count};
use super::reading::{Marks, MeshChoice, Patterns, Reading};
use super::surface::Surface;
use super::words::{cut, listed, some};
use super::{Imported, PartKind, malformed, notes, uri};
use crate::base::error::Error;
use crate::mesh::data::MeshData;
use crate::mesh::keep_out::Solid;
use glam::{DMat3, DMat4, DVec3, Mat4, Vec3};
use std::path::Path;

/// Reads a mesh, or a body of the meshes of nodes, with its morph targets from a `.gltf` or `.glb` file. The [module](super)
/// describes what is read.
///
/// ```
/// use crumple::import::{MeshChoice, gltf_file};
/// # let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
/// let imported = gltf_file(&folder.join("tests/fixtures/two_materials.glb"), MeshChoice::First)?;
/// assert_eq!(imported.primitives.len(), 2);
/// for example in &imported.examples {
///     println!("{} was hit at {:?}", example.name, example.contact);
/// }
/// # Ok::<(), crumple::Error>(())
/// ```
///
/// # Errors
/// [`Error::Io`] if the file or one of its buffers cannot be read; [`Error::Unsupported`] for Draco's compression and other
/// versions; [`Error::NoSuchMesh`] and [`Error::NoExamples`], which list what the file has; [`Error::InvalidArgument`] for a pattern
/// that matches nothing; [`Error::Format`], [`Error::IndexOutOfRange`] and [`Error::NotFinite`], which name what is wrong in the
/// file.
pub fn gltf_file(path: &Path, reading: impl Into<Reading>) -> Result<Imported, Error> {
    let reading = reading.into();
    let imported = gltf_slice(&uri::read(path, None)?, path.parent(), &reading)?;
    Ok(match reading.mesh {
        MeshChoice::Nodes(_) => {
            Imported { name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(), ..imported }
        }
        _ => imported,
    })
}

/// Reads the same from memory. Relative paths of external buffers start at `base_dir`; without it they are an error. A body of
/// nodes has no name.
///
/// # Errors
/// As [`gltf_file`].
pub fn gltf_slice(bytes: &[u8], base_dir: Option<&Path>, reading: impl Into<Reading>) -> Result<Imported, Error> {
    Ok(read(&Document::parse(bytes, base_dir)?, &reading.into())?.imported)
}

/// Reads every mesh of a glTF file as a solid in the space of a body's mesh. `body` is the [`Imported::node_transform`] of the
/// body, whose file shares its scene with this one: each solid is taken to where the lowest-numbered node that shows it
/// places it, and from there into the body's space. Relative paths of external buffers start at `base_dir`; without it they
/// are an error.
///
/// # Errors
/// Those of [`gltf_file`]; [`Error::NoSuchMesh`] for a file without meshes; [`Error::InvalidArgument`] for a `body` that has no
/// inverse.
pub fn gltf_solids(bytes: &[u8], base_dir: Option<&Path>, body: Option<[[f32; 4]; 4]>) -> Result<Vec<Solid>, Error> {
    let body = body.map_or(Mat4::IDENTITY, |columns| Mat4::from_cols_array_2d(&columns));
    let into_body = body.inverse();
    if !into_body.is_finite() {
        return Err(Error::invalid("the body's node transform", body, "a matrix with an inverse"));
    }
    let doc = Document::parse(bytes, base_dir)?;
    if doc.meshes.len() == 0 {
        return Err(Error::NoSuchMesh { wanted: "a solid".into(), available: meshes(&doc, Vec::new()) });
    }
    let nodes = Nodes::of(&doc)?;
    let solid = |mesh| {
        let surface = Surface::read(&doc, &primitives(&doc, mesh)?, &mut Vec::new())?;
        let MeshData { mut positions, triangles, .. } = surface.data;
        let to_body = into_body * nodes.transform_of_mesh(mesh)?.unwrap_or(Mat4::IDENTITY);
        for p in positions.iter_mut().filter(|_| to_body != Mat4::IDENTITY) {
            *p = to_body.transform_point3(Vec3::from(*p)).to_array();
        }
        Ok(Solid::Mesh { positions, triangles })
    };
    (0..doc.meshes.len()).map(solid).collect()
}

/// Reads what `reading` chooses.
pub(crate) fn read<'d>(doc: &'d Document<'_>, reading: &Reading) -> Result<Body<'d>, Error> {
    reading.check()?;
    let nodes = Nodes::of(doc)?;
    let source = Source { doc, nodes: &nodes, marks: &Marks::of(doc, &nodes, reading)?, reading };
    let unknown = |name: &&str| {
        format!("the file requires {name}, which is not known here; it is kept, and the meshes are read without it")
    };
    let mut notes: Vec<String> = doc.unknown_requirements().iter().map(unknown).collect();
    let named = |name: &str, mesh: usize| doc.value["meshes"][mesh]["name"] == name;
    let mut body = match &reading.mesh {
        MeshChoice::Nodes(_) => source.joined(&mut notes)?,
        MeshChoice::First => source.single(source.first(&mut notes)?, &mut notes)?,
        MeshChoice::Index(index) => source.wanted(index.to_string(), |mesh| mesh == *index, &mut notes)?,
        MeshChoice::Name(name) => source.wanted(format!("'{name}'"), |mesh| named(name, mesh), &mut notes)?,
    };
    notes::look(&body.imported, &mut notes);
    body.imported.notes = notes;
    Ok(body)
}

/// What bodies are read from.
struct Source<'s, 'd, 'a> {
    doc: &'d Document<'a>,
    nodes: &'s Nodes<'d, 'a>,
    marks: &'s Marks<'s>,
    reading: &'s Reading,
}

impl<'d> Source<'_, 'd, '_> {
    /// The first mesh that can be used: its dents move a vertex. A broken mesh is passed over.
    fn first(&self, notes: &mut Vec<String>) -> Result<Piece<'d>, Error> {
        let (mut broken, mut still, mut unchosen) = (None, None, None);
        for mesh in 0..self.doc.meshes.len() {
            let has_targets = self.doc.meshes.get(mesh, "mesh").map(|mesh| target_count(mesh) > 0);
            if has_targets == Ok(false) {
                continue;
            }
            let mut own = Vec::new();
            match self.piece(mesh, None, &mut own) {
                Ok(piece) if piece.targets.iter().any(|target| !target.moved.is_empty()) => {
                    if let Some((mesh, error)) = broken {
                        notes.push(format!("{} was passed over: {error}", self.doc.mesh_label(mesh)));
                    }
                    notes.append(&mut own);
                    return Ok(piece);
                }
                Ok(piece) if piece.dents.is_empty() => unchosen = unchosen.or(Some(piece)),
                Ok(_) => still = still.or(Some(mesh)),
                Err(error) => broken = broken.or(Some((mesh, error))),
            }
        }
        match (broken, still, unchosen) {
            (Some((_, error)), ..) => Err(error),
            (None, None, Some(piece)) => Err(self.no_dents(&piece)),
            (None, Some(mesh), _) => {
                let what =
                    format!("no morph target of {} moves a vertex; {}", self.doc.mesh_label(mesh), self.with_targets());
                Err(Error::NoExamples { what })
            }
            (None, None, None) => Err(Error::NoExamples { what: self.with_targets() }),
        }
    }

    /// The first mesh that is wanted.
    fn wanted(&self, name: String, is: impl Fn(usize) -> bool, notes: &mut Vec<String>) -> Result<Body<'d>, Error> {
        let found = (0..self.doc.meshes.len()).find(|mesh| is(*mesh));
        let mesh = found.ok_or_else(|| Error::NoSuchMesh { wanted: name, available: self.some_meshes() })?;
        self.single(self.piece(mesh, None, notes)?, notes)
    }

    /// Why a mesh has no examples.
    fn no_dents(&self, piece: &Piece<'_>) -> Error {
        if let Err(error) = self.targets_match(std::slice::from_ref(piece)) {
            return error;
        }
        let label = self.doc.mesh_label(piece.mesh);
        let what = if piece.names.is_empty() {
            format!("{label} has no morph targets; {}", self.with_targets())
        } else {
            let names = listed(piece.names.iter());
            format!("none of the morph targets of {label} is chosen as a dent: it has {names}")
        };
        Error::NoExamples { what }
    }

    fn single(&self, piece: Piece<'d>, notes: &mut Vec<String>) -> Result<Body<'d>, Error> {
        if piece.dents.is_empty() {
            return Err(self.no_dents(&piece));
        }
        self.targets_match(std::slice::from_ref(&piece))?;
        let weights = |node: usize| self.weights(piece.mesh, Some(node));
        let mut others = self.nodes_of(piece.mesh);
        others.retain(|node| !piece.nodes.contains(node));
        if let Some(node) = others.first() {
            debug_assert!(weights(*node) != weights(piece.nodes[0]));
            let (count, name) = (others.len(), self.nodes.name(*node));
            notes.push(format!(
                "{count} of the nodes that show this mesh, such as '{name}', show it with other weights and are not dented"
            ));
        }
        let alone = Group { name: None, kind: piece.kind, pieces: vec![piece] };
        let mut body = join::joined(self.doc, vec![alone], notes)?;
        let piece = &body.pieces[0];
        body.imported.name = self.doc.value["meshes"][piece.mesh]["name"].as_str().unwrap_or_default().to_owned();
        // The scene has the unit of the file, as the mesh has.
        let unit = self.reading.unit;
        body.imported.node_transform = self.nodes.transform_of_mesh(piece.mesh)?.map(|transform| {
            let [x, y, z, [tx, ty, tz, w]] = transform.to_cols_array_2d();
            [x, y, z, [tx * unit, ty * unit, tz * unit, w]]
        });
        Ok(body)
    }

    fn joined(&self, notes: &mut Vec<String>) -> Result<Body<'d>, Error> {
        let (chosen, mut aside) = self.marks.chosen();
        let mesh = |node: usize| Some((node, self.doc.nodes[node].mesh?.value()));
        let mut shown: Vec<(usize, usize)> = chosen.into_iter().filter_map(mesh).collect();
        aside.retain(|node| mesh(*node).is_some());
        if let Some(first) = aside.first() {
            notes.push(format!(
                "{} nodes with meshes, such as '{}', are of other scenes or are levels of detail, and stay as they are; name them \
                 with --nodes to take them",
                aside.len(),
                cut(&self.nodes.name(*first))
            ));
        }
        self.leave_flat(&mut shown, notes)?;
        if shown.is_empty() {
            let with_meshes = self.doc.nodes.iter().filter(|node| node.mesh.is_some()).count();
            if with_meshes == 0 && self.doc.meshes.len() > 0 {
                let all = self.some_meshes();
                return Err(Error::NoSuchMesh {
                    wanted: "of a node".into(),
                    available: format!("{all}, which no node shows; choose one (--mesh) instead of nodes"),
                });
            }
            return Err(Error::NoSuchMesh {
                wanted: "of the chosen nodes".into(),
                available: format!("{with_meshes} nodes with meshes; none of them is chosen and dents"),
            });
        }
        let mut own = Vec::new();
        let piece = |(node, mesh): &(usize, usize)| self.piece(*mesh, Some(*node), &mut own);
        let pieces = shown.iter().map(piece).collect::<Result<Vec<_>, Error>>()?;
        // Hundreds of parts may have the same fault.
        const SHOWN: usize = 3;
        let more = own.len().saturating_sub(SHOWN);
        notes.extend(own.drain(..own.len().min(SHOWN)));
        if more > 0 {
            notes.push(format!(
                "{more} more remarks on meshes of the body are left out; read a mesh alone to see its own"
            ));
        }
        self.targets_match(&pieces)?;
        let body = join::joined(self.doc, join::grouped(pieces, self.nodes, notes)?, notes)?;
        if body.imported.examples.is_empty() {
            return Err(match body.pieces.iter().find(|piece| !piece.names.is_empty()) {
                Some(piece) => self.no_dents(piece),
                None => {
                    let (count, others) = (shown.len(), self.with_targets());
                    let what = format!("no mesh of the {count} chosen nodes has morph targets; {others}");
                    Error::NoExamples { what }
                }
            });
        }
        Ok(body)
    }

    /// Leaves out nodes that a scale of 0 hides, unless all are.
    fn leave_flat(&self, shown: &mut Vec<(usize, usize)>, notes: &mut Vec<String>) -> Result<(), Error> {
        let (mut flat, mut others) = (Vec::new(), Vec::new());
        for (node, mesh) in &*shown {
            let world = self.nodes.shown(*node, &mut Vec::new())?;
            let is_flat = !DMat3::from_mat4(world).inverse().is_finite();
            if is_flat { &mut flat } else { &mut others }.push((*node, *mesh));
        }
        if let (Some((first, _)), false) = (flat.first(), others.is_empty()) {
            let (hidden, name) = (flat.len(), self.nodes.name(*first));
            notes.push(format!("{hidden} nodes, such as '{}', have a scale of 0 and stay as they are", cut(&name)));
            *shown = others;
        }
        Ok(())
    }

    fn some_meshes(&self) -> String {
        meshes(self.doc, (0..self.doc.meshes.len()).collect())
    }

    /// Fails if a pattern of the reading matches no target.
    fn targets_match(&self, pieces: &[Piece<'_>]) -> Result<(), Error> {
        let names: Vec<&str> = pieces.iter().flat_map(|piece| &piece.names).map(String::as_str).collect();
        self.reading.targets.all_match("morph targets", &names)
    }

    /// The nodes that show a mesh.
    fn nodes_of(&self, mesh: usize) -> Vec<usize> {
        let shows = |node: &usize| self.doc.nodes[*node].mesh.is_some_and(|shown| shown.value() == mesh);
        (0..self.doc.nodes.len()).filter(shows).collect()
    }

    /// The default weights of a mesh where a node shows it.
    fn weights(&self, mesh: usize, node: Option<usize>) -> &[f32] {
        let own = node.and_then(|node| self.doc.nodes[node].weights.as_deref());
        let of_mesh = || self.doc.meshes.get(mesh, "mesh").ok()?.weights.as_deref();
        own.or_else(of_mesh).unwrap_or_default()
    }

    /// Reads a mesh: in the scene's space where `node` shows it, or in its own space.
    fn piece(&self, mesh: usize, node: Option<usize>, notes: &mut Vec<String>) -> Result<Piece<'d>, Error> {
        let doc = self.doc;
        let user = node.map_or_else(|| "mesh".into(), |node| format!("the mesh of node {node}"));
        let targets = target_count(doc.meshes.get(mesh, &user)?);
        let primitives = primitives(doc, mesh)?;
        let value = &doc.value["meshes"][mesh];
        let names = extras::names(value, targets, || target_accessors(doc, mesh, targets))?;
        let dents = dents(self.reading, value, &names)?;
        let shown_by = node.or(self.nodes.first(mesh));
        let weights = self.weights(mesh, shown_by);
        let weighted = weights.iter().copied().enumerate().take(targets).filter(|(_, weight)| *weight != 0.0);
        let shown: Vec<(usize, f32)> = weighted.filter(|(target, _)| dents.contains(target)).collect();
        if let Some((target, weight)) = shown.first() {
            let more = if shown.len() == 1 { String::new() } else { format!(" and {} more", shown.len() - 1) };
            notes.push(format!(
                "{} shows '{}' at weight {weight} by default{more}: what is written keeps that shape; set the weights to 0 and \
                 export again to have it undented",
                doc.mesh_label(mesh),
                cut(&names[*target])
            ));
        }
        let surface = Surface::read(doc, &primitives, notes)?;
        let count = surface.data.positions.len();
        let impacts = extras::impacts(value, &names, count)?;
        let mut read = Vec::with_capacity(dents.len());
        let mut broken = 0;
        for target in &dents {
            let deltas = deltas(doc, &primitives, *target)?;
            let lacks_normals = deltas.lacks_normals || deltas.broken_normals || deltas.normals.is_empty();
            broken += usize::from(deltas.broken_normals);
            read.push(Target {
                name: names[*target].clone(),
                moved: deltas.positions,
                turned: (!lacks_normals).then_some(deltas.normals),
                impact: impacts[*target],
            });
        }
        if broken > 0 {
            let label = doc.mesh_label(mesh);
            notes.push(format!(
                "{broken} targets of {label} have normals that are no numbers; they are computed instead"
            ));
        }
        let nodes = match node {
            Some(node) => vec![node],
            None => {
                let mut all = self.nodes_of(mesh);
                all.retain(|node| self.weights(mesh, Some(*node)) == weights);
                all
            }
        };
        let to_body = match node {
            Some(node) => self.nodes.shown(node, notes)?,
            None => DMat4::IDENTITY,
        };
        let to_body = DMat4::from_scale(DVec3::splat(f64::from(self.reading.unit))) * to_body;
        if !DMat3::from_mat4(to_body).inverse().is_finite() {
            let node = node.unwrap_or_default();
            return Err(malformed(format!("the world matrix of node {node} has no inverse; a scale of it is 0")));
        }
        let kind = |material: Option<usize>| self.marks.of_primitive(shown_by, mesh, material);
        let kinds: Vec<PartKind> = primitives.iter().map(|primitive| kind(primitive.material())).collect();
        Ok(Piece {
            mesh,
            nodes,
            name: node.map_or_else(String::new, |node| self.nodes.name(node)),
            shown,
            // A node all of whose materials are glass is glass.
            kind: kinds.iter().copied().reduce(|a, b| if a == b { a } else { kind(None) }).unwrap_or_default(),
            kinds,
            surface,
            primitives,
            dents,
            names,
            to_body,
            first_vertex: 0,
            targets: read,
        })
    }

    fn with_targets(&self) -> String {
        let has = |mesh: &usize| self.doc.meshes.get(*mesh, "mesh").is_ok_and(|mesh| target_count(mesh) > 0);
        let some: Vec<usize> = (0..self.doc.meshes.len()).filter(has).collect();
        if some.is_empty() && self.doc.uses_draco() {
            return "the file is compressed with Draco, which holds no morph targets; export without it, or compress with \
                    meshoptimizer (gltfpack -c)"
                .into();
        }
        if some.is_empty() {
            return format!(
                "no mesh of the file has morph targets (it has {}); export them (shape keys), or make some with `crumple examples`",
                self.some_meshes()
            );
        }
        format!("the file's meshes with morph targets are {}", meshes(self.doc, some))
    }
}

/// Some of many meshes for a message.
pub(super) fn meshes(doc: &Document<'_>, list: Vec<usize>) -> String {
    some("no meshes", list.iter().map(|mesh| doc.mesh_label(*mesh)))
}

/// The indices of the targets that are dents.
fn dents(reading: &Reading, mesh: &serde_json::Value, names: &[String]) -> Result<Vec<usize>, Error> {
    let own = extras::dents(mesh)?.map(Patterns::new);
    let patterns = if reading.targets.is_empty() { own.unwrap_or_default() } else { reading.targets.clone() };
    Ok((0..names.len()).filter(|target| patterns.takes(&names[*target])).collect())
}

/// The names of the targets' accessors, where some exporters write the names of targets.
fn target_accessors(doc: &Document<'_>, mesh: usize, targets: usize) -> Option<Vec<String>> {
    let primitives = &doc.meshes.get(mesh, "mesh").ok()?.primitives;
    let name = |target: usize| {
        let accessor = primitives.iter().find_map(|p| p.targets.as_ref()?.get(target)?.positions)?;
        doc.accessors.get(accessor.value(), "accessor").ok()?.name.clone().filter(|name| !name.is_empty())
    };
    let names = (0..targets).map(name).collect::<Option<Vec<String>>>()?;
    let distinct: std::collections::HashSet<&String> = names.iter().collect();
    (distinct.len() == names.len()).then_some(names)
}
