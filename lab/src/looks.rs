//! How dents look, beside how far they are off: normals, roughness and pictures. Single hits that no example shows on every
//! body, and bodies that are hit again and again.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, Result};
use crumple::{ExampleSet, Hit, InstanceOptions, Rule, SetOptions};
use glam::{DVec3, Vec3};
use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8, FlipPool};

use crate::Options;
use crate::accuracy::law::{Law, Sees, target};
use crate::accuracy::pod::Pod;
use crate::accuracy::radial::Radial;
use crate::metric::{deepest, length, median, relative_l2};
use crate::pictures::picture::{Body as Drawn, Camera, Finish, Image, Margins, View, legend, millimetres, photograph};
use crate::pictures::stacked;
use crate::scene;
use crate::table::{Table, num};
use crate::truth::{Body, Field, Impact};

/// A vertex is in the dent if the truth moves it by this share of its deepest.
const DENTED: f64 = 0.05;
/// Hits that leave less than this at the contact are left out, m.
const WEAK: f64 = 2e-3;
/// The most steps of smoothing that the reference of an error takes.
const MOST_STEPS: usize = 512;
/// A vertex is at the limit from this share of it.
const AT_LIMIT: f64 = 0.99;
/// One of the pictures side by side, pixels.
const PANEL: [usize; 2] = [524, 390];
const MARGINS: Margins = Margins { side: 0.05, top: 0.21, bottom: 0.06 };
const UP: Vec3 = Vec3::Z;

/// The first three are in the pictures.
const METHODS: [&str; 4] = ["crumple", "radial", "classic", "pod"];
const TITLES: [&str; 3] = ["Crumple", "a radial profile for each hit", "the literature: most displaced"];

const COLUMNS: [&str; 13] = [
    "truth",
    "body",
    "hits",
    "method",
    "rel_l2",
    "normals_mean_deg",
    "normals_p95_deg",
    "normals_over_reference",
    "curvature_ratio",
    "flip",
    "at_limit",
    "depth_ratio",
    "n",
];

pub fn run(options: &Options) -> Result<()> {
    let mut table = Table::new(&COLUMNS);
    table.comment("command", "cargo xtask lab --only looks");
    table.comment("told", "the blow, as a rigid-body engine knows it; presses are told the displacement");
    table.comment(
        "methods",
        "radial and classic are told the displacement of a law; pod: modes of the examples, and kriging",
    );
    table.comment("hits", "1: medians over hits that no example shows; more: one body, hit so often at random places");
    table.comment(
        "normals",
        format!("angle to the truth's normal where the truth moves by {DENTED} of its deepest, by area"),
    );
    table.comment(
        "reference",
        "the truth, smoothed and scaled until its displacements are as wrong as the method's; none above 1",
    );
    table.comment("curvature", "sum over edges of squared change of angle by length over width, over the truth's");
    table.comment("flip", "mean FLIP error of the picture against the truth's");
    table.comment("at_limit", "share of vertices within a hundredth of the depth limit");
    for body in Body::read_all()? {
        let looks = Looks::new(&body)?;
        single_hits(&looks, options, &mut table)?;
        if let Some(wreck) = &body.wreck {
            for (hits, truth) in &wreck.after {
                looks.wrecked(&wreck.impacts[..*hits], truth, options, &mut table)?;
            }
        }
        println!("looks: {} {}", body.truth.name(), body.name);
    }
    table.write(&options.out, "looks.csv").map(drop)
}

fn single_hits(looks: &Looks, options: &Options, table: &mut Table) -> Result<()> {
    let body = looks.body;
    let hits = if body.play.is_empty() { &body.heldout } else { &body.play };
    let most = if options.quick { 2 } else { usize::MAX };
    let hits: Vec<&Impact> = hits.iter().filter(|i| i.depth() >= WEAK).take(most).collect();
    let mut scores = [const { Vec::new() }; METHODS.len()];
    for hit in &hits {
        let scored = looks.scores(std::slice::from_ref(*hit), &hit.field)?.0;
        scores.iter_mut().zip(scored).for_each(|(all, score)| all.push(score));
    }
    for (method, scores) in METHODS.iter().zip(&scores) {
        let medians = std::array::from_fn(|k| median(&scores.iter().map(|s| s.0[k]).collect::<Vec<_>>()));
        looks.row(table, 1, method, &Score(medians), scores.len())?;
    }
    Ok(())
}

/// `rel_l2` and the columns after it.
struct Score([f64; 8]);

/// A body, and what predicts its dents.
struct Looks<'a> {
    body: &'a Body,
    set: Arc<ExampleSet>,
    /// The same where an example counts as moving a vertex from a tenth of a millimetre, as the classic rule needs it.
    cut: Arc<ExampleSet>,
    radial: Radial,
    pod: Pod,
    law: Option<Law>,
    edges: Vec<Edge>,
    neighbours: Vec<Vec<u32>>,
    /// A third of the area of the base's triangles around each vertex, m².
    areas: Vec<f64>,
}

/// An edge between two triangles.
struct Edge {
    ends: [u32; 2],
    across: [u32; 2],
    /// Of the base: squared length over the area of both triangles, and the signed angle between them.
    weight: f64,
    angle: f64,
}

impl<'a> Looks<'a> {
    fn new(body: &'a Body) -> Result<Self> {
        let count = body.train.len();
        let cut = SetOptions { drop_below: 1e-4, ..SetOptions::default() };
        let mut sides = std::collections::BTreeMap::<[u32; 2], Vec<u32>>::new();
        for t in &body.triangles {
            for k in 0..3 {
                let (a, b, c) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
                sides.entry([a.min(b), a.max(b)]).or_default().push(c);
            }
        }
        let mut neighbours = vec![Vec::new(); body.vertices.len()];
        for [a, b] in sides.keys() {
            neighbours[*a as usize].push(*b);
            neighbours[*b as usize].push(*a);
        }
        let base = moved(body, &vec![[0.0; 3]; body.vertices.len()]);
        let mut areas = vec![0.0; base.len()];
        for t in &body.triangles {
            let [a, b, c] = t.map(|v| base[v as usize]);
            let third = (b - a).cross(c - a).length() / 6.0;
            t.iter().for_each(|v| areas[*v as usize] += third);
        }
        let edges = sides.into_iter().filter(|(_, c)| c.len() == 2).map(|(ends, c)| {
            let mut edge = Edge { ends, across: [c[0], c[1]], weight: 0.0, angle: 0.0 };
            let [p, q] = edge.ends.map(|v| base[v as usize]);
            let areas = edge.across.map(|v| (q - p).cross(base[v as usize] - p).length() / 2.0);
            edge.weight = (q - p).length_squared() / (areas[0] + areas[1]);
            edge.angle = edge.angle_of(&base);
            edge
        });
        Ok(Self {
            body,
            set: scene::with_nodes(body, count)?,
            cut: scene::set(body, count, cut)?,
            radial: Radial::fit(body),
            pod: Pod::fit(&body.train),
            law: Law::fit(&body.train, Sees::Striker),
            edges: edges.collect(),
            neighbours,
            areas,
        })
    }

    /// The field after these impacts by a method, m.
    fn field(&self, method: &str, impacts: &[Impact]) -> Result<Field> {
        let target = |i: &Impact| target(self.law.as_ref(), i);
        match method {
            "crumple" => {
                let hits: Vec<Hit> = impacts.iter().map(scene::blow_hit).collect();
                scene::field_after(&self.set, &InstanceOptions::default(), &hits)
            }
            "radial" => Ok(self.sum(impacts, |i| {
                let told = Impact { displacement: target(i), field: Field::new(), ..i.clone() };
                let mut field = Field::new();
                self.radial.predict(self.body, &told, &mut field);
                field
            })),
            "pod" => Ok(self.sum(impacts, |i| self.pod.predict(i))),
            _ => {
                let hits: Vec<Hit> = impacts.iter().map(|i| Hit::displacement(i.point, target(i))).collect();
                scene::field_after(&self.cut, &InstanceOptions::classic(Rule::MostDisplaced), &hits)
            }
        }
    }

    /// Dents that add, up to the depth limit: what a game would do against bottomless dents.
    fn sum(&self, impacts: &[Impact], dent: impl Fn(&Impact) -> Field) -> Field {
        let mut all = vec![Vec3::ZERO; self.body.vertices.len()];
        for impact in impacts {
            all.iter_mut().zip(dent(impact)).for_each(|(sum, u)| *sum += Vec3::from_array(u));
        }
        all.iter().map(|u| u.clamp_length_max(self.set.depth_limit()).to_array()).collect()
    }

    fn score(&self, field: &Field, truth: &Field, flip: f64) -> Score {
        let error = relative_l2(field, truth);
        let [mean, p95] = self.normal_errors(field, truth);
        let reference = if error < 1.0 { self.normal_errors(&self.as_wrong(truth, error), truth)[0] } else { f64::NAN };
        let limit = f64::from(self.set.depth_limit());
        let at_limit = field.iter().filter(|u| length(**u) >= AT_LIMIT * limit).count() as f64 / field.len() as f64;
        Score([
            error,
            mean,
            p95,
            mean / reference,
            self.curvature(field) / self.curvature(truth),
            flip,
            at_limit,
            deepest(field) / deepest(truth),
        ])
    }

    fn row(&self, table: &mut Table, hits: usize, method: &str, score: &Score, n: usize) -> Result<()> {
        let head = [self.body.truth.name(), self.body.name].map(str::to_owned);
        let head = head.into_iter().chain([hits.to_string(), method.to_owned()]);
        table.row(head.chain(score.0.map(num)).chain([n.to_string()]))
    }

    /// The scores of all methods after these impacts, and the pictures: the truth's and theirs.
    fn scores(&self, impacts: &[Impact], truth: &Field) -> Result<(Vec<Score>, [Image; 5], Vec<Field>)> {
        let fields = METHODS.map(|m| self.field(m, impacts)).into_iter().collect::<Result<Vec<Field>>>()?;
        let pictures = self.pictures([truth, &fields[0], &fields[1], &fields[2], &fields[3]]);
        let score = |(field, picture): (&Field, &Image)| self.score(field, truth, flip(&pictures[0], picture));
        let scores = fields.iter().zip(&pictures[1..]).map(score).collect();
        Ok((scores, pictures, fields))
    }

    /// After many impacts: a row for each method and the pictures side by side.
    fn wrecked(&self, impacts: &[Impact], truth: &Field, options: &Options, table: &mut Table) -> Result<()> {
        let (scores, mut pictures, fields) = self.scores(impacts, truth)?;
        legend::caption(&mut pictures[0], 20, "the solver", &format!("{} mm deep", mm(truth)));
        for (method, score) in METHODS.iter().zip(&scores) {
            self.row(table, impacts.len(), method, score, 1)?;
        }
        for (k, title) in TITLES.iter().enumerate() {
            let detail = format!("error {:.2}, {} mm deep", scores[k].0[0], mm(&fields[k]));
            legend::caption(&mut pictures[k + 1], 20, title, &detail);
        }
        let [a, b, c, d, _] = &pictures;
        let name = format!("looks_{}.png", self.body.name);
        save(&stacked(&a.beside(b), &c.beside(d)), &options.out.join(name))
    }

    /// Mean and 95th percentile by area of the angle between the normals of two fields, inside the truth's dent, degrees.
    fn normal_errors(&self, field: &Field, truth: &Field) -> [f64; 2] {
        let (a, b) = (normals(self.body, field), normals(self.body, truth));
        let dent = DENTED * deepest(truth);
        let mut angles: Vec<(f64, f64)> = (0..truth.len())
            .filter(|v| length(truth[*v]) >= dent)
            .map(|v| (a[v].angle_between(b[v]).to_degrees(), self.areas[v]))
            .collect();
        angles.sort_by(|x, y| x.0.total_cmp(&y.0));
        let all: f64 = angles.iter().map(|(_, area)| area).sum();
        let mean = angles.iter().map(|(angle, area)| angle * area).sum::<f64>() / all;
        let mut below = 0.0;
        let p95 = angles.iter().find(|(_, area)| {
            below += area;
            below >= 0.95 * all
        });
        [mean, p95.map_or(0.0, |(angle, _)| *angle)]
    }

    /// Bending energy of the change of shape, up to a factor.
    fn curvature(&self, field: &Field) -> f64 {
        let positions = moved(self.body, field);
        self.edges.iter().map(|e| (e.angle_of(&positions) - e.angle).powi(2) * e.weight).sum()
    }

    /// The truth, smoothed until half of the squared error is reached, and scaled for the other half. `error` is below 1.
    fn as_wrong(&self, truth: &Field, error: f64) -> Field {
        let mut smooth = truth.clone();
        let mut step = 0;
        while relative_l2(&smooth, truth) < error / 2f64.sqrt() && step < MOST_STEPS {
            smooth = self.smoothed(&smooth);
            step += 1;
        }
        // |s smooth - truth| = error |truth|, the smaller of both factors.
        let dot = |a: &Field, b: &Field| -> f64 {
            a.iter().zip(b).map(|(x, y)| f64::from(Vec3::from_array(*x).dot(Vec3::from_array(*y)))).sum()
        };
        let (ss, st, tt) = (dot(&smooth, &smooth), dot(&smooth, truth), dot(truth, truth));
        let root = (st * st - ss * tt * (1.0 - error * error)).max(0.0).sqrt();
        let factor = ((st - root) / ss) as f32;
        smooth.iter().map(|u| u.map(|x| factor * x)).collect()
    }

    fn smoothed(&self, field: &Field) -> Field {
        let mean = |v: usize| {
            let near = &self.neighbours[v];
            let sum: Vec3 = near.iter().map(|n| Vec3::from_array(field[*n as usize])).sum();
            ((Vec3::from_array(field[v]) + sum / near.len().max(1) as f32) / 2.0).to_array()
        };
        (0..field.len()).map(mean).collect()
    }

    /// The body with each of these displacements, in the same view.
    fn pictures<const N: usize>(&self, fields: [&Field; N]) -> [Image; N] {
        let base: Vec<Vec3> = self.body.vertices.iter().map(|p| Vec3::from_array(*p)).collect();
        let dents: Vec<Vec3> = fields[0].iter().map(|u| Vec3::from_array(*u)).collect();
        let view = View::of(&base, &self.body.triangles, &dents, UP);
        let camera = Camera::framing(base.iter(), view, PANEL[0] as f32 / PANEL[1] as f32, MARGINS);
        fields.map(|field| {
            let positions: Vec<Vec3> = moved(self.body, field).iter().map(|p| p.as_vec3()).collect();
            let normals: Vec<Vec3> = normals(self.body, field).iter().map(|n| n.as_vec3()).collect();
            let triangles = &self.body.triangles;
            let body = Drawn { positions: &positions, normals: &normals, triangles, values: &[] };
            photograph(body, &camera, view, PANEL, &Finish::Coats(&[]), None)
        })
    }
}

impl Edge {
    /// The signed angle between the two triangles.
    fn angle_of(&self, positions: &[DVec3]) -> f64 {
        let [p, q] = self.ends.map(|v| positions[v as usize]);
        let [a, b] = self.across.map(|v| positions[v as usize] - p);
        let along = q - p;
        let (m, n) = (along.cross(a), b.cross(along));
        m.cross(n).dot(along.normalize_or_zero()).atan2(m.dot(n))
    }
}

fn moved(body: &Body, field: &Field) -> Vec<DVec3> {
    body.vertices.iter().zip(field).map(|(p, u)| (Vec3::from_array(*p) + Vec3::from_array(*u)).as_dvec3()).collect()
}

/// Normals of the displaced surface, whatever normals a method has.
fn normals(body: &Body, field: &Field) -> Vec<DVec3> {
    let positions = moved(body, field);
    let mut sums = vec![DVec3::ZERO; positions.len()];
    for t in &body.triangles {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        let n = (b - a).cross(c - a);
        t.iter().for_each(|v| sums[*v as usize] += n);
    }
    sums.into_iter().map(|n| n.normalize_or(DVec3::Z)).collect()
}

/// Mean FLIP error of two pictures: 0 if they look the same, at most 1.
fn flip(truth: &Image, picture: &Image) -> f64 {
    let [a, b] = [truth, picture].map(|i| FlipImageRgb8::with_data(i.width as u32, i.height as u32, &i.rgb));
    FlipPool::from_image(&nv_flip::flip(a, b, DEFAULT_PIXELS_PER_DEGREE)).mean().into()
}

fn mm(field: &Field) -> String {
    millimetres(deepest(field) as f32)
}

fn save(image: &Image, path: &Path) -> Result<()> {
    let png = image.to_png("after shots at random places: the solver, Crumple, a radial profile, the literature")?;
    fs::write(path, png).with_context(|| format!("writing {}", path.display()))
}
