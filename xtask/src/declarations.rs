//! Reads the headers: the few forms of C that cbindgen writes, with their comments. Any other line is an error, so no declaration can
//! be missing from what is generated.

pub mod csharp;
pub mod python;

use std::path::Path;

use anyhow::{Context, Result, bail};

use crate::files;

/// The folder of the headers.
pub const INCLUDE: &str = "include";
/// The headers, each after those that it includes.
pub const HEADERS: &[&str] = &[
    "crumple.h",
    "crumple_build.h",
    "crumple_import.h",
    "crumple_parts.h",
    "crumple_contacts.h",
    "crumple_view.h",
    "crumple_host.h",
    "crumple_vulkan.h",
    "crumple_graph.h",
];

/// The headers of a folder as one text.
pub fn read(include: &Path) -> Result<String> {
    read_these(include, HEADERS)
}

/// Some of the headers, each after those that it includes.
pub fn read_these(include: &Path, names: &[&str]) -> Result<String> {
    Ok(joined(&names.iter().map(|name| files::read(&include.join(name))).collect::<Result<Vec<_>>>()?))
}

/// Headers, each after those that it includes, as one text.
pub fn joined(headers: &[String]) -> String {
    let lines = headers.iter().flat_map(|text| text.lines()).filter(|line| !line.starts_with("#include \""));
    lines.flat_map(|line| [line, "\n"]).collect()
}

/// A C type: its name, the number of pointer stars, and the array length.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Type {
    pub base: String,
    pub pointers: usize,
    /// Only fields are arrays.
    pub array: Option<usize>,
}

/// A field or a parameter.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Variable {
    pub name: String,
    pub kind: Type,
}

#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Variant {
    pub name: String,
    pub value: String,
}

#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Form {
    Define {
        value: String,
    },
    Enum {
        variants: Vec<Variant>,
    },
    /// A struct without a definition.
    Opaque,
    Struct {
        fields: Vec<Variable>,
    },
    /// A pointer to a function of the host.
    Callback {
        result: Type,
        parameters: Vec<Variable>,
    },
    Function {
        result: Type,
        parameters: Vec<Variable>,
    },
}

#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Item {
    pub docs: Vec<String>,
    pub name: String,
    pub form: Form,
    /// The declaration as the header has it, with the comments inside it.
    pub text: String,
}

/// The functions that the header declares.
pub fn functions(text: &str) -> Result<Vec<Item>> {
    let mut items = header(text)?;
    items.retain(|item| matches!(item.form, Form::Function { .. }));
    Ok(items)
}

/// What all enumerators of a type begin with: its own name where they do, as those of results do not.
fn prefix(name: &str, variants: &[Variant]) -> String {
    let mut own = String::new();
    for letter in name.chars() {
        if letter.is_ascii_uppercase() && !own.is_empty() {
            own.push('_');
        }
        own.push(letter.to_ascii_uppercase());
    }
    own.push('_');
    if variants.iter().all(|variant| variant.name.starts_with(&own)) { own } else { "CRUMPLE_".to_owned() }
}

/// Everything that the header declares, in header order.
pub fn header(text: &str) -> Result<Vec<Item>> {
    let mut lines = text.lines().enumerate();
    let mut items = Vec::new();
    let mut docs = Vec::new();
    while let Some((number, line)) = lines.next() {
        let trimmed = line.trim();
        if let Some(text) = trimmed.strip_prefix("///") {
            docs.push(text.trim().to_owned());
            continue;
        }
        if ignored(trimmed) {
            continue;
        }
        // A declaration ends with a semicolon; one with braces ends with the closing brace and a semicolon.
        let mut declaration = vec![line];
        if !trimmed.starts_with("#define") {
            let braced = trimmed.ends_with('{');
            while !declaration.last().is_some_and(|last| {
                let last = last.trim();
                last.ends_with(';') && (!braced || last.starts_with('}'))
            }) {
                let (_, next) = lines.next().with_context(|| format!("line {}: {trimmed} has no end", number + 1))?;
                declaration.push(next);
            }
        }
        let (name, form) = item(&declaration).with_context(|| format!("line {}: {trimmed}", number + 1))?;
        items.push(Item { docs: std::mem::take(&mut docs), name, form, text: declaration.join("\n") });
    }
    Ok(items)
}

fn ignored(line: &str) -> bool {
    const LINES: &[&str] = &["", "#ifdef __cplusplus", "extern \"C\" {"];
    LINES.contains(&line)
        || line.starts_with("//")
        || line.starts_with("#ifndef CRUMPLE_")
        || line.starts_with("#define CRUMPLE_") && line.ends_with("_H")
        || line.starts_with("#include <std")
        || line.starts_with("#endif")
        || line.starts_with("}  // extern")
}

fn item(lines: &[&str]) -> Result<(String, Form)> {
    let first = lines[0].trim();
    if let Some(define) = first.strip_prefix("#define ") {
        let (name, value) = define.split_once(' ').context("a #define without a value")?;
        return Ok((name.to_owned(), Form::Define { value: value.trim().to_owned() }));
    }
    let opens = |kind: &str| first.starts_with(&format!("typedef {kind} ")) && first.ends_with(" {");
    if opens("enum") || opens("struct") {
        let (last, body) = lines[1..].split_last().context("it has no body")?;
        let name = last.trim().trim_start_matches('}').trim_end_matches(';').trim().to_owned();
        let form = if opens("enum") {
            Form::Enum { variants: variants(body)? }
        } else {
            Form::Struct { fields: fields(body)? }
        };
        return Ok((name, form));
    }
    let whole = lines.iter().map(|line| line.trim()).collect::<Vec<_>>().join(" ");
    let whole = whole.trim_end_matches(';');
    if let Some(rest) = whole.strip_prefix("typedef struct ") {
        let (name, again) = rest.split_once(' ').context("a struct without a name")?;
        if name != again {
            bail!("{name} and {again} should be one name");
        }
        return Ok((name.to_owned(), Form::Opaque));
    }
    let parameters = |list: &str| -> Result<Vec<Variable>> {
        if list == "void" { Ok(Vec::new()) } else { list.split(',').map(variable).collect() }
    };
    if let Some(rest) = whole.strip_prefix("typedef ") {
        let (before, rest) = rest.split_once("(*").context("neither enum, struct nor callback")?;
        let (name, list) = rest.split_once(")(").context("a callback without parameters")?;
        let result = variable(&format!("{before} result"))?.kind;
        let list = list.strip_suffix(')').context("a callback without an end")?;
        return Ok((name.to_owned(), Form::Callback { result, parameters: parameters(list)? }));
    }
    let (before, list) = whole.split_once('(').context("not a declaration that this reads")?;
    let Variable { name, kind: result } = variable(before)?;
    let list = list.strip_suffix(')').context("a function without an end")?;
    Ok((name, Form::Function { result, parameters: parameters(list)? }))
}

/// The lines of a body without comments.
fn code<'a>(lines: &'a [&str]) -> impl Iterator<Item = &'a str> {
    lines.iter().map(|line| line.trim()).filter(|line| !line.starts_with("///"))
}

fn variants(lines: &[&str]) -> Result<Vec<Variant>> {
    let variant = |line: &str| {
        let (name, value) =
            line.trim_end_matches(',').split_once(" = ").with_context(|| format!("{line:?} has no value"))?;
        Ok(Variant { name: name.to_owned(), value: value.to_owned() })
    };
    code(lines).map(variant).collect()
}

fn fields(lines: &[&str]) -> Result<Vec<Variable>> {
    let field = |line: &str| variable(line.strip_suffix(';').with_context(|| format!("{line:?} has no semicolon"))?);
    code(lines).map(field).collect()
}

/// `const T *name[4]`, without comments.
fn variable(text: &str) -> Result<Variable> {
    let (text, array) = match text.trim().strip_suffix(']').and_then(|text| text.split_once('[')) {
        Some((text, length)) => (text, Some(length.parse().with_context(|| format!("{text}[{length}]"))?)),
        None => (text.trim(), None),
    };
    let spaced = text.replace('*', " * ");
    let words: Vec<&str> = spaced.split_whitespace().filter(|word| *word != "const").collect();
    let plain = |word: &str| word.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_');
    match words.as_slice() {
        [base, stars @ .., name] if stars.iter().all(|word| *word == "*") && plain(base) && plain(name) => {
            Ok(Variable {
                name: (*name).to_owned(),
                kind: Type { base: (*base).to_owned(), pointers: stars.len(), array },
            })
        }
        _ => bail!("{text:?} is no type and name that this reads"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forms_of_c() -> Result<()> {
        let items = header(concat!(
            "// Words.\n#define CRUMPLE_H\n/// One.\n///\n/// Two.\n#define CRUMPLE_A 3\n\ntypedef enum CrumpleE {\n    /// No.\n    CRUMPLE_E_NO = 0,\n",
            "} CrumpleE;\ntypedef struct CrumpleO CrumpleO;\ntypedef void (*CrumpleV)(void);\ntypedef void *(*CrumpleC)(size_t a,\n",
            "    const char *const *b);\ntypedef struct CrumpleS {\n    /// In m.\n    float m[16];\n    const void *data;\n} CrumpleS;\n",
            "/// Does.\nuint32_t crumple_f(CrumpleO *o,\n    CrumpleO **out);\nconst char *crumple_g(void);\n"
        ))?;
        let names: Vec<&str> = items.iter().map(|item| item.name.as_str()).collect();
        assert_eq!(
            names,
            ["CRUMPLE_A", "CrumpleE", "CrumpleO", "CrumpleV", "CrumpleC", "CrumpleS", "crumple_f", "crumple_g"]
        );
        assert_eq!(items[0].docs, ["One.", "", "Two."]);
        let Form::Callback { result, parameters } = &items[4].form else { bail!("{:?}", items[4]) };
        assert_eq!((result.pointers, parameters[1].kind.pointers, parameters[1].name.as_str()), (1, 2, "b"));
        let Form::Struct { fields } = &items[5].form else { bail!("{:?}", items[5]) };
        assert_eq!((fields[0].kind.array, fields[1].kind.pointers), (Some(16), 1));
        let Form::Function { parameters, .. } = &items[6].form else { bail!("{:?}", items[6]) };
        assert_eq!(parameters[1].kind, Type { base: "CrumpleO".into(), pointers: 2, array: None });
        Ok(())
    }

    #[test]
    fn what_is_not_understood_is_an_error() {
        for text in
            ["int x = 3;\n", "typedef union {\n    int a;\n} U;\n", "void crumple_f(int (*g)(void));\n", "void f(int\n"]
        {
            assert!(header(text).is_err(), "{text}");
        }
    }
}
