//! Points on all surfaces, one for each square of a spacing's side.
//!
//! The triangles are laid end to end by area, and each square of the spacing's side gets a point in the
//! triangle at its middle. Within triangles, points follow the R2 sequence (Roberts, *The Unreasonable
//! Effectiveness of Quasirandom Sequences*, 2018), which fills large ones evenly.

use adumbra::grid::vec3::{cross, dot};
use adumbra_scene::{Instance, Mesh, Scene};
use adumbra_truth::trace::{Hit, Tracer};
use adumbra_truth::verify::Solids;

use super::{Facing, Receiver, check_spacing, some};
use crate::error::Result;

/// 1 / g and 1 / g², where g³ = g + 1.
const R2: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3];

/// Returns points on the opaque surfaces of the tracer's scene, one for each `spacing_world` ×
/// `spacing_world` of area. Points on solids face outward. Points on sheets, which do not bound a solid, are
/// lit from either side. The same scene and spacing give the same points. Cost: the topology of each mesh,
/// and two passes over the placed triangles.
///
/// # Errors
/// Returns [`Error::Range`](crate::Error::Range) if the spacing is not above 0,
/// [`Error::TooManyPoints`](crate::Error::TooManyPoints) if it is too small, and
/// [`Error::NoPoints`](crate::Error::NoPoints) if it is so large that no point remains.
pub fn surface_points(tracer: &Tracer<'_>, spacing_world: f64, ignore_alpha: bool) -> Result<Vec<Receiver>> {
    let scene = tracer.scene();
    let total: f64 = placed(scene).map(|triangle| triangle.area()).sum();
    check_spacing(spacing_world, |spacing| total / (spacing * spacing))?;
    let solids = Solids::of(scene);
    let square = spacing_world * spacing_world;
    let (mut points, mut done, mut number) = (Vec::new(), 0.0, 0_u64);
    for triangle in placed(scene) {
        done += triangle.area();
        while (number as f64 + 0.5) * square < done {
            let receiver = triangle.receiver(tracer, &solids, ignore_alpha, weights(number));
            points.extend(receiver);
            number += 1;
        }
    }
    some(points, "on the surfaces", "give a smaller spacing")
}

/// Barycentric weights of the point with this number.
fn weights(number: u64) -> [f64; 3] {
    let [mut u, mut v] = R2.map(|step| (0.5 + step * number as f64).fract());
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    [1.0 - u - v, u, v]
}

/// A triangle of an instance.
struct Placed<'s> {
    instance: (u32, &'s Instance),
    mesh: &'s Mesh,
    triangle: u32,
}

fn placed(scene: &Scene) -> impl Iterator<Item = Placed<'_>> {
    (0..).zip(&scene.instances).flat_map(|instance| {
        let mesh = &scene.meshes[instance.1.mesh as usize];
        (0..mesh.triangles.len() as u32).map(move |triangle| Placed { instance, mesh, triangle })
    })
}

impl Placed<'_> {
    fn corners(&self) -> [[f64; 3]; 3] {
        let vertices = self.mesh.triangles[self.triangle as usize];
        vertices.map(|v| self.instance.1.to_world(self.mesh.positions[v as usize]))
    }

    /// Twice the area times the normal of the winding.
    fn cross(&self) -> [f64; 3] {
        let [a, b, c] = self.corners();
        let edge = |to: [f64; 3]| std::array::from_fn(|k| to[k] - a[k]);
        cross(edge(b), edge(c))
    }

    /// The area, or 0 if it is not finite.
    fn area(&self) -> f64 {
        let n = self.cross();
        let area = 0.5 * dot(n, n).sqrt();
        if area.is_finite() { area } else { 0.0 }
    }

    /// The point with these weights; `None` in a hole of a masked surface.
    fn receiver(
        &self,
        tracer: &Tracer<'_>,
        solids: &Solids,
        ignore_alpha: bool,
        weights: [f64; 3],
    ) -> Option<Receiver> {
        let material = self.mesh.triangle_materials[self.triangle as usize];
        let [a, b, c] = self.mesh.corner_uvs(self.triangle).map(|uv| uv.map(f64::from));
        let uv = [0, 1].map(|k| (weights[0] * a[k] + weights[1] * b[k] + weights[2] * c[k]) as f32);
        let alpha = self.mesh.alpha_at(self.triangle, weights);
        if !ignore_alpha && !tracer.scene().is_opaque(material, uv, alpha) {
            return None;
        }
        let (number, instance) = self.instance;
        let [a, b, c] = self.corners();
        let p_world = std::array::from_fn(|k| weights[0] * a[k] + weights[1] * b[k] + weights[2] * c[k]);
        let n = self.cross();
        let length = dot(n, n).sqrt() * if instance.determinant() < 0.0 { -1.0 } else { 1.0 };
        let normal = n.map(|c| c / length);
        let solid = solids.contains(number, self.triangle);
        let hit = Hit {
            t: 0.0,
            instance: number,
            triangle: self.triangle,
            material,
            barycentric: weights,
            uv,
            normal,
            front: true,
        };
        let facing = if solid { Facing::Front(normal) } else { Facing::Both(normal) };
        Some(Receiver { p_world, facing, lift_world: tracer.lift_world(&hit, p_world) })
    }
}

#[cfg(test)]
mod tests {
    use adumbra_testing::{add_quad, cuboid, scene_of};
    use adumbra_truth::trace::TraceOptions;

    use super::*;

    #[test]
    fn surface_points_are_spread_by_area_and_face_outward() {
        // Faces of 4 × 2, 4 × 1 and 2 × 1, twice each: 28 in all.
        let scene = scene_of(vec![cuboid([0.0, 0.0, 0.0], [4.0, 1.0, 2.0])]);
        let tracer = Tracer::build(&scene, TraceOptions::default());
        let points = surface_points(&tracer, 0.1, false).unwrap();
        assert_eq!(points.len(), 2800);
        let mut counts = [0; 6];
        for point in &points {
            let Facing::Front(normal) = point.facing else { panic!("a box is solid") };
            let axis = (0..3).find(|&a| normal[a].abs() > 0.99).unwrap();
            let side = usize::from(normal[axis] > 0.0);
            let plane = [0.0, [4.0, 1.0, 2.0][axis]][side];
            assert!((point.p_world[axis] - plane).abs() < 1e-6, "{point:?}");
            counts[2 * axis + side] += 1;
        }
        for (found, expected) in counts.into_iter().zip([200_i32, 200, 800, 800, 400, 400]) {
            assert!((found - expected).abs() <= 2, "{counts:?}");
        }
        // The points fill the top evenly: a quarter in each quarter.
        let top = points.iter().filter(|p| p.normal().unwrap()[1] > 0.5);
        let quarter = top.filter(|p| p.p_world[0] < 2.0 && p.p_world[2] < 1.0).count();
        assert!((180..=220).contains(&quarter), "{quarter}");
    }

    #[test]
    fn points_on_sheets_are_lit_from_both_sides() {
        let mut mesh = adumbra_scene::Mesh::default();
        add_quad(&mut mesh, [[0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, 0.0]]);
        let scene = scene_of(vec![mesh]);
        let tracer = Tracer::build(&scene, TraceOptions::default());
        let points = surface_points(&tracer, 0.5, false).unwrap();
        assert_eq!(points.len(), 4);
        assert!(points.iter().all(|p| p.facing == Facing::Both([0.0, 1.0, 0.0])));
        assert!(surface_points(&tracer, 10.0, false).is_err());
        assert!(surface_points(&tracer, 0.0, false).is_err());
    }
}
