//! The materials of an MTL file as glTF materials.

use super::words::decoded;
use serde_json::{Value, json};
use std::collections::HashMap;

/// The materials of a library by name. `Err` says what the library lacks.
pub(super) fn library(bytes: &[u8]) -> Result<HashMap<String, tobj::Material>, String> {
    let text = decoded(bytes).replace("\r\n", "\n").replace('\r', "\n");
    match tobj::load_mtl_buf(&mut text.as_bytes()) {
        Ok((materials, _)) => Ok(materials.into_iter().rev().map(|m| (m.name.clone(), m)).collect()),
        Err(error) => Err(error.to_string()),
    }
}

/// A glTF material. `texture` returns the index of a glTF texture of this uri.
pub(super) fn material(name: &str, mtl: Option<&tobj::Material>, texture: &mut dyn FnMut(String) -> usize) -> Value {
    let mut out = json!({ "name": name });
    let Some(mtl) = mtl else { return out };
    let number = |key: &str| mtl.unknown_param.get(key).and_then(|text| text.parse::<f32>().ok());
    let map = |key: &str| mtl.unknown_param.get(key).map(String::as_str);
    let alpha = mtl.dissolve.or(number("Tr").map(|t| 1.0 - t)).unwrap_or(1.0).clamp(0.0, 1.0);
    let colour_map = mtl.diffuse_texture.as_deref().and_then(file);
    // The picture has the colour: exporters leave a grey beside it.
    let colour = if colour_map.is_some() { [1.0; 3] } else { mtl.diffuse.unwrap_or([1.0; 3]) };
    let [r, g, b] = colour.map(shortest);
    // The roughness whose highlight is as wide as that of a Phong exponent (Karis, 2013).
    let from_exponent = |ns: f32| (2.0 / (ns.max(0.0) + 2.0)).powf(0.25);
    let roughness = number("Pr").or(mtl.shininess.map(from_exponent)).unwrap_or(1.0).clamp(0.0, 1.0);
    let metallic = number("Pm").unwrap_or(0.0).clamp(0.0, 1.0);
    out["pbrMetallicRoughness"] = json!({
        "baseColorFactor": [r, g, b, shortest(alpha)],
        "metallicFactor": shortest(metallic),
        "roughnessFactor": shortest(roughness),
    });
    if let Some(uri) = colour_map {
        out["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": texture(uri) });
    }
    if alpha < 1.0 {
        out["alphaMode"] = "BLEND".into();
    }
    let emissive_map = map("map_Ke").and_then(file);
    let emissive = if emissive_map.is_some() { Some([1.0; 3]) } else { mtl.emissive };
    if let Some(emissive) = emissive.filter(|e| *e != [0.0; 3]) {
        out["emissiveFactor"] = emissive.map(|x| shortest(x.clamp(0.0, 1.0))).to_vec().into();
    }
    if let Some(uri) = emissive_map {
        out["emissiveTexture"] = json!({ "index": texture(uri) });
    }
    if let Some(uri) = map("norm").and_then(file) {
        out["normalTexture"] = json!({ "index": texture(uri) });
    }
    // What glTF has no place for.
    let others = [
        ("map_Bump", mtl.normal_texture.as_deref()),
        ("map_Ks", mtl.specular_texture.as_deref()),
        ("map_Ns", mtl.shininess_texture.as_deref()),
        ("map_d", mtl.dissolve_texture.as_deref()),
    ];
    for (key, value) in others.into_iter().filter_map(|(key, value)| Some((key, value?))) {
        out["extras"][key] = value.into();
    }
    out
}

/// The number that reads back as the same float, in few digits.
fn shortest(x: f32) -> f64 {
    x.to_string().parse().unwrap_or_else(|_| f64::from(x))
}

/// The uri of a picture, without the options that may stand before its name. Of an absolute path only the name is left.
fn file(text: &str) -> Option<String> {
    let mut words = text.split_whitespace().peekable();
    while words.next_if(|word| word.starts_with('-')).is_some() {
        // Options have numbers or words such as "on" after them; the name is what remains at the end.
        while words.next_if(|word| word.parse::<f32>().is_ok() || matches!(*word, "on" | "off")).is_some() {}
    }
    let name = words.collect::<Vec<_>>().join(" ").replace('\\', "/");
    let is_absolute = name.starts_with('/') || name.get(1..3) == Some(":/");
    let name = if is_absolute { name.rsplit('/').next().unwrap_or_default() } else { &name };
    (!name.is_empty()).then(|| percent_encoding::utf8_percent_encode(name, PATH).to_string())
}

/// What must be encoded in the path of a uri.
const PATH: &percent_encoding::AsciiSet = &percent_encoding::CONTROLS
    .add(b' ')
    .add(b'"')
    .add(b'%')
    .add(b'#')
    .add(b'?')
    .add(b'<')
    .add(b'>')
    .add(b'[')
    .add(b']')
    .add(b':');
