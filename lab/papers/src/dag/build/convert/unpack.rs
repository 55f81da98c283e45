//! [`PackedDag`] → [`Dag`], through a store, so that duplicates in a file are merged.

use crate::dag::roots::LEAF_NODE_LEVEL;

use crate::dag::TooLarge;
use crate::dag::build::store::{NodeState, NodeStore};
use crate::dag::packed::node::{Cube, Inner, LL, LM, LS, M2, MM, MS, Target, high_bits};
use crate::dag::packed::{POOL_WORDS, PackedDag, PackedError};
use crate::dag::plain::Dag;

/// Converts a packed graph to the plain layout, in canonical form.
///
/// If the packed graph was made from one whose equal nodes were merged, as all graphs made by `bake` are, the
/// result is that graph again. Cost: one visit per node. Memory: twice the plain graph, and twelve bytes per
/// node of a pool.
///
/// # Errors
/// Returns [`PackedError`] if the graph is not valid, or if its top grid is too large: the plain layout
/// stores each root cube separately.
pub fn unpack(packed: &PackedDag) -> Result<Dag, PackedError> {
    packed.validate()?;
    TooLarge::check_roots(packed.size, packed.root_level)?;
    let mut reader = Reader { packed, store: NodeStore::default(), pools: Vec::new() };
    for level in LEAF_NODE_LEVEL..=packed.root_level {
        reader.pool(level);
    }
    let [nx, ny, nz] = packed.top_dims.map(|n| n as usize);
    let mut top = vec![NodeState::Lit; nx * ny * nz];
    for (index, state) in top.iter_mut().enumerate() {
        let column = POOL_WORDS + 2 * (index % (nx * ny));
        let (first, z0, end) = (packed.top[column], packed.top[column + 1], packed.top[column + 2]);
        let gz = (index / (nx * ny)) as u32;
        if gz >= z0 {
            let root = first + (gz - z0);
            *state = match root < end {
                true => reader.pooled(packed.top[packed.roots_at() + root as usize], packed.root_level),
                false => NodeState::Shadowed,
            };
        }
    }
    if reader.store.is_full() {
        return Err(TooLarge::words().into());
    }
    Ok(reader.store.finish(packed.size, packed.root_level, packed.top_dims, &top))
}

struct Reader<'p> {
    packed: &'p PackedDag,
    store: NodeStore,
    /// For each level from 3 up, the nodes of its pool: the offset in units from the pool's first unit,
    /// ascending, and the node's state in the store.
    pools: Vec<Vec<(u32, NodeState)>>,
}

impl Reader<'_> {
    fn pool(&mut self, level: u32) {
        let (begin, end) = (self.packed.pool(level), self.packed.pool(level + 1));
        let mut nodes = Vec::new();
        let mut at = begin;
        while at < end {
            let (state, next) = self.node(at, level);
            nodes.push((at - begin, state));
            at = next;
        }
        self.pools.push(nodes);
    }

    /// Reads a node of a valid graph; also returns where it ends.
    fn node(&mut self, at: u32, level: u32) -> (NodeState, u32) {
        let units = &self.packed.units[at as usize..];
        if level == LEAF_NODE_LEVEL {
            let (cube, length) = Cube::read(units, &self.packed.leaf_masks).unwrap_or_default();
            let leaf_masks = cube.leaf_masks().map(|mask| self.store.leaf_mask(mask));
            return (self.store.cube(&leaf_masks), at + length);
        }
        let high_bits = high_bits(self.packed.pool(level) - self.packed.pool(level - 1));
        let node = Inner::read(units, high_bits).unwrap_or_default();
        let slots_end = at + node.units(high_bits);
        let mut end = slots_end;
        let mut states = [NodeState::Lit; 8];
        for (state, target) in states.iter_mut().zip(node.pointers()) {
            let distance = match *target {
                Target::Pool(unit) => {
                    *state = self.pooled(unit, level - 1);
                    continue;
                }
                Target::Near(distance) => distance,
                Target::Follows => 0,
            };
            let (inside, inside_end) = self.node(slots_end + distance, level - 1);
            *state = inside;
            end = end.max(inside_end);
        }
        let mut mixed = states.into_iter();
        let mut next = || mixed.next().unwrap_or(NodeState::Lit);
        let mut children = [NodeState::Shadowed; 8];
        for (q, pair) in children.as_chunks_mut::<2>().0.iter_mut().enumerate() {
            *pair = match node.codes >> (3 * q) & 7 {
                LL => [NodeState::Lit; 2],
                LS => [NodeState::Lit, NodeState::Shadowed],
                M2 => [next(), next()],
                LM => [NodeState::Lit, next()],
                MS => [next(), NodeState::Shadowed],
                MM => [next(); 2],
                _ => [NodeState::Shadowed; 2],
            };
        }
        (self.store.inner(&children), end)
    }

    fn pooled(&self, unit: u32, level: u32) -> NodeState {
        let pool = &self.pools[(level - LEAF_NODE_LEVEL) as usize];
        match pool.binary_search_by_key(&unit, |node| node.0) {
            Ok(i) => pool[i].1,
            Err(_) => NodeState::Lit,
        }
    }
}
