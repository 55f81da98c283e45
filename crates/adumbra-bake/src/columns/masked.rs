//! Surfaces with holes: which part of a texel they cover, and when a texel counts as covered.
//!
//! Departure from the specification, which takes a single sample at the texel's centre: if a texture's holes are finer
//! than a texel, the centre alone gives a random answer. A masked surface is sampled at 4 × 4 points of the texel.
//! Coverage is accumulated over the layers from the light on, and the column begins where half of the points are
//! covered. A texture that is coarser than the texels is sampled once.

use crate::columns::rules::FirstSurface;
use crate::triangles::opacity::{OpacityTable, OpacityTables, Uniform, Window};
use crate::triangles::project::{FixedDepth, Plane, Projected};
use crate::triangles::surface::Surface;
use adumbra::grid::LightGrid;
use adumbra_scene::Scene;

/// Sample points of a texel along each axis.
const PLACES: u32 = 4;
/// Number of sample points that must be covered: half.
const COVERED_PLACES: u32 = PLACES * PLACES / 2;
/// A texel that covers less than this many texels of the texture is sampled at its centre only.
const COARSE_TEXTURE_TEXELS: f64 = 0.5;
/// A texel that covers less than this many texels of the texture counts as uniform if its four corner points agree.
const CORNERS_TELL_TEXELS: f64 = 4.0;
/// Bits of the four corner points.
const CORNERS: u16 = 0x9009;
/// How far the sample points of a texel reach from its centre along each axis, texels.
pub(crate) const PLACES_REACH: f64 = 0.5 - 0.5 / PLACES as f64;

/// A masked surface over one texel, as a word that sorts by texel, then like [`FirstSurface`].
///
/// | bits | meaning |
/// |---|---|
/// | 111..80 | texel |
/// | 79..48 | depth plus 2^31 |
/// | 47..16 | [`FirstSurface::info`] |
/// | 15..0 | sample points covered |
///
/// Worked value: an open surface without a bias that covers the first point of texel 2 at depth 3 is
/// `0x2_8000_0003_8000_0000_0001`.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct MaskedHit(u128);

impl MaskedHit {
    #[inline(always)]
    pub(crate) fn new(texel: usize, depth: FixedDepth, info: u32, covered: u16) -> Self {
        let high = u64::from(texel as u32) << 32 | u64::from(depth as u32 ^ 1 << 31);
        Self(u128::from(high) << 48 | u128::from(info) << 16 | u128::from(covered))
    }

    fn texel(self) -> usize {
        (self.0 >> 80) as usize
    }

    fn first(self) -> FirstSurface {
        FirstSurface::new(((self.0 >> 48) as u32 ^ 1 << 31) as FixedDepth, (self.0 >> 16) as u32)
    }

    fn covered(self) -> u16 {
        self.0 as u16
    }
}

/// Whether these sample points are enough for a texel to be covered.
#[inline(always)]
pub(crate) fn is_enough(covered: u16) -> bool {
    covered.count_ones() >= COVERED_PLACES
}

/// Calls `add(texel, surface)` with the masked surface at which half of a texel is covered, at most once per texel.
pub(crate) fn add_first_surfaces(hits: &mut [MaskedHit], mut add: impl FnMut(usize, FirstSurface)) {
    hits.sort_unstable();
    for texel in hits.chunk_by(|a, b| a.texel() == b.texel()) {
        let mut covered = 0_u16;
        for hit in texel {
            covered |= hit.covered();
            if is_enough(covered) {
                add(hit.texel(), hit.first());
                break;
            }
        }
    }
}

/// The opaque part of a masked triangle: texture coordinates and vertex alpha as planes over grid x and y.
#[derive(Clone, Debug)]
pub(crate) struct TriangleMask {
    material: u32,
    u: Plane,
    v: Plane,
    /// `None` if all corners are opaque.
    vertex_alpha: Option<Plane>,
    /// Number of texture texels that a texel of the light's plane covers, along the longer axis.
    extent_texels: f64,
}

impl TriangleMask {
    /// Returns `None` for a triangle that is edge-on to the light.
    pub(crate) fn new(scene: &Scene, grid: &LightGrid, surface: &Surface) -> Option<Self> {
        let instance = &scene.instances[surface.instance as usize];
        let mesh = &scene.meshes[instance.mesh as usize];
        let corners = mesh.triangles[surface.triangle as usize];
        let corners_grid = corners.map(|v| grid.to_grid(instance.to_world(mesh.positions[v as usize])));
        let uv = mesh.corner_uvs(surface.triangle);
        let plane = |a: usize| Projected::attribute_plane(&corners_grid, uv.map(|c| f64::from(c[a])));
        let (u, v) = (plane(0)?, plane(1)?);
        let alphas = mesh.corner_alphas(surface.triangle);
        let vertex_alpha = match alphas == [1.0; 3] {
            true => None,
            false => Some(Projected::attribute_plane(&corners_grid, alphas.map(f64::from))?),
        };
        let material = mesh.triangle_materials[surface.triangle as usize];
        let size = scene.materials[material as usize].texture.map_or([1, 1], |t| {
            let texture = &scene.textures[t as usize];
            [texture.width, texture.height]
        });
        let extent = |p: &Plane, texels: u32| (p.gradient[0].abs() + p.gradient[1].abs()) * f64::from(texels);
        let extent_texels = extent(&u, size[0]).max(extent(&v, size[1]));
        Some(Self { material, u, v, vertex_alpha, extent_texels })
    }

    /// Returns the table of the texture, or `None` if it has none or is not all that decides opacity.
    pub(crate) fn table<'t>(&self, tables: &'t OpacityTables) -> Option<&'t OpacityTable> {
        if self.vertex_alpha.is_some() { None } else { tables.of(self.material) }
    }

    /// Returns whether all points of a rectangle around `center` are opaque, or all are clear. `None`: neither, or not
    /// known. `half` is half its width and its height, texels.
    #[inline(always)]
    pub(crate) fn uniform_within(
        &self,
        table: &OpacityTable,
        [x, y]: [f64; 2],
        half: [f64; 2],
    ) -> Option<bool> {
        let reach = |p: &Plane| p.gradient[0].abs() * half[0] + p.gradient[1].abs() * half[1];
        let window = table.window([reach(&self.u), reach(&self.v)])?;
        let found = table.uniform(&[[self.u.at(x, y) as f32], [self.v.at(x, y) as f32]], &window);
        (found.opaque | found.clear != 0).then_some(found.opaque != 0)
    }

    /// Returns the window of a texel's sample points, for [`Self::row_coverage`].
    #[inline(always)]
    pub(crate) fn texel_window(&self, table: &OpacityTable) -> Option<Window> {
        table.window([self.u.gradient_sum() * PLACES_REACH, self.v.gradient_sum() * PLACES_REACH])
    }

    /// Returns [`Self::coverage`] of the `wanted` ones of eight texels in a row, given the columns' centres and the row's.
    #[inline(always)]
    pub(crate) fn row_coverage(
        &self,
        table: &OpacityTable,
        window: &Option<Window>,
        wanted: u16,
        columns: &[f64; 8],
        row: f64,
    ) -> [u16; 8] {
        let centers = [rounded(&self.u.along(columns, row)), rounded(&self.v.along(columns, row))];
        let mut covered = [0; 8];
        if self.extent_texels < COARSE_TEXTURE_TEXELS {
            let opaque = table.opaque_at(centers);
            for (i, covered) in covered.iter_mut().enumerate() {
                *covered = (opaque >> i & 1).wrapping_neg();
            }
            return covered;
        }
        let uniform = match window {
            Some(window) => table.uniform(&centers, window),
            None => Uniform::default(),
        };
        for (i, covered) in covered.iter_mut().enumerate() {
            *covered = (uniform.opaque >> i & 1).wrapping_neg();
            if (wanted & !uniform.opaque & !uniform.clear) >> i & 1 == 1 {
                *covered = self.coverage_by(table, [columns[i], row]);
            }
        }
        covered
    }

    /// Returns [`Self::coverage`] of a texture that is not coarse.
    #[inline(always)]
    fn coverage_by(&self, table: &OpacityTable, [x, y]: [f64; 2]) -> u16 {
        let mut at = [[0.0; (PLACES * PLACES) as usize]; 2];
        for (at, plane) in at.iter_mut().zip([&self.u, &self.v]) {
            for (place, c) in (0..).zip(at) {
                *c = plane.at(x + offset(place % PLACES), y + offset(place / PLACES)) as f32;
            }
        }
        let places = table.opaque_at(at);
        match places & CORNERS {
            0 if self.extent_texels < CORNERS_TELL_TEXELS => 0,
            CORNERS if self.extent_texels < CORNERS_TELL_TEXELS => u16::MAX,
            _ => places,
        }
    }

    /// Returns which sample points of the texel around (x, y) are opaque: bit = row · 4 + column.
    pub(crate) fn coverage(&self, scene: &Scene, [x, y]: [f64; 2]) -> u16 {
        if self.extent_texels < COARSE_TEXTURE_TEXELS {
            return if self.opaque_at(scene, x, y) { u16::MAX } else { 0 };
        }
        let places = |wanted: u16| {
            (0..PLACES * PLACES).filter(|place| wanted >> place & 1 == 1).fold(0, |bits, place| {
                let opaque = self.opaque_at(scene, x + offset(place % PLACES), y + offset(place / PLACES));
                bits | u16::from(opaque) << place
            })
        };
        match places(CORNERS) {
            0 if self.extent_texels < CORNERS_TELL_TEXELS => 0,
            CORNERS if self.extent_texels < CORNERS_TELL_TEXELS => u16::MAX,
            corners => corners | places(!CORNERS),
        }
    }

    fn opaque_at(&self, scene: &Scene, x: f64, y: f64) -> bool {
        let vertex_alpha = self.vertex_alpha.as_ref().map_or(1.0, |plane| plane.at(x, y) as f32);
        scene.is_opaque(self.material, [self.u.at(x, y) as f32, self.v.at(x, y) as f32], vertex_alpha)
    }
}

#[inline(always)]
fn rounded(along: &[f64; 8]) -> [f32; 8] {
    let mut rounded = [0.0; 8];
    for (rounded, c) in rounded.iter_mut().zip(along) {
        *rounded = *c as f32;
    }
    rounded
}

/// Returns how far the sample points of this row or column are from the texel's centre, texels.
#[inline(always)]
fn offset(place: u32) -> f64 {
    (f64::from(place) + 0.5) / f64::from(PLACES) - 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use adumbra_scene::{AlphaMode, Material, Pixels, Texture, Wrap};
    use proptest::prelude::*;

    /// A triangle's mask, with a texture of random texels.
    fn masks() -> impl Strategy<Value = (Scene, TriangleMask)> {
        let wrap = || prop_oneof![Just(Wrap::Repeat), Just(Wrap::Mirror), Just(Wrap::Clamp)];
        let gradient =
            || prop_oneof![-0.02_f64..0.02, -0.5_f64..0.5, (-8_i32..8).prop_map(|g| f64::from(g) / 16.0)];
        let alpha = prop_oneof![3 => Just(0_u8), 3 => Just(255), 1 => any::<u8>()];
        let texture =
            (1_u32..12, 1_u32..12, prop::collection::vec(alpha, 144), [wrap(), wrap()], any::<bool>());
        let planes = prop::array::uniform2((-2.0_f64..2.0, gradient(), gradient()));
        (texture, planes, 0.05_f32..1.0, 0_u32..4).prop_map(|(texture, planes, cutoff, blur)| {
            let (width, height, mut alphas, wrap, nearest) = texture;
            // Runs of equal texels, so that some rectangles are uniform.
            for t in 0..alphas.len() {
                alphas[t] = alphas[t >> blur << blur];
            }
            let pixels = Pixels::Alpha(alphas[..(width * height) as usize].to_vec());
            let material = Material {
                alpha: AlphaMode::Mask { cutoff },
                texture: Some(0),
                ..Material::opaque("m", [1.0, 1.0, 1.0, 0.9])
            };
            let texture = Texture { name: "t".into(), width, height, pixels, wrap, nearest };
            let scene = Scene { materials: vec![material], textures: vec![texture], ..Scene::default() };
            let corners = [[0.0, 0.0, 0.0], [8.0, 0.0, 0.0], [0.0, 8.0, 0.0]];
            let [u, v] = planes.map(|(at, gx, gy)| {
                let values = [at, at + 8.0 * gx, at + 8.0 * gy];
                Projected::attribute_plane(&corners, values).expect("three corners that are not on a line")
            });
            let extent = |p: &Plane, texels: u32| p.gradient_sum() * f64::from(texels);
            let extent_texels = extent(&u, width).max(extent(&v, height));
            (scene, TriangleMask { material: 0, u, v, vertex_alpha: None, extent_texels })
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]

        /// The tables answer as samples one by one do, for texels and for rectangles of them.
        #[test]
        fn tables_cover_what_samples_cover((scene, mask) in masks(), wanted in any::<u8>(), size in [1_usize..9, 1_usize..9]) {
            let tables = OpacityTables::new(&scene);
            let table = mask.table(&tables).expect("a texture");
            let columns: [f64; 8] = std::array::from_fn(|i| i as f64 + 0.5);
            let window = mask.texel_window(table);
            let mut all = Vec::new();
            for row in 0..size[1] {
                let y = row as f64 + 0.5;
                let found = mask.row_coverage(table, &window, u16::from(wanted), &columns, y);
                for (i, &x) in columns.iter().enumerate() {
                    let expected = mask.coverage(&scene, [x, y]);
                    if wanted >> i & 1 == 1 {
                        prop_assert_eq!(found[i], expected, "texel {}, {}", i, row);
                    }
                    if i < size[0] {
                        all.push(expected);
                    }
                }
            }
            let half = size.map(|s| s as f64 / 2.0);
            let reach = half.map(|h| h - 0.5 + PLACES_REACH);
            if let Some(opaque) = mask.uniform_within(table, half, reach) {
                let expected = if opaque { u16::MAX } else { 0 };
                prop_assert!(all.iter().all(|&covered| covered == expected), "{opaque}: {all:x?}");
            }
        }
    }

    #[test]
    fn a_hit_is_the_word_in_the_table() {
        let hit = MaskedHit::new(2, 3, 1 << 31, 1);
        assert_eq!(hit.0, 0x2_8000_0003_8000_0000_0001);
        assert_eq!((hit.texel(), hit.first().depth(), hit.first().info(), hit.covered()), (2, 3, 1 << 31, 1));
        assert!(MaskedHit::new(2, -3, 5, u16::MAX) < hit && hit < MaskedHit::new(3, FixedDepth::MIN, 0, 0));
    }

    #[test]
    fn masked_layers_count_together_from_the_light_on() {
        let hit = |depth, covered| MaskedHit::new(0, depth, 1 << 31, covered);
        // A quarter, the same quarter again, another quarter: half is reached at the third.
        let mut hits = [hit(900, 0x0f00), hit(300, 0x000f), hit(600, 0x000f), hit(1200, u16::MAX)];
        let mut found = Vec::new();
        add_first_surfaces(&mut hits, |texel, first| found.push((texel, first.depth())));
        assert_eq!(found, [(0, 900)]);
        // Less than half.
        add_first_surfaces(&mut hits[..2], |texel, first| panic!("{texel}: {first:?}"));
    }
}
