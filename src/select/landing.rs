//! Where hits on an instance may land, if not on the whole base mesh.

use crate::base::error::Error;
use crate::base::tasks::TaskSystem;
use crate::example::set::ExampleSet;
use crate::mesh::finite;
use crate::mesh::nearest::{Nearest, VertexIndex};

/// The base vertices that may become contacts.
#[derive(Debug)]
pub(crate) struct Landing {
    index: VertexIndex,
    /// For each base vertex, whether hits there leave no mark.
    rigid: Vec<bool>,
}

impl Landing {
    /// Of the base vertices for which `may` is true. `None` if there is none. Both functions agree for vertices at one
    /// position.
    pub(crate) fn new(
        set: &ExampleSet,
        may: impl Fn(usize) -> bool,
        is_rigid: impl Fn(usize) -> bool,
        tasks: &dyn TaskSystem,
    ) -> Option<Self> {
        let (mesh, count) = (set.mesh(), set.vertex_count());
        let lowest = |v: usize| if may(v) { mesh.weld()[v] } else { u32::MAX };
        let weld: Vec<u32> = (0..count).map(lowest).collect();
        let index = weld.iter().any(|w| *w != u32::MAX).then(|| VertexIndex::new(mesh.positions(), &weld, tasks))?;
        Some(Landing { index, rigid: (0..count).map(is_rigid).collect() })
    }

    /// The nearest of these vertices. The lowest index if several are equally near.
    pub(crate) fn nearest(&self, set: &ExampleSet, point: [f32; 3]) -> Result<Nearest, Error> {
        let p = finite(point, || "point".into())?;
        self.index
            .nearest(p, set.mesh().positions())
            .ok_or_else(|| Error::invalid("point", p, "near enough that squared distances fit in f32"))
    }

    pub(crate) fn is_rigid(&self, vertex: u32) -> bool {
        self.rigid[vertex as usize]
    }
}
