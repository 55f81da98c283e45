//! Surfaces with holes: where a column meets one.
//!
//! A masked surface covers a texel where it is opaque at the texel's centre, as in the specification. So it
//! lets as much light through as the same shape would as geometry, however fine the holes are. A majority
//! over the texel's area would be less noisy where holes are finer than a texel. But it would make mostly
//! covered surfaces opaque, and sparsely covered surfaces clear.

use crate::triangles::depth::{Plane, plane_through};
use crate::triangles::opacity::{OpacityTable, OpacityTables};
use crate::triangles::surface::Surface;
use adumbra::grid::LightGrid;
use adumbra_scene::Scene;

/// The opaque part of a masked triangle: texture coordinates and vertex alpha as planes over grid x and y.
#[derive(Clone, Debug)]
pub(crate) struct TriangleMask {
    material: u32,
    u: Plane,
    v: Plane,
    /// The least and the largest texture coordinates of the corners, as [u, v].
    low: [f32; 2],
    high: [f32; 2],
    /// `None` if all corners are opaque.
    vertex_alpha: Option<Plane>,
}

impl TriangleMask {
    /// Returns `None` for a triangle that is edge-on to the light.
    pub(crate) fn new(scene: &Scene, grid: &LightGrid, surface: &Surface) -> Option<Self> {
        let instance = &scene.instances[surface.instance as usize];
        let mesh = &scene.meshes[instance.mesh as usize];
        let corners = mesh.triangles[surface.triangle as usize];
        let corners_grid = corners.map(|v| grid.to_grid(instance.to_world(mesh.positions[v as usize])));
        let uv = mesh.corner_uvs(surface.triangle);
        let alphas = mesh.corner_alphas(surface.triangle);
        let material = mesh.triangle_materials[surface.triangle as usize];
        Self::on(&corners_grid, uv, alphas, material)
    }

    fn on(corners_grid: &[[f64; 3]; 3], uv: [[f32; 2]; 3], alphas: [f32; 3], material: u32) -> Option<Self> {
        let plane = |values: [f32; 3]| plane_through(corners_grid, values.map(f64::from));
        let [us, vs] = [0, 1].map(|axis| uv.map(|corner| corner[axis]));
        let vertex_alpha = if alphas == [1.0; 3] { None } else { Some(plane(alphas)?) };
        Some(Self {
            material,
            u: plane(us)?,
            v: plane(vs)?,
            low: [us, vs].map(|values| values.into_iter().fold(f32::INFINITY, f32::min)),
            high: [us, vs].map(|values| values.into_iter().fold(f32::NEG_INFINITY, f32::max)),
            vertex_alpha,
        })
    }

    /// Returns the opacity table of the texture, or `None` if there is none, or if vertex alpha also decides
    /// opacity.
    pub(crate) fn table<'t>(&self, tables: &'t OpacityTables) -> Option<&'t OpacityTable> {
        if self.vertex_alpha.is_some() { None } else { tables.of(self.material) }
    }

    /// Returns which of eight points of a row are opaque, one bit each.
    #[inline(always)]
    pub(crate) fn opaque_along(&self, table: &OpacityTable, x: &[f64; 8], y: f64) -> u8 {
        let within = |plane: &Plane, axis: usize| {
            let mut coordinates = [0.0; 8];
            for (rounded, c) in coordinates.iter_mut().zip(plane.along(x, y)) {
                *rounded = self.within_corners(axis, c);
            }
            coordinates
        };
        table.opaque_at([within(&self.u, 0), within(&self.v, 1)])
    }

    /// Returns whether a point is opaque.
    pub(crate) fn is_opaque(&self, scene: &Scene, [x, y]: [f64; 2]) -> bool {
        let vertex_alpha = self.vertex_alpha.as_ref().map_or(1.0, |plane| plane.at(x, y) as f32);
        let uv = [self.within_corners(0, self.u.at(x, y)), self.within_corners(1, self.v.at(x, y))];
        scene.is_opaque(self.material, uv, vertex_alpha)
    }

    /// Rounds a texture coordinate, and clamps it to the range of the corners. Snapping may have moved a
    /// point beyond an edge, to another part of the texture; on a triangle that is almost edge-on, to any
    /// part.
    #[inline(always)]
    fn within_corners(&self, axis: usize, coordinate: f64) -> f32 {
        (coordinate as f32).max(self.low[axis]).min(self.high[axis])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use adumbra_scene::{AlphaMode, Material, Pixels, Texture, Wrap};
    use proptest::prelude::*;

    /// Scenes with one material, whose texture has random texels.
    fn textures() -> impl Strategy<Value = Scene> {
        let wrap = || prop_oneof![Just(Wrap::Repeat), Just(Wrap::Mirror), Just(Wrap::Clamp)];
        let alpha = prop_oneof![3 => Just(0_u8), 3 => Just(255), 1 => any::<u8>()];
        let texels = prop::collection::vec(alpha, 144);
        (1_u32..12, 1_u32..12, texels, [wrap(), wrap()], any::<bool>(), 0.05_f32..1.0).prop_map(
            |(width, height, alphas, wrap, nearest, cutoff)| {
                let pixels = Pixels::Alpha(alphas[..(width * height) as usize].to_vec());
                let material = Material {
                    alpha: AlphaMode::Mask { cutoff },
                    texture: Some(0),
                    ..Material::opaque("m", [1.0, 1.0, 1.0, 0.9])
                };
                let texture = Texture { name: "t".into(), width, height, pixels, wrap, nearest };
                Scene { materials: vec![material], textures: vec![texture], ..Scene::default() }
            },
        )
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]

        /// Compares table look-ups with single samples, on the triangle and beyond it.
        #[test]
        fn opacity_of_rows_equals_opacity_of_points(
            scene in textures(), corners in prop::array::uniform3(prop::array::uniform2(-4.0_f64..12.0)),
            uv in prop::array::uniform3(prop::array::uniform2(-2.0_f32..2.0)),
        ) {
            let corners = corners.map(|[x, y]| [x, y, 0.0]);
            let Some(mask) = TriangleMask::on(&corners, uv, [1.0; 3], 0) else { return Ok(()) };
            let tables = OpacityTables::new(&scene, u64::MAX);
            let table = mask.table(&tables).expect("a texture");
            let columns: [f64; 8] = std::array::from_fn(|i| i as f64 + 0.5);
            for row in 0..8 {
                let y = f64::from(row) + 0.5;
                let expected = (0..8).fold(0, |bits, i| bits | u8::from(mask.is_opaque(&scene, [columns[i], y])) << i);
                prop_assert_eq!(mask.opaque_along(table, &columns, y), expected, "row {}", row);
            }
        }
    }

    #[test]
    fn no_part_of_the_texture_beyond_the_corners_is_sampled() {
        // The left half of the texture is clear.
        let texture = Texture {
            name: "t".into(),
            width: 2,
            height: 1,
            pixels: Pixels::Alpha(vec![0, 255]),
            wrap: [Wrap::Repeat; 2],
            nearest: true,
        };
        let cut = Material {
            alpha: AlphaMode::Mask { cutoff: 0.5 },
            texture: Some(0),
            ..Material::opaque("cut", [1.0; 4])
        };
        let scene = Scene { materials: vec![cut], textures: vec![texture], ..Scene::default() };
        // Almost edge-on: half of the texture is squeezed into a thousandth of a texel.
        let corners = [[4.0, 0.0, 0.0], [4.001, 0.0, 9.0], [4.0, 8.0, 0.0]];
        let mask = TriangleMask::on(&corners, [[0.01, 0.0], [0.49, 0.0], [0.01, 1.0]], [1.0; 3], 0).unwrap();
        let tables = OpacityTables::new(&scene, u64::MAX);
        let columns: [f64; 8] = std::array::from_fn(|i| 4.0 + (i as f64 - 4.0) / 256.0);
        assert_eq!(mask.opaque_along(mask.table(&tables).unwrap(), &columns, 0.5), 0);
        assert!(columns.iter().all(|&x| !mask.is_opaque(&scene, [x, 0.5])));
    }
}
