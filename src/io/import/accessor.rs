//! Accessors: their fields are checked against the buffers, then their elements are read, as floats or quantised.

use super::document::{Budget, Document, out_of_range, range};
use super::{finite, malformed, unsupported};
use crate::base::error::Error;
use crate::base::error::reserve;
use ::gltf::json::accessor::{Accessor as Json, ComponentType, IndexComponentType, Type};
use ::gltf::json::validation::Checked;
use ::gltf::json::{self, Index};

/// A checked range of a buffer, `(count - 1) * stride + size` bytes.
#[derive(Clone, Copy)]
struct Strided<'d> {
    bytes: &'d [u8],
    stride: usize,
    size: usize,
}

impl<'d> Strided<'d> {
    fn element(&self, i: usize) -> &'d [u8] {
        &self.bytes[i * self.stride..][..self.size]
    }
}

/// A checked accessor. `name` is for errors.
pub(crate) struct Accessor<'d> {
    budget: &'d Budget,
    name: String,
    pub index: usize,
    pub count: usize,
    pub component: ComponentType,
    normalized: bool,
    base: Option<Strided<'d>>,
    sparse: Option<(Vec<u32>, Strided<'d>)>,
}

impl<'d> Accessor<'d> {
    /// Checks accessor `index` of numbers, which must be of type `kind` and have at least one element.
    pub fn new(doc: &'d Document<'_>, index: Index<json::Accessor>, name: &str, kind: Type) -> Result<Self, Error> {
        Self::of(doc, index, name, (kind, false))
    }

    /// Checks an accessor of vertex indices.
    pub fn of_indices(doc: &'d Document<'_>, index: Index<json::Accessor>, name: &str) -> Result<Self, Error> {
        Self::of(doc, index, name, (Type::Scalar, true))
    }

    fn of(
        doc: &'d Document<'_>,
        index: Index<json::Accessor>,
        name: &str,
        (kind, indices): (Type, bool),
    ) -> Result<Self, Error> {
        let index = index.value();
        let json = doc.accessors.get(index, &format!("{name}: accessor"))?;
        let name = format!("{name} (accessor {index})");
        let component = component(json, &name, (kind, indices))?;
        // Vertex indices have 32 bits.
        let count =
            usize::try_from(json.count.0).ok().filter(|n| (1..u32::MAX as usize).contains(n)).ok_or_else(|| {
                malformed(format!("{name} has a count of {}; it must be from 1 to {}", json.count.0, u32::MAX - 1))
            })?;
        let size = component.size() * kind.multiplicity();
        let offset = json.byte_offset.map_or(0, |o| o.0);
        let base = json.buffer_view.map(|view| strided(doc, view, offset, count, size, &name)).transpose()?;
        if base.is_none() && json.sparse.is_none() {
            not_elsewhere(doc, index, &name)?;
        }
        let sparse = match &json.sparse {
            Some(s) => sparse(doc, s, count, size, &name)?,
            None => None,
        };
        Ok(Self { budget: &doc.budget, name, index, count, component, normalized: json.normalized, base, sparse })
    }

    /// Whether the file stores elements. Without any, all are zero.
    pub fn is_stored(&self) -> bool {
        self.base.is_some() || self.sparse.is_some()
    }

    /// The bytes of an element, if they stand in the file as they are.
    pub fn stored(&self, i: usize) -> Option<&'d [u8]> {
        let listed = self.sparse.as_ref().and_then(|(indices, values)| {
            let at = indices.binary_search(&u32::try_from(i).ok()?).ok()?;
            Some(values.element(at))
        });
        listed.or_else(|| self.base.map(|base| base.element(i)))
    }

    /// Reads all elements as numbers. They need not be finite.
    pub fn values<const N: usize>(&self) -> Result<Vec<[f32; N]>, Error> {
        self.elements([0.0; N], |bytes| self.decoded(bytes))
    }

    /// All elements; those that are not stored are `zero`.
    fn elements<T: Copy>(&self, zero: T, decoded: impl Fn(&[u8]) -> T) -> Result<Vec<T>, Error> {
        self.budget.charge(self.count, size_of::<T>(), &self.name)?;
        let mut out = reserve(self.count, &self.name)?;
        match self.base {
            Some(base) => out.extend((0..self.count).map(|i| decoded(base.element(i)))),
            None => out.resize(self.count, zero),
        }
        if let Some((indices, values)) = &self.sparse {
            indices.iter().enumerate().for_each(|(k, i)| out[*i as usize] = decoded(values.element(k)));
        }
        Ok(out)
    }

    /// The components of one element as floats, by the equations of the glTF 2.0 specification, 3.11.
    fn decoded<const N: usize>(&self, bytes: &[u8]) -> [f32; N] {
        let scaled = |value: f32, most: f32| if self.normalized { (value / most).max(-1.0) } else { value };
        std::array::from_fn(|i| match self.component {
            ComponentType::I8 => scaled(f32::from(bytes[i] as i8), 127.0),
            ComponentType::U8 => scaled(f32::from(bytes[i]), 255.0),
            ComponentType::I16 => scaled(f32::from(i16::from_le_bytes([bytes[2 * i], bytes[2 * i + 1]])), 32767.0),
            ComponentType::U16 => scaled(f32::from(u16::from_le_bytes([bytes[2 * i], bytes[2 * i + 1]])), 65535.0),
            _ => f32::from_le_bytes([bytes[4 * i], bytes[4 * i + 1], bytes[4 * i + 2], bytes[4 * i + 3]]),
        })
    }

    /// The bytes of a unit vector in this accessor's components, so that it can stand beside those of the file.
    pub fn encoded<const N: usize>(&self, value: [f32; N]) -> Vec<u8> {
        let rounded = |x: f32, most: f32| if self.normalized { (x * most).round() } else { x.round() };
        let component = |x: f32| match self.component {
            ComponentType::I8 => (rounded(x, 127.0) as i8).to_le_bytes().to_vec(),
            ComponentType::U8 => (rounded(x, 255.0) as u8).to_le_bytes().to_vec(),
            ComponentType::I16 => (rounded(x, 32767.0) as i16).to_le_bytes().to_vec(),
            ComponentType::U16 => (rounded(x, 65535.0) as u16).to_le_bytes().to_vec(),
            _ => x.to_le_bytes().to_vec(),
        };
        value.into_iter().flat_map(component).collect()
    }

    /// Reads all elements. Refuses NaN and infinities.
    pub fn floats<const N: usize>(&self) -> Result<Vec<[f32; N]>, Error> {
        let values = self.values::<N>()?;
        for (i, v) in values.iter().enumerate() {
            finite(*v, || self.element_name(i))?;
        }
        Ok(values)
    }

    /// Reads the elements that are not zero, with their indices in increasing order. Elements that a sparse accessor
    /// omits cost nothing. They need not be finite.
    pub fn nonzero(&self) -> Result<Vec<(u32, [f32; 3])>, Error> {
        let pairs: Vec<(u32, [f32; 3])> = match (&self.sparse, self.base) {
            (Some((indices, values)), None) => {
                self.budget.charge(indices.len(), 16, &self.name)?;
                indices.iter().enumerate().map(|(k, i)| (*i, self.decoded(values.element(k)))).collect()
            }
            _ => (0..).zip(self.values::<3>()?).collect(),
        };
        Ok(pairs.into_iter().filter(|(_, v)| *v != [0.0; 3]).collect())
    }

    /// Reads all elements as vertex indices, which must be below `limit`.
    pub fn indices(&self, limit: usize) -> Result<Vec<u32>, Error> {
        let indices = self.elements(0, unsigned)?;
        match indices.iter().position(|i| *i as usize >= limit) {
            None => Ok(indices),
            Some(at) => Err(out_of_range(&self.element_name(at), indices[at] as usize, limit)),
        }
    }

    /// The name for errors, with that of an element.
    pub fn element_name(&self, i: usize) -> String {
        format!("{}[{i}]", self.name)
    }
}

/// The little-endian number of some bytes.
fn unsigned(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |number, byte| number << 8 | u32::from(*byte))
}

fn component(json: &Json, name: &str, (kind, indices): (Type, bool)) -> Result<ComponentType, Error> {
    let (Checked::Valid(component), Checked::Valid(actual)) = (json.component_type, json.type_) else {
        return Err(malformed(format!("{name} has an unknown componentType or type")));
    };
    if actual != kind {
        return Err(malformed(format!("{name} is of type {}; it must be {}", type_name(actual), type_name(kind))));
    }
    match (indices, component.0) {
        (true, c @ (ComponentType::U8 | ComponentType::U16 | ComponentType::U32)) => Ok(c),
        (true, c) => {
            Err(malformed(format!("{name} has components of {}; indices must be unsigned integers", component_name(c))))
        }
        (_, ComponentType::U32) => Err(malformed(format!(
            "{name} has components of {}; they must be floats, or bytes or shorts of KHR_mesh_quantization",
            component_name(ComponentType::U32)
        ))),
        (_, c) => Ok(c),
    }
}

fn strided<'d>(
    doc: &'d Document<'_>,
    view: Index<json::buffer::View>,
    offset: u64,
    count: usize,
    size: usize,
    name: &str,
) -> Result<Strided<'d>, Error> {
    let (bytes, stride) = doc.view(view, name)?;
    let stride = stride.unwrap_or(size);
    if stride < size {
        return Err(malformed(format!(
            "{name}: bufferView {} has a byteStride of {stride}; an element has {size} bytes",
            view.value()
        )));
    }
    let needed = (count as u64 - 1).checked_mul(stride as u64).and_then(|n| n.checked_add(size as u64));
    let range = range(offset, needed, bytes.len()).ok_or_else(|| {
        malformed(format!(
            "{name}: {count} elements of {size} bytes, {stride} apart, from byte {offset} do not fit into bufferView {} of {} bytes",
            view.value(),
            bytes.len()
        ))
    })?;
    Ok(Strided { bytes: &bytes[range], stride, size })
}

fn sparse<'d>(
    doc: &'d Document<'_>,
    json: &json::accessor::sparse::Sparse,
    count: usize,
    size: usize,
    name: &str,
) -> Result<Option<(Vec<u32>, Strided<'d>)>, Error> {
    let listed = usize::try_from(json.count.0).ok().filter(|n| *n <= count).ok_or_else(|| {
        malformed(format!("{name} has a sparse count of {}; it must be at most its count of {count}", json.count.0))
    })?;
    if listed == 0 {
        return Ok(None);
    }
    let Checked::Valid(IndexComponentType(component)) = json.indices.component_type else {
        return Err(malformed(format!(
            "{name}: the sparse indices have an unknown componentType; it must be 5121, 5123 or 5125"
        )));
    };
    let indices_name = format!("{name} sparse indices");
    let raw =
        strided(doc, json.indices.buffer_view, json.indices.byte_offset.0, listed, component.size(), &indices_name)?;
    let values_name = format!("{name} sparse values");
    let values = strided(doc, json.values.buffer_view, json.values.byte_offset.0, listed, size, &values_name)?;
    doc.budget.charge(listed, 4, &indices_name)?;
    let indices: Vec<u32> = (0..listed).map(|i| unsigned(raw.element(i))).collect();
    if let Some(i) = (1..indices.len()).find(|i| indices[*i] <= indices[i - 1]) {
        let (this, last) = (indices[i], indices[i - 1]);
        return Err(malformed(format!("{indices_name}[{i}] is {this} after {last}; they must increase")));
    }
    match indices.iter().position(|i| *i as usize >= count) {
        None => Ok(Some((indices, values))),
        Some(at) => Err(out_of_range(&format!("{indices_name}[{at}]"), indices[at] as usize, count)),
    }
}

/// Refuses an accessor whose data is in an extension. Without data it is all zeros; Blender writes shape keys that move
/// nothing this way.
fn not_elsewhere(doc: &Document<'_>, index: usize, name: &str) -> Result<(), Error> {
    let own = doc.value["accessors"][index]["extensions"].as_object().and_then(|o| o.keys().next());
    match own {
        Some(e) => Err(unsupported(format!("{name} has its data in {e}, which is not read; export without it"))),
        None => Ok(()),
    }
}

fn type_name(kind: Type) -> String {
    format!("{kind:?}").to_uppercase()
}

fn component_name(component: ComponentType) -> String {
    let name = match component {
        ComponentType::I8 => "BYTE",
        ComponentType::U8 => "UNSIGNED_BYTE",
        ComponentType::I16 => "SHORT",
        ComponentType::U16 => "UNSIGNED_SHORT",
        ComponentType::U32 => "UNSIGNED_INT",
        ComponentType::F32 => "FLOAT",
    };
    format!("{name} ({})", component.as_gl_enum())
}
