//! Bias and voxel PCF: acne and leak counts, and the paper's pictures (Fig. 4-1, 4-3, 4-5, 4-6, 5-1).

use std::fmt::Write as _;

use adumbra::{Bias, LightGrid, PointVisibility, Sun};
use adumbra_bake::Size;
use adumbra_program::output::write_png;
use adumbra_scene::Camera;
use adumbra_tree::query::{TreeQuery, Weights};
use adumbra_tree::{BakedTree, TreeOptions, VoxelTree};
use adumbra_truth::picture;
use adumbra_truth::picture::{Picture, Shadows};
use adumbra_truth::verify::{Answers, Class, Promises, TreeAnswers};

use super::document::{FilterRow, Part};
use super::{BenchScene, Check, SUN, bake_quietly, tree_options};
use crate::Result;
use crate::args::BenchTree;

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
            let answers = Ablated::new(&baked, sun, variant)?;
            let v = check.run(&answers);
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
        eprintln!("{}: filters and sheets", scene.name);
    }
    Ok(rows)
}

/// A look-up of one kind, classified and compared at the points to which the usual bias moves the receivers.
struct Ablated<'a> {
    query: TreeQuery<'a, VoxelTree>,
    usual: TreeAnswers<'a, VoxelTree>,
}

impl<'a> Ablated<'a> {
    fn new(baked: &'a BakedTree, sun: Sun, variant: &Variant) -> Result<Self> {
        let usual = baked.settings.bias;
        let query = |bias, side, weights| {
            TreeQuery::new(&baked.space, &baked.regions, &sun, &baked.tree, bias, side, weights)
        };
        let bias = if variant.biased { usual } else { NO_BIAS };
        let asked = query(bias, variant.kernel_side, variant.weights)?;
        Ok(Self {
            query: if variant.all_taps { asked.with_all_taps() } else { asked },
            usual: TreeAnswers::new(&baked.settings, sun, query(usual, 1, Weights::Mean)?),
        })
    }
}

impl Answers for Ablated<'_> {
    fn visibility(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> f32 {
        self.query.visibility(p_world, normal)
    }

    fn towards_sun(&self) -> [f64; 3] {
        self.usual.towards_sun()
    }

    fn grid_at(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> LightGrid {
        self.usual.grid_at(p_world, normal)
    }

    fn bias(&self) -> Bias {
        self.usual.bias()
    }

    fn baked_bias(&self) -> Bias {
        self.usual.baked_bias()
    }

    fn covers(&self, p_world: [f64; 3]) -> bool {
        self.usual.covers(p_world)
    }

    fn insides_are_free(&self) -> bool {
        self.usual.insides_are_free()
    }

    fn promises(&self) -> Promises {
        self.usual.promises()
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
        let answers = Ablated::new(baked, sun, variant)?;
        let lookup: &dyn PointVisibility = &answers.query;
        let shadows = Shadows::File(lookup);
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
    let mut text = format!(
        "\n## Bias and voxel PCF\n\nDepth {DEPTH}, {} points on surfaces. Acne: lit points called shadowed \
        (visibility at most one half). Leak: shadowed points called lit. Both are in % of all points, and \
        counted among interior points, which are two voxels away from any outline. *In front of the plane*: taps \
        behind the receiver's plane are skipped, as in `query` and `render`. The sheets `tree-sheet-*.png` \
        (depth 8 and 10) show no bias, bias, 3³ / 5³, bias with 5³ in front of the plane, and rays; in those \
        named `-grazing`, the sun is at {GRAZING_ELEVATION}°.\n\n\
        | scene | look-up | agreement % | acne % | leak % | interior acne | interior leak | interior points |\n|---|---|---|---|---|---|---|---|\n",
        part.samples
    );
    for r in &part.rows {
        let _ = writeln!(
            text,
            "| {} | {} | {:.3} | {:.3} | {:.3} | {} | {} | {} |",
            r.scene,
            r.look_up,
            100.0 * r.agreement,
            100.0 * r.acne,
            100.0 * r.leak,
            r.interior_acne,
            r.interior_leak,
            r.interior,
        );
    }
    text
}
