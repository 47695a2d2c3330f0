//! A truth's body as the library sees it: a set of its first examples, hits, deformed vertices.

use std::sync::Arc;

use anyhow::Result;
use crumple::{
    BasisOptions, Blow, Contact, Deltas, ExampleData, ExampleSet, Hit, Instance, InstanceOptions, MeshData, Serial,
    SetOptions, Striker, StrikerShape, Tracker, VertexMemory,
};

use crate::truth::{self, Body, Field, Impact};

/// Of the vertices that follow nodes, m.
const TOLERANCE: f32 = 5e-4;

pub fn mesh(body: &Body) -> MeshData {
    MeshData {
        positions: body.vertices.clone(),
        normals: Some(body.normals.clone()),
        tangents: None,
        triangles: body.triangles.clone(),
        ..MeshData::default()
    }
}

/// The first `count` training impacts as examples.
pub fn examples(body: &Body, count: usize) -> Vec<ExampleData> {
    body.train.iter().take(count).map(example).collect()
}

pub fn example(impact: &Impact) -> ExampleData {
    ExampleData {
        contact: Some(Contact::Vertex(impact.contact_vertex)),
        blow: impact.blow.as_ref().map(blow).unwrap_or_default(),
        ..ExampleData::new(impact.source.clone(), Deltas::Full(impact.field.clone()))
    }
}

/// All that is known of a blow.
pub fn blow(known: &truth::Blow) -> Blow {
    let shape = if known.pole { StrikerShape::Pole } else { StrikerShape::Ball };
    Blow {
        impulse: Some(known.impulse),
        duration: known.duration,
        normal: Some(known.normal),
        striker: Striker { mass: Some(known.mass), velocity: Some(known.velocity), radius: Some(known.radius), shape },
    }
}

/// A set of the first `count` training impacts.
pub fn set(body: &Body, count: usize, options: SetOptions) -> Result<Arc<ExampleSet>> {
    Ok(Arc::new(ExampleSet::build(mesh(body), examples(body, count), options, &Serial)?))
}

/// A set whose vertices follow as many nodes as they need to be near the examples.
pub fn with_nodes(body: &Body, count: usize) -> Result<Arc<ExampleSet>> {
    let basis = Some(BasisOptions::new(TOLERANCE));
    set(body, count, SetOptions { basis, ..SetOptions::default() })
}

/// What an engine would report: the contact point and the displacement wanted there.
pub fn hit(impact: &Impact) -> Hit {
    Hit::displacement(impact.point, impact.displacement)
}

/// What an engine knows of the blow; the displacement if the truth knows no blow.
pub fn blow_hit(impact: &Impact) -> Hit {
    let known = |known: &truth::Blow| Hit::blow(impact.point, blow(&known.in_engine()));
    impact.blow.as_ref().map_or_else(|| hit(impact), known)
}

/// What an engine would report that knows the depth alone: as deep, along the normal.
pub fn along_normal(set: &ExampleSet, impact: &Impact) -> Hit {
    let normal = set.mesh().contact_normal(impact.contact_vertex).unwrap_or_default();
    let d = impact.displacement;
    let depth = d.iter().map(|x| x * x).sum::<f32>().sqrt();
    Hit::displacement(impact.point, (normal * -depth).to_array())
}

/// The displacement field after these hits, m.
pub fn field_after(set: &Arc<ExampleSet>, options: &InstanceOptions, hits: &[Hit]) -> Result<Field> {
    let mut instance = Instance::new(set.clone(), *options)?;
    for hit in hits {
        instance.submit(hit)?;
        // One after the other: the classic rules depend on the order.
        instance.fold();
    }
    displacements(&mut instance)
}

/// The displacement field of an instance, m.
pub fn displacements(instance: &mut Instance) -> Result<Field> {
    let set = instance.example_set().clone();
    let mut positions = vec![[0.0f32; 3]; set.vertex_count()];
    instance.deform(&mut Tracker::new(), VertexMemory::separate(&mut positions, None, None)?, &Serial)?;
    let base = set.mesh().positions();
    Ok(positions.iter().zip(base).map(|(p, b)| [p[0] - b.x, p[1] - b.y, p[2] - b.z]).collect())
}
