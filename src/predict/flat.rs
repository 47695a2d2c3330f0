//! A learned rule as bytes: a sequence of arrays, each a u64 length and its elements, little-endian, filled up to 8 bytes.
//! docs/format.md names them.

use super::body::Body;
use super::features::{AXES, Points};
use super::hits::Typical;
use super::predictor::{Model, Part, Predictor};
use super::size::SizeLaw;
use super::stamp::STAMP;
use crate::base::error::Error;
use crate::mesh::mirror::Mirror;
use bytemuck::Pod;

/// The largest absolute value of any number.
const MOST: f64 = 1e30;

/// Arrays that are written to bytes, or read from them. One list of arrays serves both.
enum Flat<'a> {
    Write(&'a mut Vec<u8>),
    Read(&'a [u8]),
}

fn wrong(what: &str, value: impl std::fmt::Display, expected: impl std::fmt::Display) -> Error {
    Error::Format { what: format!("baked set: {what} of section rule is {value}; it must be {expected}") }
}

impl Flat<'_> {
    fn array<T: Pod>(&mut self, array: &mut Vec<T>) -> Result<(), Error> {
        match self {
            Flat::Write(out) => {
                out.extend((array.len() as u64).to_le_bytes());
                out.extend(bytemuck::cast_slice::<T, u8>(array));
                out.resize(out.len().next_multiple_of(8), 0);
            }
            Flat::Read(rest) => {
                let short = || wrong("the length", "too short", "that of its arrays");
                let (length, after) = rest.split_first_chunk().ok_or_else(short)?;
                let length = usize::try_from(u64::from_le_bytes(*length)).map_err(|_| short())?;
                let bytes = length.checked_mul(size_of::<T>()).ok_or_else(short)?;
                let filled = bytes.checked_next_multiple_of(8).ok_or_else(short)?;
                let (own, after) = after.split_at_checked(filled).ok_or_else(short)?;
                *array = bytemuck::pod_collect_to_vec(&own[..bytes]);
                *rest = after;
            }
        }
        Ok(())
    }

    /// Numbers that are finite and not huge.
    fn numbers<T: Pod + Into<f64>>(&mut self, array: &mut Vec<T>) -> Result<(), Error> {
        self.array(array)?;
        match array.iter().map(|x| (*x).into()).find(|x: &f64| x.is_nan() || x.abs() > MOST) {
            Some(x) => Err(wrong("a number", x, format!("finite and at most {MOST}"))),
            None => Ok(()),
        }
    }

    /// A few numbers with places of their own.
    fn fixed<'x>(&mut self, all: impl IntoIterator<Item = &'x mut f64>) -> Result<(), Error> {
        let all: Vec<&mut f64> = all.into_iter().collect();
        let mut array = all.iter().map(|x| **x).collect();
        self.numbers(&mut array)?;
        length("a group of numbers", array.len(), all.len())?;
        all.into_iter().zip(array).for_each(|(to, x)| *to = x);
        Ok(())
    }

    fn part(&mut self, part: &mut Part, (rows, columns): (usize, usize)) -> Result<(), Error> {
        self.fixed(&mut part.factors)?;
        self.numbers(&mut part.mean)?;
        self.numbers(&mut part.coefficients)?;
        self.numbers(&mut part.steps)?;
        self.array(&mut part.modes)?;
        let rank = part.mean.len();
        length("a number of steps", part.steps.len(), rank)?;
        length("a number of coefficients", part.coefficients.len(), rank * rows)?;
        length("a number of modes", part.modes.len(), rank * columns)
    }

    fn size(&mut self, law: &mut SizeLaw, rows: usize) -> Result<(), Error> {
        self.fixed(law.law.iter_mut().chain(&mut law.factors).chain([&mut law.mean]))?;
        self.numbers(&mut law.coefficients)?;
        self.numbers(&mut law.knots)?;
        length("a number of coefficients", law.coefficients.len(), rows)?;
        let rise = law.knots.windows(2).all(|pair| pair[0] < pair[1]);
        if law.knots.is_empty() || !rise { Err(wrong("the knots", "no rising list", "one")) } else { Ok(()) }
    }

    fn model(&mut self, m: &mut Model, points: usize) -> Result<(), Error> {
        let mut rows = m.rows.concat();
        self.numbers(&mut rows)?;
        if !rows.len().is_multiple_of(AXES) || rows.is_empty() {
            return Err(wrong("a number of hits", rows.len(), format!("a multiple of {AXES}, above 0")));
        }
        m.rows = rows.as_chunks::<AXES>().0.to_vec();
        let n = m.rows.len();
        let mut examples: Vec<[u32; 2]> = m.examples.iter().map(|(e, mirror)| [*e, mirror.bits().into()]).collect();
        self.array(&mut examples)?;
        length("a number of examples", examples.len(), n)?;
        m.examples = examples.iter().map(|[e, mirror]| (*e, Mirror::from_bits(*mirror as u8))).collect();
        self.numbers(&mut m.logs)?;
        self.numbers(&mut m.errors)?;
        length("a number of sizes", m.logs.len(), n)?;
        length("a number of errors", m.errors.len(), n)?;
        self.fixed([&mut m.share, &mut m.factor, &mut m.reference, &mut m.far])?;
        self.size(&mut m.size, n)?;
        self.part(&mut m.carried, (n, STAMP))?;
        self.part(&mut m.anchored, (n, 3 * points))?;
        m.points = Points::new(&m.rows);
        m.most = m.logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Ok(())
    }

    /// Everything that does not follow from the body.
    fn rule(&mut self, p: &mut Predictor) -> Result<(), Error> {
        let points = p.body.count;
        let (mut kind, mut reach) = (f64::from(p.typical.kind), f64::from(p.reach));
        let [mut blows, mut displacements] = [&p.blow, &p.displacement].map(|m| f64::from(u8::from(m.is_some())));
        let Typical { mass, radius, rebound, .. } = &mut p.typical;
        self.fixed([mass, radius, rebound, &mut kind, &mut reach, &mut blows, &mut displacements])?;
        (p.typical.kind, p.reach) = (kind as u32, reach as f32);
        let mut partners: Vec<u32> = Vec::new();
        for (mirror, list) in &p.partners {
            partners.push(mirror.bits().into());
            partners.extend(list);
        }
        self.array(&mut partners)?;
        if !partners.len().is_multiple_of(points + 1) {
            return Err(wrong("the number of mirrored points", partners.len(), "one for each point and mirror"));
        }
        let of_mirror = |list: &[u32]| (Mirror::from_bits(list[0] as u8), list[1..].to_vec());
        p.partners = partners.chunks_exact(points + 1).map(of_mirror).collect();
        if let Some(far) = p.partners.iter().flat_map(|(_, list)| list).find(|v| **v as usize >= points) {
            return Err(wrong("a mirrored point", far, format!("below {points}")));
        }
        self.array(&mut p.order)?;
        let samples = p.order.len();
        let mut given: Vec<u32> = p.order.clone();
        given.sort_unstable();
        if !given.into_iter().eq(0..samples as u32) {
            return Err(wrong("the order of the examples", format!("{samples} numbers"), "each of them once"));
        }
        if displacements != 0.0 {
            self.model(p.displacement.get_or_insert_default(), points)?;
        }
        if blows != 0.0 {
            self.model(p.blow.get_or_insert_default(), points)?;
        }
        match p.displacement.iter().chain(&p.blow).flat_map(|m| &m.examples).find(|(e, _)| *e as usize >= samples) {
            Some((e, _)) => Err(wrong("an example", e, format!("below {samples}"))),
            None => Ok(()),
        }
    }
}

fn length(what: &str, value: usize, expected: usize) -> Result<(), Error> {
    if value == expected { Ok(()) } else { Err(wrong(what, value, expected)) }
}

impl Predictor {
    /// Everything that was learned.
    ///
    /// # Errors
    /// [`Error::Format`] for numbers that are not finite or huge.
    pub(crate) fn to_bytes(&self) -> Result<Vec<u8>, Error> {
        let mut out = Vec::new();
        Flat::Write(&mut out).rule(&mut self.clone())?;
        Ok(out)
    }

    /// The rule of a body from [`Predictor::to_bytes`].
    ///
    /// # Errors
    /// [`Error::Format`].
    pub(crate) fn from_bytes(body: Body, bytes: &[u8]) -> Result<Self, Error> {
        let mut rule = Predictor {
            body,
            partners: Vec::new(),
            typical: Typical::default(),
            blow: None,
            displacement: None,
            order: Vec::new(),
            reach: 0.0,
        };
        let mut flat = Flat::Read(bytes);
        flat.rule(&mut rule)?;
        match flat {
            Flat::Read([]) | Flat::Write(_) => Ok(rule),
            Flat::Read(rest) => Err(wrong("the rest", format!("{} bytes", rest.len()), "empty")),
        }
    }
}
