//! Compares vertices of a device with those of the CPU.
//!
//! Lavapipe and SwiftShader round every operation as IEEE 754 says, so they must give the CPU's bits. Vulkan allows other devices
//! to differ (Vulkan specification, "Precision and Operation of SPIR-V Instructions"):
//!
//! - Additions, subtractions and multiplications are rounded correctly. NoContraction forbids to fuse them.
//! - A division may be wrong by 2.5 units in the last place (ulp).
//! - A square root is computed as 1 / inversesqrt. That makes 2 + 2.5 ulp.
//! - Numbers below 1.2e-38 may count as 0.
//!
//! The kernels divide and take roots in these places:
//!
//! - The length limit scales a displacement by `sqrt(a) / sqrt(b)`: at most 4.5 + 4.5 + 2.5 = 11.5 ulp of the displacement. A
//!   normal is scaled likewise, and divided by its length: 11.5 + 4.5 + 2.5 = 18.5 ulp of 1. A tangent is turned with the normal
//!   and made a unit vector in two more steps of 7 ulp. [`ULPS`] covers that.
//! - A normalised position is divided by its scale, which may change the integer by 1.
//! - An octahedral vector is divided by the sum of its coordinates, which may change each integer by 1. Decoded, that turns a
//!   tangent by up to 0.0002.

use crumple::Instance;
use half::f16;

use crate::backend::{Attribute, Encoding};

/// A word that nothing ever writes.
pub const POISON: u32 = 0xCDCD_CDCD;

/// The software drivers that every test runs on. A device's name begins with one of these.
const DRIVERS: [&str; 2] = ["llvmpipe", "SwiftShader"];

/// Whether a driver and the validation layer must be there.
pub fn required() -> bool {
    std::env::var("CRUMPLE_REQUIRE_GPU").is_ok_and(|v| v != "0")
}

/// Prints which software drivers are not among these devices. Fails if CRUMPLE_REQUIRE_GPU names one of them.
pub fn note_missing(seen: &[String]) {
    let named = std::env::var("CRUMPLE_REQUIRE_GPU").unwrap_or_default();
    for driver in DRIVERS {
        if !seen.iter().any(|name| name.starts_with(driver)) {
            assert!(!named.split(',').any(|n| n == driver), "{driver} is required, but there are only {seen:?}");
            eprintln!("left out: there is no {driver}, only {seen:?}");
        }
    }
}

/// Units in the last place that divisions and square roots may cost, of the largest coordinate or of 1 for directions.
const ULPS: f32 = 64.0;

/// The device that a test runs on.
#[derive(Debug, Clone)]
pub struct TestedDevice {
    pub name: String,
    /// Its driver, with the version.
    pub driver: String,
    /// Whether wgpu translates the kernels, so that the driver may fuse and reorder operations.
    pub translated: bool,
}

impl TestedDevice {
    /// How many times the bounds its numbers may be off; 0 where it must give the CPU's bits. Kernels that wgpu translates are off by a few
    /// units, as src/wgpu/mod.rs states.
    fn slack(&self, attribute: Attribute) -> f32 {
        let of_driver = if DRIVERS.iter().any(|driver| self.name.starts_with(driver)) { 0.0 } else { 1.0 };
        let units = if attribute == Attribute::Position { 4.0 } else { 32.0 };
        of_driver + if self.translated { units / ULPS } else { 0.0 }
    }

    /// Whether it must give the CPU's bits.
    pub fn exact(&self) -> bool {
        self.slack(Attribute::Position) == 0.0
    }

    /// Prints the device and how its vertices are compared.
    pub fn announce(&self) {
        let how = if self.exact() { "bits" } else { "vertices within the bounds of tests/gpu/compare.rs" };
        println!("on {} (driver {}): compares {how}", self.name, self.driver);
    }
}

/// How far a device that is not exact may be off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// m.
    position: f32,
    /// Of a unit vector.
    direction: f32,
}

impl Bounds {
    /// The bounds for an instance.
    pub fn of(instance: &mut Instance) -> Self {
        let set = instance.example_set().clone();
        let bounds = set.mesh().bounds();
        let largest = bounds.min.abs().max(bounds.max.abs()).max_element() + set.depth_limit();
        let (position, direction) = (ULPS * f32::EPSILON * largest, ULPS * f32::EPSILON);
        Bounds { position, direction }
    }

    fn of_attribute(self, attribute: Attribute) -> f32 {
        match attribute {
            Attribute::Position => self.position,
            Attribute::Normal | Attribute::Tangent => self.direction,
        }
    }
}

/// How a word of a buffer may differ on a device that is not exact.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Allowed {
    /// Not at all.
    Nothing,
    /// Numbers in an encoding, by a bound on each and one step of the encoding.
    Numbers(Encoding, Attribute, [f32; 4]),
}

/// The words that a buffer should hold.
#[derive(Debug, Clone)]
pub struct Expected {
    words: Vec<u32>,
    allowed: Vec<Allowed>,
}

impl Expected {
    /// Of a buffer of `words` words that nothing was written to.
    pub fn poison(words: usize) -> Self {
        Expected { words: vec![POISON; words], allowed: vec![Allowed::Nothing; words] }
    }

    /// Puts a vertex's attribute at a word. A position's bounds are divided by the scale of normalised integers.
    pub fn put(
        &mut self,
        at: usize,
        attribute: Attribute,
        encoding: Encoding,
        words: &[u32],
        bounds: Bounds,
        scale: [f32; 3],
    ) {
        let bound = bounds.of_attribute(attribute);
        let [x, y, z] = scale.map(|s| bound / s);
        let all = [x, y, z, bound];
        self.words[at..at + words.len()].copy_from_slice(words);
        for i in 0..words.len() {
            let of = match encoding {
                Encoding::F32 => [all[i]; 4],
                Encoding::F16x4 | Encoding::Snorm16x4 => [all[2 * i], all[2 * i + 1], 0.0, 0.0],
                Encoding::Snorm8x4 | Encoding::Octahedral16x2 => all,
            };
            self.allowed[at + i] = Allowed::Numbers(encoding, attribute, of);
        }
    }

    /// Fails at the first word that differs by more than the device may.
    #[track_caller]
    pub fn compare(&self, got: &[u32], device: &TestedDevice, what: &str) {
        assert_eq!(got.len(), self.words.len(), "{what}");
        let differs = |i: &usize| !agree(got[*i], self.words[*i], self.allowed[*i], &|a| device.slack(a));
        let mut wrong = (0..got.len()).filter(differs);
        if let Some(at) = wrong.next() {
            let (g, w) = (got[at], self.words[at]);
            let floats = (f32::from_bits(g), f32::from_bits(w));
            panic!(
                "{what} on {} (driver {}): word {at} is {g:08x}, not {w:08x} ({floats:?}, {:?}); {} of {} words differ",
                device.name,
                device.driver,
                self.allowed[at],
                1 + wrong.count(),
                got.len()
            );
        }
    }
}

fn agree(got: u32, wanted: u32, allowed: Allowed, slack: &dyn Fn(Attribute) -> f32) -> bool {
    let zero_for_tiny = f32::from_bits(wanted).is_subnormal() && got << 1 == 0;
    let Allowed::Numbers(encoding, attribute, bounds) = allowed else { return got == wanted };
    if got == wanted || encoding == Encoding::F32 && zero_for_tiny {
        return true;
    }
    // A NaN agrees with nothing.
    slack(attribute) > 0.0
        && numbers(encoding, attribute, got).iter().zip(numbers(encoding, attribute, wanted)).zip(bounds).all(
            |((g, w), bound)| {
                let step = match encoding {
                    Encoding::F32 => 0.0,
                    // Half of a unit in the last place of eleven bits, once on each side.
                    Encoding::F16x4 => w.abs().max(6.2e-5) / 1024.0,
                    Encoding::Snorm16x4 => 1.0 / 32767.0,
                    Encoding::Snorm8x4 => 1.0 / 127.0,
                    Encoding::Octahedral16x2 => 2e-4,
                };
                (g - w).abs() <= slack(attribute) * bound + step * 1.0001
            },
        )
}

/// The numbers in a word.
fn numbers(encoding: Encoding, attribute: Attribute, word: u32) -> [f32; 4] {
    let halves = [word as u16, (word >> 16) as u16];
    match encoding {
        Encoding::F32 => [f32::from_bits(word), 0.0, 0.0, 0.0],
        Encoding::F16x4 => {
            let [x, y] = halves.map(|h| f16::from_bits(h).to_f32());
            [x, y, 0.0, 0.0]
        }
        Encoding::Snorm16x4 => {
            let [x, y] = halves.map(|h| f32::from(h as i16) / 32767.0);
            [x, y, 0.0, 0.0]
        }
        Encoding::Snorm8x4 => word.to_le_bytes().map(|b| f32::from(b as i8) / 127.0),
        Encoding::Octahedral16x2 => octahedral(halves, attribute == Attribute::Tangent),
    }
}

/// The vector of two numbers on an unfolded octahedron, and for a tangent its sign.
fn octahedral(words: [u16; 2], tangent: bool) -> [f32; 4] {
    let [x, mut y] = words.map(|w| f64::from(w) / 65535.0 * 2.0 - 1.0);
    let sign = if tangent { y.signum() } else { 0.0 };
    if tangent {
        y = y.abs() * 2.0 - 1.0;
    }
    let z = 1.0 - x.abs() - y.abs();
    let folded = (-z).max(0.0);
    let v = [x - folded.copysign(x), y - folded.copysign(y), z];
    let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
    [v[0] / length, v[1] / length, v[2] / length, sign].map(|c| c as f32)
}
