//! Bad input is refused with an error that names it.

use std::sync::Arc;

use crumple::{Error, ErrorKind, ExampleSet, Instance, InstanceOptions, Rule, Serial, SetOptions};

use super::layout::TestLayout;
use super::scene::Scene;
use super::{Lowered, folded};
use crate::backend::{BAD_POSITION, Def, HALF_POSITION, Job, OCTAHEDRAL, PACKED_POSITION, Stream, on_each_device};
use crate::scenes;

/// Fails unless the result is an error of this kind with all of these words in its text.
#[track_caller]
pub fn refused<T>(result: Result<T, Error>, kind: ErrorKind, words: &[&str]) {
    let Err(error) = result else { panic!("accepted; {words:?} should be refused") };
    let text = error.to_string();
    assert!(error.kind() == kind && words.iter().all(|w| text.contains(w)), "{kind:?} {words:?}: {error:?} {text}");
}

#[test]
fn targets_that_will_not_do_are_refused() {
    use ErrorKind::{BufferTooSmall, IndexOutOfRange, InvalidArgument, Misaligned, Unsupported};
    let set = scenes::cube_set();
    on_each_device(|gpu| {
        let layout = TestLayout::everything(&set, 0, 0);
        let buffer = gpu.buffer(layout.size);
        let good = layout.def(buffer.as_ref());
        let mut no = |def: Def<'_>, kind, words: &[&str]| refused(gpu.crumple.add_target(&set, &def), kind, words);
        no(Def { lod: 1, ..good }, IndexOutOfRange, &["1"]);
        no(Def { offset: 2, size: 4, ..good }, Misaligned, &["target's offset", "2"]);
        no(Def { offset: 8, ..good }, BufferTooSmall, &["buffer"]);
        no(Def { size: layout.size - 8, ..good }, BufferTooSmall, &["tangent"]);
        let with = |change: fn(&mut Stream)| {
            let mut positions = good.positions;
            change(&mut positions);
            Def { positions, ..good }
        };
        no(with(|s| s.stride = 50), Misaligned, &["position stride", "50", "4"]);
        no(with(|s| s.offset = 3), Misaligned, &["position offset", "3"]);
        no(with(|s| s.stride = 8), InvalidArgument, &["position stride", "8", "12"]);
        no(with(|s| s.stride = 1 << 40), InvalidArgument, &["position stride"]);
        no(with(|s| s.offset += 8), InvalidArgument, &["position", "normal"]);
        let (bad, floats) = BAD_POSITION;
        let bad_name = format!("{bad:?}");
        let packed_name = format!("{PACKED_POSITION:?}");
        let words = ["position format", &bad_name, floats, &packed_name];
        no(with(|s| s.format = BAD_POSITION.0), InvalidArgument, &words);
        let octahedral_name = format!("{OCTAHEDRAL:?}");
        no(with(|s| s.format = OCTAHEDRAL), InvalidArgument, &["position format", &octahedral_name, floats]);
        let normals = Some(Stream { format: OCTAHEDRAL, stride: 50, ..good.normals.unwrap() });
        no(Def { normals, ..good }, Misaligned, &["normal stride", "50"]);
        let normals = Some(Stream { format: HALF_POSITION, ..good.normals.unwrap() });
        no(Def { normals, ..good }, InvalidArgument, &["normal format", "8"]);
        let tangents = Some(Stream { format: good.positions.format, ..good.tangents.unwrap() });
        no(Def { tangents, ..good }, InvalidArgument, &["tangent format", "8"]);
        for scale in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            let def = Def { scale: [1.0, scale, 1.0], ..with(|s| s.format = PACKED_POSITION) };
            no(def, InvalidArgument, &["scale", &format!("{scale:?}")]);
        }
        // Attributes that a mesh does not have.
        let stream = |s: Stream, offset| Stream { offset, stride: 44, ..s };
        let (positions, normals) = (stream(good.positions, 0), stream(good.normals.unwrap(), 12));
        let tangents = Some(stream(good.tangents.unwrap(), 24));
        let mut flat = scenes::sheet(4);
        (flat.normals, flat.tangents, flat.triangles) = (None, None, Vec::new());
        let bare = scenes::build(flat, vec![scenes::poke(3, 0.1)], SetOptions::default());
        let def = Def { normals: Some(normals), positions, tangents: None, ..good };
        refused(gpu.crumple.add_target(&bare, &def), Unsupported, &["normal"]);
        let def = Def { tangents, positions, normals: None, ..good };
        refused(gpu.crumple.add_target(&scenes::ball_set(), &def), Unsupported, &["tangent"]);
        gpu.crumple.add_target(&set, &good).unwrap();
    });
}

#[test]
fn workgroup_sizes_that_will_not_do_are_refused() {
    on_each_device(|gpu| {
        for workgroup_size in [0, 16, 100, 256] {
            let made = gpu.lowered(Lowered { workgroup_size, ..Lowered::default() });
            refused(made, ErrorKind::InvalidArgument, &["workgroup_size", &workgroup_size.to_string(), "power of two"]);
        }
    });
}

#[test]
fn jobs_of_other_devices_and_sets_are_refused_and_change_nothing() {
    use ErrorKind::InvalidArgument;
    let set = scenes::cube_set();
    on_each_device(|gpu| {
        let mut other = gpu.lowered(Default::default()).unwrap();
        let mut scene = Scene::of(gpu, &set, 5, 1);
        refused(other.run(&mut scene.jobs()), InvalidArgument, &["target of job 0", "another device"]);
        let stranger = folded(&scenes::ball_set(), 1, 1);
        let job = Job { instance: &stranger, target: &mut scene.targets[0] };
        refused(gpu.run(&mut [job]), InvalidArgument, &["instance of job 0", "example set"]);
        assert!(scene.targets[0].bounds().is_none());
        scene.compare(gpu, "refused");
        scene.run(gpu);
        scene.check(gpu, "after errors");
    });
}

#[test]
fn classic_rules_show_the_base_mesh_alone() {
    let mesh = scenes::sheet(8);
    let examples = scenes::bowls(&mesh, 2, 0.3, 1);
    let mut set = ExampleSet::build(mesh, examples, SetOptions::default(), &Serial).unwrap();
    set.add_lod(scenes::sheet(4), &Serial).unwrap();
    let set = Arc::new(set);
    on_each_device(|gpu| {
        let layout = TestLayout::everything(&set, 1, 0);
        let buffer = gpu.buffer(layout.size);
        let target = &mut gpu.add_target(&set, &layout, &buffer).unwrap();
        let instance = &Instance::new(set.clone(), InstanceOptions::classic(Rule::MostDisplaced)).unwrap();
        let result = gpu.run(&mut [Job { instance, target }]);
        refused(result, ErrorKind::WrongRule, &["level of detail", "Marks"]);
    });
}
