//! The C# declarations of everything in `include/crumple.h`: blittable structs, enums, delegates and P/Invoke functions, with
//! the header's comments as XML documentation. What a C type becomes is said in one place, `Writer::kind`.

use std::collections::BTreeMap;
use std::fmt::Write;

use anyhow::{Context, Result, bail};

use crate::declarations::{Form, Item, Type, Variable, Variant};

const HEAD: &str = "// Generated from include/crumple.h by `cargo xtask header`; do not edit it.\n\n";
const KEYWORDS: &[&str] = &["base", "event", "fixed", "in", "lock", "object", "out", "params", "ref", "string"];
/// Columns of a line of documentation.
const WIDTH: usize = 126;

/// The two files: types and functions.
pub fn files(items: &[Item]) -> Result<(String, String)> {
    let writer = Writer::new(items);
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

struct Writer<'a> {
    items: &'a [Item],
    /// What each name that comments may mention is called in C#.
    names: BTreeMap<String, String>,
}

impl<'a> Writer<'a> {
    fn new(items: &'a [Item]) -> Self {
        let mut names = BTreeMap::new();
        for Item { name, form, .. } in items {
            match form {
                Form::Function { .. } => names.insert(name.clone(), format!("Native.NativeMethods.{name}")),
                Form::Define { .. } => match name.strip_prefix("CRUMPLE_FEATURE_") {
                    Some(feature) => names.insert(name.clone(), format!("CrumpleFeatures.{}", pascal(feature))),
                    None => names.insert(name.clone(), format!("Native.NativeMethods.{}", define(name))),
                },
                Form::Enum { variants } => {
                    let prefix = prefix(name, variants);
                    for variant in variants {
                        names.insert(variant.name.clone(), format!("{name}.{}", pascal(&variant.name[prefix.len()..])));
                    }
                    names.insert(name.clone(), name.clone())
                }
                Form::Opaque | Form::Callback { .. } | Form::Struct { .. } => names.insert(name.clone(), name.clone()),
            };
        }
        Self { items, names }
    }

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
            "float" => "float",
            "double" => "double",
            "size_t" => "UIntPtr",
            "uint8_t" => "byte",
            "uint16_t" => "ushort",
            "uint32_t" => "uint",
            "uint64_t" => "ulong",
            "int32_t" => "int",
            "int64_t" => "long",
            name => match self.form(name) {
                Some(Form::Enum { .. } | Form::Struct { .. }) => name,
                Some(Form::Callback { .. }) => "IntPtr",
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
        let mut text = format!("{HEAD}using System;\nusing System.Runtime.InteropServices;\n\nnamespace Crumple\n{{\n");
        self.features(&mut text)?;
        for item in self.items {
            match &item.form {
                Form::Enum { variants } => {
                    self.docs(&mut text, 1, &item.docs)?;
                    writeln!(text, "    public enum {}\n    {{", item.name)?;
                    let prefix = prefix(&item.name, variants);
                    for variant in variants {
                        self.docs(&mut text, 2, &variant.docs)?;
                        writeln!(text, "        {} = {},", pascal(&variant.name[prefix.len()..]), variant.value)?;
                    }
                    text.push_str("    }\n\n");
                }
                Form::Callback { result, parameters } => {
                    self.docs(&mut text, 1, &item.docs)?;
                    text.push_str("    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]\n");
                    let (result, list) = (self.kind(result, false)?, self.parameters(parameters)?);
                    writeln!(
                        text,
                        "    public {}delegate {result} {}({list});\n",
                        dangerous(&result, &list),
                        item.name
                    )?;
                }
                Form::Struct { fields } => self.structure(&mut text, item, fields)?,
                Form::Define { .. } | Form::Opaque | Form::Function { .. } => {}
            }
        }
        Ok(text.trim_end().to_owned() + "\n}\n")
    }

    fn features(&self, text: &mut String) -> Result<()> {
        text.push_str("    /// <summary>\n    /// What this build of the library can do. Bits unknown to you may be set.\n    /// </summary>\n");
        text.push_str("    [Flags]\n    public enum CrumpleFeatures : ulong\n    {\n");
        for Item { docs, name, form, .. } in self.items {
            if let (Form::Define { value }, Some(feature)) = (form, name.strip_prefix("CRUMPLE_FEATURE_")) {
                self.docs(text, 2, docs)?;
                writeln!(text, "        {} = {value},", pascal(feature))?;
            }
        }
        text.push_str("    }\n\n");
        Ok(())
    }

    fn structure(&self, text: &mut String, item: &Item, fields: &[Variable]) -> Result<()> {
        let primitive = |kind: &Type| kind.pointers == 0 && self.form(&kind.base).is_none() && kind.base != "bool";
        let has_fixed = fields.iter().any(|field| field.kind.array.is_some() && primitive(&field.kind));
        self.docs(text, 1, &item.docs)?;
        text.push_str("    [StructLayout(LayoutKind.Sequential)]\n");
        writeln!(text, "    public {}partial struct {}\n    {{", if has_fixed { "unsafe " } else { "" }, item.name)?;
        for field in fields {
            let (name, kind) = (pascal(&field.name), self.kind(&field.kind, true)?);
            match field.kind.array {
                None => {
                    self.docs(text, 2, &field.docs)?;
                    writeln!(text, "        public {kind} {name};")?;
                }
                Some(length) if primitive(&field.kind) => {
                    self.docs(text, 2, &field.docs)?;
                    writeln!(text, "        public fixed {kind} {name}[{length}];")?;
                }
                Some(length) => {
                    // C# has fixed arrays of numbers only.
                    for index in 0..length {
                        self.docs(text, 2, &field.docs)?;
                        writeln!(text, "        public {kind} {name}{index};")?;
                    }
                }
            }
        }
        if let Some(default) = self.default_of(&item.name) {
            writeln!(
                text,
                "\n        /// <summary>\n        /// The defaults, from <c>{default}()</c>: begin with these.\n        /// </summary>"
            )?;
            writeln!(
                text,
                "        /// <exception cref=\"CrumpleLibraryException\">The native library is missing or does not fit.</exception>"
            )?;
            writeln!(text, "        public static {} Default\n        {{\n            get\n            {{", item.name)?;
            writeln!(
                text,
                "                CrumpleRuntime.EnsureLoaded();\n                return Native.NativeMethods.{default}();"
            )?;
            text.push_str("            }\n        }\n");
        }
        text.push_str("    }\n\n");
        Ok(())
    }

    /// The function without parameters that returns this struct.
    fn default_of(&self, structure: &str) -> Option<&str> {
        self.items.iter().find_map(|item| match &item.form {
            Form::Function { result, parameters }
                if parameters.is_empty() && result.base == structure && result.pointers == 0 =>
            {
                Some(item.name.as_str())
            }
            _ => None,
        })
    }

    fn functions(&self) -> Result<String> {
        let mut text =
            format!("{HEAD}using System;\nusing System.Runtime.InteropServices;\n\nnamespace Crumple.Native\n{{\n");
        text.push_str(concat!(
            "    /// <summary>\n    /// The functions of crumple.h as they are. Call <see cref=\"CrumpleRuntime.EnsureLoaded\"/> before the first one: it tells\n",
            "    /// what is wrong with a library that is missing or does not fit.\n    /// </summary>\n    public static unsafe class NativeMethods\n    {\n",
            "        /// <summary>\n        /// Name of the native library, without what systems put before and after it.\n        /// </summary>\n",
            "#if (UNITY_IOS || UNITY_TVOS || UNITY_VISIONOS) && !UNITY_EDITOR\n        public const string Library = \"__Internal\";\n",
            "#else\n        public const string Library = \"crumple\";\n#endif\n\n"
        ));
        for Item { docs, name, form, .. } in self.items {
            let Form::Define { value } = form else { continue };
            // Features are an enum; a define in small letters is another name of a function, which C# has as it is.
            if name.starts_with("CRUMPLE_FEATURE_") || name.starts_with("crumple_") {
                continue;
            }
            self.docs(&mut text, 2, docs)?;
            let value = replace_words(value, |word| word.starts_with("CRUMPLE_").then(|| define(word)));
            writeln!(text, "        public const uint {} = {value};\n", define(name))?;
        }
        for Item { docs, name, form, .. } in self.items {
            let Form::Function { result, parameters } = form else { continue };
            self.docs(&mut text, 2, docs)?;
            text.push_str(
                "        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]\n",
            );
            let head = format!("        public static extern {} {name}(", self.kind(result, false)?);
            let list = self.parameters(parameters).with_context(|| name.clone())?;
            if head.len() + list.len() < WIDTH {
                writeln!(text, "{head}{list});\n")?;
            } else {
                writeln!(text, "{head}\n            {});\n", list.replace(", ", ",\n            "))?;
            }
        }
        Ok(text.trim_end().to_owned() + "\n    }\n}\n")
    }

    fn parameters(&self, parameters: &[Variable]) -> Result<String> {
        let one =
            |parameter: &Variable| Ok(format!("{} {}", self.kind(&parameter.kind, false)?, camel(&parameter.name)));
        Ok(parameters.iter().map(one).collect::<Result<Vec<String>>>()?.join(", "))
    }

    /// The first paragraph is the summary, all others are remarks.
    fn docs(&self, text: &mut String, depth: usize, docs: &[String]) -> Result<()> {
        let indent = "    ".repeat(depth);
        let paragraphs: Vec<String> =
            docs.split(|line| line.is_empty()).map(|lines| self.referring(&lines.join(" "))).collect();
        let Some((summary, remarks)) = paragraphs.split_first() else { return Ok(()) };
        let mut put = |line: &str| writeln!(text, "{indent}/// {line}");
        put("<summary>")?;
        for line in wrap(summary, WIDTH - indent.len()) {
            put(&line)?;
        }
        put("</summary>")?;
        if !remarks.is_empty() {
            put("<remarks>")?;
            for paragraph in remarks {
                for line in wrap(&format!("<para>{paragraph}</para>"), WIDTH - indent.len()) {
                    put(&line)?;
                }
            }
            put("</remarks>")?;
        }
        Ok(())
    }

    /// Escapes for XML, and turns names of the header into references to what they are here.
    fn referring(&self, text: &str) -> String {
        let escaped = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
        let calls = escaped.replace("()", "");
        replace_words(&calls, |word| {
            let name = self.names.get(word)?;
            Some(format!("<see cref=\"{name}\"/>"))
        })
    }
}

/// `CRUMPLE_VERSION_MAJOR` as `VersionMajor`.
fn define(name: &str) -> String {
    pascal(name.trim_start_matches("CRUMPLE_"))
}

/// `unsafe `, where a signature has pointers.
fn dangerous(result: &str, list: &str) -> &'static str {
    if result.contains('*') || list.contains('*') { "unsafe " } else { "" }
}

/// Replaces each whole identifier that `with` knows.
fn replace_words(text: &str, with: impl Fn(&str) -> Option<String>) -> String {
    let part_of_name = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
    let mut replaced = String::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let inside = part_of_name(first);
        let end = rest.find(|letter| part_of_name(letter) != inside).unwrap_or(rest.len());
        let (word, after) = rest.split_at(end);
        replaced += &with(word).filter(|_| inside).unwrap_or_else(|| word.to_owned());
        rest = after;
    }
    replaced
}

/// Breaks at spaces, but not inside a reference.
fn wrap(text: &str, width: usize) -> Vec<String> {
    let whole = text.replace("<see cref", "<see\u{0}cref");
    let mut lines = vec![String::new()];
    for word in whole.split(' ') {
        let line = lines.last_mut().expect("there is always a line");
        if line.is_empty() {
            line.push_str(word);
        } else if line.len() + 1 + word.len() <= width {
            line.push(' ');
            line.push_str(word);
        } else {
            lines.push(word.to_owned());
        }
    }
    lines.into_iter().map(|line| line.replace('\u{0}', " ")).collect()
}
