//! Plain text tables.

use std::fmt::Write;

/// Columns are as wide as their widest cell.
pub struct Table {
    heads: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A head that begins with `>` right-aligns its column.
    pub fn new(heads: &[&str]) -> Table {
        Table { heads: heads.iter().map(|&h| h.to_owned()).collect(), rows: Vec::new() }
    }

    pub fn row(&mut self, cells: Vec<String>) {
        self.rows.push(cells.iter().map(|cell| plain(cell)).collect());
    }

    /// Appends the table to `text`, each line indented by two spaces.
    pub fn write(&self, text: &mut String) {
        let (right, heads): (Vec<bool>, Vec<&str>) =
            self.heads.iter().map(|h| h.strip_prefix('>').map_or((false, h.as_str()), |h| (true, h))).unzip();
        let width = |column: usize| {
            let cells = self.rows.iter().filter_map(|r| r.get(column));
            cells.map(|c| c.chars().count()).chain([heads[column].chars().count()]).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..heads.len()).map(width).collect();
        let mut line = |cells: &mut dyn Iterator<Item = &str>| {
            let mut out = String::from(" ");
            for ((cell, &width), &right) in cells.zip(&widths).zip(&right) {
                let _ = if right { write!(out, " {cell:>width$} ") } else { write!(out, " {cell:<width$} ") };
            }
            text.push_str(out.trim_end());
            text.push('\n');
        };
        line(&mut heads.iter().copied());
        for row in &self.rows {
            line(&mut row.iter().map(String::as_str));
        }
    }
}

/// A text on one line. A name may hold anything; line breaks and control characters would break a table.
pub fn plain(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// A point in metres, with millimetre precision.
pub fn point(p: impl Into<[f32; 3]>) -> String {
    let [x, y, z] = p.into().map(|c| format!("{:.3}", if c.abs() < 5e-4 { 0.0 } else { c }));
    format!("({x}, {y}, {z})")
}

/// A count with its noun: `1 hit`, `2 hits`.
pub fn count(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// A count of vertices.
pub fn vertices(n: usize) -> String {
    count(n, "vertex", "vertices")
}

/// A number with at most four significant digits.
pub fn digits(x: f32) -> String {
    format!("{x:.3e}").parse().map_or_else(|_| x.to_string(), |rounded: f32| rounded.to_string())
}

/// A share as a percentage. It shows 0 and 100 only if they are exact.
pub fn percent(part: f64, whole: f64) -> String {
    let p = if whole > 0.0 { 100.0 * part / whole } else { 0.0 };
    match p {
        p if p > 0.0 && p < 0.1 => "under 0.1 %".into(),
        p if p < 100.0 && p > 99.9 => "over 99.9 %".into(),
        p => format!("{p:.1} %"),
    }
}
