//! The five truths in `lab/data`: bodies, the impacts that dented them, and the dents that stayed.

use std::fs::File;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};

use crate::metric::dot64;

/// Displacement of each vertex, m.
pub type Field = Vec<[f32; 3]>;

/// Who computed the dents.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Truth {
    /// MuJoCo shells hit by a free-flying ball: how deep is up to the energy.
    Shots,
    /// CalculiX steel bricks under a sphere that is pressed in and drawn out: how deep is prescribed.
    Presses,
    /// MuJoCo shells with a crease, a free edge, an inner frame or bends, hit by strikers of many masses.
    Structure,
    /// OpenRadioss shells: a hood of thin sheet steel on a welded frame.
    Steel,
    /// Hundreds of hits on coarser shells of the structure's bodies. Only `learn` reads it.
    Dense,
}

impl Truth {
    /// All but the dense one.
    pub const ALL: [Truth; 4] = [Truth::Shots, Truth::Presses, Truth::Structure, Truth::Steel];
    /// Those of smooth bodies with held rims.
    pub const SMOOTH: [Truth; 2] = [Truth::Shots, Truth::Presses];
    /// The bodies that each of the smooth truths has.
    pub const SMOOTH_BODIES: [&str; 2] = ["panel", "tube"];

    /// As in file names and CSV columns.
    pub fn name(self) -> &'static str {
        match self {
            Truth::Shots => "shots",
            Truth::Presses => "presses",
            Truth::Structure => "structure",
            Truth::Steel => "steel",
            Truth::Dense => "dense",
        }
    }

    pub fn bodies(self) -> &'static [&'static str] {
        match self {
            Truth::Shots | Truth::Presses => &Self::SMOOTH_BODIES,
            Truth::Structure | Truth::Dense => &["door", "box"],
            Truth::Steel => &["hood"],
        }
    }

    /// What no predictor can beat on this body: the relative L2 error of the truth against itself (`lab/data/README.md`:
    /// the change of field at a change of direction by 1e-7, the middle of 0.04 to 0.09 on the shots' tube, otherwise the
    /// largest; on the presses, symmetry copies run again, the upper of 0.010 to 0.015 on the panel).
    pub fn noise_floor(self, body: &str) -> f64 {
        match (self, body) {
            (Truth::Shots, "panel") => 0.0002,
            (Truth::Shots, _) => 0.065,
            (Truth::Presses, "panel") => 0.015,
            (Truth::Presses, _) => 0.030,
            (Truth::Structure, "door") => 0.019,
            (Truth::Structure, _) => 0.056,
            (Truth::Steel, _) => 0.0014,
            // Not measured.
            (Truth::Dense, _) => f64::NAN,
        }
    }
}

/// What struck the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Striker {
    /// A ball, or a pole at some hits of the box: speed in m/s, radius in m, tilt of its flight against the inward normal in
    /// degrees (NaN where the data does not tell).
    Ball { speed: f64, radius: f64, tilt_deg: f64 },
    /// A sphere that travels `depth` along the direction and is drawn out again, m.
    Punch { depth: f64, radius: f64 },
}

/// What a rigid-body engine knows of an impact, in the body's space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blow {
    /// Mass of the striker, kg.
    pub mass: f32,
    /// Velocity of the striker before the touch, m/s.
    pub velocity: [f32; 3],
    /// Radius of the striker, m.
    pub radius: f32,
    /// On the body, N s. For the shots, what an engine reports of a fixed body: the normal momentum without restitution, and
    /// friction.
    pub impulse: [f32; 3],
    /// First to last touch, s. `None` for the shots.
    pub duration: Option<f32>,
    /// Unit contact normal, out of the body.
    pub normal: [f32; 3],
    /// Whether the striker was a pole, not a ball.
    pub pole: bool,
}

impl Blow {
    /// What a rigid-body engine reports if the body is fixed: the normal momentum without restitution, and friction that
    /// is at most 0.4 times as large and at most stops the striker. No duration.
    pub fn in_engine(&self) -> Self {
        const FRICTION: f64 = 0.4;
        let (normal, velocity) = (self.normal.map(f64::from), self.velocity.map(f64::from));
        let along = -dot64(velocity, normal);
        let across = [0, 1, 2].map(|k| velocity[k] + along * normal[k]);
        let speed = dot64(across, across).sqrt();
        let share = (FRICTION * along / speed.max(1e-9)).min(1.0);
        let impulse = [0, 1, 2].map(|k| (f64::from(self.mass) * (share * across[k] - along * normal[k])) as f32);
        Blow { impulse, duration: None, ..*self }
    }
}

/// One impact on the fresh body.
#[derive(Debug, Clone)]
pub struct Impact {
    /// The simulation it is from. Rows of one simulation (exact symmetry copies) share it: leave them out together.
    pub source: String,
    pub contact_vertex: u32,
    /// Where the striker first touches, m: that vertex or, on the door, the box and the steel hood, a point near it.
    pub point: [f32; 3],
    /// Unit direction of flight or travel, into the body.
    pub direction: [f32; 3],
    /// Displacement that stays at the contact vertex, m.
    pub displacement: [f32; 3],
    pub striker: Striker,
    /// `None` for the presses.
    pub blow: Option<Blow>,
    /// The truth.
    pub field: Field,
}

impl Impact {
    /// Length of the displacement that stays at the contact, m.
    pub fn depth(&self) -> f64 {
        crate::metric::length(self.displacement)
    }
}

/// Impacts on one body, one after the other.
#[derive(Debug, Clone)]
pub struct Sequence {
    pub name: String,
    /// `overlap`, `random` or `repeat` for the shots, `press` for the presses.
    pub kind: String,
    /// Each alone on the fresh body.
    pub impacts: Vec<Impact>,
    /// The truth after each of them.
    pub after: Vec<Field>,
}

/// One impact repeated at one vertex.
#[derive(Debug, Clone)]
pub struct Repeat {
    /// Which of the training impacts is repeated.
    pub train: usize,
    /// The truth after each.
    pub after: Vec<Field>,
}

/// One body that is hit again and again.
#[derive(Debug, Clone)]
pub struct Wreck {
    /// In order. What each alone would leave is not known: their fields are empty, their displacements 0.
    pub impacts: Vec<Impact>,
    /// The truth after so many of them.
    pub after: Vec<(usize, Field)>,
}

/// A body with all that one truth knows about it.
#[derive(Debug, Clone)]
pub struct Body {
    pub truth: Truth,
    /// One of its truth's [`Truth::bodies`].
    pub name: &'static str,
    pub vertices: Vec<[f32; 3]>,
    /// Outward.
    pub normals: Vec<[f32; 3]>,
    pub triangles: Vec<[u32; 3]>,
    /// Vertices that the solver held; empty for the presses, whose data does not say.
    pub pinned: Vec<bool>,
    /// Rows and columns of the grid that the vertices are: vertex = i * columns + j. The tube's rows wrap. 0 and 0 for the
    /// box, which has no grid.
    pub grid: [usize; 2],
    /// For choosing parameters, by cross-validation over `source`. In an order of which any prefix is well spread.
    pub train: Vec<Impact>,
    /// As many more, with energies that were drawn without regard to place. Door and box only.
    pub train_free: Vec<Impact>,
    /// For measuring only.
    pub heldout: Vec<Impact>,
    /// For measuring only: hits as they come in play, so weak ones too. Door and box only.
    pub play: Vec<Impact>,
    /// For measuring only. Empty for the steel hood.
    pub sequences: Vec<Sequence>,
    /// For choosing how dents combine. Shots only.
    pub train_sequences: Vec<Sequence>,
    /// Shots only.
    pub repeats: Vec<Repeat>,
    /// For measuring only. Shots only.
    pub wreck: Option<Wreck>,
}

impl Body {
    /// Reads one body of a truth.
    pub fn read(truth: Truth, name: &'static str) -> Result<Self> {
        let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(truth.name()).join(name);
        let mut base = Archive::open(directory.join("base.npz"))?;
        let vertices = base.vectors("vertices")?;
        let grid = base.integers("grid")?;
        let mut body = Body {
            truth,
            name,
            normals: base.vectors("normals")?,
            triangles: base
                .integers("triangles")?
                .chunks_exact(3)
                .map(|t| [t[0], t[1], t[2]].map(|v| v as u32))
                .collect(),
            pinned: if truth == Truth::Presses { Vec::new() } else { base.array::<bool>("pinned")? },
            grid: [grid[0] as usize, grid[1] as usize],
            train: Vec::new(),
            train_free: Vec::new(),
            heldout: Vec::new(),
            play: Vec::new(),
            sequences: Vec::new(),
            train_sequences: Vec::new(),
            repeats: Vec::new(),
            wreck: None,
            vertices,
        };
        body.train = body.impacts(&directory, "train")?;
        body.heldout = body.impacts(&directory, "heldout")?;
        match truth {
            Truth::Shots => {
                body.sequences = body.padded_sequences(&directory, "sequences")?;
                body.train_sequences = body.padded_sequences(&directory, "train_sequences")?;
                body.repeats = body.read_repeats(&directory)?;
                body.wreck = Some(body.read_wreck(&directory)?);
            }
            Truth::Presses => body.sequences = body.press_sequences(&directory)?,
            Truth::Structure => {
                body.train_free = body.impacts(&directory, "train_free")?;
                body.play = body.impacts(&directory, "play")?;
                body.sequences = body.padded_sequences(&directory, "sequences")?;
            }
            Truth::Steel | Truth::Dense => {}
        }
        let vertices = body.grid[0] * body.grid[1];
        ensure!(vertices == 0 || vertices == body.vertices.len(), "{name}: the grid does not count its vertices");
        Ok(body)
    }

    /// The same body with both kinds of training impacts as one.
    pub fn with_free(mut self) -> Self {
        self.train.append(&mut self.train_free);
        self
    }

    /// Every body of every truth.
    pub fn read_all() -> Result<Vec<Self>> {
        Self::read_of(&Truth::ALL)
    }

    /// The panels and tubes of shots and presses.
    pub fn read_smooth() -> Result<Vec<Self>> {
        Self::read_of(&Truth::SMOOTH)
    }

    fn read_of(truths: &[Truth]) -> Result<Vec<Self>> {
        truths.iter().flat_map(|t| t.bodies().iter().map(|b| Body::read(*t, b))).collect()
    }

    /// Angle between an impact's direction and the inward normal at its contact, degrees.
    pub fn tilt_deg(&self, impact: &Impact) -> f64 {
        let cosine: f64 =
            -dot64(impact.direction.map(f64::from), self.normals[impact.contact_vertex as usize].map(f64::from));
        cosine.clamp(-1.0, 1.0).acos().to_degrees()
    }

    fn impacts(&self, directory: &Path, file: &str) -> Result<Vec<Impact>> {
        let mut a = Archive::open(directory.join(file).with_extension("npz"))?;
        let (strikers, sources) = match self.truth {
            Truth::Presses => {
                (punches(&a.floats("prescribed_depth")?, &a.floats("punch_radius")?), a.array::<String>("source")?)
            }
            _ => {
                let strikers = balls(&a.floats("speed")?, &a.floats("radius")?, Some(&a.floats("tilt_deg")?));
                let sources = (0..strikers.len()).map(|i| format!("{}_{file}_{i:02}", self.name)).collect();
                (strikers, sources)
            }
        };
        let blows = self.blows(&mut a, strikers.len(), "")?;
        let (points, directions) = (a.vectors("contact_point")?, a.vectors("direction")?);
        let contacts = a.integers("contact_vertex")?;
        let fields = self.fields(&mut a, "fields")?;
        ensure!(fields.len() == strikers.len(), "{file}: {} fields for {} impacts", fields.len(), strikers.len());
        Ok(fields
            .into_iter()
            .enumerate()
            .map(|(i, field)| Impact {
                source: sources[i].clone(),
                contact_vertex: contacts[i] as u32,
                point: points[i],
                direction: directions[i],
                displacement: field[contacts[i] as usize],
                striker: strikers[i],
                blow: blows[i],
                field,
            })
            .collect())
    }

    /// What is known of each of `count` blows; `suffix` is that of the keys of a first hit.
    fn blows(&self, a: &mut Archive, count: usize, suffix: &str) -> Result<Vec<Option<Blow>>> {
        if self.truth == Truth::Presses {
            return Ok(vec![None; count]);
        }
        let durations = match self.truth {
            Truth::Shots => vec![None; count],
            _ => a.floats(&format!("duration{suffix}"))?.into_iter().map(|d| Some(d as f32)).collect(),
        };
        let impulses = match self.truth {
            Truth::Shots => a.vectors("impulse")?,
            _ => a.vectors(&format!("impulse{suffix}"))?,
        };
        let poles = match self.truth {
            Truth::Structure | Truth::Dense => a.array::<String>("shape")?.iter().map(|s| s == "pole").collect(),
            _ => vec![false; count],
        };
        let (masses, radii) = (a.floats("mass")?, a.floats("radius")?);
        let (velocities, normals) = (a.vectors("velocity")?, a.vectors("contact_normal")?);
        let blow = |i: usize| Blow {
            mass: masses[i] as f32,
            velocity: velocities[i],
            radius: radii[i] as f32,
            impulse: impulses[i],
            duration: durations[i],
            normal: normals[i],
            pole: poles[i],
        };
        Ok((0..count).map(|i| Some(blow(i))).collect())
    }

    fn fields(&self, a: &mut Archive, name: &str) -> Result<Vec<Field>> {
        Ok(a.displacements(name)?.chunks_exact(self.vertices.len()).map(<[_]>::to_vec).collect())
    }

    /// Sequences that all have as many rows as the longest.
    fn padded_sequences(&self, directory: &Path, file: &str) -> Result<Vec<Sequence>> {
        let mut a = Archive::open(directory.join(file).with_extension("npz"))?;
        let (lengths, kinds) = (a.integers("length")?, a.array::<String>("kind")?);
        let strikers = balls(&a.floats("speed")?, &a.floats("radius")?, None);
        let blows = self.blows(&mut a, strikers.len(), "_single")?;
        let (points, directions) = (a.vectors("contact_point")?, a.vectors("direction")?);
        let contacts = a.integers("contact_vertex")?;
        let single = self.fields(&mut a, "fields_single")?;
        let after = self.fields(&mut a, "fields_after")?;
        let padded = single.len() / lengths.len();
        Ok((0..lengths.len())
            .map(|s| {
                let rows = s * padded..s * padded + lengths[s] as usize;
                Sequence {
                    name: format!("{}_{s:02}", self.name),
                    kind: kinds[s].clone(),
                    impacts: rows
                        .clone()
                        .map(|i| Impact {
                            source: format!("{}_{file}_{s:02}_{}", self.name, i - rows.start),
                            contact_vertex: contacts[i] as u32,
                            point: points[i],
                            direction: directions[i],
                            displacement: single[i][contacts[i] as usize],
                            striker: strikers[i],
                            blow: blows[i],
                            field: single[i].clone(),
                        })
                        .collect(),
                    after: after[rows].to_vec(),
                }
            })
            .collect())
    }

    fn press_sequences(&self, directory: &Path) -> Result<Vec<Sequence>> {
        let mut a = Archive::open(directory.join("sequences.npz"))?;
        let (offsets, names) = (a.integers("offsets")?, a.array::<String>("name")?);
        let sources = a.array::<String>("source")?;
        let strikers = punches(&a.floats("prescribed_depth")?, &a.floats("punch_radius")?);
        let (points, directions) = (a.vectors("contact_point")?, a.vectors("direction")?);
        let contacts = a.integers("contact_vertex")?;
        let single = self.fields(&mut a, "single_fields")?;
        let after = self.fields(&mut a, "fields_after")?;
        Ok((0..names.len())
            .map(|s| {
                let rows = offsets[s] as usize..offsets[s + 1] as usize;
                Sequence {
                    name: names[s].clone(),
                    kind: "press".into(),
                    impacts: rows
                        .clone()
                        .map(|i| Impact {
                            source: sources[i].clone(),
                            contact_vertex: contacts[i] as u32,
                            point: points[i],
                            direction: directions[i],
                            displacement: single[i][contacts[i] as usize],
                            striker: strikers[i],
                            blow: None,
                            field: single[i].clone(),
                        })
                        .collect(),
                    after: after[rows].to_vec(),
                }
            })
            .collect())
    }

    fn read_wreck(&self, directory: &Path) -> Result<Wreck> {
        let mut a = Archive::open(directory.join("wreck.npz"))?;
        let strikers = balls(&a.floats("speed")?, &a.floats("radius")?, None);
        let blows = self.blows(&mut a, strikers.len(), "")?;
        let (points, directions) = (a.vectors("contact_point")?, a.vectors("direction")?);
        let contacts = a.integers("contact_vertex")?;
        let impact = |i: usize| Impact {
            source: format!("{}_wreck_{i:02}", self.name),
            contact_vertex: contacts[i] as u32,
            point: points[i],
            direction: directions[i],
            displacement: [0.0; 3],
            striker: strikers[i],
            blow: blows[i],
            field: Field::new(),
        };
        let after = a.integers("after")?.into_iter().map(|n| n as usize);
        let fields = self.fields(&mut a, "fields_after")?;
        Ok(Wreck { impacts: (0..strikers.len()).map(impact).collect(), after: after.zip(fields).collect() })
    }

    fn read_repeats(&self, directory: &Path) -> Result<Vec<Repeat>> {
        let mut a = Archive::open(directory.join("repeat.npz"))?;
        let train = a.integers("train_index")?;
        let after = self.fields(&mut a, "fields_after")?;
        let times = after.len() / train.len();
        Ok(train
            .iter()
            .zip(after.chunks_exact(times))
            .map(|(t, after)| Repeat { train: *t as usize, after: after.to_vec() })
            .collect())
    }
}

fn balls(speeds: &[f64], radii: &[f64], tilts: Option<&[f64]>) -> Vec<Striker> {
    let tilt = |i: usize| tilts.map_or(f64::NAN, |t| t[i]);
    (0..speeds.len()).map(|i| Striker::Ball { speed: speeds[i], radius: radii[i], tilt_deg: tilt(i) }).collect()
}

fn punches(depths: &[f64], radii: &[f64]) -> Vec<Striker> {
    depths.iter().zip(radii).map(|(d, r)| Striker::Punch { depth: *d, radius: *r }).collect()
}

/// A NumPy archive.
struct Archive {
    path: PathBuf,
    zip: zip::ZipArchive<File>,
}

impl Archive {
    fn open(path: PathBuf) -> Result<Self> {
        let file = File::open(&path).with_context(|| format!("opening {}", path.display()))?;
        let zip = zip::ZipArchive::new(file).with_context(|| format!("reading {}", path.display()))?;
        Ok(Self { path, zip })
    }

    fn array<T: npyz::Deserialize>(&mut self, name: &str) -> Result<Vec<T>> {
        let what = || format!("{name} in {}", self.path.display());
        let file = self.zip.by_name(&format!("{name}.npy")).with_context(what)?;
        npyz::NpyFile::new(file).and_then(npyz::NpyFile::into_vec).with_context(what)
    }

    /// Of any integer type.
    fn integers(&mut self, name: &str) -> Result<Vec<i64>> {
        self.array::<i64>(name)
            .or_else(|_| Ok(self.array::<i32>(name)?.into_iter().map(i64::from).collect()))
            .or_else(|_: anyhow::Error| Ok(self.array::<u32>(name)?.into_iter().map(i64::from).collect()))
    }

    /// Of either floating-point type.
    fn floats(&mut self, name: &str) -> Result<Vec<f64>> {
        self.array::<f64>(name).or_else(|_| Ok(self.array::<f32>(name)?.into_iter().map(f64::from).collect()))
    }

    /// Stored as 16-bit multiples of `step`.
    fn displacements(&mut self, name: &str) -> Result<Vec<[f32; 3]>> {
        let step = self.array::<f64>("step")?[0];
        let flat = self.array::<i16>(name)?;
        ensure!(flat.len().is_multiple_of(3), "{name} in {} holds no vectors", self.path.display());
        let metres = |k: i16| (step * f64::from(k)) as f32;
        Ok(flat.chunks_exact(3).map(|v| [v[0], v[1], v[2]].map(metres)).collect())
    }

    fn vectors(&mut self, name: &str) -> Result<Vec<[f32; 3]>> {
        let flat = self.array::<f32>(name)?;
        ensure!(flat.len().is_multiple_of(3), "{name} in {} holds no vectors", self.path.display());
        Ok(flat.chunks_exact(3).map(|v| [v[0], v[1], v[2]]).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metric::length;

    #[test]
    fn every_body_is_whole() {
        for body in Body::read_all().unwrap() {
            let n = body.vertices.len();
            let sequences = body.sequences.iter().chain(&body.train_sequences).flat_map(|s| &s.impacts);
            let single = [&body.train, &body.train_free, &body.heldout, &body.play].into_iter().flatten();
            // Of a rough mesh's vertex normals against the striker's own contact normal.
            let steepest = if body.name == "box" { 75.0 } else { 60.0 };
            for i in single.chain(sequences) {
                assert_eq!(i.field.len(), n);
                assert!(crate::metric::length(i.displacement) < 0.2);
                let vertex = body.vertices[i.contact_vertex as usize];
                let apart = crate::metric::sub(vertex, i.point);
                let most = if Truth::SMOOTH.contains(&body.truth) { 0.0 } else { 0.02 };
                assert!(dot64(apart, apart).sqrt() <= most, "{} {}", body.name, i.source);
                assert!(body.tilt_deg(i) < steepest, "{} {} comes from inside", body.name, i.source);
                if let Striker::Ball { tilt_deg, .. } = i.striker
                    && body.truth == Truth::Shots
                    && !tilt_deg.is_nan()
                {
                    assert!((body.tilt_deg(i) - tilt_deg).abs() < 0.5, "{} {tilt_deg}", body.tilt_deg(i));
                }
                assert_eq!(i.blow.is_none(), body.truth == Truth::Presses);
                if let Some(b) = i.blow {
                    let along = |v: [f32; 3]| dot64(v.map(f64::from), b.normal.map(f64::from));
                    assert!((length(b.normal) - 1.0).abs() < 1e-3);
                    assert!(
                        along(b.velocity) < 0.0 && along(b.impulse) < 0.0,
                        "{} {}: into the body",
                        body.name,
                        i.source
                    );
                    let engine = b.in_engine().impulse;
                    assert!(body.truth != Truth::Shots || (0..3).all(|k| (engine[k] - b.impulse[k]).abs() < 1e-3));
                    assert!(b.mass > 0.0 && b.radius > 0.0 && b.duration.is_none_or(|d| d > 0.0));
                }
            }
            assert_eq!(body.train.len(), if Truth::SMOOTH.contains(&body.truth) { 32 } else { 40 });
            let structure = body.truth == Truth::Structure;
            assert_eq!((body.train_free.len(), body.play.len()), if structure { (40, 24) } else { (0, 0) });
            assert!(body.triangles.iter().flatten().all(|v| (*v as usize) < n));
            assert_eq!(body.sequences.is_empty(), body.truth == Truth::Steel);
            assert!(body.sequences.iter().all(|s| s.after.len() == s.impacts.len() && s.impacts.len() > 1));
            assert_eq!(body.train_sequences.len(), if body.truth == Truth::Shots { 16 } else { 0 });
            assert_eq!(body.repeats.len(), if body.truth == Truth::Shots { 2 } else { 0 });
            // A first hit is the hit alone, but for noise.
            let most = if structure { 0.25 } else { 0.1 };
            for s in &body.sequences {
                let error = crate::metric::relative_l2(&s.impacts[0].field, &s.after[0]);
                assert!(error < most, "{}: {error}", s.name);
            }
        }
    }
}
