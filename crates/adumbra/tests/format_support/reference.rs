//! A slow reader of the point look-up, K = 1, written from `spec/adumbra-file.md` alone. It works on the file's bytes
//! and shares no code with the library. It checks nothing, so it must only be given valid files.

use adumbra_testing::{f64_at, u32_at, u64_at};

/// Returns the visibility of a world point: 1 = lit, 0 = shadowed.
pub(crate) fn visibility(file: &[u8], world: [f64; 3]) -> u8 {
    // Up to version 2 the header holds the world position of the corner.
    let has_origin = u32_at(file, 8) < 3;
    let mut grid = [0.0; 3];
    for (r, g) in (0_u64..).zip(&mut grid) {
        let mut sum = 0.0;
        for (c, p) in (0_u64..).zip(world) {
            let axis = f64_at(file, 112 + 24 * r + 8 * c);
            let origin = if has_origin { f64_at(file, 88 + 8 * c) } else { 0.0 };
            sum += axis * (p - origin);
        }
        *g = sum / f64_at(file, 56) - if has_origin { 0.0 } else { f64_at(file, 88 + 8 * r) };
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
pub(crate) fn voxel(file: &[u8], [x, y, z]: [u32; 3]) -> u8 {
    const NONE: u32 = 0xFFFF_FFFF;
    let (top, code, entries) = (u64_at(file, 280), u64_at(file, 304), u64_at(file, 328));
    let byte = |b: u32| u32::from(file[code as usize + b as usize]);
    let half = |h: u32| byte(2 * h) + 256 * byte(2 * h + 1);
    let two = |h: u32| half(h) + 65536 * half(h + 1);
    let mut level = u32_at(file, 36);
    let root = u64::from(y >> level) * u64::from(u32_at(file, 40)) + u64::from(x >> level);
    let (mut at, mut base) = (u32_at(file, top + 8 * root), u32_at(file, top + 8 * root + 4));
    while at != NONE && level > 3 {
        let digit = |c: u32| c >> (level - 2) & 3;
        let child = 4 * digit(y) + digit(x);
        let size = |c: u32| (half(at) >> c & 1) + 2 * (half(at + 1) >> c & 1);
        let field = at + 3 + (0..child).map(size).sum::<u32>();
        let near = |h: u32| if half(h) < 32768 { half(h) } else { at - (half(h) - 32768) };
        // A half-word of 32768 or more represents its value less 65536.
        let moved = |h: u32| base.wrapping_add(half(h)).wrapping_sub(if half(h) < 32768 { 0 } else { 65536 });
        (at, base) = match (size(child), half(at + 2) >> child & 1) {
            (0, 0) => (NONE, base),
            (0, _) => (NONE, NONE),
            (1, 0) => (near(field), base),
            (1, _) => (NONE, moved(field)),
            (2, 0) => (two(field), base),
            (2, _) => (near(field + 1), moved(field)),
            (_, 0) => (two(field + 1), moved(field)),
            _ => {
                let entry = entries + 8 * u64::from(two(field));
                (u32_at(file, entry + 4), base.wrapping_add(u32_at(file, entry)))
            }
        };
        level -= 2;
    }
    if at == NONE {
        return u8::from(z < base);
    }
    let head = half(at);
    let (last, never, bytes) = (head & 63, head >> 6 & 1, 1 << (head >> 7 & 3));
    let mut next = at + 1;
    let mut rise = 0;
    if head >> 9 & 1 == 1 {
        for (gradient, c) in [(byte(2 * next), x % 8), (byte(2 * next + 1), y % 8)] {
            rise += if gradient < 128 { gradient * (7 - c) } else { (256 - gradient) * c };
        }
        rise = rise.div_ceil(4);
        next += 1;
    }
    let mut depths = vec![base];
    for d in 0..last - never {
        let difference = (0..bytes).map(|b| byte(2 * next + d * bytes + b) << (8 * b)).sum::<u32>();
        depths.push(depths[d as usize].saturating_add(difference));
    }
    next += ((last - never) * bytes).div_ceil(2);
    let column = y % 8 * 8 + x % 8;
    let planes = (0..).find(|&n| last < 1 << n).expect("a number of planes");
    let rank: u32 = (0..planes).map(|p| (half(next + 4 * p + column / 16) >> (column % 16) & 1) << p).sum();
    match depths.get(rank as usize) {
        Some(depth) => u8::from(z < depth.saturating_sub(rise)),
        None => 1,
    }
}
