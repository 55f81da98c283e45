//! Proves that a packed graph from anywhere can be walked: every pointer leads to a node of the level below, every unit
//! belongs to one node, and everything is reached.
//!
//! Pools lie in order of their levels, from 3 up, and a node's pool pointers lead one level down: to what has been read
//! already, so one pass from the first unit to the last proves everything. Nodes inside others must begin where the one
//! before has ended. Whether equal nodes were merged, and pools sorted, is not checked: that decides the size, not the
//! answers.

use super::node::{Cube, Inner, Target, Unreadable, high_bits};
use super::{MAX_SHARED_SLABS, MAX_UNITS, POOL_WORDS, PackedDag};
use crate::dag::top_error::{TopError, check_count, check_dims};
use crate::dag::{Composition, SLAB_NODE_LEVEL, TooLarge};

/// A structural fault of a packed graph.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PackedError {
    /// Of the top, or of a size.
    #[error(transparent)]
    Top(#[from] TopError),
    /// Pools do not lie one behind the other from the first unit to the last.
    #[error(
        "top word {word} says that a pool begins at unit {unit}, which cannot be: {units} units in order"
    )]
    Pools {
        /// Its index.
        word: usize,
        /// What it says.
        unit: u32,
        /// Units there are.
        units: usize,
    },
    /// The last unit is not in use, and not zero.
    #[error("unit {unit} only fills a word and is {value:#06x}, but must be 0")]
    Filler {
        /// Its index.
        unit: usize,
        /// What it is.
        value: u16,
    },
    /// A column's roots do not follow those of the one before, or do not fit the grid.
    #[error("top word {word} is {value}, which cannot be: a column of {depth} root cubes")]
    Column {
        /// Its index.
        word: usize,
        /// What it says.
        value: u32,
        /// Root cubes along the light.
        depth: u32,
    },
    /// Bits of a node mean nothing, or it has another form.
    #[error("unit {unit} begins a node of level {level} whose bits mean nothing or could be fewer")]
    NodeBits {
        /// Its index.
        unit: usize,
        /// The node's level.
        level: u32,
    },
    /// A node goes on behind the end of its pool.
    #[error("unit {unit} begins a node of level {level} that goes on behind its pool")]
    NodeEnd {
        /// Its index.
        unit: usize,
        /// The node's level.
        level: u32,
    },
    /// A node of level 3 names a shared slab that does not exist.
    #[error("unit {unit} begins a node that names slab {slab}, but there are only {count}")]
    SlabRange {
        /// The node's first unit.
        unit: usize,
        /// The slab named.
        slab: u16,
        /// Slabs there are.
        count: usize,
    },
    /// A node of level 3 is lit behind what is shadowed, or says the same slab twice.
    #[error("unit {unit} begins a node whose slabs do not each lose voxels of the one before")]
    Slabs {
        /// The node's first unit.
        unit: usize,
    },
    /// No node of the pool begins where a pointer leads.
    #[error("{place} {index} leads to unit {pointer} of the pool of level {level}, where no node begins")]
    Pointer {
        /// "unit" or "top word".
        place: &'static str,
        /// Index of the root, or of the first unit of the node with the pointer.
        index: usize,
        /// Where it leads, from the pool's first unit.
        pointer: u32,
        /// The level of that pool.
        level: u32,
    },
    /// A node inside another does not begin where the one before ended.
    #[error(
        "unit {unit} begins a node with a child {found} units behind its slots, where only {expected} can be next"
    )]
    Order {
        /// The parent's first unit.
        unit: usize,
        /// Where the pointer leads, from the end of the slots.
        found: u32,
        /// Where the child should begin.
        expected: u32,
    },
    /// Something that nothing leads to.
    #[error("{what} {index} is not reached from any root")]
    Unreached {
        /// "unit" or "slab".
        what: &'static str,
        /// Its index.
        index: usize,
    },
    /// The graph is valid, but its plain form would be too large.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
}

impl PackedError {
    /// The variant's name, stable across versions; test vectors use it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Top(error) => error.kind(),
            Self::Pools { .. } => "Pools",
            Self::Filler { .. } => "Filler",
            Self::Column { .. } => "Column",
            Self::NodeBits { .. } => "NodeBits",
            Self::NodeEnd { .. } => "NodeEnd",
            Self::SlabRange { .. } => "SlabRange",
            Self::Slabs { .. } => "Slabs",
            Self::Pointer { .. } => "Pointer",
            Self::Order { .. } => "Order",
            Self::Unreached { .. } => "Unreached",
            Self::TooLarge(_) => "TooLarge",
        }
    }
}

impl PackedDag {
    /// Checks that every look-up ends at an answer, and that nothing is there that no look-up reaches; see the module's
    /// text.
    ///
    /// Cost: one pass over all units, and two bits of memory a unit.
    ///
    /// # Errors
    /// The first fault: of the top's pools and columns, of the nodes, of what leads to them.
    pub fn validate(&self) -> Result<(), PackedError> {
        self.composition().map(|_| ())
    }

    /// What the graph's bytes are spent on, found while it is checked.
    ///
    /// # Errors
    /// As [`PackedDag::validate`].
    pub fn composition(&self) -> Result<Composition, PackedError> {
        self.check_top()?;
        let mut walk = Walk {
            packed: self,
            begins: vec![0; self.units.len().div_ceil(64)],
            reached: vec![0; self.units.len().div_ceil(64)],
            slabs_reached: vec![0; self.slabs.len().div_ceil(64)],
            composition: Composition {
                slabs: self.slabs.len() as u64,
                top_bytes: self.top.len() as u64 * 4,
                slab_bytes: self.slabs.len() as u64 * 8,
                ..Composition::default()
            },
        };
        for level in SLAB_NODE_LEVEL..=self.root_level {
            walk.pool(level)?;
        }
        walk.finish()
    }

    fn check_top(&self) -> Result<(), PackedError> {
        check_dims(self.size, self.root_level, self.top_dims)?;
        let columns = u128::from(self.top_dims[0]) * u128::from(self.top_dims[1]);
        let fixed = POOL_WORDS as u128 + 2 * columns + 1;
        let found = self.top.len() as u64;
        if u128::from(found) < fixed {
            return Err(TopError::TopLength { found, expected: fixed }.into());
        }
        let roots = self.top[self.roots_at() - 1];
        if u128::from(found) != fixed + u128::from(roots) {
            return Err(TopError::TopLength { found, expected: fixed + u128::from(roots) }.into());
        }
        check_count("units", self.units.len() as u64, MAX_UNITS as u64)?;
        check_count("slabs", self.slabs.len() as u64, MAX_SHARED_SLABS as u64)?;
        self.check_pools()?;
        self.check_columns()
    }

    fn check_pools(&self) -> Result<(), PackedError> {
        let units = self.units.len();
        let mut last = 0;
        for (word, &unit) in self.top[..POOL_WORDS].iter().enumerate() {
            // The first begins at 0, and those above the roots' level are empty.
            let empty = word > (self.root_level - SLAB_NODE_LEVEL + 1) as usize;
            if unit < last || (word == 0 && unit != 0) || (empty && unit != last) {
                return Err(PackedError::Pools { word, unit, units });
            }
            last = unit;
        }
        if (last as usize).checked_next_multiple_of(2) != Some(units) {
            return Err(PackedError::Pools { word: POOL_WORDS - 1, unit: last, units });
        }
        match self.units.last() {
            Some(&value) if last % 2 == 1 && value != 0 => {
                Err(PackedError::Filler { unit: units - 1, value })
            }
            _ => Ok(()),
        }
    }

    fn check_columns(&self) -> Result<(), PackedError> {
        let depth = self.top_dims[2];
        let columns = &self.top[POOL_WORDS..self.roots_at()];
        let mut last = 0;
        let mut most = 0;
        for (i, &value) in columns.iter().enumerate() {
            let word = POOL_WORDS + i;
            let good = if i % 2 == 1 { value <= depth } else { last <= value && value - last <= most };
            if !good {
                return Err(PackedError::Column { word, value, depth });
            }
            if i % 2 == 1 {
                most = depth - value;
            } else {
                last = value;
            }
        }
        Ok(())
    }
}

struct Walk<'a> {
    packed: &'a PackedDag,
    /// Bit u: a node of a pool begins at unit u.
    begins: Vec<u64>,
    /// Bit u: something leads to it.
    reached: Vec<u64>,
    slabs_reached: Vec<u64>,
    composition: Composition,
}

impl Walk<'_> {
    fn pool(&mut self, level: u32) -> Result<(), PackedError> {
        let end = self.packed.pool(level + 1) as usize;
        let mut at = self.packed.pool(level) as usize;
        while at < end {
            self.begins[at / 64] |= 1 << (at % 64);
            at = self.node(at, end, level)?;
        }
        Ok(())
    }

    /// A node of a pool that ends at `end`, with all that lies in it; returns where it ends. As deep as there are levels.
    fn node(&mut self, unit: usize, end: usize, level: u32) -> Result<usize, PackedError> {
        let units = &self.packed.units[unit..end];
        self.composition.nodes += 1;
        self.composition.header_bytes += 2;
        if level == SLAB_NODE_LEVEL {
            let (cube, length) =
                Cube::read(units, &self.packed.slabs).map_err(|e| self.unreadable(e, unit, level))?;
            let monotone = Cube::of_slabs(&cube.slabs());
            if monotone.is_none_or(|m| (m.changes, m.masks) != (cube.changes, cube.masks)) {
                return Err(PackedError::Slabs { unit });
            }
            let mut pointers = 0;
            for place in cube.shared.iter().flatten().map(|&place| usize::from(place)) {
                self.slabs_reached[place / 64] |= 1 << (place % 64);
                pointers += 1;
            }
            let masks = u64::from(length - 1 - pointers);
            self.composition.pointer_bytes += u64::from(2 * pointers);
            self.composition.slab_bytes += 2 * masks;
            self.composition.slabs += masks / 4;
            return Ok(unit + length as usize);
        }
        let high_bits = high_bits(self.packed.pool(level) - self.packed.pool(level - 1));
        let node = Inner::read(units, high_bits).map_err(|e| self.unreadable(e, unit, level))?;
        let length = node.units(high_bits);
        self.composition.pointer_bytes += 2 * u64::from(length - 1);
        let slots_end = unit + length as usize;
        let mut inside = [0; 8];
        let mut count = 0;
        for target in node.pointers() {
            match *target {
                Target::Pool(pointer) => self.reach(pointer, level - 1, "unit", unit)?,
                Target::Follows => count += 1,
                Target::Near(distance) => {
                    inside[count] = distance;
                    count += 1;
                }
            }
        }
        inside[..count].sort_unstable();
        let mut at = slots_end;
        for &found in &inside[..count] {
            let expected = (at - slots_end) as u32;
            if found != expected {
                return Err(PackedError::Order { unit, found, expected });
            }
            at = self.node(at, end, level - 1)?;
        }
        Ok(at)
    }

    fn reach(
        &mut self,
        pointer: u32,
        level: u32,
        place: &'static str,
        index: usize,
    ) -> Result<(), PackedError> {
        let [begin, end] = [level, level + 1].map(|l| u64::from(self.packed.pool(l)));
        let at = begin + u64::from(pointer);
        let (word, bit) = ((at / 64) as usize, 1 << (at % 64));
        if at >= end || self.begins[word] & bit == 0 {
            return Err(PackedError::Pointer { place, index, pointer, level });
        }
        self.reached[word] |= bit;
        Ok(())
    }

    fn unreadable(&self, what: Unreadable, unit: usize, level: u32) -> PackedError {
        match what {
            Unreadable::End => PackedError::NodeEnd { unit, level },
            Unreadable::Bits => PackedError::NodeBits { unit, level },
            Unreadable::Slab(slab) => PackedError::SlabRange { unit, slab, count: self.packed.slabs.len() },
        }
    }

    fn finish(mut self) -> Result<Composition, PackedError> {
        let packed = self.packed;
        for (index, &root) in packed.top.iter().enumerate().skip(packed.roots_at()) {
            self.reach(root, packed.root_level, "top word", index)?;
        }
        let missing = |have: &[u64], want: &dyn Fn(usize) -> u64| {
            let word = (0..have.len()).find(|&w| want(w) & !have[w] != 0)?;
            Some(word * 64 + (want(word) & !have[word]).trailing_zeros() as usize)
        };
        if let Some(index) = missing(&self.reached, &|w| self.begins[w]) {
            return Err(PackedError::Unreached { what: "unit", index });
        }
        let slabs = packed.slabs.len();
        let all = |w: usize| if slabs >= 64 * (w + 1) { u64::MAX } else { (1 << (slabs % 64)) - 1 };
        if let Some(index) = missing(&self.slabs_reached, &all) {
            return Err(PackedError::Unreached { what: "slab", index });
        }
        Ok(self.composition)
    }
}
