//! Base colours at ray hits: material, texture and vertex colours, filtered as a renderer filters them.
//!
//! Textures are sampled with mip levels. The level follows from the change in texture coordinates to the next
//! pixel. A GPU takes that from the other pixels of a 2 × 2 quad; here the rays of those pixels are
//! intersected with the triangle's plane.

use rayon::prelude::*;

use crate::trace::Hit;
use adumbra::grid::vec3::{cross, dot};
use adumbra_scene::View;
use adumbra_scene::{MippedTexture, Scene};

/// The colours of a scene, prepared for look-ups from any number of threads.
#[derive(Debug)]
pub struct BaseColors<'s> {
    scene: &'s Scene,
    textures: Vec<MippedTexture<'s>>,
}

/// A triangle's plane, with the map from points on it to texture coordinates.
struct UvPlane {
    p_world: [f64; 3],
    normal: [f64; 3],
    /// Gradients of u and v in world space: the dot product with the offset from `p_world` gives the change
    /// in u or v.
    gradients: [[f64; 3]; 2],
}

impl<'s> BaseColors<'s> {
    /// Builds the mip levels of all textures on the current rayon pool. Cost: that of [`MippedTexture::new`]
    /// for each texture.
    pub fn new(scene: &'s Scene) -> Self {
        Self { scene, textures: scene.textures.par_iter().map(MippedTexture::new).collect() }
    }

    /// Memory for a scene's colours in addition to the scene itself, bytes.
    pub fn bytes_of(scene: &Scene) -> u64 {
        scene.textures.iter().map(MippedTexture::bytes_of).sum()
    }

    /// Linear base colour at `hit`, which the ray through the centre of pixel (x, y) produced. Cost: eight
    /// texels if there is a texture.
    pub fn at(&self, view: &View, pixel: [u32; 2], hit: &Hit) -> [f64; 3] {
        let material = &self.scene.materials[hit.material as usize];
        let mesh = &self.scene.meshes[self.scene.instances[hit.instance as usize].mesh as usize];
        let corners = mesh.corner_colors(hit.triangle).map(|c| c.map(f64::from));
        let texel = material.texture.map_or([1.0; 3], |t| {
            let texture = &self.textures[t as usize];
            let level = self.uv_differences(view, pixel, hit).map_or(0.0, |d| texture.level(d));
            texture.color(hit.uv, level)
        });
        std::array::from_fn(|a| {
            let vertex: f64 = (0..3).map(|c| hit.barycentric[c] * corners[c][a]).sum();
            f64::from(material.base_color[a] * texel[a]) * vertex
        })
    }

    /// Differences of the texture coordinates across the pixel's quad, along its row and along its column;
    /// `None` for a degenerate triangle.
    fn uv_differences(&self, view: &View, [x, y]: [u32; 2], hit: &Hit) -> Option<[[f64; 2]; 2]> {
        let plane = self.uv_plane(hit)?;
        let uv = |x: u32, y: u32| {
            let (origin, direction) = view.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
            plane.uv_on_ray(origin, direction)
        };
        let [left, right] = [uv(x & !1, y), uv(x | 1, y)];
        let [top, bottom] = [uv(x, y & !1), uv(x, y | 1)];
        Some([[0, 1].map(|k| right[k] - left[k]), [0, 1].map(|k| bottom[k] - top[k])])
    }

    fn uv_plane(&self, hit: &Hit) -> Option<UvPlane> {
        let instance = &self.scene.instances[hit.instance as usize];
        let mesh = &self.scene.meshes[instance.mesh as usize];
        let corners = mesh.triangles[hit.triangle as usize];
        let [a, b, c] = corners.map(|v| instance.to_world(mesh.positions[v as usize]));
        let edge = |to: [f64; 3]| std::array::from_fn::<f64, 3, _>(|k| to[k] - a[k]);
        let (ab, ac) = (edge(b), edge(c));
        let normal = cross(ab, ac);
        let squared = dot(normal, normal);
        // A point of the plane is a + s ab + t ac with s = (ac x n) · offset / n², t = (n x ab) · offset /
        // n².
        let (for_s, for_t) = (cross(ac, normal), cross(normal, ab));
        let uv = mesh.corner_uvs(hit.triangle).map(|uv| uv.map(f64::from));
        let gradients = [0, 1].map(|k| {
            let (along_ab, along_ac) = (uv[1][k] - uv[0][k], uv[2][k] - uv[0][k]);
            std::array::from_fn(|i| (along_ab * for_s[i] + along_ac * for_t[i]) / squared)
        });
        (squared > 0.0).then_some(UvPlane { p_world: a, normal, gradients })
    }
}

impl UvPlane {
    /// Texture coordinates where a ray's line meets the plane, minus those of `p_world`.
    fn uv_on_ray(&self, origin: [f64; 3], direction: [f64; 3]) -> [f64; 2] {
        let way: [f64; 3] = std::array::from_fn(|k| origin[k] - self.p_world[k]);
        let t = -dot(way, self.normal) / dot(direction, self.normal);
        let to: [f64; 3] = std::array::from_fn(|k| way[k] + t * direction[k]);
        self.gradients.map(|gradient| dot(gradient, to))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::{Ray, TraceOptions, Tracer};
    use adumbra_scene::{Camera, Projection};
    use adumbra_scene::{GeneratedKind, generate};

    #[test]
    fn uv_differences_match_the_neighbouring_hits() {
        let mut scene = generate(GeneratedKind::Primitives, 1);
        for mesh in &mut scene.meshes {
            mesh.uvs =
                mesh.positions.iter().map(|p| [0.3 * p[0] + 0.1 * p[1], 0.2 * p[2] - 0.4 * p[1]]).collect();
        }
        let tracer = Tracer::build(&scene, TraceOptions::default());
        let colors = BaseColors::new(&scene);
        let bounds = scene.bounds();
        for projection in
            [Projection::Perspective { fov_degrees: 50.0 }, Projection::Orthographic { height_world: 9.0 }]
        {
            let camera = Camera { width: 160, height: 120, projection, ..Camera::overview(&bounds, 50.0) };
            let view = camera.view();
            let hit = |x: u32, y: u32| {
                let (origin, direction) = view.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
                tracer.nearest_surface(&Ray { origin, direction, t_min: 0.0, t_max: f64::INFINITY })
            };
            let mut compared = 0;
            for (x, y) in (0..120).flat_map(|y| (0..160).map(move |x| (x, y))) {
                let (Some(here), Some(right), Some(below)) = (hit(x, y), hit(x ^ 1, y), hit(x, y ^ 1)) else {
                    continue;
                };
                let of = |h: &Hit| (h.instance, h.triangle);
                if of(&here) != of(&right) || of(&here) != of(&below) {
                    continue;
                }
                let [along_x, along_y] = colors.uv_differences(&view, [x, y], &here).unwrap();
                for k in 0..2 {
                    let between = |a: &Hit, b: &Hit| (f64::from(b.uv[k]) - f64::from(a.uv[k])).abs();
                    assert!((along_x[k].abs() - between(&here, &right)).abs() < 1e-4);
                    assert!((along_y[k].abs() - between(&here, &below)).abs() < 1e-4);
                }
                compared += 1;
            }
            assert!(compared > 300, "{compared}");
        }
    }

    #[test]
    fn vertex_colours_multiply_in_linear_light() {
        let mut scene = generate(GeneratedKind::Primitives, 1);
        for mesh in &mut scene.meshes {
            mesh.colors = vec![[188, 255, 0, 255]; mesh.positions.len()];
        }
        let tracer = Tracer::build(&scene, TraceOptions::default());
        let camera = Camera { width: 8, height: 8, ..Camera::overview(&scene.bounds(), 50.0) };
        let (origin, direction) = camera.view().ray(4.5, 4.5);
        let ray = Ray { origin, direction, t_min: 0.0, t_max: f64::INFINITY };
        let hit = tracer.nearest_surface(&ray).unwrap();
        let plain = scene.materials[hit.material as usize].base_color;
        let color = BaseColors::new(&scene).at(&camera.view(), [4, 4], &hit);
        let expected = [0.5, 1.0, 0.0].map(f64::from);
        for a in 0..3 {
            assert!((color[a] - expected[a] * f64::from(plain[a])).abs() < 0.004, "{color:?}");
        }
    }
}
