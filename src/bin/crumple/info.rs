//! `crumple info`: reports a file's mesh and examples, how well the examples predict each other, and where they do not
//! reach.

use crate::picture::millimetres;
use crate::source::{Input, Source, write_notes};
use crate::table::{Table, count, digits, percent, plain, point, vertices};
use anyhow::Result;
use clap::Args;
use crumple::glam::Vec3;
use crumple::import::{Part, PartKind};
use crumple::{Aabb, ExampleSet, Mesh, Mirror, ThreadPool};
use std::fmt::Write;

#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    input: Input,
}

pub fn run(arguments: &Arguments) -> Result<String> {
    let source = arguments.input.load(&ThreadPool::new(0)?)?;
    let mut text = format!("{}\n", arguments.input.file.display());
    body(&mut text, &source)?;
    examples(&mut text, &source.set, source.scale());
    learned(&mut text, &source.set)?;
    reach(&mut text, &source.set)?;
    Ok(text)
}

fn body(text: &mut String, source: &Source) -> Result<()> {
    let (mesh, scale) = (source.set.mesh(), source.scale());
    let name = Some(plain(&source.about.name)).filter(|name| !name.is_empty()).unwrap_or("(no name)".into());
    let (all, triangles) = (vertices(mesh.positions().len()), count(mesh.triangles().len(), "triangle", "triangles"));
    let primitives = count(source.about.primitives.len().max(1), "primitive", "primitives");
    writeln!(text, "  mesh      {name}: {all}, {triangles}, {primitives}, {} on seams", mesh.seam_count())?;
    let size = mesh.bounds().max - mesh.bounds().min;
    let sides = |size: Vec3| format!("{:.3} x {:.3} x {:.3}", size.x, size.y, size.z);
    writeln!(text, "  size      {} m", sides(size * scale))?;
    if scale != 1.0 {
        let (times, own) = (digits(scale), sides(size));
        writeln!(
            text,
            "  scale     {times}: its node scales the mesh, which is {own} in its own space. Lengths here are the scene's, points the mesh's own"
        )?;
    }
    writeln!(text, "  limit     no vertex moves further than {} mm", millimetres(source.set.depth_limit() * scale))?;
    let megabytes = source.set.memory_bytes() as f64 * 1e-6;
    writeln!(text, "  memory    {megabytes:.1} MB for mesh and examples, shared by all copies")?;
    let report = source.set.report();
    writeln!(text, "  mirror    {}", planes(report.mirror_planes))?;
    if report.held_vertices > 0 {
        let held = vertices(report.held_vertices);
        writeln!(text, "  rim       {held} on edges that the examples show to be held; dents do not move them")?;
    }
    if report.limited_vertices + report.stiff_vertices > 0 {
        let (limited, stiff, rigid) = (vertices(report.limited_vertices), report.stiff_vertices, report.rigid_vertices);
        writeln!(text, "  limits    {limited} with a depth limit, {stiff} with a stiffness; {rigid} cannot move")?;
    }
    if report.welded > 0 {
        let (welded, widest) = (report.welded, millimetres(report.widest_weld));
        writeln!(
            text,
            "  note      the examples tear {welded} seam vertices apart, by up to {widest} mm; they were welded"
        )?;
    }
    if report.repaired_normals > 0 {
        writeln!(text, "  note      {} normals of length zero were replaced", report.repaired_normals)?;
    }
    if report.degenerate_triangles > 0 {
        writeln!(text, "  note      {} triangles have no area", report.degenerate_triangles)?;
    }
    write_notes(text, "  warning   ", &source.about.notes);
    if source.about.parts.is_empty() { levels(text, &source.set) } else { parts(text, &source.about.parts) }
}

/// Reports the parts of a body.
pub fn parts(text: &mut String, parts: &[Part]) -> Result<()> {
    for (i, part) in parts.iter().enumerate() {
        let kind = match part.kind {
            PartKind::Dents => "",
            PartKind::Rigid => ", rigid",
            PartKind::Glass => ", glass",
        };
        let (name, vertices) = (plain(&part.name), vertices(part.vertices.len()));
        writeln!(text, "  part {:<4} {name}: {vertices}{kind}", i + 1)?;
    }
    Ok(())
}

/// A level of detail that is further than this from the base surface causes a warning; a share of the body's diagonal.
const FAR_OFF: f32 = 0.02;

/// Reports the levels of detail and which of them probably belong to another body or are in another unit.
fn levels(text: &mut String, set: &ExampleSet) -> Result<()> {
    let bounds = set.mesh().bounds();
    let far = FAR_OFF * bounds.max.distance(bounds.min);
    for (i, level) in set.report().lods.iter().enumerate() {
        let (vertices, off) = (vertices(level.vertices), millimetres(level.farthest));
        writeln!(text, "  level {}   {vertices}, at most {off} mm off the base surface", i + 1)?;
        if level.farthest > far {
            writeln!(
                text,
                "  warning   level {} lies far off the base surface; is it the same body, in the same space and unit (m)?",
                i + 1
            )?;
        }
    }
    Ok(())
}

/// The planes in which mirror images of examples are used.
fn planes(planes: Mirror) -> String {
    let names: Vec<&str> =
        (0..3).filter(|k| planes.bits() >> k & 1 == 1).map(|k| ["x", "y", "z"][k as usize]).collect();
    match names.as_slice() {
        [] => "no plane maps the body onto itself".into(),
        names => format!("the body is the same on both sides in {}; examples serve both", names.join(", ")),
    }
}

/// `scale` takes lengths of the mesh's space to the scene's.
fn examples(text: &mut String, set: &ExampleSet, scale: f32) {
    text.push('\n');
    let heads =
        [">#", "example", ">moved", ">depth mm", ">deepest mm", ">support m", ">contact", "contact point m", ">error"];
    let mut table = Table::new(&heads);
    for (i, (e, error)) in set.examples().iter().zip(set.example_errors()).enumerate() {
        table.row(vec![
            i.to_string(),
            e.name().to_owned(),
            e.moved_vertices().to_string(),
            millimetres(e.depth() * scale),
            millimetres(e.max_depth() * scale),
            format!("{:.3}", e.support_radius() * scale),
            e.contact_vertex().to_string(),
            point(e.contact_point()),
            if e.is_empty() { "empty".into() } else { format!("{error:.2}") },
        ]);
    }
    table.write(text);
    blows(text, set);
}

/// Reports how many examples know their blow.
pub fn blows(text: &mut String, set: &ExampleSet) {
    let known = set.examples().iter().filter(|e| e.blow().total_impulse().is_some()).count();
    let all = count(set.examples().len(), "example", "examples");
    let known = match known {
        0 => "no example knows its blow".into(),
        1 => format!("1 of {all} knows its blow"),
        _ => format!("{known} of {all} know their blow"),
    };
    text.push_str(&format!("\n  blows     {known}\n"));
}

/// Reports how well the examples predict each other, each left out in turn.
pub fn learned(text: &mut String, set: &ExampleSet) -> Result<()> {
    let errors = set.example_errors();
    let mut left: Vec<usize> = (0..errors.len()).filter(|i| !set.examples()[*i].is_empty()).collect();
    left.sort_by(|a, b| errors[*a].total_cmp(&errors[*b]));
    let Some(worst) = left.last().filter(|_| left.len() > 1) else { return Ok(()) };
    text.push_str("\n  Examples predict each other\n");
    let median = errors[left[left.len() / 2]];
    writeln!(
        text,
        "  error     {median:.2}, median over the examples left out in turn; 0 is perfect, no dent at all is 1"
    )?;
    let name = plain(set.examples()[*worst].name());
    writeln!(text, "  worst     {:.2}, {name} (#{worst}): one more near it would help most", errors[*worst])?;
    Ok(())
}

/// Reports which part of the body the examples move where they were made.
fn reach(text: &mut String, set: &ExampleSet) -> Result<()> {
    let mesh = set.mesh();
    let reached = moved(set);
    let missed = reached.iter().filter(|r| !**r).count();
    let areas = vertex_areas(mesh);
    let (mut area, mut missed_area) = (0.0, 0.0);
    for (a, reached) in areas.iter().zip(&reached) {
        area += a;
        missed_area += if *reached { 0.0 } else { *a };
    }
    text.push('\n');
    if missed == 0 {
        writeln!(text, "  The examples move every vertex.")?;
        return Ok(());
    }
    let all = set.vertex_count();
    let (share, of_area) = (percent(missed as f64, all as f64), percent(missed_area, area));
    writeln!(text, "  The examples do not move {missed} of {all} vertices ({share}; {of_area} of the area).")?;
    let regions = regions(mesh, &reached);
    if let Some(largest) = regions.first() {
        let Aabb { min, max } = Aabb::of(largest.iter().map(|&v| &mesh.positions()[v as usize]));
        let (regions, largest) = (count(regions.len(), "region", "regions"), vertices(largest.len()));
        let (centre, min, max) = (point((min + max) * 0.5), point(min), point(max));
        writeln!(text, "  They lie in {regions}; the largest has {largest}, centre {centre}, from {min} to {max} m.")?;
    }
    Ok(())
}

/// Which vertices the examples move.
pub fn moved(set: &ExampleSet) -> Vec<bool> {
    (0..set.vertex_count() as u32).map(|v| set.examples().iter().any(|e| e.delta(v) != Vec3::ZERO)).collect()
}

/// The area of each vertex: a third of that of the triangles around it, m².
fn vertex_areas(mesh: &Mesh) -> Vec<f64> {
    let mut areas = vec![0.0; mesh.positions().len()];
    for t in mesh.triangles() {
        let [a, b, c] = t.map(|i| mesh.positions()[i as usize].as_dvec3());
        for &i in t {
            areas[i as usize] += (b - a).cross(c - a).length() / 6.0;
        }
    }
    areas
}

/// Connected regions of vertices that no example reaches, largest first. Vertices at one position count as connected.
fn regions(mesh: &Mesh, reached: &[bool]) -> Vec<Vec<u32>> {
    let mut parent: Vec<u32> = mesh.weld().to_vec();
    let mut join = |a: u32, b: u32| {
        let (a, b) = (root(&mut parent, a), root(&mut parent, b));
        parent[a.max(b) as usize] = a.min(b);
    };
    for t in mesh.triangles() {
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[0], t[2])] {
            if !reached[a as usize] && !reached[b as usize] {
                join(a, b);
            }
        }
    }
    let mut regions = std::collections::BTreeMap::<u32, Vec<u32>>::new();
    for v in (0..reached.len() as u32).filter(|&v| !reached[v as usize]) {
        regions.entry(root(&mut parent, v)).or_default().push(v);
    }
    let mut regions: Vec<_> = regions.into_values().collect();
    regions.sort_by_key(|r| std::cmp::Reverse(r.len()));
    regions
}

fn root(parent: &mut [u32], mut v: u32) -> u32 {
    while parent[v as usize] != v {
        parent[v as usize] = parent[parent[v as usize] as usize];
        v = parent[v as usize];
    }
    v
}
