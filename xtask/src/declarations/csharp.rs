//! The C# declarations of what headers declare: blittable structs, enums, delegates and P/Invoke functions.
//! csbindgen does not serve: it reads the Rust sources and cannot translate the callbacks and the `MaybeUninit` fields of defs there.

use std::fmt::Write;

use anyhow::{Context, Result, bail};
use heck::{ToLowerCamelCase, ToUpperCamelCase};
use regex_lite::{Captures, Regex};

use super::{Form, Item, Type, Variable, declared, number, prefix, wrapped};

const HEAD: &str = "\
// Generated from the headers in include by `cargo xtask header`; do not edit it. They document what is declared here. C# lays out
// structs as C does; tests compare them with a C compiler's.
#pragma warning disable 1591

using System;
using System.Runtime.InteropServices;
";
const METHODS: &str = "
namespace Crumple.Native
{
    /// <summary>
    /// The functions of the C headers. Call <see cref=\"CrumpleRuntime.EnsureLoaded\"/> first: it says what is wrong with a library that is
    /// missing or does not fit.
    /// </summary>
    public static unsafe class NativeMethods
    {
        // The file name without the prefix and suffix that systems add.
        public const string Library = \"crumple\";
";
/// The headers that C# has. The others are for hosts with a graphics device or an allocator of their own.
pub const HEADERS: &[&str] =
    &["crumple.h", "crumple_build.h", "crumple_import.h", "crumple_parts.h", "crumple_contacts.h", "crumple_view.h"];

const KEYWORDS: &[&str] = &["base", "event", "fixed", "in", "lock", "object", "out", "params", "ref", "string"];
const WIDTH: usize = 126;

/// The two files: types and functions.
pub fn files(items: &[Item]) -> Result<(String, String)> {
    Ok((types(items)?, functions(items)?))
}

fn camel(name: &str) -> String {
    let name = name.to_lower_camel_case();
    if KEYWORDS.contains(&name.as_str()) { format!("@{name}") } else { name }
}

/// What a C type is in C#. Pointers whose target C# has no type for are `IntPtr`, and so are all pointers in structs: those
/// must be usable without `unsafe`.
fn kind(items: &[Item], kind: &Type, field: bool) -> Result<String> {
    let known = match (kind.base.as_str(), declared(items, &kind.base)) {
        ("void", _) => "void",
        ("char", _) if kind.pointers > 0 => "byte",
        ("bool", _) => "CrumpleBool",
        (name, None) => number(name)?.0,
        (name, Some(Form::Enum(..) | Form::Struct(..))) => name,
        (_, Some(Form::Callback(..))) => "IntPtr",
        (_, Some(Form::Opaque)) if kind.pointers > 0 => "void",
        (name, _) => bail!("{name:?} is a type that is not declared"),
    };
    // A pointer to nothing that C# could name, or text.
    let blank = kind.pointers > 0 && (field || known == "void" || kind.base == "char");
    let stars = if field { 0 } else { kind.pointers - usize::from(blank) };
    Ok(format!("{}{}", if blank { "IntPtr" } else { known }, "*".repeat(stars)))
}

fn list(items: &[Item], parameters: &[Variable]) -> Result<String> {
    let one = |one: &Variable| Ok(format!("{} {}", kind(items, &one.kind, false)?, camel(&one.name)));
    Ok(parameters.iter().map(one).collect::<Result<Vec<String>>>()?.join(", "))
}

fn types(items: &[Item]) -> Result<String> {
    let mut text = format!(
        "{HEAD}using Crumple.Native;\n\nnamespace Crumple\n{{\n    [Flags]\n    public enum CrumpleFeatures : ulong\n    {{\n"
    );
    for Item { name, form, .. } in items {
        if let (Form::Define(value), Some(feature)) = (form, name.strip_prefix("CRUMPLE_FEATURE_")) {
            writeln!(text, "        {} = {value},", feature.to_upper_camel_case())?;
        }
    }
    text += "    }\n\n";
    for Item { name, form, .. } in items {
        match form {
            Form::Enum(variants) => {
                writeln!(text, "    public enum {name}\n    {{")?;
                let prefix = prefix(name, variants);
                for (variant, value) in variants {
                    writeln!(text, "        {} = {value},", variant[prefix.len()..].to_upper_camel_case())?;
                }
                text += "    }\n\n";
            }
            Form::Callback(result, parameters) => {
                let (result, list) = (kind(items, result, false)?, list(items, parameters)?);
                let keyword = if result.contains('*') || list.contains('*') { "unsafe " } else { "" };
                text += "    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]\n";
                writeln!(text, "    public {keyword}delegate {result} {name}({list});\n")?;
            }
            Form::Struct(fields) => structure(items, &mut text, name, fields)?,
            Form::Define(..) | Form::Opaque | Form::Function(..) => {}
        }
    }
    Ok(text.trim_end().to_owned() + "\n}\n")
}

fn structure(items: &[Item], text: &mut String, structure: &str, fields: &[Variable]) -> Result<()> {
    // C# has fixed arrays of numbers only.
    let number = |kind: &Type| kind.pointers == 0 && declared(items, &kind.base).is_none() && kind.base != "bool";
    let fixed = fields.iter().any(|field| field.kind.array.is_some() && number(&field.kind));
    writeln!(text, "    public {}partial struct {structure}\n    {{", if fixed { "unsafe " } else { "" })?;
    for field in fields {
        let (name, kind) = (field.name.to_upper_camel_case(), kind(items, &field.kind, true)?);
        match field.kind.array {
            None => writeln!(text, "        public {kind} {name};")?,
            Some(length) if number(&field.kind) => writeln!(text, "        public fixed {kind} {name}[{length}];")?,
            Some(length) => (0..length).try_for_each(|at| writeln!(text, "        public {kind} {name}{at};"))?,
        }
    }
    // The function without parameters that returns this struct.
    let default = |item: &&Item| {
        matches!(&item.form, Form::Function(result, parameters)
            if parameters.is_empty() && result.base == structure && result.pointers == 0)
    };
    if let Some(Item { name, .. }) = items.iter().find(default) {
        let call = format!("CrumpleRuntime.Loaded(() => NativeMethods.{name}())");
        writeln!(text, "\n        public static {structure} Default => {call};")?;
    }
    text.push_str("    }\n\n");
    Ok(())
}

fn functions(items: &[Item]) -> Result<String> {
    let mut text = format!("{HEAD}{METHODS}");
    // `CRUMPLE_VERSION_MAJOR` is `VersionMajor`, also in the values of others.
    let define = |name: &str| name.trim_start_matches("CRUMPLE_").to_upper_camel_case();
    for Item { name, form, .. } in items {
        let Form::Define(value) = form else { continue };
        // Features are an enum; a define in small letters is another name of a function, which C# has as it is.
        if !name.starts_with("CRUMPLE_FEATURE_") && !name.starts_with("crumple_") {
            let value = Regex::new("CRUMPLE_\\w+")?.replace_all(value, |found: &Captures<'_>| define(&found[0]));
            writeln!(text, "        public const uint {} = {value};", define(name))?;
        }
    }
    text.push('\n');
    for Item { name, form, .. } in items {
        let Form::Function(result, parameters) = form else { continue };
        text += "        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]\n";
        let list = list(items, parameters).with_context(|| name.clone())?;
        let declaration = format!("        public static extern {} {name}({list});", kind(items, result, false)?);
        writeln!(text, "{}", wrapped(&declaration, WIDTH, 12))?;
    }
    Ok(text + "    }\n}\n")
}
