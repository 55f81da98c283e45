//! Textures with holes in the form that the fast builder needs: exact samples, many at a time.
//!
//! A bilinear sample is a mean of four texels. So the plane is cut into cells between four texel centres, and
//! a table of the cells' corners, with those beyond the texture's borders, serves any wrap mode.

mod sample;

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use adumbra_scene::{AlphaMode, Material, Pixels, Scene, Texture, Wrap};

/// Texels along an axis, and corners in all, that a table may have: their numbers are exact in the arithmetic
/// of samples.
const MOST_TEXELS: u32 = 1 << 22;
const MOST_CORNERS: u64 = 1 << 31;

/// The tables of a scene's materials.
#[derive(Default)]
pub(crate) struct OpacityTables {
    /// Index into `tables` for each material; `None` for those without holes in a texture.
    of_material: Vec<Option<usize>>,
    tables: Vec<OpacityTable>,
    corner_bytes: u64,
}

impl OpacityTables {
    /// Builds the tables of all materials. Materials that cut the same texture at the same alpha share a
    /// table, and all materials that cut it share its corners. If the corners would take more than
    /// `most_bytes`, no tables are built.
    pub(crate) fn new(scene: &Scene, most_bytes: u64) -> Self {
        let cut = cut_textures(scene);
        let textures: HashSet<u32> = cut.iter().flatten().map(|&(number, _)| number).collect();
        let needed_bytes: u64 = textures.iter().map(|&n| corner_count(&scene.textures[n as usize])).sum();
        if needed_bytes > most_bytes {
            return Self::default();
        }
        let corners: HashMap<u32, Arc<[u8]>> =
            textures.into_iter().map(|n| (n, corners(&scene.textures[n as usize]))).collect();
        let mut found = HashMap::new();
        let mut tables = Vec::new();
        let of_material = cut.into_iter().map(|cut| {
            let (number, opaque_from) = cut?;
            Some(*found.entry((number, opaque_from.to_bits())).or_insert_with(|| {
                let corners = Arc::clone(&corners[&number]);
                tables.push(OpacityTable::new(&scene.textures[number as usize], corners, opaque_from));
                tables.len() - 1
            }))
        });
        Self { of_material: of_material.collect(), tables, corner_bytes: needed_bytes }
    }

    /// Returns a material's table, or `None` if it has no texture with holes.
    pub(crate) fn of(&self, material: u32) -> Option<&OpacityTable> {
        self.of_material.get(material as usize)?.map(|table| &self.tables[table])
    }

    /// Bytes held.
    pub(crate) fn memory_bytes(&self) -> u64 {
        self.corner_bytes + (self.tables.capacity() * size_of::<OpacityTable>()) as u64
    }
}

/// Where a texture is opaque for materials that cut it at one alpha and have opaque vertices.
pub(crate) struct OpacityTable {
    /// Texels along u and v.
    size: [u32; 2],
    wrap: [Wrap; 2],
    nearest: bool,
    /// Alpha at the corners of cells, row by row; `width` of them in a row. Cell c is between corners c and
    /// c + 1, and corner c is the centre of texel c - 1. With nearest filtering, cell c is texel c, and so is
    /// corner c.
    corners: Arc<[u8]>,
    width: usize,
    /// The least sample, 0 to 255, that is opaque; infinity if none is.
    opaque_from: f32,
}

impl OpacityTable {
    fn new(texture: &Texture, corners: Arc<[u8]>, opaque_from: f32) -> Self {
        let size = [texture.width, texture.height];
        let width = corner_dims(texture)[0] as usize;
        Self { size, wrap: texture.wrap, nearest: texture.nearest, corners, width, opaque_from }
    }
}

/// Returns the texture of each material with holes, and the least sample of it that is opaque.
fn cut_textures(scene: &Scene) -> Vec<Option<(u32, f32)>> {
    let cut = |material: &Material| {
        let (AlphaMode::Mask { cutoff }, Some(number)) = (material.alpha, material.texture) else {
            return None;
        };
        let texture = &scene.textures[number as usize];
        if texture.width.max(texture.height) > MOST_TEXELS || corner_count(texture) > MOST_CORNERS {
            return None;
        }
        Some((number, least_opaque_sample(material.base_color[3], cutoff)?))
    };
    scene.materials.iter().map(cut).collect()
}

/// Returns the number of corners along u and v.
fn corner_dims(texture: &Texture) -> [u32; 2] {
    [texture.width, texture.height].map(|side| if texture.nearest { side + 1 } else { side + 2 })
}

fn corner_count(texture: &Texture) -> u64 {
    corner_dims(texture).map(u64::from).iter().product()
}

/// Returns the alpha at a texture's corners. Cost: one pass over it.
fn corners(texture: &Texture) -> Arc<[u8]> {
    let [width, height] = corner_dims(texture);
    let rows = (0..height).map(|y| texel_of_corner(y, texture, 1));
    rows.flat_map(|row| (0..width).map(move |x| alpha_byte(texture, texel_of_corner(x, texture, 0), row)))
        .collect()
}

/// Returns the least sample of a texture, 0 to 255, at which a material with opaque vertices is opaque, or
/// infinity if there is none, by the arithmetic of [`Scene::is_opaque`]. Returns `None` if more alpha may be
/// less opaque.
fn least_opaque_sample(alpha_factor: f32, cutoff: f32) -> Option<f32> {
    let is_opaque = |sample: f32| alpha_factor * (sample / 255.0) >= cutoff;
    if !(alpha_factor >= 0.0) {
        return None;
    }
    // Positive numbers are ordered like their bits.
    let (mut low, mut high) = (0, 255_f32.to_bits());
    if !is_opaque(f32::from_bits(high)) {
        return Some(f32::INFINITY);
    }
    while low < high {
        let middle = low + (high - low) / 2;
        if is_opaque(f32::from_bits(middle)) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    Some(f32::from_bits(low))
}

/// Returns the texel at a corner of cells along an axis.
fn texel_of_corner(corner: u32, texture: &Texture, axis: usize) -> u32 {
    let last = [texture.width, texture.height][axis].saturating_sub(1);
    match (texture.nearest, texture.wrap[axis]) {
        (true, _) => corner.min(last),
        (false, Wrap::Repeat) if corner == 0 => last,
        (false, Wrap::Repeat) if corner > last + 1 => 0,
        (false, _) => corner.saturating_sub(1).min(last),
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

    /// Coordinates of points that are often on texel borders.
    fn points() -> impl Strategy<Value = Vec<[f32; 2]>> {
        let coordinate = prop_oneof![
            (-96_i32..96).prop_map(|c| c as f32 / 16.0),
            -3.0_f32..3.0,
            prop::num::f32::ANY,
            prop_oneof![Just(-1e-9_f32), Just(1.0 - f32::EPSILON), Just(5e6), Just(-16_777_217.5)],
        ];
        prop::collection::vec([coordinate.clone(), coordinate], 8)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]

        #[test]
        fn table_samples_equal_scene_samples(
            size in [1_u32..9, 1_u32..9],
            alphas in prop::collection::vec(prop_oneof![Just(0_u8), Just(255), any::<u8>()], 64),
            wrap in [wraps(), wraps()],
            nearest in any::<bool>(),
            cutoff in prop_oneof![0.0_f32..1.0, (0_u8..=255).prop_map(|byte| 0.9 * (f32::from(byte) / 255.0))],
            points in points(),
        ) {
            let alphas = &alphas[..(size[0] * size[1]) as usize];
            let scene = scene(size, alphas, wrap, nearest, cutoff);
            let tables = OpacityTables::new(&scene, u64::MAX);
            let table = tables.of(0).expect("a texture");
            let expected = (0..8).fold(0, |bits, i| bits | u8::from(scene.is_opaque(0, points[i], 1.0)) << i);
            let along = |axis: usize| std::array::from_fn(|i| points[i][axis]);
            prop_assert_eq!(table.opaque_at([along(0), along(1)]), expected, "{:?}", points);
        }
    }

    #[test]
    fn the_least_opaque_sample_is_the_first_that_passes_the_cut_off() {
        for (factor, cutoff) in [(1.0, 0.5), (0.9, 0.3), (0.7, 0.1), (1.0, 1.0), (1.0, 0.0), (0.3, 0.2999)] {
            let least = least_opaque_sample(factor, cutoff).expect("a factor of at least 0");
            let is_opaque = |sample: f32| factor * (sample / 255.0) >= cutoff;
            assert!(is_opaque(least), "{factor} {cutoff}: {least}");
            assert!(least == 0.0 || !is_opaque(least.next_down()), "{factor} {cutoff}: {least}");
        }
        assert_eq!(least_opaque_sample(0.4, 0.5), Some(f32::INFINITY));
        assert_eq!(least_opaque_sample(-1.0, 0.5), None);
        assert_eq!(least_opaque_sample(f32::NAN, 0.5), None);
    }

    #[test]
    fn only_textures_with_holes_have_a_table() {
        let mut scene = scene([1, 1], &[9], [Wrap::Clamp; 2], false, 0.5);
        scene.materials[0].alpha = AlphaMode::Opaque;
        assert!(OpacityTables::new(&scene, u64::MAX).of(0).is_none());
        scene.materials[0] =
            Material { alpha: AlphaMode::Mask { cutoff: 0.5 }, ..Material::opaque("m", [1.0; 4]) };
        assert!(OpacityTables::new(&scene, u64::MAX).of(0).is_none());
    }

    #[test]
    fn materials_that_cut_a_texture_alike_share_a_table() {
        let mut scene = scene([8, 8], &[9; 64], [Wrap::Clamp; 2], false, 0.5);
        let masked = scene.materials[0].clone();
        scene.materials.extend([masked.clone(), masked]);
        let one = OpacityTables::new(&scene, 100);
        scene.materials[2].alpha = AlphaMode::Mask { cutoff: 0.01 };
        let two = OpacityTables::new(&scene, 100);
        // 10 x 10 corners, whatever the number of cuts.
        assert!(
            one.corner_bytes == 100
                && two.corner_bytes == 100
                && [one.tables.len(), two.tables.len()] == [1, 2]
        );
        assert!(Arc::ptr_eq(&two.tables[0].corners, &two.tables[1].corners));
        assert!(OpacityTables::new(&scene, 99).of(0).is_none());
        let opacities = [0, 1, 2].map(|m| two.of(m).map(|t| t.opaque_at([[0.4; 8]; 2])));
        assert_eq!(opacities, [Some(0), Some(0), Some(u8::MAX)]);
    }
}
