//! Reads `mesh.extras` of the targets: names, impacts with their blows, and which targets are dents.

use super::document::out_of_range;
use super::words::{brief, listed, unfit};
use super::{finite, malformed, whole};
use crate::base::error::Error;
use crate::example::blow::{Blow, Striker, StrikerShape};
use crate::example::data::{Contact, ExampleData};
use serde_json::{Map, Value};
use std::collections::HashMap;

/// Describes examples by the `extras` of their glTF mesh, for engines that import glTF themselves and keep the extras.
///
/// `extras` is a JSON object with the keys `targetNames` and `impacts`, as the [module](super) says. All
/// are optional. `examples` are the mesh's targets in order, and `vertices` is the number of vertices that
/// `contact_vertex` may refer to. Names, contacts, contact normals and blows that the object knows replace
/// the examples' own.
///
/// ```
/// use crumple::{Contact, Deltas, ExampleData, import};
/// let mut examples = [ExampleData::new("", Deltas::Full(vec![[0.0, 0.0, -0.1]; 3]))];
/// let text = r#"{"targetNames": ["ball"], "impacts": [{"name": "ball", "contact_vertex": 2}]}"#;
/// import::apply_extras(text, 3, &mut examples)?;
/// assert_eq!((&*examples[0].name, examples[0].contact), ("ball", Some(Contact::Vertex(2))));
/// # Ok::<(), crumple::Error>(())
/// ```
///
/// # Errors
/// [`Error::Format`], [`Error::IndexOutOfRange`] and [`Error::NotFinite`], which name what is wrong. After an error
/// nothing has changed.
pub fn apply_extras(extras: &str, vertices: usize, examples: &mut [ExampleData]) -> Result<(), Error> {
    let value: Value =
        serde_json::from_str(extras).map_err(|e| malformed(format!("the mesh's extras are not JSON: {e}")))?;
    if !value.is_object() {
        return Err(malformed(format!("the mesh's extras are {}; they must be an object", brief(&value))));
    }
    let named = !value["targetNames"].is_null();
    let mesh = Value::Object([("extras".to_owned(), value)].into_iter().collect());
    let names = if named {
        names(&mesh, examples.len(), || None)?
    } else {
        examples.iter().map(|example| example.name.clone()).collect()
    };
    let impacts = impacts(&mesh, &names, vertices)?;
    for (example, (name, impact)) in examples.iter_mut().zip(names.into_iter().zip(impacts)) {
        example.name = name;
        if impact.contact.is_some() {
            (example.contact, example.contact_normal, example.blow) = (impact.contact, impact.normal, impact.blow);
        }
    }
    Ok(())
}

/// What is known of how an example was made.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Impact {
    pub(super) contact: Option<Contact>,
    /// Outward normal at the contact. It is the surface's and the blow's.
    pub(super) normal: Option<[f32; 3]>,
    pub(super) blow: Blow,
}

/// The name of each target. Exporters write the names to the mesh; some older ones write them to its first primitive, or name
/// the targets' accessors, which `elsewhere` returns.
pub(super) fn names(
    mesh: &Value,
    targets: usize,
    elsewhere: impl FnOnce() -> Option<Vec<String>>,
) -> Result<Vec<String>, Error> {
    let on_mesh = &mesh["extras"]["targetNames"];
    let list = if on_mesh.is_null() { &mesh["primitives"][0]["extras"]["targetNames"] } else { on_mesh };
    let list = match list {
        Value::Null => match elsewhere() {
            Some(names) => return Ok(names),
            None => &[],
        },
        Value::Array(list) => list.as_slice(),
        other => return Err(unfit("extras.targetNames", other, "a list of texts")),
    };
    let name = |i| match list.get(i) {
        Some(Value::String(name)) => Ok(name.clone()),
        None | Some(Value::Null) => Ok(format!("target {i}")),
        Some(other) => Err(unfit(&format!("extras.targetNames[{i}]"), other, "a text")),
    };
    (0..targets).map(name).collect()
}

/// The patterns of the targets that are dents, from `extras.dents`. `None` if it is absent.
pub(super) fn dents(mesh: &Value) -> Result<Option<Vec<String>>, Error> {
    let list = match &mesh["extras"]["dents"] {
        Value::Null => return Ok(None),
        Value::String(text) => return Ok(Some(text.split(',').map(|word| word.trim().to_owned()).collect())),
        Value::Array(list) => list,
        other => return Err(unfit("extras.dents", other, "a list of names")),
    };
    let word = |(i, word): (usize, &Value)| match word {
        Value::String(text) => Ok(text.clone()),
        other => Err(unfit(&format!("extras.dents[{i}]"), other, "a name")),
    };
    list.iter().enumerate().map(word).collect::<Result<Vec<_>, _>>().map(Some)
}

/// The impact of each target, from `extras.impacts`.
pub(super) fn impacts(mesh: &Value, names: &[String], vertices: usize) -> Result<Vec<Impact>, Error> {
    let mut out = vec![Impact::default(); names.len()];
    // Blender's interface cannot make lists of objects, so JSON in a text is accepted too.
    let parsed: Value;
    let list = match &mesh["extras"]["impacts"] {
        Value::String(text) => {
            let not_json = |e| malformed(format!("extras.impacts is a text that is not JSON: {e}"));
            parsed = serde_json::from_str(text).map_err(not_json)?;
            &parsed
        }
        other => other,
    };
    let list = match list {
        Value::Null => return Ok(out),
        Value::Array(list) => list,
        other => return Err(unfit("extras.impacts", other, "a list of objects")),
    };
    let entry = |(i, value)| object(value, &format!("extras.impacts[{i}]"));
    let list: Vec<&Map<String, Value>> = list.iter().enumerate().map(entry).collect::<Result<_, _>>()?;
    let targets = by_name(&list, names)?;
    if targets.is_none() && list.len() > names.len() {
        return Err(malformed(format!(
            "extras.impacts has {} entries for {} targets; give at most one each",
            list.len(),
            names.len()
        )));
    }
    for (i, entry) in list.iter().enumerate() {
        out[targets.as_ref().map_or(i, |t| t[i])] = impact(entry, i, vertices)?;
    }
    Ok(out)
}

/// The target of each impact, by name. `None` if names do not decide it: two targets or two impacts have the same name,
/// or an impact has none.
fn by_name(list: &[&Map<String, Value>], names: &[String]) -> Result<Option<Vec<usize>>, Error> {
    let index: HashMap<&str, usize> = names.iter().enumerate().map(|(i, n)| (n.as_str(), i)).collect();
    let used: Option<Vec<&str>> = list.iter().map(|entry| entry.get("name").and_then(Value::as_str)).collect();
    let Some(used) = used.filter(|_| index.len() == names.len()) else { return Ok(None) };
    let distinct: std::collections::HashSet<&str> = used.iter().copied().collect();
    if distinct.len() < used.len() {
        return Ok(None);
    }
    let target = |(i, name): (usize, &&str)| {
        index.get(name).copied().ok_or_else(|| {
            malformed(format!(
                "extras.impacts[{i}] is for '{name}'; there is no such target (there are {})",
                listed(names.iter())
            ))
        })
    };
    used.iter().enumerate().map(target).collect::<Result<_, _>>().map(Some)
}

fn impact(entry: &Map<String, Value>, i: usize, vertices: usize) -> Result<Impact, Error> {
    let at = format!("extras.impacts[{i}]");
    let vertex = given(entry, "contact_vertex", &at, |value, name| vertex(value, name, vertices))?;
    let contact = given(entry, "point", &at, vector)?.map(Contact::Point).or(vertex.map(Contact::Vertex));
    if contact.is_none() {
        return Err(malformed(format!("{at} has neither a point nor a contact_vertex")));
    }
    let normal = given(entry, "normal", &at, vector)?.map(|n| unit(n, i)).transpose()?;
    let blow = Blow {
        impulse: given(entry, "impulse", &at, vector)?,
        duration: given(entry, "duration", &at, positive)?,
        normal,
        striker: given(entry, "striker", &at, striker)?.unwrap_or_default(),
    };
    Ok(Impact { contact, normal, blow })
}

fn striker(value: &Value, name: &str) -> Result<Striker, Error> {
    let entry = object(value, name)?;
    Ok(Striker {
        mass: given(entry, "mass", name, positive)?,
        velocity: given(entry, "velocity", name, vector)?,
        radius: given(entry, "radius", name, positive)?,
        shape: entry.get("shape").and_then(Value::as_str).map_or(StrikerShape::Unknown, StrikerShape::named),
    })
}

/// The value of a key, as `read` reads it. `None` if the key is absent or null. `at` is the name of the entry.
fn given<T>(
    entry: &Map<String, Value>,
    key: &str,
    at: &str,
    read: impl Fn(&Value, &str) -> Result<T, Error>,
) -> Result<Option<T>, Error> {
    match entry.get(key) {
        None | Some(Value::Null) => Ok(None),
        Some(value) => read(value, &format!("{at}.{key}")).map(Some),
    }
}

fn object<'v>(value: &'v Value, name: &str) -> Result<&'v Map<String, Value>, Error> {
    value.as_object().ok_or_else(|| unfit(name, value, "an object"))
}

fn vector(value: &Value, name: &str) -> Result<[f32; 3], Error> {
    let numbers: Option<Vec<f64>> = value.as_array().and_then(|a| a.iter().map(Value::as_f64).collect());
    match numbers.as_deref() {
        Some([x, y, z]) => finite([*x as f32, *y as f32, *z as f32], || name.to_owned()),
        _ => Err(unfit(name, value, "three numbers")),
    }
}

fn positive(value: &Value, name: &str) -> Result<f32, Error> {
    let number = value.as_f64().map(|x| x as f32).filter(|x| *x > 0.0 && x.is_finite());
    number.ok_or_else(|| unfit(name, value, "a number above 0"))
}

fn vertex(value: &Value, name: &str, vertices: usize) -> Result<u32, Error> {
    // Blender writes an integer custom property as 7.0 if it was set as a float.
    match whole(value) {
        Some(v) if v < vertices as u64 => Ok(v as u32),
        Some(v) => Err(out_of_range(name, usize::try_from(v).unwrap_or(usize::MAX), vertices)),
        None => Err(unfit(name, value, "a vertex index")),
    }
}

fn unit(n: [f32; 3], i: usize) -> Result<[f32; 3], Error> {
    let length = n.iter().map(|x| f64::from(*x) * f64::from(*x)).sum::<f64>().sqrt();
    if length < 1e-30 {
        return Err(malformed(format!("extras.impacts[{i}].normal is {n:?}; it must have a length")));
    }
    Ok(n.map(|x| (f64::from(x) / length) as f32))
}
