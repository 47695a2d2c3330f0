//! The vertices that an export takes, and the file that it rewrites.

use crate::base::error::Error;
use crate::io::glb::Glb;
use crate::io::import::document::Document;
use crate::io::import::finite;

/// A file that is being rewritten.
pub(super) struct Rewrite<'d> {
    pub doc: &'d Document<'d>,
    pub glb: Glb,
    pub notes: Vec<String>,
}

/// Deformed vertices.
#[derive(Clone, Copy)]
pub(super) struct Vertices<'a> {
    pub positions: &'a [[f32; 3]],
    pub normals: Option<&'a [[f32; 3]]>,
    pub tangents: Option<&'a [[f32; 4]]>,
}

impl Vertices<'_> {
    /// They must be the right number and finite.
    pub fn check(&self, count: usize) -> Result<(), Error> {
        each(count, self.positions, "positions")?;
        self.normals.map_or(Ok(()), |n| each(count, n, "normals"))?;
        self.tangents.map_or(Ok(()), |t| each(count, t, "tangents"))
    }
}

fn each<const N: usize>(count: usize, values: &[[f32; N]], name: &str) -> Result<(), Error> {
    if values.len() != count {
        return Err(Error::invalid(
            &format!("{name}.len()"),
            values.len(),
            &format!("{count}, as many as the mesh has vertices"),
        ));
    }
    values.iter().enumerate().try_for_each(|(i, v)| finite(*v, || format!("{name}[{i}]")).map(drop))
}
