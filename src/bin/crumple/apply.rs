//! `crumple apply`: dents a mesh with a list of impacts; writes a GLB and pictures.

use crate::impacts::{self, Impact};
use crate::output::{Output, progress};
use crate::picture::{Kind, Subject, millimetres};
use crate::source::{FAR_OFF, Input, Source, write_notes};
use crate::table::{Table, count, digits, percent};
use crate::vertices::Deformed;
use anyhow::{Context, Result, bail};
use clap::Args;
use crumple::glam::Vec3;
use crumple::{HitStatus, Instance, InstanceOptions, Outcome, Rule, Space, ThreadPool};
use std::fmt::Write;
use std::path::PathBuf;

/// Vertices that moved less than this are not reported as moved, m.
const VISIBLE: f32 = 1e-5;

#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    input: Input,
    /// JSON list of impacts, as docs/impacts.md describes; `crumple sample` writes one to start from
    #[arg(long, value_name = "IMPACTS.json")]
    impacts: PathBuf,
    /// File for the dented mesh; everything else of a glTF file is kept
    #[arg(short, long, value_name = "OUT.glb")]
    output: PathBuf,
    /// Directory for base.png, after.png, heat.png and before_after.png; it is created if needed
    #[arg(long, value_name = "DIR")]
    png: Option<PathBuf>,
    /// Size of the pictures, pixels; the time to draw them is in proportion
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "1280x800", value_parser = size)]
    size: [usize; 2],
    /// How impacts add up: marks, or one of the paper's classic rules, most-displaced or blend=K (K from 0 to 1)
    #[arg(long, default_value = "marks", value_parser = rule)]
    rule: Rule,
    /// Number of threads; 0 is one per core
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=1024))]
    threads: u32,
    /// Deform on the GPU and compare with the CPU's vertices. Takes the fastest GPU, or the one whose name contains NAME
    #[arg(long, value_name = "NAME", num_args = 0..=1, default_missing_value = "")]
    gpu: Option<String>,
}

fn rule(text: &str) -> Result<Rule, String> {
    match text.split_once('=') {
        None if text == "marks" => Ok(Rule::Marks),
        None if text == "most-displaced" => Ok(Rule::MostDisplaced),
        Some(("blend", k)) => match k.parse::<f32>() {
            Ok(k) if (0.0..=1.0).contains(&k) => Ok(Rule::Blend(k)),
            _ => Err(format!("blend's K is '{k}'; it must be a number from 0 to 1")),
        },
        _ => Err("it must be marks, most-displaced or blend=K".into()),
    }
}

pub fn run(arguments: &Arguments) -> Result<String> {
    let impacts = impacts::read(&arguments.impacts)?;
    let mut file = Output::create_as(&arguments.output, "glb", "a GLB")?;
    if same_file(&arguments.output, &arguments.input.file) {
        bail!("{} is the input; writing it would delete its examples; name another file", arguments.output.display());
    }
    let pool = ThreadPool::new(arguments.threads as usize)?;
    let pictures = if arguments.png.is_some() { &Kind::ALL[..] } else { &[] };
    let bar = progress(impacts.len() + 3 + pictures.len());
    bar.set_message("reading");
    let source = arguments.input.load(&pool)?;
    if arguments.png.is_some() && source.set.mesh().triangles().is_empty() {
        bail!("the mesh has no triangles, so no picture can be drawn; remove --png");
    }
    bar.inc(1);

    bar.set_message("hits");
    let mut instance = Instance::new(source.set.clone(), options(arguments))?;
    source.spare_glass(&mut instance)?;
    if let Some(transform) = source.transform()
        && impacts.iter().any(|i| i.hit.space == Space::World)
    {
        instance.set_transform(transform).context("the transform of the mesh's node")?;
    }
    let mut outcomes = Vec::with_capacity(impacts.len());
    for (i, impact) in impacts.iter().enumerate() {
        let outcome = instance.submit(&impact.hit);
        outcomes.push(outcome.with_context(|| format!("{}: impact {i}", arguments.impacts.display()))?);
        bar.inc(1);
    }

    bar.set_message("deforming");
    let deformed = Deformed::new(&mut instance, &pool, arguments.threads, arguments.gpu.as_deref())?;
    bar.inc(1);
    bar.set_message("writing");
    let exported = source.deformed_glb(&deformed.vertices)?;
    file.fill(&exported.glb)?;
    bar.inc(1);

    let mut files = vec![file];
    if let Some(folder) = &arguments.png {
        std::fs::create_dir_all(folder).with_context(|| format!("cannot make the directory {}", folder.display()))?;
        let mut outputs = Vec::new();
        for kind in pictures {
            outputs.push(Output::create(&folder.join(kind.file_name()))?);
        }
        let workers = rayon::ThreadPoolBuilder::new().num_threads(arguments.threads as usize).build()?;
        for (kind, mut output) in pictures.iter().zip(outputs) {
            bar.set_message(kind.file_name());
            output.fill(&workers.install(|| draw(*kind, arguments.size, &source, &deformed, &outcomes))?)?;
            files.push(output);
            bar.inc(1);
        }
    }
    for file in files {
        file.commit()?;
    }
    bar.finish_and_clear();
    let left = match instance.marks() {
        Ok(marks) => count(marks.len(), "mark", "marks"),
        Err(_) => "per-vertex state".to_owned(),
    };
    let done = Done { source: &source, impacts: &impacts, outcomes: &outcomes, limit: instance.depth_limit() };
    let mut text = done.report(arguments, &left, &deformed)?;
    write_notes(&mut text, "  Warning: ", &[&source.about.notes[..], &exported.notes].concat());
    Ok(text)
}

fn options(arguments: &Arguments) -> InstanceOptions {
    match arguments.rule {
        Rule::Marks => InstanceOptions::default(),
        rule => InstanceOptions::classic(rule),
    }
}

fn same_file(a: &std::path::Path, b: &std::path::Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// Parses the size of a picture.
fn size(text: &str) -> Result<[usize; 2], String> {
    let sides = text.split_once(['x', 'X']).map(|(w, h)| [w, h].map(|side| side.trim().parse::<usize>()));
    match sides {
        Some([Ok(width), Ok(height)]) if (64..=8192).contains(&width) && (40..=8192).contains(&height) => {
            Ok([width, height])
        }
        _ => Err("it must be WIDTHxHEIGHT, from 64x40 to 8192x8192".into()),
    }
}

fn draw(kind: Kind, size: [usize; 2], source: &Source, deformed: &Deformed, outcomes: &[Outcome]) -> Result<Vec<u8>> {
    let mesh = source.set.mesh();
    let vectors = |v: &[[f32; 3]]| v.iter().map(|&p| Vec3::from(p)).collect::<Vec<_>>();
    let after = vectors(&deformed.vertices.positions);
    let after_normals = deformed.vertices.normals.as_deref().map(vectors).unwrap_or_default();
    let marked = outcomes.iter().filter(|o| o.status == HitStatus::Marked);
    let subject = Subject {
        triangles: mesh.triangles(),
        before: mesh.positions(),
        before_normals: mesh.normals().unwrap_or_default(),
        after: &after,
        after_normals: &after_normals,
        coats: (&source.coats.0, &source.coats.1),
        contacts: &marked.map(|o| o.contact_vertex).collect::<Vec<_>>(),
        up: source.up(),
        size,
    };
    let description = match kind {
        Kind::Base => "before".to_owned(),
        Kind::After => "after".to_owned(),
        Kind::BeforeAfter => "before and after".to_owned(),
        Kind::Heat => format!("displacement, 0 to {} mm", subject.deepest().1 * 1e3),
    };
    Ok(subject.draw(kind).to_png(&description)?)
}

/// What was asked for, and what came of it. Lengths are reported as the scene's.
struct Done<'a> {
    source: &'a Source,
    impacts: &'a [Impact],
    outcomes: &'a [Outcome],
    /// The instance's depth limit, m.
    limit: f32,
}

impl Done<'_> {
    fn mm(&self, length: f32) -> String {
        millimetres(length * self.source.scale())
    }

    /// `left` is the damage.
    fn report(&self, arguments: &Arguments, left: &str, deformed: &Deformed) -> Result<String> {
        let Done { source, impacts, outcomes, .. } = *self;
        let mut text = String::new();
        let heads = [">#", "impact", ">vertex", ">off mm", ">target mm", ">achieved mm", ">short mm", "expected error"];
        let mut table = Table::new(&heads);
        for (i, (impact, outcome)) in impacts.iter().zip(outcomes).enumerate() {
            let length = |v: [f32; 3]| self.mm(Vec3::from(v).length());
            table.row(vec![
                i.to_string(),
                impact.name.clone().unwrap_or_default(),
                outcome.contact_vertex.to_string(),
                self.mm(outcome.contact_distance),
                length(outcome.target),
                length(outcome.achieved),
                length(outcome.shortfall()),
                self.left(outcome),
            ]);
        }
        if !impacts.is_empty() {
            table.write(&mut text);
        }
        let (set, scale) = (&source.set, source.scale());
        let (mut moved, mut deepest) = (0, (0, 0.0));
        for (v, (after, before)) in deformed.vertices.positions.iter().zip(set.mesh().positions()).enumerate() {
            let d = (Vec3::from(*after) - *before).length();
            moved += usize::from(d * scale > VISIBLE);
            if d > deepest.1 {
                deepest = (v, d);
            }
        }
        let marked = outcomes.iter().filter(|o| o.status == HitStatus::Marked).count();
        if impacts.is_empty() {
            writeln!(text, "  The list of impacts is empty: the mesh is written without a dent.")?;
        } else {
            let all = count(impacts.len(), "impact", "impacts");
            writeln!(text, "\n  {marked} of {all} left a dent; the damage is {left}.")?;
        }
        if moved > 0 {
            writeln!(
                text,
                "  {moved} of {} vertices moved by more than {} mm ({}), vertex {} furthest: {} mm.",
                set.vertex_count(),
                VISIBLE * 1e3,
                percent(moved as f64, set.vertex_count() as f64),
                deepest.0,
                self.mm(deepest.1)
            )?;
        }
        let scaled = scale != 1.0 && impacts.iter().any(|impact| impact.hit.space == Space::Local);
        if moved == 0 && (marked > 0 || scaled) {
            let why = if scaled {
                "; the node scales the mesh, and impacts are in its own space and unit: give them \"space\": \"world\" for the scene's"
            } else {
                "; check the impacts' unit (m)"
            };
            writeln!(text, "  Warning: no vertex moved by more than {} mm{why}.", VISIBLE * 1e3)?;
        }
        if scale != 1.0 {
            writeln!(text, "  Lengths are the scene's: the node scales the mesh by {}.", digits(scale))?;
        }
        self.warn(&mut text)?;
        let (vertices, time) = (set.vertex_count(), deformed.time.as_secs_f64() * 1e3);
        writeln!(text, "  Deformed {vertices} vertices in {time:.2} ms on {}.", deformed.by)?;
        writeln!(text, "  Wrote {}", arguments.output.display())?;
        if let Some(folder) = &arguments.png {
            let names = Kind::ALL.map(Kind::file_name).join(", ");
            writeln!(text, "  Wrote {names} in {}", folder.display())?;
        }
        Ok(text)
    }

    /// Whether a hit asked for more than the depth limit, of the instance or of its vertex, by more than a rounding.
    fn is_cut(&self, outcome: &Outcome) -> bool {
        let limited = self.source.set.report().limited_vertices > 0;
        outcome.clamped && (limited || asked(outcome) > f64::from(self.limit) * (1.0 + 1e-5))
    }

    /// Warns of impacts whose numbers are probably in the wrong unit or space.
    fn warn(&self, text: &mut String) -> std::fmt::Result {
        let set = &self.source.set;
        let name = |i: usize| match &self.impacts[i].name {
            Some(name) => format!("impact {i} '{name}'"),
            None => format!("impact {i}"),
        };
        // How many impacts have a length, and the one with the greatest.
        let worst = |length: &dyn Fn(&Outcome) -> Option<f32>| {
            let all: Vec<(usize, f32)> =
                self.outcomes.iter().enumerate().filter_map(|(i, o)| Some((i, length(o)?))).collect();
            all.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, most)| (all.len(), name(i), self.mm(most)))
        };
        if let Some((cut, name, most)) = worst(&|o| self.is_cut(o).then_some(asked(o) as f32)) {
            let own = if set.report().limited_vertices > 0 { ", or that of its vertex," } else { "" };
            let (cut, limit) = (count(cut, "impact", "impacts"), self.mm(self.limit));
            writeln!(
                text,
                "  Warning: {cut} asked for more than the depth limit of {limit} mm{own} and got the limit; {name} asked for {most} mm."
            )?;
        }
        let far = FAR_OFF * set.mesh().bounds().diagonal();
        if let Some((missed, name, most)) = worst(&|o| Some(o.contact_distance).filter(|off| *off > far)) {
            let (missed, far) = (count(missed, "impact lies", "impacts lie"), self.mm(far));
            writeln!(
                text,
                "  Warning: {missed} more than {far} mm from the nearest vertex; {name} is {most} mm off. Check the points' space and unit (m)."
            )?;
        }
        Ok(())
    }

    /// The expected error of a hit's dent, the example of a classic rule, or the reason why it leaves nothing.
    fn left(&self, outcome: &Outcome) -> String {
        let what = match outcome.status {
            HitStatus::BelowYield => return "below yield: no mark".into(),
            HitStatus::Rigid => return "the part is rigid: no mark".into(),
            HitStatus::NothingReaches => return "no example moves the contact".into(),
            _ => match outcome.classic {
                Some(chosen) => {
                    let name = self.source.set.examples().get(chosen.example as usize).map_or("?", |e| e.name());
                    format!("{name} x{:.2}", chosen.weight)
                }
                None => outcome.expected_error.map(|error| format!("{error:.2}")).unwrap_or_default(),
            },
        };
        if self.is_cut(outcome) { format!("{what}; cut to the depth limit") } else { what }
    }
}

/// The length of the displacement that a hit asked for, m.
fn asked(outcome: &Outcome) -> f64 {
    Vec3::from(outcome.target).as_dvec3().length()
}
