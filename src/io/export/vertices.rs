//! The vertices that an export takes, and what it returns.

use crate::base::error::Error;
use crate::io::import::finite;

/// A written file.
#[derive(Debug, Clone, PartialEq)]
pub struct Exported {
    /// The GLB's bytes.
    pub glb: Vec<u8>,
    /// What could not be kept as it was, such as images that were not found: a sentence each, for people.
    pub notes: Vec<String>,
}

/// Deformed vertices, checked to be the right number and finite.
#[derive(Clone, Copy)]
pub(super) struct Vertices<'a> {
    pub(super) positions: &'a [[f32; 3]],
    pub(super) normals: Option<&'a [[f32; 3]]>,
    pub(super) tangents: Option<&'a [[f32; 4]]>,
}

impl<'a> Vertices<'a> {
    pub(super) fn checked(
        count: usize,
        positions: &'a [[f32; 3]],
        normals: Option<&'a [[f32; 3]]>,
        tangents: Option<&'a [[f32; 4]]>,
    ) -> Result<Self, Error> {
        each(count, positions, "positions")?;
        normals.map_or(Ok(()), |n| each(count, n, "normals"))?;
        tangents.map_or(Ok(()), |t| each(count, t, "tangents"))?;
        Ok(Self { positions, normals, tangents })
    }
}

pub(super) fn each<const N: usize>(count: usize, values: &[[f32; N]], name: &str) -> Result<(), Error> {
    if values.len() != count {
        return Err(Error::invalid(
            &format!("{name}.len()"),
            values.len(),
            &format!("{count}, as many as the mesh has vertices"),
        ));
    }
    values.iter().enumerate().try_for_each(|(i, v)| finite(*v, || format!("{name}[{i}]")).map(drop))
}
