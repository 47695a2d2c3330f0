//! Hits on a skinned mesh in its pose, against a reference that skins every vertex in double precision.

mod scenes;

use crumple::glam::{DMat4, DVec3, Mat4, Quat, Vec3};
use crumple::{Blow, Cause, Error, Hit, Instance, Skin, Space, Striker};
use proptest::prelude::*;
use scenes::{Dice, displacements, new, push};

/// Two joints that share the ball's vertices along x, and a third that nobody uses.
struct Bones {
    joints: Vec<[u16; 4]>,
    weights: Vec<[f32; 4]>,
    matrices: Vec<Mat4>,
}

impl Bones {
    fn new(positions: &[Vec3], dice: &mut Dice) -> Self {
        let share = |p: &Vec3| (p.x * 1.5 + 0.5).clamp(0.0, 1.0);
        let turn = |dice: &mut Dice| {
            let [x, y, z] = dice.vector(0.6);
            let moved = Vec3::from_array(dice.vector(1.0));
            Mat4::from_rotation_translation(Quat::from_euler(crumple::glam::EulerRot::XYZ, x, y, z), moved)
        };
        let (first, second) = (turn(dice), turn(dice));
        Bones {
            joints: positions.iter().map(|_| [2, 0, 0, 0]).collect(),
            weights: positions.iter().map(|p| [share(p), 1.0 - share(p), 0.0, 0.0]).collect(),
            matrices: vec![second, Mat4::ZERO, first],
        }
    }

    fn skin(&self) -> Skin<'_> {
        Skin { joints: &self.joints, weights: &self.weights, matrices: &self.matrices }
    }

    /// The naive skin matrix of a vertex.
    fn matrix(&self, v: usize) -> DMat4 {
        (0..4).fold(DMat4::ZERO, |sum, i| {
            sum + self.matrices[usize::from(self.joints[v][i])].as_dmat4() * f64::from(self.weights[v][i])
        })
    }
}

fn close(a: DVec3, b: DVec3) -> bool {
    (a - b).length() < 2e-5 * (1.0 + b.length())
}

proptest! {
    #![proptest_config(scenes::cases(64))]

    /// The vertex that the reference finds is the contact; hits lie where the reference's inverse puts them; a dent that is
    /// then skinned moves the posed contact as far as the hit asked in the pose, up to what examples can answer.
    #[test]
    fn hits_on_the_pose_are_those_of_the_reference(seed: u64, world: bool) {
        let set = scenes::ball_set();
        let positions = set.mesh().positions();
        let mut dice = Dice::new(seed);
        let bones = Bones::new(positions, &mut dice);
        let mut body = new(&set);
        let place = if world { Mat4::from_translation(Vec3::from_array(dice.vector(9.0))) } else { Mat4::IDENTITY };
        body.set_transform(place).unwrap();
        let posed: Vec<DVec3> = positions.iter().enumerate().map(|(v, p)| bones.matrix(v).transform_point3(p.as_dvec3())).collect();
        let vertex = dice.index(positions.len());
        let skin = bones.matrix(vertex);
        // A skin matrix between two turned joints may be nearly singular; no hit can be taken through it.
        prop_assume!(skin.determinant().abs() > 0.2);
        let inward = (skin.inverse().transpose().transform_vector3(-positions[vertex].as_dvec3())).normalize() * 0.05;
        let at = place.as_dmat4().transform_point3(posed[vertex]);
        let space = if world { Space::World } else { Space::Local };
        let hit = Hit { space, ..push(at.as_vec3().to_array(), inward.as_vec3().to_array()) };

        let bound = body.inbox().to_bind_pose(&bones.skin(), &hit).unwrap();
        let near = |v: usize| (posed[v] - (at - place.w_axis.truncate().as_dvec3())).length();
        let naive = (0..posed.len()).min_by(|a, b| near(*a).total_cmp(&near(*b))).unwrap();
        let contact = set.nearest_vertex(bound.point).unwrap().vertex as usize;
        prop_assert!((near(naive) - near(contact)).abs() < 1e-5, "vertices {naive} and {contact}");
        let inverse = bones.matrix(contact).inverse();
        prop_assert!(close(Vec3::from_array(bound.point).as_dvec3(), inverse.transform_point3(posed[vertex])));
        let Cause::Displacement(told) = bound.cause else { panic!("still a displacement") };
        prop_assert!(close(Vec3::from_array(told).as_dvec3(), inverse.transform_vector3(inward)));
        prop_assert_eq!(bound.space, Space::Local);

        // Dent, then skin: the posed contact moves by the skin matrix of what the hit left.
        let outcome = body.submit(&bound).unwrap();
        let moved = displacements(&mut body)[contact].as_dvec3();
        let achieved = Vec3::from_array(outcome.achieved).as_dvec3();
        prop_assert!(close(bones.matrix(contact).transform_vector3(moved), bones.matrix(contact).transform_vector3(achieved)));
        if outcome.mark.is_some() {
            prop_assert!(bones.matrix(contact).transform_vector3(moved).dot(inward) > 0.0, "it is dented inwards in the pose");
        }
    }
}

#[test]
fn quick_a_blow_keeps_what_it_knows() {
    let set = scenes::ball_set();
    let body = new(&set);
    let count = set.vertex_count();
    let turn = Mat4::from_rotation_z(std::f32::consts::FRAC_PI_2);
    let (joints, weights, matrices) = (vec![[0; 4]; count], vec![[1.0, 0.0, 0.0, 0.0]; count], [turn]);
    let skin = Skin { joints: &joints, weights: &weights, matrices: &matrices };
    let striker = Striker { mass: Some(2.0), velocity: Some([0.0, -3.0, 0.0]), radius: Some(0.1) };
    let blow = Blow { impulse: None, duration: Some(0.01), normal: Some([0.0, 1.0, 0.0]), striker };
    let bound = body.inbox().to_bind_pose(&skin, &Hit::blow([0.0, 0.5, 0.0], blow)).unwrap();
    let Cause::Impulse { blow, .. } = bound.cause else { panic!("still an impulse") };
    let near = |a: [f32; 3], b: [f32; 3]| (Vec3::from_array(a) - Vec3::from_array(b)).length() < 1e-6;
    assert!(near(bound.point, [0.5, 0.0, 0.0]) && near(blow.normal.unwrap(), [1.0, 0.0, 0.0]));
    assert!(near(blow.striker.velocity.unwrap(), [-3.0, 0.0, 0.0]));
    assert_eq!((blow.duration, blow.striker.radius, blow.impulse), (Some(0.01), Some(0.1), None));
}

#[test]
fn quick_bad_skins_are_refused_by_name() {
    let set = scenes::ball_set();
    let body: Instance = new(&set);
    let count = set.vertex_count();
    let (joints, weights) = (vec![[0u16; 4]; count], vec![[1.0f32, 0.0, 0.0, 0.0]; count]);
    let one = [Mat4::IDENTITY];
    let good = Skin { joints: &joints, weights: &weights, matrices: &one };
    let hit = push([0.5, 0.0, 0.0], [-0.01, 0.0, 0.0]);
    assert!(body.inbox().to_bind_pose(&good, &hit).is_ok());
    let message = |skin: Skin<'_>| body.inbox().to_bind_pose(&skin, &hit).unwrap_err().to_string();
    let says = |skin: Skin<'_>, text: &str| assert!(message(skin).contains(text), "{} is not {text}", message(skin));
    says(Skin { joints: &joints[1..], ..good }, "the length of skin.joints is 641; it must be 642");
    says(Skin { weights: &[], ..good }, "the length of skin.weights is 0");
    says(Skin { matrices: &[], ..good }, "a joint of vertex 0 is 0; it must be below 0");
    says(Skin { matrices: &[Mat4::ZERO], ..good }, "the skin matrix of vertex 0 is");
    says(Skin { matrices: &[Mat4::NAN], ..good }, "skin.matrices[0] is");
    let half = vec![[0.5f32, 0.0, 0.0, 0.0]; count];
    says(Skin { weights: &half, ..good }, "the sum of the weights of vertex");
    let bad = Hit { point: [f32::NAN, 0.0, 0.0], ..hit };
    assert!(matches!(body.inbox().to_bind_pose(&good, &bad), Err(Error::NotFinite { .. })));
}
