//! One node taken apart: what encoder, validation and the way back share. The look-up reads only what it needs.

use super::NEAR_UNITS;

/// Both shadowed.
pub(super) const SS: u32 = 0;
/// Both lit.
pub(super) const LL: u32 = 1;
/// Lit, then shadowed.
pub(super) const LS: u32 = 2;
/// Two mixed nodes.
pub(super) const M2: u32 = 3;
/// Lit, then mixed.
pub(super) const LM: u32 = 4;
/// Mixed, then shadowed.
pub(super) const MS: u32 = 5;
/// One mixed node for both.
pub(super) const MM: u32 = 6;
/// No child follows the slots.
pub(super) const NO_FOLLOWER: u32 = 7;

/// The lowest `count` bits; at most 31.
pub(super) fn bits_below(count: u32) -> u32 {
    (1 << count) - 1
}

/// Pointers of the quarters in `codes`, three bits each, none of them 7.
pub(super) fn pointers_in(codes: u32) -> u32 {
    (codes & 0o4444).count_ones() + 2 * (codes & codes >> 1 & 0o1111).count_ones()
}

/// Bits of a wide slot's high part, where the pool that it leads to has so many units.
pub(super) fn high_bits(pool_units: u32) -> u32 {
    match pool_units {
        0..=0x10_0000 => 4,
        0x10_0001..=0x100_0000 => 8,
        _ => 16,
    }
}

/// Planes that `masks` masks take.
pub(super) fn plane_count(masks: u32) -> u32 {
    u32::BITS - masks.leading_zeros()
}

/// Bit i: mask i of a level-3 node stands in it.
pub(super) fn masks_here(unit: u32) -> u32 {
    let flags = unit >> 9 & 0x3f;
    flags | ((flags & 0x20) * 6)
}

/// Where a pointer leads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Target {
    /// Right behind the slots.
    #[default]
    Follows,
    /// So many units behind the end of the slots.
    Near(u32),
    /// That unit of the pool of the level below.
    Pool(u32),
}

/// A node above level 3 without the children that lie in it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Inner {
    /// Twelve bits: three a quarter.
    pub(super) codes: u32,
    /// Where the pointers lead, as many as [`pointers_in`] says.
    pub(super) targets: [Target; 8],
}

impl Inner {
    pub(super) fn pointers(&self) -> &[Target] {
        &self.targets[..pointers_in(self.codes) as usize]
    }

    /// Units before the children that lie in it.
    pub(super) fn units(&self, high_bits: u32) -> u32 {
        let slots = self.pointers().iter().filter(|t| **t != Target::Follows).count() as u32;
        1 + string_units(self.wide(), high_bits) + slots
    }

    /// Appends it to `units`.
    pub(super) fn write(&self, high_bits: u32, units: &mut Vec<u16>) {
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

    /// The node that begins at `units`' front, as [`Inner::write`] writes it. Its children may be anything.
    pub(super) fn read(units: &[u16], high_bits: u32) -> Result<Self, Unreadable> {
        let unit = u32::from(*units.first().ok_or(Unreadable::End)?);
        let codes = unit & 0xfff;
        let pointers = pointers_in(codes);
        let follower = unit >> 12 & 7;
        // A 7 is the one code of which all three bits are set.
        let invalid = codes & codes >> 1 & codes >> 2 & 0o1111 != 0;
        if invalid || (follower != NO_FOLLOWER && follower >= pointers) || !differs(codes) {
            return Err(Unreadable::Bits);
        }
        let front = if unit >> 15 == 0 { 0 } else { u32::from(*units.get(1).ok_or(Unreadable::End)?) };
        let wide = front & 0xff;
        // Wide are pointers that have a slot; where high parts begin with the next unit, the rest of this one is empty.
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

    /// Pointers whose slots are wide.
    fn wide(&self) -> u32 {
        let wide = |t: &Target| matches!(t, Target::Pool(unit) if *unit >= NARROW_POOL_UNITS);
        self.pointers().iter().enumerate().fold(0, |mask, (p, t)| mask | u32::from(wide(t)) << p)
    }
}

/// Units of a pool that narrow slots reach.
const NARROW_POOL_UNITS: u32 = (1 << 16) - NEAR_UNITS;

/// Whether a node of these quarters is not all lit or all shadowed.
fn differs(codes: u32) -> bool {
    codes != 0 && codes != 0o1111
}

/// Units of the high parts of these wide slots, with what says which they are.
fn string_units(wide: u32, high_bits: u32) -> u32 {
    if wide == 0 { 0 } else { (high_bits.max(8) + high_bits * wide.count_ones()).div_ceil(16) }
}

/// Why there is no node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unreadable {
    /// The units end before it does.
    End,
    /// Bits that mean nothing, or a node that has another form.
    Bits,
    /// A shared slab that is not there.
    Slab(u16),
}

/// A node of level 3.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Cube {
    /// Bit k: slab k is not as the one before; bit 8: the last change is to all shadowed.
    pub(super) changes: u32,
    /// What is neither all lit nor all shadowed, each with fewer voxels lit than the one before.
    pub(super) masks: [u64; 8],
    /// Places of the masks among the shared slabs.
    pub(super) shared: [Option<u16>; 8],
}

impl Cube {
    /// The node of these slabs, z = 0 first; none where one has a voxel lit that the one before has not.
    pub(super) fn of_slabs(slabs: &[u64; 8]) -> Option<Self> {
        let mut cube = Self::default();
        let mut last = u64::MAX;
        for (k, &slab) in slabs.iter().enumerate() {
            if slab & !last != 0 {
                return None;
            }
            if slab != last {
                if slab == 0 {
                    cube.changes |= 1 << 8;
                } else {
                    cube.masks[cube.mask_count()] = slab;
                }
                cube.changes |= 1 << k;
            }
            last = slab;
        }
        Some(cube)
    }

    /// The slabs, z = 0 first.
    pub(super) fn slabs(&self) -> [u64; 8] {
        let mut masks = self.masks[..self.mask_count()].iter();
        let mut slab = u64::MAX;
        std::array::from_fn(|k| {
            if self.changes >> k & 1 == 1 {
                slab = masks.next().copied().unwrap_or(0);
            }
            slab
        })
    }

    pub(super) fn mask_count(&self) -> usize {
        ((self.changes & 0xff).count_ones() - (self.changes >> 8 & 1)) as usize
    }

    /// Bit i: mask i stands in the node. Masks 5, 6 and 7 do so together.
    fn here(&self) -> u32 {
        let here = (0..self.mask_count()).fold(0, |bits, i| bits | u32::from(self.shared[i].is_none()) << i);
        if here >> 5 == 0 { here } else { (here | 0xe0) & bits_below(self.mask_count() as u32) }
    }

    /// Whether planes take fewer units than masks.
    pub(super) fn in_planes(&self) -> bool {
        4 * plane_count(self.mask_count() as u32) < self.mask_units()
    }

    fn mask_units(&self) -> u32 {
        self.mask_count() as u32 + 3 * self.here().count_ones()
    }

    /// Shared slabs that it needs.
    pub(super) fn shared_used(&self) -> impl Iterator<Item = u16> {
        let used = if self.in_planes() { 0 } else { !self.here() };
        (0..self.mask_count()).filter(move |i| used >> i & 1 == 1).filter_map(|i| self.shared[i])
    }

    pub(super) fn units(&self) -> u32 {
        1 + if self.in_planes() { 4 * plane_count(self.mask_count() as u32) } else { self.mask_units() }
    }

    /// Appends it to `units`.
    pub(super) fn write(&self, units: &mut Vec<u16>) {
        let masks = &self.masks[..self.mask_count()];
        let four = |mask: u64| [0, 16, 32, 48].map(|shift| (mask >> shift) as u16);
        if self.in_planes() {
            units.push((self.changes | 1 << 15) as u16);
            for bit in 0..plane_count(masks.len() as u32) {
                // How many masks have a voxel lit is odd in this bit where an odd number of runs of 2^bit masks end there.
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

    /// The node that begins at `units`' front, and its units. It is written as it was read; whether its masks lose voxels
    /// one after the other is for [`Cube::of_slabs`] to say.
    pub(super) fn read(units: &[u16], slabs: &[u64]) -> Result<(Self, u32), Unreadable> {
        let unit = u32::from(*units.first().ok_or(Unreadable::End)?);
        let (changes, shadowed) = ((unit & 0xff).count_ones(), unit >> 8 & 1);
        let here = masks_here(unit);
        let in_planes = unit >> 15 == 1;
        if changes == 0 || unit & 0x1ff == 0x101 || (in_planes && here != 0) {
            return Err(Unreadable::Bits);
        }
        let count = changes - shadowed;
        // Of masks that are not there only 6 and 7 may have a bit, the one that they share with 5.
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
            // Voxels that are lit in at least 1, 2, ... masks; one more than there are masks finds counts that mean nothing.
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
                cube.masks[i] = *slabs.get(usize::from(place)).ok_or(Unreadable::Slab(place))?;
                cube.shared[i] = Some(place);
                at += 1;
            }
        }
        Ok((cube, at as u32))
    }
}
