//! A thin sheet of rapier's soft bodies (particles, edges, bending across edges; plastic edges and folds) that a ball
//! hits, as the truths' solvers did.

use cpu_time::ThreadTime;
use rapier3d::prelude::*;

use super::sheet::Sheet;
use crate::truth::{Impact, Striker};

/// What rapier's model asks for and the truth's material does not tell: chosen on training impacts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Natural frequency of the edges and of the folds, Hz; the first is how stiff the sheet is.
    pub edge_hz: f32,
    pub bend_hz: f32,
    /// Strain (edges) and angle in radians (folds) above which the rest shape follows; 0 is elastic.
    pub plastic_yield: f32,
    /// Natural frequency of the pull toward the body's rest shape, Hz; 0 leaves it out.
    pub shape_hz: f32,
}

impl Material {
    /// `factor` times as stiff (a spring's frequency grows with the root of its stiffness), the yield stress kept.
    pub fn stiffened(self, factor: f32) -> Self {
        let root = factor.sqrt();
        Self {
            edge_hz: self.edge_hz * root,
            bend_hz: self.bend_hz * root,
            plastic_yield: self.plastic_yield / factor,
            shape_hz: self.shape_hz * root,
        }
    }

    fn rapier(self) -> SoftBodyMaterial {
        SoftBodyMaterial {
            edge_softness: SpringCoefficients::new(self.edge_hz, 1.0),
            bend_softness: SpringCoefficients::new(self.bend_hz, 1.0),
            shape_matching_softness: SpringCoefficients::new(self.shape_hz, 1.0),
            edge_plastic_yield: self.plastic_yield,
            // At once, as the truths' rate-free plasticity.
            edge_plastic_creep: f32::INFINITY,
            edge_plastic_max: 1.0,
            ..SoftBodyMaterial::default()
        }
    }
}

/// How finely time and constraints are solved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// Every how many-th vertex of the truth's grid is a particle.
    pub stride: usize,
    /// Steps a second.
    pub hz: f32,
    /// Solver iterations (substeps) a step; rapier's default is 4.
    pub substeps: usize,
    /// Extra sweeps over the constraints a substep; the default for soft bodies is 3.
    pub sweeps: usize,
}

/// What a hit left.
pub struct Outcome {
    /// Displacement of each particle, m.
    pub field: Vec<[f32; 3]>,
    /// CPU time of the one thread, s.
    pub seconds: f64,
    pub simulated_s: f64,
    /// Of the soft body: particles, edges, folds and surface.
    pub bytes: usize,
    /// rapier met a NaN and took the body out of the simulation.
    pub quarantined: bool,
}

impl Outcome {
    pub fn is_nan(&self) -> bool {
        self.quarantined || self.field.iter().flatten().any(|x| !x.is_finite())
    }
}

/// Mass of the shots' ball, kg.
const BALL_KG: f32 = 2.5;
/// Mass damping of the sheet while it is hit and after, 1/s; the sheet rests below this speed, m/s; times in s. All as in
/// the truth of the shots.
const DAMPING_IN_CONTACT: f32 = 5.0;
const DAMPING_AFTER: f32 = 60.0;
const REST_SPEED: f32 = 2e-3;
const SETTLE_AT_LEAST: f32 = 0.06;
const SETTLE_AT_MOST: f32 = 0.20;
const CONTACT_AT_MOST: f32 = 0.30;
/// Travel time of a press each way, s; never under twelve steps.
const PRESS_S: f32 = 0.012;

struct Scene {
    world: PhysicsWorld,
    sheet: SoftBodyHandle,
    ball: RigidBodyHandle,
    radius: f32,
    simulated: f32,
}

/// Hits a fresh sheet and lets it settle. Only the simulation is timed, not how the scene is built.
pub fn hit(sheet: &Sheet, impact: &Impact, material: Material, quality: Quality) -> Outcome {
    let mut scene = Scene::new(sheet, impact, material, quality);
    let started = ThreadTime::now();
    match impact.striker {
        Striker::Ball { .. } => scene.shoot(impact),
        Striker::Punch { depth, .. } => scene.press(vector(impact.direction) * depth as f32),
    }
    scene.settle();
    let seconds = started.elapsed().as_secs_f64();
    let body = &scene.world.soft_bodies[scene.sheet];
    let field =
        body.particle_positions().zip(&sheet.vertices).map(|(p, b)| [p.x - b[0], p.y - b[1], p.z - b[2]]).collect();
    let quarantined = !body.is_enabled();
    Outcome { field, seconds, simulated_s: f64::from(scene.simulated), bytes: bytes(body), quarantined }
}

impl Scene {
    fn new(sheet: &Sheet, impact: &Impact, material: Material, quality: Quality) -> Self {
        let mut world = PhysicsWorld::new();
        world.gravity = Vector::ZERO;
        world.integration_parameters.dt = 1.0 / quality.hz;
        world.integration_parameters.num_solver_iterations = quality.substeps;
        let friction = if matches!(impact.striker, Striker::Ball { .. }) { 0.4 } else { 0.0 };
        let positions: Vec<Vector> = sheet.vertices.iter().map(|p| vector(*p)).collect();
        let body = SoftBodyBuilder::trimesh(positions, sheet.triangles.clone())
            .expect("a sheet has triangles")
            .masses(sheet.masses.clone())
            .pinned_particles(sheet.rim.iter().copied())
            .material(material.rapier())
            .shape_matching(material.shape_hz > 0.0)
            .particle_radius(0.002)
            .surface_collider(ColliderBuilder::ball(0.002).density(0.0).friction(friction))
            .additional_pgs_iterations(quality.sweeps)
            .can_sleep(false);
        let sheet_handle = world.insert_soft_body(body);
        let (radius, rigid) = match impact.striker {
            Striker::Ball { radius, speed, .. } => {
                let flight = vector(impact.direction) * speed as f32;
                (radius as f32, RigidBodyBuilder::dynamic().linvel(flight).can_sleep(false))
            }
            Striker::Punch { radius, .. } => (radius as f32, RigidBodyBuilder::kinematic_position_based()),
        };
        let centre = start(sheet, impact, radius);
        let collider = ColliderBuilder::ball(radius).mass(BALL_KG).friction(friction);
        let (ball, _) = world.insert(rigid.translation(centre), collider);
        Self { world, sheet: sheet_handle, ball, radius, simulated: 0.0 }
    }

    fn step(&mut self, damping: f32) {
        self.world.step();
        let dt = self.world.integration_parameters.dt;
        self.simulated += dt;
        // The truth's factor of each of its steps of 1 ms, and as much each second at any other step.
        let kept = (1.0 - damping * 1e-3).powf(dt / 1e-3);
        let sheet = &mut self.world.soft_bodies[self.sheet];
        for i in 0..sheet.num_particles() {
            let velocity = sheet.particle_velocity(i);
            sheet.set_particle_velocity(i, velocity * kept);
        }
    }

    /// Until the ball has left or stands still.
    fn shoot(&mut self, impact: &Impact) {
        let direction = vector(impact.direction);
        let speed = self.world.bodies[self.ball].linvel().dot(direction);
        let mut touched = false;
        while self.simulated < CONTACT_AT_MOST {
            self.step(DAMPING_IN_CONTACT);
            let ball = &self.world.bodies[self.ball];
            let forward = ball.linvel().dot(direction);
            touched |= forward < 0.99 * speed;
            let centre = ball.translation();
            let clear = self.radius + 0.005;
            let apart = self.world.soft_bodies[self.sheet]
                .particle_positions()
                .all(|p| (p - centre).length_squared() > clear * clear);
            if touched && forward < 0.05 * speed && apart {
                return;
            }
        }
    }

    /// In along `travel` and out again, smoothly.
    fn press(&mut self, travel: Vector) {
        let start = self.world.bodies[self.ball].translation();
        let dt = self.world.integration_parameters.dt;
        let steps = 2 * ((PRESS_S / dt).ceil() as usize).max(12);
        for k in 1..=steps {
            let phase = std::f32::consts::TAU * k as f32 / steps as f32;
            let at = start + travel * (0.5 * (1.0 - phase.cos()));
            self.world.bodies[self.ball].set_next_kinematic_translation(at);
            self.step(DAMPING_IN_CONTACT);
        }
    }

    /// Takes the ball away and damps the sheet to rest.
    fn settle(&mut self) {
        self.world.remove_body(self.ball);
        let started = self.simulated;
        loop {
            self.step(DAMPING_AFTER);
            let seconds = self.simulated - started;
            let sheet = &self.world.soft_bodies[self.sheet];
            let speed = sheet.particle_velocities().map(|v| v.length()).fold(0.0, f32::max);
            if (seconds > SETTLE_AT_LEAST && speed < REST_SPEED) || seconds > SETTLE_AT_MOST {
                return;
            }
        }
    }
}

/// Where the ball starts: just off the contact point along the outward normal, and back along its way until it is clear of
/// the curved sheet.
fn start(sheet: &Sheet, impact: &Impact, radius: f32) -> Vector {
    let direction = vector(impact.direction);
    let nearest = |c: Vector| sheet.vertices.iter().map(|p| (vector(*p) - c).length()).fold(f32::MAX, f32::min);
    let normal = outward(sheet, vector(impact.point));
    let mut centre = vector(impact.point) + normal * (radius + 0.003);
    if matches!(impact.striker, Striker::Ball { .. }) {
        for _ in 0..400 {
            if nearest(centre) >= radius + 0.0025 {
                break;
            }
            centre -= direction * 0.002;
        }
    }
    centre
}

/// Unit normal of the vertex nearest to a point.
fn outward(sheet: &Sheet, point: Vector) -> Vector {
    let distance = |v: &usize| (vector(sheet.vertices[*v]) - point).length();
    let nearest = (0..sheet.vertices.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("vertices");
    let mut sum = Vector::ZERO;
    for t in sheet.triangles.iter().filter(|t| t.contains(&(nearest as u32))) {
        let [a, b, c] = t.map(|v| vector(sheet.vertices[v as usize]));
        sum += (b - a).cross(c - a);
    }
    sum.normalize()
}

fn vector(v: [f32; 3]) -> Vector {
    Vector::new(v[0], v[1], v[2])
}

fn bytes(body: &SoftBody) -> usize {
    size_of_val(body.particles())
        + size_of_val(body.edges())
        + size_of_val(body.dihedrals())
        + size_of_val(body.boundary())
}
