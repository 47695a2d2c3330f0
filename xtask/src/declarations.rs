//! Reads the headers: the few forms of C that cbindgen writes, with their comments. Any other line is an error, so no declaration can
//! be missing from what is generated.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::LazyLock;

use anyhow::{Context, Result, bail, ensure};
use heck::ToShoutySnakeCase;
use regex_lite::{Captures, Regex};

pub mod csharp;
pub mod python;

pub const INCLUDE: &str = "include";
/// The headers, each after those that it includes: the first words of the parts of that file.
pub static HEADERS: LazyLock<Vec<&str>> =
    LazyLock::new(|| PARTS.split("\n\n").filter_map(|part| part.split([' ', ':']).next()).collect());

/// The headers in their order: what each includes, the files of `src` without their ends in the order in which their items are declared,
/// and the first lines of its opening comment, which crumple.h has in cbindgen.toml.
pub const PARTS: &str = include_str!("../headers.txt");

/// Headers of a folder as one text.
pub fn read(include: impl AsRef<Path>, headers: &[&str]) -> Result<String> {
    headers.iter().map(|name| crate::files::read(include.as_ref().join(name))).collect()
}

/// A C type: its name, the number of pointer stars, and the array length.
pub struct Type {
    pub base: String,
    pub pointers: usize,
    /// Only fields are arrays.
    pub array: Option<usize>,
}

pub struct Variable {
    pub name: String,
    pub kind: Type,
}

/// The name and the value of an enumerator.
pub type Variant = (String, String);

pub enum Form {
    Define(String),
    Enum(Vec<Variant>),
    /// A struct without a definition.
    Opaque,
    Struct(Vec<Variable>),
    /// A pointer to a function of the host: its result and parameters.
    Callback(Type, Vec<Variable>),
    Function(Type, Vec<Variable>),
}

pub struct Item {
    pub docs: Vec<String>,
    pub name: String,
    pub form: Form,
    /// The declaration as the header has it, with the comments inside it.
    pub text: String,
}

pub fn functions(text: &str) -> Result<Vec<Item>> {
    let mut items = header(text)?;
    items.retain(|item| matches!(item.form, Form::Function(..)));
    Ok(items)
}

/// Their names, of the headers of a folder.
pub fn names(include: impl AsRef<Path>) -> Result<BTreeSet<String>> {
    Ok(functions(&read(include, &HEADERS)?)?.into_iter().map(|item| item.name).collect())
}

/// What all enumerators of a type begin with: its own name where they do, as those of results do not.
fn prefix(name: &str, variants: &[Variant]) -> String {
    let own = name.to_shouty_snake_case() + "_";
    if variants.iter().all(|(name, _)| name.starts_with(&own)) { own } else { "CRUMPLE_".to_owned() }
}

/// The numbers of C, each with its name in C#.
const NUMBERS: &str = "float float double double size_t UIntPtr uint8_t byte uint16_t ushort uint32_t uint uint64_t ulong int32_t int \
                       int64_t long";

/// A number of C in C# and in Python's ctypes.
fn number(name: &str) -> Result<(&'static str, String)> {
    let mut words = NUMBERS.split(' ');
    while let (Some(c), Some(csharp)) = (words.next(), words.next()) {
        if c == name {
            return Ok((csharp, format!("c.c_{}", if c == "size_t" { c } else { c.trim_end_matches("_t") })));
        }
    }
    bail!("{name:?} is a type that is not declared")
}

pub fn declared<'a>(items: &'a [Item], name: &str) -> Option<&'a Form> {
    items.iter().find(|item| item.name == name).map(|item| &item.form)
}

/// Breaks a declaration after commas where it would be wider.
pub fn wrapped(declaration: &str, width: usize, indent: usize) -> String {
    let mut lines = vec![String::new()];
    for part in declaration.split_inclusive(", ") {
        if lines.last().is_some_and(|line| !line.is_empty() && line.len() + part.trim_end().len() > width) {
            lines.push(" ".repeat(indent));
        }
        lines.last_mut().into_iter().for_each(|line| *line += part);
    }
    lines.iter().map(|line| line.trim_end()).collect::<Vec<_>>().join("\n")
}

/// A declaration, after its comment.
const DECLARATION: &str =
    r"(?m)((?:^///.*\n)*)^(#define \w+ +.+|typedef (?:enum|struct) \w+ \{\n(?s:.*?)\n\} \w+;|[^\n#/{}][^;{}#]*;)\n";
/// Lines without a declaration.
const IGNORED: &str = r#"^(|//.*|#ifdef __cplusplus|extern "C" \{|\}  // extern.*|#ifndef CRUMPLE_.*|#define CRUMPLE_(\w*_)?H|#include .*|#endif.*)$"#;

/// Everything that the header declares, in header order.
pub fn header(text: &str) -> Result<Vec<Item>> {
    let (declaration, ignored) = (Regex::new(DECLARATION)?, Regex::new(IGNORED)?);
    let rest = declaration.replace_all(text, "");
    let unknown = rest.lines().find(|line| !ignored.is_match(line.trim()));
    ensure!(unknown.is_none(), "{unknown:?} is not what this reads");
    let item = |found: Captures<'_>| {
        let docs = found[1].lines().map(|line| line.trim_start_matches('/').trim().to_owned()).collect();
        let (name, form) = form(&found[2]).with_context(|| format!("{:?} is not what this reads", &found[2]))?;
        Ok(Item { docs, name, form, text: found[2].to_owned() })
    };
    declaration.captures_iter(text).map(item).collect()
}

fn form(text: &str) -> Result<(String, Form)> {
    let code: Vec<&str> = text.lines().map(str::trim).filter(|line| !line.starts_with("///")).collect();
    let code = code.join(" ");
    let parts = |pattern| -> Result<Option<[String; 3]>> {
        let found = Regex::new(pattern)?.captures(&code);
        Ok(found.map(|found| [1, 2, 3].map(|part| found.get(part).map_or("", |part| part.as_str()).to_owned())))
    };
    if let Some([name, value, _]) = parts(r"^#define (\w+) +(.+)$")? {
        Ok((name, Form::Define(value)))
    } else if let Some([list, name, _]) = parts(r"^typedef enum \w+ \{ (.*?),? \} (\w+);$")? {
        let variant = |text: &str| text.trim().split_once(" = ").map(|(name, value)| (name.into(), value.into()));
        let variants = list.split(',').map(variant).collect::<Option<_>>().context("an enumerator has no value")?;
        Ok((name, Form::Enum(variants)))
    } else if let Some([list, name, _]) = parts(r"^typedef struct \w+ \{ (.*); \} (\w+);$")? {
        Ok((name, Form::Struct(list.split(';').map(variable).collect::<Result<_>>()?)))
    } else if let Some([name, again, _]) = parts(r"^typedef struct (\w+) (\w+);$")? {
        ensure!(name == again, "{name} and {again} should be one name");
        Ok((name, Form::Opaque))
    } else if let Some([result, name, list]) = parts(r"^typedef (.+)\(\*(\w+)\)\((.+)\);$")? {
        Ok((name, Form::Callback(variable(&format!("{result} result"))?.kind, parameters(&list)?)))
    } else {
        let [function, list, _] = parts(r"^(.+)\((.+)\);$")?.context("no declaration")?;
        let Variable { name, kind: result } = variable(&function)?;
        Ok((name, Form::Function(result, parameters(&list)?)))
    }
}

fn parameters(list: &str) -> Result<Vec<Variable>> {
    if list == "void" { Ok(Vec::new()) } else { list.split(',').map(variable).collect() }
}

/// `const T *name[4]`.
fn variable(text: &str) -> Result<Variable> {
    static FORM: LazyLock<Regex> = LazyLock::new(|| {
        Regex::new(r"^(?:const )?(\w+)((?: |\*|const)*[ *])(\w+)(?:\[(\d+)\])?$").expect("a regular expression")
    });
    let found = FORM.captures(text.trim()).with_context(|| format!("{text:?} is no type and name that this reads"))?;
    let array = found.get(4).map(|length| length.as_str().parse()).transpose()?;
    let kind = Type { base: found[1].to_owned(), pointers: found[2].matches('*').count(), array };
    Ok(Variable { name: found[3].to_owned(), kind })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_understood_is_an_error() {
        for text in
            ["int x = 3;\n", "typedef union {\n    int a;\n} U;\n", "void crumple_f(int (*g)(void));\n", "void f(int\n"]
        {
            assert!(header(text).is_err(), "{text}");
        }
    }
}
