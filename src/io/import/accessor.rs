//! Accessors: their fields are checked against the buffers, then the `gltf` crate's iterators read the elements.

use super::document::{Budget, Document, out_of_range, range};
use super::{finite, malformed, unsupported};
use crate::base::error::Error;
use crate::base::error::reserve;
use ::gltf::accessor::util::{Item, ItemIter, SparseIndicesIter, SparseIter};
use ::gltf::json::accessor::{Accessor as Json, ComponentType, IndexComponentType, Type};
use ::gltf::json::validation::Checked;
use ::gltf::json::{self, Index};

/// A checked range of a buffer, `(count - 1) * stride + size` bytes.
#[derive(Clone, Copy)]
struct Strided<'d> {
    bytes: &'d [u8],
    stride: usize,
}

/// A checked accessor. `name` is for errors.
pub(crate) struct Accessor<'d> {
    budget: &'d Budget,
    name: String,
    pub count: usize,
    component: ComponentType,
    base: Option<Strided<'d>>,
    sparse: Option<(Vec<u32>, Strided<'d>)>,
}

impl<'d> Accessor<'d> {
    /// Checks accessor `index`, which must be of type `kind` and have at least one element.
    /// Scalars are indices.
    pub fn new(doc: &'d Document<'_>, index: Index<json::Accessor>, name: &str, kind: Type) -> Result<Self, Error> {
        Self::of(doc, index, name, (kind, kind == Type::Scalar))
    }

    /// Checks an accessor of one 32-bit float an element.
    pub fn of_numbers(doc: &'d Document<'_>, index: Index<json::Accessor>, name: &str) -> Result<Self, Error> {
        Self::of(doc, index, name, (Type::Scalar, false))
    }

    fn of(
        doc: &'d Document<'_>,
        index: Index<json::Accessor>,
        name: &str,
        (kind, indices): (Type, bool),
    ) -> Result<Self, Error> {
        let accessors = &doc.root.accessors;
        let index = index.value();
        let json =
            accessors.get(index).ok_or_else(|| out_of_range(&format!("{name}: accessor"), index, accessors.len()))?;
        let name = format!("{name} (accessor {index})");
        let component = component(json, &name, (kind, indices))?;
        // The crate's sparse iterator counts in 32 bits, and so do vertex indices.
        let count =
            usize::try_from(json.count.0).ok().filter(|n| (1..u32::MAX as usize).contains(n)).ok_or_else(|| {
                malformed(format!("{name} has a count of {}; it must be from 1 to {}", json.count.0, u32::MAX - 1))
            })?;
        let size = component.size() * kind.multiplicity();
        let offset = json.byte_offset.map_or(0, |o| o.0);
        let base = json.buffer_view.map(|view| strided(doc, view, offset, count, size, &name)).transpose()?;
        if base.is_none() && json.sparse.is_none() {
            not_compressed(doc, index, &name)?;
        }
        let sparse = match &json.sparse {
            Some(s) => sparse(doc, s, count, size, &name)?,
            None => None,
        };
        Ok(Self { budget: &doc.budget, name, count, component, base, sparse })
    }

    /// Reads all elements; those that are not stored are zero.
    fn read<T: Item + Copy>(&self) -> Result<Vec<T>, Error> {
        self.budget.charge(self.count, size_of::<T>(), &self.name)?;
        let mut out = reserve(self.count, &self.name)?;
        match (&self.sparse, self.base) {
            (None, Some(base)) => out.extend(ItemIter::<T>::new(base.bytes, base.stride).take(self.count)),
            (None, None) => out.resize(self.count, T::zero()),
            (Some((indices, values)), base) => {
                // The crate reads the indices from bytes. Ours are decoded and checked already, so they are encoded
                // again.
                let raw: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()).collect();
                let indices = SparseIndicesIter::U32(ItemIter::new(&raw, 4));
                let values = ItemIter::new(values.bytes, values.stride);
                let base = base.map(|b| ItemIter::new(b.bytes, b.stride));
                out.extend(SparseIter::<T>::with_base_count(base, self.count, indices, values).take(self.count));
            }
        }
        debug_assert_eq!(out.len(), self.count);
        Ok(out)
    }

    /// Reads all elements as floats. Refuses NaN and infinities.
    pub fn floats<const N: usize>(&self) -> Result<Vec<[f32; N]>, Error>
    where
        [f32; N]: Item,
    {
        let values = self.read::<[f32; N]>()?;
        for (i, v) in values.iter().enumerate() {
            finite(*v, || format!("{}[{i}]", self.name))?;
        }
        Ok(values)
    }

    /// Reads numbers. They need not be finite.
    pub fn scalars(&self) -> Result<Vec<f32>, Error> {
        self.read::<f32>()
    }

    /// Reads the elements that are not zero, with their indices in increasing order. Elements that a sparse accessor
    /// omits cost nothing.
    pub fn nonzero(&self) -> Result<(Vec<u32>, Vec<[f32; 3]>), Error> {
        let pairs: Vec<(u32, [f32; 3])> = match (&self.sparse, self.base) {
            (Some((indices, values)), None) => {
                self.budget.charge(indices.len(), 16, &self.name)?;
                indices.iter().copied().zip(ItemIter::new(values.bytes, values.stride)).collect()
            }
            _ => (0..).zip(self.read::<[f32; 3]>()?).collect(),
        };
        let mut out = (Vec::new(), Vec::new());
        for (i, v) in pairs {
            finite(v, || format!("{}[{i}]", self.name))?;
            if v != [0.0; 3] {
                out.0.push(i);
                out.1.push(v);
            }
        }
        Ok(out)
    }

    /// Reads all elements as vertex indices, which must be below `limit`.
    pub fn indices(&self, limit: usize) -> Result<Vec<u32>, Error> {
        let wide: Vec<u32> = match self.component {
            ComponentType::U8 => self.read::<u8>()?.into_iter().map(u32::from).collect(),
            ComponentType::U16 => self.read::<u16>()?.into_iter().map(u32::from).collect(),
            _ => self.read::<u32>()?,
        };
        match wide.iter().position(|i| *i as usize >= limit) {
            None => Ok(wide),
            Some(at) => Err(out_of_range(&format!("{}[{at}]", self.name), wide[at] as usize, limit)),
        }
    }
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
        (_, ComponentType::F32) => Ok(ComponentType::F32),
        (_, c) => Err(unsupported(format!(
            "{name} has quantised components of {} (KHR_mesh_quantization); 32-bit floats are read",
            component_name(c)
        ))),
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
    Ok(Strided { bytes: &bytes[range], stride })
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
    let indices: Vec<u32> = match component {
        ComponentType::U8 => ItemIter::<u8>::new(raw.bytes, raw.stride).map(u32::from).collect(),
        ComponentType::U16 => ItemIter::<u16>::new(raw.bytes, raw.stride).map(u32::from).collect(),
        ComponentType::U32 => ItemIter::<u32>::new(raw.bytes, raw.stride).collect(),
        other => {
            return Err(malformed(format!(
                "{indices_name} have components of {}; they must be unsigned",
                component_name(other)
            )));
        }
    };
    if let Some(i) = (1..indices.len()).find(|i| indices[*i] <= indices[i - 1]) {
        return Err(malformed(format!(
            "{indices_name}[{i}] is {} after {}; they must increase",
            indices[i],
            indices[i - 1]
        )));
    }
    match indices.last() {
        Some(last) if *last as usize >= count => {
            let at = indices.partition_point(|i| (*i as usize) < count);
            Err(out_of_range(&format!("{indices_name}[{at}]"), indices[at] as usize, count))
        }
        _ => Ok(Some((indices, values))),
    }
}

/// Refuses an accessor whose data is in an extension. Without data it is all zeros; Blender writes shape keys that move
/// nothing this way.
fn not_compressed(doc: &Document<'_>, index: usize, name: &str) -> Result<(), Error> {
    let used = doc.value["extensionsUsed"].as_array().map(Vec::as_slice).unwrap_or_default();
    let used = used.iter().filter_map(|e| e.as_str()).find(|e| e.contains("draco") || e.contains("meshopt"));
    let own = doc.value["accessors"][index]["extensions"].as_object().and_then(|o| o.keys().next());
    match own.map(String::as_str).or(used) {
        Some(e) => Err(unsupported(format!("{name} has its data in {e}; export without mesh compression"))),
        None => Ok(()),
    }
}

fn type_name(kind: Type) -> &'static str {
    match kind {
        Type::Scalar => "SCALAR",
        Type::Vec2 => "VEC2",
        Type::Vec3 => "VEC3",
        Type::Vec4 => "VEC4",
        Type::Mat2 => "MAT2",
        Type::Mat3 => "MAT3",
        Type::Mat4 => "MAT4",
    }
}

fn component_name(component: ComponentType) -> &'static str {
    match component {
        ComponentType::I8 => "BYTE (5120)",
        ComponentType::U8 => "UNSIGNED_BYTE (5121)",
        ComponentType::I16 => "SHORT (5122)",
        ComponentType::U16 => "UNSIGNED_SHORT (5123)",
        ComponentType::U32 => "UNSIGNED_INT (5125)",
        ComponentType::F32 => "FLOAT (5126)",
    }
}
