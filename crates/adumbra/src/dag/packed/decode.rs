//! [`PackedDag`] → [`Dag`]: through a store, so that what a file holds twice is merged.

use super::node::{Cube, Inner, LL, LM, LS, M2, MM, MS, Target, high_bits};
use super::{PackedDag, PackedError};
use crate::dag::store::{NodeState, NodeStore};
use crate::dag::{Dag, SLAB_NODE_LEVEL, TooLarge};

impl PackedDag {
    /// The same graph in the plain layout, in its canonical form.
    ///
    /// Of a graph whose equal nodes were merged, as of all that `bake` makes, it is that graph again. Cost: one visit a
    /// node; memory: the plain graph twice, and twelve bytes a node of a pool.
    ///
    /// # Errors
    /// [`PackedError`] where the graph is not valid, or its top grid too large: a plain one has each root cube by itself.
    pub fn to_dag(&self) -> Result<Dag, PackedError> {
        self.validate()?;
        TooLarge::check_roots(self.size, self.root_level)?;
        let mut reader = Reader { packed: self, store: NodeStore::default(), pools: Vec::new() };
        for level in SLAB_NODE_LEVEL..=self.root_level {
            reader.pool(level);
        }
        let [nx, ny, nz] = self.top_dims.map(|n| n as usize);
        let mut top = vec![NodeState::Lit; nx * ny * nz];
        for (index, state) in top.iter_mut().enumerate() {
            let column = super::POOL_WORDS + 2 * (index % (nx * ny));
            let (first, z0, end) = (self.top[column], self.top[column + 1], self.top[column + 2]);
            let gz = (index / (nx * ny)) as u32;
            if gz >= z0 {
                let root = first + (gz - z0);
                *state = match root < end {
                    true => reader.pooled(self.top[self.roots_at() + root as usize], self.root_level),
                    false => NodeState::Shadowed,
                };
            }
        }
        if reader.store.is_full() {
            return Err(TooLarge::words().into());
        }
        Ok(reader.store.finish(self.size, self.root_level, self.top_dims, &top))
    }
}

struct Reader<'p> {
    packed: &'p PackedDag,
    store: NodeStore,
    /// By level from 3 up, the pool's nodes: units from its first one, ascending, and what they are in the store.
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

    /// A node of a valid graph and where it ends.
    fn node(&mut self, at: u32, level: u32) -> (NodeState, u32) {
        let units = &self.packed.units[at as usize..];
        if level == SLAB_NODE_LEVEL {
            let (cube, length) = Cube::read(units, &self.packed.slabs).unwrap_or_default();
            let slabs = cube.slabs().map(|mask| self.store.slab(mask));
            return (self.store.cube(&slabs), at + length);
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
        let pool = &self.pools[(level - SLAB_NODE_LEVEL) as usize];
        match pool.binary_search_by_key(&unit, |node| node.0) {
            Ok(i) => pool[i].1,
            Err(_) => NodeState::Lit,
        }
    }
}
