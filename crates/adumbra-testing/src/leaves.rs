//! Encodes trees of the layout `depths` half-word by half-word, and decodes their leaves according to the
//! specification.

use adumbra::layout::depths::DepthTree;

/// Number of leaves along a side of a root of level 5.
const LEAVES: usize = 4;

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

/// Builds a tree with roots of level 5 from `leaves`, in rows of `row` leaves. `row` and the number of rows are
/// multiples of four, so that every root is complete. All leaves have the base `base`.
pub fn from_leaves(leaves: &[Leaf], row: usize, base: u32, depth: u32) -> DepthTree {
    let rows = leaves.len() / row;
    let mut halves: Vec<u16> = Vec::new();
    let places: Vec<u32> = leaves
        .iter()
        .map(|leaf| {
            let at = halves.len() as u32;
            halves.extend(leaf.halves());
            at
        })
        .collect();
    let mut top = Vec::new();
    for y in (0..rows).step_by(LEAVES) {
        for x in (0..row).step_by(LEAVES) {
            top.push([halves.len() as u32, base]);
            // Sixteen shapes with the same base, each through a far pointer.
            halves.extend([0, 0xffff, 0]);
            let places = (0..16).map(|c| places[(y + c / LEAVES) * row + x + c % LEAVES]);
            halves.extend(places.flat_map(|at| [at as u16, (at >> 16) as u16]));
        }
    }
    halves.resize(halves.len().next_multiple_of(2), 0);
    DepthTree {
        size: [8 * row as u32, 8 * rows as u32, depth],
        root_level: 5,
        top_dims: [(row / LEAVES) as u32, (rows / LEAVES) as u32],
        top,
        wide: Vec::new(),
        code: halves.as_chunks::<2>().0.iter().map(|h| u32::from(h[0]) | u32::from(h[1]) << 16).collect(),
    }
}

/// Returns one plane leaf for every gradient, in rows of 256.
pub fn every_gradient() -> Vec<Leaf> {
    let all = (0..=u16::MAX).map(|half| [half as u8 as i8, (half >> 8) as u8 as i8]);
    all.map(Leaf::plane).collect()
}
