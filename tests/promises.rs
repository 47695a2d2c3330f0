//! The promises of docs/model.md: bounded, local, independent of order, deterministic, watertight, and nothing written
//! where nothing changed. The tests submit up to 10 000 random hits to a sheet, a ball, a cube with hard edges and a UV
//! seam, and the solver's panel.

mod scenes;

use std::ops::Range;
use std::sync::Arc;

use crumple::glam::{Mat4, Quat, Vec3};
use crumple::{
    Attribute, BasisOptions, Blow, Cause, Deltas, Encoding, ExampleSet, Hit, HitStatus, Instance, InstanceOptions,
    Mark, Rule, Serial, SetOptions, SimdLevel, Space, TaskSystem, ThreadPool, Tracker, VertexMemory,
};
use proptest::prelude::*;
use scenes::{
    Body, Dice, Eager, Output, POISON, base, check_sound, dented, distance, fnv, new, push, random_hit, random_hits,
    rounding, with,
};

/// All bodies, built once, and last two that have learned, the first with levels of detail.
fn bodies() -> &'static [Body] {
    static BODIES: std::sync::OnceLock<Vec<Body>> = std::sync::OnceLock::new();
    BODIES.get_or_init(|| {
        let mut all = scenes::bodies();
        let mut levels = scenes::learned(&scenes::sheet(16), 12, 5);
        let set = Arc::get_mut(&mut levels).unwrap();
        for mesh in [scenes::sheet(16), scenes::sheet(40), scenes::cube(4)] {
            set.add_lod(mesh, &Serial).unwrap();
        }
        all.push(("sheet that has learned", levels));
        all.push(("cube that has learned", scenes::learned(&scenes::cube(6), 12, 6)));
        all
    })
}

fn any_body() -> impl Strategy<Value = &'static Body> {
    (0..6usize).prop_map(|i| &bodies()[i])
}

/// 1 to 10 000, small numbers as likely as large ones.
fn sequence_length() -> impl Strategy<Value = usize> {
    prop_oneof![1usize..10, 10usize..300, 300usize..3000, Just(10_000)]
}

fn bits(p: [f32; 3]) -> [u32; 3] {
    p.map(f32::to_bits)
}

/// No classic rule, twice as often as one.
fn any_rule() -> impl Strategy<Value = Option<f32>> {
    prop_oneof![2 => Just(None), 1 => (0.0f32..=1.0).prop_map(Some)]
}

/// The default rule, or the classic one that blends by `k`.
fn either_rule(k: Option<f32>) -> InstanceOptions {
    k.map_or(InstanceOptions::default(), |k| InstanceOptions::classic(Rule::Blend(k)))
}

// -------------------------------------------------------------------------------------------------- bounded and watertight

/// A mark that no hit would make but that is accepted.
fn any_mark(set: &ExampleSet, dice: &mut Dice) -> Mark {
    let depth = [1e-30, 1e-9, 0.01, 1.0, 1e9][dice.index(5)];
    let energy = [1, Mark::ONE, u64::MAX][dice.index(3)];
    let mut word = || dice.next() as u16;
    let (direction, others) = ([word(), word()], [word(), word(), word(), word()]);
    let told = u16::from(set.predicts_blows()) & others[0];
    let [striker, strength, mass, radius] = others.map(|x| told * x);
    let contact = dice.index(set.vertex_count()) as u32;
    Mark { contact, depth, energy, told, striker, direction, strength, mass, radius, reserved: 0 }
}

/// Any hit that an engine might report: sizes from 1e-30 to 1e30, any direction, as displacement or impulse.
fn wild_hit(set: &ExampleSet, dice: &mut Dice) -> Hit {
    let mut hit = random_hit(set, dice);
    let size = [1e-30f32, 1e-20, 1e-6, 1e-3, 1.0, 10.0, 1e4, 1e15, 1e30][dice.index(9)];
    let direction = dice.vector(1.0);
    let vector = direction.map(|x| x * size);
    hit.cause = match dice.index(3) {
        0 => Cause::Displacement(vector),
        1 => {
            let duration = [1e-30, 1e-3, 1.0, 1e30][dice.index(4)];
            let mass = Some([1e-30, 0.1, 1e30][dice.index(3)]);
            Cause::Impulse { blow: Blow::of_impulse(vector, duration), mass }
        }
        _ => hit.cause,
    };
    hit
}

proptest! {
    #![proptest_config(scenes::cases(24))]

    /// The clamped classic rules never pass the deepest example.
    #[test]
    fn bounded_whatever_is_submitted(
        body in any_body(), count in sequence_length(), seed in any::<u64>(), frames in 1usize..4, classic in any_rule(),
    ) {
        let (_, set) = body;
        let mut dice = Dice::new(seed);
        let depth_limit = [None, Some(1e-3), Some(0.05), Some(1e9)][dice.index(4)].filter(|_| classic.is_none());
        let mut instance = with(set, InstanceOptions { depth_limit, ..either_rule(classic) });
        let (count, deepest) = match classic {
            None => (count, f32::INFINITY),
            Some(_) => (count.min(600), set.examples().iter().map(|e| e.max_depth()).fold(0.0, f32::max)),
        };
        for _ in 0..frames {
            for _ in 0..count.div_ceil(frames) {
                let outcome = instance.submit(&wild_hit(set, &mut dice)).unwrap();
                let shortfall = outcome.shortfall();
                let all = outcome.achieved.iter().chain(&shortfall).chain(&outcome.target);
                prop_assert!(all.into_iter().all(|x| x.is_finite()), "{outcome:?}");
            }
            check_sound(&mut instance)?;
            let furthest = scenes::displacements(&mut instance).iter().map(|u| u.length()).fold(0.0, f32::max);
            prop_assert!(furthest <= deepest * (1.0 + 1e-5) + 1e-6, "{furthest}, deepest {deepest}");
        }
    }
}

// ------------------------------------------------------------------------------------------------------------------ local

/// Whether the mark can move vertex `v` or turn its normal, judged by public data alone: a dent ends at 1.3 times the furthest that an
/// example moves, and turns what is beside it.
fn reaches(set: &ExampleSet, mark: &Mark, v: usize) -> bool {
    let furthest = set.examples().iter().map(|e| f64::from(e.support_radius())).fold(0.0, f64::max);
    let beside = 0.1 * f64::from(set.mesh().bounds().diagonal());
    distance(base(set, v), base(set, mark.contact as usize)) <= 1.3 * furthest + beside
}

proptest! {
    #![proptest_config(scenes::cases(24))]

    #[test]
    fn nothing_moves_outside_the_supports_of_the_marks(body in (0..4usize).prop_map(|i| &bodies()[i]), count in 1usize..12, seed in any::<u64>()) {
        let (_, set) = body;
        let mut instance = dented(set, InstanceOptions::default(), &random_hits(set, count, seed));
        let marks = instance.marks().unwrap().to_vec();
        let out = Output::fresh(&mut instance);
        let still = Output::fresh(&mut new(set));
        for v in 0..set.vertex_count() {
            if !marks.iter().any(|m| reaches(set, m, v)) {
                prop_assert_eq!(out.bits(v), still.bits(v));
                prop_assert_eq!(bits(out.positions[v]), bits(base(set, v)));
            }
        }
    }

    #[test]
    fn a_carried_dent_is_where_the_body_was_hit(seed in any::<u64>(), which in 0usize..3) {
        let mesh = [scenes::sheet(24), scenes::ball(3), scenes::cube(10)][which].clone();
        // not on the sides of the sheet, where a dent shows half of itself
        let inside = |p: &[f32; 3]| which > 0 || p[..2].iter().all(|x| x.abs() < 0.3);
        let places: Vec<u32> = (0..).zip(&mesh.positions).filter(|(_, p)| inside(p)).map(|(v, _)| v).collect();
        let bowl = |i: usize| {
            let place = places[i * 37 % places.len()];
            scenes::bowl(&mesh, place, 0.03 + 0.015 * i as f32, 0.22 + 0.03 * i as f32)
        };
        let examples = (0..5).map(bowl).collect();
        let set = scenes::build(mesh.clone(), examples, SetOptions::default());
        let mut dice = Dice::new(seed);
        let vertex = dice.index(set.vertex_count());
        let n = set.mesh().contact_normal(vertex as u32).unwrap();
        // What is deeper approaches the limit.
        let depth = 0.75 * set.depth_limit() * dice.between(0.2, 0.9);
        let mut instance = new(&set);
        let outcome = instance.submit(&push(base(&set, vertex), (n * -depth).to_array())).unwrap();
        prop_assert_eq!(outcome.status, HitStatus::Marked);
        let mark = outcome.mark.unwrap();
        let wide = |e: &crumple::Example| e.support_radius() * (mark.depth / e.depth()).sqrt().clamp(0.25, 4.0);
        let wide = set.examples().iter().map(wide).fold(0.0, f32::max);
        let out = Output::fresh(&mut instance);
        let moved = |v: usize| distance(out.positions[v], base(&set, v));
        let deepest = (0..set.vertex_count()).max_by(|a, b| moved(*a).total_cmp(&moved(*b))).unwrap();
        // the contact moves as asked (on the cube, where normals at edges lie between faces: as reported), and no
        // vertex is much deeper
        let at_contact = moved(outcome.contact_vertex as usize);
        let ought = if which == 2 { f64::from(scenes::length(outcome.achieved)) } else { f64::from(depth) };
        prop_assert!((at_contact - ought).abs() <= 0.01 * ought, "{at_contact}, not {ought}");
        prop_assert!(at_contact >= 0.9 * moved(deepest), "contact {at_contact}, deepest {}", moved(deepest));
        // a bowl is round: no vertex outside its radius moves much, and every vertex well inside moves
        for v in 0..set.vertex_count() {
            let away = distance(base(&set, v), base(&set, vertex)) as f32;
            prop_assert!(moved(v) <= 0.06 * f64::from(depth) || away <= 1.7 * wide, "vertex {v} moved {} at {away} m, radius {wide}", moved(v));
        }
    }
}

// -------------------------------------------------------------------------------------------- free of order, deterministic

fn save_after(set: &Arc<ExampleSet>, options: InstanceOptions, frames: &[Vec<Hit>]) -> Vec<u8> {
    let mut instance = with(set, options);
    for frame in frames {
        for hit in frame {
            instance.submit(hit).unwrap();
        }
        instance.fold();
    }
    instance.save()
}

/// Splits `hits` into frames at random.
fn cut(mut hits: Vec<Hit>, dice: &mut Dice) -> Vec<Vec<Hit>> {
    let mut frames = Vec::new();
    while !hits.is_empty() {
        let rest = hits.split_off(1 + dice.index(hits.len()));
        frames.push(std::mem::replace(&mut hits, rest));
    }
    frames
}

proptest! {
    #![proptest_config(scenes::cases(16))]

    /// The classic rules depend on the cut into frames, and so do marks that merge.
    #[test]
    fn the_order_does_not_matter_nor_does_the_cut_into_frames_until_the_capacity(
        body in any_body(), count in sequence_length(), seed in any::<u64>(), capacity in prop_oneof![1u32..100, Just(12_000)], classic in any_rule(),
    ) {
        let (_, set) = body;
        let options = InstanceOptions { capacity, ..either_rule(classic) };
        let mut dice = Dice::new(seed);
        let mut hits = random_hits(set, count.min(if classic.is_some() { 60 } else { count }), seed);
        let once = save_after(set, options, std::slice::from_ref(&hits));
        dice.shuffle(&mut hits);
        let frames = if classic.is_none() && count <= capacity as usize { cut(hits, &mut dice) } else { vec![hits] };
        prop_assert!(once == save_after(set, options, &frames));
    }

    #[test]
    fn the_order_of_given_marks_does_not_matter(body in any_body(), count in 1usize..20, seed in any::<u64>(), capacity in 1u32..20) {
        let (_, set) = body;
        let mut dice = Dice::new(seed);
        let mut marks: Vec<Mark> = (0..count).map(|_| any_mark(set, &mut dice)).collect();
        let given = |marks: &[Mark]| {
            let mut instance = with(set, InstanceOptions { capacity, ..InstanceOptions::default() });
            instance.set_marks(marks).unwrap();
            (instance.save(), Output::fresh(&mut instance).all_bits())
        };
        let once = given(&marks);
        dice.shuffle(&mut marks);
        prop_assert!(once == given(&marks));
        // What is loaded is merged alike on the way in.
        let (mut all, mut loaded) = (new(set), with(set, InstanceOptions { capacity, ..InstanceOptions::default() }));
        all.set_marks(&marks).unwrap();
        loaded.load(&all.save()).unwrap();
        prop_assert!(loaded.marks().unwrap().len() <= capacity as usize && once.0 == loaded.save());
    }

    #[test]
    fn any_number_of_threads_submits_and_deforms_alike(body in any_body(), count in 1usize..600, seed in any::<u64>()) {
        let (_, set) = body;
        let hits = random_hits(set, count, seed);
        let alone = save_after(set, InstanceOptions::default(), std::slice::from_ref(&hits));
        let mut reference: Option<Vec<[u32; 10]>> = None;
        for tasks in task_systems() {
            let mut instance = new(set);
            let inbox = instance.inbox().clone();
            std::thread::scope(|scope| {
                for part in hits.chunks(hits.len().div_ceil(8)) {
                    let inbox = &inbox;
                    scope.spawn(move || part.iter().for_each(|h| { inbox.submit(h).unwrap(); }));
                }
            });
            prop_assert!(instance.save() == alone);
            let mut out = Output::new(set);
            out.update_with(&mut instance, tasks.as_ref());
            prop_assert!(reference.get_or_insert_with(|| out.all_bits()) == &out.all_bits());
        }
    }
}

/// Serial, and pools of 1, 2 and 8 threads.
fn task_systems() -> &'static [Box<dyn TaskSystem + Send>] {
    static SYSTEMS: std::sync::OnceLock<Vec<Box<dyn TaskSystem + Send>>> = std::sync::OnceLock::new();
    SYSTEMS.get_or_init(|| {
        let pool = |n| -> Box<dyn TaskSystem + Send> { Box::new(Eager(ThreadPool::new(n).unwrap())) };
        vec![Box::new(Serial), pool(1), pool(2), pool(8)]
    })
}

#[test]
fn sets_are_built_alike_on_any_number_of_threads() {
    let build = |tasks: &dyn TaskSystem| {
        let mesh = scenes::cube(8);
        let examples = scenes::bowls(&mesh, 9, 0.4, 4);
        let options = SetOptions { whole_examples: true, ..SetOptions::default() };
        let mut set = ExampleSet::build(mesh, examples, options, tasks).unwrap();
        set.add_lod(scenes::ball(3), tasks).unwrap();
        set.save().unwrap()
    };
    let alone = build(&Serial);
    assert!(task_systems().iter().all(|tasks| build(tasks.as_ref()) == alone));
}

/// Hashes of a fixed scenario. A platform that differs here would disagree with others over a network. After a
/// deliberate change of the model or of the saved format, replace them by the printed values.
#[test]
fn quick_golden_marks_are_the_same_on_every_platform() {
    let found = scenes::small_bodies().into_iter().map(|(name, set)| {
        let mut instance = with(&set, InstanceOptions { capacity: 24, ..InstanceOptions::default() });
        let mut dice = Dice::new(2026);
        for frame in random_hits(&set, 60, 2026).chunks(13) {
            frame.iter().for_each(|h| _ = instance.submit(h).unwrap());
            let (impulse, v) = (dice.vector(90.0), dice.index(set.vertex_count()));
            instance.submit(&Hit::impulse(base(&set, v), impulse, 0.01, Some(2.5))).unwrap();
            instance.fold();
        }
        let mut vertices = SimdLevel::available().map(|level| {
            level.force().unwrap();
            let out = Output::fresh(&mut instance);
            fnv(&out.positions.iter().flatten().flat_map(|x| x.to_bits().to_le_bytes()).collect::<Vec<u8>>())
        });
        let first = vertices.next().unwrap();
        assert!(vertices.all(|hash| hash == first), "{name}: SIMD levels differ");
        format!("{name}: marks {:016x}, vertices {first:016x}", fnv(&instance.save()))
    });
    let golden = [
        "sheet: marks 747b0c187f7c9cc6, vertices 552e3d8f7177dd47",
        "ball: marks 5ae9091d9ac40fc9, vertices 93367433c27f38cc",
        "cube: marks ae565575a4785155, vertices cfb974e6e7563634",
    ];
    assert_eq!(found.collect::<Vec<_>>(), golden);
}

// ------------------------------------------------------------------------------------------- written: all, and only, changes

/// Checks vertices interleaved in a random layout, in floats or packed, with guard bytes before, between and after.
fn check_guards(set: &Arc<ExampleSet>, seed: u64) -> Result<(), TestCaseError> {
    const GUARD: u8 = 0xA5;
    let mut dice = Dice::new(seed);
    let gap = |dice: &mut Dice| 4 * dice.index(4);
    let has_tangents = set.mesh().tangents().is_some();
    let formats = [(); 2].map(|()| [Encoding::F32, Encoding::Octahedral16x2][dice.index(2)]);
    let words = |which: usize| if formats[which] == Encoding::F32 { 3 + which } else { 1 };
    let position = gap(&mut dice);
    let normal = position + 12 + gap(&mut dice);
    let tangent = normal + 4 * words(0) + gap(&mut dice);
    let last = if has_tangents { tangent + 4 * words(1) } else { normal + 4 * words(0) };
    let stride = last + gap(&mut dice);
    let count = set.vertex_count();
    // the memory ends with the last value; deform needs no byte beyond it
    let size = (count - 1) * stride + last;
    let before = dice.index(9);
    let mut bytes = vec![GUARD; before + size + 64];
    let attribute = |offset, format| Attribute { offset, stride, format };
    let mut instance = new(set);
    let mut tracker = Tracker::new();
    let mut plain = Output::new(set);
    for _ in 0..3 {
        instance.submit(&random_hit(set, &mut dice)).unwrap();
        let memory = VertexMemory::interleaved(
            &mut bytes[before..before + size],
            attribute(position, Encoding::F32),
            Some(attribute(normal, formats[0])),
            has_tangents.then_some(attribute(tangent, formats[1])),
        )
        .unwrap();
        instance.deform(&mut tracker, memory, &Serial).unwrap();
        plain.update(&mut instance);
    }
    let mut untouched = bytes.clone();
    let packed = |[x, y]: [u16; 2]| vec![u32::from(x) | u32::from(y) << 16];
    for v in 0..count {
        let mut take = |offset: usize, words: usize| -> Vec<u32> {
            let at = before + v * stride + offset;
            untouched[at..at + 4 * words].fill(GUARD);
            bytes[at..at + 4 * words].chunks_exact(4).map(|b| u32::from_le_bytes(b.try_into().unwrap())).collect()
        };
        let (n, t) = (plain.normals[v], plain.tangents[v]);
        let floats = [n.map(f32::to_bits).to_vec(), t.map(f32::to_bits).to_vec()];
        let packed = [packed(scenes::octahedral_normal(n)), packed(scenes::octahedral_tangent(t))];
        let ought = |which: usize| if words(which) == 1 { &packed[which] } else { &floats[which] };
        prop_assert_eq!(take(position, 3), plain.positions[v].map(f32::to_bits).to_vec());
        prop_assert_eq!(&take(normal, words(0)), ought(0));
        prop_assert!(!has_tangents || take(tangent, words(1)) == *ought(1), "tangent of vertex {v}");
    }
    prop_assert!(untouched.iter().all(|b| *b == GUARD), "a byte outside the attributes was written");
    Ok(())
}

fn poisoned(out: &Output, v: usize) -> bool {
    out.positions[v] == [POISON; 3]
}

/// Deforms into poisoned memory. It must write what `changed` lists, and that must include all that differs from
/// `before`. The triangles and the box that the tracker tells hold what was written, and a second call writes nothing.
fn check_changes(instance: &mut Instance, out: &mut Output) -> Result<(), TestCaseError> {
    let before = out.clone();
    out.poison();
    let report = out.update(instance);
    let ranges = out.tracker.changed().to_vec();
    let is_in = |ranges: &[Range<u32>], i: usize| ranges.iter().any(|r| r.contains(&(i as u32)));
    prop_assert!(ranges.windows(2).all(|w| w[0].end < w[1].start), "{ranges:?}");
    prop_assert!(ranges.iter().all(|r| r.start < r.end));
    let told: u64 = ranges.iter().map(|r| u64::from(r.end - r.start)).sum();
    prop_assert_eq!(told, report.vertices_written);
    prop_assert_eq!(out.tracker.changed_bounds().is_some(), told > 0);
    let fresh = Output::fresh_level(instance, out.lod);
    for v in 0..out.positions.len() {
        prop_assert_eq!(is_in(&ranges, v), !poisoned(out, v), "vertex {}", v);
        if poisoned(out, v) {
            prop_assert_eq!(before.bits(v), fresh.bits(v), "vertex {} changed and was not written", v);
            (out.positions[v], out.normals[v], out.tangents[v]) =
                (fresh.positions[v], fresh.normals[v], fresh.tangents[v]);
            continue;
        }
        prop_assert_eq!(out.bits(v), fresh.bits(v), "vertex {}", v);
        let bounds = out.tracker.changed_bounds().unwrap();
        for p in [before.positions[v], out.positions[v]].map(Vec3::from).into_iter().filter(|p| p.x != POISON) {
            prop_assert!(p.cmpge(bounds.min).all() && p.cmple(bounds.max).all(), "vertex {} at {}, {:?}", v, p, bounds);
        }
    }
    let triangles = instance.example_set().lod_mesh(out.lod).unwrap().triangles();
    let changed = out.tracker.changed_triangles(triangles);
    prop_assert!(changed.windows(2).all(|w| w[0].end < w[1].start) && changed.iter().all(|r| r.start < r.end));
    for (t, corners) in triangles.iter().enumerate() {
        let written = corners.iter().any(|v| is_in(&ranges, *v as usize));
        prop_assert_eq!(is_in(&changed, t), written, "triangle {}", t);
    }
    let again = out.update(instance);
    prop_assert_eq!((again.vertices_written, again.blocks_written), (0, 0));
    prop_assert!(out.tracker.changed().is_empty() && out.tracker.changed_bounds().is_none());
    Ok(())
}

fn check_bounds(out: &Output) -> Result<(), TestCaseError> {
    let found = out.tracker.bounds().expect("bounds after a deform");
    for k in 0..3 {
        let low = out.positions.iter().map(|p| p[k]).fold(f32::INFINITY, f32::min);
        let high = out.positions.iter().map(|p| p[k]).fold(f32::NEG_INFINITY, f32::max);
        prop_assert_eq!((found.min[k], found.max[k]), (low, high));
    }
    Ok(())
}

/// Does one random thing to an instance.
fn act(instance: &mut Instance, saves: &mut Vec<Vec<u8>>, dice: &mut Dice) {
    let set = instance.example_set().clone();
    let classic = instance.options().rule != Rule::Marks;
    match dice.index(14) {
        0 => instance.repair(dice.unit()).unwrap(),
        1 => instance.reset(),
        2 => saves.push(instance.save()),
        3 if !saves.is_empty() => instance.load(&saves[dice.index(saves.len())]).unwrap(),
        4 => instance.fold(),
        5 => {}
        6 if !classic => instance.set_depth_limit([None, Some(0.02), Some(0.3)][dice.index(3)]).unwrap(),
        7 if !classic => instance.repair_around(base(&set, dice.index(set.vertex_count())), 0.4, dice.unit()).unwrap(),
        8 => {
            let mut other = dented(&set, *instance.options(), &[random_hit(&set, dice)]);
            instance.copy_damage_from(&mut other).unwrap();
        }
        9 if !classic => {
            let mut marks = instance.marks().unwrap().to_vec();
            marks.truncate(dice.index(marks.len() + 1));
            marks.extend((0..dice.index(3)).map(|_| any_mark(&set, dice)));
            instance.set_marks(&marks).unwrap();
        }
        _ => {
            for _ in 0..=dice.index(3) {
                instance.submit(&random_hit(&set, dice)).unwrap();
            }
        }
    }
}

proptest! {
    #![proptest_config(scenes::cases(16))]

    #[test]
    fn nothing_is_written_outside_the_attributes(body in any_body(), seed in any::<u64>()) {
        check_guards(&body.1, seed)?;
    }

    /// Dents that grow leave the marks of those that do not. Once the time has passed, all is as in `plain`, whose dents never grew.
    #[test]
    fn any_sequence_leaves_what_a_fresh_evaluation_gives(
        body in any_body(), seed in any::<u64>(), steps in 1usize..30, capacity in prop_oneof![1u32..9, Just(40)], classic in any_rule(),
    ) {
        let (_, set) = body;
        let mut dice = Dice::new(seed);
        let options = InstanceOptions { capacity, ..either_rule(classic) };
        let grow_time = if classic.is_none() { 0.05 * dice.index(2) as f32 } else { 0.0 };
        let (mut instance, mut plain) = (with(set, InstanceOptions { grow_time, ..options }), with(set, options));
        // Levels of detail take no classic rules.
        let lod = if classic.is_none() { dice.index(set.lod_count()) } else { 0 };
        let (mut often, mut seldom, mut saves) = (Output::level(set, lod), Output::level(set, lod), [Vec::new(), Vec::new()]);
        let mut time = f64::from(dice.between(-1e3, 1e3));
        for step in 0..steps {
            instance.set_time(time).unwrap();
            let mut same_dice = dice.clone();
            act(&mut instance, &mut saves[0], &mut dice);
            act(&mut plain, &mut saves[1], &mut same_dice);
            // It is neither read nor shown in between.
            plain.fold();
            instance.preview(&random_hit(set, &mut same_dice)).unwrap();
            prop_assert!(classic.is_some() || instance.marks().unwrap().len() <= capacity as usize);
            check_changes(&mut instance, &mut often)?;
            check_bounds(&often)?;
            if step % 5 == 4 {
                seldom.update(&mut instance);
                prop_assert!(seldom.all_bits() == often.all_bits());
                check_bounds(&seldom)?;
                let alone = scenes::positions(&mut instance).0;
                prop_assert!(lod > 0 || alone == often.positions, "positions without normals");
            }
            time += f64::from(dice.between(0.0, 0.06));
        }
        for _ in (0..20).filter(|_| lod == 0) {
            let v = dice.index(set.vertex_count());
            prop_assert_eq!(bits(instance.displaced(v as u32).unwrap().to_array()), bits(often.positions[v]));
        }
        instance.set_time(time + 0.1).unwrap();
        check_changes(&mut instance, &mut often)?;
        prop_assert!(instance.save() == plain.save(), "a replay gives the same bytes");
        prop_assert!(instance.memory_bytes() == plain.memory_bytes(), "nothing is kept of what grew");
        // Damage survives saving, giving and copying. Nodes keep sums from hit to hit, which must not show.
        let alike = InstanceOptions { depth_limit: Some(plain.depth_limit()), ..options };
        let [mut loaded, mut copy, mut given] = [(); 3].map(|()| with(set, alike));
        let bytes = plain.save();
        loaded.load(&bytes).unwrap();
        copy.copy_damage_from(&mut plain).unwrap();
        let mut others = vec![loaded, copy];
        if classic.is_none() {
            let marks = plain.marks().unwrap();
            given.set_marks(marks).unwrap();
            others.push(given);
            // a mark has 32 bytes
            prop_assert!(bytes.len() <= 64 + 32 * marks.len());
        }
        check_sound(&mut others[0])?;
        for other in others.iter_mut().chain([&mut plain]) {
            prop_assert!(other.save() == bytes && other.revision() == instance.revision());
            prop_assert!(often.all_bits() == Output::fresh_level(other, lod).all_bits());
        }
        // A reset forgets all, hits that wait too.
        plain.submit(&random_hit(set, &mut dice)).unwrap();
        plain.reset();
        let (mut untouched, out) = (with(set, alike), Output::fresh(&mut plain));
        prop_assert!(plain.save() == untouched.save() && out.all_bits() == Output::fresh(&mut untouched).all_bits());
        prop_assert!((0..set.vertex_count()).all(|v| bits(out.positions[v]) == bits(base(set, v))));
        instance.set_time(time + 0.2).unwrap();
        prop_assert_eq!(often.update(&mut instance).blocks_written, 0);
    }
}

#[test]
fn quick_guards_and_changes() {
    for (_, set) in scenes::small_bodies() {
        check_guards(&set, 3).unwrap();
        let mut dice = Dice::new(8);
        let mut instance = with(&set, InstanceOptions { capacity: 3, ..InstanceOptions::default() });
        let (mut out, mut saves) = (Output::new(&set), Vec::new());
        for _ in 0..12 {
            act(&mut instance, &mut saves, &mut dice);
            check_changes(&mut instance, &mut out).unwrap();
            check_bounds(&out).unwrap();
        }
    }
}

#[test]
fn quick_an_output_may_change_hands() {
    let set = scenes::cube_set();
    let (mut a, mut b) = (new(&set), new(&set));
    a.submit(&random_hit(&set, &mut Dice::new(1))).unwrap();
    b.submit(&random_hit(&set, &mut Dice::new(2))).unwrap();
    let mut out = Output::new(&set);
    for turn in 0..3 {
        let instance = if turn == 1 { &mut b } else { &mut a };
        out.update(instance);
        assert!(out.all_bits() == Output::fresh(instance).all_bits());
        check_bounds(&out).unwrap();
    }
    // Other code has overwritten the memory.
    out.poison();
    out.tracker.invalidate();
    assert_eq!(out.update(&mut a).vertices_written, set.vertex_count() as u64);
    assert!(out.all_bits() == Output::fresh(&mut a).all_bits());
    // Between levels of detail too.
    let mut body = new(&bodies()[4].1);
    for lod in [2, 0, 3] {
        let tracker = out.tracker;
        out = Output::level(body.example_set(), lod);
        out.tracker = tracker;
        out.update(&mut body);
        assert!(out.all_bits() == Output::fresh_level(&mut body, lod).all_bits());
    }
}

// ------------------------------------------------------------------------------------------------- damage comes and goes

proptest! {
    #![proptest_config(scenes::cases(24))]

    #[test]
    fn repairs_scale_depth(body in (0..4usize).prop_map(|i| &bodies()[i]), seed in any::<u64>(), keep in 0.05f32..1.0) {
        let (_, set) = body;
        let mut instance = with(set, InstanceOptions { depth_limit: Some(1e3), ..InstanceOptions::default() });
        // Several hits upon each other also get narrower.
        instance.submit(&random_hits(set, 1, seed)[0]).unwrap();
        let (before, mark) = (Output::fresh(&mut instance), instance.marks().unwrap()[0]);
        instance.repair(1.0).unwrap();
        prop_assert!(instance.marks().unwrap() == [mark] && Output::fresh(&mut instance).all_bits() == before.all_bits());
        instance.repair(keep).unwrap();
        let after = Output::fresh(&mut instance);
        let ought = mark.energy as f64 * f64::from(keep).powf(2.4);
        prop_assert!((instance.marks().unwrap()[0].energy as f64 - ought).abs() <= 1.0 + 1e-9 * ought);
        let limit = f64::from(set.depth_limit());
        for v in 0..set.vertex_count() {
            let b = base(set, v);
            let ought = [0, 1, 2].map(|k| b[k] + keep * (before.positions[v][k] - b[k]));
            // Nodes move in steps of up to a 16 000th of 16 times the set's limit.
            // Where the soft limit, at 16 times the set's, is far.
            let is_free = distance(before.positions[v], b) < 11.0 * limit;
            prop_assert!(!is_free || distance(after.positions[v], ought) <= 4e-3 * limit + 3.0 * rounding(b));
        }
        instance.repair(0.0).unwrap();
        prop_assert!(instance.marks().unwrap().is_empty());
        prop_assert!(Output::fresh(&mut instance).all_bits() == Output::fresh(&mut new(set)).all_bits());
    }
}

// ------------------------------------------------------------------------------------------------------ energies, examples

#[test]
fn quick_energy_stops_at_its_greatest_value() {
    let set = scenes::ball_set();
    let hit = random_hit(&set, &mut Dice::new(4));
    let mut instance = dented(&set, InstanceOptions::default(), &[hit]);
    let mark = instance.marks().unwrap()[0];
    let brimful = Mark { energy: u64::MAX - 1, ..mark };
    instance.set_marks(&[brimful, mark]).unwrap();
    assert_eq!(instance.marks().unwrap(), [Mark { energy: u64::MAX, ..mark }]);
    instance.submit(&hit).unwrap();
    assert_eq!(instance.marks().unwrap(), [Mark { energy: u64::MAX, ..mark }]);
    check_sound(&mut instance).unwrap();
}

/// A body made in other units dents in the same way: no constant of the model is a length.
#[test]
fn a_body_dents_alike_in_any_unit() {
    let scaled = |factor: f32| {
        let mut mesh = scenes::cube(8);
        let mut examples = scenes::bowls(&mesh, 5, 0.45, 3);
        mesh.positions.iter_mut().flatten().for_each(|x| *x *= factor);
        for e in &mut examples {
            let Deltas::Sparse { values, .. } = &mut e.positions else { unreachable!() };
            values.iter_mut().flatten().for_each(|x| *x *= factor);
        }
        scenes::build(mesh, examples, SetOptions::default())
    };
    let one = scaled(1.0);
    // powers of two cause no rounding
    for factor in [2f32.powi(-20), 2f32.powi(-10), 2f32.powi(10), 2f32.powi(20)] {
        let set = scaled(factor);
        let (mut here, mut there) = (new(&one), new(&set));
        for hit in random_hits(&one, 12, 8) {
            let Cause::Displacement(d) = hit.cause else { unreachable!() };
            let big = push(hit.point.map(|x| x * factor), d.map(|x| x * factor));
            let (a, b) = (here.submit(&hit).unwrap(), there.submit(&big).unwrap());
            assert_eq!((a.status, a.contact_vertex), (b.status, b.contact_vertex));
        }
        let (a, b) = (Output::fresh(&mut here), Output::fresh(&mut there));
        for v in 0..one.vertex_count() {
            let ought = a.positions[v].map(|x| x * factor);
            let off = distance(b.positions[v], ought) / f64::from(factor);
            assert!(off < 2e-5, "factor {factor}, vertex {v}: off by {off}");
            assert!(distance(b.normals[v], a.normals[v]) < 1e-3, "factor {factor}, normal of vertex {v}");
        }
    }
}

fn check_own_contacts(set: &Arc<ExampleSet>) {
    for (i, e) in set.examples().iter().enumerate() {
        let mut instance = new(set);
        let outcome = instance.submit(&scenes::own_hit(e)).unwrap();
        let worst = set.basis_report().unwrap().worst;
        assert!(scenes::length(outcome.shortfall()) <= 1e-3 * e.depth() + 2.0 * worst, "{outcome:?}");
        let out = Output::fresh(&mut instance);
        for v in 0..set.vertex_count() {
            let ought = (set.mesh().positions()[v] + e.delta(v as u32)).to_array();
            // Half a step of a node. Between nodes the dent is scaled so that its contact, which is off as others are, moves as told.
            let off = distance(out.positions[v], ought);
            let most = 1e-4 * set.depth_limit() + 2.0 * worst;
            assert!(off <= f64::from(most), "example {i}, vertex {v}: {off}, at most {most}");
        }
    }
}

#[test]
fn quick_a_hit_at_an_examples_own_contact_is_the_example() {
    for (_, set) in scenes::small_bodies() {
        check_own_contacts(&set);
    }
}

#[test]
fn a_hit_at_an_examples_own_contact_is_the_example_on_solver_bodies() {
    for body in ["panel", "tube"] {
        check_own_contacts(&scenes::solver_with(body, 32, scenes::every_node(SetOptions::default())));
        let basis =
            Some(BasisOptions { tolerance: 0.02 * scenes::solver_set(body, 8).depth_limit(), rounds: 4, nodes: 512 });
        check_own_contacts(&scenes::solver_with(body, 8, SetOptions { basis, ..SetOptions::default() }));
    }
}

// --------------------------------------------------------------------------------------------------------- attached points

#[test]
fn quick_attached_points_keep_their_places_on_the_surface() {
    for (name, set) in scenes::small_bodies() {
        let mut dice = Dice::new(12);
        let vertices = (0..set.vertex_count()).map(|v| base(&set, v));
        let beside = vertices.clone().take(50).map(|p| [0, 1, 2].map(|k| p[k] + dice.vector(0.05)[k]));
        let points: Vec<[f32; 3]> = vertices.clone().chain(beside).collect();
        let attachments: Vec<_> = points.iter().map(|p| set.attach(*p).unwrap()).collect();
        let mut instance = new(&set);
        for (p, a) in points.iter().zip(&attachments) {
            let frame = instance.attached_pose(a).unwrap();
            assert!(distance(frame.position, *p) <= 1e-7, "{name}: {frame:?}, not {p:?}");
            assert_eq!(frame.rotation, [0.0, 0.0, 0.0, 1.0]);
        }
        for hit in random_hits(&set, 6, 5) {
            instance.submit(&hit).unwrap();
        }
        let out = Output::fresh(&mut instance);
        for (i, (p, a)) in points.iter().zip(&attachments).enumerate() {
            let frame = instance.attached_pose(a).unwrap();
            if i < set.vertex_count() {
                assert!(distance(frame.position, out.positions[i]) <= 2e-7, "{name}, vertex {i}: {frame:?}");
            }
            // The place on its triangle, and the way from there, before and after.
            let weights = Vec3::from_array(a.weights);
            assert!((weights.element_sum() - 1.0).abs() < 1e-5);
            let place = |at: &dyn Fn(usize) -> [f32; 3]| -> Vec3 {
                (0..3).map(|k| Vec3::from(at(a.vertices[k] as usize)) * weights[k]).sum()
            };
            let before = Vec3::from(*p) - place(&|v| base(&set, v));
            let after = Vec3::from(frame.position) - place(&|v| out.positions[v]);
            let turn = Quat::from_array(frame.rotation);
            assert!((turn.length() - 1.0).abs() < 1e-5);
            assert!((turn * before - after).length() < 1e-5, "{name}, point {i}: {before} became {after}");
        }
    }
}

// ------------------------------------------------------------------------------------------------------------------ spaces

#[test]
fn quick_world_space_hits_arrive_in_the_bodys_own_space() {
    let set = scenes::cube_set();
    let turn = Quat::from_rotation_y(0.7) * Quat::from_rotation_x(-1.1);
    for scale in [Vec3::ONE, Vec3::splat(2.5), Vec3::new(1.0, 2.0, 0.5)] {
        let to_world = Mat4::from_scale_rotation_translation(scale, turn, Vec3::new(100.0, -20.0, 3.0));
        let mut moved = new(&set);
        moved.inbox().set_transform(to_world).unwrap();
        moved.fold();
        let mut dice = Dice::new(6);
        for _ in 0..20 {
            let local = random_hit(&set, &mut dice);
            let Cause::Displacement(d) = local.cause else { unreachable!() };
            let world = Hit {
                point: to_world.transform_point3(Vec3::from_array(local.point)).to_array(),
                cause: Cause::Displacement(to_world.transform_vector3(Vec3::from_array(d)).to_array()),
                space: Space::World,
                contact: None,
            };
            let (a, b) = (moved.preview(&local).unwrap(), moved.preview(&world).unwrap());
            assert_eq!(a.contact_vertex, b.contact_vertex);
            assert!(distance(a.target, b.target) < 1e-4, "{:?} {:?}", a.target, b.target);
            assert!(distance(a.achieved, b.achieved) < 1e-3 * f64::from(set.depth_limit()));
        }
    }
}
