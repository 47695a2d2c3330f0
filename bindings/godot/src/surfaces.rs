//! The surfaces of Godot's meshes: read as one Crumple mesh with its examples, and made again without blend shapes.

use crate::divide::divide;
use crumple::{Deltas, ExampleData, ExampleSet, MeshData, import};
use godot::classes::mesh::{ArrayFormat, ArrayType, BlendShapeMode, PrimitiveType};
use godot::classes::{ArrayMesh, Json, Material, RenderingServer};
use godot::obj::EngineEnum;
use godot::prelude::*;

/// The metadata in which Godot's glTF importer keeps a mesh's extras.
const EXTRAS: &str = "extras";
/// What stands in for the tangents of a surface without tangents, if another surface has some. It is not shown.
const NO_TANGENT: [f32; 4] = [1.0, 0.0, 0.0, 1.0];

/// One surface of the shown mesh.
pub struct Surface {
    primitive: PrimitiveType,
    arrays: VarArray,
    /// The blend shapes, until they are examples.
    shapes: Vec<VarArray>,
    flags: u64,
    lods: VarDictionary,
    material: Option<Gd<Material>>,
    name: GString,
    /// Its first vertex among those of all surfaces that dent.
    pub first: usize,
    /// The number of its vertices; 0 if it does not dent.
    pub count: usize,
    pub has_normals: bool,
    pub has_tangents: bool,
}

impl Surface {
    /// Fits a surface to a baked set. Normals that the set lacks stay undamaged. Tangents that it lacks are dropped; compressed meshes
    /// always have some.
    pub fn fit(&mut self, set: &ExampleSet) {
        self.has_normals &= set.mesh().normals().is_some();
        if self.has_tangents && set.mesh().tangents().is_none() {
            self.arrays.set(ArrayType::TANGENT.ord() as usize, &Variant::nil());
            self.has_tangents = false;
        }
    }
}

/// What a mesh with blend shapes holds.
pub struct Source {
    pub surfaces: Vec<Surface>,
    pub mesh: MeshData,
    pub examples: Vec<ExampleData>,
}

/// Reads a mesh. Its blend shapes become the examples, and its extras say how they were made. Surfaces of points and
/// lines are shown and do not dent. Edges longer than `edge`, m, are divided; 0 divides none.
pub fn read(mesh: &Gd<ArrayMesh>, edge: f32) -> Result<Source, String> {
    let (mut surfaces, parts) = joined(mesh, edge)?;
    let vertices = parts.positions.len();
    let mut examples = examples(mesh, &surfaces)?;
    if let Some(extras) = extras(mesh)? {
        import::apply_extras(&extras, vertices, &mut examples).map_err(|e| e.to_string())?;
    }
    surfaces.iter_mut().for_each(|surface| surface.shapes.clear());
    let any = |has: fn(&Surface) -> bool| surfaces.iter().any(|s| s.count > 0 && has(s));
    let mesh = MeshData {
        positions: parts.positions,
        normals: any(|s| s.has_normals).then_some(parts.normals),
        tangents: any(|s| s.has_tangents).then_some(parts.tangents),
        triangles: parts.triangles,
        ..MeshData::default()
    };
    Ok(Source { surfaces, mesh, examples })
}

/// The mesh with its blend shapes and divided edges.
pub fn divided(mesh: &Gd<ArrayMesh>, edge: f32) -> Result<Gd<ArrayMesh>, String> {
    let (surfaces, _) = joined(mesh, edge)?;
    let mut made = ArrayMesh::new_gd();
    for i in 0..mesh.get_blend_shape_count() {
        made.add_blend_shape(&mesh.get_blend_shape_name(i));
    }
    made.set_blend_shape_mode(mesh.get_blend_shape_mode());
    for surface in &surfaces {
        let shapes: Array<AnyArray> = surface.shapes.iter().map(|shape| shape.clone().upcast_any_array()).collect();
        add(&mut made, surface, &shapes, 0);
    }
    if mesh.has_meta(EXTRAS) {
        made.set_meta(EXTRAS, &mesh.get_meta(EXTRAS));
    }
    Ok(made)
}

/// The surfaces of a mesh and the positions of the vertices that dent.
pub fn shown(mesh: &Gd<ArrayMesh>, edge: f32) -> Result<(Vec<Surface>, Vec<[f32; 3]>), String> {
    let (surfaces, parts) = joined(mesh, edge)?;
    Ok((surfaces, parts.positions))
}

fn joined(mesh: &Gd<ArrayMesh>, edge: f32) -> Result<(Vec<Surface>, Parts), String> {
    let (mut surfaces, mut parts) = (Vec::<Surface>::new(), Parts::default());
    for i in 0..mesh.get_surface_count() {
        let surface = surface(mesh, i, parts.positions.len(), edge)?;
        if surface.count > 0 {
            parts.add(&surface, i)?;
        }
        surfaces.push(surface);
    }
    match surfaces.iter().any(|s| s.count > 0) {
        true => Ok((surfaces, parts)),
        false => Err("the mesh has no surface of triangles; only triangles dent".into()),
    }
}

/// The surface of a baked set, which has no materials and no texture coordinates.
pub fn of_set(set: &ExampleSet) -> Vec<Surface> {
    let mesh = set.mesh();
    let vectors = |values: &[crumple::glam::Vec3]| -> PackedVector3Array {
        values.iter().map(|v| Vector3::new(v.x, v.y, v.z)).collect()
    };
    let mut arrays = VarArray::new();
    arrays.resize(ArrayType::MAX.ord() as usize, &Variant::nil());
    arrays.set(ArrayType::VERTEX.ord() as usize, &vectors(mesh.positions()).to_variant());
    if let Some(normals) = mesh.normals() {
        arrays.set(ArrayType::NORMAL.ord() as usize, &vectors(normals).to_variant());
    }
    if let Some(tangents) = mesh.tangents() {
        let flat: PackedFloat32Array = tangents.iter().flat_map(|t| t.to_array()).collect();
        arrays.set(ArrayType::TANGENT.ord() as usize, &flat.to_variant());
    }
    if !mesh.triangles().is_empty() {
        // Godot's front faces are clockwise.
        let indices: PackedInt32Array =
            mesh.triangles().iter().flat_map(|t| [t[0] as i32, t[2] as i32, t[1] as i32]).collect();
        arrays.set(ArrayType::INDEX.ord() as usize, &indices.to_variant());
    }
    vec![Surface {
        primitive: if mesh.triangles().is_empty() { PrimitiveType::POINTS } else { PrimitiveType::TRIANGLES },
        arrays,
        shapes: Vec::new(),
        flags: 0,
        lods: VarDictionary::new(),
        material: None,
        name: GString::new(),
        first: 0,
        count: mesh.positions().len(),
        has_normals: mesh.normals().is_some(),
        has_tangents: mesh.tangents().is_some(),
    }]
}

/// Makes a mesh of the surfaces. Its positions are floats, and its vertices may be updated.
pub fn make(surfaces: &[Surface]) -> Gd<ArrayMesh> {
    let mut mesh = ArrayMesh::new_gd();
    for surface in surfaces {
        add(&mut mesh, surface, &Array::new(), ArrayFormat::FLAG_USE_DYNAMIC_UPDATE.ord());
    }
    mesh
}

fn add(mesh: &mut Gd<ArrayMesh>, surface: &Surface, shapes: &Array<AnyArray>, flags: u64) {
    mesh.add_surface_from_arrays_ex(surface.primitive, &surface.arrays)
        .blend_shapes(shapes)
        .lods(&surface.lods)
        .flags(ArrayFormat::from_ord(flags | surface.flags))
        .done();
    let last = mesh.get_surface_count() - 1;
    mesh.surface_set_material(last, surface.material.as_ref());
    mesh.surface_set_name(last, &surface.name);
}

/// What arrays do not say: the format of the custom channels, and the number of bones a vertex.
fn flags_of(format: ArrayFormat) -> u64 {
    let shifts = [
        ArrayFormat::CUSTOM0_SHIFT,
        ArrayFormat::CUSTOM1_SHIFT,
        ArrayFormat::CUSTOM2_SHIFT,
        ArrayFormat::CUSTOM3_SHIFT,
    ];
    let custom =
        shifts.iter().map(|shift| ArrayFormat::CUSTOM_MASK.ord() << shift.ord()).fold(0, |all, mask| all | mask);
    format.ord() & (custom | ArrayFormat::FLAG_USE_8_BONE_WEIGHTS.ord())
}

fn vectors(arrays: &VarArray, kind: ArrayType) -> Option<PackedVector3Array> {
    arrays.get(kind.ord() as usize)?.try_to().ok()
}

fn floats(arrays: &VarArray, kind: ArrayType) -> Option<PackedFloat32Array> {
    arrays.get(kind.ord() as usize)?.try_to().ok()
}

fn three(v: &Vector3) -> [f32; 3] {
    [v.x, v.y, v.z]
}

fn surface(mesh: &Gd<ArrayMesh>, i: i32, first: usize, edge: f32) -> Result<Surface, String> {
    let mut arrays = mesh.surface_get_arrays(i);
    let vertices = vectors(&arrays, ArrayType::VERTEX);
    let vertices = vertices.filter(|v| !v.is_empty()).ok_or_else(|| format!("surface {i} has no vertices"))?;
    let primitive = mesh.surface_get_primitive_type(i);
    if primitive == PrimitiveType::TRIANGLE_STRIP {
        return Err(format!("surface {i} is a triangle strip; make it of triangles"));
    }
    let mut shapes: Vec<VarArray> = mesh.surface_get_blend_shape_arrays(i).iter_shared().collect();
    let old = vertices.len();
    if edge > 0.0 && primitive == PrimitiveType::TRIANGLES {
        divide(&mut arrays, &mut shapes, edge).map_err(|e| format!("surface {i} cannot be divided: {e}"))?;
    }
    let vertices = vectors(&arrays, ArrayType::VERTEX).unwrap_or_default();
    let has = |kind: ArrayType| arrays.get(kind.ord() as usize).is_some_and(|v| !v.is_nil());
    Ok(Surface {
        primitive,
        flags: flags_of(mesh.surface_get_format(i)),
        lods: lods(mesh, i, old),
        material: mesh.surface_get_material(i),
        name: mesh.surface_get_name(i),
        first,
        count: if primitive == PrimitiveType::TRIANGLES { vertices.len() } else { 0 },
        has_normals: has(ArrayType::NORMAL),
        has_tangents: has(ArrayType::TANGENT),
        arrays,
        shapes,
    })
}

/// The levels of detail that the editor's import made: the size of an edge, and indices into the same vertices.
fn lods(mesh: &Gd<ArrayMesh>, i: i32, vertices: usize) -> VarDictionary {
    let data = RenderingServer::singleton().mesh_get_surface(mesh.get_rid(), i);
    let mut lods = VarDictionary::new();
    let Some(list) = data.get("lods").and_then(|v| v.try_to::<VarArray>().ok()) else { return lods };
    for lod in list.iter_shared() {
        let Ok(lod) = lod.try_to::<VarDictionary>() else { continue };
        let edge = lod.get("edge_length").and_then(|v| v.try_to::<f32>().ok());
        let bytes = lod.get("index_data").and_then(|v| v.try_to::<PackedByteArray>().ok());
        let (Some(edge), Some(bytes)) = (edge, bytes) else { continue };
        let bytes = bytes.as_slice();
        let indices: PackedInt32Array = if vertices <= 1 << 16 {
            bytes.chunks_exact(2).map(|b| i32::from(u16::from_le_bytes([b[0], b[1]]))).collect()
        } else {
            bytes.chunks_exact(4).map(|b| i32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
        };
        lods.set(edge, &indices);
    }
    lods
}

/// The joined arrays of the surfaces that dent.
#[derive(Default)]
struct Parts {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    tangents: Vec<[f32; 4]>,
    triangles: Vec<[u32; 3]>,
}

impl Parts {
    fn add(&mut self, surface: &Surface, i: i32) -> Result<(), String> {
        let (arrays, count) = (&surface.arrays, surface.count);
        let positions = vectors(arrays, ArrayType::VERTEX).unwrap_or_default();
        self.positions.extend(positions.as_slice().iter().map(three));
        match vectors(arrays, ArrayType::NORMAL) {
            Some(normals) => self.normals.extend(normals.as_slice().iter().map(three)),
            // The set computes normals of length zero.
            None => self.normals.resize(self.positions.len(), [0.0; 3]),
        }
        match floats(arrays, ArrayType::TANGENT) {
            Some(t) => self.tangents.extend(t.as_slice().chunks_exact(4).map(|t| [t[0], t[1], t[2], t[3]])),
            None => self.tangents.resize(self.positions.len(), NO_TANGENT),
        }
        let index: Vec<u32> = match arrays.at(ArrayType::INDEX.ord() as usize).try_to::<PackedInt32Array>() {
            Ok(indices) => indices.as_slice().iter().map(|v| *v as u32).collect(),
            Err(_) => (0..count as u32).collect(),
        };
        if !index.len().is_multiple_of(3) {
            return Err(format!("surface {i} has {} indices; triangles need a multiple of 3", index.len()));
        }
        let first = surface.first as u32;
        // Godot's front faces are clockwise.
        self.triangles.extend(index.chunks_exact(3).map(|t| [first + t[0], first + t[2], first + t[1]]));
        Ok(())
    }
}

fn examples(mesh: &Gd<ArrayMesh>, surfaces: &[Surface]) -> Result<Vec<ExampleData>, String> {
    let count = mesh.get_blend_shape_count();
    if count == 0 {
        return Err("the mesh has no blend shapes; each example is one (glTF calls them morph targets)".into());
    }
    // Normalized shapes are the whole deformed mesh, relative ones are displacements.
    let absolute = mesh.get_blend_shape_mode() == BlendShapeMode::NORMALIZED;
    let mut positions: Vec<Vec<(u32, [f32; 3])>> = vec![Vec::new(); count as usize];
    let mut normals: Vec<Vec<(u32, [f32; 3])>> = vec![Vec::new(); count as usize];
    let every_normal = surfaces.iter().all(|s| s.count == 0 || s.has_normals);
    for (i, surface) in surfaces.iter().enumerate().filter(|(_, s)| s.count > 0) {
        let shapes = &surface.shapes;
        if shapes.len() != count as usize {
            return Err(format!("surface {i} has {} blend shapes; the mesh has {count}", shapes.len()));
        }
        for (e, shape) in shapes.iter().enumerate() {
            for (kind, out) in [(ArrayType::VERTEX, &mut positions[e]), (ArrayType::NORMAL, &mut normals[e])] {
                let (Some(shape), Some(base)) = (vectors(shape, kind), vectors(&surface.arrays, kind)) else {
                    continue;
                };
                if shape.len() != surface.count {
                    let (found, wanted) = (shape.len(), surface.count);
                    return Err(format!("blend shape {e} of surface {i} has {found} values for {wanted} vertices"));
                }
                let deltas = shape.as_slice().iter().zip(base.as_slice()).enumerate();
                let deltas = deltas.map(|(v, (s, b))| (v, if absolute { *s - *b } else { *s }));
                let moved = deltas.filter(|(_, d)| *d != Vector3::ZERO);
                out.extend(moved.map(|(v, d)| ((surface.first + v) as u32, three(&d))));
            }
        }
    }
    let sparse = |list: Vec<(u32, [f32; 3])>| {
        let (indices, values) = list.into_iter().unzip();
        Deltas::Sparse { indices, values }
    };
    let example = |(i, (p, n)): (usize, (Vec<_>, Vec<_>))| {
        let mut example = ExampleData::new(mesh.get_blend_shape_name(i as i32).to_string(), sparse(p));
        example.normals = every_normal.then(|| sparse(n));
        example
    };
    Ok(positions.into_iter().zip(normals).enumerate().map(example).collect())
}

/// The mesh's extras as JSON.
fn extras(mesh: &Gd<ArrayMesh>) -> Result<Option<String>, String> {
    if !mesh.has_meta(EXTRAS) {
        return Ok(None);
    }
    let extras = mesh.get_meta(EXTRAS);
    if extras.get_type() != VariantType::DICTIONARY {
        return Err(format!("the mesh's metadata \"extras\" is {extras}; it must be a dictionary"));
    }
    Ok(Some(Json::stringify(&extras).to_string()))
}
