//! The paper's visual tests (75 random hits), its rule beside ours, rendered.
//!
//! Its tool "chooses random example and random weight for each test" and does so 75 times (section 5.3): here each hit is at
//! a random example's own contact and asks for a random share of its depth. A second test hits anywhere.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, Result};
use crumple::import::{MeshChoice, gltf_file};
use crumple::{ExampleSet, Hit, Serial, SetOptions};
use glam::{Mat4, Vec3};

use crate::metric::{deepest, edges, largest_jump, length};
use crate::stability::{Dice, Method, random_hit};
use crate::table::{Table, num};
use crate::truth::Field;
use crate::{Options, metric};

// The renderer of the `crumple` command.
#[allow(dead_code)]
#[path = "../../src/bin/crumple/picture/mod.rs"]
pub mod picture;

use picture::{Body, Camera, Finish, Image, Margins, View, legend, millimetres, photograph};

const HITS: usize = 75;
/// Height of the caption of a close-up, pixels.
const BAND: usize = 78;
/// One of the pictures side by side, pixels.
const PANEL: [usize; 2] = [524, 390];
const MARGINS: Margins = Margins { side: 0.05, top: 0.21, bottom: 0.06 };

const METHODS: [(Method, &str); 3] = [
    (Method::Classic, "the literature: most displaced"),
    (Method::Blend, "the literature: blend, k = 0.5"),
    (Method::Ours, "Crumple"),
];

/// A body of the demo.
struct Scene {
    name: &'static str,
    set: Arc<ExampleSet>,
    up: Vec3,
    /// Vertices that shade as one: the same place and the same normal.
    smooth: Vec<u32>,
}

pub fn run(options: &Options) -> Result<()> {
    let columns =
        ["body", "test", "rule", "hits", "seam", "kept_mean", "kept_worst", "deepest_over_limit", "inverted_triangles"];
    let mut table = Table::new(&columns);
    table.comment("what", format!("{HITS} random hits on the demo's bodies, one sequence"));
    table.comment("seam", "largest edge jump over the largest in any example");
    table.comment("kept", "displacement at each contact after all hits over the deepest asked for there, at most 1");
    fs::create_dir_all(&options.out)?;
    for name in ["hood", "drum"] {
        let scene = Scene::read(name)?;
        let edges = edges(scene.set.mesh().triangles());
        for (test, hits) in [("examples", scene.at_examples()), ("anywhere", scene.anywhere())] {
            let fields = METHODS.map(|(method, _)| method.after(&scene.set, &hits));
            let fields: Vec<Field> = fields.into_iter().collect::<Result<_>>()?;
            let mut details = Vec::new();
            for ((method, _), field) in METHODS.iter().zip(&fields) {
                let seam = largest_jump(field, &edges) / scene.worst_example_jump(&edges)?;
                let (mean, worst) = scene.kept(&hits, field)?;
                let inverted = scene.inverted(field);
                table.row([
                    name.to_owned(),
                    test.to_owned(),
                    method.name().to_owned(),
                    HITS.to_string(),
                    num(seam),
                    num(mean),
                    num(worst),
                    num(deepest(field) / f64::from(scene.set.depth_limit())),
                    inverted.to_string(),
                ])?;
                details.push(format!(
                    "seam {seam:.1}x an example's, kept {:.0} % (worst {:.0} %), {} mm deep",
                    100.0 * mean,
                    100.0 * worst,
                    millimetres(deepest(field) as f32)
                ));
            }
            if options.quick && test == "anywhere" {
                continue;
            }
            scene.draw_four(&fields, &details, &options.out.join(format!("pictures_{name}_{test}.png")))?;
            if test == "examples" {
                scene.draw_seam(&fields, &edges, &options.out.join(format!("pictures_{name}_seam.png")))?;
            }
        }
    }
    table.write(&options.out, "pictures.csv").map(drop)
}

impl Scene {
    fn read(name: &'static str) -> Result<Self> {
        let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("../assets/demo/{name}.glb"));
        let imported = gltf_file(&path, MeshChoice::First)?;
        let transform = imported.node_transform.map(|m| Mat4::from_cols_array_2d(&m));
        let up = transform.map_or(Vec3::Y, |m| m.transpose().transform_vector3(Vec3::Y).normalize_or(Vec3::Y));
        let set = Arc::new(ExampleSet::build(imported.mesh, imported.examples, SetOptions::default(), &Serial)?);
        let mesh = set.mesh();
        let mut first = HashMap::new();
        let smooth = mesh.positions().iter().enumerate().map(|(v, p)| {
            let n = mesh.normals().map_or(Vec3::ZERO, |n| n[v]);
            let place = (p.to_array().map(f32::to_bits), n.to_array().map(|x| (x * 64.0).round() as i32));
            *first.entry(place).or_insert(v as u32)
        });
        let smooth = smooth.collect();
        Ok(Self { name, up, smooth, set })
    }

    /// The paper's own test.
    fn at_examples(&self) -> Vec<Hit> {
        let mut dice = Dice::new(75);
        let hit = |_| {
            let e = &self.set.examples()[dice.index(self.set.examples().len())];
            let weight = dice.between(0.1, 1.0) as f32;
            Hit::displacement(e.contact_point().to_array(), (e.contact_displacement() * weight).to_array())
        };
        (0..HITS).map(hit).collect()
    }

    fn anywhere(&self) -> Vec<Hit> {
        let mut dice = Dice::new(76);
        let mut hits = Vec::new();
        while hits.len() < HITS {
            let share = dice.between(0.05, 0.6);
            let hit = random_hit(&self.set, &mut dice, share);
            if self.dents_at(Vec3::from_array(hit.point)) {
                hits.push(hit);
            }
        }
        hits
    }

    /// Whether any example says that the body dents there: the drum's lids and the hood's edge are held.
    fn dents_at(&self, point: Vec3) -> bool {
        let v = self.set.nearest_vertex(point.to_array()).map_or(0, |n| n.vertex);
        self.set.examples().iter().any(|e| e.delta(v).length() > 0.05 * e.depth())
    }

    fn worst_example_jump(&self, edges: &[[u32; 2]]) -> Result<f64> {
        let mut worst = 0.0f64;
        for e in self.set.examples() {
            let field: Field = (0..self.set.vertex_count()).map(|v| e.delta(v as u32).to_array()).collect();
            worst = worst.max(largest_jump(&field, edges));
        }
        Ok(worst)
    }

    /// Mean and worst, over the places that were hit, of what is left of the deepest dent asked for there.
    fn kept(&self, hits: &[Hit], field: &Field) -> Result<(f64, f64)> {
        let mut asked: HashMap<u32, f64> = HashMap::new();
        for hit in hits {
            let outcome = Method::Ours.instance(&self.set)?.preview(hit)?;
            let most = asked.entry(outcome.contact_vertex).or_default();
            *most = most.max(length(outcome.target).min(f64::from(self.set.depth_limit())));
        }
        let kept: Vec<f64> = asked.iter().map(|(v, d)| (length(field[*v as usize]) / d).min(1.0)).collect();
        let mean = kept.iter().sum::<f64>() / kept.len() as f64;
        Ok((mean, kept.iter().copied().fold(f64::INFINITY, f64::min)))
    }

    fn inverted(&self, field: &Field) -> usize {
        let base: Vec<[f32; 3]> = self.set.mesh().positions().iter().map(|p| p.to_array()).collect();
        metric::inverted(field, &base, self.set.mesh().triangles())
    }

    fn moved(&self, field: &Field) -> Vec<Vec3> {
        self.set.mesh().positions().iter().zip(field).map(|(p, u)| *p + Vec3::from_array(*u)).collect()
    }

    /// Normals of the surface as it is, whatever a rule makes of the engine's own.
    fn normals(&self, positions: &[Vec3]) -> Vec<Vec3> {
        let mut sums = vec![Vec3::ZERO; positions.len()];
        for t in self.set.mesh().triangles() {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            let n = (b - a).cross(c - a);
            t.iter().for_each(|v| sums[self.smooth[*v as usize] as usize] += n);
        }
        self.smooth.iter().map(|v| sums[*v as usize].normalize_or(self.up)).collect()
    }

    /// Before, and after by each rule, two by two.
    fn draw_four(&self, fields: &[Field], details: &[String], path: &Path) -> Result<()> {
        let base = self.set.mesh().positions();
        let after: Vec<Vec<Vec3>> = fields.iter().map(|f| self.moved(f)).collect();
        let dents: Vec<Vec3> = fields[2].iter().map(|u| Vec3::from_array(*u)).collect();
        let view = View::of(base, self.set.mesh().triangles(), &dents, self.up);
        let points = base.iter().chain(after.iter().flatten());
        let camera = Camera::framing(points, view, PANEL[0] as f32 / PANEL[1] as f32, MARGINS);
        let photo = |positions: &[Vec3], title: &str, detail: &str| {
            let normals = self.normals(positions);
            let triangles = self.set.mesh().triangles();
            let body = Body { positions, normals: &normals, triangles, values: &[] };
            let mut image = photograph(body, &camera, view, PANEL, &Finish::Coats(&[]), None);
            legend::caption(&mut image, 20, title, detail);
            image
        };
        let before = photo(base, "before", "as it came");
        let images: Vec<Image> =
            after.iter().zip(METHODS).zip(details).map(|((p, (_, title)), detail)| photo(p, title, detail)).collect();
        save(&stacked(&before.beside(&images[2]), &images[0].beside(&images[1])), path, self.name)
    }

    /// Around the edge where blending tears most, the same place by each rule.
    fn draw_seam(&self, fields: &[Field], edges: &[[u32; 2]], path: &Path) -> Result<()> {
        let jump = |e: &[u32; 2]| {
            let d = metric::sub(fields[1][e[0] as usize], fields[1][e[1] as usize]);
            metric::dot64(d, d)
        };
        let worst = edges.iter().max_by(|a, b| jump(a).total_cmp(&jump(b))).context("a mesh without edges")?;
        let mesh = self.set.mesh();
        let at = mesh.positions()[worst[0] as usize];
        let normal = mesh.contact_normal(worst[0]).unwrap_or(self.up);
        let size = mesh.bounds().diagonal();
        // A hood is looked down upon, a drum from the side.
        let flat = normal.dot(self.up).abs() > 0.7;
        let up = if flat { normal } else { self.up };
        let level = if flat { normal.any_orthonormal_vector() } else { normal };
        let aside = up.cross(level);
        let toward = if flat { up * 0.75 + level * 0.5 + aside * 0.4 } else { level * 0.75 + aside * 0.5 + up * 0.3 };
        let view = View { up, toward: toward.normalize() };
        let near: Vec<Vec3> = mesh.positions().iter().copied().filter(|p| (*p - at).length() < 0.1 * size).collect();
        let margins = Margins { side: 0.0, top: 0.12, bottom: 0.0 };
        let camera = Camera::framing(&near, view, PANEL[0] as f32 / PANEL[1] as f32, margins);
        // What lies behind the viewer, or on the far side of a drum, is left out.
        let whole = |t: &&[u32; 3]| t.iter().all(|v| (mesh.positions()[*v as usize] - at).length() < 0.3 * size);
        let triangles: Vec<[u32; 3]> = mesh.triangles().iter().filter(whole).copied().collect();
        let mut row: Option<Image> = None;
        for (field, (_, title)) in fields.iter().zip(METHODS) {
            let positions = self.moved(field);
            let normals = self.normals(&positions);
            let body = Body { positions: &positions, normals: &normals, triangles: &triangles, values: &[] };
            let mut image = photograph(body, &camera, view, PANEL, &Finish::Coats(&[]), None);
            image.rgb[..BAND * PANEL[0] * 3].fill(236);
            let here = metric::sub(field[worst[0] as usize], field[worst[1] as usize]);
            let detail = format!("{} mm across one edge here", millimetres(metric::dot64(here, here).sqrt() as f32));
            legend::caption(&mut image, 20, title, &detail);
            row = Some(row.map_or(image.clone(), |r| r.beside(&image)));
        }
        save(&row.context("no rules")?, path, self.name)
    }
}

/// One above the other.
pub fn stacked(a: &Image, b: &Image) -> Image {
    Image { width: a.width, height: a.height + b.height, rgb: [a.rgb.as_slice(), &b.rgb].concat() }
}

fn save(image: &Image, path: &Path, name: &str) -> Result<()> {
    let png = image.to_png(&format!("{name} after {HITS} random hits, by rule"))?;
    fs::write(path, png).with_context(|| format!("writing {}", path.display()))
}
