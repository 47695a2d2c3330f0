//! Stage "rooms": the folders of `src` are layers. A file imports from its own room and from rooms above it in `ROOMS`, and the files of
//! a room import each other without circles. Modules of tests inside `src` are exempt, and so is `lib.rs`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use syn::visit::{self, Visit};
use syn::{Attribute, Item, ItemMod, ItemUse, UseTree, Visibility};

use crate::files::{files_of, read, within};

/// From top to bottom. Rooms that a bar joins do not import each other.
const ROOMS: &str = "base mesh basis predict example damage select bake deform classic instance contacts io gpu graph|vulkan|wgpu capi bin";

/// A module's path from the root: `["deform", "tracker"]`.
type Module = Vec<String>;

pub fn stage() -> Result<()> {
    let source = |path: &PathBuf| Ok((within(Path::new("src"), path)?, read(path)?));
    let sources = files_of("src", &["rs"])?.iter().map(source).collect::<Result<Vec<_>>>()?;
    let findings = check(&sources)?;
    findings.iter().for_each(|finding| println!("{finding}"));
    ensure!(findings.is_empty(), "{} imports of src break the order of the rooms", findings.len());
    println!("the imports of {} files keep the order of the rooms", sources.len());
    Ok(())
}

/// What breaks the order in `sources`, pairs of a path below `src` and a text.
fn check(sources: &[(String, String)]) -> Result<Vec<String>> {
    let (mut tree, mut parsed) = (Tree::default(), Vec::new());
    for (name, text) in sources {
        let (module, file) = (module_of(name), syn::parse_file(text).with_context(|| format!("reading src/{name}"))?);
        tree.add(name, &module, &file.items);
        parsed.push((name.as_str(), module, file));
    }
    parsed.retain(|(name, module, _)| *name != "lib.rs" && !tree.tests.iter().any(|test| module.starts_with(test)));
    let (mut arrows, mut findings) = (BTreeMap::new(), Vec::new());
    for (name, module, file) in &parsed {
        Imports { tree: &tree, name, module: module.clone(), arrows: &mut arrows }.visit_file(file);
        if level(name).is_none() {
            findings.push(format!("src/{name}: is in no room"));
        }
    }
    let inside = || arrows.iter().filter(|((from, to), _)| room(from) == room(to));
    for ((from, to), (line, path)) in &arrows {
        if room(from) != room(to) && level(from) <= level(to) {
            findings.push(format!("src/{from}:{line}: {} may not import from {}: {path}", room(from), room(to)));
        }
    }
    for ((from, to), (line, path)) in inside() {
        let (mut reached, mut left) = (BTreeSet::new(), vec![*to]);
        while let Some(file) = left.pop() {
            let next = inside().filter(|((from, _), _)| *from == file).map(|((_, to), _)| *to);
            left.extend(next.filter(|file| reached.insert(*file)));
        }
        if reached.contains(from) {
            findings.push(format!("src/{from}:{line}: a circle of imports leads through src/{to}: {path}"));
        }
    }
    Ok(findings)
}

fn module_of(name: &str) -> Module {
    let path = name.trim_end_matches(".rs").trim_end_matches("/mod").trim_end_matches("/main");
    path.split('/').filter(|part| *part != "lib").map(str::to_owned).collect()
}

/// The first folder, or the file's own name.
fn room(name: &str) -> &str {
    name.split('/').next().unwrap_or_default().trim_end_matches(".rs")
}

fn level(name: &str) -> Option<usize> {
    ROOMS.split(' ').position(|rooms| rooms.split('|').any(|known| known == room(name)))
}

/// The modules of the crate, the files that hold them, and the names that each gets by `use`.
#[derive(Default)]
struct Tree<'a> {
    files: BTreeMap<Module, &'a str>,
    names: BTreeMap<(Module, String), Vec<String>>,
    tests: Vec<Module>,
}

impl<'a> Tree<'a> {
    fn add(&mut self, name: &'a str, module: &Module, items: &[Item]) {
        self.files.insert(module.clone(), name);
        for item in items {
            match item {
                Item::Use(item) if !for_tests(&item.attrs) => {
                    let leaves = leaves(&item.tree, &[]).into_iter();
                    self.names.extend(leaves.map(|(path, name, _)| ((module.clone(), name), path)));
                }
                Item::Mod(item) => {
                    let inner = [module.as_slice(), &[item.ident.to_string()]].concat();
                    if for_tests(&item.attrs) {
                        self.tests.push(inner);
                    } else if let Some((_, items)) = &item.content {
                        self.add(name, &inner, items);
                    }
                }
                _ => {}
            }
        }
    }

    /// The module that defines what `path` names when it is written in `module`. Nothing for other crates.
    fn resolve(&self, module: &Module, path: &[String], depth: usize) -> Option<Module> {
        let (first, mut rest) = path.split_first()?;
        let mut at = module.clone();
        match first.as_str() {
            "crate" => at.truncate(if module.first().is_some_and(|room| room == "bin") { 2 } else { 0 }),
            "self" => {}
            "super" => {
                at.pop();
            }
            _ => {
                let local = self.names.contains_key(&(at.clone(), first.clone()));
                let child = path.len() > 1 && self.files.contains_key(&[at.as_slice(), &path[..1]].concat());
                if !local && !child {
                    return None;
                }
                rest = path;
            }
        }
        while let Some((name, after)) = rest.split_first() {
            let inner = [at.as_slice(), &rest[..1]].concat();
            if name == "super" {
                at.pop();
            } else if self.files.contains_key(&inner) {
                at = inner;
            } else if let Some(path) = self.names.get(&(at.clone(), name.clone())).filter(|_| depth < 9) {
                return self.resolve(&at, &[path.as_slice(), after].concat(), depth + 1);
            } else {
                break;
            }
            rest = after;
        }
        Some(at)
    }
}

/// Collects the arrows of one file.
struct Imports<'t, 'a> {
    tree: &'t Tree<'a>,
    name: &'a str,
    module: Module,
    /// By both files: the line of the first import, and its path.
    arrows: &'t mut BTreeMap<(&'a str, &'a str), (usize, String)>,
}

impl Imports<'_, '_> {
    fn arrow(&mut self, path: &[String], line: usize) {
        let Some(module) = self.tree.resolve(&self.module, path, 0) else { return };
        let to = self.tree.files.get(&module).copied().filter(|to| *to != "lib.rs" && *to != self.name);
        if let Some(to) = to {
            self.arrows.entry((self.name, to)).or_insert((line, path.join("::")));
        }
    }
}

impl<'ast> Visit<'ast> for Imports<'_, '_> {
    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        // A re-export is no import: whoever uses the name imports from where it leads.
        if matches!(item.vis, Visibility::Inherited) && !for_tests(&item.attrs) {
            leaves(&item.tree, &[]).iter().for_each(|(path, _, line)| self.arrow(path, *line));
        }
    }

    fn visit_item_mod(&mut self, item: &'ast ItemMod) {
        if !for_tests(&item.attrs) {
            self.module.push(item.ident.to_string());
            visit::visit_item_mod(self, item);
            self.module.pop();
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let names: Vec<String> = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        self.arrow(&names, path.segments[0].ident.span().start().line);
        visit::visit_path(self, path);
    }

    /// The visitor does not look inside macros: every `a::b` there counts as a path.
    fn visit_macro(&mut self, call: &'ast syn::Macro) {
        visit::visit_macro(self, call);
        let tokens = call.tokens.to_string().replace(" :: ", "::");
        for path in tokens.split(|letter: char| !letter.is_alphanumeric() && !"_:".contains(letter)) {
            let names: Vec<String> = path.split("::").map(str::to_owned).collect();
            self.arrow(&names, call.path.segments[0].ident.span().start().line);
        }
    }

    fn visit_vis_restricted(&mut self, _: &'ast syn::VisRestricted) {}

    fn visit_attribute(&mut self, _: &'ast Attribute) {}
}

/// Whether `#[cfg(test)]`, alone or among others, is on an item.
fn for_tests(attributes: &[Attribute]) -> bool {
    let test = |attribute: &Attribute| {
        let tokens = attribute.meta.require_list().map(|list| list.tokens.to_string()).unwrap_or_default();
        let mut words = tokens.split(|letter: char| !letter.is_alphanumeric());
        attribute.path().is_ident("cfg") && !tokens.contains("not") && words.any(|word| word == "test")
    };
    attributes.iter().any(test)
}

/// A path of a `use`, the name that it gets, and its line.
type Leaf = (Vec<String>, String, usize);

/// Every path of a `use` below `above`.
fn leaves(tree: &UseTree, above: &[String]) -> Vec<Leaf> {
    let (own, name) = match tree {
        UseTree::Path(part) => return leaves(&part.tree, &[above, &[part.ident.to_string()]].concat()),
        UseTree::Group(group) => return group.items.iter().flat_map(|tree| leaves(tree, above)).collect(),
        UseTree::Glob(star) => return vec![(above.to_vec(), "*".to_owned(), star.star_token.spans[0].start().line)],
        UseTree::Name(last) => (&last.ident, &last.ident),
        UseTree::Rename(last) => (&last.ident, &last.rename),
    };
    let mut path = above.to_vec();
    if own != "self" || above.is_empty() {
        path.push(own.to_string());
    }
    let name = if name == "self" { path.last().cloned().unwrap_or_default() } else { name.to_string() };
    vec![(path, name, own.span().start().line)]
}

/// That good imports are found good, the stage itself shows.
#[cfg(test)]
mod tests {
    use super::*;

    const LIB: &str = "mod base; mod deform; mod instance; pub use base::math::Aabb; pub use instance::Instance;";

    fn findings(files: &[(&str, &str)]) -> Vec<String> {
        let sources: Vec<_> = files.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())).collect();
        check(&sources).unwrap()
    }

    #[test]
    fn an_import_from_a_room_below_is_named() {
        let files = [
            ("lib.rs", LIB),
            ("instance.rs", "pub struct Instance;"),
            ("base/mod.rs", "fn f() {\n    let one = crate::instance::Instance;\n}"),
            ("deform/mod.rs", "\nuse crate::Instance as Other;"),
            ("vulkan/mod.rs", "macro_rules! m { () => { $crate::wgpu::run() } }"),
            ("wgpu/mod.rs", "pub fn run() {}"),
            ("other.rs", ""),
        ];
        let expected = [
            "src/other.rs: is in no room",
            "src/base/mod.rs:2: base may not import from instance: crate::instance::Instance",
            "src/deform/mod.rs:2: deform may not import from instance: crate::Instance",
            "src/vulkan/mod.rs:1: vulkan may not import from wgpu: crate::wgpu::run",
        ];
        assert_eq!(findings(&files), expected);
    }

    #[test]
    fn a_circle_inside_a_room_is_named() {
        let files = [
            ("lib.rs", "mod capi;"),
            ("capi/mod.rs", "mod a; mod b; mod c; pub use a::one; pub use b::Two;"),
            ("capi/a.rs", "use super::Two;\npub fn one() {}"),
            ("capi/b.rs", "pub struct Two;\nfn f() { super::one() }"),
            ("capi/c.rs", "use super::a::one;"),
        ];
        let expected = [
            "src/capi/a.rs:1: a circle of imports leads through src/capi/b.rs: super::Two",
            "src/capi/b.rs:2: a circle of imports leads through src/capi/a.rs: super::one",
        ];
        assert_eq!(findings(&files), expected);
    }
}
