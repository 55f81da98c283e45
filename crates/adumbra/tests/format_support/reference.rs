//! A slow reader of the point look-up, K = 1, written from `spec/adumbra-file.md` alone. It works on the
//! file's bytes and shares no code with the library. It checks nothing, so it must only be given valid files.

use adumbra_testing::{f64_at, u32_at, u64_at};

/// Offset of the directory's first entry, the finest grid.
const GRID: u64 = 256;

/// Returns the visibility of a world point: 1 = lit, 0 = shadowed.
pub(crate) fn visibility(file: &[u8], world: [f64; 3]) -> u8 {
    let mut grid = [0.0; 3];
    for (r, g) in (0_u64..).zip(&mut grid) {
        let mut sum = 0.0;
        for (c, p) in (0_u64..).zip(world) {
            sum += f64_at(file, GRID + 72 + 24 * r + 8 * c) * p;
        }
        *g = sum / f64_at(file, GRID + 16) - f64_at(file, GRID + 48 + 8 * r);
    }
    let size = [0, 4, 8].map(|at| f64::from(u32_at(file, GRID + at)));
    let beside = !(grid[0] >= 0.0 && grid[0] < size[0] && grid[1] >= 0.0 && grid[1] < size[1]);
    if beside || grid[2].is_nan() || grid[2] < 0.0 {
        return 1;
    }
    let z = if grid[2] >= size[2] { size[2] - 1.0 } else { grid[2] };
    voxel(file, 0, [grid[0].floor() as u32, grid[1].floor() as u32, z.floor() as u32])
}

/// Returns the place of the `d`-th point of the Hilbert curve through a square of `side` points, by the rule
/// of the specification, with everything inside.
fn hilbert(d: u64, side: i64) -> [i64; 2] {
    let (mut d, mut corner, mut u, mut v) = (d, [0_i64; 2], [side, 0], [0, side]);
    let mut count = (side * side) as u64;
    while count > 1 {
        count /= 4;
        let (quarter, half) = (d / count, |e: [i64; 2]| e.map(|c| c / 2));
        d %= count;
        let (hu, hv) = (half(u), half(v));
        let plus = |a: [i64; 2], b: [i64; 2]| [a[0] + b[0], a[1] + b[1]];
        (corner, u, v) = match quarter {
            0 => (corner, hv, hu),
            1 => (plus(corner, hu), hu, hv),
            2 => (plus(corner, plus(hu, hv)), hu, hv),
            _ => (plus(corner, plus(hu, v)), hv.map(|c| -c), hu.map(|c| -c)),
        };
    }
    // An edge that points backwards has the point on its other side.
    [0, 1].map(|a| corner[a] + u[a].min(0) + v[a].min(0))
}

/// Where a page is in a file.
struct Page {
    root: u32,
    base: u32,
    /// Offset of its words.
    words: u64,
}

/// Finds the page at a place of the grid at `entry` of the directory.
fn page(file: &[u8], entry: u64, [px, py]: [u32; 2]) -> Page {
    let pages = [0, 4].map(|at| u32_at(file, entry + at).div_ceil(512));
    let dims = pages.map(|n| i64::from(n.div_ceil(4)));
    let side = (dims[0].max(dims[1]) as u64).next_power_of_two() as i64;
    let (mut row, mut at) = (u64_at(file, entry + 160), u64_at(file, entry + 208));
    for d in 0.. {
        let place = hilbert(d, side);
        if place[0] >= dims[0] || place[1] >= dims[1] {
            continue;
        }
        if place == [px, py].map(|c| i64::from(c / 4)) {
            break;
        }
        at += u64::from(u32_at(file, row));
        row += 24;
    }
    if u32_at(file, row) == 0 {
        return Page { root: u32::MAX, base: u32_at(file, row + 12), words: at };
    }
    let slot = u64::from(py % 4 * 4 + px % 4);
    let before: u32 = (0..slot).map(|p| u32_at(file, at + 12 * p + 8)).sum();
    let [root, base] = [0, 4].map(|field| u32_at(file, at + 12 * slot + field));
    Page { root, base, words: at + 192 + 4 * u64::from(before) }
}

/// Returns the visibility of a voxel of a level's grid: 1 = lit, 0 = shadowed.
pub(crate) fn voxel(file: &[u8], level_of_detail: u64, [x, y, z]: [u32; 3]) -> u8 {
    const NONE: u32 = 0xFFFF_FFFF;
    let entry = GRID + 256 * level_of_detail;
    let common = u64_at(file, entry + 184);
    let Page { root, mut base, words } = page(file, entry, [x / 512, y / 512]);
    // Addresses within the page, or within the common section.
    let (mut at, mut in_page) =
        if root == NONE || root < 1 << 31 { (root, false) } else { (root - (1 << 31), true) };
    let mut level = 9;
    while at != NONE && level > 3 {
        let code = if in_page { words } else { common };
        let byte = |b: u32| u32::from(file[code as usize + b as usize]);
        let half = |h: u32| byte(2 * h) + 256 * byte(2 * h + 1);
        let two = |h: u32| half(h) + 65536 * half(h + 1);
        let digit = |c: u32| c >> (level - 2) & 3;
        let child = 4 * digit(y) + digit(x);
        // The bits of a child, high first, as one number.
        let form = |c: u32| 4 * (half(at + 1) >> c & 1) + 2 * (half(at) >> c & 1) + (half(at + 2) >> c & 1);
        let field = at + 3 + (0..child).map(|c| [0, 0, 1, 1, 1, 2, 3][form(c) as usize]).sum::<u32>();
        let near =
            |h: u32| if half(h) < 32768 { (half(h), false) } else { (at - (half(h) - 32768), in_page) };
        // A half-word of 32768 or more represents its value less 65536.
        let moved = |h: u32| base.wrapping_add(half(h)).wrapping_sub(if half(h) < 32768 { 0 } else { 65536 });
        let none = (NONE, false);
        ((at, in_page), base) = match form(child) {
            0 => (none, base),
            1 => (none, NONE),
            2 => (near(field), base),
            3 => (none, moved(field)),
            4 => {
                let (back, delta) = (half(field) % 256, half(field) / 256);
                let less = if delta < 128 { 0 } else { 256 };
                ((at - back, in_page), base.wrapping_add(delta).wrapping_sub(less))
            }
            5 => (near(field + 1), moved(field)),
            _ => {
                let far = two(field + 1);
                let (place, delta) = (far % (1 << 25), half(field) + (far >> 25) % 64 * 65536);
                let less = if delta < 1 << 21 { 0 } else { 1 << 22 };
                let to = match (far >> 31, place) {
                    (0, _) => (place, false),
                    (_, 0) => none,
                    _ => (at - place, in_page),
                };
                (to, base.wrapping_add(delta).wrapping_sub(less))
            }
        };
        level -= 2;
    }
    let code = if in_page { words } else { common };
    let byte = |b: u32| u32::from(file[code as usize + b as usize]);
    let half = |h: u32| byte(2 * h) + 256 * byte(2 * h + 1);
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
