//! Reads and writes the JSON list of impacts. `docs/impacts.md` documents its keys.

use anyhow::{Context, Result, anyhow, bail};
use crumple::{Blow, Cause, Hit, Space, Striker, StrikerShape};
use serde::Deserialize;
use serde_json::{json, value::RawValue};
use std::num::NonZeroU64;
use std::path::Path;

/// One impact of the file. Numbers are f64, so that a number too large for f32 can be refused.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "lowercase")]
struct Entry {
    name: Option<String>,
    point: [f64; 3],
    displacement: Option<[f64; 3]>,
    impulse: Option<[f64; 3]>,
    normal: Option<[f64; 3]>,
    striker: Option<StrikerEntry>,
    duration: Option<f64>,
    mass: Option<f64>,
    space: Option<SpaceName>,
    contact: Option<NonZeroU64>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct StrikerEntry {
    mass: Option<f64>,
    radius: Option<f64>,
    velocity: Option<[f64; 3]>,
    /// Such as "ball"; other names than those of [`StrikerShape::named`] are notes for people.
    shape: Option<String>,
}

#[derive(Debug, Clone, Copy, Deserialize)]
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
pub fn parse(text: &str) -> Result<Vec<Impact>> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let raw: Vec<&RawValue> = serde_json::from_str(text).map_err(|e| {
        if e.is_data() {
            anyhow!("the file is not a list of impacts, [{{…}}, …]")
        } else {
            anyhow!("not JSON: {e}")
        }
    })?;
    raw.iter().enumerate().map(|(i, raw)| entry(raw.get()).with_context(|| format!("impact {i}"))).collect()
}

fn entry(raw: &str) -> Result<Impact> {
    let entry: Entry =
        serde_path_to_error::deserialize(&mut serde_json::Deserializer::from_str(raw)).map_err(|e| explain(&e, raw))?;
    let point = vector("point", entry.point)?;
    let cause = match entry.displacement {
        Some(displacement) => {
            if entry.impulse.is_some() {
                bail!("both 'displacement' and 'impulse'; give one of them");
            }
            let others = [
                ("duration", entry.duration.is_some()),
                ("mass", entry.mass.is_some()),
                ("normal", entry.normal.is_some()),
                ("striker", entry.striker.is_some()),
            ];
            if let Some((key, _)) = others.iter().find(|(_, given)| *given) {
                bail!("'{key}' needs 'impulse' and cannot be given with 'displacement'");
            }
            Cause::Displacement(vector("displacement", displacement)?)
        }
        None => Cause::Impulse { blow: blow(&entry)?, mass: number("mass", entry.mass)? },
    };
    let space = match entry.space {
        Some(SpaceName::World) => Space::World,
        _ => Space::Local,
    };
    Ok(Impact { name: entry.name, hit: Hit { point, cause, space, contact: entry.contact } })
}

fn blow(entry: &Entry) -> Result<Blow> {
    let vector = |key: &str, value: Option<[f64; 3]>| value.map(|v| self::vector(key, v)).transpose();
    let none = StrikerEntry::default();
    let striker = entry.striker.as_ref().unwrap_or(&none);
    let blow = Blow {
        impulse: vector("impulse", entry.impulse)?,
        duration: number("duration", entry.duration)?,
        normal: vector("normal", entry.normal)?,
        striker: Striker {
            mass: number("striker.mass", striker.mass)?,
            velocity: vector("striker.velocity", striker.velocity)?,
            radius: number("striker.radius", striker.radius)?,
            shape: striker.shape.as_deref().map_or(StrikerShape::Unknown, StrikerShape::named),
        },
    };
    if blow.total_impulse().is_none() {
        bail!(
            "neither 'displacement' (m) nor 'impulse' (N s) nor a 'striker' with 'mass' (kg) and 'velocity' (m/s); give one of them"
        );
    }
    if blow.normal.is_some_and(|n| n == [0.0; 3]) {
        bail!("normal is [0, 0, 0]; it must be longer than 0");
    }
    Ok(blow)
}

fn number(key: &str, value: Option<f64>) -> Result<Option<f32>> {
    let Some(value) = value else { return Ok(None) };
    if !(value > 0.0 && (value as f32) > 0.0 && (value as f32).is_finite()) {
        bail!("{key} is {value}; it must be above 0 and at most 3.4e38");
    }
    Ok(Some(value as f32))
}

fn vector(key: &str, value: [f64; 3]) -> Result<[f32; 3]> {
    for (i, v) in value.iter().enumerate() {
        if !(*v as f32).is_finite() {
            bail!("{key}[{i}] is {v:e}; it must be within 3.4e38 of zero");
        }
    }
    Ok(value.map(|v| v as f32))
}

/// Rewrites serde's error for the file's author: the key, the value, and what would be right.
fn explain(error: &serde_path_to_error::Error<serde_json::Error>, raw: &str) -> anyhow::Error {
    let (path, error) = (error.path().to_string(), error.inner());
    let key = if path == "." { "the impact" } else { &path };
    let text = error.to_string();
    // The line and column count from the start of the impact, so they are left out.
    let what = text.split(" at line ").next().unwrap_or(&text);
    if what.contains("number out of range") {
        let line = raw.lines().nth(error.line().saturating_sub(1)).unwrap_or(raw);
        let end = error.column().min(line.len());
        let number = |c: char| c.is_ascii_digit() || "+-.eE".contains(c);
        let start = line.as_bytes()[..end].iter().rposition(|&b| !number(b as char)).map_or(0, |p| p + 1);
        let stop = line.as_bytes()[end..].iter().position(|&b| !number(b as char)).map_or(line.len(), |p| end + p);
        return anyhow!("{key}: {} is out of range; numbers must be within 3.4e38 of zero", &line[start..stop]);
    }
    let mismatch = what.strip_prefix("invalid type: ").or(what.strip_prefix("invalid value: "));
    if let Some((found, expected)) = mismatch.and_then(|t| t.rsplit_once(", expected ")) {
        return anyhow!("{key} is {}; it must be {}", json_name(found), json_name(expected));
    }
    if let Some(length) = what.strip_prefix("invalid length ").and_then(|t| t.split(',').next()) {
        return anyhow!("{key} has {length} numbers; it must have 3");
    }
    anyhow!("{what}")
}

/// JSON's name for serde's name of a type, or of a value with its type.
fn json_name(serde: &str) -> String {
    let value = ["integer `", "floating point `", "boolean `"].iter().find_map(|kind| serde.strip_prefix(kind));
    match (value.and_then(|v| v.strip_suffix('`')), serde) {
        (Some(value), _) => value.into(),
        (_, "f64") => "a number".into(),
        (_, "a nonzero u64") => "a whole number above 0".into(),
        (_, "struct Entry" | "struct StrikerEntry" | "map") => "an object {…}".into(),
        (_, "sequence") => "a list".into(),
        (_, t) if t.starts_with("an array of length 3") => "a list of 3 numbers".into(),
        (_, t) => t.strip_prefix("string ").map_or_else(|| t.to_owned(), |text| format!("the text {text}")),
    }
}

/// Writes a list of (point, displacement) as text, both m.
pub fn format(impacts: &[([f32; 3], [f32; 3])]) -> String {
    // Goes through the shortest text of an f32, so that the file shows 0.1, not 0.10000000149.
    let exact = |v: [f32; 3]| v.map(|c| c.to_string().parse::<f64>().unwrap_or(f64::from(c)));
    let line = |(i, (point, displacement)): (usize, &([f32; 3], [f32; 3]))| {
        let (point, displacement) = (exact(*point), exact(*displacement));
        format!("  {}", json!({ "name": format!("sample {i}"), "point": point, "displacement": displacement }))
    };
    format!("[\n{}\n]\n", impacts.iter().enumerate().map(line).collect::<Vec<_>>().join(",\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lists that are refused, and the messages. `P` stands for a point, `U` for a displacement.
    const REFUSED: &[(&str, &str)] = &[
        ("", "not JSON"),
        ("[{]", "not JSON: key must be a string at line 1 column 3"),
        ("{}", "the file is not a list of impacts, [{…}, …]"),
        ("[1]", "impact 0: the impact is 1; it must be an object {…}"),
        (r#"[{P, U}, {P, "displacment": [0,0,-1]}]"#, "impact 1: unknown field `displacment`, expected one of"),
        (r#"[{P, "displacment": [0,0,-1]}]"#, "`displacement`"),
        ("[{U}]", "impact 0: missing field `point`"),
        ("[{P}]", "impact 0: neither 'displacement' (m) nor 'impulse' (N s)"),
        (r#"[{P, U, "impulse": [0,0,1]}]"#, "both"),
        (r#"[{P, U, "mass": 1}]"#, "'mass' needs 'impulse'"),
        (r#"[{P, U, "striker": {}}]"#, "'striker' needs 'impulse'"),
        (r#"[{P, "striker": {"mass": 2}}]"#, "nor a 'striker' with 'mass' (kg) and 'velocity' (m/s)"),
        (r#"[{P, "striker": {"mass": 0, "velocity": [0,0,1]}}]"#, "striker.mass is 0; it must be above 0"),
        (r#"[{P, "impulse": [0,0,1], "striker": {"radius": -1}}]"#, "striker.radius is -1; it must be above 0"),
        (r#"[{P, "impulse": [0,0,1], "striker": {"velocity": [0,1e39,0]}}]"#, "striker.velocity[1] is 1e39"),
        (r#"[{P, "impulse": [0,0,1], "striker": 7}]"#, "striker is 7; it must be an object {…}"),
        (r#"[{P, "impulse": [0,0,1], "striker": {"speed": 7}}]"#, "unknown field `speed`"),
        (r#"[{P, "impulse": [0,0,1], "normal": [0,0,0]}]"#, "normal is [0, 0, 0]; it must be longer than 0"),
        (r#"[{"point": [0,0], U}]"#, "impact 0: point has 2 numbers; it must have 3"),
        (r#"[{"point": 7, U}]"#, "point is 7; it must be a list of 3 numbers"),
        (r#"[{P, U, "space": "wrold"}]"#, "unknown variant `wrold`, expected `local` or `world`"),
        (r#"[{P, U, "contact": 0}]"#, "contact is 0; it must be a whole number above 0"),
        ("[{P, P, U}]", "duplicate field `point`"),
        (r#"[{"point": [0,0,1e999], U}]"#, "impact 0: point[2]: 1e999 is out of range"),
        ("[\n{P, U},\n{P,\n\"displacement\": [0,-1e999,0]}]", "impact 1: displacement[1]: -1e999 is out of range"),
        (r#"[{"point": [0,4e38,0], U}]"#, "impact 0: point[1] is 4e38"),
        (r#"[{P, "impulse": [0,0,1], "duration": 0, "mass": 1}]"#, "duration is 0; it must be above 0"),
        (r#"[{P, "impulse": [0,0,1], "duration": 1, "mass": -2}]"#, "mass is -2; it must be above 0"),
        // below the smallest f32
        (r#"[{P, "impulse": [0,0,1], "duration": 1e-60, "mass": 1}]"#, "must be above 0"),
        (r#"[{"point": [0,0,NaN], U}]"#, "not JSON"),
        (r#"[{"point": [0,0,"1"], U}]"#, "impact 0: point[2] is the text \"1\"; it must be a number"),
        (r#"[{"point": [0,{},0], U}]"#, "point[1] is an object {…}; it must be a number"),
        (r#"[{"point": [0,true,0], U}]"#, "point[1] is true; it must be a number"),
        (r#"[{"point": [0,null,0], U}]"#, "point[1] is null; it must be a number"),
        (r#"[{"point": [0,[0],0], U}]"#, "point[1] is a list; it must be a number"),
    ];

    #[test]
    fn a_blow_is_read_and_what_is_not_given_is_unknown() {
        let json = r#"[{"point": [1,2,3], "normal": [0,0,2], "duration": 0.5, "mass": 8,
            "striker": {"mass": 2, "velocity": [0,1,-4], "radius": 0.25, "shape": "ball"}},
            {"point": [1,2,3], "impulse": [0,0,-1]}]"#;
        let hits: Vec<Hit> = parse(json).expect("good impacts").into_iter().map(|i| i.hit).collect();
        let striker = Striker {
            mass: Some(2.0),
            velocity: Some([0.0, 1.0, -4.0]),
            radius: Some(0.25),
            shape: StrikerShape::Ball,
        };
        let blow = Blow { impulse: None, duration: Some(0.5), normal: Some([0.0, 0.0, 2.0]), striker };
        assert_eq!(hits[0].cause, Cause::Impulse { blow, mass: Some(8.0) });
        let blow = Blow { impulse: Some([0.0, 0.0, -1.0]), ..Blow::default() };
        assert_eq!(hits[1].cause, Cause::Impulse { blow, mass: None });
    }

    #[test]
    fn refusals_name_the_impact_the_key_and_what_would_be_right() {
        for (json, part) in REFUSED {
            let json = json.replace('P', r#""point": [0,0,0]"#).replace('U', r#""displacement": [0,0,-1]"#);
            let error = format!("{:#}", parse(&json).expect_err(&json));
            assert!(error.contains(part), "'{part}' is not in: {error}");
        }
        let file = tempfile::NamedTempFile::new().expect("a file");
        std::fs::write(file.path(), b"[\xff]").expect("written");
        let error = read(file.path()).expect_err("not UTF-8").to_string();
        assert!(error.contains("not UTF-8 at byte 1"), "{error}");
    }
}
