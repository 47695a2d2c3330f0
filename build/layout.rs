//! Writes code for both sides from `src/gpu/layout.wgsl`. Rust gets its constants, and assertions that the structs of
//! `src/gpu/layout.rs` have the offsets that naga gives them. WGSL gets functions that load the structs row by row.

use naga::{Literal, Module, ScalarKind, StructMember, TypeInner, VectorSize};
use std::fmt::Write;

/// Bytes of a row. A kernel reads a row at once.
const ROW: u32 = 16;

/// A struct of `layout.wgsl`.
struct Struct<'a> {
    name: &'a str,
    members: &'a [StructMember],
    bytes: u32,
}

fn structs(module: &Module) -> impl Iterator<Item = Struct<'_>> {
    module.types.iter().filter_map(|(_, t)| match (&t.name, &t.inner) {
        (Some(name), TypeInner::Struct { members, span }) => Some(Struct { name, members, bytes: *span }),
        _ => None,
    })
}

/// Constants and assertions, to be included by `src/gpu/layout.rs`.
pub fn rust(module: &Module) -> String {
    let mut out = String::new();
    for (_, constant) in module.constants.iter() {
        let name = constant.name.as_deref().expect("a constant has a name");
        let naga::Expression::Literal(literal) = module.global_expressions[constant.init] else {
            panic!("layout.wgsl: {name} must be a number");
        };
        let (kind, value) = match literal {
            Literal::U32(x) => ("u32", x.to_string()),
            Literal::F32(x) => ("f32", format!("{x:?}")),
            other => panic!("layout.wgsl: {name} is {other:?}; it must be u32 or f32"),
        };
        writeln!(out, "#[allow(dead_code)]\npub(crate) const {name}: {kind} = {value};").expect("written");
    }
    for s in structs(module) {
        let name = s.name;
        writeln!(out, "const _: () = assert!(size_of::<{name}>() == {});", s.bytes).expect("written");
        for m in s.members {
            let (member, kind) = (m.name.as_deref().expect("a member has a name"), rust_type(module, m));
            let offset = m.offset;
            writeln!(out, "const _: () = assert!(std::mem::offset_of!({name}, {member}) == {offset});")
                .expect("written");
            writeln!(out, "const _: fn(&{name}) -> &{kind} = |s| &s.{member};").expect("written");
        }
    }
    out
}

fn rust_type(module: &Module, member: &StructMember) -> String {
    let t = &module.types[member.ty];
    let scalar = |kind| match kind {
        ScalarKind::Uint => "u32",
        ScalarKind::Float => "f32",
        other => panic!("layout.wgsl: {:?} is {other:?}; members are u32 or f32", member.name),
    };
    match &t.inner {
        TypeInner::Scalar(s) => scalar(s.kind).to_owned(),
        TypeInner::Vector { size, scalar: s } => format!("[{}; {}]", scalar(s.kind), count(*size)),
        TypeInner::Struct { .. } => t.name.clone().expect("a struct has a name"),
        other => panic!("layout.wgsl: {:?} is {other:?}; members are numbers, vectors and structs", member.name),
    }
}

fn count(size: VectorSize) -> u32 {
    size as u32
}

/// The functions and constants that a kernel's text names. `load_block_work(index)` and `load_target_work(row)` load a struct,
/// `ROWS_TARGET_WORK` is a struct's size, and `ROW_CARRIED_WORK_NORMALS` is the row at which an inner struct begins.
pub fn loaders(module: &Module, text: &str) -> String {
    let mut out = String::new();
    let mut add = |name: &str, declaration: String| {
        if text.contains(name) {
            out += &declaration;
        }
    };
    for s in structs(module) {
        let (snake, upper) = (snake(s.name), snake(s.name).to_uppercase());
        let rows = s.bytes.div_ceil(ROW);
        let name = format!("ROWS_{upper}");
        add(&name, format!("const {name} = {rows}u;\n"));
        let inner = |m: &&StructMember| matches!(module.types[m.ty].inner, TypeInner::Struct { .. });
        for m in s.members.iter().filter(inner) {
            let member = m.name.as_deref().expect("a member has a name");
            let name = format!("ROW_{upper}_{}", member.to_uppercase());
            assert!(m.offset.is_multiple_of(ROW), "layout.wgsl: {}.{member} does not begin at a row", s.name);
            add(&name, format!("const {name} = {}u;\n", m.offset / ROW));
        }
        let name = format!("load_{snake}");
        if s.members.iter().any(|m| inner(&m)) || !text.contains(&name) {
            continue;
        }
        let values: Vec<String> = s.members.iter().map(|m| value(module, m)).collect();
        let values = values.join(", ");
        let body = if s.bytes == ROW / 2 {
            let select = "select(both.xy, both.zw, (index & 1u) != 0u)";
            format!("(index: u32) -> {} {{\n let both = work[index >> 1u];\n let r0 = {select};\n", s.name)
        } else {
            assert!(s.bytes.is_multiple_of(ROW), "layout.wgsl: {} does not fill its last row", s.name);
            let rows = (0..rows).map(|r| format!(" let r{r} = work[row + {r}u];\n"));
            format!("(row: u32) -> {} {{\n{}", s.name, rows.collect::<String>())
        };
        add(&name, format!("fn {name}{body} return {}({values});\n}}\n", s.name));
    }
    out
}

/// The expression that takes a member's value from the loaded rows.
fn value(module: &Module, member: &StructMember) -> String {
    let (row, first) = (member.offset / ROW, member.offset % ROW / 4);
    let (kind, n) = match &module.types[member.ty].inner {
        TypeInner::Scalar(s) => (s.kind, 1),
        TypeInner::Vector { size, scalar } => (scalar.kind, count(*size)),
        other => panic!("layout.wgsl: {:?} is {other:?}", member.name),
    };
    let words = format!("r{row}.{}", &"xyzw"[first as usize..(first + n) as usize]);
    match (kind, n) {
        (ScalarKind::Float, 1) => format!("bitcast<f32>({words})"),
        (ScalarKind::Float, n) => format!("bitcast<vec{n}<f32>>({words})"),
        _ => words,
    }
}

/// `BlockWork` as `block_work`.
fn snake(name: &str) -> String {
    let mut out = String::new();
    for c in name.chars() {
        if c.is_uppercase() && !out.is_empty() {
            out.push('_');
        }
        out.push(c.to_ascii_lowercase());
    }
    out
}
