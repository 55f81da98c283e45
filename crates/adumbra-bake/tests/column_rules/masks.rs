//! Floors under cards with holes that are finer than a texel: they get the light that the holes let through.

use adumbra::Sun;
use adumbra_bake::{BakeOptions, ColumnBuilder, FrameChoice, Size};
use adumbra_scene::{AlphaMode, Material, Pixels, Texture, Wrap};

use super::model::{Model, Point, bake_quietly, lit_on_ground, scene};

const VOXEL: f64 = 0.1;
/// Half the side of the card.
const HALF: f32 = 4.0;

/// Every fourth texel along the longer side of a texture is clear. A texel of the grid covers 4.3 texture
/// texels along the longer side, and 0.006 along the other.
#[test]
fn floor_under_a_striped_card_gets_the_clear_share_of_light() {
    const LONG: u32 = 64;
    let overhead = Sun::from_direction([0.0, 1.0, 0.0]).unwrap();
    for [width, height] in [[LONG, 2], [2, LONG]] {
        let (mut floor, mut card) = (Model::default(), Model::default());
        floor.level_square(1.5 * f64::from(HALF), 0.0);
        card.level_square(HALF.into(), 3.0);
        let mut scene = scene(&[floor, card]);
        let card = &mut scene.meshes[1];
        let uv = |&[x, _, z]: &[f32; 3]| {
            // 80 texels of the grid.
            let along =
                |c: f32, size: u32| c / (2.0 * HALF) * if size == LONG { 80.0 * 4.3 / 64.0 } else { 0.25 };
            [along(x, width), along(z, height)]
        };
        card.uvs = card.positions.iter().map(uv).collect();
        card.triangle_materials.fill(1);
        let alpha = |texel: u32| {
            let along = if width == LONG { texel % width } else { texel / width };
            if along % 4 == 0 { 0 } else { 255 }
        };
        let pixels = Pixels::Alpha((0..width * height).map(alpha).collect());
        let wrap = [Wrap::Repeat; 2];
        scene.textures.push(Texture {
            name: "stripes".to_owned(),
            width,
            height,
            pixels,
            wrap,
            nearest: true,
        });
        let alpha = AlphaMode::Mask { cutoff: 0.5 };
        scene.materials.push(Material { texture: Some(0), alpha, ..Material::opaque("stripes", [1.0; 4]) });
        let middle = |n: i32| VOXEL * (f64::from(n) + 0.5);
        let points: Vec<Point> =
            (-30..30).flat_map(|x| (-30..30).map(move |z| [middle(x), 0.0, middle(z)])).collect();
        for builder in [ColumnBuilder::Fast, ColumnBuilder::Plain] {
            let frame = FrameChoice::ObliqueAt(0.0);
            let options = BakeOptions::new(overhead, Size::VoxelSize(VOXEL)).with(|o| {
                o.builder = builder;
                o.frame = frame;
            });
            let lit = lit_on_ground(&bake_quietly(&scene, &options), &points);
            let share = lit as f64 / points.len() as f64;
            // Stripes and texels alias: of thirteen texels in a row, three or four are on a clear stripe.
            assert!((share - 0.25).abs() < 0.05, "{width} x {height}, {builder:?}: {share}");
        }
    }
}
