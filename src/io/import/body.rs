//! Joins the meshes of all nodes of a glTF to one body, with a part for each node.

use super::document::{Document, out_of_range};
use super::gltf::{base, deltas, parts, range, target_count};
use super::nodes::Nodes;
use super::{Imported, Part, PrimitiveRange, extras, malformed, unsupported, uri};
use crate::base::error::Error;
use crate::base::math::{Aabb, to_f32};
use crate::example::data::{Contact, Deltas, ExampleData, Placement};
use crate::example::set::MAX_MESHES;
use crate::mesh::data::MeshData;
use glam::{DMat3, DMat4, DVec3, Vec3};
use rstar::RTree;
use std::cmp::Ordering;
use std::collections::{HashMap, HashSet};
use std::path::Path;

/// Vertices of different nodes nearer than this share of the body's diagonal lie at one position: node matrices round.
const SAME: f32 = 1e-6;

/// Reads all meshes that nodes show as one body. Each node with a mesh becomes a part, in the order of the file's nodes.
/// Positions are in the scene's space: each part is where its node places it. Vertices of different nodes that lie within a
/// millionth of the body's diagonal get one position, so that seams between parts stay closed.
///
/// Morph targets of the same name are one example; a mesh without a target of that name does not move in it. `impacts` and
/// `placements` are read from each mesh's extras, in its own space. If several meshes have one for the same example, the
/// first counts. Normals of the targets are not read: normals follow the displaced triangles. Everything else is as for
/// [`gltf_file`](super::gltf_file).
///
/// ```no_run
/// use crumple::{ExampleSet, Serial, SetOptions, import};
/// let body = import::gltf_body_file("car.glb".as_ref())?;
/// let parts = body.part_meshes();
/// let mut set = ExampleSet::build(body.mesh, body.examples, SetOptions::default(), &Serial)?;
/// for (part, mesh) in body.parts.iter().zip(parts) {
///     println!("part {} is {}", set.add_lod(mesh, &Serial)?, part.name);
/// }
/// # Ok::<(), crumple::Error>(())
/// ```
///
/// # Errors
/// Those of [`gltf_file`](super::gltf_file); [`Error::NoSuchMesh`] if no node has a mesh; [`Error::NoExamples`] if no mesh has
/// morph targets; [`Error::Unsupported`] for more than 63 nodes with meshes; [`Error::Format`] if a mesh has two targets of
/// one name, or a node's matrix no inverse.
pub fn gltf_body_file(path: &Path) -> Result<Imported, Error> {
    let imported = gltf_body(&uri::read(path, None)?, path.parent())?;
    Ok(Imported { name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(), ..imported })
}

/// Reads the same from memory. Relative paths of external buffers start at `base_dir`; without it they are an error. The name
/// is empty.
///
/// # Errors
/// As [`gltf_body_file`].
pub fn gltf_body(bytes: &[u8], base_dir: Option<&Path>) -> Result<Imported, Error> {
    let doc = Document::parse(bytes, base_dir)?;
    let shown: Vec<_> =
        doc.root.nodes.iter().enumerate().filter_map(|(n, node)| Some((n, node.mesh?.value()))).collect();
    if shown.is_empty() {
        return Err(Error::NoSuchMesh {
            wanted: "a node with a mesh".into(),
            available: "nodes without meshes".into(),
        });
    }
    if shown.len() >= MAX_MESHES {
        let what = format!("{} nodes have meshes; a body has at most {} parts", shown.len(), MAX_MESHES - 1);
        return Err(unsupported(what));
    }
    let nodes = Nodes::of(&doc);
    let pieces =
        shown.iter().map(|(node, mesh)| Piece::read(&doc, &nodes, *node, *mesh)).collect::<Result<Vec<_>, Error>>()?;
    let vertices: usize = pieces.iter().map(|piece| piece.mesh.positions.len()).sum();
    if vertices > u32::MAX as usize {
        return Err(unsupported(format!("{vertices} vertices in all parts; 32-bit indices reach {}", u32::MAX)));
    }
    let mut joined = Imported {
        name: String::new(),
        mesh: MeshData {
            normals: all(&pieces, |mesh| mesh.normals.as_ref()),
            tangents: all(&pieces, |mesh| mesh.tangents.as_ref()),
            depth_limits: all(&pieces, |mesh| mesh.depth_limits.as_ref()),
            stiffness: all(&pieces, |mesh| mesh.stiffness.as_ref()),
            ..MeshData::default()
        },
        texcoords: None,
        examples: Vec::new(),
        primitives: Vec::new(),
        parts: Vec::new(),
        node_transform: None,
    };
    let mut known = HashMap::new();
    for piece in pieces {
        add(&mut joined, piece, &mut known);
    }
    if joined.examples.is_empty() {
        return Err(Error::NoExamples { what: "no mesh that a node shows has morph targets".into() });
    }
    close_seams(&mut joined);
    Ok(joined)
}

/// The mesh of one node in the scene's space.
struct Piece {
    name: String,
    mesh: MeshData,
    examples: Vec<ExampleData>,
    primitives: Vec<PrimitiveRange>,
}

impl Piece {
    fn read(doc: &Document<'_>, nodes: &Nodes<'_>, node: usize, mesh: usize) -> Result<Self, Error> {
        let targets = if doc.root.meshes.get(mesh).is_some() {
            target_count(doc, mesh)?
        } else {
            return Err(out_of_range(&format!("the mesh of node {node}"), mesh, doc.root.meshes.len()));
        };
        let to_scene = DMat4::from_cols_array_2d(&nodes.world(node)?);
        let linear = DMat3::from_mat4(to_scene);
        if !linear.inverse().is_finite() {
            return Err(malformed(format!("the world matrix of node {node} has no inverse")));
        }
        let primitives = parts(doc, mesh)?;
        let mut base = base(doc, &primitives)?;
        let value = &doc.value["meshes"][mesh];
        let names = extras::names(value, targets)?;
        let mut seen = HashSet::new();
        if let Some(name) = names.iter().find(|name| !seen.insert(*name)) {
            let mesh = doc.mesh_label(mesh);
            return Err(malformed(format!("{mesh} has two targets named '{name}'; in a body their names must differ")));
        }
        let impacts = extras::impacts(value, &names, base.positions.len())?;
        let placements = extras::placements(value, &names)?;
        let mut examples = Vec::with_capacity(targets);
        for (i, ((name, impact), placement)) in names.into_iter().zip(impacts).zip(placements).enumerate() {
            let (mut positions, _) = deltas(doc, &primitives, i)?;
            if let Deltas::Sparse { values, .. } = &mut positions {
                values.iter_mut().for_each(|v| *v = mapped(linear, *v));
            }
            let contact = impact.contact.map(|contact| match contact {
                Contact::Point(p) => Contact::Point(to_f32(to_scene.transform_point3(DVec3::from(p.map(f64::from))))),
                vertex => vertex,
            });
            let blow = impact.blow.transformed(linear);
            let contact_normal = impact.normal.map(|n| unit_mapped(linear.inverse().transpose(), n));
            examples.push(ExampleData {
                contact,
                contact_normal,
                blow,
                placement,
                ..ExampleData::new(name, positions)
            });
        }
        place(&mut base, to_scene);
        let named = [&doc.root.nodes[node].name, &doc.root.meshes[mesh].name];
        let name = named.into_iter().flatten().find(|name| !name.is_empty());
        Ok(Piece {
            name: name.cloned().unwrap_or_else(|| format!("node {node}")),
            mesh: base,
            examples,
            primitives: primitives.iter().map(|p| range(doc, p)).collect::<Result<_, _>>()?,
        })
    }
}

fn mapped(linear: DMat3, v: [f32; 3]) -> [f32; 3] {
    to_f32(linear * DVec3::from(v.map(f64::from)))
}

fn unit_mapped(linear: DMat3, v: [f32; 3]) -> [f32; 3] {
    to_f32((linear * DVec3::from(v.map(f64::from))).normalize_or_zero())
}

/// Takes a mesh to the scene's space.
fn place(mesh: &mut MeshData, to_scene: DMat4) {
    let linear = DMat3::from_mat4(to_scene);
    if to_scene == DMat4::IDENTITY {
        return;
    }
    let normals = linear.inverse().transpose();
    for p in &mut mesh.positions {
        *p = to_f32(to_scene.transform_point3(DVec3::from(p.map(f64::from))));
    }
    mesh.normals.iter_mut().flatten().for_each(|n| *n = unit_mapped(normals, *n));
    let mirrored = linear.determinant() < 0.0;
    for tangent in mesh.tangents.iter_mut().flatten() {
        let [x, y, z, w] = *tangent;
        let [x, y, z] = unit_mapped(linear, [x, y, z]);
        *tangent = [x, y, z, if mirrored { -w } else { w }];
    }
    if mirrored {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    let scale = linear.determinant().abs().cbrt() as f32;
    mesh.depth_limits.iter_mut().flatten().for_each(|limit| *limit *= scale);
}

/// An attribute of all pieces; `None` if one lacks it.
fn all<T: Copy>(pieces: &[Piece], of: impl Fn(&MeshData) -> Option<&Vec<T>>) -> Option<Vec<T>> {
    let lists = pieces.iter().map(|piece| of(&piece.mesh)).collect::<Option<Vec<_>>>()?;
    Some(lists.into_iter().flatten().copied().collect())
}

/// Appends a piece, whose attributes other than positions are there already. `known` has the places of the examples by name.
fn add(joined: &mut Imported, piece: Piece, known: &mut HashMap<String, usize>) {
    let Piece { name, mesh, examples, primitives } = piece;
    let (first_vertex, first_triangle) = (joined.mesh.positions.len() as u32, joined.mesh.triangles.len() as u32);
    let (vertex_count, triangle_count) = (mesh.positions.len() as u32, mesh.triangles.len() as u32);
    joined.parts.push(Part { name, first_vertex, vertex_count, first_triangle, triangle_count });
    joined.mesh.positions.extend(mesh.positions);
    joined.mesh.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + first_vertex)));
    joined.primitives.extend(primitives.into_iter().map(|p| PrimitiveRange {
        first_vertex: p.first_vertex + first_vertex,
        first_triangle: p.first_triangle + first_triangle,
        ..p
    }));
    for mut example in examples {
        if let Some(Contact::Vertex(v)) = &mut example.contact {
            *v += first_vertex;
        }
        if let Deltas::Sparse { indices, .. } = &mut example.positions {
            indices.iter_mut().for_each(|v| *v += first_vertex);
        }
        let Some(known) = known.get(&example.name).map(|i| &mut joined.examples[*i]) else {
            known.insert(example.name.clone(), joined.examples.len());
            joined.examples.push(example);
            continue;
        };
        if let (Deltas::Sparse { indices, values }, Deltas::Sparse { indices: more, values: moved }) =
            (&mut known.positions, example.positions)
        {
            indices.extend(more);
            values.extend(moved);
        }
        if known.contact.is_none() {
            (known.contact, known.contact_normal) = (example.contact, example.contact_normal);
            known.blow = example.blow;
        }
        if known.placement == Placement::Automatic {
            known.placement = example.placement;
        }
    }
}

/// How many vertices that lie at one place up to rounding are compared, so that thousands take no longer than in proportion.
const COMPARED: usize = 256;

/// Gives vertices of different parts that lie at the same place the bits of the first part's.
fn close_seams(joined: &mut Imported) {
    let positions = &mut joined.mesh.positions;
    let diagonal = Aabb::of_slice(bytemuck::cast_slice(positions)).diagonal();
    let mut earlier: RTree<[f32; 3]> = RTree::new();
    let mut inserted = HashSet::new();
    for part in &joined.parts {
        let own = &mut positions[part.vertices()];
        for p in own.iter_mut() {
            let near = earlier.locate_within_distance(*p, (SAME * diagonal).powi(2)).take(COMPARED);
            // The nearest; among equally near the least, so that the tree's shape does not matter.
            let distance = |q: &[f32; 3]| (Vec3::from(*q) - Vec3::from(*p)).length_squared();
            let least = |a: &&[f32; 3], b: &&[f32; 3]| {
                distance(a).total_cmp(&distance(b)).then(a.partial_cmp(b).unwrap_or(Ordering::Equal))
            };
            if let Some(nearest) = near.min_by(least) {
                *p = *nearest;
            }
        }
        own.iter().filter(|p| inserted.insert(p.map(f32::to_bits))).for_each(|p| earlier.insert(*p));
    }
}
