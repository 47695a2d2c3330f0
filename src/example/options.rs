//! Options for building an example set.

use crate::base::error::Error;
use crate::base::error::{at_least_zero, positive};
use crate::basis::learn::BasisOptions;
use crate::mesh::MAX_COORDINATE;

/// Mass of the vertices, for impulses that do not give one.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum VertexMass {
    /// Unknown. Each impulse must give a mass.
    #[default]
    None,
    /// The same mass for all vertices, kg.
    Uniform(f32),
    /// One mass per vertex, kg.
    PerVertex(Vec<f32>),
}

/// Options for building an example set.
#[derive(Debug, Clone, PartialEq)]
pub struct SetOptions {
    /// Largest displacement of any vertex, m. `None` takes three times the longest displacement of all examples.
    pub depth_limit: Option<f32>,
    /// Mass of the vertices.
    pub mass: VertexMass,
    /// Displacements no longer than this are dropped, m. 0 drops only exact zeros.
    pub drop_below: f32,
    /// Largest position error that compression may cause, for an example of weight 1, m. `None` stores displacements as
    /// exact floats. With a tolerance, displacements are stored as multiples of one step in the narrowest integers, and
    /// those no longer than the tolerance are dropped.
    pub tolerance: Option<f32>,
    /// With a tolerance, the largest error of a normal for an example of weight 1, degrees. Above 0 and at most 45.
    pub normal_tolerance: f32,
    /// Whether examples also count mirrored unless they contradict it, if the body is symmetric about a coordinate plane through the centre of
    /// its bounds.
    pub mirror: bool,
    /// Whether carried dents fade to zero towards edges of the sheet that the examples show to be held (fixed).
    pub held_rims: bool,
    /// How well vertices follow *nodes*, a few of them, whose displacements alone are computed from hits (docs/model.md, "Nodes").
    /// `None`: nodes spread evenly. With options more are added where vertices are wrong. It is not saved.
    pub basis: Option<BasisOptions>,
    /// Whether a baked file holds the examples whole, as the classic rules need them. Otherwise it holds what they move the nodes by, which is all that
    /// hits need: an example of a body of many vertices then takes a tenth of the memory.
    pub whole_examples: bool,
}

impl Default for SetOptions {
    fn default() -> Self {
        Self {
            depth_limit: None,
            mass: VertexMass::default(),
            drop_below: 0.0,
            tolerance: None,
            normal_tolerance: 1.0,
            mirror: true,
            held_rims: true,
            basis: None,
            whole_examples: false,
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
