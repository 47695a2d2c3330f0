//! Lengths, masses and angles with their units, as options give them.

/// Splits a text into a number and the rest.
fn split(text: &str) -> (Option<f64>, &str) {
    let text = text.trim();
    // The longest prefix that is a number: "1e-4m" is 1e-4 and metres, "5e" is 5 and an unknown unit.
    let ends = (1..=text.len()).rev().filter(|at| text.is_char_boundary(*at));
    let number = |at: &usize| text[..*at].bytes().all(|b| b"0123456789+-.eE".contains(&b));
    ends.filter(number)
        .find_map(|at| text[..at].parse().ok().map(|n| (Some(n), text[at..].trim_start())))
        .unwrap_or((None, text))
}

pub fn length(text: &str) -> Result<f32, String> {
    const UNITS: [(&str, f64); 8] =
        [("um", 1e-6), ("µm", 1e-6), ("mm", 1e-3), ("cm", 1e-2), ("m", 1.0), ("in", 0.0254), ("ft", 0.3048), ("", 1.0)];
    quantity(text, &UNITS, ("length", "0.1mm"), "um, mm, cm, m, in or ft, or none for metres")
}

/// The length of a unit: a length, or the name of a unit alone.
pub fn unit(text: &str) -> Result<f32, String> {
    match length(&format!("1{}", text.trim())) {
        Ok(one) if split(text).0.is_none() && !text.trim().is_empty() => Ok(one),
        _ => length(text),
    }
}

pub fn mass(text: &str) -> Result<f32, String> {
    const UNITS: [(&str, f64); 4] = [("g", 1e-3), ("kg", 1.0), ("lb", 0.453_592_37), ("", 1.0)];
    quantity(text, &UNITS, ("mass", "0.5kg"), "g, kg or lb, or none for kilograms")
}

/// Parses a number above 0 with one of these units.
fn quantity(text: &str, units: &[(&str, f64)], (noun, example): (&str, &str), names: &str) -> Result<f32, String> {
    let (Some(number), unit) = split(text) else {
        return Err(format!("it must be a {noun}, such as {example}"));
    };
    let Some((_, factor)) = units.iter().find(|u| u.0 == unit) else {
        return Err(format!("'{unit}' is no unit of {noun} here; give {names}"));
    };
    let value = (number * factor) as f32;
    if value > 0.0 && value.is_finite() { Ok(value) } else { Err("it must be above 0 and finite".into()) }
}

pub fn angle(text: &str) -> Result<f32, String> {
    let (Some(number), unit) = split(text) else {
        return Err("it must be an angle, such as 1deg".into());
    };
    let degrees = match unit {
        "" | "deg" | "°" => number,
        "rad" => number.to_degrees(),
        _ => return Err(format!("'{unit}' is no unit of angle here; give deg or rad, or none for degrees")),
    } as f32;
    if degrees > 0.0 && degrees <= 45.0 { Ok(degrees) } else { Err("it must be above 0 and at most 45 degrees".into()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(parse: fn(&str) -> Result<f32, String>, good: &[(&str, f32)], bad: &[&str]) {
        for (text, value) in good {
            assert_eq!(parse(text), Ok(*value), "{text}");
        }
        for text in bad {
            assert!(parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn numbers_have_units() {
        let tenths = ["0.1mm", "100 um", "100µm", "1e-4", "1e-4m", "0.01cm"].map(|text| (text, 1e-4));
        let lengths = [&tenths[..], &[("1in", 0.0254), (" 2m ", 2.0)]].concat();
        check(length, &lengths, &["", "mm", "0", "-1mm", "nan", "inf", "1km", "0,1mm", "1 mm mm", "1e99m", "1e"]);
        assert!(length("3yd").unwrap_err().contains("'yd'"));
        // A unit may stand alone.
        let units = [("cm", 0.01), (" mm ", 0.001), ("ft", 0.3048), ("m", 1.0), ("0.01", 0.01)];
        check(unit, &[&lengths[..], &units].concat(), &["", "cubit", "0cm", "-cm"]);
        let masses = [("0.5", 0.5), ("500g", 0.5), ("0.5 kg", 0.5), ("2lb", 0.907_184_7)];
        check(mass, &masses, &["", "kg", "0", "-1kg", "nan", "inf", "1mm", "1e99kg"]);
        let angles = [("1", 1.0), ("2deg", 2.0), ("0.5rad", 0.5f64.to_degrees() as f32)];
        check(angle, &angles, &["0", "46", "1rad", "1mm", "", "nan"]);
    }
}
