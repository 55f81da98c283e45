//! Tells where a texture with holes is opaque or clear throughout, without sampling it point by point.
//!
//! A bilinear sample is between the smallest and the largest alpha of four texels. So each cell between four texel
//! centres is opaque, clear, or mixed. A pyramid over the cells answers for any rectangle from at most nine of them.
//! Opacity micromaps of ray tracing hardware distinguish the same three states.

use std::collections::HashMap;

use adumbra_scene::{AlphaMode, Pixels, Scene, Texture, Wrap};

/// A cell with opaque points.
const OPAQUE: u8 = 1;
/// A cell with clear points.
const CLEAR: u8 = 2;

/// Coordinates beyond this are not looked up: their fractions are too coarse.
const LARGEST_COORDINATE: f64 = 4096.0;
/// Relative error of a sample's texture coordinates.
const RELATIVE_ERROR: f64 = 1.0 / (1 << 21) as f64;
/// Their error in texels, apart from that.
const ERROR_TEXELS: f64 = 1.0 / 256.0;

/// The pyramids of a scene's materials.
#[derive(Default)]
pub(crate) struct OpacityPyramids {
    /// Index into `pyramids` for each material; `None` for those without holes.
    of_material: Vec<Option<usize>>,
    pyramids: Vec<OpacityPyramid>,
}

impl OpacityPyramids {
    /// Builds the pyramids of all materials. Those that cut the same texture at the same alpha share one.
    pub(crate) fn new(scene: &Scene) -> Self {
        let mut found = HashMap::new();
        let mut pyramids = Vec::new();
        let of_material = (0..scene.materials.len() as u32).map(|material| {
            let m = &scene.materials[material as usize];
            let (AlphaMode::Mask { .. }, Some(texture)) = (m.alpha, m.texture) else { return None };
            let opaque_from = least_opaque_byte(scene, material);
            Some(*found.entry((texture, opaque_from)).or_insert_with(|| {
                pyramids.push(OpacityPyramid::new(&scene.textures[texture as usize], opaque_from));
                pyramids.len() - 1
            }))
        });
        Self { of_material: of_material.collect(), pyramids }
    }

    /// Returns a material's pyramid, or `None` if it has no texture with holes.
    pub(crate) fn of(&self, material: u32) -> Option<&OpacityPyramid> {
        self.of_material.get(material as usize)?.map(|pyramid| &self.pyramids[pyramid])
    }

    /// Bytes held.
    pub(crate) fn memory_bytes(&self) -> u64 {
        let levels = self.pyramids.iter().flat_map(|pyramid| &pyramid.levels);
        levels.map(|level| level.states.capacity() as u64).sum()
    }
}

/// Where a texture is opaque for materials that cut it at one alpha.
pub(crate) struct OpacityPyramid {
    /// Texels along u and v.
    size: [u32; 2],
    wrap: [Wrap; 2],
    /// Position of the first texel's border in the first cell, cells.
    offset: f64,
    /// The finest first. A cell of a coarser level covers 2 × 2 of the level before.
    levels: Vec<Level>,
}

/// States of cells: [`OPAQUE`], [`CLEAR`] or both.
struct Level {
    width: usize,
    states: Vec<u8>,
}

impl OpacityPyramid {
    /// Returns the pyramid of a texture whose texels are opaque from an alpha of `opaque_from` on, 0 to 255. Cost: one
    /// pass over the texture.
    fn new(texture: &Texture, opaque_from: u32) -> Self {
        let size = [texture.width, texture.height];
        // A bilinear sample may be up to half a texel outside the outermost centres.
        let (cells, offset) = if texture.nearest { (size, 0.0) } else { (size.map(|s| s + 1), 0.5) };
        let [width, height] = cells.map(|c| c as usize);
        let mut states = Vec::with_capacity(width * height);
        for y in 0..cells[1] {
            for x in 0..cells[0] {
                let axes = [(x, 0), (y, 1)].map(|(cell, axis)| texels_of_cell(cell, texture, axis));
                let corners = axes[1].into_iter().flat_map(|j| axes[0].map(|i| alpha_byte(texture, i, j)));
                let state = |alpha: u8| if u32::from(alpha) >= opaque_from { OPAQUE } else { CLEAR };
                states.push(corners.map(state).fold(0, |all, state| all | state));
            }
        }
        let mut levels = vec![Level { width, states }];
        while let Some(last) = levels.last().filter(|level| level.states.len() > 1) {
            let coarser = last.halved();
            levels.push(coarser);
        }
        Self { size, wrap: texture.wrap, offset, levels }
    }

    /// Returns whether a material with opaque vertices is opaque or clear at all texture coordinates in these ranges of
    /// u and v. `None`: it is neither, or not known.
    pub(crate) fn opacity(&self, ranges: [[f64; 2]; 2]) -> Option<bool> {
        let [[left, right], [top, bottom]] = [self.cells(0, ranges[0])?, self.cells(1, ranges[1])?];
        let extent = (right - left).max(bottom - top);
        let shift = (usize::BITS - extent.leading_zeros()).saturating_sub(1);
        let level = self.levels.get(shift as usize)?;
        let mut found = 0;
        for y in top >> shift..=bottom >> shift {
            for x in left >> shift..=right >> shift {
                found |= level.states[y * level.width + x];
            }
        }
        match found {
            OPAQUE => Some(true),
            CLEAR => Some(false),
            _ => None,
        }
    }

    /// Returns the first and the last cell in which samples within a range of coordinates may be, or `None` if the
    /// texture begins again within it.
    fn cells(&self, axis: usize, [low, high]: [f64; 2]) -> Option<[usize; 2]> {
        let size = f64::from(self.size[axis]);
        // Neither holds if it is not a number.
        if !(low >= -LARGEST_COORDINATE && high <= LARGEST_COORDINATE) {
            return None;
        }
        let largest = low.abs().max(high.abs());
        let error = largest * RELATIVE_ERROR + ERROR_TEXELS / size;
        let [low, high] = [low - error, high + error];
        let [low, high] = match self.wrap[axis] {
            Wrap::Clamp => [low.clamp(0.0, 1.0), high.clamp(0.0, 1.0)],
            Wrap::Repeat | Wrap::Mirror => {
                let period = low.floor();
                if high >= period + 1.0 {
                    return None;
                }
                let [low, high] = [low - period, high - period];
                let is_mirrored = self.wrap[axis] == Wrap::Mirror && period.rem_euclid(2.0) == 1.0;
                if is_mirrored { [1.0 - high, 1.0 - low] } else { [low, high] }
            }
        };
        let last = self.levels[0].cells(axis) - 1;
        let cell = |c: f64| ((c * size + self.offset) as usize).min(last);
        Some([cell(low), cell(high)])
    }
}

impl Level {
    /// Returns the number of cells along an axis.
    fn cells(&self, axis: usize) -> usize {
        [self.width, self.states.len() / self.width][axis]
    }

    fn halved(&self) -> Self {
        let [width, height] = [0, 1].map(|axis| self.cells(axis));
        let mut halved =
            Self { width: width.div_ceil(2), states: vec![0; width.div_ceil(2) * height.div_ceil(2)] };
        for (at, state) in self.states.iter().enumerate() {
            let [x, y] = [at % width, at / width];
            halved.states[y / 2 * halved.width + x / 2] |= state;
        }
        halved
    }
}

/// Returns the least alpha in a texture, 0 to 255, at which the material is opaque; 256 if there is none. By the
/// arithmetic of [`Scene::is_opaque`].
fn least_opaque_byte(scene: &Scene, material: u32) -> u32 {
    let m = &scene.materials[material as usize];
    let AlphaMode::Mask { cutoff } = m.alpha else { return 0 };
    (0..=u8::MAX).find(|&byte| m.base_color[3] * (f32::from(byte) / 255.0) >= cutoff).map_or(256, u32::from)
}

/// Returns the texels between which a cell lies along an axis.
fn texels_of_cell(cell: u32, texture: &Texture, axis: usize) -> [u32; 2] {
    if texture.nearest {
        return [cell; 2];
    }
    let last = [texture.width, texture.height][axis] - 1;
    match (texture.wrap[axis], cell) {
        (Wrap::Repeat, 0) => [last, 0],
        (Wrap::Repeat, cell) if cell > last => [last, 0],
        (_, cell) => [cell.saturating_sub(1), cell.min(last)],
    }
}

fn alpha_byte(texture: &Texture, x: u32, y: u32) -> u8 {
    let texel = y as usize * texture.width as usize + x as usize;
    let byte = match &texture.pixels {
        Pixels::Alpha(bytes) => bytes.get(texel),
        Pixels::Rgba(bytes) => bytes.get(texel * 4 + 3),
    };
    byte.copied().unwrap_or(u8::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use adumbra_scene::Material;
    use proptest::prelude::*;

    fn scene(size: [u32; 2], alphas: &[u8], wrap: [Wrap; 2], nearest: bool, cutoff: f32) -> Scene {
        let pixels = Pixels::Alpha(alphas.to_vec());
        let texture = Texture { name: "t".into(), width: size[0], height: size[1], pixels, wrap, nearest };
        let material = Material {
            alpha: AlphaMode::Mask { cutoff },
            texture: Some(0),
            ..Material::opaque("m", [1.0, 1.0, 1.0, 0.9])
        };
        Scene { materials: vec![material], textures: vec![texture], ..Scene::default() }
    }

    fn wraps() -> impl Strategy<Value = Wrap> {
        prop_oneof![Just(Wrap::Repeat), Just(Wrap::Mirror), Just(Wrap::Clamp)]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        /// Samples random points of a rectangle and its corners, which are often on texel borders.
        #[test]
        fn what_is_said_to_be_opaque_or_clear_is_so_at_every_point(
            size in [1_u32..9, 1_u32..9],
            alphas in prop::collection::vec(prop_oneof![Just(0_u8), Just(255), any::<u8>()], 64),
            wrap in [wraps(), wraps()],
            nearest in any::<bool>(),
            cutoff in 0.05_f32..1.0,
            low in [-20_i32..20, -20_i32..20],
            extent in [0.0_f64..1.5, 0.0_f64..1.5],
            points in prop::collection::vec([0.0_f64..1.0, 0.0_f64..1.0], 40),
        ) {
            let alphas = &alphas[..(size[0] * size[1]) as usize];
            let scene = scene(size, alphas, wrap, nearest, cutoff);
            let pyramids = OpacityPyramids::new(&scene);
            let pyramid = pyramids.of(0).expect("a texture");
            let low = low.map(|l| f64::from(l) / 8.0);
            let ranges = [0, 1].map(|a| [low[a], low[a] + extent[a]]);
            let Some(opaque) = pyramid.opacity(ranges) else { return Ok(()) };
            let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
            for point in points.into_iter().chain(corners) {
                let uv = [0, 1].map(|a| (low[a] + point[a] * extent[a]) as f32);
                prop_assert_eq!(scene.is_opaque(0, uv, 1.0), opaque, "at {:?}", uv);
            }
        }
    }

    #[test]
    fn uniform_parts_are_found_at_every_scale() {
        // The left half is opaque.
        let alphas: Vec<u8> = (0..64 * 64).map(|t| if t % 64 < 32 { 255 } else { 0 }).collect();
        for nearest in [false, true] {
            let scene = scene([64, 64], &alphas, [Wrap::Repeat; 2], nearest, 0.5);
            let pyramids = OpacityPyramids::new(&scene);
            let pyramid = pyramids.of(0).expect("a texture");
            for side in [0.0, 0.01, 0.1, 0.2] {
                let over = |u: f64| pyramid.opacity([[u, u + side], [0.3, 0.3 + side]]);
                assert_eq!(
                    [over(3.15), over(-0.35), over(0.5 - side / 2.0)],
                    [Some(true), Some(false), None]
                );
            }
            // Across the border at which the texture begins again.
            assert_eq!(pyramid.opacity([[0.9, 1.1], [0.5, 0.5]]), None);
            for not_finite in [[f64::NAN, 0.1], [0.1, f64::NAN], [f64::NAN; 2], [f64::NEG_INFINITY, 0.1]] {
                assert_eq!(pyramid.opacity([not_finite, [0.5, 0.5]]), None);
            }
        }
    }

    #[test]
    fn only_textures_with_holes_have_a_pyramid() {
        let mut scene = scene([1, 1], &[9], [Wrap::Clamp; 2], false, 0.5);
        scene.materials[0].alpha = AlphaMode::Opaque;
        assert!(OpacityPyramids::new(&scene).of(0).is_none());
        scene.materials[0] =
            Material { alpha: AlphaMode::Mask { cutoff: 0.5 }, ..Material::opaque("m", [1.0; 4]) };
        assert!(OpacityPyramids::new(&scene).of(0).is_none());
    }

    #[test]
    fn materials_that_cut_a_texture_alike_share_a_pyramid() {
        let mut scene = scene([8, 8], &[9; 64], [Wrap::Clamp; 2], false, 0.5);
        let masked = scene.materials[0].clone();
        scene.materials.extend([masked.clone(), masked]);
        let one = OpacityPyramids::new(&scene);
        scene.materials[2].alpha = AlphaMode::Mask { cutoff: 0.01 };
        let two = OpacityPyramids::new(&scene);
        assert_eq!(2 * one.memory_bytes(), two.memory_bytes());
        let opacities = [0, 1, 2].map(|m| two.of(m).and_then(|p| p.opacity([[0.2, 0.6]; 2])));
        assert_eq!(opacities, [Some(false), Some(false), Some(true)]);
    }
}
