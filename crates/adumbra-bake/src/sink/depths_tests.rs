//! Compares depths with the intervals of their columns.

use proptest::prelude::*;

use crate::columns::Columns;
use crate::columns::rules::{BESIDE_GRID, FREE_TO_END};
use crate::options::{BakeOptions, Size};
use crate::sink::depths::{DepthsBlock, DepthsSink};
use crate::sink::from_columns::block_of;
use crate::sink::{BlockSink, Structure};
use crate::test_bakes::{bake_depths, for_each_column};
use adumbra::Sun;
use adumbra::layout::depths::code::ColumnNode;
use adumbra::layout::depths::page::{IN_PAGE, Page};
use adumbra::layout::depths::{Census, DepthTree, LEAF_LEVEL, NEVER};
use adumbra_scene::{GeneratedKind, LoadOptions, Scene, generate, load};
use adumbra_testing::TreeParts;

/// An object above the ground: x, y, width, height, depth, thickness, slope, whether its columns end.
type Part = (u32, u32, u32, u32, u32, u32, u32, bool);

/// A few objects above a tilted ground.
#[derive(Debug)]
struct World {
    size: [u32; 2],
    parts: Vec<Part>,
    rough: bool,
}

fn any_world() -> impl Strategy<Value = World> {
    let part =
        (0_u32..80, 0_u32..80, 1_u32..60, 1_u32..60, 0_u32..300_000, 0_u32..300, 0_u32..4, any::<bool>());
    let size = [1_u32..150, 1_u32..150];
    let all = (size, prop::collection::vec(part, 0..12), any::<bool>());
    all.prop_map(|(size, parts, rough)| World { size, parts, rough })
}

impl World {
    fn columns(&self) -> Columns {
        let [width, height] = self.size;
        let mut columns = Columns::default();
        columns.reset(width, height);
        for i in 0..width * height {
            columns.set(i as usize, [400_000 + i % width, FREE_TO_END]);
        }
        for &(x0, y0, w, h, depth, thick, slope, ends) in &self.parts {
            for (y, x) in
                (y0..(y0 + h).min(height)).flat_map(|y| (x0..(x0 + w).min(width)).map(move |x| (y, x)))
            {
                let rough = if self.rough { (x * 7919 + y * 104_729) % 97 } else { 0 };
                let e = depth + slope * (x + 2 * y) + rough;
                let end = if ends { e + thick } else { FREE_TO_END };
                columns.set((y * width + x) as usize, [e, end]);
            }
        }
        columns
    }
}

/// Builds depths from root blocks of `level`.
fn build(columns: &Columns, level: u32, merged: bool) -> DepthTree {
    build_in_order(columns, level, merged, std::iter::empty(), whole)
}

/// Makes a block of columns, see [`block_of`].
type MakeBlock = fn(&DepthsSink, &dyn Fn(u32, u32) -> [u32; 2], u32, [u32; 2]) -> DepthsBlock;

/// Makes a block that is uniform at the highest level at which it can be.
fn whole(
    sink: &DepthsSink,
    column: &dyn Fn(u32, u32) -> [u32; 2],
    level: u32,
    corner: [u32; 2],
) -> DepthsBlock {
    block_of(sink, &column, level, corner)
}

/// Makes a block by joining all of its leaves.
fn of_leaves(
    sink: &DepthsSink,
    column: &dyn Fn(u32, u32) -> [u32; 2],
    level: u32,
    corner: [u32; 2],
) -> DepthsBlock {
    if level == LEAF_LEVEL {
        return whole(sink, column, level, corner);
    }
    let [x, y] = corner;
    let half = 1 << (level - 1);
    let quarter = |q: u32| of_leaves(sink, column, level - 1, [x + (q >> 1) * half, y + (q & 1) * half]);
    sink.join(level, [0, 1, 2, 3].map(quarter))
}

/// Builds depths from root blocks of `level`. The sink takes those in `order` as soon as they are done, the
/// others at the end.
fn build_in_order(
    columns: &Columns,
    level: u32,
    merged: bool,
    order: impl Iterator<Item = usize>,
    make: MakeBlock,
) -> DepthTree {
    let size = [columns.width, columns.height, 500_000];
    let sink = DepthsSink::in_memory(size, level, merged);
    let column = |i, j| {
        if i >= columns.width || j >= columns.height {
            return [0, BESIDE_GRID];
        }
        let at = (j * columns.width + i) as usize;
        [columns.e[at], columns.x[at]]
    };
    let corners = |n: u32| (0..n).step_by(1 << level);
    let corners: Vec<[u32; 2]> =
        corners(size[1]).flat_map(|y| corners(size[0]).map(move |x| [x, y])).collect();
    let block = |number: usize| make(&sink, &column, level, corners[number]);
    let mut taken: Vec<_> = corners.iter().map(|_| None).collect();
    for number in order {
        taken[number] = Some(sink.taken(number, block(number)));
    }
    let rest = |(number, taken): (usize, Option<_>)| taken.unwrap_or_else(|| block(number));
    let blocks = taken.into_iter().enumerate().map(rest).collect();
    sink.finish(blocks).tree().expect("room for all words")
}

/// Checks that a column's answer satisfies `[e, x]`, and that its leaf as a whole agrees.
fn check_column(found: &DepthTree, i: u32, j: u32, [e, x]: [u32; 2]) {
    let value = found.value(i, j);
    assert!(e <= value && (value <= x || x == FREE_TO_END), "({i}, {j}): {value} is not in [{e}, {x}]");
    let ColumnNode::Leaf { at, base } = found.place(i, j).0 else { return };
    let of_leaf = found.shapes().leaf(at, base).values();
    assert_eq!(of_leaf[((j & 7) * 8 + (i & 7)) as usize], value, "({i}, {j})");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn depths_answer_every_defined_voxel(world in any_world(), level in 5_u32..=10, merged in any::<bool>()) {
        let columns = world.columns();
        let found = build(&columns, level, merged);
        for j in 0..columns.height {
            for i in 0..columns.width {
                let at = (j * columns.width + i) as usize;
                check_column(&found, i, j, [columns.e[at], columns.x[at]]);
            }
        }
    }

    #[test]
    fn depths_of_damaged_words_are_rejected_or_readable(
        world in any_world(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u32>(), 0_u32..3), 1..6),
    ) {
        let columns = world.columns();
        let mut parts = TreeParts::of(&build(&columns, 7, true));
        for (at, word, part) in changes {
            let page = at.get_mut(&mut parts.pages);
            match part {
                0 => page.root = IN_PAGE | (word % 9000),
                1 => page.base = word % 9000,
                _ if page.words.is_empty() => {}
                _ => *at.get_mut(&mut page.words) ^= 1 << (word & 31),
            }
        }
        if let Ok(found) = parts.tree() {
            for j in 0..columns.height {
                for i in 0..columns.width {
                    check_column(&found, i, j, [0, FREE_TO_END]);
                }
            }
        }
    }
}

/// A world of several pages, the last of which the grid's end cuts.
fn wide_world([width, height]: [u32; 2], seed: u32) -> Columns {
    let part = |n: u32| {
        let at = |k: u32| (n * 7919 + k * 104_729 + seed * 31) % 1000;
        let place = [at(1) * width / 1000, at(2) * height / 1000];
        (place[0], place[1], 1 + at(3) / 8, 1 + at(4) / 8, 200 * at(5), at(6) / 4, at(7) % 3, at(8) % 2 == 0)
    };
    World { size: [width, height], parts: (0..60).map(part).collect(), rough: seed % 2 == 1 }.columns()
}

#[test]
fn depths_do_not_depend_on_root_block_size_or_order() {
    for (size, seed) in [([1100, 700], 0), ([513, 300], 1), ([40, 600], 2), ([512, 512], 3), ([5, 3], 4)] {
        let free = wide_world(size, seed);
        // Columns without freedom give the same depths in a uniform block of any level.
        let mut fixed = wide_world(size, seed);
        for (e, x) in fixed.e.iter_mut().zip(&mut fixed.x) {
            [*e, *x] = if *x < FREE_TO_END { [*e; 2] } else { [500_000, FREE_TO_END] };
        }
        for (columns, make, merged) in
            [(&free, of_leaves as MakeBlock, true), (&fixed, whole, true), (&fixed, whole, false)]
        {
            let build = |level, order: &mut dyn Iterator<Item = usize>| {
                build_in_order(columns, level, merged, order, make)
            };
            let expected = build(9, &mut std::iter::empty());
            for level in [3, 4, 5, 6, 7, 8, 10, 11] {
                let across = size[0].div_ceil(1 << level) as usize;
                let count = across * size[1].div_ceil(1 << level) as usize;
                // Every second block, then half of the others backwards, and the rest at the end.
                let mut order = (0..count).step_by(2).chain((1..count).step_by(4).rev());
                assert!(build(level, &mut order) == expected, "{size:?}, {level}, merged: {merged}");
            }
        }
    }
}

#[test]
fn depths_of_one_row_match_the_worked_example() {
    let mut columns = Columns::default();
    columns.reset(32, 32);
    (0..1024).for_each(|i| columns.set(i, if i < 8 { [7, 7] } else { [500, FREE_TO_END] }));
    let found = build(&columns, 5, true);
    assert_eq!(found.top(), [[5, 7]]);
    // The leaf, then the nodes of levels 5, 7 and 9 at half-words 5, 9 and 13: child 0 is a shape 5, 4 and 4
    // half-words back, all others are never.
    let leaf_and_nodes = [
        0xff00_0041,
        0xffff_ffff,
        0x0001_ffff,
        0xfffe_0000,
        0x0001_8005,
        0xfffe_0000,
        0x0001_8004,
        0xfffe_0000,
        0x0000_8004,
    ];
    assert_eq!(found.page([0, 0]), Page { root: IN_PAGE | 13, base: 7, words: &leaf_and_nodes });
    assert_eq!((found.common(), found.code()), (&[][..], &leaf_and_nodes[..]));
    assert_eq!((found.value(7, 0), found.value(8, 0), found.value(0, 1)), (7, NEVER, NEVER));
    let of_leaf = found.shapes().leaf(0, 7).values();
    assert_eq!(of_leaf, std::array::from_fn::<u32, 64, _>(|column| if column < 8 { 7 } else { NEVER }));
}

#[test]
fn depths_store_equal_shapes_at_different_depths_once() {
    let mut columns = Columns::default();
    columns.reset(256, 32);
    for i in 0..256 * 32 {
        let (x, y) = (i % 256, i / 256);
        let inside = (3..29).contains(&(x % 32)) && (5..21).contains(&y);
        columns.set(
            i,
            if inside { [1000 * (x / 32) as u32, 1000 * (x / 32) as u32 + 3] } else { [20_000, FREE_TO_END] },
        );
    }
    let [merged, plain] = [true, false].map(|merged| build(&columns, 5, merged));
    assert!(merged.top().iter().all(|root| root[0] == merged.top()[0][0]));
    let [of_merged, of_plain] = [&merged, &plain].map(DepthTree::census);
    let leaf_bytes = |census: &Census| census.depth_bytes + census.plane_bytes;
    assert!(leaf_bytes(&of_plain) >= 8 * leaf_bytes(&of_merged), "{of_plain:?}, {of_merged:?}");
    // Eight nodes of level 5, two of level 7, and the root.
    assert_eq!((of_plain.nodes, of_merged.nodes), (11, 3));
    assert_eq!((merged.value(40, 10), plain.value(240, 20)), (1000, 7000));
}

fn bake(scene: &Scene, options: &BakeOptions, merged: bool) -> DepthTree {
    bake_depths(scene, options, merged).expect("a good bake").0
}

#[test]
fn depths_do_not_depend_on_the_number_of_threads() {
    let scene = generate(GeneratedKind::Primitives, 1);
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).expect("above the horizon");
    let options = BakeOptions::new(sun, Size::Resolution(256));
    let of_threads = |threads, merged| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a small pool");
        pool.install(|| bake(&scene, &options, merged))
    };
    for merged in [true, false] {
        assert_eq!(of_threads(1, merged), of_threads(4, merged));
    }
}

/// Options for a shared scene as in the tables, with the sun's direction chosen by name.
fn shared_options(name: &str, resolution: u64) -> BakeOptions {
    let sun = if name == "jacksboro" { [-0.77, 0.105, -0.63] } else { [0.5, 0.8, 0.35] };
    let sun = Sun::from_direction(sun).expect("above the horizon");
    BakeOptions { thickness_world: 0.1, ..BakeOptions::new(sun, Size::Resolution(resolution)) }
}

fn shared_scene(name: &str) -> Option<Scene> {
    let path = adumbra_testing::scene_file(&adumbra_testing::shared("scenes")?, name);
    Some(load(&path, &LoadOptions::default()).expect("a good scene"))
}

#[test]
#[ignore = "slow: real scenes"]
fn shared_depths_answer_every_defined_voxel() {
    for name in ["kaykit_city_21", "alpine-2"] {
        let Some(scene) = shared_scene(name) else { return };
        let options = shared_options(name, 1024);
        let found = bake(&scene, &options, true);
        for_each_column(&scene, &options, |i, j, column| check_column(&found, i, j, column))
            .expect("a good plan");
    }
}
