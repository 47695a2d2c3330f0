//! Any bytes as saved damage: of one instance, of many instances, and with a classic rule. Version, fingerprint of the set and
//! checksum are made right.
#![no_main]

use crumple::glam::Vec3;
use crumple::{Instance, Rule, Serial, Tracker, VertexMemory, load_all, save_all};
use crumple_fuzz::{seeds, target};
use twox_hash::XxHash3_64;

target!(run, seeds: seeds::damage);

fn run(data: &[u8]) {
    let Some((kind, bytes)) = data.split_first() else { return };
    let (mut bytes, mut bodies) = (bytes.to_vec(), seeds::dented());
    match bodies.get_mut(usize::from(*kind)) {
        Some(body) => {
            repair(&mut bytes, body.example_set().fingerprint());
            let _ = body.load(&bytes);
        }
        None => {
            repair_all(&mut bytes, bodies[0].example_set().fingerprint());
            let mut all: Vec<&mut Instance> = bodies.iter_mut().collect();
            let _ = load_all(&mut all, &bytes, &Serial);
        }
    }
    bodies.iter_mut().for_each(check);
    let saved = save_all(&mut bodies);
    let mut fresh = seeds::dented();
    load_all(&mut fresh.iter_mut().collect::<Vec<_>>(), &saved, &Serial).expect("what was saved");
    assert_eq!(save_all(&mut fresh), saved);
}

/// Makes version, fingerprint and checksum of one instance's damage right.
fn repair(bytes: &mut [u8], fingerprint: u64) {
    if let Some(header) = bytes.first_chunk_mut::<24>() {
        header[8..16].copy_from_slice(&fingerprint.to_le_bytes());
    }
    seal(bytes);
}

/// The same for the damage of many instances, each with its size before it.
fn repair_all(bytes: &mut [u8], fingerprint: u64) {
    let mut rest = bytes.get_mut(16..).unwrap_or_default();
    while let Some((size, after)) = rest.split_first_chunk_mut() {
        let size = usize::try_from(u64::from_le_bytes(*size)).unwrap_or(usize::MAX);
        let Some((one, after)) = after.split_at_mut_checked(size) else { break };
        repair(one, fingerprint);
        rest = after;
    }
    seal(bytes);
}

/// Writes the version, and the checksum at the end.
fn seal(bytes: &mut [u8]) {
    if let Some(version) = bytes.get_mut(4..6) {
        version.copy_from_slice(&3u16.to_le_bytes());
    }
    if let Some((sealed, checksum)) = bytes.split_last_chunk_mut() {
        *checksum = XxHash3_64::oneshot(sealed).to_le_bytes();
    }
}

fn check(body: &mut Instance) {
    let (set, rule) = (body.example_set().clone(), body.options().rule);
    let (mut positions, mut normals) = (vec![[0.0f32; 3]; set.vertex_count()], vec![[0.0f32; 3]; set.vertex_count()]);
    let memory = VertexMemory::separate(&mut positions, Some(&mut normals), None).expect("two arrays");
    body.deform(&mut Tracker::new(), memory, &Serial).expect("arrays of the set's length");
    for ((p, n), base) in positions.iter().zip(&normals).zip(set.mesh().positions()) {
        let (p, length) = (Vec3::from(*p), Vec3::from(*n).length());
        assert!((length - 1.0).abs() < 1e-4, "a normal is {n:?}");
        // A classic rule's vertices may be anywhere.
        let allowed = if rule == Rule::Marks { set.depth_limit() * 1.00001 } else { f32::INFINITY };
        assert!(p.is_finite() && (p - *base).length() <= allowed, "a vertex moved from {base} to {p}");
    }
}
