//! A slow reader of the point look-up, K = 1, written from `spec/adumbra-file.md` alone: it works on the file's bytes
//! and shares nothing with the library. It checks nothing; give it valid files.

fn u32_at(file: &[u8], at: u64) -> u32 {
    let at = at as usize;
    u32::from_le_bytes([file[at], file[at + 1], file[at + 2], file[at + 3]])
}

fn u64_at(file: &[u8], at: u64) -> u64 {
    u64::from(u32_at(file, at)) | u64::from(u32_at(file, at + 4)) << 32
}

fn f64_at(file: &[u8], at: u64) -> f64 {
    f64::from_bits(u64_at(file, at))
}

/// Visibility of a world point: 1 = lit, 0 = shadowed.
pub(crate) fn visibility(file: &[u8], world: [f64; 3]) -> u8 {
    let mut grid = [0.0; 3];
    for (r, g) in (0_u64..).zip(&mut grid) {
        let mut sum = 0.0;
        for (c, p) in (0_u64..).zip(world) {
            let axis = f64_at(file, 112 + 24 * r + 8 * c);
            let origin = f64_at(file, 88 + 8 * c);
            sum += axis * (p - origin);
        }
        *g = sum / f64_at(file, 56);
    }
    let size = [24, 28, 32].map(|at| f64::from(u32_at(file, at)));
    let beside = !(grid[0] >= 0.0 && grid[0] < size[0] && grid[1] >= 0.0 && grid[1] < size[1]);
    if beside || grid[2].is_nan() || grid[2] < 0.0 {
        return 1;
    }
    let z = if grid[2] >= size[2] { size[2] - 1.0 } else { grid[2] };
    voxel(file, [grid[0].floor() as u32, grid[1].floor() as u32, z.floor() as u32])
}

/// Visibility of a voxel of the grid.
pub(crate) fn voxel(file: &[u8], [x, y, z]: [u32; 3]) -> u8 {
    let (top, nodes, slabs) = (u64_at(file, 280), u64_at(file, 304), u64_at(file, 328));
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
            let mask = u64_at(file, slabs + 8 * u64::from(pointer));
            return (mask >> (y % 8 * 8 + x % 8) & 1) as u8;
        }
        level -= 1;
    }
}
