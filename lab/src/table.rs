//! CSV files: comments that say where the figures are from, a header, rows.

use std::fmt::Display;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};

use crate::machine::Machine;

/// A table that becomes a file. Columns carry their unit in their name.
pub struct Table {
    comments: Vec<(String, String)>,
    columns: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// With the machine and the versions on top, of costs on one thread.
    pub fn new(columns: &[&str]) -> Self {
        Self::of_costs(columns, "every cost is that of one thread")
    }

    /// The same of costs on as many threads as the rows say.
    pub fn threaded(columns: &[&str]) -> Self {
        Self::of_costs(columns, "threads as the rows say")
    }

    fn of_costs(columns: &[&str], threads: &str) -> Self {
        let mut table =
            Self { comments: Vec::new(), columns: columns.iter().map(|c| (*c).to_owned()).collect(), rows: Vec::new() };
        for (key, value) in Machine::here().comments(threads) {
            table.comment(key, value);
        }
        table
    }

    /// Adds a line `# key: value` above the header.
    pub fn comment(&mut self, key: impl Display, value: impl Display) {
        self.comments.push((key.to_string(), value.to_string()));
    }

    /// Adds a row: as many cells as there are columns ([`num`] writes numbers).
    ///
    /// # Errors
    /// Where there are not.
    pub fn row(&mut self, cells: impl IntoIterator<Item = impl Display>) -> Result<()> {
        let row: Vec<String> = cells.into_iter().map(|c| c.to_string()).collect();
        ensure!(row.len() == self.columns.len(), "{} cells for the columns {:?}", row.len(), self.columns);
        self.rows.push(row);
        Ok(())
    }

    /// Writes `directory/file`, and makes the directory where it is missing.
    pub fn write(&self, directory: &Path, file: &str) -> Result<PathBuf> {
        let path = directory.join(file);
        let mut text = Vec::new();
        for (key, value) in &self.comments {
            writeln!(text, "# {key}: {value}")?;
        }
        let mut writer = csv::Writer::from_writer(text);
        writer.write_record(&self.columns)?;
        for row in &self.rows {
            writer.write_record(row)?;
        }
        let text = writer.into_inner().context("writing to memory")?;
        fs::create_dir_all(directory).with_context(|| format!("creating {}", directory.display()))?;
        fs::write(&path, text).with_context(|| format!("writing {}", path.display()))?;
        Ok(path)
    }
}

/// A number in at most five significant digits; empty for NaN.
pub fn num(x: f64) -> String {
    if x.is_nan() {
        return String::new();
    }
    if x == 0.0 || !x.is_finite() {
        return format!("{x}");
    }
    let digits = (4 - x.abs().log10().floor() as i32).clamp(0, 12) as usize;
    if x.abs() >= 1e9 || x.abs() < 1e-8 {
        return format!("{x:.4e}");
    }
    let text = format!("{x:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_five_digits() {
        assert_eq!(num(0.123456), "0.12346");
        assert_eq!(num(123456.7), "123457");
        assert_eq!(num(2.5), "2.5");
        assert_eq!(num(100.0), "100");
        assert_eq!(num(1e-12), "1.0000e-12");
        assert_eq!(num(f64::NAN), "");
        assert_eq!(num(f64::INFINITY), "inf");
    }

    #[test]
    fn a_row_must_fill_the_columns() {
        let mut table = Table::new(&["a", "b_mm"]);
        assert!(table.row(["1", "2"]).is_ok());
        assert!(table.row(["1"]).is_err());
    }
}
