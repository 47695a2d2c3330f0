// What the fuzzer does with bytes, and tests/format.rs with bytes that it damages itself: they become a set or an error, and a
// set can be hit, deformed, asked and saved. Included by both.

/// Makes length and checksum right, so that damage gets past them.
pub fn repair(file: &mut [u8]) {
    if file.len() >= 64 {
        let length = file.len() as u64;
        file[16..24].copy_from_slice(&length.to_le_bytes());
        let checksum = crumple::file_checksum(file, &crumple::Serial);
        file[8..16].copy_from_slice(&checksum.to_le_bytes());
    }
}

/// Loads bytes and uses the set, if it is one; whether it is.
pub fn load_and_use(file: Vec<u8>) -> bool {
    use crumple::{Blow, ExampleSet, Hit, Instance, InstanceOptions, Rule, Serial, Tracker, VertexMemory};
    let Ok(set) = ExampleSet::load(file, &Serial) else { return false };
    let set = std::sync::Arc::new(set);
    let n = set.vertex_count();
    let finite = |what: &str, all: &[f32]| {
        assert!(all.iter().all(|x| x.is_finite()), "{what} of a loaded set are not finite: {all:?}");
    };
    let rules = [Rule::Marks, Rule::MostDisplaced];
    for rule in rules.into_iter().filter(|rule| *rule == Rule::Marks || set.has_whole_examples()) {
        let options = if rule == Rule::Marks { InstanceOptions::default() } else { InstanceOptions::classic(rule) };
        let mut body = Instance::new(set.clone(), options).expect("default options");
        let contacts = set.examples().iter().map(|e| e.contact_vertex() as usize);
        for (i, v) in contacts.chain([0, n / 3, n / 2, n - 1]).take(12).enumerate() {
            let normal = set.mesh().contact_normal(v as u32).unwrap_or_default();
            let size = set.depth_limit() * [0.1, 1.0, 3.0][i % 3];
            let lean = [0.0, 0.1, -0.3][i / 3 % 3];
            let push = [lean - normal.x, -normal.y, lean * 0.5 - normal.z].map(|x| x * size);
            let point = set.mesh().positions()[v].to_array();
            let _ = body.submit(&Hit::displacement(point, push));
            let _ = body.submit(&Hit::displacement(point.map(|x| x + size * 0.1), push));
            let _ = body.submit(&Hit::blow(point, Blow::of_impulse(push, 0.01)));
        }
        let (mut positions, mut normals, mut tangents) =
            (vec![[0.0f32; 3]; n], vec![[0.0f32; 3]; n], vec![[0.0f32; 4]; n]);
        let memory = VertexMemory::separate(
            &mut positions,
            set.mesh().normals().is_some().then_some(&mut normals),
            (set.mesh().tangents().is_some() && set.mesh().normals().is_some()).then_some(&mut tangents),
        );
        let mut tracker = Tracker::new();
        body.deform(&mut tracker, memory.expect("separate arrays"), &Serial).expect("arrays of the set's length");
        finite("positions", positions.as_flattened());
        finite("normals", normals.as_flattened());
        // Without normals and tangents another path is taken.
        let mut tracker = Tracker::new();
        let memory = VertexMemory::separate(&mut positions, None, None).expect("one array");
        body.deform(&mut tracker, memory, &Serial).expect("an array of the set's length");
        finite("positions", positions.as_flattened());
        if let Ok(at) = set.attach(set.mesh().positions()[n / 2].to_array()) {
            let _ = body.attached_pose(&at);
        }
    }
    for e in set.examples() {
        let _ = (e.delta(n as u32 - 1), e.normal_delta(0));
    }
    let again = set.save().expect("a small set");
    let twice = ExampleSet::load(again.clone(), &Serial).expect("what was saved").save().expect("a small set");
    assert!(again == twice, "a loaded set does not give its own bytes");
    true
}
