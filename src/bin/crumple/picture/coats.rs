//! The materials of a glTF as the studio shows them.

use super::Coat;
use crumple::import::PrimitiveRange;
use glam::Vec3;
use serde_json::Value;

/// How the materials of a glTF or GLB look, and for each vertex of these primitives the index of its material.
pub fn coats(file: &[u8], primitives: &[PrimitiveRange], vertices: usize) -> (Vec<Coat>, Vec<f32>) {
    // A GLB's first chunk is its JSON; its length is the fourth number of the file.
    let chunk = |from: usize, to: usize| file.get(from..to);
    let text = match chunk(0, 4) {
        Some(b"glTF") => {
            let length = chunk(12, 16).and_then(|four| four.try_into().ok()).map_or(0, u32::from_le_bytes);
            chunk(20, 20usize.saturating_add(length as usize))
        }
        _ => Some(file),
    };
    let file: Value = text.and_then(|text| serde_json::from_slice(text).ok()).unwrap_or_default();
    let materials = file["materials"].as_array().map(Vec::as_slice).unwrap_or_default();
    let number = |value: &Value| value.as_f64().unwrap_or(1.0) as f32;
    let coat = |material: &Value| {
        let look = &material["pbrMetallicRoughness"];
        let [red, green, blue, opaque] = [0, 1, 2, 3].map(|channel| number(&look["baseColorFactor"][channel]));
        // Nothing is drawn behind glass, which is dark.
        Coat::of(
            Vec3::new(red, green, blue) * opaque,
            number(&look["metallicFactor"]),
            number(&look["roughnessFactor"]),
        )
    };
    // The last one is of primitives without a material, which is white.
    let coats: Vec<Coat> = materials.iter().chain([&Value::Null]).map(coat).collect();
    let mut coat_of = vec![materials.len() as f32; vertices];
    for range in primitives {
        let named = materials.iter().position(|material| material["name"].as_str() == range.material.as_deref());
        let of = coat_of.get_mut(range.vertices.clone()).unwrap_or_default();
        of.fill(named.unwrap_or(materials.len()) as f32);
    }
    (coats, coat_of)
}
