//! Tests of the pictures.

use super::camera::Camera;
use super::legend::millimetres;
use super::raster::{self, Body};
use super::shade::decode;
use super::{Coat, Kind, MARGINS, Scale, Subject, View};
use glam::Vec3;

const SIZE: [usize; 2] = [1280, 800];

/// A sphere of radius 1 around `centre`, as positions, normals and triangles.
fn sphere(centre: Vec3) -> (Vec<Vec3>, Vec<Vec3>, Vec<[u32; 3]>) {
    let (rings, sectors) = (96u32, 192u32);
    let mut normals = Vec::new();
    for i in 0..=rings {
        for j in 0..=sectors {
            let (a, b) = (
                std::f32::consts::PI * i as f32 / rings as f32,
                std::f32::consts::TAU * (j % sectors) as f32 / sectors as f32,
            );
            normals.push(Vec3::new(a.sin() * b.sin(), a.cos(), a.sin() * b.cos()));
        }
    }
    let at = |i: u32, j: u32| i * (sectors + 1) + j;
    let mut triangles = Vec::new();
    for i in 0..rings {
        for j in 0..sectors {
            triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    (normals.iter().map(|n| centre + *n).collect(), normals, triangles)
}

/// A body that was not hit.
fn at_rest<'a>(positions: &'a [Vec3], normals: &'a [Vec3], triangles: &'a [[u32; 3]]) -> Subject<'a> {
    Subject {
        triangles,
        before: positions,
        before_normals: normals,
        after: positions,
        after_normals: normals,
        coats: (&[], &[]),
        contacts: &[],
        up: Vec3::Y,
        size: SIZE,
    }
}

#[test]
fn a_sphere_covers_the_area_that_geometry_says() {
    let centre = Vec3::new(3.0, -2.0, 1.0);
    let (positions, normals, triangles) = sphere(centre);
    let view = View::of(&positions, &triangles, &vec![Vec3::ZERO; positions.len()], Vec3::Y);
    let camera = Camera::framing(&positions, view, SIZE[0] as f32 / SIZE[1] as f32, MARGINS);
    let body = Body { positions: &positions, normals: &normals, triangles: &triangles, values: &[] };
    let surfaces = raster::through(&camera, body, SIZE);
    let covered = surfaces.as_ref().iter().filter(|s| s.is_some()).count() as f32;
    // The outline of a sphere is an ellipse in the image plane.
    let to = centre - camera.eye;
    let (sin2, cos2) = (1.0 / to.length_squared(), (to.normalize().dot(-camera.back)).powi(2));
    let area = std::f32::consts::PI * sin2 * (1.0 - sin2).sqrt() * cos2.sqrt().max(0.0) / (cos2 - sin2).powf(1.5);
    let pixels = area * (SIZE[1] as f32 / (2.0 * camera.tan.y)).powi(2);
    assert!((covered / pixels - 1.0).abs() < 0.01, "{covered} pixels, {pixels} expected");
    // The near side hides the far side, without pinholes.
    let far = surfaces.as_ref().iter().filter(|s| s.is_some() && s.distance > to.dot(-camera.back)).count();
    assert_eq!(far, 0, "pixels look through the surface");
    // The sphere fills the frame between the margins.
    let rows = (0..SIZE[1]).filter(|y| surfaces.as_ref()[y * SIZE[0]..(y + 1) * SIZE[0]].iter().any(|s| s.is_some()));
    let rows: Vec<usize> = rows.collect();
    let (top, bottom) = (MARGINS.top * SIZE[1] as f32, (1.0 - MARGINS.bottom) * SIZE[1] as f32);
    assert!((rows[0] as f32 - top).abs() < 3.0, "{} {top}", rows[0]);
    assert!((rows[rows.len() - 1] as f32 - bottom).abs() < 3.0, "{} {bottom}", rows[rows.len() - 1]);
}

#[test]
fn the_deepest_vertex_has_the_last_colour_of_the_scale() {
    let (before, normals, triangles) = sphere(Vec3::ZERO);
    let hit = Vec3::new(0.3, 0.2, 0.9).normalize();
    let after: Vec<Vec3> =
        before.iter().map(|p| *p * (1.0 - 0.05 * (1.0 - p.distance(hit) / 0.5).max(0.0).powi(2))).collect();
    let subject = Subject { after: &after, ..at_rest(&before, &normals, &triangles) };
    let (vertex, maximum) = subject.deepest();
    assert!(before[vertex].distance(hit) < 0.05 && maximum <= 0.05);
    let image = subject.draw(Kind::Heat);
    let moved: Vec<Vec3> = after.iter().zip(&before).map(|(a, b)| *a - *b).collect();
    let view = View::of(&before, &triangles, &moved, Vec3::Y);
    let camera = Camera::framing(before.iter().chain(&after), view, SIZE[0] as f32 / SIZE[1] as f32, MARGINS);
    let at = camera.pixel(after[vertex], SIZE);
    let at = (at.y as usize * SIZE[0] + at.x as usize) * 3;
    let colour = Scale { maximum }.colour(maximum);
    // Light scales a colour without changing its hue.
    let shares: Vec<f32> = (0..3).map(|c| decode(image.rgb[at + c]) / decode(colour[c])).collect();
    let (low, high) = shares.iter().fold((f32::MAX, 0f32), |(l, h), s| (l.min(*s), h.max(*s)));
    assert!(low > 0.5 && high < 1.15 && high - low < 0.2, "{shares:?}");
}

#[test]
fn a_vertex_has_the_colour_of_its_coat() {
    let (before, normals, triangles) = sphere(Vec3::ZERO);
    let coats = [Coat::of(Vec3::Z, 0.0, 1.0), Coat::of(Vec3::X, 0.0, 1.0)];
    let coat_of = vec![1.0; before.len()];
    let subject = Subject { coats: (&coats, &coat_of), ..at_rest(&before, &normals, &triangles) };
    let image = subject.draw(Kind::Base);
    // A rough coat reflects nothing, so it has no other colour than its own.
    let middle = (SIZE[1] / 2 * SIZE[0] + SIZE[0] / 2) * 3;
    let [red, green, blue] = [0, 1, 2].map(|channel| image.rgb[middle + channel]);
    assert!(red > 40 && green == 0 && blue == 0, "{red} {green} {blue}");
}

#[test]
fn drawing_what_has_no_size_or_no_dent_does_not_fail() {
    let one = [Vec3::ONE; 3];
    let subject = Subject { contacts: &[0], size: [64, 40], ..at_rest(&one, &[Vec3::Z; 3], &[[0, 1, 2]]) };
    for kind in Kind::ALL {
        assert_eq!(subject.draw(kind).rgb.len(), 64 * 40 * 3);
    }
}

#[test]
fn lengths_are_written_with_the_digits_they_need() {
    let text = [0.0, 1e-8, 4.2e-6, 0.000_25, 0.0334, 0.2, 3.0].map(millimetres);
    assert_eq!(text, ["0.0", "1.00e-5", "0.004", "0.2", "33.4", "200", "3000"]);
}
