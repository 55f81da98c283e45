//! Pages that are linked: in any order and from disk, with the shapes that several have in common, and with
//! pointers and differences of every size.

mod meanings;

use std::collections::HashSet;
use std::path::PathBuf;
use std::sync::Arc;

use adumbra::IoError;
use adumbra::layout::depths::child::{Child, ShapeRef};
use adumbra::layout::depths::code::{Code, NEAR};
use adumbra::layout::depths::page::{IN_PAGE, PAGE_LEVEL, Page};
use adumbra::layout::depths::{DepthTree, LEAF_LEVEL, NEVER, UNIFORM};
use adumbra_scene::random::{Random, mix};

use self::meanings::{Meanings, Pointer, Where};
use super::{PageStore, Pages, Spill};
use crate::columns::rules::FREE_TO_END;
use crate::error::Error;
use crate::sink::Structure;
use crate::sink::depths::DepthsSink;
use crate::sink::from_columns::block_of;

/// Voxels along the light.
const DEPTH: u32 = 1 << 21;
/// Columns along a side of a page, and of the blocks that the tests fill pages with: those of the root's
/// children.
const PAGE: u32 = 1 << PAGE_LEVEL;
const BLOCK: u32 = PAGE / 4;

/// Returns a pseudo-random number below `n`, determined by the other arguments.
fn noise(n: u32, of: [u32; 3]) -> u32 {
    let mixed = of.into_iter().fold(0, |state, c| mix(state ^ u64::from(c)));
    (mixed % u64::from(n)) as u32
}

/// A grid of whole pages in which every column switches at one depth.
struct World {
    /// Pages along x and y.
    pages: [u32; 2],
    /// Returns the depth at which a column switches, [`NEVER`] if it does not.
    depth: fn(u32, u32) -> u32,
}

impl World {
    fn size(&self) -> [u32; 3] {
        let [across, down] = self.pages.map(|n| n * PAGE);
        [across, down, DEPTH]
    }

    /// Bakes the pages, each on its own.
    fn pages(&self, merged: bool) -> Pages {
        let sink = DepthsSink::in_memory(self.size(), PAGE_LEVEL, merged);
        let column = |i, j| match (self.depth)(i, j) {
            NEVER => [DEPTH, FREE_TO_END],
            depth => [depth; 2],
        };
        let [across, down] = self.pages;
        let corners = (0..down).flat_map(|y| (0..across).map(move |x| [x * PAGE, y * PAGE]));
        let blocks = corners.map(|corner| block_of(&sink, &column, PAGE_LEVEL, corner)).collect();
        sink.finish(blocks)
    }

    fn tree(&self, merged: bool) -> DepthTree {
        self.pages(merged).tree().expect("room for all words")
    }

    /// Checks the answer of every column.
    fn check(&self, tree: &DepthTree) {
        let [nx, ny, _] = self.size();
        for (i, j) in (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j))) {
            assert_eq!(tree.value(i, j), (self.depth)(i, j), "({i}, {j})");
        }
    }
}

/// Twelve pages. Some of their blocks are in all pages, some in three, some in two and some in one, each at
/// another distance from its page's base. The last four pages are equal.
const TOWN: World = World {
    pages: [4, 3],
    depth: |i, j| {
        let page = j / PAGE * 4 + i / PAGE;
        let kind = match (j % PAGE / BLOCK * 4 + i % PAGE / BLOCK, page) {
            (0, _) => 1,
            (2, 0..2) => 2,
            (5, 0..3) => 3,
            (6, 1..3) => 4,
            (9, _) => 100 + page.min(8),
            _ => return 1000 + 300 * page,
        };
        let [x, y] = [i, j].map(|c| c % BLOCK);
        // Leaves of few contours, so that blocks of different kinds have some of them in common.
        match noise(4, [kind, x / 8, y / 8]) {
            0 => NEVER,
            contour => 1000 + 300 * page + 10 * noise(5, [contour, x % 8 / 2, y % 8 / 2]),
        }
    },
};

#[test]
fn shapes_of_three_pages_are_common_but_not_shapes_of_two() {
    let tree = TOWN.tree(true);
    let found = Meanings::of(&tree);
    let mut in_pages = [0; 13];
    for shape in &found.shapes {
        let count = shape.pages.len();
        in_pages[count] += 1;
        let parts: HashSet<Where> = shape.halves.keys().map(|&(part, _)| part).collect();
        let expected: HashSet<Where> = match count {
            3.. => [None].into(),
            _ => shape.pages.iter().map(|&page| Some(page)).collect(),
        };
        assert_eq!(parts, expected, "a shape of level {} that {count} pages have", shape.level);
        // Each part stores the shape once.
        assert_eq!(parts.len(), shape.halves.len());
    }
    assert!([1, 2, 3, 12].iter().all(|&count| in_pages[count] > 3), "{in_pages:?}");
    // Nothing else is stored.
    let words = |part: Where| {
        let lengths = found.shapes.iter().flat_map(|shape| &shape.halves).filter(|((of, _), _)| *of == part);
        lengths.map(|(_, length)| *length as usize).sum::<usize>().div_ceil(2)
    };
    assert_eq!(tree.common().len(), words(None));
    for page in 0..12 {
        let place = [page % 4, page / 4];
        assert_eq!(tree.page(place).words.len(), words(Some(page as usize)), "{place:?}");
        // The root of equal pages is a shape of all four.
        assert_eq!(tree.page(place).root & IN_PAGE == 0, page >= 8, "{place:?}");
    }
}

#[test]
fn merged_and_unmerged_pages_answer_alike() {
    let [merged, plain] = [true, false].map(|merged| TOWN.tree(merged));
    assert!(plain.common().is_empty() && 2 * merged.code().len() < plain.code().len());
    TOWN.check(&merged);
    TOWN.check(&plain);
}

/// One block is nearer in its first child, and the next block in the first child of its first child.
#[test]
fn nodes_of_two_levels_with_equal_children_are_two_shapes() {
    let world = World {
        pages: [1, 1],
        depth: |i, j| match [i, j] {
            [0..32, 0..32] | [128..136, 0..8] => 10,
            _ => 20,
        },
    };
    let tree = world.tree(true);
    world.check(&tree);
    let shapes = Meanings::of(&tree).shapes;
    let levels: Vec<u32> = shapes.iter().map(|shape| shape.level).collect();
    assert_eq!(levels, [7, 5, 7, 9]);
    let places: HashSet<_> = shapes.iter().flat_map(|shape| shape.halves.keys()).collect();
    assert_eq!(places.len(), 4);
}

/// Returns the same pages, as if they had been made in this order.
fn made_in_order(pages: &Pages, order: &[usize], spill: &Arc<Spill>) -> Pages {
    let store = PageStore::new(Arc::clone(spill));
    let mut places = pages.places.clone();
    for &page in order {
        if pages.places[page][0] != UNIFORM {
            let (words, root) = pages.store.get(pages.places[page][0]).expect("a page in memory");
            places[page][0] = store.add(root, words.to_vec());
        }
    }
    Pages { size: pages.size, places, store, merged: pages.merged, is_too_large: false }
}

fn shuffled(count: usize, random: &mut Random) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    for at in (0..count).rev() {
        order.swap(at, (random.unit() * (at + 1) as f64) as usize);
    }
    order
}

fn unlimited_spill() -> Arc<Spill> {
    Arc::new(Spill::unlimited())
}

/// Returns a spill with room for one page or two.
fn tiny_spill() -> Arc<Spill> {
    Arc::new(Spill::new(8_000, std::env::temp_dir()))
}

#[test]
fn linking_does_not_depend_on_page_order_or_spilling() {
    let mut random = Random::for_batch(1, 0);
    for merged in [true, false] {
        let pages = TOWN.pages(merged);
        let in_order: Vec<usize> = (0..12).collect();
        let expected = made_in_order(&pages, &in_order, &unlimited_spill()).tree().unwrap();
        for case in 0..6_usize {
            let order = shuffled(12, &mut random);
            let spill = if case % 2 == 0 { unlimited_spill() } else { tiny_spill() };
            let again = made_in_order(&pages, &order, &spill);
            if case == 4 {
                spill.limit_to(8_000);
                again.store.shrink();
            }
            assert_eq!(spill.spilled_bytes() > 0, case % 2 == 1 || case == 4, "{case}");
            assert!(spill.resident_bytes() <= 8_000 || spill.spilled_bytes() == 0);
            let pool = rayon::ThreadPoolBuilder::new().num_threads(1 + case % 3).build().unwrap();
            assert!(pool.install(|| again.tree()).unwrap() == expected, "{case}: {order:?}");
        }
    }
}

#[test]
fn linked_bundles_come_in_order_and_free_their_pages() {
    let (spill, order) = (unlimited_spill(), shuffled(12, &mut Random::for_batch(2, 0)));
    let pages = made_in_order(&TOWN.pages(true), &order, &spill);
    assert!(spill.resident_bytes() > 0);
    let expected = TOWN.tree(true);
    let mut linked = pages.link().unwrap();
    assert_eq!(linked.take_common().0, expected.common());
    let mut places = Vec::new();
    let words = |_, pages: &[Page<'_>; 16]| pages.map(|page| page.words.to_vec());
    linked
        .for_each_bundle(words, |at, found| {
            places.push(at);
            assert_eq!(found, expected.bundle(at).map(|page| page.words.to_vec()));
            Ok(())
        })
        .unwrap();
    assert_eq!(places, [[0, 0]]);
    assert_eq!(spill.resident_bytes(), 0);
}

#[test]
fn linking_reports_pages_that_could_not_be_spilled() {
    let folder = PathBuf::from("/nonexistent/adumbra");
    let in_order: Vec<usize> = (0..12).collect();
    let spill = Arc::new(Spill::new(8_000, folder.clone()));
    let pages = made_in_order(&TOWN.pages(true), &in_order, &spill);
    let Err(Error::Spill(IoError { path, source, .. })) = pages.tree() else { panic!("no error") };
    assert_eq!((path, source.kind()), (folder, std::io::ErrorKind::NotFound));
}

/// Columns without anything in common, up to 60,000 voxels apart.
fn rough(i: u32, j: u32) -> u32 {
    noise(60_000, [7, i, j])
}

#[test]
fn page_above_the_reach_of_near_pointers_has_far_ones() {
    // One page has nothing in common with others.
    let alone = World { pages: [1, 1], depth: rough };
    let tree = alone.tree(true);
    let Page { root, words, .. } = tree.page([0, 0]);
    assert!(tree.common().is_empty() && 2 * words.len() > 8 * NEAR as usize && root & IN_PAGE != 0);
    alone.check(&tree);
    let Meanings { pointers, shapes, .. } = Meanings::of(&tree);
    assert!(pointers.iter().all(|pointer| pointer.back.is_some()));
    // All but the last children of the root are far.
    let root = root & !IN_PAGE;
    let distance = |c| match (Code { words }).child(root, c) {
        Child::Shape { shape: ShapeRef::Here(at), .. } => root - at,
        other => panic!("{other:?}"),
    };
    assert!((0..14).all(|c| distance(c) >= NEAR) && distance(15) < NEAR);
    // Those of level 5 are short.
    let short = pointers.iter().filter(|pointer| pointer.back < Some(256) && pointer.delta.abs() < 100);
    assert!(short.count() > 10);
    // A node's head says which children have far pointers. They are exactly these.
    let nodes = shapes.iter().filter(|shape| shape.level > LEAF_LEVEL).flat_map(|shape| shape.halves.keys());
    let half = |at| Code { words }.half(at);
    let far: u32 = nodes.map(|&(_, at)| (half(at) & half(at + 1) & !half(at + 2)).count_ones()).sum();
    assert_eq!(pointers.iter().filter(|pointer| pointer.is_far()).count() as u32, far);
}

#[test]
fn common_section_above_the_reach_of_near_addresses_has_far_ones() {
    // Three quarters of the blocks are in every page.
    let world = World {
        pages: [2, 2],
        depth: |i, j| {
            let [x, y] = [i, j].map(|c| c % PAGE);
            let page = if y < 3 * BLOCK { 0 } else { j / PAGE * 2 + i / PAGE };
            rough(x + page * PAGE, y)
        },
    };
    let tree = world.tree(true);
    assert!(2 * tree.common().len() > 6 * NEAR as usize);
    let words = tree.page([1, 1]).words;
    assert!(2 * words.len() > 2 * NEAR as usize && 2 * words.len() < tree.common().len());
    world.check(&tree);
    let root = tree.page([1, 1]).root & !IN_PAGE;
    let of_children = |c| match (Code { words }).child(root, c) {
        Child::Shape { shape, .. } => shape,
        other => panic!("{other:?}"),
    };
    let children: Vec<ShapeRef> = (0..16).map(of_children).collect();
    assert!(children[..12].iter().all(|shape| matches!(shape, ShapeRef::Common(_))));
    assert!(children[12..].iter().all(|shape| matches!(shape, ShapeRef::Here(_))));
    assert!(children[..12].iter().filter(|shape| shape.at() >= NEAR).count() > 8, "{children:?}");
}

/// Depths of a block with unique leaves, with equal leaves, and with a part far behind the others.
fn pattern(x: u32, y: u32) -> u32 {
    let behind = if x / 32 == 2 && y / 32 == 1 { 70_000 } else { 0 };
    behind + 20 * noise(6, [3, x / 32 * 4 + y / 32, x % 32]) + noise(90, [4, x / 4, y / 8])
}

/// One page with differences beyond 16 bits: near and far, up and down, with a shape and without.
const CLIFFS: World = World {
    pages: [1, 1],
    depth: |i, j| {
        let [x, y] = [i, j].map(|c| c % BLOCK);
        match j / BLOCK * 4 + i / BLOCK {
            0 => 10 + pattern(x, y),
            1..5 => 10 + rough(i, j) / 2,
            5 => 1_000_000,
            // Leaves far behind their neighbours.
            6 => 100_000 * ((x / 8 + y / 8) % 2) + 3 * (x % 8) + y % 8,
            // Most columns are far behind; the others are nearer than the base.
            7 if x < 32 && y < 32 => 20,
            7 if x < 64 && y < 32 => 20 + noise(100, [5, x, y]),
            7 => 300_000,
            // The last leaves of the first block again.
            8 if x < 8 && y < 8 => 500_000 + pattern(x + 120, y + 120),
            8 if x < 32 && y < 32 => 10,
            15 => 200_010 + pattern(x, y),
            _ => NEVER,
        }
    },
};

#[test]
fn wide_differences_occur_with_near_far_and_no_pointers() {
    let tree = CLIFFS.tree(true);
    assert!(2 * tree.page([0, 0]).words.len() > 2 * NEAR as usize);
    CLIFFS.check(&tree);
    CLIFFS.check(&CLIFFS.tree(false));
    let found = Meanings::of(&tree);
    let children = found.numbers.keys().filter(|(level, _)| *level > LEAF_LEVEL).flat_map(|(_, c)| c);
    let uniform = children.filter(|[kind, ..]| *kind == 1).map(|[_, delta, _]| *delta as u32 as i32);
    let wide: HashSet<i32> = uniform.filter(|&delta| i16::try_from(delta).is_err()).collect();
    // Block 5 from the root's base, which is that of blocks 0 and 8, and the first part of block 7 from that
    // of the block.
    assert_eq!(wide, [1_000_000 - 10, 20 - 300_000].into());
    // Near: block 7 and its second part, eight leaves of block 6, and the part of the pattern. Far: the last
    // block, and the leaf of block 8.
    let is_far: Vec<bool> = found.pointers.iter().filter(|p| p.is_wide()).map(Pointer::is_far).collect();
    let far = is_far.iter().filter(|&&is_far| is_far).count();
    assert_eq!((is_far.len() - far, far), (11, 2));
    assert!(found.pointers.iter().any(|p| p.is_far() && !p.is_wide()));
    // Each shape once.
    assert!(found.shapes.iter().all(|shape| shape.halves.len() == 1));
}

#[test]
fn wide_differences_occur_with_far_common_addresses() {
    // Rough blocks that each page has three times come first in the common section.
    let world = World {
        pages: [2, 2],
        depth: |i, j| {
            let [x, y] = [i, j].map(|c| c % BLOCK);
            let page = j / PAGE * 2 + i / PAGE;
            match j % PAGE / BLOCK * 4 + i % PAGE / BLOCK {
                block @ 0..9 => 10 + block + rough(x + block / 3 * BLOCK, y) / 2,
                9 => 100 + noise(90, [page, x, y]),
                10 => 200_010 + pattern(x, y),
                _ => NEVER,
            }
        },
    };
    let tree = world.tree(true);
    world.check(&tree);
    let found = Meanings::of(&tree);
    let wide: Vec<&Pointer> = found.pointers.iter().filter(|pointer| pointer.is_wide()).collect();
    assert_eq!(wide.len(), 4);
    assert!(
        wide.iter().all(|pointer| pointer.back.is_none() && pointer.at == wide[0].at && pointer.is_far())
    );
    assert!(found.shapes.iter().all(|shape| shape.pages.len() == 1 || shape.pages.len() == 4));
}

#[test]
fn rejects_differences_beyond_the_longest_form() {
    // The base is that of most columns, the deepest.
    for (deepest, fits) in [(1 << 21, true), ((1 << 21) + 1, false)] {
        let sink = DepthsSink::in_memory([16, 8, DEPTH << 1], PAGE_LEVEL, true);
        let column = |i, _| if i < 8 { [0; 2] } else { [deepest; 2] };
        let block = block_of(&sink, &column, PAGE_LEVEL, [0, 0]);
        match sink.finish(vec![block]).tree() {
            Ok(tree) => assert!(fits && tree.value(8, 0) == deepest && tree.value(7, 0) == 0),
            Err(error) => assert!(!fits && matches!(error, Error::TooManyWords { .. }), "{error}"),
        }
    }
}

/// Forged pages may use one place as shapes of several levels. A node without pointers is valid at any level.
#[test]
fn place_used_at_two_levels_is_read_as_two_shapes() {
    use adumbra::layout::depths::write::Writer;
    let mut writer = Writer::page();
    let node = |writer: &mut Writer, children: &[u32]| {
        let mut all = [Child::Uniform(0); 16];
        for (child, &at) in all.iter_mut().zip(children) {
            *child = Child::Shape { delta: 0, shape: ShapeRef::Here(at) };
        }
        all[15] = Child::Uniform(1);
        writer.node(&all).expect("a small page")
    };
    let low = node(&mut writer, &[]);
    let middle = node(&mut writer, &[low]);
    let root = node(&mut writer, &[low, middle]);
    let mut reader = super::Reader::default();
    reader.read(&writer.words(), root);
    assert_eq!(
        (0..reader.list.len()).map(|index| reader.list.level(index)).collect::<Vec<_>>(),
        [PAGE_LEVEL - 2, PAGE_LEVEL - 4, PAGE_LEVEL - 2, PAGE_LEVEL]
    );
    let different: HashSet<u128> = reader.hashes.iter().copied().collect();
    assert_eq!(different.len(), 4);
}
