//! The JSON list of impacts; its keys are documented in `docs/impacts.md`.

use anyhow::{Context, Result, anyhow, bail};
use crumple::{Cause, Hit, Space};
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use std::num::NonZeroU64;
use std::path::Path;

/// One impact as the file has it. Numbers are f64 here, so that one too large for f32 is noticed.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "lowercase")]
struct Entry {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    name: Option<String>,
    point: [f64; 3],
    #[serde(default, skip_serializing_if = "Option::is_none")]
    displacement: Option<[f64; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    impulse: Option<[f64; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    duration: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    mass: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    space: Option<SpaceName>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    contact: Option<NonZeroU64>,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum SpaceName {
    Local,
    World,
}

/// An impact ready to submit.
#[derive(Debug, Clone, PartialEq)]
pub struct Impact {
    pub name: Option<String>,
    pub hit: Hit,
}

/// Reads and checks a file.
pub fn read(path: &Path) -> Result<Vec<Impact>> {
    let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    let text = std::str::from_utf8(&bytes)
        .map_err(|e| anyhow!("{}: not UTF-8 at byte {}; JSON is UTF-8", path.display(), e.valid_up_to()))?;
    parse(text).with_context(|| path.display().to_string())
}

/// Parses and checks a list.
fn parse(text: &str) -> Result<Vec<Impact>> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let raw: Vec<&RawValue> = serde_json::from_str(text).map_err(|e| {
        if e.is_data() { anyhow!("not a list of impacts [{{…}}, …]: {e}") } else { anyhow!("not JSON: {e}") }
    })?;
    if raw.is_empty() {
        bail!("the list of impacts is empty; there is nothing to do");
    }
    raw.iter().enumerate().map(|(i, raw)| entry(raw.get()).with_context(|| format!("impact {i}"))).collect()
}

fn entry(raw: &str) -> Result<Impact> {
    let entry: Entry = serde_json::from_str(raw).map_err(|e| explain(&e, raw))?;
    let point = vector("point", entry.point)?;
    let number = |key: &'static str, value: Option<f64>| -> Result<f32> {
        let value = value.ok_or_else(|| anyhow!("'impulse' needs '{key}' beside it"))?;
        if !(value > 0.0 && (value as f32) > 0.0 && (value as f32).is_finite()) {
            bail!("{key} is {value}; it must be above 0 and at most 3.4e38");
        }
        Ok(value as f32)
    };
    let cause = match (entry.displacement, entry.impulse) {
        (Some(_), Some(_)) => bail!("both 'displacement' and 'impulse'; give one of them"),
        (None, None) => bail!("neither 'displacement' (m) nor 'impulse' (N s); give one of them"),
        (Some(displacement), None) => {
            for (key, value) in [("duration", entry.duration), ("mass", entry.mass)] {
                if value.is_some() {
                    bail!("'{key}' goes with 'impulse', not with 'displacement'");
                }
            }
            Cause::Displacement(vector("displacement", displacement)?)
        }
        (None, Some(impulse)) => Cause::Impulse {
            impulse: vector("impulse", impulse)?,
            duration: number("duration", entry.duration)?,
            mass: Some(number("mass", entry.mass)?),
        },
    };
    let space = match entry.space {
        Some(SpaceName::World) => Space::World,
        _ => Space::Local,
    };
    Ok(Impact { name: entry.name, hit: Hit { point, cause, space, contact: entry.contact } })
}

fn vector(key: &str, value: [f64; 3]) -> Result<[f32; 3]> {
    for (i, v) in value.iter().enumerate() {
        if !(*v as f32).is_finite() {
            bail!("{key}[{i}] is {v:e}; it must be within 3.4e38 of zero");
        }
    }
    Ok(value.map(|v| v as f32))
}

/// serde_json tells where, counted from the impact's own start; the reader of the file needs what.
fn explain(error: &serde_json::Error, raw: &str) -> anyhow::Error {
    let text = error.to_string();
    let what = text.split(" at line ").next().unwrap_or(&text);
    if what.contains("number out of range") {
        let line = raw.lines().nth(error.line().saturating_sub(1)).unwrap_or(raw);
        let end = error.column().min(line.len());
        let number = |c: char| c.is_ascii_digit() || "+-.eE".contains(c);
        let start = line.as_bytes()[..end].iter().rposition(|&b| !number(b as char)).map_or(0, |p| p + 1);
        let stop = line.as_bytes()[end..].iter().position(|&b| !number(b as char)).map_or(line.len(), |p| end + p);
        return anyhow!("{} is out of range; numbers must be within 3.4e38 of zero", &line[start..stop]);
    }
    anyhow!("{what}")
}

/// The file for displacements at points, m.
pub fn format(impacts: &[([f32; 3], [f32; 3])]) -> Result<String> {
    // Through the shortest text of an f32, so that the file shows 0.1 and not 0.10000000149.
    let exact = |v: [f32; 3]| v.map(|c| c.to_string().parse::<f64>().unwrap_or(f64::from(c)));
    let mut text = String::from("[\n");
    for (i, &(point, displacement)) in impacts.iter().enumerate() {
        let entry = Entry {
            name: Some(format!("sample {i}")),
            point: exact(point),
            displacement: Some(exact(displacement)),
            ..Entry::default()
        };
        let comma = if i + 1 < impacts.len() { "," } else { "" };
        text.push_str(&format!("  {}{comma}\n", serde_json::to_string(&entry)?));
    }
    text.push_str("]\n");
    Ok(text)
}
