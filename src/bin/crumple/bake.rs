//! `crumple bake`: builds a mesh's example set, writes it as a .crumple file and reports its size and accuracy.

use crate::info;
use crate::output::{Output, progress};
use crate::source::{Input, write_notes};
use crate::table::{Table, count, vertices};
use crate::units::{angle, length, mass};
use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use crumple::{BasisReport, ExampleSet, MeshData, SetOptions, TaskSystem, ThreadPool, VertexMass, import};
use indicatif::ProgressBar;
use std::{fmt::Write, path::PathBuf, time::Instant};

/// Bytes per moved vertex in the plain sparse form: an index and three floats.
const SPARSE: usize = 16;

#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    input: Input,
    /// File for the baked set
    #[arg(short, long, value_name = "OUT.crumple")]
    output: PathBuf,
    /// Largest position error of a stored example, such as 0.1mm (um, mm, cm, m, in; a bare number is metres) [default: exact
    /// floats]
    #[arg(long, value_name = "LENGTH", value_parser = length)]
    tolerance: Option<f32>,
    /// Largest error of a stored normal, such as 1deg or 0.02rad (a bare number is degrees); needs --tolerance
    #[arg(long, value_name = "ANGLE", value_parser = angle, requires = "tolerance")]
    normal_tolerance: Option<f32>,
    /// No vertex moves further than this [default: three times the depth of the deepest example]
    #[arg(long, value_name = "LENGTH", value_parser = length)]
    depth_limit: Option<f32>,
    /// Keep the examples whole, for the rules of the paper (`--rule` of `crumple apply`): on large bodies ten times the memory for each
    #[arg(long)]
    whole_examples: bool,
    /// Leave out the mesh of each part, which only engines that draw parts on their own need: half the file
    #[arg(long)]
    one_mesh: bool,
    /// File with closed solids that dents must not enter, such as a roll cage: every mesh of a glTF or GLB file, where its
    /// node places it in the scene of the body, m; repeat the option for more files
    #[arg(long, value_name = "SOLID.glb")]
    keep_out: Vec<PathBuf>,
    /// Calibration mass of impulses that have none of their own, such as 0.5kg (g, kg, lb; a bare number is kilograms). An impulse
    /// moves its contact by impulse * duration / mass
    #[arg(long, value_name = "MASS", value_parser = mass)]
    vertex_mass: Option<f32>,
    /// Sort the vertices by place, which makes the set smaller and faster. Your vertex buffers must use the same order (see
    /// --permutation)
    #[arg(long)]
    reorder: bool,
    /// File for that order: the source index of each vertex, as little-endian u32. The baked set has it too
    #[arg(long, value_name = "FILE", requires = "reorder")]
    permutation: Option<PathBuf>,
    /// Number of threads; 0 is one per core
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=1024))]
    threads: u32,
}

/// A thread pool that counts the tasks on a progress bar.
struct Shown<'a> {
    pool: ThreadPool,
    bar: &'a ProgressBar,
}

impl TaskSystem for Shown<'_> {
    fn parallel_for(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
        self.bar.inc_length(count as u64);
        self.pool.parallel_for(count, &|i| {
            task(i);
            self.bar.inc(1);
        });
    }

    fn workers(&self) -> usize {
        self.pool.workers()
    }
}

pub fn run(arguments: &Arguments) -> Result<String> {
    let shown = arguments.input.file.display();
    if arguments.input.is_baked()? {
        bail!("{shown} is baked already; bake its source file again with the other options");
    }
    let mut file = Output::create_as(&arguments.output, "crumple", "a .crumple file")?;
    let mut permutation = arguments.permutation.as_deref().map(Output::create).transpose()?;
    ensure!(
        arguments.permutation.as_deref() != Some(&arguments.output),
        "--permutation and --output both name {}; name two files",
        arguments.output.display()
    );
    let bar = progress(3);
    let pool = Shown { pool: ThreadPool::new(arguments.threads as usize)?, bar: &bar };
    bar.set_message("reading");
    let (imported, _) = arguments.input.import()?;
    let part_meshes = if arguments.one_mesh { Vec::new() } else { imported.part_meshes() };
    let (mut mesh, mut examples) = (imported.mesh, imported.examples);
    let kept_out = keep_out((&mut mesh, imported.node_transform), &arguments.keep_out, &pool)?;
    let order = arguments.reorder.then(|| crumple::reorder(&mut mesh, &mut examples));
    bar.inc(1);
    bar.set_message("baking");
    let defaults = SetOptions::default();
    let options = SetOptions {
        depth_limit: arguments.depth_limit,
        mass: arguments.vertex_mass.map_or(VertexMass::None, VertexMass::Uniform),
        tolerance: arguments.tolerance,
        normal_tolerance: arguments.normal_tolerance.unwrap_or(defaults.normal_tolerance),
        whole_examples: arguments.whole_examples,
        basis: arguments.input.basis(),
        ..defaults
    };
    let start = Instant::now();
    let mut set = ExampleSet::build(mesh, examples, options, &pool).with_context(|| shown.to_string())?;
    for mesh in part_meshes {
        set.add_lod(mesh, &pool).with_context(|| shown.to_string())?;
    }
    let built = start.elapsed();
    bar.inc(1);
    bar.set_message("writing");
    if let Some(order) = order {
        if let Some(file) = &mut permutation {
            file.fill(&order.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>())?;
        }
        set.set_source_order(order)?;
    }
    let bytes = set.save()?;
    file.fill(&bytes)?;
    let length = bytes.len();
    let start = Instant::now();
    ExampleSet::load(bytes, &pool).context("the baked set does not load")?;
    let loaded = start.elapsed();
    file.commit()?;
    permutation.map(Output::commit).transpose()?;
    bar.finish_and_clear();

    let mut text = format!("{}: {}\n\n", arguments.output.display(), megabytes(length));
    write_notes(&mut text, "  Warning: ", &imported.notes);
    text.push_str(&kept_out);
    if !imported.parts.is_empty() {
        info::parts(&mut text, &imported.parts)?;
        text.push('\n');
    }
    sizes(&mut text, &set, length);
    if let Some(report) = set.basis_report() {
        followed(&mut text, &report, arguments.input.basis)?;
    }
    info::blows(&mut text, &set);
    info::learned(&mut text, &set)?;
    writeln!(text, "\n  Built in {:.0} ms; loads in {:.2} ms.", built.as_secs_f64() * 1e3, loaded.as_secs_f64() * 1e3)?;
    if let Some(path) = &arguments.permutation {
        writeln!(text, "  Wrote {}: the source index of each vertex.", path.display())?;
    } else if arguments.reorder {
        writeln!(text, "  The order of the vertices differs from the source's; --permutation FILE writes it.")?;
    }
    Ok(text)
}

/// Keeps dents out of the solids of these files. Returns what was done.
fn keep_out(
    (mesh, transform): (&mut MeshData, Option<[[f32; 4]; 4]>),
    files: &[PathBuf],
    tasks: &dyn TaskSystem,
) -> Result<String> {
    let mut text = String::new();
    for path in files {
        let shown = path.display();
        let bytes = std::fs::read(path).with_context(|| format!("cannot read {shown}"))?;
        let solids = import::gltf_solids(&bytes, path.parent(), transform).with_context(|| shown.to_string())?;
        let report = mesh.keep_out(&solids, tasks).with_context(|| shown.to_string())?;
        let (kept, solids) = (vertices(report.limited), count(solids.len(), "solid", "solids"));
        writeln!(text, "  {shown}: keeps {kept} out of {solids}; {} begin inside and do not move", report.inside)?;
    }
    Ok(text)
}

fn megabytes(bytes: usize) -> String {
    if bytes < 100_000 { format!("{:.1} kB", bytes as f64 * 1e-3) } else { format!("{:.2} MB", bytes as f64 * 1e-6) }
}

/// Reports the bytes of each part of a file, compared with the plain sparse form.
fn sizes(text: &mut String, set: &ExampleSet, file: usize) {
    let report = set.report();
    let moved = report.moved_vertices.max(1);
    let whole = if set.options().whole_examples { report.anchored_bytes } else { 0 };
    let nodes = set.basis_report().map_or(0, |nodes| nodes.bytes);
    let mut table = Table::new(&["", ">bytes", ">a moved vertex"]);
    let mut row = |name: &str, bytes: usize| {
        table.row(vec![name.into(), bytes.to_string(), format!("{:.2}", bytes as f64 / moved as f64)]);
    };
    row("plain sparse displacements", moved * SPARSE);
    row("whole examples", whole);
    row("nodes", nodes);
    row("mesh, index and the rest", file - whole - nodes);
    row("file", file);
    table.write(text);
    let (vertices, examples) = (vertices(moved), count(set.examples().len(), "example", "examples"));
    text.push_str(&format!("\n  moved     {vertices} in {examples}\n"));
}

/// Reports the nodes that vertices follow.
fn followed(text: &mut String, report: &BasisReport, tolerance: Option<f32>) -> Result<()> {
    let mm = |x: f32| format!("{:.3} mm", f64::from(x) * 1e3);
    let (nodes, each, size) = (count(report.nodes, "node", "nodes"), report.nodes_a_vertex, megabytes(report.bytes));
    writeln!(text, "\n  nodes     {nodes}; a vertex follows {each:.0} of them, in the mean; {size}")?;
    let off = format!("vertices are off by up to {} in examples and in hits all over the body", mm(report.worst));
    match tolerance.filter(|tolerance| report.worst > *tolerance) {
        None => writeln!(text, "            {off}")?,
        Some(least) => {
            writeln!(text, "  Warning: {off}, where {} was asked for; no more nodes were tried.", mm(least))?;
        }
    }
    Ok(())
}
