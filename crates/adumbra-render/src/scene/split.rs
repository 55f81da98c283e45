//! Splits triangles that are far larger than the rest, for the GPU. Vertices far behind the camera are
//! clipped in `f32`, which moves nearby parts off their plane, by centimetres on a quad of 1000 km. Pure
//! arithmetic, without the GPU.
//!
//! An edge is halved while it is longer than [`LONGEST_EDGES`] times the scene's median edge. Every triangle
//! that shares an edge splits it alike, so they leave no cracks. The median changes neither with a stray
//! triangle nor with the scene's unit.

use std::borrow::Cow;
use std::collections::HashMap;

use adumbra_scene::{Mesh, Scene};

/// Longest edge that is not split, in multiples of the scene's median edge.
const LONGEST_EDGES: f64 = 2048.0;
/// Approximate number of triangles that the median is taken over.
const SAMPLE: usize = 1 << 16;
/// A mesh is not split any further if it would have more triangles than this.
const MAX_TRIANGLES: usize = 1 << 20;

/// Returns for each mesh the scale of its largest instance, along the axis scaled most; 0 without instances.
pub(super) fn largest_scales(scene: &Scene) -> Vec<f64> {
    let mut scales = vec![0.0_f64; scene.meshes.len()];
    for instance in &scene.instances {
        let column =
            |c: usize| instance.world_from_mesh.iter().map(|row| row[c] * row[c]).sum::<f64>().sqrt();
        let largest = (0..3).map(column).fold(0.0, f64::max);
        if let Some(scale) = scales.get_mut(instance.mesh as usize)
            && largest.is_finite()
        {
            *scale = scale.max(largest);
        }
    }
    scales
}

/// Returns the length of the longest edge that is drawn unsplit, world units; infinite for a scene without
/// edges. `scales` are those of [`largest_scales`].
pub(super) fn longest_edge(scene: &Scene, scales: &[f64]) -> f64 {
    let step = (scene.stored_triangles() as usize).div_ceil(SAMPLE).max(1);
    let placed = scene.meshes.iter().zip(scales).filter(|(_, scale)| **scale > 0.0);
    let sample = placed.flat_map(|(m, scale)| m.triangles.iter().map(move |t| (m, t, *scale))).step_by(step);
    let mut lengths: Vec<f64> = sample
        .flat_map(|(m, &[a, b, c], scale)| {
            [(a, b), (b, c), (c, a)].map(|(a, b)| scale * square(m, a, b).sqrt())
        })
        .collect();
    lengths.sort_unstable_by(f64::total_cmp);
    lengths.get(lengths.len() / 2).map_or(f64::INFINITY, |median| LONGEST_EDGES * median)
}

/// Returns the squared length of an edge, in the mesh's own units.
fn square(mesh: &Mesh, a: u32, b: u32) -> f64 {
    let [p, q] = [a, b].map(|i| mesh.positions[i as usize]);
    (0..3).map(|k| (f64::from(p[k]) - f64::from(q[k])).powi(2)).sum()
}

/// Returns the mesh with edges longer than `longest` halved until none is left, as far as [`MAX_TRIANGLES`]
/// allows. `longest` is in the mesh's own units.
pub(super) fn split_long_edges(mesh: &Mesh, longest: f64) -> Cow<'_, Mesh> {
    let mut split = Cow::Borrowed(mesh);
    while let Some(next) = halved(&split, longest) {
        split = Cow::Owned(next);
    }
    split
}

/// Halves each edge that is too long once. Returns `None` if there is none, or if too many triangles would
/// result.
fn halved(mesh: &Mesh, longest: f64) -> Option<Mesh> {
    let is_long = |a: u32, b: u32| square(mesh, a, b) > longest * longest;
    let sides = |[a, b, c]: [u32; 3]| [(a, b), (b, c), (c, a)];
    let more = mesh.triangles.iter().flat_map(|&t| sides(t)).filter(|&(a, b)| is_long(a, b)).count();
    if more == 0 || mesh.triangles.len() + more > MAX_TRIANGLES {
        return None;
    }
    let mut out = Mesh {
        name: mesh.name.clone(),
        positions: mesh.positions.clone(),
        uvs: mesh.uvs.clone(),
        colors: mesh.colors.clone(),
        ..Mesh::default()
    };
    let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
    for (&triangle, &material) in mesh.triangles.iter().zip(&mesh.triangle_materials) {
        let mut middle = |(a, b): (u32, u32)| {
            is_long(a, b)
                .then(|| *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| out.add_middle([a, b])))
        };
        let found = sides(triangle).map(&mut middle);
        // Rotate the triangle so that its split edges come first.
        let turn = (0..3).max_by_key(|&t| {
            let at = |i: usize| usize::from(found[(t + i) % 3].is_some());
            4 * at(0) + 2 * at(1) + at(2)
        });
        let at = |i: usize| (turn.unwrap_or(0) + i) % 3;
        let [a, b, c] = [0, 1, 2].map(|i| triangle[at(i)]);
        let parts = match [0, 1, 2].map(|i| found[at(i)]) {
            [Some(ab), Some(bc), Some(ca)] => vec![[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]],
            [Some(ab), Some(bc), None] => vec![[ab, b, bc], [a, ab, bc], [a, bc, c]],
            [Some(ab), None, None] => vec![[a, ab, c], [ab, b, c]],
            _ => vec![[a, b, c]],
        };
        out.triangle_materials.extend(std::iter::repeat_n(material, parts.len()));
        out.triangles.extend(parts);
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use adumbra_scene::{GeneratedKind, Mesh, generate};

    use super::*;

    const LONGEST: f64 = 4096.0;

    fn quad(half: f32) -> Mesh {
        Mesh {
            positions: vec![[-half, 0.0, -half], [-half, 0.0, half], [half, 0.0, half], [half, 0.0, -half]],
            uvs: vec![[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            triangle_materials: vec![3, 4],
            ..Mesh::default()
        }
    }

    fn corners(mesh: &Mesh, triangle: [u32; 3]) -> [[f64; 3]; 3] {
        triangle.map(|i| mesh.positions[i as usize].map(f64::from))
    }

    /// Returns twice the signed area, seen from above.
    fn area([a, b, c]: [[f64; 3]; 3]) -> f64 {
        (b[2] - a[2]) * (c[0] - a[0]) - (b[0] - a[0]) * (c[2] - a[2])
    }

    #[test]
    fn halves_long_edges_without_cracks() {
        for half in [3_000.0_f32, 50_000.0] {
            let mesh = quad(half);
            let split = split_long_edges(&mesh, LONGEST);
            assert!(matches!(split, Cow::Owned(_)));
            let areas: Vec<f64> = split.triangles.iter().map(|&t| area(corners(&split, t))).collect();
            let whole = 8.0 * f64::from(half).powi(2);
            assert!((areas.iter().sum::<f64>() / whole - 1.0).abs() < 1e-6 && areas.iter().all(|a| *a > 0.0));
            let mut edges: HashMap<[u32; 2], u32> = HashMap::new();
            for t in &split.triangles {
                for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                    *edges.entry([a.min(b), a.max(b)]).or_default() += 1;
                    let [p, q] = [a, b].map(|i| split.positions[i as usize]);
                    let length = (p[0] - q[0]).hypot(p[2] - q[2]);
                    assert!(f64::from(length) <= LONGEST, "{length}");
                }
            }
            // Inner edges are shared by two triangles. The others are on the quad's outline.
            for ([a, b], count) in edges {
                let [p, q] = [a, b].map(|i| split.positions[i as usize]);
                let outer = [0, 2].iter().any(|&k| p[k].abs() == half && p[k] == q[k]);
                assert_eq!(count, if outer { 1 } else { 2 });
            }
            assert_eq!(
                (split.uvs.len(), split.triangle_materials.len()),
                (split.positions.len(), areas.len())
            );
            for (p, uv) in split.positions.iter().zip(&split.uvs) {
                assert!((uv[0] - (p[0] / half + 1.0) / 2.0).abs() < 1e-6, "{p:?} {uv:?}");
            }
        }
    }

    #[test]
    fn ordinary_meshes_are_left_alone() {
        assert!(matches!(split_long_edges(&quad(1_000.0), LONGEST), Cow::Borrowed(_)));
        assert!(matches!(split_long_edges(&quad(1e6), f64::INFINITY), Cow::Borrowed(_)));
        let mesh = quad(1e30);
        let far_too_large = split_long_edges(&mesh, LONGEST);
        assert!(far_too_large.triangles.len() <= MAX_TRIANGLES);
    }

    #[test]
    fn longest_edge_follows_the_median_edge_and_the_unit() {
        let mut scene = generate(GeneratedKind::City, 1);
        let of = |scene: &Scene| longest_edge(scene, &largest_scales(scene));
        let plain = of(&scene);
        assert!((100.0..1e5).contains(&plain), "{plain}");
        scene.meshes[0].positions.extend([[1e6, 0.0, 0.0], [1e6, 0.0, 1.0], [0.0, 0.0, 1e6]]);
        let last = scene.meshes[0].positions.len() as u32;
        scene.meshes[0].triangles.push([last - 3, last - 2, last - 1]);
        scene.meshes[0].triangle_materials.push(0);
        assert!((of(&scene) / plain - 1.0).abs() < 0.01);
        for row in scene.instances.iter_mut().flat_map(|i| &mut i.world_from_mesh) {
            row.iter_mut().for_each(|c| *c *= 1000.0);
        }
        assert!((of(&scene) / plain / 1000.0 - 1.0).abs() < 0.01);
        assert_eq!(of(&Scene::default()), f64::INFINITY);
    }
}
