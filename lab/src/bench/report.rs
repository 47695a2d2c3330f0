//! What a run found: rows for a person, for a machine (JSON), and to be committed (CSV).

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use serde_json::{Value, json};

use super::measure::Times;
use crate::machine::Machine;
use crate::table::{Table, num};

/// What a value is held against.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sense {
    /// Ratio is reference over value: how many times as fast.
    Speed,
    /// Ratio is value over reference: how many times as much time or memory.
    Cost,
}

impl Sense {
    fn name(self) -> &'static str {
        match self {
            Sense::Speed => "speed",
            Sense::Cost => "cost",
        }
    }
}

/// What a row should reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Aim {
    /// The ratio at least, with [`Sense::Speed`].
    AtLeast(f64),
    /// The ratio at most, with [`Sense::Cost`].
    AtMost(f64),
    /// The value itself at most, in its unit.
    Value(f64),
}

/// One result.
#[derive(Debug, Clone)]
pub struct Row {
    pub name: String,
    pub value: f64,
    pub unit: &'static str,
    /// Its name, and its value in the same unit, from the same run.
    pub reference: Option<(String, f64)>,
    pub sense: Sense,
    pub aim: Option<Aim>,
    /// Whether the aim is for what was measured here; otherwise it is shown alone.
    pub judged: bool,
    /// xxh3 of the bits of what was computed.
    pub hash: Option<u64>,
    /// Least, first and third quartile, in the unit, and how many runs.
    pub spread: Option<([f64; 3], usize)>,
}

impl Row {
    pub fn new(name: impl Into<String>, value: f64, unit: &'static str) -> Self {
        let (sense, judged) = (Sense::Cost, true);
        Row { name: name.into(), value, unit, reference: None, sense, aim: None, judged, hash: None, spread: None }
    }

    /// The median of `times`, shown in `unit` (s, ms, µs or ns).
    pub fn time(name: impl Into<String>, times: &Times, unit: &'static str) -> Self {
        let f = per_second(unit);
        Row {
            spread: Some(([0.0, 0.25, 0.75].map(|q| f * times.quantile(q)), times.runs())),
            ..Self::new(name, f * times.median(), unit)
        }
    }

    /// Beside a reference in the same unit.
    pub fn beside(self, name: impl Into<String>, value: f64, sense: Sense) -> Self {
        Row { reference: Some((name.into(), value)), sense, ..self }
    }

    /// Beside the median of other times.
    pub fn beside_time(self, name: impl Into<String>, times: &Times, sense: Sense) -> Self {
        let value = per_second(self.unit) * times.median();
        self.beside(name, value, sense)
    }

    pub fn aim(self, aim: Aim) -> Self {
        Row { aim: Some(aim), ..self }
    }

    pub fn hash(self, hash: u64) -> Self {
        Row { hash: Some(hash), ..self }
    }

    pub fn ratio(&self) -> Option<f64> {
        let (_, reference) = self.reference.as_ref()?;
        Some(match self.sense {
            Sense::Speed => reference / self.value,
            Sense::Cost => self.value / reference,
        })
    }

    /// Whether the aim is met; `None` without one, or where it is not judged.
    pub fn met(&self) -> Option<bool> {
        Some(match self.aim.filter(|_| self.judged)? {
            Aim::AtLeast(least) => self.ratio()? >= least,
            Aim::AtMost(most) => self.ratio()? <= most,
            Aim::Value(most) => self.value <= most,
        })
    }

    /// What the ratio is.
    pub fn ratio_text(&self) -> &'static str {
        match (&self.reference, self.sense) {
            (None, _) => "",
            (_, Sense::Speed) => "reference / value",
            (_, Sense::Cost) => "value / reference",
        }
    }

    pub fn aim_text(&self) -> String {
        match self.aim {
            None => String::new(),
            Some(Aim::AtLeast(x)) => format!(">= {} x", num(x)),
            Some(Aim::AtMost(x)) => format!("<= {} x", num(x)),
            Some(Aim::Value(x)) => format!("<= {} {}", num(x), self.unit),
        }
    }

    pub fn met_text(&self) -> &'static str {
        match self.met() {
            None if self.aim.is_some() => "shown",
            None => "",
            Some(true) => "yes",
            Some(false) => "NO",
        }
    }
}

/// Of `unit`, how many make a second.
fn per_second(unit: &str) -> f64 {
    match unit.split('/').next() {
        Some("ms") => 1e3,
        Some("µs") => 1e6,
        Some("ns") => 1e9,
        _ => 1.0,
    }
}

/// The rows so far, printed as they come.
#[derive(Debug, Default)]
pub struct Report {
    rows: Vec<Row>,
    /// Heads of a group that has no rows yet.
    head: Option<String>,
}

impl Report {
    /// What the rows that follow are; printed with the first of them.
    pub fn group(&mut self, name: &str, about: &str) {
        let head = ["name", "value", "unit", "reference", "", "ratio", "aim", "met", "hash"].map(str::to_owned);
        self.head = Some(format!("\n{name}: {about}\n{}", line(&head)));
    }

    pub fn add(&mut self, row: Row) {
        let (reference, beside) = row.reference.clone().map_or_else(Default::default, |(n, v)| (n, short(v)));
        let cells = [
            row.name.clone(),
            short(row.value),
            row.unit.to_owned(),
            reference,
            beside,
            row.ratio().map_or_else(String::new, |r| format!("{r:.2} x {}", row.sense.name())),
            row.aim_text(),
            row.met_text().to_owned(),
            row.hash.map_or_else(String::new, |h| format!("{h:016x}")),
        ];
        if let Some(head) = self.head.take() {
            println!("{head}");
        }
        println!("{}", line(&cells));
        self.rows.push(row);
    }

    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// How many aims there are, and which are missed.
    pub fn summary(&self) {
        let missed: Vec<&Row> = self.rows.iter().filter(|r| r.met() == Some(false)).collect();
        let aims = self.rows.iter().filter(|r| r.met().is_some()).count();
        println!("\n{} of {aims} aims are met; {} rows", aims - missed.len(), self.rows.len());
        let shown = self.rows.iter().filter(|r| r.aim.is_some() && !r.judged).count();
        if shown > 0 {
            println!("  {shown} more are for real graphics cards and are shown alone");
        }
        for row in missed {
            let ratio = row.ratio().map_or_else(String::new, |r| format!("{r:.2} x {}", row.sense.name()));
            println!(
                "  missed: {:36} {:>10} {:9} {ratio:>14}  {}",
                row.name,
                short(row.value),
                row.unit,
                row.aim_text()
            );
        }
    }

    /// An array of objects, each with `name`, `value`, `unit`, `reference` (in the unit; null where there is none) and
    /// `ratio` (null likewise).
    pub fn json(&self) -> Value {
        let row = |r: &Row| {
            json!({
                "name": r.name,
                "value": r.value,
                "unit": r.unit,
                "reference": r.reference.as_ref().map(|(_, v)| v),
                "ratio": r.ratio(),
            })
        };
        Value::Array(self.rows.iter().map(row).collect())
    }

    pub fn write_json(&self, path: &Path) -> Result<()> {
        let text = serde_json::to_string_pretty(&self.json())?;
        fs::write(path, text + "\n").with_context(|| format!("writing {}", path.display()))
    }

    /// `directory/MACHINE.csv`.
    pub fn write_csv(&self, directory: &Path, recipe: &str) -> Result<PathBuf> {
        let mut table = Table::threaded(&[
            "name",
            "value",
            "least",
            "p25",
            "p75",
            "runs",
            "unit",
            "reference",
            "reference_value",
            "ratio",
            "ratio_is",
            "aim",
            "met",
            "hash",
        ]);
        table.comment("command", recipe);
        for r in &self.rows {
            let ([least, low, high], runs) = r.spread.unwrap_or(([f64::NAN; 3], 0));
            let (reference, value) = r.reference.clone().unwrap_or((String::new(), f64::NAN));
            table.row([
                r.name.clone(),
                num(r.value),
                num(least),
                num(low),
                num(high),
                if runs == 0 { String::new() } else { runs.to_string() },
                r.unit.to_owned(),
                reference,
                num(value),
                num(r.ratio().unwrap_or(f64::NAN)),
                r.ratio_text().to_owned(),
                r.aim_text(),
                r.met_text().to_lowercase(),
                r.hash.map_or_else(String::new, |h| format!("{h:016x}")),
            ])?;
        }
        table.write(directory, &format!("{}.csv", file_name(&Machine::here())))
    }
}

/// The machine's name as a file may have it.
fn file_name(machine: &Machine) -> String {
    let text = format!("{} {} cores {}", machine.cpu, machine.cores, std::env::consts::OS).to_lowercase();
    text.split(|c: char| !c.is_ascii_alphanumeric()).filter(|w| !w.is_empty()).collect::<Vec<_>>().join("-")
}

fn line(cells: &[String; 9]) -> String {
    let [name, value, unit, reference, beside, ratio, aim, met, hash] = cells;
    let text =
        format!("  {name:36} {value:>10} {unit:10} {reference:>14} {beside:>10} {ratio:>14}  {aim:16} {met:5} {hash}");
    text.trim_end().to_owned()
}

/// Four digits for the eye.
fn short(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return num(x);
    }
    let digits = (3 - x.abs().log10().floor() as i32).clamp(0, 9) as usize;
    format!("{x:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row() -> Row {
        Row::time("a", &Times::new(vec![0.001, 0.002, 0.003]), "ms")
    }

    #[test]
    fn ratios_say_what_aims_ask_for() {
        let fast = row().beside("classic", 6.0, Sense::Speed).aim(Aim::AtLeast(2.5));
        assert_eq!((fast.value, fast.ratio(), fast.met()), (2.0, Some(3.0), Some(true)));
        let slow = row().beside_time("one", &Times::new(vec![0.001]), Sense::Cost).aim(Aim::AtMost(1.5));
        assert_eq!((slow.ratio(), slow.met()), (Some(2.0), Some(false)));
        assert_eq!(row().aim(Aim::Value(2.0)).met(), Some(true));
        assert_eq!((row().ratio(), row().met()), (None, None));
    }

    #[test]
    fn json_is_an_array_of_objects_with_five_keys() {
        let mut report = Report::default();
        report.add(row().beside("classic", 6.0, Sense::Speed));
        report.add(row());
        let json: Value = serde_json::from_str(&report.json().to_string()).unwrap();
        for entry in json.as_array().unwrap() {
            let keys: Vec<&String> = entry.as_object().unwrap().keys().collect();
            assert_eq!(keys.len(), 5);
            assert!(["name", "value", "unit", "reference", "ratio"].iter().all(|k| keys.iter().any(|have| have == k)));
        }
        assert_eq!(json[0]["reference"], 6.0);
        assert!(json[1]["ratio"].is_null());
    }

    #[test]
    fn a_machine_has_a_plain_file_name() {
        let machine = Machine { cpu: "Intel(R) Xeon(R) (family 6)".into(), cores: 2 };
        assert!(file_name(&machine).starts_with("intel-r-xeon-r-family-6-2-cores-"));
    }
}
