//! How an example set is built.

use crate::base::error::Error;
use crate::base::error::{at_least_zero, positive};
use crate::mesh::MAX_COORDINATE;

/// How the displacements of several marks combine at a vertex. The result always has the direction of their sum.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Combine {
    /// Displacements add, up to the depth limit.
    Sum = 1,
    /// Energies add: the sum is no longer than the square root of the sum of squared lengths. The default.
    #[default]
    Energies = 0,
    /// The sum is no longer than the longest displacement.
    Deepest = 2,
}

/// What happens when an example moves apart vertices that share a base position.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Seams {
    /// The vertices stay together: each gets the mean of their displacements. The default.
    #[default]
    Weld = 0,
    /// The vertices move apart as in the example, for tears that the artist made.
    Keep = 1,
}

/// Mass of a vertex, for impulses that do not bring their own.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum VertexMass {
    /// Unknown: each impulse must bring a mass.
    #[default]
    None,
    /// The same for all, kg.
    Uniform(f32),
    /// One a vertex, kg.
    PerVertex(Vec<f32>),
}

/// How an example set is built.
#[derive(Debug, Clone, PartialEq)]
pub struct SetOptions {
    /// No vertex ever moves further than this, m. `None`: the deepest displacement of any example.
    pub depth_limit: Option<f32>,
    /// How the dents of several marks combine.
    pub combine: Combine,
    /// Whether carried examples may never be scaled above their own depth, as anchored ones never are.
    pub strict: bool,
    /// What becomes of examples that tear seams.
    pub seams: Seams,
    /// Mass of a vertex.
    pub mass: VertexMass,
    /// Displacements up to this length are dropped, m. 0 drops only exact zeros.
    pub drop_below: f32,
    /// Nodes along each side of a stamp: 4 to 128. With a tolerance, at most.
    pub stamp_resolution: u32,
    /// How far an example of weight 1 may put a vertex off, m. `None` keeps every displacement as an exact float. With a
    /// tolerance displacements are whole multiples of one step for the set, in the narrowest integers, and those no longer than
    /// the tolerance are dropped; stamps get the coarsest grid that holds it, if any of up to `stamp_resolution` nodes does
    /// ([`crate::Stamp::error`] tells).
    pub tolerance: Option<f32>,
    /// With a tolerance: how far an example of weight 1 may turn a normal off, degrees; above 0 to 45.
    pub normal_tolerance: f32,
    /// Whether examples also serve mirrored, where the body is the same on both sides of a coordinate plane through the centre
    /// of its bounds.
    pub mirror: bool,
    /// Whether carried dents fall to zero towards edges of the sheet that the examples show to be held.
    pub held_rims: bool,
}

impl Default for SetOptions {
    fn default() -> Self {
        Self {
            depth_limit: None,
            combine: Combine::default(),
            strict: false,
            seams: Seams::default(),
            mass: VertexMass::default(),
            drop_below: 0.0,
            stamp_resolution: 32,
            tolerance: None,
            normal_tolerance: 1.0,
            mirror: true,
            held_rims: true,
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
    if !(4..=128).contains(&o.stamp_resolution) {
        return Err(Error::invalid("stamp_resolution", o.stamp_resolution, "4 to 128"));
    }
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
