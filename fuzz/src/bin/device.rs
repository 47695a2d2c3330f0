//! Random scenes on Vulkan devices: after each frame their vertices are the CPU's, in random formats.
#![no_main]

use std::cell::RefCell;

use arbitrary::Unstructured;
use compare::{Expected, TestedDevice};
use crumple::ExampleSet;
use crumple_fuzz::engine::{self, Engine};
use crumple_fuzz::{scene, seeds, target};
use layout::TestLayout;

/// What the comparison of the tests needs.
mod backend {
    use crumple::vulkan::vk;
    pub use crumple::vulkan::{Attribute, Encoding, Stream, encode};
    use crumple::vulkan::{BufferId, TargetDef};

    pub type BufferRef<'a> = BufferId;
    pub type Def<'a> = TargetDef;

    pub fn format(attribute: Attribute, encoding: Encoding) -> vk::Format {
        match (encoding, attribute) {
            (Encoding::F32, Attribute::Tangent) => vk::Format::R32G32B32A32_SFLOAT,
            (Encoding::F32, _) => vk::Format::R32G32B32_SFLOAT,
            (Encoding::F16x4, _) => vk::Format::R16G16B16A16_SFLOAT,
            (Encoding::Snorm16x4, _) => vk::Format::R16G16B16A16_SNORM,
            (Encoding::Snorm8x4, _) => vk::Format::R8G8B8A8_SNORM,
            (Encoding::Octahedral16x2, _) => vk::Format::R16G16_UNORM,
        }
    }
}

#[allow(dead_code)]
#[path = "../../../tests/gpu/compare.rs"]
mod compare;
#[allow(dead_code)]
#[path = "../../../tests/gpu/layout.rs"]
mod layout;

/// A word that nothing ever writes.
const POISON: u32 = 0xCDCD_CDCD;
/// Drivers that must give the CPU's bits.
const DRIVERS: [&str; 2] = ["llvmpipe", "SwiftShader"];

target!(run, seeds: seeds::noise);

fn run(data: &[u8]) {
    thread_local! {
        static ENGINES: RefCell<Vec<Engine>> = RefCell::new(engine::all());
    }
    ENGINES.with_borrow_mut(|engines| engines.iter_mut().for_each(|engine| play(&mut Unstructured::new(data), engine)));
}

/// Plays the scene on one device. The first bytes choose the formats.
fn play(bytes: &mut Unstructured<'_>, engine: &mut Engine) {
    let device = TestedDevice { name: engine.name.clone(), driver: engine.driver.clone(), translated: false };
    let chosen: [u8; 4] = bytes.arbitrary().unwrap_or_default();
    let mut shown = None;
    scene::play(bytes, |body| {
        let (set, buffer) = (body.example_set().clone(), engine.buffer());
        let (layout, target) = shown.get_or_insert_with(|| {
            let layout = TestLayout::interleaved(&set, 0, 4 * u64::from(chosen[3] >> 4), encodings(&set, chosen));
            (layout, engine.target(&set, &layout.def(buffer), POISON))
        });
        let mut expected = Expected::poison(engine::SIZE as usize / 4);
        layout.expect(body, &mut expected);
        let got = engine.run(crumple::vulkan::RecordJob { instance: body, target });
        expected.compare(got, &device, "the frame");
    });
}

/// An encoding for each attribute that the mesh has.
fn encodings(set: &ExampleSet, chosen: [u8; 4]) -> [Option<backend::Encoding>; 3] {
    use backend::Encoding::{F16x4, F32, Octahedral16x2, Snorm8x4, Snorm16x4};
    let of = |i: usize, list: &[Option<backend::Encoding>]| list[usize::from(chosen[i] & 15) % list.len()];
    let directions = [Some(F32), Some(Snorm16x4), Some(Snorm8x4), Some(Octahedral16x2), None];
    let normals = set.mesh().normals().and_then(|_| of(1, &directions));
    [
        of(0, &[Some(F32), Some(F16x4), Some(Snorm16x4)]),
        normals,
        set.mesh().tangents().and(normals).and_then(|_| of(2, &directions)),
    ]
}
