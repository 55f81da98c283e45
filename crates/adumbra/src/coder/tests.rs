//! Round trips of random shapes, and garbage.

use super::contour::{Leaf, NEVER_CELL, Outline};
use super::rans::{Bit, Coder, Decoder, Encoder, Symbol};
use super::shapes::{Layout, Pool};
use super::walk::Walk;
use super::{
    Common, DECODING_RATIO, Fault, decode_bundle, decode_common, encode_bundle, encode_common, least_bytes,
};
use crate::layout::depths::child::{Child, Children};
use crate::layout::depths::leaf::MOST_HALVES;
use crate::layout::depths::page::{BUNDLE_PAGES, IN_PAGE, Page};
use crate::layout::depths::shapes::ShapeList;
use crate::layout::depths::write::Writer;
use crate::layout::depths::{NEVER, ShapePlace, UNIFORM};

/// A deterministic pseudo-random sequence (xorshift).
struct Random(u32);

impl Random {
    fn below(&mut self, limit: u32) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0 % limit
    }
}

/// Shapes of a part under construction, behind those of a common section.
struct PartBuilder<'c> {
    common: &'c Common,
    own: ShapeList,
    random: Random,
}

/// A page that owns its words.
#[derive(Clone, Debug, PartialEq)]
struct OwnedPage {
    root: u32,
    base: u32,
    words: Vec<u32>,
}

type Pages = [OwnedPage; BUNDLE_PAGES];

fn pages_of(owned: &Pages) -> [Page<'_>; BUNDLE_PAGES] {
    owned.each_ref().map(|page| Page { root: page.root, base: page.base, words: &page.words })
}

impl<'c> PartBuilder<'c> {
    fn new(common: &'c Common, seed: u32) -> Self {
        Self { common, own: ShapeList::default(), random: Random(seed) }
    }

    /// Adds a leaf of any number of depths, some slanted, some with columns that never switch, some with
    /// large differences.
    fn leaf(&mut self) -> u32 {
        let r = &mut self.random;
        let last = [1, 1, 2, 3, 5, 9, 15, 16, 20, 63][r.below(10) as usize];
        let mut leaf = Leaf { last, never: r.below(2) == 1, ..Leaf::EMPTY };
        leaf.slant = r.below(2) * (1 + r.below(0xffff));
        let width = r.below(3);
        for difference in &mut leaf.differences[..(last - u32::from(leaf.never)) as usize] {
            *difference = match width {
                0 => 1 + r.below(255),
                1 => 256 + r.below(60_000),
                _ => 70_000 + r.below(1 << 24),
            };
        }
        for (c, rank) in (0..).zip(&mut leaf.ranks) {
            *rank = if r.below(3) > 0 { c / 8 % (last + 1) } else { r.below(last + 1) } as u8;
        }
        let mut buffer = [0; MOST_HALVES];
        self.common.shapes.len() + self.own.push_leaf(leaf.halves(&mut buffer).iter().copied())
    }

    fn node(&mut self, level: u32, children: Children<u32>) -> u32 {
        self.common.shapes.len() + self.own.push_node(level, &children)
    }

    /// Adds a node of random children. `known` are shapes of the level below.
    fn random_node(&mut self, level: u32, known: &mut Vec<u32>, wide: bool) -> u32 {
        let mut children = [Child::Never; 16];
        for child in &mut children {
            let delta = match self.random.below(4) {
                0 => 0,
                1 if wide => self.random.below(1 << 22).wrapping_sub(1 << 21),
                2 => self.random.below(9).wrapping_sub(4),
                _ => self.random.below(20_000),
            };
            *child = match self.random.below(4) {
                0 => Child::Never,
                1 => Child::Uniform(delta),
                2 if !known.is_empty() => {
                    Child::Shape { shape: known[self.random.below(known.len() as u32) as usize], delta }
                }
                _ => {
                    let shape = if level == 5 {
                        self.leaf()
                    } else {
                        self.random_node(level - 2, &mut Vec::new(), wide)
                    };
                    known.push(shape);
                    Child::Shape { shape, delta }
                }
            };
        }
        self.node(level, children)
    }

    fn pages(&self, roots: &[(u32, u32)]) -> Pages {
        let mut layout = Layout::of_pages(self.common, &self.own, usize::MAX);
        std::array::from_fn(|i| {
            let &(base, root) = roots.get(i).unwrap_or(&(NEVER, UNIFORM));
            let root = match root {
                UNIFORM => Child::Uniform(base),
                shape => Child::Shape { shape, delta: base },
            };
            let (root, words) = layout.page(root).expect("a page");
            OwnedPage { root, base, words }
        })
    }
}

/// Returns a common section of this many leaves and a few nodes, as an encoder has it, and its words.
fn common_of(seed: u32, leaves: usize) -> (Common, Vec<u32>) {
    let none = Common::default();
    let mut b = PartBuilder::new(&none, seed);
    let known: Vec<u32> = (0..leaves).map(|_| b.leaf()).collect();
    let mut levels = vec![3; leaves];
    for level in [5, 5, 5, 7, 7, 9] {
        let before = b.own.len();
        b.random_node(level, &mut if level == 5 { known.clone() } else { Vec::new() }, true);
        let of = |index: &u32| [3, 5, 7, 9].into_iter().find(|&level| b.own.of_level(level).contains(index));
        levels.extend((before..b.own.len()).map(|index| of(&index).expect("a level")));
    }
    let (common, words) = Common::lay_out(b.own, usize::MAX).expect("a common section");
    let places: Vec<ShapePlace> =
        common.addresses.iter().zip(levels).map(|(&at, level)| ShapePlace { at, level }).collect();
    (Common::new(&words, &places).expect("a common section that is written in order"), words)
}

fn word_count(pages: &Pages) -> usize {
    48 + pages.iter().map(|page| page.words.len()).sum::<usize>()
}

fn restored(words: &[u32]) -> Pages {
    let mut first = 48;
    std::array::from_fn(|i| {
        let length = words[3 * i + 2] as usize;
        first += length;
        OwnedPage { root: words[3 * i], base: words[3 * i + 1], words: words[first - length..first].to_vec() }
    })
}

fn check(pages: &Pages, common: &Common) -> Vec<u8> {
    let bytes = encode_bundle(&pages_of(pages), common).expect("pages that are written in order");
    let words = decode_bundle(&bytes, word_count(pages), common).expect("coded bytes");
    assert_eq!(&restored(&words), pages);
    bytes
}

#[test]
fn bits_symbols_and_numbers_round_trip() {
    fn code(coder: &mut impl Coder, mut seen: impl FnMut(u32, u32)) {
        let (mut random, mut bit, mut symbol) = (Random(7), [Bit::NEW; 2], [Symbol::NEW; 2]);
        for i in 0..20_000 {
            // Rare symbols, frequent symbols, and changes of which symbol is frequent.
            let rare = random.below(50) == 0;
            let value = if rare { random.below(16) } else { i / 5000 * 5 };
            seen(value, coder.symbol(&mut symbol[(i & 1) as usize], value));
            seen(value & 1, coder.bit(&mut bit[(i & 1) as usize], value & 1));
            let (count, number) = (i % 33, random.below(u32::MAX));
            let number = if count == 32 { number } else { number & ((1 << count) - 1) };
            seen(number, coder.plain(count, number));
        }
    }
    let mut encoder = Encoder::default();
    code(&mut encoder, |_, _| ());
    let bytes = encoder.finish(0);
    let mut decoder = Decoder::new(&bytes);
    code(&mut decoder, |expected, found| assert_eq!(expected, found));
    assert_eq!(decoder.finish(0), Ok(()));
}

#[test]
fn bundle_of_uniform_pages_is_restored() {
    let none = Common::default();
    let b = PartBuilder::new(&none, 1);
    check(&b.pages(&[]), &none);
    check(&b.pages(&[(0, UNIFORM), (7, UNIFORM), (NEVER - 1, UNIFORM)]), &none);
}

#[test]
fn bundle_of_random_pages_is_restored() {
    for seed in 1..8 {
        let none = Common::default();
        let mut b = PartBuilder::new(&none, seed);
        let mut known = Vec::new();
        let roots: Vec<_> =
            (0..16).map(|i| (i * 1000, b.random_node(9, &mut known, seed % 2 == 0))).collect();
        check(&b.pages(&roots), &none);
    }
}

#[test]
fn references_to_the_common_section_are_restored() {
    let (common, words) = common_of(5, 3000);
    assert!(words.len() > 1 << 15, "{}", words.len());
    let list = |level| common.shapes.of_level(level).to_vec();
    let bytes = encode_common(&common, words.len()).unwrap();
    let (decoded, found) = decode_common(&bytes, words.len()).unwrap();
    assert_eq!(found, words);
    // A root in the common section, and nodes of its leaves, near and far, with small and large differences.
    let mut b = PartBuilder::new(&common, 9);
    let mut roots = vec![(50, list(9)[0])];
    let leaves = list(3);
    for k in 0..4 {
        let below = std::array::from_fn(|c| Child::Shape {
            shape: leaves[(c * 181 + k * 7) % leaves.len()],
            delta: [0, 5, 1 << 20, 70_000][k],
        });
        let five = b.node(5, below);
        let seven = b.node(7, [Child::Shape { shape: five, delta: 100_000 * k as u32 }; 16]);
        roots.push((3, b.node(9, [Child::Shape { shape: seven, delta: 1 }; 16])));
    }
    let pages = b.pages(&roots);
    let bytes = check(&pages, &common);
    assert_eq!(decode_bundle(&bytes, word_count(&pages), &decoded).map(|words| restored(&words)), Ok(pages));
}

#[test]
fn far_pointers_of_a_large_page_are_restored() {
    let none = Common::default();
    let mut b = PartBuilder::new(&none, 77);
    let first = b.leaf();
    let mut seven = [Child::Never; 16];
    let mut nine = [Child::Never; 16];
    for (i, nine) in nine.iter_mut().enumerate() {
        for child in &mut seven {
            let mut five = [Child::Shape { shape: first, delta: 0 }; 16];
            for (c, child) in five.iter_mut().enumerate().skip(1) {
                *child = Child::Shape { shape: b.leaf(), delta: c as u32 - 1 };
            }
            five[15] = Child::Shape { shape: first, delta: if i % 2 == 0 { 1 << 17 } else { 3 } };
            *child = Child::Shape { shape: b.node(5, five), delta: 0 };
        }
        *nine = Child::Shape { shape: b.node(7, seven), delta: 9 };
    }
    let root = b.node(9, nine);
    let pages = b.pages(&[(0, root), (0, root)]);
    assert!(word_count(&pages) > 1 << 16, "{}", word_count(&pages));
    check(&pages, &none);
}

#[test]
fn rejects_pages_that_decoder_would_not_restore() {
    let none = Common::default();
    let mut b = PartBuilder::new(&none, 3);
    let leaf = b.leaf();
    let mut root = leaf;
    for level in [5, 7, 9] {
        root = b.node(level, [Child::Shape { shape: root, delta: 1 }; 16]);
    }
    let pages = b.pages(&[(0, root)]);
    check(&pages, &none);
    let with = |words: Vec<u32>, root: u32| {
        let mut pages = pages.clone();
        pages[0] = OwnedPage { root, words, ..pages[0].clone() };
        encode_bundle(&pages_of(&pages), &none)
    };
    let OwnedPage { root, words, .. } = pages[0].clone();
    // Unreferenced words, after the root and before the first shape.
    assert_eq!(with([&words[..], &[0]].concat(), root), Err(Fault));
    assert_eq!(with([&[0], &words[..]].concat(), root + 2), Err(Fault));
    // A uniform page with words, and a root in the common section, which is empty.
    assert_eq!(with(words, UNIFORM), Err(Fault));
    assert_eq!(with(Vec::new(), 0), Err(Fault));
    assert_eq!(root & IN_PAGE, IN_PAGE);
}

#[test]
fn rejects_garbage_or_decodes_exact_word_count() {
    let (common, common_words) = common_of(11, 40);
    let mut b = PartBuilder::new(&common, 21);
    let mut known = common.shapes.of_level(7).to_vec();
    let roots: Vec<_> = (0..3).map(|i| (i, b.random_node(9, &mut known, true))).collect();
    let pages = b.pages(&roots);
    let bytes = check(&pages, &common);
    let words = word_count(&pages);
    let decode = |bytes: &[u8], words| decode_bundle(bytes, words, &common);
    for length in (0..bytes.len()).step_by(37) {
        assert_eq!(decode(&bytes[..length], words), Err(Fault), "{length}");
    }
    for more in [&[0_u8][..], &[0, 0], &[1, 2, 3]] {
        assert_eq!(decode(&[&bytes, more].concat(), words), Err(Fault));
    }
    for other in [0, 1, 47, 48, words - 1, words + 1, 2 * words] {
        assert_eq!(decode(&bytes, other), Err(Fault), "{other}");
    }
    let coded_common = encode_common(&common, common_words.len()).unwrap();
    for length in (0..coded_common.len()).step_by(37) {
        assert!(decode_common(&coded_common[..length], common_words.len()).is_err(), "{length}");
    }
    let mut random = Random(99);
    for _ in 0..60 {
        let mut flipped = bytes.clone();
        let at = random.below(bytes.len() as u32) as usize;
        flipped[at] ^= 1 << random.below(8);
        // A flipped bit of a plain number decodes to other words. Only the file's checksums detect that.
        if let Ok(found) = decode(&flipped, words) {
            assert_eq!(found.len(), words);
        }
        let noise: Vec<u8> = (0..random.below(500)).map(|_| random.below(256) as u8).collect();
        assert!(decode(&noise, 1 << 19).is_err());
        assert!(decode_common(&noise, 1 << 15).is_err());
        assert!(decode_common(&flipped, words).is_err());
    }
}

#[test]
fn pads_highly_compressible_part_with_zeros() {
    let none = Common::default();
    let mut b = PartBuilder::new(&none, 1);
    let mut leaf = Leaf { last: 1, ..Leaf::EMPTY };
    leaf.differences[0] = 5;
    leaf.ranks[32..].fill(1);
    let mut buffer = [0; MOST_HALVES];
    let halves = leaf.halves(&mut buffer);
    for _ in 0..2000 {
        b.own.push_leaf(halves.iter().copied());
    }
    let (common, words) = Common::lay_out(b.own, usize::MAX).unwrap();
    assert_eq!(words.len(), 6000);
    let bytes = encode_common(&common, words.len()).unwrap();
    assert_eq!(bytes.len(), least_bytes(words.len()));
    assert_eq!(bytes.len(), 1500);
    let coded = bytes.iter().rposition(|&byte| byte != 0).unwrap();
    assert!((100..1400).contains(&coded), "{coded}");
    let decode = |bytes: &[u8]| decode_common(bytes, words.len()).map(|(_, words)| words);
    assert_eq!(decode(&bytes).as_ref(), Ok(&words));
    let (but_two, last) = bytes.split_at(1498);
    assert_eq!(last, [0; 2]);
    for end in [&[][..], &[0], &[0, 1], &[1, 0], &[0, 0, 0], &[0, 0, 0, 0]] {
        assert_eq!(decode(&[but_two, end].concat()), Err(Fault), "{end:?}");
    }

    // Pages that are equal.
    let mut b = PartBuilder::new(&none, 5);
    let root = b.random_node(9, &mut Vec::new(), false);
    let pages = b.pages(&[(0, root); BUNDLE_PAGES]);
    let bytes = check(&pages, &none);
    assert_eq!(bytes.len(), least_bytes(word_count(&pages) - 48));
}

#[test]
fn outline_subtracts_rise_only_where_columns_switch() {
    let mut leaf = Leaf { last: 2, never: true, slant: 0x0404, ..Leaf::EMPTY };
    leaf.differences[0] = 1 << 31;
    leaf.ranks = std::array::from_fn(|c| [1, 2][c % 2]);
    let outline = Outline::of(leaf.halves(&mut [0; MOST_HALVES]));
    // Columns 0 and 1 of row 7: the first has the depth 2^31 minus the rise of 7 columns, the second never
    // switches.
    assert_eq!(outline.cells[..2], [(1 << 31) - 7, NEVER_CELL]);
}

#[test]
fn decoder_counts_children_against_half_word_limit() {
    // A node whose 16 children are uniform at their own depths takes 3 + 16 half-words.
    let none = Common::default();
    let mut b = PartBuilder::new(&none, 2);
    let mut root = b.node(5, [Child::Uniform(3); 16]);
    for level in [7, 9] {
        root = b.node(
            level,
            std::array::from_fn(
                |c| if c == 0 { Child::Shape { shape: root, delta: 1 } } else { Child::Never },
            ),
        );
    }
    let pages = b.pages(&[(0, root)]);
    let bytes = check(&pages, &none);
    let source = Pool { common: &none.shapes, own: &none.shapes };
    let decode = |halves| {
        Walk::new(Decoder::new(&bytes), &none.shapes, source, halves)
            .pages([Child::Never; BUNDLE_PAGES])
            .is_ok()
    };
    assert!(decode(3 * 3 + 16 + 2) && !decode(3 * 3 + 16 + 1));
}

#[test]
fn memory_of_shape_lists_is_within_decoding_ratio() {
    let far = Child::Shape { shape: 0, delta: 1 << 17 };
    let nodes = [
        [Child::Never; 16],
        [Child::Uniform(0); 16],
        [Child::Uniform(3); 16],
        [Child::Shape { shape: 0, delta: 0 }; 16],
        [far; 16],
        std::array::from_fn(|c| if c == 5 { Child::Shape { shape: 0, delta: 0 } } else { Child::Never }),
    ];
    let mut buffer = [0; MOST_HALVES];
    let mut all_taken = Vec::new();
    for kind in 0..=nodes.len() {
        let mut shapes = ShapeList::default();
        let smallest = Leaf { slant: 1, ..Leaf::EMPTY };
        shapes.push_leaf(smallest.halves(&mut buffer).iter().copied());
        // A little more than a power of two, so that the lists are half empty.
        for _ in 0..4200 {
            match kind.checked_sub(1) {
                None => shapes.push_leaf(smallest.halves(&mut buffer).iter().copied()),
                Some(kind) => shapes.push_node(5, &nodes[kind]),
            };
        }
        let taken = shapes.bytes();
        let (_, words) = Common::lay_out(shapes, usize::MAX).unwrap();
        all_taken.push(taken as f64 / (4 * words.len()) as f64);
    }
    // Memory of the writer's half-words, their words and their addresses, relative to the words.
    let rest = 2.0 + 1.0 + 2.0;
    let most = all_taken.iter().copied().fold(0.0, f64::max);
    assert!(most + rest <= DECODING_RATIO as f64 && most > 1.0, "{all_taken:?}");
}

/// Forged sections may use one place as shapes of several levels. A node without pointers is valid at any
/// level.
#[test]
fn rejects_section_with_place_of_two_levels() {
    let mut writer = Writer::common();
    let mut children = [Child::Uniform(0); 16];
    children[0] = Child::Uniform(3);
    let at = writer.node(&children).unwrap();
    let words = writer.words();
    let place = |level| ShapePlace { at, level };
    assert!(Common::new(&words, &[place(5)]).is_ok());
    assert_eq!(Common::new(&words, &[place(5), place(7)]).err(), Some(Fault));
}

#[test]
fn frequent_symbols_are_cheap_and_rare_ones_stay_possible() {
    for symbol in 0..16 {
        let mut model = Symbol::NEW;
        for _ in 0..2000 {
            model.adapt(symbol);
        }
        for other in 0..16 {
            let [_, frequency] = model.interval(other);
            let expected = if other == symbol { 31_900..=32_300 } else { 16..=80 };
            assert!(expected.contains(&frequency), "{symbol}, {other}: {frequency}");
        }
    }
    // No frequency reaches 0, however the frequencies change.
    let (mut model, mut random) = (Symbol::NEW, Random(3));
    for i in 0..100_000 {
        model.adapt(if i % 1000 < 900 { i / 1000 % 16 } else { random.below(16) });
        assert!((0..16).all(|symbol| model.interval(symbol)[1] > 0));
    }
}
