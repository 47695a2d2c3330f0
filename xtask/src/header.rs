//! The headers, which cbindgen writes from the sources of `src/capi`, and the C# and Python declarations made from them: committed,
//! and compared in CI.

use anyhow::{Context, Result, anyhow, bail};
use regex_lite::Regex;
use similar::TextDiff;

use crate::declarations::{self, HEADERS, INCLUDE, PARTS, csharp, python, wrapped};
use crate::files::{read, write};
use crate::workspace::in_root;

/// The last line of an opening comment.
const GENERATED: &str =
    "// This file is generated from the library's source by `cargo xtask header`; do not edit it.\n";

const WIDTH: usize = 120;

/// Where the declarations of C# and Python are.
const CSHARP: &str = "bindings/unity/Runtime/Native";
const PYTHON: &str = "bindings/python/src/crumple/_native.py";

pub fn run(check: bool) -> Result<()> {
    let headers = generate()?;
    let in_csharp = |(name, _): &(&&str, &String)| csharp::HEADERS.contains(name);
    let of_csharp: String = HEADERS.iter().zip(&headers).filter(in_csharp).map(|(_, text)| text.as_str()).collect();
    let (types, functions) = csharp::files(&declarations::header(&of_csharp)?)?;
    let python = python::module(&declarations::header(&headers.concat())?)?;
    let mut files: Vec<_> = HEADERS.iter().map(|name| format!("{INCLUDE}/{name}")).zip(headers).collect();
    files.push((format!("{CSHARP}/NativeTypes.g.cs"), types));
    files.push((format!("{CSHARP}/NativeMethods.g.cs"), functions));
    files.push((PYTHON.to_owned(), python));
    for (name, fresh) in &files {
        let committed = read(name).unwrap_or_default();
        if check && committed != *fresh {
            let diff = TextDiff::from_lines(&committed, fresh);
            print!("{}", diff.unified_diff().header(&format!("{name} (committed)"), "what the sources say"));
            bail!("{name} is not what the sources say; type: cargo xtask header");
        }
        if !check {
            write(name, fresh)?;
        }
        println!("{name} is what the sources say");
    }
    Ok(())
}

/// The texts of `HEADERS`.
fn generate() -> Result<Vec<String>> {
    let shared = cbindgen::Config::from_file("cbindgen.toml").map_err(|message| anyhow!("cbindgen.toml: {message}"))?;
    let part = |part: &str| {
        let (head, about) = part.split_once('\n').unwrap_or((part, ""));
        let (name, sources) = head.trim().split_once(": ").with_context(|| format!("{head:?} is no header"))?;
        let Some((name, include)) = name.split_once(" (") else { return write_header(sources, shared.clone()) };
        let config = cbindgen::Config {
            header: Some(format!("{}\n//\n{GENERATED}", about.trim_end())),
            include_guard: Some(name.to_uppercase().replace('.', "_")),
            after_includes: Some(format!("\n#include \"{}\"", include.trim_end_matches(')'))),
            ..shared.clone()
        };
        write_header(sources, config)
    };
    PARTS.split("\n\n").map(part).collect()
}

/// What `sources` declare. Types of other files are written as they are named.
fn write_header(sources: &str, mut config: cbindgen::Config) -> Result<String> {
    config.function.args = cbindgen::Layout::Horizontal;
    let files = sources.split(' ').map(|file| in_root(format!("src/{file}.rs")));
    let builder = files.fold(cbindgen::Builder::new(), |builder, file| builder.with_src(file)).with_config(config);
    let bindings = builder.generate().context("cbindgen cannot read the sources; does the library build?")?;
    let mut text = Vec::new();
    bindings.write(&mut text);
    // With tags, cbindgen also refers to types by them.
    let tag = Regex::new("(struct|enum) Crumple")?;
    let line = |line: &str| {
        let tagged = line.starts_with("typedef struct ") || line.starts_with("typedef enum ");
        let line = if tagged { line.into() } else { tag.replace_all(line, "Crumple") };
        let declares = line.ends_with(");") && !line.starts_with("//");
        // Arguments that have no room go below each other.
        let column = line.rfind('(').map_or(0, |parenthesis| parenthesis + 1);
        if declares { wrapped(&line, WIDTH, column) } else { line.into_owned() }
    };
    let mut text = String::from_utf8(text)?.lines().map(line).collect::<Vec<_>>().join("\n") + "\n";
    for (found, instead) in [
        // Items that cbindgen leaves out leave their blank lines behind.
        (r"\n\n\n+", "\n\n"),
        // Constants go together, each below its comment.
        (r"(#define .*\n)\n((?:///.*\n)*#define)", "$1$2"),
        // A function without a comment returns the def of the next function.
        (r"(_def_default\(void\);\n)\n(///|.*_def_default\(void\);)", "$1$2"),
    ] {
        let found = Regex::new(found)?;
        while found.is_match(&text) {
            text = found.replace_all(&text, instead).into_owned();
        }
    }
    Ok(text)
}
