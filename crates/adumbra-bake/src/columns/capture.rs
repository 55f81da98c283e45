//! Computes the columns of a rectangle of texels: first surface, end of the first solid, and the nearest
//! receiver that may be behind.
//!
//! Two passes over the rectangle's triangles. The first samples texel centres. The second tests, for every
//! triangle near a texel's footprint, whether it is a receiver behind the column's caster. Only crossings of
//! solids are kept as lists, to count their winding. The rules are those of §3 of the specification,
//! implemented in `columns/rules.rs`.

use crate::columns::Columns;
use crate::columns::crossings::{crossing_key, solid_end};
use crate::columns::masked::TriangleMask;
use crate::columns::rules::{ColumnRules, FirstSurface, ReceiverKind};
use crate::columns::seams::{self, SeamHit};
use crate::triangles::depth::FixedDepth;
use crate::triangles::project::SEAM_MARGIN;
use crate::triangles::surface::{Surface, Surfaces};
use adumbra::Receivers;

/// Solid crossings that a rectangle may hold at once. A rectangle with more is captured in bands of rows.
const MAX_CROSSINGS: usize = 1 << 20;

/// A rectangle of texels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TexelRect {
    pub(crate) x: u32,
    pub(crate) y: u32,
    pub(crate) width: u32,
    pub(crate) height: u32,
}

/// Buffers that a worker reuses from one rectangle to the next.
#[derive(Default)]
pub struct CaptureBuffers {
    first: Vec<FirstSurface>,
    next: Vec<FixedDepth>,
    base: Vec<FixedDepth>,
    crossings: Vec<Crossing>,
    list_ends: Vec<u32>,
    sorted: Vec<u32>,
    seams: Vec<SeamHit>,
}

/// A solid's surface at a texel centre. The key orders crossings by depth, then entry before exit.
#[derive(Clone, Copy)]
struct Crossing {
    texel: u32,
    key: u32,
}

/// Returns the bytes that a worker needs for a rectangle of this many texels, columns included.
pub fn working_bytes(texels: u64) -> u64 {
    let texel = size_of::<FirstSurface>() + 2 * size_of::<FixedDepth>() + 4;
    // Vectors grow by doubling.
    let crossings = 2 * MAX_CROSSINGS * (size_of::<Crossing>() + 4);
    texels * (texel as u64 + 2 * 4) + crossings as u64
}

/// Captures the columns of `rect` from the surfaces near it.
pub(crate) fn capture(
    surfaces: &impl Surfaces,
    rules: &ColumnRules,
    rect: TexelRect,
    buffers: &mut CaptureBuffers,
    out: &mut Columns,
) {
    out.reset(rect.width, rect.height);
    for_each_band(rect, |band, start| {
        if !sample_band(surfaces, rules, band, buffers) {
            return false;
        }
        resolve_solids(buffers);
        find_receivers(surfaces, rules, &[ReceiverKind::Footprint], band, buffers);
        for i in 0..buffers.first.len() {
            out.set(start + i, rules.column(buffers.first[i], buffers.base[i], buffers.next[i]));
        }
        if rules.receivers == Receivers::Static {
            let kinds = [ReceiverKind::Footprint, ReceiverKind::Filtered];
            find_receivers(surfaces, rules, &kinds, band, buffers);
            for i in 0..buffers.first.len() {
                out.extend(start + i, rules.static_end(buffers.first[i], buffers.next[i]));
            }
        }
        surfaces.for_each(|surface| bound(surface, rules, band, start, out));
        true
    });
}

/// Finds the first surface of every texel of `rect`, and the solids along it. Calls
/// `visit(texel of the rect, surface, sorted crossings)` once per texel, in no particular order.
/// [`FirstSurface::bias`] is the bias of `rules` at the surface's slope.
pub(crate) fn capture_layers(
    surfaces: &impl Surfaces,
    rules: &ColumnRules,
    rect: TexelRect,
    buffers: &mut CaptureBuffers,
    mut visit: impl FnMut(usize, FirstSurface, &[u32]),
) {
    for_each_band(rect, |band, offset| {
        if !sample_band(surfaces, rules, band, buffers) {
            return false;
        }
        sort_crossings(buffers, |_| true);
        let mut start = 0;
        for (i, &end) in buffers.list_ends.iter().enumerate() {
            visit(offset + i, buffers.first[i], &buffers.sorted[start..end as usize]);
            start = end as usize;
        }
        true
    });
}

/// Covers all rows of `rect` in bands, from the first on. `capture(band, its first texel in rect)` returns
/// whether the band's crossings fit. If they do not, the band is split in half. A single row must fit.
fn for_each_band(rect: TexelRect, mut capture: impl FnMut(TexelRect, usize) -> bool) {
    let mut bands = vec![(rect.y, rect.height)];
    while let Some((y, height)) = bands.pop() {
        let start = ((y - rect.y) * rect.width) as usize;
        if !capture(TexelRect { y, height, ..rect }, start) {
            let half = height / 2;
            bands.push((y + half, height - half));
            bands.push((y, half));
        }
    }
}

/// First pass: fills `first` and `crossings` of a band of rows. Returns false if there are too many crossings
/// to hold and the band has more than one row.
fn sample_band(
    surfaces: &impl Surfaces,
    rules: &ColumnRules,
    rect: TexelRect,
    b: &mut CaptureBuffers,
) -> bool {
    let texels = (rect.width * rect.height) as usize;
    b.first.clear();
    b.first.resize(texels, FirstSurface::NONE);
    b.crossings.clear();
    b.seams.clear();
    let mut fits = true;
    surfaces.for_each(|surface| {
        fits = fits && (!surface.casts || sample_centers(surfaces, surface, rules, rect, b));
    });
    if fits {
        let CaptureBuffers { seams, first, .. } = b;
        if seams::keep_meeting_seams(seams) {
            surfaces.for_each(|surface| {
                seams::drop_covered_seams(seams, surface, |texel| {
                    let (x, y) = (texel as u32 % rect.width, texel as u32 / rect.width);
                    surface.shape.covers(i64::from(rect.x + x), i64::from(rect.y + y))
                });
            });
            seams::close_seams(seams, |texel, surface| first[texel] = first[texel].min(surface));
        }
    }
    fits
}

/// Second pass: fills `next`, the nearest depth at which a receiver of any of `kinds` needs a column's
/// shadow.
fn find_receivers(
    surfaces: &impl Surfaces,
    rules: &ColumnRules,
    kinds: &[ReceiverKind],
    rect: TexelRect,
    b: &mut CaptureBuffers,
) {
    b.next.clear();
    b.next.resize(b.first.len(), FixedDepth::MAX);
    surfaces.for_each(|surface| {
        for &kind in kinds {
            find_next(surface, rules, kind, rect, b);
        }
    });
}

/// First pass: samples the triangle at the texel centres that it covers.
fn sample_centers(
    surfaces: &impl Surfaces,
    surface: &Surface,
    rules: &ColumnRules,
    rect: TexelRect,
    b: &mut CaptureBuffers,
) -> bool {
    let triangle = &surface.shape;
    let Some(plane) = triangle.plane else { return true };
    let mask = if surface.masked {
        let Some(mask) = TriangleMask::new(surfaces.scene(), surfaces.grid(), surface) else { return true };
        Some(mask)
    } else {
        None
    };
    let margin = if surface.solid && !triangle.faces_sun { 0 } else { SEAM_MARGIN };
    let (first_row, last_row) = triangle.rows(margin);
    let (y0, y1) = (i64::from(rect.y), i64::from(rect.y + rect.height) - 1);
    let (x0, x1) = (i64::from(rect.x), i64::from(rect.x + rect.width) - 1);
    let info = rules.surface_info(triangle.slope, surface.solid);
    let exit_bit = u32::from(!triangle.faces_sun);
    for row in first_row.max(y0)..=last_row.min(y1) {
        let (first, last) = triangle.span(row, margin);
        let exact = if surface.solid && margin > 0 { triangle.span(row, 0) } else { (first, last) };
        let start = ((row - y0) * i64::from(rect.width) - x0) as isize;
        let y = row as f64 + 0.5;
        for i in first.max(x0)..=last.min(x1) {
            let x = i as f64 + 0.5;
            let depth = triangle.depth_at(&plane, x, y);
            let texel = (start + i as isize) as usize;
            if let Some(mask) = &mask {
                if mask.is_opaque(surfaces.scene(), [x, y]) {
                    b.first[texel] = b.first[texel].min(FirstSurface::new(depth, info));
                }
                continue;
            }
            if i < exact.0 || i > exact.1 {
                b.seams.push(SeamHit::new(texel, depth, info, surface));
                continue;
            }
            let first = FirstSurface::new(depth, info);
            if first < b.first[texel] {
                b.first[texel] = first;
            }
            if surface.solid {
                b.crossings.push(Crossing { texel: texel as u32, key: crossing_key(depth, exit_bit) });
            }
        }
        if b.crossings.len() > MAX_CROSSINGS && rect.height > 1 {
            return false;
        }
    }
    true
}

/// Walks the sorted crossings of every texel whose first surface bounds a solid. Writes to `base` the depth
/// behind which other receivers matter: the solid's end, or the first surface itself.
fn resolve_solids(b: &mut CaptureBuffers) {
    b.base.clear();
    b.base.extend(b.first.iter().map(|f| f.depth()));
    sort_crossings(b, |first| first.is_solid());
    let mut start = 0;
    for texel in 0..b.first.len() {
        let end = b.list_ends[texel] as usize;
        if end > start {
            match solid_end(&b.sorted[start..end]) {
                Some(exit) => b.base[texel] = exit,
                None => b.first[texel].set_open(),
            }
        }
        start = end;
    }
}

/// Sorts the crossings of each texel whose first surface is `wanted`. Those of texel i are in `sorted` from
/// `list_ends[i - 1]` (or 0) to `list_ends[i]`.
fn sort_crossings(b: &mut CaptureBuffers, wanted: impl Fn(FirstSurface) -> bool) {
    b.list_ends.clear();
    b.list_ends.resize(b.first.len(), 0);
    let wanted = |first: &[FirstSurface], c: &Crossing| wanted(first[c.texel as usize]);
    for c in b.crossings.iter().filter(|c| wanted(&b.first, c)) {
        b.list_ends[c.texel as usize] += 1;
    }
    let mut sum = 0;
    for count in &mut b.list_ends {
        sum += std::mem::replace(count, sum);
    }
    b.sorted.clear();
    b.sorted.resize(sum as usize, 0);
    for c in b.crossings.iter().filter(|c| wanted(&b.first, c)) {
        let slot = &mut b.list_ends[c.texel as usize];
        b.sorted[*slot as usize] = c.key;
        *slot += 1;
    }
    let mut start = 0;
    for &end in &b.list_ends {
        b.sorted[start..end as usize].sort_unstable();
        start = end as usize;
    }
}

/// Second pass: the surface as a receiver of one kind, near the texels of a band of rows.
fn find_next(
    surface: &Surface,
    rules: &ColumnRules,
    kind: ReceiverKind,
    rect: TexelRect,
    b: &mut CaptureBuffers,
) {
    let Some(receiver) = rules.receiver(surface) else { return };
    let triangle = &surface.shape;
    let half = rules.footprint_half_texels(kind);
    let (y0, y1) = (i64::from(rect.y), i64::from(rect.y + rect.height) - 1);
    let (x0, x1) = (i64::from(rect.x), i64::from(rect.x + rect.width) - 1);
    let y = triangle.corners.map(|c| c[1]);
    let low = y[0].min(y[1]).min(y[2]);
    let high = y[0].max(y[1]).max(y[2]);
    let first_row = ((low - half - 0.5).ceil() as i64).max(y0);
    let last_row = ((high + half - 0.5).floor() as i64).min(y1);
    for row in first_row..=last_row {
        let y = row as f64 + 0.5;
        let Some([low, high]) = triangle.x_range_in_band(y, half) else { continue };
        let first = ((low - half - 0.5).ceil() as i64).max(x0);
        let last = ((high + half - 0.5).floor() as i64).min(x1);
        let start = ((row - y0) * i64::from(rect.width) - x0) as isize;
        for i in first..=last {
            let texel = (start + i as isize) as usize;
            let (base, first) = (b.base[texel], b.first[texel]);
            let next = rules.receiver_behind(kind, (triangle, &receiver), [i, row], base, first);
            b.next[texel] = b.next[texel].min(next);
        }
    }
}

/// Bounds the columns of a band, which begins at texel `start` of `out`, where filters around the surface
/// read.
fn bound(surface: &Surface, rules: &ColumnRules, rect: TexelRect, start: usize, out: &mut Columns) {
    let Some(receiver) = rules.receiver(surface) else { return };
    let triangle = &surface.shape;
    let (y0, y1) = (i64::from(rect.y), i64::from(rect.y + rect.height) - 1);
    let (x0, x1) = (i64::from(rect.x), i64::from(rect.x + rect.width) - 1);
    for (ring, margin) in rules.contact_margins().into_iter().enumerate() {
        let (first_row, last_row) = triangle.rows(margin);
        for row in first_row.max(y0)..=last_row.min(y1) {
            let (first, last) = triangle.span(row, margin);
            let row_start = start as i64 + (row - y0) * i64::from(rect.width) - x0;
            for i in first.max(x0)..=last.min(x1) {
                let texel = (row_start + i) as usize;
                let plane_voxels = receiver.plane.at(i as f64 + 0.5, row as f64 + 0.5);
                let contact = rules.contact_at(&receiver, plane_voxels);
                out.x[texel] = ColumnRules::bounded([out.e[texel], out.x[texel]], ring, contact);
            }
        }
    }
}
