//! Bias and voxel PCF: acne and leak counts, and the paper's pictures (Fig. 4-1, 4-3, 4-5, 4-6, 5-1).

use adumbra::{Bias, Sun};
use adumbra_bake::Size;
use adumbra_papers::tree::TreeAnswers;
use adumbra_papers::tree::query::{TreeQuery, Weights};
use adumbra_papers::tree::{BakedTree, TreeOptions, VoxelTree};
use adumbra_program::output::write_png;
use adumbra_scene::Camera;
use adumbra_truth::picture;
use adumbra_truth::picture::{Picture, Shadows};
use adumbra_truth::verify::{Answers, Class, Replaced};

use super::results::{FilterRow, Part};
use super::{BenchScene, Check, SUN, bake_quietly, tree_options, unfiltered};
use crate::args::BenchTree;
use adumbra_compare::Result;
use adumbra_html::page::Table;
use adumbra_program::format::percent;

const NO_BIAS: Bias = Bias { constant_texels: 0.0, slope_texels: 0.0, normal_offset_texels: 0.0 };
/// Depth of the counts.
const DEPTH: u32 = 10;
/// Scenes with picture sheets, and the depth of each at which voxels are visible.
const SHEETS: [(&str, u32); 2] = [("primitives", 8), ("landscape", 10)];
/// Elevation of the sun in the grazing sheets, degrees.
const GRAZING_ELEVATION: f64 = 8.0;
/// Size of one picture of a sheet in pixels.
const CELL: [u32; 2] = [480, 320];

/// One kind of look-up.
struct Variant {
    name: &'static str,
    biased: bool,
    kernel_side: u32,
    weights: Weights,
    /// Whether taps behind the receiver's plane count too.
    all_taps: bool,
}

const fn variant(
    name: &'static str,
    biased: bool,
    kernel_side: u32,
    weights: Weights,
    all_taps: bool,
) -> Variant {
    Variant { name, biased, kernel_side, weights, all_taps }
}

const VARIANTS: [Variant; 9] = [
    variant("no bias, no filter", false, 1, Weights::Mean, true),
    variant("bias", true, 1, Weights::Mean, true),
    variant("3³, no bias", false, 3, Weights::Mean, true),
    variant("5³, no bias", false, 5, Weights::Mean, true),
    variant("bias, 3³", true, 3, Weights::Mean, true),
    variant("bias, 5³", true, 5, Weights::Mean, true),
    variant("bias, 3³ in front of the plane", true, 3, Weights::Mean, false),
    variant("bias, 5³ in front of the plane", true, 5, Weights::Mean, false),
    variant("bias, 5³ in front of the plane, Poisson", true, 5, Weights::Poisson, false),
];
/// Indices into [`VARIANTS`] of a sheet's pictures, row by row. The picture by rays comes last.
const SHEET: [usize; 5] = [0, 1, 2, 3, 7];

pub(super) fn measure(args: &BenchTree, scenes: &[BenchScene]) -> Result<Vec<FilterRow>> {
    let mut rows = Vec::new();
    for scene in scenes {
        let sun = Sun::from_direction(SUN)?;
        let baked = bake_quietly(scene, &tree_options(DEPTH)?)?;
        let check = Check::new(&scene.scene, args.samples);
        for variant in &VARIANTS {
            let query = variant.query(&baked, sun)?;
            // Classify and compare the points of every variant at receivers moved by the usual bias.
            let usual = TreeAnswers::new(&baked.settings, sun, unfiltered(&baked, sun)?);
            let visibility = |_: &TreeAnswers<'_, _>, p, normal| query.visibility(p, normal);
            let v = check.run(&Replaced { answers: usual, visibility, covers: Answers::covers });
            let interior = v.class(Class::Interior);
            rows.push(FilterRow {
                scene: scene.name.clone(),
                depth: DEPTH,
                look_up: variant.name.to_owned(),
                agreement: v.agreement,
                acne: v.acne,
                leak: v.leak,
                interior: interior.points,
                interior_acne: interior.acne,
                interior_leak: interior.leak,
            });
        }
        if let Some((_, depth)) = SHEETS.iter().find(|(name, _)| *name == scene.name) {
            let low = Sun::from_angles(55.0, GRAZING_ELEVATION)?;
            for (sun, suffix) in [(sun, ""), (low, "-grazing")] {
                let baked = bake_quietly(scene, &TreeOptions::new(sun, Size::Resolution(1 << depth)))?;
                sheet(args, scene, &check, &baked, sun, &format!("{}{suffix}", scene.name))?;
            }
        }
        adumbra_program::note!("{}: filters and sheets", scene.name);
    }
    Ok(rows)
}

impl Variant {
    fn query<'a>(&self, baked: &'a BakedTree, sun: Sun) -> Result<TreeQuery<'a, VoxelTree>> {
        let bias = if self.biased { baked.settings.bias } else { NO_BIAS };
        let (space, regions, tree) = (&baked.space, &baked.regions, &baked.tree);
        let query = TreeQuery::new(space, regions, &sun, tree, bias, self.kernel_side, self.weights)?;
        Ok(if self.all_taps { query.with_all_taps() } else { query })
    }
}

/// Draws six pictures in two rows: no bias, bias, 3³; then 5³, bias with 5³ before the plane, rays.
fn sheet(
    args: &BenchTree,
    scene: &BenchScene,
    check: &Check<'_>,
    baked: &BakedTree,
    sun: Sun,
    name: &str,
) -> Result<()> {
    let mut camera = Camera::overview(&scene.scene.bounds(), 40.0);
    [camera.width, camera.height] = CELL;
    // Closer than a view of the whole scene, so that voxels are visible.
    camera.eye = std::array::from_fn(|a| camera.target[a] + 0.45 * (camera.eye[a] - camera.target[a]));
    let mut pictures = Vec::new();
    for variant in SHEET.map(|i| &VARIANTS[i]) {
        let query = variant.query(baked, sun)?;
        let shadows = Shadows::File(&query);
        pictures.push(picture::draw(&scene.scene, &check.tracer, &camera, sun.towards(), &shadows, 2));
    }
    let truth = Shadows::Truth;
    pictures.push(picture::draw(&scene.scene, &check.tracer, &camera, sun.towards(), &truth, 2));
    Ok(write_png(&args.output.join(format!("tree-sheet-{name}.png")), &beside(&pictures, 3))?)
}

/// Arranges pictures of equal size in rows.
fn beside(pictures: &[Picture], columns: usize) -> Picture {
    let [width, height] = CELL.map(|c| c as usize);
    let rows = pictures.len().div_ceil(columns);
    let mut rgb = vec![255; width * columns * height * rows * 3];
    for (i, picture) in pictures.iter().enumerate() {
        let (x, y) = (i % columns * width, i / columns * height);
        for row in 0..height {
            let to = ((y + row) * width * columns + x) * 3;
            let from = row * width * 3;
            rgb[to..to + width * 3].copy_from_slice(&picture.rgb[from..from + width * 3]);
        }
    }
    Picture { width: (width * columns) as u32, height: (height * rows) as u32, rgb, difference_share: None }
}

pub(super) fn markdown(part: &Part<Vec<FilterRow>>) -> String {
    let table = Table::of(
        "",
        &part.rows,
        &[
            ("scene", |r| r.scene.clone()),
            ("look-up", |r| r.look_up.clone()),
            ("agreement %", |r| percent(r.agreement, 3)),
            ("acne %", |r| percent(r.acne, 3)),
            ("leak %", |r| percent(r.leak, 3)),
            ("interior acne", |r| r.interior_acne.to_string()),
            ("interior leak", |r| r.interior_leak.to_string()),
            ("interior points", |r| r.interior.to_string()),
        ],
    );
    format!(
        "\n## Bias and voxel PCF\n\nDepth {DEPTH}, {} points on surfaces. Acne: lit points called shadowed \
        (visibility at most one half). Leak: shadowed points called lit. Both are in % of all points, and \
        counted among interior points, which are two voxels away from any outline. *In front of the plane*: taps \
        behind the receiver's plane are skipped, as in `query` and `render`. The sheets `tree-sheet-*.png` \
        (depth 8 and 10) show no bias, bias, 3³ / 5³, bias with 5³ in front of the plane, and rays; in those \
        named `-grazing`, the sun is at {GRAZING_ELEVATION}°.\n\n{}",
        part.samples,
        table.markdown()
    )
}
