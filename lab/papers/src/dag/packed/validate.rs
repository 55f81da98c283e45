//! Validates a packed graph from an untrusted source: every pointer leads to a node of the level below, every
//! unit belongs to one node, and everything is reachable.
//!
//! Pools are in the order of their levels, from 3 up. A node's pool pointers lead one level down, to nodes
//! that have already been read, so one pass from the first unit to the last validates everything. Nodes
//! inside others must begin where the one before ends. Whether equal nodes were merged and pools were sorted
//! is not checked, since that affects the size and not the results.

use crate::dag::composition::Composition;
use crate::dag::packed::node::{Cube, Inner, Target, Unreadable, high_bits};
use crate::dag::packed::{MAX_SHARED_LEAF_MASKS, MAX_UNITS, POOL_WORDS, PackedDag};
use crate::dag::roots::LEAF_NODE_LEVEL;
use crate::dag::top_error::{TopError, check_count, check_dims};

use crate::dag::too_large::TooLarge;

/// A structural fault of a packed graph.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PackedError {
    /// A fault of the top grid, or of a size.
    #[error(transparent)]
    Top(#[from] TopError),
    /// Pools do not follow each other without gaps from the first unit to the last.
    #[error(
        "top word {word} says that a pool begins at unit {unit}, but pools must begin in order within {units} units"
    )]
    Pools {
        /// Index of the word.
        word: usize,
        /// Value of the word.
        unit: u32,
        /// Number of units in the graph.
        units: usize,
    },
    /// The last unit is not in use, but is not zero.
    #[error("unit {unit} is padding and has the value {value:#06x}, but must be 0")]
    Filler {
        /// Index of the unit.
        unit: usize,
        /// Value of the unit.
        value: u16,
    },
    /// A column's roots do not follow those of the column before, or do not fit the grid.
    #[error("top word {word} is {value}, which is impossible for a column of {depth} root cubes")]
    Column {
        /// Index of the word.
        word: usize,
        /// Value of the word.
        value: u32,
        /// Number of root cubes along the light.
        depth: u32,
    },
    /// A node has invalid bits, or has to be encoded differently.
    #[error("unit {unit} begins a node of level {level} with invalid bits or an encoding that is too long")]
    NodeBits {
        /// Index of the node's first unit.
        unit: usize,
        /// The node's level.
        level: u32,
    },
    /// A node extends past the end of its pool.
    #[error("unit {unit} begins a node of level {level} that extends past the end of its pool")]
    NodeEnd {
        /// Index of the node's first unit.
        unit: usize,
        /// The node's level.
        level: u32,
    },
    /// A node of level 3 refers to a shared leaf mask that does not exist.
    #[error("unit {unit} begins a node that refers to leaf mask {leaf_mask}, but there are only {count}")]
    LeafMaskRange {
        /// Index of the node's first unit.
        unit: usize,
        /// Index of the leaf mask.
        leaf_mask: u16,
        /// Number of shared leaf masks in the graph.
        count: usize,
    },
    /// A node of level 3 has a voxel lit behind a shadowed one, or stores the same leaf mask twice.
    #[error("unit {unit} begins a node whose leaf masks are not each a proper subset of the one before")]
    LeafMasks {
        /// Index of the node's first unit.
        unit: usize,
    },
    /// A pointer does not lead to the first unit of a node in the pool.
    #[error("{place} {index} leads to unit {pointer} of the pool of level {level}, where no node begins")]
    Pointer {
        /// "unit" or "top word".
        place: &'static str,
        /// Index of the top word, or of the first unit of the node with the pointer.
        index: usize,
        /// The pointer, relative to the pool's first unit.
        pointer: u32,
        /// Level of that pool.
        level: u32,
    },
    /// A node inside another does not begin where the one before ends.
    #[error(
        "unit {unit} begins a node with a child {found} units after its slots, but the next child must begin {expected} units after them"
    )]
    Order {
        /// Index of the parent's first unit.
        unit: usize,
        /// Distance to which the pointer leads, from the end of the slots.
        found: u32,
        /// Distance at which the child should begin, from the end of the slots.
        expected: u32,
    },
    /// A unit or leaf mask is not reachable from any root.
    #[error("{what} {index} is not reachable from any root")]
    Unreached {
        /// "unit" or "leaf mask".
        what: &'static str,
        /// Index of the unit or leaf mask.
        index: usize,
    },
    /// The graph is valid, but its plain form would be too large.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
}

impl PackedError {
    /// Returns the variant's name. It is stable across versions and is used by the test vectors.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Top(error) => error.kind(),
            Self::Pools { .. } => "Pools",
            Self::Filler { .. } => "Filler",
            Self::Column { .. } => "Column",
            Self::NodeBits { .. } => "NodeBits",
            Self::NodeEnd { .. } => "NodeEnd",
            Self::LeafMaskRange { .. } => "LeafMaskRange",
            Self::LeafMasks { .. } => "LeafMasks",
            Self::Pointer { .. } => "Pointer",
            Self::Order { .. } => "Order",
            Self::Unreached { .. } => "Unreached",
            Self::TooLarge(_) => "TooLarge",
        }
    }
}

impl PackedDag {
    /// Checks that every look-up in the graph terminates, and that every unit and leaf mask is reachable.
    ///
    /// Cost: one pass over all units, and two bits of memory per unit.
    ///
    /// # Errors
    /// Returns the first fault: first of the top's pools and columns, then of the nodes, then of the pointers
    /// to them.
    pub fn validate(&self) -> Result<(), PackedError> {
        self.composition().map(|_| ())
    }

    /// Returns the breakdown of the graph's bytes, which is counted during validation.
    ///
    /// # Errors
    /// Returns the first fault, see [`PackedDag::validate`].
    pub fn composition(&self) -> Result<Composition, PackedError> {
        self.check_top()?;
        let mut walk = Walk {
            packed: self,
            begins: vec![0; self.units.len().div_ceil(64)],
            reached: vec![0; self.units.len().div_ceil(64)],
            leaf_masks_reached: vec![0; self.leaf_masks.len().div_ceil(64)],
            composition: Composition {
                leaf_masks: self.leaf_masks.len() as u64,
                top_bytes: self.top.len() as u64 * 4,
                leaf_mask_bytes: self.leaf_masks.len() as u64 * 8,
                ..Composition::default()
            },
        };
        for level in LEAF_NODE_LEVEL..=self.root_level {
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
        check_count("leaf masks", self.leaf_masks.len() as u64, MAX_SHARED_LEAF_MASKS as u64)?;
        self.check_pools()?;
        self.check_columns()
    }

    fn check_pools(&self) -> Result<(), PackedError> {
        let units = self.units.len();
        let mut last = 0;
        for (word, &unit) in self.top[..POOL_WORDS].iter().enumerate() {
            // The first pool begins at 0. Pools above the root level are empty.
            let empty = word > (self.root_level - LEAF_NODE_LEVEL + 1) as usize;
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
    /// Bit u: a pointer leads to unit u.
    reached: Vec<u64>,
    leaf_masks_reached: Vec<u64>,
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

    /// Checks a node of a pool that ends at `end`, with all nodes inside it. Returns the unit at which the
    /// node ends. The recursion is at most as deep as there are levels.
    fn node(&mut self, unit: usize, end: usize, level: u32) -> Result<usize, PackedError> {
        let units = &self.packed.units[unit..end];
        self.composition.nodes += 1;
        self.composition.header_bytes += 2;
        if level == LEAF_NODE_LEVEL {
            let (cube, length) =
                Cube::read(units, &self.packed.leaf_masks).map_err(|e| self.unreadable(e, unit, level))?;
            let monotone = Cube::from_leaf_masks(&cube.leaf_masks());
            if monotone.is_none_or(|m| (m.changes, m.masks) != (cube.changes, cube.masks)) {
                return Err(PackedError::LeafMasks { unit });
            }
            let mut pointers = 0;
            for place in cube.shared.iter().flatten().map(|&place| usize::from(place)) {
                self.leaf_masks_reached[place / 64] |= 1 << (place % 64);
                pointers += 1;
            }
            let masks = u64::from(length - 1 - pointers);
            self.composition.pointer_bytes += u64::from(2 * pointers);
            self.composition.leaf_mask_bytes += 2 * masks;
            self.composition.leaf_masks += masks / 4;
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
            Unreadable::LeafMask(leaf_mask) => {
                PackedError::LeafMaskRange { unit, leaf_mask, count: self.packed.leaf_masks.len() }
            }
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
        let leaf_masks = packed.leaf_masks.len();
        let all = |w: usize| if leaf_masks >= 64 * (w + 1) { u64::MAX } else { (1 << (leaf_masks % 64)) - 1 };
        if let Some(index) = missing(&self.leaf_masks_reached, &all) {
            return Err(PackedError::Unreached { what: "leaf mask", index });
        }
        Ok(self.composition)
    }
}
