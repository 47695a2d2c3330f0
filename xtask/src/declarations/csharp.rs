//! The C# declarations of what headers declare: blittable structs, enums, delegates and P/Invoke functions.
//! csbindgen does not serve: it reads the Rust sources and cannot translate the callbacks and the `MaybeUninit` fields of defs there.

use std::fmt::Write;

use anyhow::{Context, Result, bail};
use regex_lite::{Captures, Regex};

use super::{Form, Item, Type, Variable, number, prefix, wrapped};

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
/// Columns of a line.
const WIDTH: usize = 126;

/// The two files: types and functions.
pub fn files(items: &[Item]) -> Result<(String, String)> {
    let writer = Writer { items };
    Ok((writer.types()?, writer.functions()?))
}

/// `contact_vertex` and `CONTACT_VERTEX` as `ContactVertex`.
pub fn pascal(name: &str) -> String {
    let word = |word: &str| {
        let mut letters = word.chars();
        let first = letters.next().map(|letter| letter.to_ascii_uppercase());
        first.into_iter().chain(letters.map(|letter| letter.to_ascii_lowercase())).collect::<String>()
    };
    name.split('_').map(word).collect()
}

fn camel(name: &str) -> String {
    let pascal = pascal(name);
    let mut letters = pascal.chars();
    let first = letters.next().map(|letter| letter.to_ascii_lowercase());
    let name: String = first.into_iter().chain(letters).collect();
    if KEYWORDS.contains(&name.as_str()) { format!("@{name}") } else { name }
}

struct Writer<'a> {
    items: &'a [Item],
}

impl Writer<'_> {
    fn form(&self, name: &str) -> Option<&Form> {
        self.items.iter().find(|item| item.name == name).map(|item| &item.form)
    }

    /// What a C type is in C#. Pointers whose target C# has no type for are `IntPtr`, and so are all pointers in structs: those
    /// must be usable without `unsafe`.
    fn kind(&self, kind: &Type, field: bool) -> Result<String> {
        let known = match kind.base.as_str() {
            "void" => "void",
            "char" if kind.pointers > 0 => "byte",
            "bool" => "CrumpleBool",
            name => match self.form(name) {
                None => number(name)?.0,
                Some(Form::Enum(..) | Form::Struct(..)) => name,
                Some(Form::Callback(..)) => "IntPtr",
                Some(Form::Opaque) if kind.pointers > 0 => "void",
                _ => bail!("{name:?} is a type that is not declared"),
            },
        };
        if kind.pointers == 0 {
            return Ok(known.to_owned());
        }
        if field {
            return Ok("IntPtr".to_owned());
        }
        // A pointer to nothing that C# could name, or text.
        let blank = known == "void" || kind.base == "char";
        let (name, stars) = if blank { ("IntPtr", kind.pointers - 1) } else { (known, kind.pointers) };
        Ok(format!("{name}{}", "*".repeat(stars)))
    }

    fn types(&self) -> Result<String> {
        let mut text = format!(
            "{HEAD}using Crumple.Native;\n\nnamespace Crumple\n{{\n    [Flags]\n    public enum CrumpleFeatures : ulong\n    {{\n"
        );
        for Item { name, form, .. } in self.items {
            if let (Form::Define(value), Some(feature)) = (form, name.strip_prefix("CRUMPLE_FEATURE_")) {
                writeln!(text, "        {} = {value},", pascal(feature))?;
            }
        }
        text.push_str("    }\n\n");
        for Item { name, form, .. } in self.items {
            match form {
                Form::Enum(variants) => {
                    writeln!(text, "    public enum {name}\n    {{")?;
                    let prefix = prefix(name, variants);
                    for (variant, value) in variants {
                        writeln!(text, "        {} = {value},", pascal(&variant[prefix.len()..]))?;
                    }
                    text.push_str("    }\n\n");
                }
                Form::Callback(result, parameters) => {
                    let (result, list) = (self.kind(result, false)?, self.parameters(parameters)?);
                    let keyword = if result.contains('*') || list.contains('*') { "unsafe " } else { "" };
                    text.push_str("    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]\n");
                    writeln!(text, "    public {keyword}delegate {result} {name}({list});\n")?;
                }
                Form::Struct(fields) => self.structure(&mut text, name, fields)?,
                Form::Define(..) | Form::Opaque | Form::Function(..) => {}
            }
        }
        Ok(text.trim_end().to_owned() + "\n}\n")
    }

    fn structure(&self, text: &mut String, structure: &str, fields: &[Variable]) -> Result<()> {
        let primitive = |kind: &Type| kind.pointers == 0 && self.form(&kind.base).is_none() && kind.base != "bool";
        let has_fixed = fields.iter().any(|field| field.kind.array.is_some() && primitive(&field.kind));
        let keyword = if has_fixed { "unsafe " } else { "" };
        writeln!(text, "    public {keyword}partial struct {structure}\n    {{")?;
        for field in fields {
            let (name, kind) = (pascal(&field.name), self.kind(&field.kind, true)?);
            match field.kind.array {
                None => writeln!(text, "        public {kind} {name};")?,
                Some(length) if primitive(&field.kind) => {
                    writeln!(text, "        public fixed {kind} {name}[{length}];")?
                }
                // C# has fixed arrays of numbers only.
                Some(length) => {
                    for index in 0..length {
                        writeln!(text, "        public {kind} {name}{index};")?;
                    }
                }
            }
        }
        if let Some(default) = self.default_of(structure) {
            writeln!(
                text,
                "\n        public static {structure} Default => CrumpleRuntime.Loaded(() => NativeMethods.{default}());"
            )?;
        }
        text.push_str("    }\n\n");
        Ok(())
    }

    /// The function without parameters that returns this struct.
    fn default_of(&self, structure: &str) -> Option<&str> {
        self.items.iter().find_map(|item| match &item.form {
            Form::Function(result, parameters)
                if parameters.is_empty() && result.base == structure && result.pointers == 0 =>
            {
                Some(item.name.as_str())
            }
            _ => None,
        })
    }

    fn functions(&self) -> Result<String> {
        let mut text = format!("{HEAD}{METHODS}");
        for Item { name, form, .. } in self.items {
            let Form::Define(value) = form else { continue };
            // Features are an enum; a define in small letters is another name of a function, which C# has as it is.
            if !name.starts_with("CRUMPLE_FEATURE_") && !name.starts_with("crumple_") {
                writeln!(text, "        public const uint {} = {};", define(name), defines_in(value)?)?;
            }
        }
        text.push('\n');
        for Item { name, form, .. } in self.items {
            let Form::Function(result, parameters) = form else { continue };
            text.push_str(
                "        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]\n",
            );
            let list = self.parameters(parameters).with_context(|| name.clone())?;
            let declaration = format!("        public static extern {} {name}({list});", self.kind(result, false)?);
            writeln!(text, "{}", wrapped(&declaration, WIDTH, 12))?;
        }
        Ok(text + "    }\n}\n")
    }

    fn parameters(&self, parameters: &[Variable]) -> Result<String> {
        let one =
            |parameter: &Variable| Ok(format!("{} {}", self.kind(&parameter.kind, false)?, camel(&parameter.name)));
        Ok(parameters.iter().map(one).collect::<Result<Vec<String>>>()?.join(", "))
    }
}

/// `CRUMPLE_VERSION_MAJOR` as `VersionMajor`.
fn define(name: &str) -> String {
    pascal(name.trim_start_matches("CRUMPLE_"))
}

/// The value of a define, with the names of other defines as C# has them.
fn defines_in(value: &str) -> Result<String> {
    Ok(Regex::new("CRUMPLE_\\w+")?.replace_all(value, |found: &Captures<'_>| define(&found[0])).into_owned())
}
