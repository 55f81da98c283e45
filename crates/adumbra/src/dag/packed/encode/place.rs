//! Sizes and places of nodes, and writing them.
//!
//! A place is, with [`POOLED`], that of a node in its level's pool, once that is laid out; before, and for nodes that lie in
//! their parent, it is the node's size with all that lies in it.

use super::{Encoder, PackError, pairs};
use crate::dag::packed::node::{Inner, NO_FOLLOWER, Target, high_bits};
use crate::dag::packed::{MAX_UNITS, NEAR_UNITS, POOL_WORDS, PackedDag};
use crate::dag::{GraphPlace, LIT, SHADOWED, SLAB_NODE_LEVEL};

const POOLED: u32 = 1 << 31;

/// A node above level 3, ready to be written.
struct Plan {
    node: Inner,
    /// Words of the children that lie in it, in order.
    inside: [u32; 8],
    inside_count: usize,
}

impl Encoder<'_> {
    /// Gives each node of a level its size, and each of the level below its place. Levels come in order, from 3 up.
    pub(super) fn size_level(&mut self, level: u32) -> Result<(), PackError> {
        let words = std::mem::take(&mut self.words[level as usize]);
        if level > SLAB_NODE_LEVEL {
            words.iter().for_each(|&word| self.send_far_children_to_pool(word, level));
            self.lay_out_pool(level - 1)?;
        }
        for &word in &words {
            let units = if level == SLAB_NODE_LEVEL {
                self.cube(word).map_or(0, |cube| u64::from(cube.units()))
            } else {
                let plan = self.plan(word, level);
                let inside = plan.inside[..plan.inside_count].iter();
                let inside: u64 = inside.map(|&child| u64::from(self.place(child, level - 1))).sum();
                u64::from(plan.node.units(self.high_bits(level))) + inside
            };
            let size = check_units(units)?;
            let key = self.keys.key(word, level);
            let pooled = level == self.dag.root_level || self.references[key] > 1;
            self.places[key] = if pooled { size | POOLED } else { size };
        }
        self.words[level as usize] = words;
        if level == self.dag.root_level { self.lay_out_pool(level) } else { Ok(()) }
    }

    /// Children that lie in a node must begin near it; the largest that do not go to the pool.
    fn send_far_children_to_pool(&mut self, word: u32, level: u32) {
        let Some(pairs) = pairs(self.dag, word) else { return };
        let (order, count) = self.inside(pairs.children(), level);
        let mut distance = 0;
        for &pointer in &order[..count] {
            let key = self.keys.key(pairs.list[pointer], level - 1);
            let size = self.places[key];
            if distance >= NEAR_UNITS {
                self.places[key] |= POOLED;
            } else {
                distance = distance.saturating_add(size);
            }
        }
    }

    /// Pointers whose children lie in the node, in order: by size, but the first must be one that the header can name.
    fn inside(&self, children: &[u32], level: u32) -> ([usize; 8], usize) {
        let mut order = [0; 8];
        let mut count = 0;
        for (pointer, &child) in children.iter().enumerate() {
            if self.place(child, level - 1) & POOLED == 0 {
                order[count] = pointer;
                count += 1;
            }
        }
        let inside = &mut order[..count];
        inside.sort_by_key(|&pointer| (self.place(children[pointer], level - 1), pointer));
        if count > 1 && inside[0] == NO_FOLLOWER as usize {
            inside.swap(0, 1);
        }
        (order, count)
    }

    /// Lays out a pool: the most referenced nodes first, those of equal references in order.
    fn lay_out_pool(&mut self, level: u32) -> Result<(), PackError> {
        let mut pool = std::mem::take(&mut self.words[level as usize]);
        pool.retain(|&word| self.place(word, level) & POOLED != 0);
        pool.sort_by_key(|&word| u32::MAX - self.references[self.keys.key(word, level)]);
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
        let mut plan = Plan { node: Inner::default(), inside: [0; 8], inside_count: 0 };
        let Some(pairs) = pairs(self.dag, word) else { return plan };
        plan.node.codes = pairs.codes;
        for (target, &child) in plan.node.targets.iter_mut().zip(pairs.children()) {
            *target = Target::Pool(self.place(child, level - 1) & !POOLED);
        }
        let (order, count) = self.inside(pairs.children(), level);
        let mut distance = 0;
        for (i, &pointer) in order[..count].iter().enumerate() {
            let child = pairs.list[pointer];
            let follows = i == 0 && pointer < NO_FOLLOWER as usize;
            plan.node.targets[pointer] = if follows { Target::Follows } else { Target::Near(distance) };
            plan.inside[i] = child;
            distance += self.place(child, level - 1);
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
        let [nx, ny, nz] = self.dag.top_dims.map(|n| n as usize);
        let mut roots = Vec::new();
        for column in 0..nx * ny {
            let entry = |gz: usize| self.dag.top[gz * nx * ny + column];
            let z0 = (0..nz).take_while(|&gz| entry(gz) == LIT).count();
            let mixed = (z0..nz).take_while(|&gz| entry(gz) < SHADOWED).count();
            if let Some(gz) = (z0 + mixed..nz).find(|&gz| entry(gz) != SHADOWED) {
                let place = GraphPlace::Top { index: gz * nx * ny + column };
                return Err(PackError::NotMonotone { place, level: self.dag.root_level });
            }
            packed.top.extend([roots.len() as u32, z0 as u32]);
            roots.extend((z0..z0 + mixed).map(|gz| self.place(entry(gz), self.dag.root_level) & !POOLED));
        }
        packed.top.push(roots.len() as u32);
        packed.top.append(&mut roots);
        Ok(())
    }

    /// All nodes, pool by pool.
    pub(super) fn write_nodes(&self, packed: &mut PackedDag) {
        packed.units.reserve_exact(packed.top[POOL_WORDS - 1] as usize + 1);
        for (level, pool) in (0..).zip(&self.words) {
            pool.iter().for_each(|&word| self.write_node(word, level, &mut packed.units));
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

fn check_units(units: u64) -> Result<u32, PackError> {
    if units < MAX_UNITS as u64 { Ok(units as u32) } else { Err(PackError::TooLarge { units }) }
}
