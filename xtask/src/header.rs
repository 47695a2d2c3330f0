//! The headers, which cbindgen writes from the sources of `src/capi`, and the C# and Python declarations made from them: committed,
//! and compared in CI.

use crate::declarations::{csharp, python, wrapped};
use crate::prelude::*;
use similar::TextDiff;

/// The last line of an opening comment.
const GENERATED: &str =
    "// This file is generated from the library's source by `cargo xtask header`; do not edit it.\n";

/// Characters in a line of a header.
const WIDTH: usize = 120;

/// Where the declarations of C# and Python are.
const CSHARP: &str = "bindings/unity/Runtime/Native";
const PYTHON: &str = "bindings/python/src/crumple/_native.py";

/// Of crumple.h, whose opening comment is in cbindgen.toml.
const CORE: &str = "capi/version capi/result capi/types example/blow select/hit contacts/options damage/mark capi/tasks capi/context \
                    capi/set capi/instance capi/hit capi/contacts capi/damage capi/memory capi/buffer capi/deform";

/// The headers beside crumple.h: the header, what it includes, and the files of `src` without their ends in the order in which their items
/// are declared; then the first lines of its opening comment.
const PARTS: &str = "\
crumple_build.h crumple.h example/data example/options capi/memory capi/build capi/authoring
// Crumple: builds example sets from arrays, adds levels of detail to them, and saves them as baked sets.
//
// Games load baked sets (crumple.h). This header is for what makes them, and for bodies that are made at run time.

crumple_import.h crumple_build.h capi/store capi/load
// Crumple: builds example sets from glTF and OBJ files.

crumple_parts.h crumple.h capi/parts
// Crumple: bodies whose parts come off, points that move with the surface, such as lamps, and colliders.

crumple_contacts.h crumple.h capi/contact_ids
// Crumple: contact ids, which join hits to one dent, and the hits that contact points became.

crumple_view.h crumple.h capi/view
// Crumple: how finely, and how soon, instances are shown.

crumple_host.h crumple.h capi/allocator capi/share
// Crumple: the host's allocator, and example sets in several contexts.

crumple_vulkan.h crumple.h capi/vulkan_types capi/vulkan
// Crumple: writes deformed vertices by a Vulkan device instead of the CPU.
//
// With your device: crumple_vulkan_attach, crumple_buffer_register_vulkan, and once a frame crumple_vulkan_record into your
// VkCommandBuffer and crumple_vulkan_complete_frames. With a device of Crumple's own, which shares memory with yours:
// crumple_vulkan_open, crumple_vulkan_import_buffer, crumple_buffer_register_vulkan, and once a frame crumple_vulkan_submit.
//
// Every call with a context may also return CRUMPLE_ERROR_VULKAN and CRUMPLE_ERROR_DEVICE_LOST.

crumple_graph.h crumple_vulkan.h capi/graph_types capi/graph
// Crumple: writes deformed vertices in passes of your own render graph.
//
// Register vertex buffers with crumple_buffer_register_graph. Once a frame, crumple_graph_plan returns what to upload and to
// dispatch, with kernels of crumple_graph_get_kernel. Crumple calls no graphics library.";

pub fn run(check: bool) -> Result<()> {
    let headers = generate()?;
    let in_csharp = |(name, _): &(&&str, &String)| csharp::HEADERS.contains(name);
    let of_csharp: Vec<_> = HEADERS.iter().zip(&headers).filter(in_csharp).map(|(_, text)| text.clone()).collect();
    let (types, functions) = csharp::files(&declarations::header(&declarations::joined(&of_csharp))?)?;
    let python = python::module(&declarations::header(&declarations::joined(&headers))?)?;
    let mut files: Vec<_> = HEADERS.iter().map(|name| format!("{INCLUDE}/{name}")).zip(headers).collect();
    files.push((format!("{CSHARP}/NativeTypes.g.cs"), types));
    files.push((format!("{CSHARP}/NativeMethods.g.cs"), functions));
    files.push((PYTHON.to_owned(), python));
    for (name, fresh) in &files {
        if check {
            compare(name, fresh)?;
        } else {
            write(name, fresh)?;
            println!("wrote {name}");
        }
    }
    Ok(())
}

fn compare(name: &str, fresh: &str) -> Result<()> {
    let committed = read(name)?;
    if committed != fresh {
        let committed_name = format!("{name} (committed)");
        let diff = TextDiff::from_lines(&committed, fresh);
        print!("{}", diff.unified_diff().header(&committed_name, "what the sources say"));
        bail!("{name} is not what the sources say; type: cargo xtask header");
    }
    println!("{name} is what the sources say");
    Ok(())
}

/// The texts of `HEADERS`.
fn generate() -> Result<Vec<String>> {
    let shared =
        cbindgen::Config::from_file(in_root("cbindgen.toml")).map_err(|message| anyhow!("cbindgen.toml: {message}"))?;
    let part = |name: &&str| {
        let Some(part) = PARTS.split("\n\n").find(|part| part.starts_with(name)) else {
            return write_header(CORE, shared.clone());
        };
        let (head, about) = part.split_once('\n').context("an opening comment")?;
        let [_, include, sources] = head.splitn(3, ' ').collect::<Vec<_>>()[..] else { bail!("{head:?} is no header") };
        let config = cbindgen::Config {
            header: Some(format!("{about}\n//\n{GENERATED}")),
            include_guard: Some(name.to_uppercase().replace('.', "_")),
            after_includes: Some(format!("\n#include \"{include}\"")),
            ..shared.clone()
        };
        write_header(sources, config)
    };
    HEADERS.iter().map(part).collect()
}

/// What `sources` declare. Types of other files are written as they are named.
fn write_header(sources: &str, mut config: cbindgen::Config) -> Result<String> {
    config.function.args = cbindgen::Layout::Horizontal;
    let files = sources.split(' ').map(|file| in_root(format!("src/{file}.rs")));
    let builder = files.fold(cbindgen::Builder::new(), |builder, file| builder.with_src(file));
    let bindings =
        builder.with_config(config).generate().context("cbindgen cannot read the sources; does the library build?")?;
    let mut text = Vec::new();
    bindings.write(&mut text);
    let line = |line: &str| {
        // With tags, cbindgen also refers to types by them.
        let line = match line.starts_with("typedef struct ") || line.starts_with("typedef enum ") {
            true => line.to_owned(),
            false => line.replace("struct Crumple", "Crumple").replace("enum Crumple", "Crumple"),
        };
        let declares = line.ends_with(");") && !line.starts_with("//");
        // Arguments that have no room go below each other.
        let column = line.rfind('(').map_or(0, |parenthesis| parenthesis + 1);
        if declares { wrapped(&line, WIDTH, column) } else { line }
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
