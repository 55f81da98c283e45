//! Encoding and decoding of a single node, shared by the encoder, the validation and the conversion back.
//! Look-ups have their own code, which reads only what it needs.

use crate::dag::packed::NEAR_UNITS;

/// Code of a quarter: both children shadowed.
pub const SS: u32 = 0;
/// Code of a quarter: both children lit.
pub const LL: u32 = 1;
/// Code of a quarter: lit, then shadowed.
pub const LS: u32 = 2;
/// Code of a quarter: two mixed nodes.
pub const M2: u32 = 3;
/// Code of a quarter: lit, then mixed.
pub const LM: u32 = 4;
/// Code of a quarter: mixed, then shadowed.
pub const MS: u32 = 5;
/// Code of a quarter: one mixed node for both children.
pub const MM: u32 = 6;
/// Value of a header's field f if no child directly follows the slots.
pub const NO_FOLLOWER: u32 = 7;

/// Returns a mask of the lowest `count` bits; `count` is at most 31.
pub(crate) fn bits_below(count: u32) -> u32 {
    (1 << count) - 1
}

/// Returns the number of pointers of the quarters in `codes`, which have three bits each and are never 7.
pub(crate) fn pointers_in(codes: u32) -> u32 {
    (codes & 0o4444).count_ones() + 2 * (codes & codes >> 1 & 0o1111).count_ones()
}

/// Returns the number of bits in a wide slot's high part for a target pool of `pool_units` units.
pub fn high_bits(pool_units: u32) -> u32 {
    match pool_units {
        0..=0x10_0000 => 4,
        0x10_0001..=0x100_0000 => 8,
        _ => 16,
    }
}

/// Returns the number of bit planes for `masks` masks.
pub(crate) fn plane_count(masks: u32) -> u32 {
    u32::BITS - masks.leading_zeros()
}

/// Returns a mask of the inline masks of a level-3 node: bit i, mask i.
pub(crate) fn inline_masks(unit: u32) -> u32 {
    let flags = unit >> 9 & 0x3f;
    flags | ((flags & 0x20) * 6)
}

/// The location that a pointer leads to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Target {
    /// Directly behind the slots.
    #[default]
    Follows,
    /// This many units behind the end of the slots.
    Near(u32),
    /// This unit in the pool of the level below.
    Pool(u32),
}

/// A node above level 3, without the children stored inside it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Inner {
    /// The codes of the four quarters, three bits each.
    pub codes: u32,
    /// The locations that the pointers lead to, in the order of the quarters: two for code 3, one each for
    /// codes 4 to 6.
    pub targets: [Target; 8],
}

impl Inner {
    /// Returns the locations of the children that are nodes, in the order of the quarters.
    pub fn pointers(&self) -> &[Target] {
        &self.targets[..pointers_in(self.codes) as usize]
    }

    /// Returns the number of units before the children stored inside the node.
    pub fn units(&self, high_bits: u32) -> u32 {
        let slots = self.pointers().iter().filter(|t| **t != Target::Follows).count() as u32;
        1 + string_units(self.wide(), high_bits) + slots
    }

    /// Appends the node to `units`.
    pub fn write(&self, high_bits: u32, units: &mut Vec<u16>) {
        let wide = self.wide();
        let follower = self.pointers().iter().position(|t| *t == Target::Follows);
        let follower = follower.map_or(NO_FOLLOWER, |p| p as u32);
        units.push((self.codes | follower << 12 | u32::from(wide != 0) << 15) as u16);
        let string = units.len();
        units.resize(string + string_units(wide, high_bits) as usize, 0);
        let mut place = high_bits.max(8);
        for (p, target) in self.pointers().iter().enumerate() {
            let value = match *target {
                Target::Follows => continue,
                Target::Near(distance) => distance,
                Target::Pool(unit) if wide >> p & 1 == 0 => unit + NEAR_UNITS,
                Target::Pool(unit) => {
                    units[string] |= 1 << p;
                    units[string + (place >> 4) as usize] |= (unit >> 16 << (place & 15)) as u16;
                    place += high_bits;
                    unit
                }
            };
            units.push(value as u16);
        }
    }

    /// Decodes the node at the start of `units`, as [`Inner::write`] encodes it. Its children are not
    /// checked.
    ///
    /// # Errors
    /// Returns [`Unreadable`] if `units` ends before the node does, or if the node is not one that
    /// [`Inner::write`] encodes.
    pub fn read(units: &[u16], high_bits: u32) -> Result<Self, Unreadable> {
        let unit = u32::from(*units.first().ok_or(Unreadable::End)?);
        let codes = unit & 0xfff;
        let pointers = pointers_in(codes);
        let follower = unit >> 12 & 7;
        // 7 is the only code with all three bits set.
        let invalid = codes & codes >> 1 & codes >> 2 & 0o1111 != 0;
        if invalid || (follower != NO_FOLLOWER && follower >= pointers) || !differs(codes) {
            return Err(Unreadable::Bits);
        }
        let front = if unit >> 15 == 0 { 0 } else { u32::from(*units.get(1).ok_or(Unreadable::End)?) };
        let wide = front & 0xff;
        // Only pointers with a slot can be wide. If the high parts begin in the next unit, the rest of this
        // one must be zero.
        let follows = |p: u32| p == follower && p != NO_FOLLOWER;
        let slotted = (0..pointers).filter(|&p| !follows(p)).fold(0, |bits, p| bits | 1 << p);
        if wide & !slotted != 0 || (wide == 0) != (unit >> 15 == 0) || (high_bits == 16 && front > 0xff) {
            return Err(Unreadable::Bits);
        }
        let length = 1 + string_units(wide, high_bits) + pointers - u32::from(follower != NO_FOLLOWER);
        let units = units.get(..length as usize).ok_or(Unreadable::End)?;
        let mut node = Self { codes, targets: [Target::Follows; 8] };
        let mut slots = units[1 + string_units(wide, high_bits) as usize..].iter();
        let mut place = high_bits.max(8);
        for (p, target) in (0..pointers).zip(&mut node.targets) {
            let Some(&value) = (if follows(p) { None } else { slots.next() }) else { continue };
            let value = u32::from(value);
            *target = if wide >> p & 1 == 1 {
                let high =
                    u32::from(units[1 + (place >> 4) as usize]) >> (place & 15) & bits_below(high_bits);
                place += high_bits;
                if (high << 16 | value) < NARROW_POOL_UNITS {
                    return Err(Unreadable::Bits);
                }
                Target::Pool(high << 16 | value)
            } else if value < NEAR_UNITS {
                Target::Near(value)
            } else {
                Target::Pool(value - NEAR_UNITS)
            };
        }
        let end_of_string = units[string_units(wide, high_bits) as usize];
        let rest_is_empty = wide == 0 || place & 15 == 0 || end_of_string >> (place & 15) == 0;
        if rest_is_empty { Ok(node) } else { Err(Unreadable::Bits) }
    }

    /// Returns a mask of the pointers with wide slots.
    fn wide(&self) -> u32 {
        let wide = |t: &Target| matches!(t, Target::Pool(unit) if *unit >= NARROW_POOL_UNITS);
        self.pointers().iter().enumerate().fold(0, |mask, (p, t)| mask | u32::from(wide(t)) << p)
    }
}

/// Number of units at the start of a pool that narrow slots can address.
const NARROW_POOL_UNITS: u32 = (1 << 16) - NEAR_UNITS;

/// Whether a node with these quarters is neither all lit nor all shadowed.
fn differs(codes: u32) -> bool {
    codes != 0 && codes != 0o1111
}

/// Returns the number of units of the high parts of wide slots, including the mask of wide pointers.
fn string_units(wide: u32, high_bits: u32) -> u32 {
    if wide == 0 { 0 } else { (high_bits.max(8) + high_bits * wide.count_ones()).div_ceil(16) }
}

/// The reason why a node cannot be decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unreadable {
    /// The units end before the node does.
    End,
    /// Bits are invalid, or the node has to be encoded differently.
    Bits,
    /// A shared leaf mask does not exist.
    LeafMask(u16),
}

/// A node of level 3.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cube {
    /// Bit k: leaf mask k differs from the one before; bit 8: the last change is to all shadowed.
    pub changes: u32,
    /// The masks that are neither all lit nor all shadowed, each with fewer voxels lit than the one before.
    pub masks: [u64; 8],
    /// Indices of the masks among the shared leaf masks.
    pub shared: [Option<u16>; 8],
}

impl Cube {
    /// Builds the node of these leaf masks, z = 0 first. Returns `None` if a leaf mask has a voxel lit that
    /// is not lit in the one before.
    pub fn from_leaf_masks(leaf_masks: &[u64; 8]) -> Option<Self> {
        let mut cube = Self::default();
        let mut last = u64::MAX;
        for (k, &leaf_mask) in leaf_masks.iter().enumerate() {
            if leaf_mask & !last != 0 {
                return None;
            }
            if leaf_mask != last {
                if leaf_mask == 0 {
                    cube.changes |= 1 << 8;
                } else {
                    cube.masks[cube.mask_count()] = leaf_mask;
                }
                cube.changes |= 1 << k;
            }
            last = leaf_mask;
        }
        Some(cube)
    }

    /// Returns the leaf masks, z = 0 first.
    pub fn leaf_masks(&self) -> [u64; 8] {
        let mut masks = self.masks[..self.mask_count()].iter();
        let mut leaf_mask = u64::MAX;
        std::array::from_fn(|k| {
            if self.changes >> k & 1 == 1 {
                leaf_mask = masks.next().copied().unwrap_or(0);
            }
            leaf_mask
        })
    }

    /// Returns the number of different masks.
    pub(crate) fn mask_count(&self) -> usize {
        ((self.changes & 0xff).count_ones() - (self.changes >> 8 & 1)) as usize
    }

    /// Returns a mask of the inline masks: bit i, mask i. Masks 5, 6 and 7 are inline together or not at all.
    fn here(&self) -> u32 {
        let here = (0..self.mask_count()).fold(0, |bits, i| bits | u32::from(self.shared[i].is_none()) << i);
        if here >> 5 == 0 { here } else { (here | 0xe0) & bits_below(self.mask_count() as u32) }
    }

    /// Whether bit planes take fewer units than masks.
    pub(crate) fn in_planes(&self) -> bool {
        4 * plane_count(self.mask_count() as u32) < self.mask_units()
    }

    fn mask_units(&self) -> u32 {
        self.mask_count() as u32 + 3 * self.here().count_ones()
    }

    /// Returns the indices of the shared leaf masks that the node needs.
    pub fn shared_used(&self) -> impl Iterator<Item = u16> {
        let used = if self.in_planes() { 0 } else { !self.here() };
        (0..self.mask_count()).filter(move |i| used >> i & 1 == 1).filter_map(|i| self.shared[i])
    }

    /// Returns the number of units of the node.
    pub fn units(&self) -> u32 {
        1 + if self.in_planes() { 4 * plane_count(self.mask_count() as u32) } else { self.mask_units() }
    }

    /// Appends the node to `units`.
    pub fn write(&self, units: &mut Vec<u16>) {
        let masks = &self.masks[..self.mask_count()];
        let four = |mask: u64| [0, 16, 32, 48].map(|shift| (mask >> shift) as u16);
        if self.in_planes() {
            units.push((self.changes | 1 << 15) as u16);
            for bit in 0..plane_count(masks.len() as u32) {
                // A voxel that is lit in exactly `count` masks has the bits of `count` in the planes.
                let plane = (1..=masks.len()).fold(0, |plane, count| {
                    if count >> bit & 1 == 0 {
                        return plane;
                    }
                    let next = masks.get(count).copied().unwrap_or(0);
                    plane | (masks[count - 1] & !next)
                });
                units.extend(four(plane));
            }
            return;
        }
        let here = self.here();
        units.push((self.changes | (here & 0x3f) << 9) as u16);
        for (i, &mask) in masks.iter().enumerate() {
            match self.shared[i] {
                Some(place) if here >> i & 1 == 0 => units.push(place),
                _ => units.extend(four(mask)),
            }
        }
    }

    /// Decodes the node at the start of `units`. Returns it with its number of units.
    ///
    /// The node is returned as it is encoded. [`Cube::from_leaf_masks`] checks whether each of its masks has
    /// a subset of the lit voxels of the one before.
    ///
    /// # Errors
    /// Returns [`Unreadable`] if `units` ends before the node does, or if its bits are invalid.
    pub fn read(units: &[u16], leaf_masks: &[u64]) -> Result<(Self, u32), Unreadable> {
        let unit = u32::from(*units.first().ok_or(Unreadable::End)?);
        let (changes, shadowed) = ((unit & 0xff).count_ones(), unit >> 8 & 1);
        let here = inline_masks(unit);
        let in_planes = unit >> 15 == 1;
        if changes == 0 || unit & 0x1ff == 0x101 || (in_planes && here != 0) {
            return Err(Unreadable::Bits);
        }
        let count = changes - shadowed;
        // Bits of missing masks must be zero, except that 6 and 7 share a bit with 5.
        let beyond = if count > 5 { 0 } else { here >> count };
        if beyond != 0 || (in_planes && count == 0) {
            return Err(Unreadable::Bits);
        }
        let mut cube = Self { changes: unit & 0x1ff, ..Self::default() };
        let mut at = 1;
        let four = |at: usize| {
            let units = units.get(at..at + 4).ok_or(Unreadable::End)?;
            Ok(units.iter().rev().fold(0, |mask, &unit| mask << 16 | u64::from(unit)))
        };
        if in_planes {
            let planes = plane_count(count) as usize;
            // Voxels that are lit in at least 1, 2, ... masks. The entry beyond the number of masks detects
            // invalid counts.
            let mut lit_in = [u64::MAX; 9];
            for bit in 0..planes {
                let plane: u64 = four(at)?;
                at += 4;
                for (i, mask) in lit_in.iter_mut().enumerate() {
                    *mask = if (i + 1) >> bit & 1 == 1 { *mask & plane } else { *mask | plane };
                }
            }
            let count = count as usize;
            if (count + 1) >> planes == 0 && lit_in[count] != 0 {
                return Err(Unreadable::Bits);
            }
            cube.masks[..count].copy_from_slice(&lit_in[..count]);
            return Ok((cube, at as u32));
        }
        for i in 0..count as usize {
            if here >> i & 1 == 1 {
                cube.masks[i] = four(at)?;
                at += 4;
            } else {
                let place = *units.get(at).ok_or(Unreadable::End)?;
                cube.masks[i] = *leaf_masks.get(usize::from(place)).ok_or(Unreadable::LeafMask(place))?;
                cube.shared[i] = Some(place);
                at += 1;
            }
        }
        Ok((cube, at as u32))
    }
}
