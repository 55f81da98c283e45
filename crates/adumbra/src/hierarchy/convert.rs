//! Between the hierarchy and anything that answers slabs.

use std::collections::{HashMap, HashSet};

use super::choose::{BESIDE_GRID, FREE_TO_END};
use super::code::Child;
use super::sink::HierarchySink;
use super::{Hierarchy, LEAF_LEVEL, NEVER, NODE_LEVELS, UNIFORM};
use crate::bake::graph_sink::GraphSink;
use crate::bake::sink::{BlockColumns, BlockSink};
use crate::dag::store::{NodeState, NodeStore};
use crate::dag::{Dag, MAX_CONVERTED_DEPTH, Slabs, TooLarge};

/// Most blocks of 8 × 8 columns that are looked at to make a hierarchy: 65,536 × 65,536 columns.
const MAX_BLOCKS: u64 = 1 << 26;
/// How many times as large as a hierarchy its graph may be, in bytes and in visits to shapes.
const MAX_GROWTH: u64 = 64;
/// Visits to shapes that are always allowed: all blocks of 32,768 × 32,768 columns.
const MIN_SHAPES_LIMIT: u64 = 1 << 24;
/// Bytes that a graph may always have.
const MIN_BYTES_LIMIT: u64 = 1 << 30;

impl Hierarchy {
    /// A hierarchy of the same defined voxels as `slabs`, which may say anything where a column is free: each column gets one depth at which it
    /// switches there. `root_level` is the bake's.
    ///
    /// Cost: some ten look-ups a block of 8 × 8 columns, more where silhouettes pass; on one thread.
    ///
    /// # Errors
    /// [`TooLarge`] for more than 2^26 blocks of 8 × 8 columns, or 2^31 voxels along the light.
    pub fn of_slabs(slabs: &dyn Slabs, root_level: u32) -> Result<Self, TooLarge> {
        let [nx, ny, nz] = slabs.size();
        TooLarge::check("voxels along the light", nz.into(), MAX_CONVERTED_DEPTH)?;
        let blocks = u128::from(nx.div_ceil(8)) * u128::from(ny.div_ceil(8));
        TooLarge::check("blocks of 8 x 8 columns", blocks, MAX_BLOCKS)?;
        let level = root_level.max(LEAF_LEVEL + NODE_LEVELS);
        let sink = HierarchySink::new(level, true, None);
        let size = slabs.size();
        let corners = |n: u32| (0..n).step_by(1 << level);
        let block = |(y, x)| block_of(slabs, &sink, level, [x, y]);
        let blocks =
            corners(size[1]).flat_map(|y| corners(size[0]).map(move |x| (y, x))).map(block).collect();
        Ok(sink.finish(size, level, blocks))
    }

    /// The graph of the same voxels; the hierarchy must be valid. Cost: that of all shapes of different roots as if none were shared.
    ///
    /// # Errors
    /// [`TooLarge`] where few bytes stand for far more: for more than 2^24 root cubes, 2^31 voxels along the light, more than 2^24 shapes and 64 times as many as the
    /// hierarchy has, or more bytes than 2^30 and 64 times its own.
    pub fn to_dag(&self) -> Result<Dag, TooLarge> {
        TooLarge::check_roots(self.size, self.root_level)?;
        self.check_shapes()?;
        let most_bytes = MIN_BYTES_LIMIT + MAX_GROWTH * self.bytes();
        let store = NodeStore::default();
        let sink = GraphSink::new(&store, self.size[2]);
        let dims = Dag::top_dims_covering(self.size, self.root_level);
        // Roots along the light of each different root, and which of them each column has.
        let mut roots: Vec<Vec<NodeState>> = Vec::new();
        let mut known = HashMap::new();
        let mut columns = Vec::with_capacity(self.top.len());
        for &[at, base] in &self.top {
            let column = *known.entry([at, base]).or_insert(roots.len());
            if column == roots.len() {
                let runs = self.blocks(&sink, at, base, self.root_level);
                roots.push(sink.roots(&runs, self.root_level, dims[2]));
                TooLarge::check("bytes of nodes", store.graph_bytes().into(), most_bytes)?;
            }
            columns.push(column);
        }
        if store.is_full() {
            return Err(TooLarge::words());
        }
        let top: Vec<_> = (0..dims[2] as usize)
            .flat_map(|z| columns.iter().map(move |&column| (column, z)))
            .map(|(column, z)| roots[column][z])
            .collect();
        Ok(store.finish(self.size, self.root_level, dims, &top))
    }

    /// That the different roots, their shapes as if none were shared, are not far more than the shapes that there are.
    fn check_shapes(&self) -> Result<(), TooLarge> {
        let mut known = HashMap::new();
        let roots: HashSet<[u32; 2]> = self.top.iter().filter(|root| root[0] != UNIFORM).copied().collect();
        let visits =
            roots.iter().map(|&[at, _]| u128::from(self.visits(&mut known, at, self.root_level))).sum();
        TooLarge::check("shapes", visits, MIN_SHAPES_LIMIT.max(MAX_GROWTH * known.len() as u64))
    }

    /// Shapes below and with one, as if none were shared: at most some thousands.
    fn visits(&self, known: &mut HashMap<(u32, u32), u32>, at: u32, level: u32) -> u32 {
        if let Some(&visits) = known.get(&(at, level)) {
            return visits;
        }
        let mut visits = 1;
        for child in (0..16).filter(|_| level > LEAF_LEVEL) {
            if let Child::Shape { at, .. } = self.shapes().child(at, child) {
                visits += self.visits(known, at, level - NODE_LEVELS);
            }
        }
        known.insert((at, level), visits);
        visits
    }

    /// A shape as a block of any sink's.
    fn blocks<S: BlockSink>(&self, sink: &S, at: u32, base: u32, level: u32) -> S::Block {
        if at == UNIFORM {
            return sink.uniform(level, self.interval(base));
        }
        let shapes = self.shapes();
        if level == LEAF_LEVEL {
            let mut columns = BlockColumns::free();
            let leaf = shapes.leaf(at, base);
            for column in 0..64 {
                [columns.e[column], columns.x[column]] = self.interval(leaf.value(column as u32));
            }
            return sink.leaf(&columns);
        }
        let below = level - NODE_LEVELS;
        let child = |c: u32| match shapes.child(at, c) {
            Child::Never => sink.uniform(below, self.interval(NEVER)),
            Child::Uniform(delta) => sink.uniform(below, self.interval(base.wrapping_add(delta))),
            Child::Shape { at, delta } => self.blocks(sink, at, base.wrapping_add(delta), below),
        };
        let place =
            |quarter: u32, part: u32| ((quarter & 1) * 2 + (part & 1)) * 4 + (quarter >> 1) * 2 + (part >> 1);
        let quarter = |q: u32| sink.join(level - 1, [0, 1, 2, 3].map(|part| child(place(q, part))));
        sink.join(level, [0, 1, 2, 3].map(quarter))
    }

    /// What a column that switches at `value` allows: that alone.
    fn interval(&self, value: u32) -> [u32; 2] {
        if value >= self.size[2] { [self.size[2], FREE_TO_END] } else { [value; 2] }
    }
}

/// The block from a corner on.
fn block_of(
    slabs: &dyn Slabs,
    sink: &HierarchySink,
    level: u32,
    [x, y]: [u32; 2],
) -> <HierarchySink as BlockSink>::Block {
    let [nx, ny, nz] = slabs.size();
    if x >= nx || y >= ny {
        return sink.uniform(level, [0, BESIDE_GRID]);
    }
    if level > LEAF_LEVEL {
        let half = 1 << (level - 1);
        let corner = |q: u32| [x + (q >> 1) * half, y + (q & 1) * half];
        return sink.join(level, [0, 1, 2, 3].map(|q| block_of(slabs, sink, level - 1, corner(q))));
    }
    let mut columns = BlockColumns::free();
    let inside =
        (0..64).filter(|i| x + (i & 7) < nx && y + (i >> 3) < ny).fold(0_u64, |mask, i| mask | 1 << i);
    let ends_lit = slabs.slab(x, y, nz - 1) & inside;
    // Columns, a depth before which they are lit, and one at which they are shadowed: between them each switches.
    let mut open = vec![(inside & !ends_lit, 0, nz - 1)];
    while let Some((mask, low, high)) = open.pop() {
        if mask == 0 {
            continue;
        }
        if low < high {
            let middle = low + (high - low) / 2;
            let lit = slabs.slab(x, y, middle) & mask;
            open.extend([(lit, middle + 1, high), (mask & !lit, low, middle)]);
            continue;
        }
        for i in (0..64).filter(|i| mask >> i & 1 == 1) {
            (columns.e[i], columns.x[i]) = (low, low);
        }
    }
    for i in (0..64).filter(|i| ends_lit >> i & 1 == 1) {
        columns.e[i] = nz;
    }
    sink.leaf(&columns)
}
