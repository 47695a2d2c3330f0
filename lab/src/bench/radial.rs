//! A dent as packages for game engines make it on the CPU: each hit moves all vertices within a radius of the contact along the
//! push, less the further away, and recalculates the mesh's normals from its triangles.

use glam::Vec3;

pub struct RadialDent<'a> {
    base: &'a [Vec3],
    triangles: &'a [[u32; 3]],
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
}

impl<'a> RadialDent<'a> {
    pub fn new(base: &'a [Vec3], triangles: &'a [[u32; 3]]) -> Self {
        RadialDent { base, triangles, positions: base.to_vec(), normals: vec![Vec3::ZERO; base.len()] }
    }

    /// Dents the body at rest.
    pub fn run(&mut self, contact: Vec3, push: Vec3, radius: f32) {
        let least = radius * radius;
        for (p, base) in self.positions.iter_mut().zip(self.base) {
            let square = (*base - contact).length_squared();
            let share = 1.0 - square / least;
            *p = if share > 0.0 { *base + push * (share * share) } else { *base };
        }
        self.normals.fill(Vec3::ZERO);
        for t in self.triangles {
            let [a, b, c] = t.map(|v| self.positions[v as usize]);
            let normal = (b - a).cross(c - a);
            t.iter().for_each(|v| self.normals[*v as usize] += normal);
        }
        self.normals.iter_mut().for_each(|n| *n = n.normalize_or_zero());
        std::hint::black_box((&self.positions, &self.normals));
    }
}
