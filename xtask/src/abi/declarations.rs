//! What a header of cbindgen's declares. No more of C than such a header has.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail};

#[derive(Debug, PartialEq, Eq)]
pub enum Declaration {
    Constant {
        name: String,
    },
    Enum {
        name: String,
        enumerators: Vec<String>,
    },
    Struct {
        name: String,
        fields: Vec<Field>,
    },
    Opaque {
        name: String,
    },
    /// `signature` is without the names of parameters, `text` as it is written.
    Callback {
        name: String,
        signature: String,
    },
    Function {
        name: String,
        signature: String,
        text: String,
    },
}

impl Declaration {
    pub fn into_function(self) -> Option<String> {
        if let Self::Function { name, .. } = self { Some(name) } else { None }
    }
}

#[derive(Debug, PartialEq, Eq)]
pub struct Field {
    pub name: String,
    /// Arrays have their length: `float[16]`.
    pub kind: String,
}

pub fn of(header: &Path) -> Result<Vec<Declaration>> {
    let text = fs::read_to_string(header).with_context(|| format!("reading {}", header.display()))?;
    read(&text).with_context(|| format!("reading {}", header.display()))
}

fn read(header: &str) -> Result<Vec<Declaration>> {
    let mut found = Vec::new();
    for line in header.lines() {
        // Versions change without a difference to programs.
        let Some(name) = line.strip_prefix("#define ").and_then(|rest| rest.split_whitespace().next()) else {
            continue;
        };
        if name.starts_with("CRUMPLE_") && !name.starts_with("CRUMPLE_VERSION") && name != "CRUMPLE_H" {
            found.push(Declaration::Constant { name: name.to_owned() });
        }
    }
    let code = code(header);
    let mut rest = code.as_str();
    while let Some(end) = end_of_statement(rest) {
        found.push(statement(rest[..end].trim()).with_context(|| format!("reading {:?}", rest[..end].trim()))?);
        rest = &rest[end + 1..];
    }
    Ok(found)
}

/// Without comments, directives and what is for C++ alone.
fn code(header: &str) -> String {
    let mut code = String::new();
    let mut for_cpp = false;
    for line in header.lines() {
        let line = line.split("//").next().unwrap_or_default().trim();
        match line {
            "#ifdef __cplusplus" => for_cpp = true,
            _ if line.starts_with("#endif") => for_cpp = false,
            _ if for_cpp || line.starts_with('#') => {}
            _ => {
                code += line;
                code.push(' ');
            }
        }
    }
    code
}

/// The semicolon outside braces.
fn end_of_statement(code: &str) -> Option<usize> {
    let mut depth = 0;
    code.bytes().position(|byte| {
        depth += i32::from(byte == b'{') - i32::from(byte == b'}');
        byte == b';' && depth == 0
    })
}

fn statement(text: &str) -> Result<Declaration> {
    if let Some(rest) = text.strip_prefix("typedef enum {") {
        let (inside, name) = rest.rsplit_once('}').context("an enum without its end")?;
        let names = inside.split(',').map(|one| one.split('=').next().unwrap_or_default().trim());
        let enumerators = names.filter(|name| !name.is_empty()).map(str::to_owned).collect();
        return Ok(Declaration::Enum { name: name.trim().to_owned(), enumerators });
    }
    if let Some(rest) = text.strip_prefix("typedef struct {") {
        let (inside, name) = rest.rsplit_once('}').context("a struct without its end")?;
        let fields = inside.split(';').map(str::trim).filter(|field| !field.is_empty()).map(field);
        return Ok(Declaration::Struct { name: name.trim().to_owned(), fields: fields.collect::<Result<_>>()? });
    }
    if let Some(rest) = text.strip_prefix("typedef struct ") {
        let name = rest.split_whitespace().next().unwrap_or_default();
        return Ok(Declaration::Opaque { name: name.to_owned() });
    }
    if let Some(rest) = text.strip_prefix("typedef ") {
        let (answer, rest) = rest.split_once("(*").context("a typedef that is no callback")?;
        let (name, parameters) = rest.split_once(')').context("a callback without a name")?;
        return Ok(Declaration::Callback { name: name.to_owned(), signature: signature(answer, parameters)? });
    }
    let (before, parameters) = text.split_once('(').context("neither a type nor a function")?;
    let at = before.rfind([' ', '*']).context("a function without a type")? + 1;
    let name = before[at..].to_owned();
    let signature = signature(&before[..at], &format!("({parameters}"))?;
    Ok(Declaration::Function { name, signature, text: text.to_owned() })
}

fn field(text: &str) -> Result<Field> {
    let (text, length) = match text.split_once('[') {
        Some((text, length)) => (text, format!("[{length}")),
        None => (text, String::new()),
    };
    let at = text.rfind([' ', '*']).context("a field without a type")? + 1;
    Ok(Field { name: text[at..].to_owned(), kind: kind(&text[..at]) + &length })
}

fn signature(answer: &str, parameters: &str) -> Result<String> {
    let Some(inside) = parameters.trim().strip_prefix('(').and_then(|rest| rest.strip_suffix(')')) else {
        bail!("{parameters:?} are no parameters");
    };
    let mut kinds = Vec::new();
    for parameter in inside.split(',').map(str::trim) {
        match parameter.rfind([' ', '*']) {
            Some(at) => kinds.push(kind(&parameter[..=at])),
            None => kinds.push(parameter.to_owned()),
        }
    }
    Ok(format!("{} ({})", kind(answer), kinds.join(", ")))
}

/// A type with one way to put blanks.
fn kind(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ").replace(" *", "*")
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "// A comment; with a semicolon { and a brace.\n#ifndef CRUMPLE_H\n#define CRUMPLE_H\n\
        #define CRUMPLE_VERSION_MAJOR 0\n#define CRUMPLE_FEATURE_OBJ 2\n\
        typedef enum {\n    /// Good; well.\n    CRUMPLE_OK = 0,\n    CRUMPLE_BAD = 7,\n} CrumpleResult;\n\
        typedef struct CrumpleContext CrumpleContext;\n\
        typedef void *(*CrumpleAlloc)(size_t size, void *user);\n\
        typedef struct {\n    const char *const *paths;\n    float m[16];\n} CrumpleDef;\n\
        #ifdef __cplusplus\nextern \"C\" {\n#endif // __cplusplus\n\
        const char *crumple_last_error(void);\n\
        CrumpleResult crumple_go(CrumpleContext *context,\n                         uint32_t *out_count);\n\
        #ifdef __cplusplus\n}  // extern \"C\"\n#endif\n#endif\n";

    #[test]
    fn declarations_are_read() {
        let field = |name: &str, kind: &str| Field { name: name.into(), kind: kind.into() };
        let expected = [
            Declaration::Constant { name: "CRUMPLE_FEATURE_OBJ".into() },
            Declaration::Enum {
                name: "CrumpleResult".into(),
                enumerators: vec!["CRUMPLE_OK".into(), "CRUMPLE_BAD".into()],
            },
            Declaration::Opaque { name: "CrumpleContext".into() },
            Declaration::Callback { name: "CrumpleAlloc".into(), signature: "void* (size_t, void*)".into() },
            Declaration::Struct {
                name: "CrumpleDef".into(),
                fields: vec![field("paths", "const char*const*"), field("m", "float[16]")],
            },
            Declaration::Function {
                name: "crumple_last_error".into(),
                signature: "const char* (void)".into(),
                text: "const char *crumple_last_error(void)".into(),
            },
            Declaration::Function {
                name: "crumple_go".into(),
                signature: "CrumpleResult (CrumpleContext*, uint32_t*)".into(),
                text: "CrumpleResult crumple_go(CrumpleContext *context, uint32_t *out_count)".into(),
            },
        ];
        assert_eq!(read(HEADER).unwrap(), expected);
    }

    #[test]
    fn what_is_not_understood_is_an_error() {
        for wrong in ["typedef int CrumpleNumber;", "int x;", "typedef struct { a; } CrumpleA;"] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }
}
