//! Encodes trees of the layout `depths` half-word by half-word, and decodes their leaves according to the
//! specification.

use adumbra::layout::depths::code::FAR;
use adumbra::layout::depths::page::{IN_PAGE, PAGE_LEVEL, Page, bundles, page_dims, pages_of};
use adumbra::layout::depths::{DepthTree, DepthsError, LEAF_LEVEL, NODE_LEVELS, TreeBuilder};
use adumbra_scene::random::Random;

/// Number of leaves along a side of a page.
const LEAVES_ACROSS: usize = 1 << (PAGE_LEVEL - LEAF_LEVEL);

/// A leaf as the specification describes it.
#[derive(Clone, Debug, Default)]
pub struct Leaf {
    /// Gradient of the planes in quarters of a voxel per column along x and y, if the leaf is slanted.
    pub slant: Option<[i8; 2]>,
    /// Bytes per difference: 1, 2 or 4.
    pub width: u32,
    /// Differences between successive depths.
    pub differences: Vec<u32>,
    /// Whether one more depth, after those of the differences, never switches.
    pub never: bool,
    /// Rank of each column among the depths, at index y · 8 + x.
    pub ranks: Vec<u32>,
}

impl Leaf {
    /// Returns a leaf with one depth on planes of this gradient.
    pub fn plane(slant: [i8; 2]) -> Self {
        Self { slant: Some(slant), width: 1, ranks: vec![0; 64], ..Self::default() }
    }

    /// Returns the depth at which a column switches, according to the specification. `None` if it never does.
    pub fn depth(&self, base: u32, column: usize) -> Option<u32> {
        let rank = self.ranks[column] as usize;
        let differences = self.differences.get(..rank)?;
        let depth = differences.iter().fold(u64::from(base), |sum, &d| sum + u64::from(d));
        let depth = depth.min(u64::from(u32::MAX));
        let along = |g: i8, at: usize| i64::from(g).abs() * if g > 0 { 7 - at } else { at } as i64;
        let [x, y] = self.slant.unwrap_or_default();
        let rise = (along(x, column % 8) + along(y, column / 8) + 3) >> 2;
        Some((depth as i64 - rise).max(0) as u32)
    }

    fn halves(&self) -> Vec<u16> {
        let last = self.differences.len() as u16 + u16::from(self.never);
        let slanted = u16::from(self.slant.is_some());
        let mut halves =
            vec![last | u16::from(self.never) << 6 | (self.width.ilog2() as u16) << 7 | slanted << 9];
        halves.extend(self.slant.map(|[x, y]| u16::from(x as u8) | u16::from(y as u8) << 8));
        let bytes =
            self.differences.iter().flat_map(|d| d.to_le_bytes().into_iter().take(self.width as usize));
        let bytes: Vec<u8> = bytes.collect();
        halves.extend(bytes.chunks(2).map(|b| u16::from(b[0]) | u16::from(*b.get(1).unwrap_or(&0)) << 8));
        for plane in 0..16 - last.leading_zeros() {
            for sixteen in self.ranks.chunks(16) {
                halves.push((0..16).fold(0, |half, i| half | ((sixteen[i] >> plane & 1) as u16) << i));
            }
        }
        halves
    }
}

/// Builds a tree from `leaves`, in rows of `row` leaves, each written once per place and reached through far
/// pointers. All leaves have the base `base`.
///
/// # Errors
/// Returns the fault if a leaf is not valid.
pub fn from_leaves(leaves: &[Leaf], row: usize, base: u32, depth: u32) -> Result<DepthTree, DepthsError> {
    let rows = leaves.len() / row;
    let size = [8 * row as u32, 8 * rows as u32, depth];
    let mut builder = TreeBuilder::new(size, Vec::new());
    let dims = page_dims(size);
    for bundle in bundles(dims) {
        let made = pages_of(bundle, dims).map(|place| {
            place.map(|[x, y]| {
                let mut halves = Vec::new();
                let leaf = |[i, j]: [usize; 2]| (i < row && j < rows).then(|| &leaves[j * row + i]);
                let corner = [x, y].map(|c| c as usize * LEAVES_ACROSS);
                let root = shape(&mut halves, &leaf, PAGE_LEVEL, corner).expect("a page with leaves");
                halves.resize(halves.len().next_multiple_of(2), 0);
                let word = |h: &[u16; 2]| u32::from(h[0]) | u32::from(h[1]) << 16;
                (root, halves.as_chunks::<2>().0.iter().map(word).collect::<Vec<u32>>())
            })
        });
        builder.add(
            bundle,
            &made.each_ref().map(|page| match page {
                Some((root, words)) => Page { root: IN_PAGE | root, base, words },
                None => Page::OUTSIDE,
            }),
        );
    }
    builder.finish()
}

/// Writes the block of `level` whose first leaf is at a place, and returns its address. `None` if it has no
/// leaves.
fn shape<'l>(
    halves: &mut Vec<u16>,
    leaf: &impl Fn([usize; 2]) -> Option<&'l Leaf>,
    level: u32,
    [x, y]: [usize; 2],
) -> Option<u32> {
    if level == LEAF_LEVEL {
        let at = halves.len() as u32;
        halves.extend(leaf([x, y])?.halves());
        return Some(at);
    }
    let step = 1 << (level - NODE_LEVELS - LEAF_LEVEL);
    let children: Vec<Option<u32>> = (0..16)
        .map(|c| shape(halves, leaf, level - NODE_LEVELS, [x + c % 4 * step, y + c / 4 * step]))
        .collect();
    if children.iter().all(Option::is_none) {
        return None;
    }
    let at = halves.len() as u32;
    let there = (0..16).filter(|&c| children[c].is_some()).fold(0_u16, |bits, c| bits | 1 << c);
    // Children with the same base, each reached through a far pointer. The other children never switch.
    halves.extend([there, there, !there]);
    halves.extend(children.into_iter().flatten().flat_map(|to| {
        let far = FAR | (at - to);
        [0, far as u16, (far >> 16) as u16]
    }));
    Some(at)
}

/// Returns one plane leaf for every gradient, in rows of 256.
pub fn every_gradient() -> Vec<Leaf> {
    let all = (0..=u16::MAX).map(|half| [half as u8 as i8, (half >> 8) as u8 as i8]);
    all.map(Leaf::plane).collect()
}

/// Returns 16 leaves with any slants, ranks and differences. Every third `case` has small differences, and
/// every fourth has many.
pub fn random_leaves(random: &mut Random, case: usize) -> Vec<Leaf> {
    let mut below = |n: u32| (random.unit() * f64::from(n)) as u32;
    let leaf = |_| {
        let width = 1 << below(3);
        let largest = [0, 255, 65_535, 0, u32::MAX][width as usize];
        let count = 1 + below(if case.is_multiple_of(4) { 62 } else { 5 });
        let never = below(2) == 1;
        Leaf {
            slant: (below(3) > 0).then(|| [below(256) as u8 as i8, below(256) as u8 as i8]),
            width,
            differences: (0..count)
                .map(|_| below(if case.is_multiple_of(3) { 40 } else { largest }))
                .collect(),
            never,
            ranks: (0..64).map(|_| below(count + 1 + u32::from(never))).collect(),
        }
    };
    (0..16).map(leaf).collect()
}

/// Bases at both ends of their range and between them.
pub const BASES: [u32; 9] = [0, 1, 13, 448, 5000, 1 << 31, u32::MAX - 449, u32::MAX - 7, u32::MAX];
