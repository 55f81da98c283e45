//! Where the columns of a small block switch from lit to shadowed: as few depths as their intervals allow, each on as round
//! a number as it may.
//!
//! Few depths make long curtains of one mask; round depths let neighbours, and levels above, agree. The fewest points that
//! hit every interval are those of the classic greedy choice: the smallest x left, and again.

use super::columns::FREE_TO_END;
use super::sink::BlockColumns;

/// Depths beyond the last surface of a column whose end is free are rounded up to multiples of 2^this: the shadow still
/// begins close behind the surface, for what moves there.
pub(super) const FREE_ROUND_LEVEL: u32 = 6;

/// The slabs of an 8 × 8 block, cube by cube of eight layers: `visit(end, masks)` for all cubes from where the last call
/// ended up to `end`, which all have these eight slabs, bit y·8 + x, 1 = lit. The last call goes on for ever.
pub(super) fn for_each_cube(columns: &BlockColumns, depth: u32, mut visit: impl FnMut(u32, [u64; 8])) {
    let latest = columns.e.iter().fold(0, |m, &e| m.max(e));
    let forced = columns.x.iter().fold(FREE_TO_END, |m, &x| m.min(x));
    if latest <= forced {
        // One switch serves all.
        let switch = roundest(latest, forced).min(depth.next_multiple_of(8));
        visit_switch(switch, depth, &mut visit);
        return;
    }
    let mut events = Events::default();
    for i in 0..columns.e.len() {
        events.add(columns.e[i], forced);
        events.add(columns.x[i], forced);
    }
    let first = forced >> 3;
    if first > 0 {
        visit(first, [u64::MAX; 8]);
    }
    let mut mask = u64::MAX;
    let mut cube = first;
    loop {
        let z = cube << 3;
        if z >= depth {
            break;
        }
        let start = columns.must_be_lit(z);
        if start == 0 {
            mask = 0;
            break;
        }
        let mut masks = [0; 8];
        if start == columns.must_be_lit(z + 7) && mask != u64::MAX {
            mask = start;
            masks = [mask; 8];
        } else {
            for (k, slab) in (z..).zip(&mut masks) {
                if mask & columns.must_be_shadowed(k) != 0 {
                    mask = columns.must_be_lit(k);
                }
                *slab = mask;
            }
        }
        let next = events.after(cube);
        if next == cube + 1 || masks != [mask; 8] {
            visit(cube + 1, masks);
            cube += 1;
        } else {
            visit(cube + 1, masks);
            cube += 1;
            let still = columns.must_be_lit(cube << 3);
            if next > cube && next != u32::MAX {
                mask = still;
                visit(next, [still; 8]);
                cube = next;
            } else if next == u32::MAX {
                mask = still;
                break;
            }
        }
    }
    visit(FREE_TO_END, [mask; 8]);
}

fn visit_switch(switch: u32, depth: u32, visit: &mut impl FnMut(u32, [u64; 8])) {
    if switch >= depth {
        visit(FREE_TO_END, [u64::MAX; 8]);
        return;
    }
    let cube = switch >> 3;
    if cube > 0 {
        visit(cube, [u64::MAX; 8]);
    }
    if switch & 7 != 0 {
        visit(cube + 1, std::array::from_fn(|k| if (k as u32) < switch & 7 { u64::MAX } else { 0 }));
    }
    visit(FREE_TO_END, [0; 8]);
}

/// Cubes in which something may change.
#[derive(Default)]
struct Events {
    cubes: Vec<u32>,
}

impl Events {
    fn add(&mut self, depth: u32, forced: u32) {
        if depth >= forced && depth != FREE_TO_END && !self.cubes.contains(&(depth >> 3)) {
            self.cubes.push(depth >> 3);
        }
    }

    fn after(&self, cube: u32) -> u32 {
        self.cubes.iter().copied().filter(|&c| c > cube).min().unwrap_or(u32::MAX)
    }
}

/// The number of `[start, end]` that is a multiple of the highest power of two; where the end is free, a multiple of
/// 2^[`FREE_ROUND_LEVEL`].
pub(super) fn roundest(start: u32, end: u32) -> u32 {
    if end == FREE_TO_END {
        return start.checked_next_multiple_of(1 << FREE_ROUND_LEVEL).unwrap_or(start);
    }
    if start == 0 || start == end {
        return start;
    }
    // Below the highest bit in which start - 1 and end differ, end has only zeros to offer.
    let differ = 31 - ((start - 1) ^ end).leading_zeros();
    end & !((1 << differ) - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roundest_is_the_number_with_most_zeros() {
        for start in 0..200_u32 {
            for end in start..200 {
                let best = (start..=end).max_by_key(|n| n.trailing_zeros()).unwrap_or(start);
                assert_eq!(roundest(start, end).trailing_zeros(), best.trailing_zeros(), "{start} {end}");
                assert!((start..=end).contains(&roundest(start, end)));
            }
        }
        assert_eq!(roundest(65, FREE_TO_END), 128);
        assert_eq!(roundest(64, FREE_TO_END), 64);
    }
}
