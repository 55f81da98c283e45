//! A slow reader of the point look-up, K = 1, written from `spec/adumbra-dag.md` alone. It works on the
//! file's bytes and shares no code with the library. It checks nothing, so it must only be given valid files.

use adumbra_testing::{f64_at, u32_at, u64_at};

/// Returns the visibility of a world point: 1 = lit, 0 = shadowed.
pub(crate) fn visibility(file: &[u8], world: [f64; 3]) -> u8 {
    let mut grid = [0.0; 3];
    for (r, g) in (0_u64..).zip(&mut grid) {
        let mut sum = 0.0;
        for (c, p) in (0_u64..).zip(world) {
            sum += f64_at(file, 112 + 24 * r + 8 * c) * p;
        }
        *g = sum / f64_at(file, 56) - f64_at(file, 88 + 8 * r);
    }
    let size = [24, 28, 32].map(|at| f64::from(u32_at(file, at)));
    let beside = !(grid[0] >= 0.0 && grid[0] < size[0] && grid[1] >= 0.0 && grid[1] < size[1]);
    if beside || grid[2].is_nan() || grid[2] < 0.0 {
        return 1;
    }
    let z = if grid[2] >= size[2] { size[2] - 1.0 } else { grid[2] };
    voxel(file, [grid[0].floor() as u32, grid[1].floor() as u32, z.floor() as u32])
}

/// Returns the visibility of a voxel of the grid: 1 = lit, 0 = shadowed.
pub(crate) fn voxel(file: &[u8], v: [u32; 3]) -> u8 {
    match u32_at(file, 52) {
        0 => plain_voxel(file, v),
        _ => packed_voxel(file, v),
    }
}

fn plain_voxel(file: &[u8], [x, y, z]: [u32; 3]) -> u8 {
    let (top, nodes, leaf_masks) = (u64_at(file, 280), u64_at(file, 304), u64_at(file, 328));
    let root_level = u32_at(file, 36);
    let (dx, dy) = (u64::from(u32_at(file, 40)), u64::from(u32_at(file, 44)));
    let (gx, gy, gz) = (u64::from(x >> root_level), u64::from(y >> root_level), u64::from(z >> root_level));
    let mut pointer = u32_at(file, top + 4 * ((gz * dy + gy) * dx + gx));
    if pointer == 0xFFFF_FFFF {
        return 1;
    }
    if pointer == 0xFFFF_FFFE {
        return 0;
    }
    let mut level = root_level;
    loop {
        let child = if level == 3 {
            z % 8
        } else {
            let half = 1 << (level - 1);
            u32::from(x & half != 0) * 4 + u32::from(y & half != 0) * 2 + u32::from(z & half != 0)
        };
        let header = u32_at(file, nodes + 4 * u64::from(pointer));
        let state = |c: u32| header >> (2 * c) & 3;
        if state(child) < 2 {
            return state(child) as u8;
        }
        let earlier = (0..child).filter(|&c| state(c) == 2).count() as u64;
        pointer = u32_at(file, nodes + 4 * (u64::from(pointer) + 1 + earlier));
        if level == 3 {
            let mask = u64_at(file, leaf_masks + 8 * u64::from(pointer));
            return (mask >> (y % 8 * 8 + x % 8) & 1) as u8;
        }
        level -= 1;
    }
}

fn packed_voxel(file: &[u8], [x, y, z]: [u32; 3]) -> u8 {
    let (top, nodes, leaf_masks) = (u64_at(file, 280), u64_at(file, 304), u64_at(file, 328));
    let word = |i: u64| u64::from(u32_at(file, top + 4 * i));
    let unit = |u: u64| u64::from(u32_at(file, nodes + u / 2 * 4) >> (u % 2 * 16) & 0xFFFF);
    let four = |u: u64| (0..4).map(|i| unit(u + i) << (16 * i)).sum::<u64>();
    let root_level = u32_at(file, 36);
    let (dx, dy) = (u64::from(u32_at(file, 40)), u64::from(u32_at(file, 44)));
    let [gx, gy, gz] = [x, y, z].map(|c| u64::from(c >> root_level));
    let column = gy * dx + gx;
    let (first, z0, end) = (word(19 + 2 * column), word(20 + 2 * column), word(21 + 2 * column));
    if gz < z0 {
        return 1;
    }
    if gz - z0 >= end - first {
        return 0;
    }
    let root = word(19 + 2 * dx * dy + 1 + first + gz - z0);
    let mut level = u64::from(root_level);
    let mut at = word(level - 3) + root;
    while level > 3 {
        let header = unit(at);
        // For each of the two children of each quarter, `Ok` with its pointer if it is mixed, or `Err` with
        // its visibility.
        let mut pointers = 0;
        let mut states = Vec::new();
        for q in 0..4 {
            let (near, far, count) = match header >> (3 * q) & 7 {
                0 => (Err(0), Err(0), 0),
                1 => (Err(1), Err(1), 0),
                2 => (Err(1), Err(0), 0),
                3 => (Ok(pointers), Ok(pointers + 1), 2),
                4 => (Err(1), Ok(pointers), 1),
                5 => (Ok(pointers), Err(0), 1),
                6 => (Ok(pointers), Ok(pointers), 1),
                _ => panic!("code 7"),
            };
            states.extend([near, far]);
            pointers += count;
        }
        let half = |c: u32| usize::from(c & 1 << (level - 1) != 0);
        let pointer: u64 = match states[4 * half(x) + 2 * half(y) + half(z)] {
            Err(answer) => return answer,
            Ok(pointer) => pointer,
        };
        // The string of high parts is read bit by bit.
        let pool = word(level - 3) - word(level - 4);
        let width = if pool <= 1 << 20 {
            4
        } else if pool <= 1 << 24 {
            8
        } else {
            16
        };
        let bit = |b: u64| unit(at + 1 + b / 16) >> (b % 16) & 1;
        let has_string = header >> 15 == 1;
        let wide: Vec<u64> = (0..8).filter(|&p| has_string && bit(p) == 1).collect();
        let string_bits = width.max(8) + width * wide.len() as u64;
        let slots = at + 1 + if has_string { string_bits.div_ceil(16) } else { 0 };
        let follower = header >> 12 & 7;
        let with_slot: Vec<u64> = (0..pointers).filter(|&p| p != follower || p == 7).collect();
        let behind = slots + with_slot.len() as u64;
        at = match with_slot.iter().position(|&p| p == pointer) {
            None => behind,
            Some(i) => {
                let value = unit(slots + i as u64);
                let below = word(level - 4);
                if let Some(rank) = wide.iter().position(|&p| p == pointer) {
                    let from = width.max(8) + width * rank as u64;
                    below + value + ((0..width).map(|b| bit(from + b) << b).sum::<u64>() << 16)
                } else if value < 1024 {
                    behind + value
                } else {
                    below + value - 1024
                }
            }
        };
        level -= 1;
    }
    let header = unit(at);
    let changes: Vec<u32> = (0..8).filter(|k| header >> k & 1 == 1).collect();
    let ends_shadowed = header >> 8 & 1 == 1;
    let masks = changes.len() - usize::from(ends_shadowed);
    let place = (y % 8 * 8 + x % 8) as u64;
    let passed = changes.iter().filter(|&&k| k <= z % 8).count();
    if passed == 0 {
        return 1;
    }
    if passed > masks {
        return 0;
    }
    if header >> 15 == 1 {
        let planes = (1..).find(|&n| masks < 1 << n).expect("a number of planes");
        let lit_in: u64 = (0..planes).map(|b| (four(at + 1 + 4 * b) >> place & 1) << b).sum();
        return u8::from(lit_in >= passed as u64);
    }
    let mut from = at + 1;
    for mask in 1.. {
        let here = header >> (8 + mask.min(6)) & 1 == 1;
        if mask == passed {
            let bits = if here { four(from) } else { u64_at(file, leaf_masks + 8 * unit(from)) };
            return (bits >> place & 1) as u8;
        }
        from += if here { 4 } else { 1 };
    }
    unreachable!("the masks have an end")
}
