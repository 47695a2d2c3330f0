//! The two truths in `lab/data`: bodies, the impacts that dented them, and the dents that stayed.

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
}

impl Truth {
    pub const ALL: [Truth; 2] = [Truth::Shots, Truth::Presses];
    /// The bodies that each of them has.
    pub const BODIES: [&str; 2] = ["panel", "tube"];

    /// As in file names and CSV columns.
    pub fn name(self) -> &'static str {
        match self {
            Truth::Shots => "shots",
            Truth::Presses => "presses",
        }
    }

    /// What no predictor can beat on this body: the relative L2 error of the truth against itself (`lab/data/README.md`:
    /// the shots' chaos at a change of direction by 1e-7, the middle of 0.04 to 0.09 on the tube; the presses' symmetry
    /// copies run again, the upper of 0.010 to 0.015 on the panel).
    pub fn noise_floor(self, body: &str) -> f64 {
        match (self, body) {
            (Truth::Shots, "panel") => 0.0002,
            (Truth::Shots, _) => 0.065,
            (Truth::Presses, "panel") => 0.015,
            (Truth::Presses, _) => 0.030,
        }
    }
}

/// What struck the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Striker {
    /// A ball of 2.5 kg: speed in m/s, radius in m, tilt of its flight against the inward normal in degrees (NaN where
    /// the data does not tell).
    Ball { speed: f64, radius: f64, tilt_deg: f64 },
    /// A sphere that travels `depth` along the direction and is drawn out again, m.
    Punch { depth: f64, radius: f64 },
}

/// One impact on the fresh body.
#[derive(Debug, Clone)]
pub struct Impact {
    /// The simulation it is from. Rows of one simulation (exact symmetry copies) share it: leave them out together.
    pub source: String,
    pub contact_vertex: u32,
    /// Base position of that vertex, m.
    pub point: [f32; 3],
    /// Unit direction of flight or travel, into the body.
    pub direction: [f32; 3],
    /// Displacement that stays at the contact vertex, m.
    pub displacement: [f32; 3],
    pub striker: Striker,
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

/// A body with all that one truth knows about it.
#[derive(Debug, Clone)]
pub struct Body {
    pub truth: Truth,
    /// `panel` or `tube`.
    pub name: &'static str,
    pub vertices: Vec<[f32; 3]>,
    /// Outward.
    pub normals: Vec<[f32; 3]>,
    pub triangles: Vec<[u32; 3]>,
    /// Vertices that the solver held; empty for the presses, whose data does not say.
    pub pinned: Vec<bool>,
    /// Rows and columns of the grid that the vertices are: vertex = i * columns + j. The tube's rows wrap.
    pub grid: [usize; 2],
    /// For choosing parameters, by cross-validation over `source`. In an order of which any prefix is well spread.
    pub train: Vec<Impact>,
    /// For measuring only.
    pub heldout: Vec<Impact>,
    pub sequences: Vec<Sequence>,
    /// Empty for the presses.
    pub repeats: Vec<Repeat>,
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
            pinned: if truth == Truth::Shots { base.array::<bool>("pinned")? } else { Vec::new() },
            grid: [grid[0] as usize, grid[1] as usize],
            train: Vec::new(),
            heldout: Vec::new(),
            sequences: Vec::new(),
            repeats: Vec::new(),
            vertices,
        };
        body.train = body.impacts(&directory, "train")?;
        body.heldout = body.impacts(&directory, "heldout")?;
        match truth {
            Truth::Shots => {
                body.sequences = body.shot_sequences(&directory)?;
                body.repeats = body.read_repeats(&directory)?;
            }
            Truth::Presses => body.sequences = body.press_sequences(&directory)?,
        }
        ensure!(body.grid[0] * body.grid[1] == body.vertices.len(), "{name}: the grid does not count its vertices");
        Ok(body)
    }

    /// All four.
    pub fn read_all() -> Result<Vec<Self>> {
        Truth::ALL.iter().flat_map(|t| Truth::BODIES.map(|b| Body::read(*t, b))).collect()
    }

    /// Angle between an impact's direction and the inward normal at its contact, degrees.
    pub fn tilt_deg(&self, impact: &Impact) -> f64 {
        let cosine: f64 =
            -dot64(impact.direction.map(f64::from), self.normals[impact.contact_vertex as usize].map(f64::from));
        cosine.clamp(-1.0, 1.0).acos().to_degrees()
    }

    fn impacts(&self, directory: &Path, file: &str) -> Result<Vec<Impact>> {
        let mut a = Archive::open(directory.join(file).with_extension("npz"))?;
        let strikers: Vec<Striker> = match self.truth {
            Truth::Shots => balls(&a.floats("speed")?, &a.floats("radius")?, Some(&a.floats("tilt_deg")?)),
            Truth::Presses => punches(&a.floats("prescribed_depth")?, &a.floats("punch_radius")?),
        };
        let sources = match self.truth {
            Truth::Shots => (0..strikers.len()).map(|i| format!("{}_{file}_{i:02}", self.name)).collect(),
            Truth::Presses => a.array::<String>("source")?,
        };
        let displacements = match self.truth {
            Truth::Shots => a.vectors("contact_displacement")?,
            Truth::Presses => a.vectors("displacement")?,
        };
        let (points, directions) = (a.vectors("contact_point")?, a.vectors("direction")?);
        let contacts = a.integers("contact_vertex")?;
        let fields = self.fields(a.vectors("fields")?);
        ensure!(fields.len() == strikers.len(), "{file}: {} fields for {} impacts", fields.len(), strikers.len());
        Ok(fields
            .into_iter()
            .enumerate()
            .map(|(i, field)| Impact {
                source: sources[i].clone(),
                contact_vertex: contacts[i] as u32,
                point: points[i],
                direction: directions[i],
                displacement: displacements[i],
                striker: strikers[i],
                field,
            })
            .collect())
    }

    fn fields(&self, flat: Vec<[f32; 3]>) -> Vec<Field> {
        flat.chunks_exact(self.vertices.len()).map(<[_]>::to_vec).collect()
    }

    fn shot_sequences(&self, directory: &Path) -> Result<Vec<Sequence>> {
        let mut a = Archive::open(directory.join("sequences.npz"))?;
        let (lengths, kinds) = (a.integers("length")?, a.array::<String>("kind")?);
        let strikers = balls(&a.floats("speed")?, &a.floats("radius")?, None);
        let (points, directions) = (a.vectors("contact_point")?, a.vectors("direction")?);
        let displacements = a.vectors("contact_displacement_single")?;
        let contacts = a.integers("contact_vertex")?;
        let single = self.fields(a.vectors("fields_single")?);
        let after = self.fields(a.vectors("fields_after")?);
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
                            source: format!("{}_sequence_{s:02}_{}", self.name, i - rows.start),
                            contact_vertex: contacts[i] as u32,
                            point: points[i],
                            direction: directions[i],
                            displacement: displacements[i],
                            striker: strikers[i],
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
        let single = self.fields(a.vectors("single_fields")?);
        let after = self.fields(a.vectors("fields_after")?);
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
                            field: single[i].clone(),
                        })
                        .collect(),
                    after: after[rows].to_vec(),
                }
            })
            .collect())
    }

    fn read_repeats(&self, directory: &Path) -> Result<Vec<Repeat>> {
        let mut a = Archive::open(directory.join("repeat.npz"))?;
        let train = a.integers("train_index")?;
        let after = self.fields(a.vectors("fields_after")?);
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

    fn vectors(&mut self, name: &str) -> Result<Vec<[f32; 3]>> {
        let flat = self.array::<f32>(name)?;
        ensure!(flat.len().is_multiple_of(3), "{name} in {} holds no vectors", self.path.display());
        Ok(flat.chunks_exact(3).map(|v| [v[0], v[1], v[2]]).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_body_is_whole() {
        for body in Body::read_all().unwrap() {
            let n = body.vertices.len();
            let sequences = body.sequences.iter().flat_map(|s| &s.impacts);
            let impacts = body.train.iter().chain(&body.heldout).chain(sequences);
            for i in impacts {
                assert_eq!(i.field.len(), n);
                assert_eq!(i.field[i.contact_vertex as usize], i.displacement, "{} {}", body.name, i.source);
                assert_eq!(body.vertices[i.contact_vertex as usize], i.point);
                assert!(body.tilt_deg(i) < 60.0, "{} {} comes from inside", body.name, i.source);
                if let Striker::Ball { tilt_deg, .. } = i.striker
                    && !tilt_deg.is_nan()
                {
                    assert!((body.tilt_deg(i) - tilt_deg).abs() < 0.5, "{} {tilt_deg}", body.tilt_deg(i));
                }
            }
            assert_eq!(body.train.len(), 32);
            assert!(body.triangles.iter().flatten().all(|v| (*v as usize) < n));
            assert!(body.sequences.iter().all(|s| s.after.len() == s.impacts.len() && s.impacts.len() > 1));
            assert_eq!(body.repeats.len(), if body.truth == Truth::Shots { 2 } else { 0 });
            // A first hit is the hit alone.
            for s in &body.sequences {
                let error = crate::metric::relative_l2(&s.impacts[0].field, &s.after[0]);
                assert!(error < 0.1, "{}: {error}", s.name);
            }
        }
    }
}
