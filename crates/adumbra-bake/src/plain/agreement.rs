//! Compares the fast builder with the plain one: its intervals are within the plain builder's everywhere, its
//! first surfaces are equal wherever it draws, and its depths are consistent with the plain columns.

use std::sync::atomic::AtomicBool;

use crate::choose;
use crate::columns::Columns;
use crate::columns::capture::{CaptureBuffers, capture};
use crate::columns::{BLOCK_SIDE, BlockColumns};
use crate::fast::descent::{DescentBuffers, build_root};
use crate::options::{AssumeGround, BakeOptions, Size};
use crate::plan::Plan;
use crate::sink::BlockSink;
use crate::test_bakes::bake_depths;
use crate::triangles::surface::BinSurfaces;
use adumbra::Receivers;
use adumbra::grid::Sun;
use adumbra_scene::{GeneratedKind, LoadOptions, Scene, generate, load};

/// A sink that keeps the descent's results in the order of traversal.
struct Found;

enum Piece {
    Uniform { level: u32, interval: [u32; 2] },
    Leaf(Box<BlockColumns>),
}

impl BlockSink for Found {
    type Block = Vec<Piece>;

    fn uniform(&self, level: u32, interval: [u32; 2]) -> Vec<Piece> {
        vec![Piece::Uniform { level, interval }]
    }

    fn leaf(&self, columns: &BlockColumns) -> Vec<Piece> {
        vec![Piece::Leaf(Box::new(columns.clone()))]
    }

    fn known(&self, _number: usize) -> Option<Vec<Piece>> {
        None
    }

    fn join(&self, _level: u32, quarters: [Vec<Piece>; 4]) -> Vec<Piece> {
        quarters.into_iter().flatten().collect()
    }

    fn taken(&self, _number: usize, block: Vec<Piece>) -> Vec<Piece> {
        block
    }
}

/// Calls `visit([x, y], [e, x], drawn)` for every texel of a root block.
fn for_each_found(
    level: u32,
    corner: [u32; 2],
    pieces: &mut impl Iterator<Item = Piece>,
    next: &mut Option<Piece>,
    visit: &mut impl FnMut([u32; 2], [u32; 2], bool),
) {
    let piece_level = match next {
        Some(Piece::Uniform { level, .. }) => *level,
        Some(Piece::Leaf(_)) => 3,
        None => panic!("the pieces end before the block"),
    };
    if piece_level < level {
        let half = 1 << (level - 1);
        for q in 0..4_u32 {
            let quarter = [corner[0] + (q >> 1) * half, corner[1] + (q & 1) * half];
            for_each_found(level - 1, quarter, pieces, next, visit);
        }
        return;
    }
    let side = 1_u32 << level;
    for y in 0..side {
        for x in 0..side {
            let (interval, drawn) = match next {
                Some(Piece::Leaf(c)) => {
                    let i = y as usize * BLOCK_SIDE + x as usize;
                    ([c.e[i], c.x[i]], true)
                }
                Some(Piece::Uniform { interval, .. }) => (*interval, false),
                None => unreachable!("looked at above"),
            };
            visit([corner[0] + x, corner[1] + y], interval, drawn);
        }
    }
    *next = pieces.next();
}

/// A column as found by both builders.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Column {
    /// Texel of the grid.
    pub(crate) at: [u32; 2],
    /// `[e, x]` of the plain builder.
    pub(crate) plain: [u32; 2],
    /// `[e, x]` of the fast builder.
    pub(crate) fast: [u32; 2],
    /// Whether the fast builder drew it.
    pub(crate) drawn: bool,
}

impl Column {
    /// Whether the fast builder's interval is within the plain one, with the same first surface if it was
    /// drawn.
    pub(crate) fn agrees(&self) -> bool {
        let ([e, x], [fast_e, fast_x]) = (self.plain, self.fast);
        e <= fast_e && fast_e <= fast_x && fast_x <= x && (!self.drawn || fast_e == e)
    }
}

/// Buffers that are reused from one root block to the next.
#[derive(Default)]
pub(crate) struct BothBuffers {
    descent: DescentBuffers,
    capture: CaptureBuffers,
    columns: Columns,
}

/// Calls `visit` with every column of a root block. The plan must have no switch limit.
pub(crate) fn for_each_column(
    plan: &Plan<'_>,
    root_block: usize,
    buffers: &mut BothBuffers,
    mut visit: impl FnMut(Column),
) {
    assert_eq!(plan.root_blocks.limit.within_voxels, 0, "the columns would be cut");
    let BothBuffers { descent, capture: captured, columns } = buffers;
    let pieces = build_root(&plan.root_blocks, root_block, &Found, descent, &AtomicBool::new(false))
        .expect("nothing interrupts");
    let surfaces =
        BinSurfaces { casters: &plan.root_blocks.casters, bin: root_block, grid: &plan.root_blocks.grid };
    let rect = plan.root_blocks.rect(root_block);
    capture(&surfaces, &plan.root_blocks.rules, rect, captured, columns);
    let mut pieces = pieces.into_iter();
    let mut next = pieces.next();
    for_each_found(
        plan.root_blocks.root_level,
        [0, 0],
        &mut pieces,
        &mut next,
        &mut |[x, y], fast, drawn| {
            if x < rect.width && y < rect.height {
                let texel = (y * rect.width + x) as usize;
                let plain = [columns.e[texel], columns.x[texel]];
                visit(Column { at: [rect.x + x, rect.y + y], plain, fast, drawn });
            }
        },
    );
    assert!(next.is_none(), "pieces are left behind the block's last");
}

/// Compares every `step`-th root block. Returns the number of drawn texels and the total number of texels.
fn assert_agreement(name: &str, scene: &Scene, options: &BakeOptions, step: usize) -> [u64; 2] {
    let plan = choose::plan(scene, options).expect("the scene fits");
    let depths = bake_depths(scene, options, true).expect("the scene fits").0;
    let layers = plan.root_blocks.grid.size[2];
    let mut buffers = BothBuffers::default();
    let (mut counts, mut shorter) = ([0, 0], 0);
    for root_block in (0..plan.root_blocks.count()).step_by(step) {
        for_each_column(&plan, root_block, &mut buffers, |column| {
            let Column { at: [i, j], plain, fast, drawn } = column;
            counts[0] += u64::from(drawn);
            counts[1] += 1;
            assert!(column.agrees(), "{name}: {column:?}");
            shorter += u64::from(drawn && fast[1] < plain[1]);
            let switch = depths.value(i, j).min(layers);
            assert!(switch >= plain[0], "{name}: ({i}, {j}) switches at {switch}, before {plain:?}");
            assert!(
                plain[1] >= layers || switch <= plain[1],
                "{name}: ({i}, {j}) switches at {switch}, behind {plain:?}"
            );
        });
    }
    // A surface that is known to be behind a block is assumed to be behind each of its columns, which may
    // shorten intervals.
    assert!(shorter * 20 <= counts[0], "{name}: {shorter} of {} drawn columns have less freedom", counts[0]);
    counts
}

fn sun(towards: [f64; 3]) -> Sun {
    Sun::from_direction(towards).expect("a sun above the horizon")
}

#[test]
#[ignore = "slow: real scenes; one of seven, all with ADUMBRA_FULL"]
fn shared_scenes_have_the_same_columns_in_both_builders() {
    let Some(folder) = adumbra_testing::shared("scenes") else { return };
    let mut names: Vec<_> = std::fs::read_dir(&folder)
        .expect("a folder")
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| [".glb", ".obj", ".ply"].iter().any(|ending| name.ends_with(ending)))
        .collect();
    names.sort();
    assert!(names.len() > 10);
    for (n, name) in names.iter().enumerate() {
        if n % 7 != 0 && !adumbra_testing::full() {
            continue;
        }
        let scene = load(&folder.join(name), &LoadOptions::default()).expect("a good scene");
        let towards = if name.starts_with("jacksboro") { [-0.77, 0.105, -0.63] } else { [0.5, 0.8, 0.35] };
        let options = BakeOptions {
            thickness_world: [0.0, 0.1][n % 2],
            ..BakeOptions::new(sun(towards), Size::Resolution(4096))
        };
        // A prime step visits every row and column of root blocks.
        let step = if adumbra_testing::full() { 1 } else { 61 };
        let [drawn, all] = assert_agreement(name, &scene, &options, step);
        eprintln!("{name}: {:.1} % of texels drawn", 100.0 * drawn as f64 / all as f64);
    }
}

#[test]
fn small_scenes_have_the_same_columns_in_both_builders() {
    let options = BakeOptions::new(sun([0.5, 0.8, 0.35]), Size::Resolution(512));
    assert_agreement("city", &generate(GeneratedKind::City, 3), &options, 7);
    // Six trees with masked leaves, and no ground.
    let mut trees = generate(GeneratedKind::Forest, 1);
    trees.instances.retain(|instance| instance.name.starts_with("tree"));
    trees.instances.truncate(6);
    let options =
        BakeOptions { thickness_world: 0.1, ..BakeOptions::new(options.sun, Size::Resolution(256)) };
    let [drawn, _] = assert_agreement("trees", &trees, &options, 1);
    assert!(drawn > 1000, "{drawn} texels are drawn");
}

/// A ray crosses hundreds of surfaces. Some boxes overlap others, share planes with them, or have no bottom,
/// so that rays never leave them.
#[test]
fn nested_boxes_have_the_same_columns_in_both_builders() {
    let boxes = (0..60_u8).map(|i| {
        let inset = 0.1 * f32::from(i);
        let [min, max] = [[-8.0 + inset, 0.0, -8.0 + inset], [8.0 - inset, 9.0 - inset, 8.0 - 0.5 * inset]];
        let mut mesh = adumbra_testing::cuboid(min, if i % 5 == 0 { [max[0], 9.0, max[2]] } else { max });
        if i % 7 == 3 {
            mesh.triangles.truncate(mesh.triangles.len() - 2);
            mesh.triangle_materials.truncate(mesh.triangles.len());
        }
        mesh
    });
    let scene = adumbra_testing::scene_of(boxes.collect());
    for towards in [[0.0, 1.0, 0.0], [0.5, 0.8, 0.35]] {
        let options = BakeOptions::new(sun(towards), Size::Resolution(64));
        let [drawn, _] = assert_agreement("boxes", &scene, &options, 1);
        assert!(drawn > 100, "{drawn} texels are drawn");
    }
}

#[test]
#[ignore = "slow: a forest, twice"]
fn masked_layers_have_the_same_columns_in_both_builders() {
    let forest = generate(GeneratedKind::Forest, 1);
    for (towards, thickness_world) in [([0.5, 0.8, 0.35], 0.0), ([0.9, 0.2, -0.3], 0.1)] {
        let options =
            BakeOptions { thickness_world, ..BakeOptions::new(sun(towards), Size::Resolution(1024)) };
        let [drawn, all] = assert_agreement("forest", &forest, &options, 5);
        assert!(drawn * 4 > all, "{drawn} of {all} texels are drawn");
    }
}

#[test]
#[ignore = "slow: real scenes"]
fn builders_agree_on_shared_scenes_under_every_option() {
    let Some(folder) = adumbra_testing::shared("scenes") else { return };
    for name in ["street-1.glb", "bridge_garden.glb"] {
        let scene = load(&folder.join(name), &LoadOptions::default()).expect("a good scene");
        let plain = BakeOptions::new(sun([-0.45, 0.75, -0.35]), Size::Resolution(1024));
        let all = [
            BakeOptions { assume_ground: AssumeGround::No, ..plain.clone() },
            BakeOptions { closed_regions: false, thickness_world: 0.3, ..plain.clone() },
            BakeOptions { ignore_alpha: true, ..plain.clone() },
            BakeOptions { receivers: Receivers::Static, ..plain },
        ];
        for options in all {
            assert_agreement(name, &scene, &options, 3);
        }
    }
}
