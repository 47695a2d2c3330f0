//! The statements of an OBJ file, by the file's own numbers.

use super::words::{cut, decoded};
use super::{finite, malformed};
use crate::base::error::Error;
use indexmap::IndexSet;
use std::borrow::Cow;

/// A corner of a face or a point of a line: indices from 0 of its position, texture coordinate and normal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Corner {
    pub v: u32,
    pub vt: Option<u32>,
    pub vn: Option<u32>,
}

/// A face, or a line of several points.
#[derive(Debug, Clone, Default)]
pub(super) struct Face {
    pub corners: Vec<Corner>,
    pub is_line: bool,
    /// Of [`ObjText::objects`], [`ObjText::groups`] and [`ObjText::materials`]; 0 is none.
    pub object: usize,
    pub group: usize,
    pub material: usize,
    pub smooth: bool,
    /// The line of the file, from 1.
    pub line: usize,
}

/// A parsed file.
#[derive(Default)]
pub(super) struct ObjText {
    pub name: String,
    pub positions: Vec<[f32; 3]>,
    /// One colour a position, if any has one.
    pub colours: Option<Vec<[f32; 3]>>,
    pub texcoords: Vec<[f32; 2]>,
    /// Those that are no numbers are zeros.
    pub normals: Vec<[f32; 3]>,
    pub faces: Vec<Face>,
    /// Names, the first of them empty.
    pub objects: IndexSet<String>,
    pub groups: IndexSet<String>,
    pub materials: IndexSet<String>,
    pub libraries: Vec<String>,
    pub notes: Vec<String>,
}

impl ObjText {
    /// `name` is for errors.
    pub fn parse(name: &str, bytes: &[u8]) -> Result<Self, Error> {
        let unnamed = || IndexSet::from([String::new()]);
        let (objects, groups, materials) = (unnamed(), unnamed(), unnamed());
        let out = ObjText { name: name.into(), objects, groups, materials, ..ObjText::default() };
        let mut parser = Parser { out, ..Parser::default() };
        let text = decoded(bytes);
        // Old programs end lines with a carriage return alone.
        let text = text.replace("\r\n", "\n").replace('\r', "\n");
        let mut lines = text.split('\n').enumerate();
        while let Some((number, line)) = lines.next() {
            parser.line = number + 1;
            let mut line = Cow::Borrowed(line);
            while line.trim_end().ends_with('\\') && !line.trim_start().starts_with('#') {
                let next = lines.next().map_or("", |(_, line)| line);
                let whole = line.to_mut();
                whole.truncate(whole.trim_end().trim_end_matches('\\').len());
                whole.extend([" ", next]);
            }
            parser.statement(line.trim())?;
        }
        parser.finish()
    }
}

#[derive(Default)]
struct Parser {
    out: ObjText,
    /// What the next face begins with.
    state: Face,
    line: usize,
    /// Faces with fewer than three corners.
    small: Counted,
    /// Corners that name a texture coordinate or a normal that the file lacks.
    absent: Counted,
    /// Texture coordinates and normals that are no numbers.
    odd: Counted,
    /// Points, curves and curved surfaces.
    other: Counted,
}

/// How often something is so, and the first line where it is.
#[derive(Default)]
struct Counted {
    count: usize,
    line: usize,
}

impl Counted {
    fn add(&mut self, line: usize) {
        self.line = if self.count == 0 { line } else { self.line.min(line) };
        self.count += 1;
    }
}

impl Parser {
    fn statement(&mut self, line: &str) -> Result<(), Error> {
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        match keyword {
            "v" => self.position(rest)?,
            "vt" => {
                let [u, v, _] = self.lenient(rest);
                self.out.texcoords.push([u, v]);
            }
            "vn" => {
                let normal = self.lenient(rest);
                self.out.normals.push(normal);
            }
            "f" | "l" => self.face(rest, keyword == "l")?,
            // A name has the number that it got where it came first.
            "o" => (self.state.object, self.state.group) = (self.out.objects.insert_full(rest.to_owned()).0, 0),
            "g" => {
                let name = if rest == "default" { "" } else { rest };
                self.state.group = self.out.groups.insert_full(name.to_owned()).0;
            }
            "usemtl" => self.state.material = self.out.materials.insert_full(rest.to_owned()).0,
            "mtllib" if !rest.is_empty() => self.out.libraries.push(rest.to_owned()),
            "s" => self.state.smooth = !matches!(rest, "off" | "0" | ""),
            "p" | "curv" | "curv2" | "surf" => self.other.add(self.line),
            _ => {}
        }
        Ok(())
    }

    fn bad(&self, what: impl std::fmt::Display) -> Error {
        malformed(format!("{}: line {}: {what}", self.out.name, self.line))
    }

    fn position(&mut self, rest: &str) -> Result<(), Error> {
        let mut numbers = Vec::with_capacity(6);
        for word in words(rest) {
            numbers.push(
                word.parse::<f32>().map_err(|_| {
                    self.bad(format_args!("'{}' is no number; v needs x y z, such as 0.5 0 1", cut(word)))
                })?,
            );
        }
        let Some(at) = numbers.first_chunk::<3>() else {
            return Err(self.bad(format_args!("v has {} numbers; it needs x y z", numbers.len())));
        };
        let count = self.out.positions.len();
        self.out.positions.push(finite(*at, || format!("{}: v line {}", self.out.name, count + 1))?);
        // Four numbers are x y z w.
        let colour = numbers.get(3..6).and_then(|c| c.first_chunk::<3>()).filter(|c| c.iter().all(|x| x.is_finite()));
        if colour.is_some() || self.out.colours.is_some() {
            let colours = self.out.colours.get_or_insert_with(Vec::new);
            colours.resize(count, [1.0; 3]);
            colours.push(colour.copied().unwrap_or([1.0; 3]));
        }
        Ok(())
    }

    /// Up to three numbers of which the geometry does not depend. What is no finite number is zero.
    fn lenient(&mut self, rest: &str) -> [f32; 3] {
        let mut out = [0.0; 3];
        for (slot, word) in out.iter_mut().zip(words(rest)) {
            match word.parse::<f32>().ok().filter(|x| x.is_finite()) {
                Some(number) => *slot = number,
                None => {
                    self.odd.add(self.line);
                    return [0.0; 3];
                }
            }
        }
        out
    }

    fn face(&mut self, rest: &str, is_line: bool) -> Result<(), Error> {
        let corners = words(rest).map(|word| self.corner(word)).collect::<Result<Vec<Corner>, Error>>()?;
        if corners.len() < if is_line { 2 } else { 3 } {
            self.small.add(self.line);
            return Ok(());
        }
        self.out.faces.push(Face { corners, is_line, line: self.line, ..self.state });
        Ok(())
    }

    fn corner(&mut self, word: &str) -> Result<Corner, Error> {
        let mut parts = word.split('/');
        let mut index = || parts.next().filter(|part| !part.is_empty()).map(str::parse::<i64>).transpose();
        let (Ok(Some(v)), Ok(vt), Ok(vn)) = (index(), index(), index()) else {
            return Err(self.bad(format_args!("'{word}' is no face corner; it must be v, v/vt, v//vn or v/vt/vn")));
        };
        let count = self.out.positions.len();
        let Some(v) = resolved(v, count) else {
            let right = if v == 0 { "indices start at 1".to_owned() } else { format!("there are {count} before it") };
            return Err(self.bad(format_args!("a face uses v {v}; {right}")));
        };
        let [vt, vn] = [(vt, self.out.texcoords.len()), (vn, self.out.normals.len())].map(|(written, count)| {
            let written = written.filter(|i| *i != 0);
            let found = written.and_then(|i| resolved(i, count));
            if written.is_some() && found.is_none() {
                self.absent.add(self.line);
            }
            found
        });
        Ok(Corner { v, vt, vn })
    }

    fn finish(mut self) -> Result<ObjText, Error> {
        let name = &self.out.name;
        if self.out.positions.is_empty() {
            return Err(malformed(format!("{name}: no v lines; this is not an OBJ file with vertices")));
        }
        // Faces may stand before the vertices that they use.
        let counts = [self.out.positions.len(), self.out.texcoords.len(), self.out.normals.len()];
        for face in &mut self.out.faces {
            if let Some(bad) = face.corners.iter().find(|c| c.v as usize >= counts[0]) {
                let (line, v) = (face.line, u64::from(bad.v) + 1);
                return Err(malformed(format!("{name}: line {line}: a face uses v {v}; there are {}", counts[0])));
            }
            for corner in &mut face.corners {
                for (index, count) in [(&mut corner.vt, counts[1]), (&mut corner.vn, counts[2])] {
                    if index.is_some_and(|i| i as usize >= count) {
                        self.absent.add(face.line);
                        *index = None;
                    }
                }
            }
        }
        if let Some(colours) = &mut self.out.colours {
            colours.resize(counts[0], [1.0; 3]);
            // Some programs write bytes.
            let scale = if colours.iter().flatten().any(|c| *c > 1.0) { 1.0 / 255.0 } else { 1.0 };
            colours.iter_mut().flatten().for_each(|c| *c = (*c * scale).clamp(0.0, 1.0));
        }
        let counted = [
            (self.small, "faces have fewer than three corners and are left out"),
            (self.absent, "corners of faces name a vt or vn line that the file lacks; they are read without it"),
            (self.odd, "vt and vn lines are no numbers; they are read as zero, and such normals are computed anew"),
            (self.other, "points, curves or curved surfaces are left out; export curved surfaces as polygons"),
        ];
        for (Counted { count, line }, what) in counted.into_iter().filter(|(counted, _)| counted.count > 0) {
            self.out.notes.push(format!("{name}, from line {line}: {count} {what}"));
        }
        Ok(self.out)
    }
}

/// The words of a statement, up to a comment.
fn words(rest: &str) -> impl Iterator<Item = &str> {
    rest.split_whitespace().take_while(|word| !word.starts_with('#'))
}

/// The index from 0 of what a file counts from 1, or backwards from -1 behind the `count` that have been read. Whether an index
/// from 1 is too large is known at the end of the file.
fn resolved(index: i64, count: usize) -> Option<u32> {
    let at = if index < 0 { i64::try_from(count).ok()?.checked_add(index)? } else { index.checked_sub(1)? };
    u32::try_from(at).ok()
}
