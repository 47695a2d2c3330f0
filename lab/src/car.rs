//! The project's car in films: Rapier moves it, the contact layer tells of its contacts, and Crumple writes the vertices that are drawn.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, Result};
use crumple::import::{MeshChoice, Part, PartKind, Patterns, gltf_slice};
use crumple::{
    Aabb, Attachment, BasisOptions, ExampleSet, Instance, InstanceOptions, MeshData, SetOptions, ThreadPool, Tracker,
    VertexMemory,
};
use glam::{Mat4, Quat, Vec3};
use rapier3d::prelude::{
    ColliderBuilder, Group, InteractionGroups, InteractionTestMode, PhysicsWorld, RigidBodyBuilder, RigidBodyHandle,
    SpringCoefficients, Vector,
};

use crate::peers::rapier_contacts::RapierContacts;
use crate::pictures::picture::{Body, Coat, Image, coats};
use crate::street::simplify::clustered_by;

const CAR: &str = "assets/car/car_dents.glb";
/// How far vertices may be from the examples where nodes are added, m.
const TOLERANCE: f32 = 0.01;
/// kg
const MASS: f32 = 1200.0;
/// Bodies give way in a contact, as a spring and a damper with this frequency (Hz) for the mass would: crumple zones.
const GIVE: SpringCoefficients<f32> = SpringCoefficients { natural_frequency: 3.0, damping_ratio: 0.7 };
/// What cars meet.
const DRIVES: InteractionGroups = InteractionGroups::new(Group::GROUP_1, Group::GROUP_1, InteractionTestMode::And);
/// Glass breaks when a part of it has moved this far, m.
pub const GLASS_HOLDS: f32 = 0.012;
/// Radius of a wheel, m.
const WHEEL: f32 = 0.335;
/// Vertices above this height are the greenhouse's, m.
const BELT: f32 = 0.92;
pub const UP: Vec3 = Vec3::Y;

/// An empty folder for the frames of a film, which lab/python/film.py reads.
pub fn frames(film: &str) -> Result<PathBuf> {
    let folder = Path::new("out").join(film);
    // Older frames would be part of the film.
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).with_context(|| format!("making {}", folder.display()))?;
    Ok(folder)
}

pub fn write_frame(folder: &Path, frame: usize, image: &Image) -> Result<()> {
    let path = folder.join(format!("frame_{frame:03}.png"));
    fs::write(&path, image.to_png("a crash")?).with_context(|| format!("writing {}", path.display()))
}

/// A wheel of the car, and where it is mounted.
pub struct Wheel {
    part: usize,
    centre: Vec3,
    mount: Attachment,
}

/// A mesh of the whole car.
pub struct Level {
    /// The same parts in each level, each with its ranges there.
    pub parts: Vec<Part>,
    pub coat_of: Vec<f32>,
}

/// What all cars share.
pub struct Model {
    pub set: Arc<ExampleSet>,
    /// The set's own mesh, and the levels of detail that were added.
    pub levels: Vec<Level>,
    pub wheels: Vec<Wheel>,
    pub coats: Vec<Coat>,
    /// Indices of the coats of the body and of the roof.
    pub paint: usize,
    pub roof: usize,
    /// Of what mostly lies below the skin.
    inner: Vec<usize>,
    hulls: [ColliderBuilder; 2],
}

impl Model {
    /// The car, and the meshes of its parts.
    pub fn load(pool: &ThreadPool) -> Result<(Self, Vec<MeshData>)> {
        let bytes = fs::read(CAR).with_context(|| format!("reading {CAR}"))?;
        let imported = gltf_slice(&bytes, None, MeshChoice::Nodes(Patterns::default()))?;
        let (meshes, parts) = (imported.part_meshes(), imported.parts);
        let (coats, coat_of) = coats(&bytes, &imported.primitives, imported.mesh.positions.len());
        let coat = |material: &str| {
            let range = imported.primitives.iter().find(|range| range.material.as_deref() == Some(material));
            range.map(|range| coat_of[range.vertices.start] as usize)
        };
        let paint = coat("paint").context("the car has no paint")?;
        let roof = coat("paint_second").context("the roof has no paint")?;
        let inner = ["trim", "trim_gloss", "chrome", "seat"].into_iter().filter_map(coat).collect();
        let options = SetOptions { basis: Some(BasisOptions::new(TOLERANCE)), ..SetOptions::default() };
        let set = ExampleSet::build(imported.mesh, imported.examples, options, pool)?;
        let wheel = |(part, of): (usize, &Part)| -> Result<Wheel> {
            let Aabb { min, max } = Aabb::of(&set.mesh().positions()[of.vertices.clone()]);
            let centre = (min + max) * 0.5;
            // What holds it is the chassis in its middle.
            let mount = set.attach((centre * Vec3::new(0.5, 1.0, 1.0)).to_array())?;
            Ok(Wheel { part, centre, mount })
        };
        let wheels = parts.iter().enumerate().filter(|(_, part)| is_wheel(part));
        let wheels = wheels.map(wheel).collect::<Result<Vec<_>>>()?;
        let hulls = hulls(&set, &parts, |points| points)?;
        let levels = vec![Level { parts, coat_of }];
        Ok((Model { set: Arc::new(set), levels, wheels, coats, paint, roof, inner, hulls }, meshes))
    }

    /// The set, as long as there is no car.
    pub fn set_mut(&mut self) -> Result<&mut ExampleSet> {
        Arc::get_mut(&mut self.set).context("the set is in use")
    }

    /// Adds a level of detail with cells of this size, m.
    pub fn add_level(&mut self, cell: f32, pool: &ThreadPool) -> Result<()> {
        let (mesh, base) = (self.set.mesh(), &self.levels[0]);
        let part_of = |v: u32| base.parts.partition_point(|part| part.vertices.start <= v as usize) - 1;
        // Wheels turn, so they share no place with the body. What shares one has a normal and a coat of its own.
        let solid = |v: u32| Some(part_of(v)).filter(|part| is_wheel(&base.parts[*part]));
        let normals = mesh.normals().context("the car has no normals")?;
        let side = |v: u32| normals[v as usize].to_array().map(|x| (1.5 * x).round() as i32);
        let kind = |v: u32| (part_of(v), base.coat_of[v as usize] as u32, side(v));
        let outside = |v: u32| !self.inner.contains(&(base.coat_of[v as usize] as usize));
        let all = |v: &[Vec3]| v.iter().map(Vec3::to_array).collect::<Vec<_>>();
        let whole = MeshData {
            positions: all(mesh.positions()),
            normals: Some(all(normals)),
            triangles: mesh.triangles().to_vec(),
            ..MeshData::default()
        };
        let (coarse, from) = clustered_by(&whole, cell, solid, kind, outside);
        let first = |v: usize| from.partition_point(|of| (*of as usize) < v);
        let triangle = |v: usize| coarse.triangles.partition_point(|t| (t[0] as usize) < v);
        let part = |part: &Part| {
            let vertices = first(part.vertices.start)..first(part.vertices.end);
            let triangles = triangle(vertices.start)..triangle(vertices.end);
            Part { vertices, triangles, ..part.clone() }
        };
        let level = Level {
            parts: base.parts.iter().map(part).collect(),
            coat_of: from.iter().map(|v| base.coat_of[*v as usize]).collect(),
        };
        self.levels.push(level);
        self.set_mut()?.add_lod(coarse, pool)?;
        Ok(())
    }

    /// Gives the physics hulls of the vertices that lie farthest in so many directions.
    pub fn set_hulls(&mut self, directions: usize) -> Result<()> {
        self.hulls = hulls(&self.set, &self.levels[0].parts, |points| farthest(&points, directions))?;
        Ok(())
    }

    /// The wheel that a part is.
    pub fn wheel(&self, part: usize) -> Option<&Wheel> {
        self.wheels.iter().find(|wheel| wheel.part == part)
    }
}

fn is_wheel(part: &Part) -> bool {
    part.name.starts_with("wheel_")
}

/// The convex hulls of the lower body and of the greenhouse.
fn hulls(set: &ExampleSet, parts: &[Part], of: impl Fn(Vec<Vec3>) -> Vec<Vec3>) -> Result<[ColliderBuilder; 2]> {
    let own = |part: &&Part| !["wheel_", "mirror_", "antenna"].iter().any(|start| part.name.starts_with(start));
    let points = parts.iter().filter(own).flat_map(|part| &set.mesh().positions()[part.vertices.clone()]);
    let (upper, lower): (Vec<Vec3>, Vec<Vec3>) = points.partition(|p| p.y > BELT);
    let hull = |points: Vec<Vec3>| {
        let points: Vec<Vector> = of(points).iter().map(vector).collect();
        ColliderBuilder::convex_hull(&points).context("the car has no hull")
    };
    Ok([hull(lower)?.mass(0.8 * MASS), hull(upper)?.mass(0.2 * MASS)])
}

/// The points that lie farthest in so many directions, which are spread evenly over the sphere.
fn farthest(points: &[Vec3], directions: usize) -> Vec<Vec3> {
    let direction = |i: usize| {
        let (turn, y) = (2.399_963 * i as f32, 1.0 - (2 * i + 1) as f32 / directions as f32);
        Vec3::new(turn.cos(), 0.0, turn.sin()) * (1.0 - y * y).sqrt() + UP * y
    };
    let far = |d: Vec3| points.iter().copied().max_by(|a, b| a.dot(d).total_cmp(&b.dot(d)));
    (0..directions).filter_map(|i| far(direction(i))).collect()
}

/// An empty world with this length of a step, s.
pub fn world(seconds: f32) -> PhysicsWorld {
    let mut world = PhysicsWorld::default();
    world.integration_parameters.dt = seconds;
    world.integration_parameters.contact_softness = GIVE;
    world.integration_parameters.static_contact_softness = GIVE;
    world
}

/// A body that moves, m/s.
pub fn moving(at: Vec3, turn: Quat, speed: Vec3) -> RigidBodyBuilder {
    let rotation = Vector::from_array(turn.to_scaled_axis().to_array());
    RigidBodyBuilder::dynamic().translation(vector(&at)).rotation(rotation).linvel(vector(&speed))
}

pub fn pose(world: &PhysicsWorld, body: RigidBodyHandle) -> Mat4 {
    let body = &world.bodies[body];
    let turn = Quat::from_array(body.rotation().to_array());
    Mat4::from_rotation_translation(turn, Vec3::from_array(body.translation().to_array()))
}

pub fn vector(v: &Vec3) -> Vector {
    Vector::from_array(v.to_array())
}

/// A body of the physics, and the vertices that Crumple writes for it.
pub struct Dented {
    pub body: RigidBodyHandle,
    pub instance: Instance,
    pub tracker: Tracker,
    pub positions: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
}

impl Dented {
    pub fn deform(&mut self, pool: &ThreadPool) -> Result<()> {
        let memory = VertexMemory::separate(&mut self.positions, Some(&mut self.normals), None)?;
        self.instance.deform(&mut self.tracker, memory, pool)?;
        Ok(())
    }
}

pub struct Car {
    pub dented: Dented,
    pub paint: Coat,
    /// How far it has rolled, m.
    way: f32,
}

impl Car {
    /// Puts a car on its wheels into a world. It drives ahead, m/s.
    pub fn add(
        world: &mut PhysicsWorld,
        contacts: &mut RapierContacts,
        model: &Model,
        (at, turn, speed): (Vec3, Quat, f32),
        paint: Coat,
        options: InstanceOptions,
    ) -> Result<Self> {
        let body = moving(at, turn, turn * Vec3::Z * speed)
            .gravity_scale(0.0)
            .enabled_translations(true, false, true)
            .enabled_rotations(false, true, false)
            .can_sleep(false);
        let body = world.insert_body(body);
        let instance = Instance::new(model.set.clone(), options)?;
        for hull in model.hulls.clone() {
            let collider = world.insert_collider(hull.friction(0.3).collision_groups(DRIVES), Some(body));
            contacts.dent(collider, instance.inbox().clone());
        }
        let vertices = vec![[0.0; 3]; model.set.vertex_count()];
        let dented = Dented { body, instance, tracker: Tracker::new(), positions: vertices.clone(), normals: vertices };
        Ok(Car { dented, paint, way: 0.0 })
    }

    /// Tells the instance where it is. Call it before each step.
    pub fn before_step(&self, world: &PhysicsWorld) -> Result<()> {
        Ok(self.dented.instance.set_transform(pose(world, self.dented.body))?)
    }

    /// Lets the wheels roll.
    pub fn roll(&mut self, world: &PhysicsWorld, seconds: f32) {
        let ahead = self.ahead(world);
        self.way += Vec3::from(world.bodies[self.dented.body].linvel().to_array()).dot(ahead) * seconds;
    }

    pub fn ahead(&self, world: &PhysicsWorld) -> Vec3 {
        Quat::from_array(world.bodies[self.dented.body].rotation().to_array()) * Vec3::Z
    }

    /// Who has crashed brakes. Whether it is the first time.
    pub fn brake(&mut self, world: &mut PhysicsWorld) -> Result<bool> {
        let body = &mut world.bodies[self.dented.body];
        let begins = !self.dented.instance.marks()?.is_empty() && body.linear_damping() == 0.0;
        if begins {
            body.set_linear_damping(1.2);
            body.set_angular_damping(1.5);
        }
        Ok(begins)
    }

    /// Where a wheel is on the car: it rolls, and moves and turns as what holds it does.
    pub fn rolled(&self, wheel: &Wheel) -> Result<Mat4> {
        let held = self.dented.instance.attached_pose(&wheel.mount)?;
        let turn = Quat::from_array(held.rotation);
        let moved = Vec3::from(held.position) - Vec3::from(wheel.mount.point);
        let roll = Quat::from_rotation_x(self.way / WHEEL);
        Ok(Mat4::from_rotation_translation(turn * roll, wheel.centre + moved) * Mat4::from_translation(-wheel.centre))
    }
}

/// The vertices of a frame.
#[derive(Default)]
pub struct Shown {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
    pub coat_of: Vec<f32>,
    pub coats: Vec<Coat>,
}

impl Shown {
    /// Adds a part of a car, without its panes, which are parts of their own. `lod` is the level that the vertices are of.
    pub fn add(
        &mut self,
        (model, lod, part): (&Model, usize, usize),
        dented: &Dented,
        at: Mat4,
        coat: impl Fn(f32) -> f32,
    ) -> Result<()> {
        let Dented { positions, normals, .. } = dented;
        let Level { parts, coat_of } = &model.levels[lod];
        let (part, first) = (&parts[part], self.positions.len() as u32);
        let own = part.vertices.clone();
        self.positions.extend(positions[own.clone()].iter().map(|p| at.transform_point3(Vec3::from_array(*p))));
        self.normals.extend(normals[own.clone()].iter().map(|n| at.transform_vector3(Vec3::from_array(*n))));
        self.coat_of.extend(coat_of[own].iter().map(|of| coat(*of)));
        let triangles = model.set.lod_mesh(lod)?.triangles();
        let panes: Vec<_> = parts.iter().filter(|p| p.kind == PartKind::Glass).map(|pane| &pane.triangles).collect();
        let is_pane = |t: &usize| part.kind != PartKind::Glass && panes.iter().any(|pane| pane.contains(t));
        let own = part.triangles.clone().filter(|t| !is_pane(t));
        self.triangles.extend(own.map(|t| triangles[t].map(|v| v - part.vertices.start as u32 + first)));
        Ok(())
    }

    /// Adds points that no triangle has: the floor, the light and the shadows are those of a scene that reaches so far.
    pub fn reach(&mut self, points: &[Vec3]) {
        self.positions.extend(points);
        self.normals.extend(points.iter().map(|_| UP));
        self.coat_of.extend(points.iter().map(|_| 0.0));
    }

    pub fn body(&self) -> Body<'_> {
        Body { positions: &self.positions, normals: &self.normals, triangles: &self.triangles, values: &self.coat_of }
    }
}

/// The corners of a box.
pub fn corners([low, high]: [Vec3; 2]) -> [Vec3; 8] {
    std::array::from_fn(|i| Vec3::select(glam::BVec3::new(i & 1 == 0, i & 2 == 0, i & 4 == 0), low, high))
}
