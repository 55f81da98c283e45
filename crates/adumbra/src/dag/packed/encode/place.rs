//! Sizes and places of nodes, and writing them.
//!
//! A place is, with [`POOLED`], that of a node in its level's pool, once that is laid out; before, and for nodes that lie
//! in their parent, it is the node's size with all that lies in it.

use rayon::prelude::*;

use super::graph::Graph;
use super::{Encoder, PackError, pairs};
use crate::dag::packed::node::{Inner, NO_FOLLOWER, Target, high_bits};
use crate::dag::packed::{MAX_UNITS, NEAR_UNITS, POOL_WORDS, PackedDag};
use crate::dag::{GraphPlace, LIT, SHADOWED, SLAB_NODE_LEVEL};

const POOLED: u32 = 1 << 31;

/// Nodes that a thread takes at a time; the results of sixteen times as many are held.
const BATCH: usize = 1 << 12;

/// A node above level 3, ready to be written.
struct Plan {
    node: Inner,
    /// Words of the children that lie in it, in order.
    inside: [u32; 8],
    inside_count: usize,
    /// Units of those.
    inside_units: u64,
}

impl<G: Graph> Encoder<'_, G> {
    /// Gives each node of a level its size, and each of the level below its place. Levels come in order, from 3 up.
    pub(super) fn size_level(&mut self, level: u32) -> Result<(), PackError> {
        let words = std::mem::take(&mut self.words[level as usize]);
        if level > SLAB_NODE_LEVEL {
            for part in words.chunks(BATCH * 16) {
                let far: Vec<usize> =
                    part.par_iter().flat_map_iter(|&word| self.far_children(word, level)).collect();
                // Each has one parent, so that no other part asks.
                far.into_iter().for_each(|key| self.places[key] |= POOLED);
            }
            self.lay_out_pool(level - 1)?;
        }
        for part in words.chunks(BATCH * 16) {
            let sizes: Vec<u64> = part.par_iter().map(|&word| self.size(word, level)).collect();
            for (&word, units) in part.iter().zip(sizes) {
                let size = check_units(units)?;
                let key = self.keys.key(word, level);
                let pooled = level == self.graph.head().root_level || self.references[key] > 1;
                self.places[key] = if pooled { size | POOLED } else { size };
            }
        }
        self.words[level as usize] = words;
        if level == self.graph.head().root_level { self.lay_out_pool(level) } else { Ok(()) }
    }

    /// Units of a node with all that lies in it.
    fn size(&self, word: u32, level: u32) -> u64 {
        if level == SLAB_NODE_LEVEL {
            return self.cube(word).map_or(0, |cube| u64::from(cube.units()));
        }
        let plan = self.plan(word, level);
        u64::from(plan.node.units(self.high_bits(level))) + plan.inside_units
    }

    /// Children that lie in a node must begin near it. Numbers of the largest, those that do not and go to the pool.
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

    /// Lays out a pool: the most referenced nodes first, those of equal references in order.
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

    /// Pools, columns and roots.
    pub(super) fn write_columns(&self, packed: &mut PackedDag) -> Result<(), PackError> {
        let mut end = 0_u64;
        for i in 0..POOL_WORDS {
            packed.top.push(check_units(end)?);
            end += u64::from(self.pool_units.get(i + SLAB_NODE_LEVEL as usize).copied().unwrap_or(0));
        }
        let [nx, ny, nz] = self.graph.head().top_dims.map(|n| n as usize);
        let mut roots = Vec::new();
        for column in 0..nx * ny {
            let entry = |gz: usize| self.graph.head().top[gz * nx * ny + column];
            let z0 = (0..nz).take_while(|&gz| entry(gz) == LIT).count();
            let mixed = (z0..nz).take_while(|&gz| entry(gz) < SHADOWED).count();
            if let Some(gz) = (z0 + mixed..nz).find(|&gz| entry(gz) != SHADOWED) {
                let place = GraphPlace::Top { index: gz * nx * ny + column };
                return Err(PackError::NotMonotone { place, level: self.graph.head().root_level });
            }
            packed.top.extend([roots.len() as u32, z0 as u32]);
            roots.extend(
                (z0..z0 + mixed).map(|gz| self.place(entry(gz), self.graph.head().root_level) & !POOLED),
            );
        }
        packed.top.push(roots.len() as u32);
        packed.top.append(&mut roots);
        Ok(())
    }

    /// Bytes of the packed graph, once its columns are written.
    pub(super) fn packed_bytes(&self) -> u64 {
        let units: u64 = self.pool_units.iter().map(|&units| u64::from(units)).sum();
        2 * units + 8 * self.shared.len() as u64
    }

    /// All nodes, pool by pool.
    pub(super) fn write_nodes(&self, packed: &mut PackedDag) {
        packed.units.reserve_exact(packed.top[POOL_WORDS - 1] as usize + 1);
        for (level, pool) in (0..).zip(&self.words) {
            let batch = |words: &[u32]| {
                let mut units = Vec::new();
                words.iter().for_each(|&word| self.write_node(word, level, &mut units));
                units
            };
            // Some batches at a time, so that little is held twice.
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
        if level == SLAB_NODE_LEVEL {
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

/// Pointers whose children lie in the node, in order: by size, but the first must be one that the header can name.
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
