//! Writes `src/gpu/layout.wgsl` in Rust: its constants, and its structs with the offsets that naga gives their members.

use naga::{Literal, Module, ScalarKind, StructMember, TypeInner};
use std::fmt::Write;

/// Constants and structs, to be included by `src/gpu/layout.rs`.
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
    for (_, t) in module.types.iter() {
        let (Some(name), TypeInner::Struct { members, span }) = (&t.name, &t.inner) else { continue };
        writeln!(out, "#[derive(Debug, Clone, Copy, Pod, Zeroable)]\n#[repr(C)]\npub(crate) struct {name} {{")
            .expect("written");
        let mut end = 0;
        for m in members {
            assert_eq!(end, m.offset, "layout.wgsl: there is a gap before {:?} of {name}", m.name);
            let (member, (kind, bytes)) = (m.name.as_deref().expect("a member has a name"), rust_type(module, m));
            writeln!(out, "    pub {member}: {kind},").expect("written");
            end += bytes;
        }
        assert_eq!(end, *span, "layout.wgsl: there is a gap at the end of {name}");
        out += "}\n";
    }
    out
}

/// The type of a member, and its size in bytes.
fn rust_type(module: &Module, member: &StructMember) -> (String, u32) {
    let scalar = |kind| match kind {
        ScalarKind::Uint => "u32",
        ScalarKind::Float => "f32",
        other => panic!("layout.wgsl: {:?} is {other:?}; members are u32 or f32", member.name),
    };
    match &module.types[member.ty].inner {
        TypeInner::Scalar(s) => (scalar(s.kind).to_owned(), 4),
        TypeInner::Vector { size, scalar: s } => (format!("[{}; {}]", scalar(s.kind), *size as u32), 4 * *size as u32),
        other => panic!("layout.wgsl: {:?} is {other:?}; members are numbers and vectors", member.name),
    }
}
