//! The fast builder against the plain one: intervals within the plain columns' everywhere, the same first surfaces wherever it
//! draws, and a graph that keeps to the plain columns.

use std::sync::atomic::AtomicBool;

use super::capture::{CaptureBuffers, capture};
use super::columns::Columns;
use super::descent::{DescentBuffers, build_root};
use super::plan::Plan;
use super::sink::{BLOCK_SIDE, BlockColumns, BlockSink};
use super::surface::TileSurfaces;
use super::{Options, Size, bake};
use crate::light::Sun;
use crate::scene::{LoadOptions, Scene, load};
use crate::settings::Receivers;
use crate::shared_folder;
use crate::verify::Random;

/// Keeps what the descent found, in the order in which it goes.
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

    fn join(&self, _level: u32, quarters: [Vec<Piece>; 4]) -> Vec<Piece> {
        quarters.into_iter().flatten().collect()
    }
}

/// Calls `visit(x, y, e, x, drawn)` for every texel of a root block.
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

/// A column as both builders have it, before a limit on switches cuts it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Column {
    /// Texel of the grid.
    pub(super) at: [u32; 2],
    /// `[e, x]` of the plain builder.
    pub(super) plain: [u32; 2],
    /// `[e, x]` of the fast builder.
    pub(super) fast: [u32; 2],
    /// The fast builder drew it.
    pub(super) drawn: bool,
}

impl Column {
    /// Whether the fast builder's interval lies within the plain one, with the same first surface where it was drawn.
    pub(super) fn agrees(&self) -> bool {
        let ([e, x], [fast_e, fast_x]) = (self.plain, self.fast);
        e <= fast_e && fast_e <= fast_x && fast_x <= x && (!self.drawn || fast_e == e)
    }
}

/// What is reused from tile to tile.
#[derive(Default)]
pub(super) struct BothBuffers {
    descent: DescentBuffers,
    capture: CaptureBuffers,
    columns: Columns,
}

/// Calls `visit` with every column of a root block.
pub(super) fn for_each_column(
    plan: &Plan<'_>,
    tile: usize,
    buffers: &mut BothBuffers,
    mut visit: impl FnMut(Column),
) {
    let BothBuffers { descent, capture: captured, columns } = buffers;
    let pieces =
        build_root(plan, tile, &Found, descent, &AtomicBool::new(false)).expect("nothing interrupts");
    let surfaces = TileSurfaces { casters: &plan.casters, tile, grid: &plan.grid };
    let rect = plan.tile_rect(tile);
    capture(&surfaces, &plan.rules, rect, captured, columns);
    let mut pieces = pieces.into_iter();
    let mut next = pieces.next();
    for_each_found(plan.root_level, [0, 0], &mut pieces, &mut next, &mut |[x, y], fast, drawn| {
        if x < rect.width && y < rect.height {
            let texel = (y * rect.width + x) as usize;
            let plain = [columns.e[texel], columns.x[texel]];
            visit(Column { at: [rect.x + x, rect.y + y], plain, fast, drawn });
        }
    });
    assert!(next.is_none(), "pieces are left behind the block's last");
}

/// Compares every `step`-th root block; gives texels drawn and texels in all.
fn assert_agreement(name: &str, scene: &Scene, options: &Options, step: usize) -> [u64; 2] {
    let plan = Plan::new(scene, options).expect("the scene fits");
    let dag = bake(scene, options, &|_| {}, &AtomicBool::new(false)).expect("the scene fits").dag;
    let mut buffers = BothBuffers::default();
    let mut random = Random::new(7, 0);
    let (mut counts, mut shorter) = ([0, 0], 0);
    for tile in (0..plan.tiles()).step_by(step) {
        for_each_column(&plan, tile, &mut buffers, |column| {
            let Column { at: [i, j], plain, fast, drawn } = column;
            counts[0] += u64::from(drawn);
            counts[1] += 1;
            assert!(column.agrees(), "{name}: {column:?}");
            shorter += u64::from(drawn && fast[1] < plain[1]);
            // The layers next to both ends, and one anywhere.
            let anywhere = (random.unit() * f64::from(plan.grid.size[2])) as u32;
            for k in [plain[0].wrapping_sub(1), plain[0], plain[1].saturating_sub(1), plain[1], anywhere] {
                if k < plan.grid.size[2] {
                    let lit = dag.voxel(i, j, k);
                    assert!(k >= plain[0] || lit, "{name}: ({i}, {j}, {k}) is shadowed before {plain:?}");
                    assert!(k < plain[1] || !lit, "{name}: ({i}, {j}, {k}) is lit behind {plain:?}");
                }
            }
        });
    }
    // What is known to lie behind a block is taken to lie behind all of it.
    assert!(shorter * 20 <= counts[0], "{name}: {shorter} of {} drawn columns have less freedom", counts[0]);
    counts
}

fn sun(towards: [f64; 3]) -> Sun {
    Sun::from_direction(towards).expect("a sun above the horizon")
}

#[test]
fn shared_scenes_have_the_plain_builders_columns() {
    let Some(folder) = shared_folder::shared("scenes") else { return };
    let mut names: Vec<_> = std::fs::read_dir(&folder)
        .expect("a folder")
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| [".glb", ".obj", ".ply"].iter().any(|ending| name.ends_with(ending)))
        .collect();
    names.sort();
    assert!(names.len() > 10);
    for (n, name) in names.iter().enumerate() {
        let scene = load(&folder.join(name), &LoadOptions::default()).expect("a good scene");
        let towards = if name.starts_with("jacksboro") { [-0.77, 0.105, -0.63] } else { [0.5, 0.8, 0.35] };
        let options = Options {
            thickness_world: [0.0, 0.1][n % 2],
            ..Options::new(sun(towards), Size::Resolution(4096))
        };
        // A prime step meets every row and column of root blocks.
        let step = if shared_folder::full() { 1 } else { 29 };
        let [drawn, all] = assert_agreement(name, &scene, &options, step);
        eprintln!("{name}: {:.1} % of texels drawn", 100.0 * drawn as f64 / all as f64);
    }
}

#[test]
fn shared_scenes_agree_under_every_option() {
    let Some(folder) = shared_folder::shared("scenes") else { return };
    for name in ["street-1.glb", "bridge_garden.glb"] {
        let scene = load(&folder.join(name), &LoadOptions::default()).expect("a good scene");
        let plain = Options::new(sun([-0.45, 0.75, -0.35]), Size::Resolution(1024));
        let all = [
            Options { assume_ground: false, ..plain.clone() },
            Options { closed_regions: false, thickness_world: 0.3, ..plain.clone() },
            Options { ignore_alpha: true, ..plain.clone() },
            Options { receivers: Receivers::Static, ..plain },
        ];
        for options in all {
            assert_agreement(name, &scene, &options, 3);
        }
    }
}
