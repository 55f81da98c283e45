//! Computes sizes and places of nodes, and writes the nodes.
//!
//! With [`POOLED`], a place is the node's offset in its level's pool once the pool is laid out. Before that,
//! and for nodes that are stored inside their parent, it is the node's size including everything stored
//! inside it.

use crate::dag::roots::LEAF_NODE_LEVEL;
use rayon::prelude::*;

use super::{Encoder, pairs};
use crate::dag::PackError;
use crate::dag::packed::node::{Inner, NO_FOLLOWER, Target, high_bits};
use crate::dag::packed::{MAX_UNITS, NEAR_UNITS, POOL_WORDS, PackedDag};
use crate::dag::plain::{GraphPlace, LIT, SHADOWED};

const POOLED: u32 = 1 << 31;

/// Number of nodes that a thread processes at a time. The results of sixteen times as many are held.
const BATCH: usize = 1 << 12;

/// A node above level 3, ready to be written.
struct Plan {
    node: Inner,
    /// Words of the children stored inside the node, in order.
    inside: [u32; 8],
    inside_count: usize,
    /// Total size of those children, units.
    inside_units: u64,
}

impl Encoder<'_> {
    /// Computes the size of each node of a level, and the place of each node of the level below. Must be
    /// called for levels in order, from 3 up.
    pub(super) fn size_level(&mut self, level: u32) -> Result<(), PackError> {
        let words = std::mem::take(&mut self.words[level as usize]);
        if level > LEAF_NODE_LEVEL {
            for part in words.chunks(BATCH * 16) {
                let far: Vec<usize> =
                    part.par_iter().flat_map_iter(|&word| self.far_children(word, level)).collect();
                // Each of these nodes has one parent, so no other part refers to it.
                far.into_iter().for_each(|key| self.places[key] |= POOLED);
            }
            self.lay_out_pool(level - 1)?;
        }
        for part in words.chunks(BATCH * 16) {
            let sizes: Vec<u64> = part.par_iter().map(|&word| self.size(word, level)).collect();
            for (&word, units) in part.iter().zip(sizes) {
                let size = check_units(units)?;
                let key = self.keys.key(word, level);
                let pooled = level == self.graph.root_level || self.references[key] > 1;
                self.places[key] = if pooled { size | POOLED } else { size };
            }
        }
        self.words[level as usize] = words;
        if level == self.graph.root_level { self.lay_out_pool(level) } else { Ok(()) }
    }

    /// Returns the size of a node in units, including everything stored inside it.
    fn size(&self, word: u32, level: u32) -> u64 {
        if level == LEAF_NODE_LEVEL {
            return self.cube(word).map_or(0, |cube| u64::from(cube.units()));
        }
        let plan = self.plan(word, level);
        u64::from(plan.node.units(self.high_bits(level))) + plan.inside_units
    }

    /// Children stored inside a node must begin near it. Returns the numbers of the largest children, which
    /// would begin too far away and therefore go to the pool.
    fn far_children(&self, word: u32, level: u32) -> impl Iterator<Item = usize> {
        let mut far = [None; 8];
        if let Some(pairs) = pairs(self.graph, word) {
            let (mut keys, mut places) = ([0; 8], [0; 8]);
            for (p, &child) in pairs.children().iter().enumerate() {
                keys[p] = self.keys.key(child, level - 1);
                places[p] = self.places[keys[p]];
            }
            let (order, count) = inside(&places[..pairs.count]);
            let mut distance = 0_u32;
            for &pointer in &order[..count] {
                if distance >= NEAR_UNITS {
                    far[pointer] = Some(keys[pointer]);
                } else {
                    distance = distance.saturating_add(places[pointer]);
                }
            }
        }
        far.into_iter().flatten()
    }

    /// Lays out a pool: the most referenced nodes first, and those with equal references in order.
    fn lay_out_pool(&mut self, level: u32) -> Result<(), PackError> {
        let mut pool = std::mem::take(&mut self.words[level as usize]);
        pool.retain(|&word| self.place(word, level) & POOLED != 0);
        pool.sort_by_cached_key(|&word| u32::MAX - self.references[self.keys.key(word, level)]);
        let mut end = 0_u64;
        for &word in &pool {
            let key = self.keys.key(word, level);
            let size = self.places[key] & !POOLED;
            self.places[key] = check_units(end)? | POOLED;
            end += u64::from(size);
        }
        self.pool_units[level as usize] = check_units(end)?;
        self.words[level as usize] = pool;
        Ok(())
    }

    fn plan(&self, word: u32, level: u32) -> Plan {
        let mut plan = Plan { node: Inner::default(), inside: [0; 8], inside_count: 0, inside_units: 0 };
        let Some(pairs) = pairs(self.graph, word) else { return plan };
        plan.node.codes = pairs.codes;
        let mut places = [0; 8];
        for ((place, target), &child) in places.iter_mut().zip(&mut plan.node.targets).zip(pairs.children()) {
            *place = self.place(child, level - 1);
            *target = Target::Pool(*place & !POOLED);
        }
        let (order, count) = inside(&places[..pairs.count]);
        for (i, &pointer) in order[..count].iter().enumerate() {
            let follows = i == 0 && pointer < NO_FOLLOWER as usize;
            let near = Target::Near(plan.inside_units as u32);
            plan.node.targets[pointer] = if follows { Target::Follows } else { near };
            plan.inside[i] = pairs.list[pointer];
            plan.inside_units += u64::from(places[pointer]);
        }
        plan.inside_count = count;
        plan
    }

    /// Writes pools, columns and roots.
    pub(super) fn write_columns(&self, packed: &mut PackedDag) -> Result<(), PackError> {
        let mut end = 0_u64;
        for i in 0..POOL_WORDS {
            packed.top.push(check_units(end)?);
            end += u64::from(self.pool_units.get(i + LEAF_NODE_LEVEL as usize).copied().unwrap_or(0));
        }
        let [nx, ny, nz] = self.graph.top_dims.map(|n| n as usize);
        let mut roots = Vec::new();
        for column in 0..nx * ny {
            let entry = |gz: usize| self.graph.top[gz * nx * ny + column];
            let z0 = (0..nz).take_while(|&gz| entry(gz) == LIT).count();
            let mixed = (z0..nz).take_while(|&gz| entry(gz) < SHADOWED).count();
            if let Some(gz) = (z0 + mixed..nz).find(|&gz| entry(gz) != SHADOWED) {
                let place = GraphPlace::Top { index: gz * nx * ny + column };
                return Err(PackError::NotMonotone { place, level: self.graph.root_level });
            }
            packed.top.extend([roots.len() as u32, z0 as u32]);
            roots.extend((z0..z0 + mixed).map(|gz| self.place(entry(gz), self.graph.root_level) & !POOLED));
        }
        packed.top.push(roots.len() as u32);
        packed.top.append(&mut roots);
        Ok(())
    }

    /// Writes all nodes, pool by pool.
    pub(super) fn write_nodes(&self, packed: &mut PackedDag) {
        packed.units.reserve_exact(packed.top[POOL_WORDS - 1] as usize + 1);
        for (level, pool) in (0..).zip(&self.words) {
            let batch = |words: &[u32]| {
                let mut units = Vec::new();
                words.iter().for_each(|&word| self.write_node(word, level, &mut units));
                units
            };
            // Process a few batches at a time, so that only a few nodes are held twice.
            for part in pool.chunks(BATCH * 16) {
                let batches: Vec<Vec<u16>> = part.par_chunks(BATCH).map(batch).collect();
                batches.iter().for_each(|units| packed.units.extend_from_slice(units));
            }
        }
        if packed.units.len() % 2 == 1 {
            packed.units.push(0);
        }
    }

    fn write_node(&self, word: u32, level: u32, units: &mut Vec<u16>) {
        if level == LEAF_NODE_LEVEL {
            self.cube(word).iter().for_each(|cube| cube.write(units));
            return;
        }
        let plan = self.plan(word, level);
        plan.node.write(self.high_bits(level), units);
        for &child in &plan.inside[..plan.inside_count] {
            self.write_node(child, level - 1, units);
        }
    }

    fn place(&self, word: u32, level: u32) -> u32 {
        self.places[self.keys.key(word, level)]
    }

    fn high_bits(&self, level: u32) -> u32 {
        high_bits(self.pool_units[level as usize - 1])
    }
}

/// Returns the pointers whose children are stored inside the node: ordered by size, except that the first
/// must be one that the header can name.
fn inside(places: &[u32]) -> ([usize; 8], usize) {
    let mut order = [0; 8];
    let mut count = 0;
    for (pointer, place) in places.iter().enumerate() {
        if place & POOLED == 0 {
            order[count] = pointer;
            count += 1;
        }
    }
    let inside = &mut order[..count];
    inside.sort_unstable_by_key(|&pointer| (places[pointer], pointer));
    if count > 1 && inside[0] == NO_FOLLOWER as usize {
        inside.swap(0, 1);
    }
    (order, count)
}

fn check_units(units: u64) -> Result<u32, PackError> {
    if units < MAX_UNITS as u64 { Ok(units as u32) } else { Err(PackError::TooLarge { units }) }
}
