//! Conversion between depths and any structure that answers leaf masks.

use std::collections::{HashMap, HashSet};

use crate::dag::roots::top_dims;
use adumbra::layout::depths::child::Child;
use adumbra::layout::depths::{DepthTree, LEAF_LEVEL, NEVER, NODE_LEVELS, UNIFORM};
use adumbra_bake::structure::{
    BESIDE_GRID, BlockColumns, BlockSink, DepthsBlock, DepthsSink, FREE_TO_END, Structure,
};

use crate::dag::build::sink::GraphSink;
use crate::dag::build::store::NodeState;
use crate::dag::plain::Dag;
use crate::dag::{LeafMasks, MAX_CONVERTED_DEPTH, TooLarge};

/// Largest number of 8 × 8 column blocks that are sampled to make depths: 65,536 × 65,536 columns.
const MAX_BLOCKS: u64 = 1 << 26;
/// How many times larger than its depths a graph may be, in bytes and in visits to shapes.
const MAX_GROWTH: u64 = 64;
/// Visits to shapes that are always allowed: all blocks of 32,768 × 32,768 columns.
const MIN_SHAPES_LIMIT: u64 = 1 << 24;
/// Size of a graph in bytes that is always allowed.
const MIN_BYTES_LIMIT: u64 = 1 << 30;

/// Builds depths with the same defined voxels as `leaf_masks`. Where a column is free, `leaf_masks` may
/// answer anything; each column switches at a single depth there. `root_level` is that of the bake.
///
/// Cost: about ten look-ups per block of 8 × 8 columns, more where silhouettes pass; single-threaded.
///
/// # Errors
/// Returns [`TooLarge`] for more than 2^26 blocks of 8 × 8 columns, or more than 2^31 voxels along the light.
pub fn depths_of(leaf_masks: &dyn LeafMasks, root_level: u32) -> Result<DepthTree, TooLarge> {
    let [nx, ny, nz] = leaf_masks.size();
    TooLarge::check("voxels along the light", nz.into(), MAX_CONVERTED_DEPTH)?;
    let blocks = u128::from(nx.div_ceil(8)) * u128::from(ny.div_ceil(8));
    TooLarge::check("blocks of 8 x 8 columns", blocks, MAX_BLOCKS)?;
    let level = root_level.max(LEAF_LEVEL + NODE_LEVELS);
    let size = leaf_masks.size();
    let sink = DepthsSink::in_memory(size, level, true);
    let corners = |n: u32| (0..n).step_by(1 << level);
    let block = |(y, x)| block_of(leaf_masks, &sink, level, [x, y]);
    let blocks = corners(size[1]).flat_map(|y| corners(size[0]).map(move |x| (y, x))).map(block).collect();
    // The sink is in memory and all depths fit a quadtree, so the only possible error is too many words.
    sink.finish(blocks).tree().map_err(|_| TooLarge::words())
}

/// Builds the graph of the same voxels as `depths`, which must be valid. Cost: one visit to each shape below
/// each distinct root, as if no shapes were shared.
///
/// # Errors
/// Returns [`TooLarge`] if a small input would expand too far: more than 2^24 root cubes, more than 2^31
/// voxels along the light, more than 2^24 shapes and 64 times as many as there are, or more than 2^30 bytes
/// and 64 times its own.
pub fn graph_of_depths(depths: &DepthTree) -> Result<Dag, TooLarge> {
    TooLarge::check_roots(depths.size(), depths.root_level())?;
    let reader = Reader { depths };
    reader.check_shapes()?;
    let max_bytes = MIN_BYTES_LIMIT + MAX_GROWTH * depths.bytes();
    let sink = GraphSink::new(depths.size(), depths.root_level());
    let dims = top_dims(depths.size(), depths.root_level());
    // The roots along the light of each distinct root of the depths, and for each column the index of its
    // entry.
    let mut roots: Vec<Vec<NodeState>> = Vec::new();
    let mut known = HashMap::new();
    let mut columns = Vec::with_capacity(depths.top().len());
    for &[at, base] in depths.top() {
        let column = *known.entry([at, base]).or_insert(roots.len());
        if column == roots.len() {
            let runs = reader.blocks(&sink, at, base, depths.root_level());
            roots.push(sink.roots(&runs, depths.root_level(), dims[2]));
            TooLarge::check("bytes of nodes", sink.store().graph_bytes().into(), max_bytes)?;
        }
        columns.push(column);
    }
    if sink.store().is_full() {
        return Err(TooLarge::words());
    }
    let top: Vec<_> = (0..dims[2] as usize)
        .flat_map(|z| columns.iter().map(move |&column| (column, z)))
        .map(|(column, z)| roots[column][z])
        .collect();
    Ok(sink.into_store().finish(depths.size(), depths.root_level(), dims, &top))
}

/// Traverses shapes.
struct Reader<'d> {
    depths: &'d DepthTree,
}

impl Reader<'_> {
    /// Checks that the distinct roots, expanded as if no shapes were shared, do not have far more shapes than
    /// are stored.
    fn check_shapes(&self) -> Result<(), TooLarge> {
        let mut known = HashMap::new();
        let roots: HashSet<[u32; 2]> =
            self.depths.top().iter().filter(|root| root[0] != UNIFORM).copied().collect();
        let visits = roots
            .iter()
            .map(|&[at, _]| u128::from(self.visits(&mut known, at, self.depths.root_level())))
            .sum();
        TooLarge::check("shapes", visits, MIN_SHAPES_LIMIT.max(MAX_GROWTH * known.len() as u64))
    }

    /// Returns the number of shapes at and below a shape, as if none were shared: a few thousand at most.
    fn visits(&self, known: &mut HashMap<(u32, u32), u32>, at: u32, level: u32) -> u32 {
        if let Some(&visits) = known.get(&(at, level)) {
            return visits;
        }
        let mut visits = 1;
        for child in (0..16).filter(|_| level > LEAF_LEVEL) {
            if let Child::Shape { shape, .. } = self.depths.shapes().child(at, child) {
                visits += self.visits(known, shape.at(), level - NODE_LEVELS);
            }
        }
        known.insert((at, level), visits);
        visits
    }

    /// Converts a shape to a block of any sink.
    fn blocks<S: BlockSink>(&self, sink: &S, at: u32, base: u32, level: u32) -> S::Block {
        if at == UNIFORM {
            return sink.uniform(level, self.interval(base));
        }
        let shapes = self.depths.shapes();
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
            Child::Shape { shape, delta } => self.blocks(sink, shape.at(), base.wrapping_add(delta), below),
        };
        let place =
            |quarter: u32, part: u32| ((quarter & 1) * 2 + (part & 1)) * 4 + (quarter >> 1) * 2 + (part >> 1);
        let quarter = |q: u32| sink.join(level - 1, [0, 1, 2, 3].map(|part| child(place(q, part))));
        sink.join(level, [0, 1, 2, 3].map(quarter))
    }

    /// Returns the `[e, x]` of a column that may switch at `value` only.
    fn interval(&self, value: u32) -> [u32; 2] {
        if value >= self.depths.size()[2] { [self.depths.size()[2], FREE_TO_END] } else { [value; 2] }
    }
}

/// Builds the block that starts at a corner.
fn block_of(leaf_masks: &dyn LeafMasks, sink: &DepthsSink, level: u32, [x, y]: [u32; 2]) -> DepthsBlock {
    let [nx, ny, nz] = leaf_masks.size();
    if x >= nx || y >= ny {
        return sink.uniform(level, [0, BESIDE_GRID]);
    }
    if level > LEAF_LEVEL {
        let half = 1 << (level - 1);
        let corner = |q: u32| [x + (q >> 1) * half, y + (q & 1) * half];
        return sink.join(level, [0, 1, 2, 3].map(|q| block_of(leaf_masks, sink, level - 1, corner(q))));
    }
    let mut columns = BlockColumns::free();
    let inside =
        (0..64).filter(|i| x + (i & 7) < nx && y + (i >> 3) < ny).fold(0_u64, |mask, i| mask | 1 << i);
    let ends_lit = leaf_masks.look_up(x, y, nz - 1) & inside;
    // Each entry: columns, a depth before which they are lit, and a depth at which they are shadowed. Each
    // column switches between the two.
    let mut open = vec![(inside & !ends_lit, 0, nz - 1)];
    while let Some((mask, low, high)) = open.pop() {
        if mask == 0 {
            continue;
        }
        if low < high {
            let middle = low + (high - low) / 2;
            let lit = leaf_masks.look_up(x, y, middle) & mask;
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
