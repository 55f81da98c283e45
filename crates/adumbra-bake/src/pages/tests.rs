//! Pages that are linked: in any order and from disk, with the shapes that several have in common, and with pointers and
//! differences of every size.

use std::collections::{HashMap, HashSet};
use std::path::PathBuf;
use std::sync::Arc;

use adumbra::IoError;
use adumbra::layout::depths::code::{Child, Code, LeafHead, NEAR};
use adumbra::layout::depths::page::{IN_PAGE, PAGE_LEVEL, Page};
use adumbra::layout::depths::{DepthTree, LEAF_LEVEL, NEVER, NODE_LEVELS, UNIFORM};
use adumbra_scene::random::{Random, mix};

use super::{PageStore, Pages, Spill};
use crate::columns::rules::FREE_TO_END;
use crate::error::Error;
use crate::sink::Structure;
use crate::sink::depths::DepthsSink;
use crate::sink::from_columns::block_of;

/// Voxels along the light.
const DEPTH: u32 = 1 << 21;
/// Columns along a side of a page, and of the blocks that the tests fill pages with: those of the root's children.
const PAGE: u32 = 1 << PAGE_LEVEL;
const BLOCK: u32 = PAGE / 4;

/// Returns a number below `n` that follows from the others.
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

/// What a shape means, wherever it is: its level, and a leaf's half-words or a node's children. A child has its kind,
/// its difference, and the number of its shape.
type Meaning = (u32, Vec<[usize; 3]>);

/// A part of a tree's code: `None` is the common section, else the number of a page.
type Where = Option<usize>;

/// The different shapes of a tree.
#[derive(Default)]
struct Meanings {
    numbers: HashMap<Meaning, usize>,
    shapes: Vec<Found>,
}

/// A shape.
#[derive(Default)]
struct Found {
    level: u32,
    /// Half-words of all places.
    halves: HashMap<(Where, u32), u32>,
    /// The pages that have the shape.
    pages: HashSet<usize>,
}

/// A page, while its shapes are visited.
struct Visit<'t> {
    number: usize,
    words: &'t [u32],
    common: &'t [u32],
    known: HashMap<(Where, u32, u32), usize>,
}

impl Meanings {
    fn of(tree: &DepthTree) -> Self {
        let mut found = Self::default();
        let [across, down] = tree.page_dims();
        for (number, place) in (0..down).flat_map(|y| (0..across).map(move |x| [x, y])).enumerate() {
            let Page { root, words, .. } = tree.page(place);
            let mut visit = Visit { number, words, common: tree.common(), known: HashMap::new() };
            match root {
                UNIFORM => {}
                root if root & IN_PAGE != 0 => {
                    found.shape(&mut visit, Some(number), root & !IN_PAGE, PAGE_LEVEL);
                }
                root => {
                    found.shape(&mut visit, None, root, PAGE_LEVEL);
                }
            }
        }
        found
    }

    /// Visits a shape and what is below it, and returns its number.
    fn shape(&mut self, visit: &mut Visit<'_>, part: Where, at: u32, level: u32) -> usize {
        if let Some(&known) = visit.known.get(&(part, at, level)) {
            return known;
        }
        let code = Code { words: if part.is_none() { visit.common } else { visit.words } };
        let (length, content) = if level == LEAF_LEVEL {
            let length = LeafHead::new(code.half(at)).length();
            (length, (at..at + length).map(|at| [code.half(at) as usize, 0, 0]).collect())
        } else {
            let child = |c| match code.child(at, c) {
                Child::Never => [0, 0, 0],
                Child::Uniform(delta) => [1, delta as usize, 0],
                Child::Shape { at, delta, is_relative } => {
                    let part = if is_relative { part } else { None };
                    [2, delta as usize, self.shape(visit, part, at, level - NODE_LEVELS)]
                }
            };
            let content = (0..16).map(child).collect();
            (3 + code.half(at).count_ones() + 2 * code.half(at + 1).count_ones(), content)
        };
        let next = self.numbers.len();
        let number = *self.numbers.entry((level, content)).or_insert(next);
        if number == next {
            self.shapes.push(Found { level, ..Found::default() });
        }
        let shape = &mut self.shapes[number];
        shape.halves.insert((part, at), length);
        shape.pages.insert(visit.number);
        visit.known.insert((part, at, level), number);
        number
    }

    /// Returns the shapes of a level that are at more than one place of a part.
    fn copied(&self, level: u32) -> impl Iterator<Item = &Found> {
        self.shapes.iter().filter(move |shape| {
            let parts: HashSet<Where> = shape.halves.keys().map(|&(part, _)| part).collect();
            shape.level == level && parts.len() < shape.halves.len()
        })
    }
}

/// Twelve pages. Some of their blocks are in all pages, some in three, some in two and some in one, each with another
/// distance to its page's base. The last four pages are equal.
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
fn shapes_of_three_pages_are_in_the_common_section_and_those_of_two_are_not() {
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
        // Each once.
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
fn linked_pages_answer_as_each_on_its_own() {
    let [merged, plain] = [true, false].map(|merged| TOWN.tree(merged));
    assert!(plain.common().is_empty() && 2 * merged.code().len() < plain.code().len());
    TOWN.check(&merged);
    TOWN.check(&plain);
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
    Pages { size: pages.size, places, store, merged: pages.merged }
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
fn linking_does_not_depend_on_the_order_of_pages_or_on_what_is_on_disk() {
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
    let linked = pages.link().unwrap();
    assert_eq!(linked.common(), expected.common());
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
fn pages_that_cannot_be_kept_are_an_error() {
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

/// Returns how many children of nodes are encoded with a far pointer, without and with a difference.
fn far_pointers(tree: &DepthTree) -> [u64; 2] {
    let children = tree.census().children;
    [children[4], children[6]]
}

#[test]
fn page_above_the_reach_of_near_pointers_has_far_ones() {
    // One page has nothing in common with others.
    let alone = World { pages: [1, 1], depth: rough };
    let tree = alone.tree(true);
    let Page { root, words, .. } = tree.page([0, 0]);
    assert!(tree.common().is_empty() && 2 * words.len() > 8 * NEAR as usize && root & IN_PAGE != 0);
    alone.check(&tree);
    let of_children = |c| match (Code { words }).child(root & !IN_PAGE, c) {
        Child::Shape { at, is_relative, .. } => (is_relative, (root & !IN_PAGE) - at >= NEAR),
        other => panic!("{other:?}"),
    };
    let children: Vec<(bool, bool)> = (0..16).map(of_children).collect();
    assert!(children.iter().all(|&(is_relative, _)| is_relative));
    assert!(children[..15].iter().all(|&(_, is_far)| is_far) && !children[15].1, "{children:?}");
    let [inherited, own] = far_pointers(&tree);
    assert!(inherited > 0 && own > 10, "{inherited}, {own}");
}

#[test]
fn common_section_above_the_reach_of_near_addresses_has_far_ones() {
    // Three quarters are in every page.
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
        Child::Shape { at, is_relative, .. } => (is_relative, at),
        other => panic!("{other:?}"),
    };
    let children: Vec<(bool, u32)> = (0..16).map(of_children).collect();
    assert!(children[..12].iter().all(|&(is_relative, _)| !is_relative));
    assert!(children[12..].iter().all(|&(is_relative, _)| is_relative));
    assert!(children[..12].iter().filter(|&&(_, at)| at >= NEAR).count() > 8, "{children:?}");
}

/// Depths of a block with leaves that are their own, with equal ones, and with a part that is far behind the rest.
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
            // Most are far behind; what is not is nearer than the base.
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

/// Returns how many children of nodes have a difference beyond 16 bits: deeper and nearer ones without a shape, and those
/// with one.
fn wide_differences(tree: &DepthTree) -> [usize; 3] {
    let found = Meanings::of(tree);
    let mut counts = [0; 3];
    for [kind, delta, _] in found.numbers.keys().filter(|(level, _)| *level > LEAF_LEVEL).flat_map(|(_, c)| c) {
        let delta = *delta as u32 as i32;
        if i16::try_from(delta).is_err() {
            counts[if *kind == 2 { 2 } else { usize::from(delta < 0) }] += 1;
        }
    }
    counts
}

#[test]
fn wide_differences_have_near_pointers_or_copies_of_their_shapes() {
    let tree = CLIFFS.tree(true);
    assert!(2 * tree.page([0, 0]).words.len() > 2 * NEAR as usize);
    CLIFFS.check(&tree);
    CLIFFS.check(&CLIFFS.tree(false));
    // Deeper: block 5. Nearer: the first part of block 7. With a shape: blocks 7 and 15, the second part of 7, eight
    // leaves of 6, the leaf of 8, and the part of the pattern.
    assert_eq!(wide_differences(&tree), [1, 1, 13]);
    let found = Meanings::of(&tree);
    // Out of reach of a near pointer: the last block, its part that is far behind, and the leaf in block 8. Within
    // reach, nothing is copied.
    let copied = [3, 5, 7, 9].map(|level| found.copied(level).count());
    assert_eq!(copied, [1, 1, 1, 0]);
    for level in [3, 5, 7] {
        let places: Vec<u32> = found.copied(level).flat_map(|s| s.halves.keys().map(|&(_, at)| at)).collect();
        let apart = places.iter().max().zip(places.iter().min()).map(|(last, first)| last - first);
        assert!(places.len() == 2 && apart >= Some(NEAR), "{level}: {places:?}");
    }
}

#[test]
fn wide_difference_to_a_far_shape_of_the_common_section_takes_a_copy_into_the_page() {
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
    for s in found.shapes.iter().filter(|s| s.level == 7) { eprintln!("{:?} {:?}", s.halves, s.pages); }
    let page = tree.page([0, 0]);
    let root = page.root & !IN_PAGE;
    let code = Code { words: page.words };
    eprintln!("{root} {:?} {:x?}", (0..16).map(|c| code.child(root, c)).collect::<Vec<_>>(), (0..50).map(|k| code.half(root + k)).collect::<Vec<_>>());
    eprintln!("{} {:?}", tree.common().len(), wide_differences(&tree));
    let copied: Vec<&Found> = found
        .shapes
        .iter()
        .filter(|shape| {
            let is_common = |&(part, at): &(Where, u32)| part.is_none() && at >= NEAR;
            shape.halves.keys().any(is_common) && shape.halves.len() > 1
        })
        .collect();
    let levels: Vec<u32> = copied.iter().map(|shape| shape.level).collect();
    assert!(levels.contains(&7), "{levels:?}");
    for shape in copied {
        let parts: HashSet<Where> = shape.halves.keys().map(|&(part, _)| part).collect();
        assert_eq!(parts, [None, Some(0), Some(1), Some(2), Some(3)].into(), "level {}", shape.level);
        assert_eq!(shape.halves.len(), 5);
    }
}
