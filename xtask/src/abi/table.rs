//! The facts of a header, one a line, and how two such tables differ.

use std::collections::BTreeMap;

const HEAD: &str = "\
# What programs that are built against include/crumple.h rely on, in bytes, on 64-bit machines. Written by `cargo xtask abi` from the
# header, through a C compiler; compared in CI. docs/abi.md says what may change.
";

/// Lines by what they are about: `struct CrumpleVec3 field x` is `offset 0 size 4 float`.
#[derive(Debug, PartialEq, Eq)]
pub struct Table(BTreeMap<String, String>);

/// What one table says and another does not.
pub struct Changes(Vec<Change>);

enum Change {
    Gone { name: String },
    Other { name: String, was: String, is: String },
    New { name: String, is: String },
}

impl Table {
    pub fn from_text(text: &str) -> Self {
        let lines = text.lines().filter(|line| !line.starts_with('#') && !line.trim().is_empty());
        Self(lines.map(split).map(|(name, fact)| (name.to_owned(), fact.to_owned())).collect())
    }

    pub fn to_text(&self) -> String {
        let lines: String =
            self.0.iter().map(|(name, fact)| format!("{name} {fact}").trim_end().to_owned() + "\n").collect();
        format!("{HEAD}{lines}")
    }

    pub fn len(&self) -> usize {
        self.0.len()
    }

    pub fn changes(&self, present: &Self) -> Changes {
        let mut changes = Vec::new();
        for (name, was) in &self.0 {
            match present.0.get(name) {
                None => changes.push(Change::Gone { name: name.clone() }),
                Some(is) if is != was => {
                    changes.push(Change::Other { name: name.clone(), was: was.clone(), is: is.clone() });
                }
                Some(_) => {}
            }
        }
        for (name, is) in present.0.iter().filter(|(name, _)| !self.0.contains_key(*name)) {
            changes.push(Change::New { name: name.clone(), is: is.clone() });
        }
        Changes(changes)
    }
}

/// What a line is about, and what it says of that.
fn split(line: &str) -> (&str, &str) {
    let member = line.split(' ').nth(2).is_some_and(|word| ["field", "value"].contains(&word));
    let words = if member { 4 } else { 2 };
    line.match_indices(' ').nth(words - 1).map_or((line, ""), |(at, _)| (&line[..at], &line[at + 1..]))
}

impl Changes {
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Those that a program notices which was built before them. What is new it does not know; what was reserved it does not touch.
    pub fn breaks(self) -> Self {
        let harmless = |change: &Change| match change {
            Change::New { .. } => true,
            Change::Gone { name } | Change::Other { name, .. } => name.contains(" field reserved"),
        };
        Self(self.0.into_iter().filter(|change| !harmless(change)).collect())
    }

    /// `of`: what says what was.
    pub fn print(&self, of: &str) {
        for change in &self.0 {
            match change {
                Change::Gone { name } => println!("{name} is gone; {of} has it"),
                Change::Other { name, was, is } => println!("{name} is now: {is}; {of} has: {was}"),
                Change::New { name, is } => println!("{name} is new: {is}"),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OLD: &str = "# Told.\nconstant CRUMPLE_FEATURE_OBJ = 2\nenum CrumpleResult size 4\nenum CrumpleResult value CRUMPLE_OK = 0\n\
        function crumple_go CrumpleResult (CrumpleContext*)\nopaque CrumpleContext\nstruct CrumpleInfo field a offset 0 size 4 float\n\
        struct CrumpleInfo field reserved offset 4 size 12 uint32_t[3]\nstruct CrumpleInfo size 16 align 4\n";

    fn breaks(from: &str, to: &str) -> usize {
        Table::from_text(OLD).changes(&Table::from_text(&OLD.replace(from, to))).breaks().0.len()
    }

    #[test]
    fn a_table_is_read_as_it_was_written() {
        let table = Table::from_text(OLD);
        assert_eq!(table.len(), 8);
        assert_eq!(Table::from_text(&table.to_text()), table);
        assert!(table.changes(&table).is_empty());
    }

    #[test]
    fn what_a_program_knew_may_not_change() {
        assert_eq!(breaks("a offset 0", "a offset 8"), 1);
        assert_eq!(breaks("field a", "field b"), 1);
        assert_eq!(breaks("CRUMPLE_OK = 0", "CRUMPLE_OK = 1"), 1);
        assert_eq!(breaks("size 16", "size 24"), 1);
        assert_eq!(breaks("(CrumpleContext*)", "(CrumpleContext*, int)"), 1);
        assert_eq!(breaks("function crumple_go", "function crumple_stop"), 1);
    }

    #[test]
    fn what_is_new_or_was_reserved_breaks_nothing() {
        assert_eq!(breaks("opaque", "function crumple_new void (void)\nopaque"), 0);
        assert_eq!(breaks("CRUMPLE_OK = 0", "CRUMPLE_OK = 0\nenum CrumpleResult value CRUMPLE_BAD = 1"), 0);
        let used = "field b offset 4 size 4 float\nstruct CrumpleInfo field reserved offset 8 size 8 uint32_t[2]";
        assert_eq!(breaks("field reserved offset 4 size 12 uint32_t[3]", used), 0);
    }
}
