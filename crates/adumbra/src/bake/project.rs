//! A triangle in grid space, ready to be sampled.
//!
//! Coverage uses coordinates snapped to 1/256 texel and integer edge functions, so that triangles that share an edge
//! never leave a gap nor overlap, and a watertight surface has winding zero outside itself at every texel centre.
//! Depth uses the unsnapped plane, clamped to the triangle's own range, so that slivers cannot shoot away.

use crate::settings::MAX_SLOPE;

/// Fractional steps of a texel (and of a voxel of depth).
pub(crate) const SUBTEXEL: i64 = 256;
/// Depths are kept above this many voxels before the grid's near end.
const DEPTH_MIN_VOXELS: f64 = -1_048_576.0;
/// Depths are kept below this many voxels: the longest grid along the light.
pub(crate) const DEPTH_MAX_VOXELS: f64 = 2_097_152.0;
/// Snapped coordinates are kept within this, far outside every grid.
const COORDINATE_LIMIT: f64 = (1_i64 << 40) as f64;

/// Slack of ranges over a square, as a share of the depths they are made of.
const RELATIVE_SLACK: f64 = 1e-9;

/// Depth in 1/256 voxels.
pub(crate) type FixedDepth = i32;

/// Depth in voxels to the nearest 1/256.
pub(crate) fn fixed_depth(z: f64) -> FixedDepth {
    let clamped = z.clamp(DEPTH_MIN_VOXELS, DEPTH_MAX_VOXELS);
    // Truncation of a positive number is the floor.
    ((clamped - DEPTH_MIN_VOXELS) * SUBTEXEL as f64 + 0.5) as i32
        - (-DEPTH_MIN_VOXELS as i32) * SUBTEXEL as i32
}

/// A triangle's supporting plane: z = z0 + gx (x - x0) + gy (y - y0), in grid units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plane {
    origin: [f64; 3],
    pub(crate) gradient: [f64; 2],
}

impl Plane {
    /// |dz/dx| + |dz/dy|.
    pub(crate) fn gradient_sum(&self) -> f64 {
        self.gradient[0].abs() + self.gradient[1].abs()
    }

    /// Plane value (a depth, or any attribute that is linear over the triangle) at (x, y).
    pub(crate) fn at(&self, x: f64, y: f64) -> f64 {
        self.origin[2] + self.gradient[1] * (y - self.origin[1]) + self.gradient[0] * (x - self.origin[0])
    }
}

/// A triangle in grid space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Projected {
    /// Corners in grid units, sorted so that no result depends on the order in which the file lists them.
    pub(crate) corners: [[f64; 3]; 3],
    /// Snapped corners, anticlockwise in the light's plane as (x, y) axes: in the order given, or with the last two swapped.
    pub(crate) snapped: [[i64; 2]; 3],
    /// The last two were swapped.
    pub(crate) swapped: bool,
    /// Some product of snapped coordinates may leave 64 bits.
    wide: bool,
    /// The plane over (x, y); none where the triangle is edge-on to the light.
    pub(crate) plane: Option<Plane>,
    /// Range of depth.
    pub(crate) z_min: f64,
    /// Range of depth.
    pub(crate) z_max: f64,
    /// Tangent of the angle between normal and light, at most [`MAX_SLOPE`].
    pub(crate) slope: f64,
    /// The face looks towards the sun, by the order of its vertices.
    pub(crate) faces_sun: bool,
}

impl Projected {
    /// Projects; `flipped` for instances of negative determinant, whose faces are listed the other way round.
    pub(crate) fn new(corners_grid: [[f64; 3]; 3], flipped: bool) -> Self {
        let mut snapped = corners_grid.map(|c| [snap(c[0]), snap(c[1])]);
        let wide = snapped.iter().flatten().any(|c| c.abs() > 1 << 29);
        // A right-handed grid whose z runs away from the sun: a face towards the sun is clockwise in (x, y).
        let area = area_snapped(&snapped);
        let faces_sun = (area < 0) != flipped;
        if area < 0 {
            snapped.swap(1, 2);
        }
        let mut corners = corners_grid;
        corners.sort_unstable_by(|a, b| {
            a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(a[2].total_cmp(&b[2]))
        });
        let plane = if area == 0 { None } else { plane_through(&corners, corners.map(|c| c[2])) };
        let slope = plane.map_or(MAX_SLOPE, |p| {
            let [gx, gy] = p.gradient;
            (gx * gx + gy * gy).sqrt().min(MAX_SLOPE)
        });
        let z = corners.map(|c| c[2]);
        Self {
            corners,
            snapped,
            swapped: area < 0,
            wide,
            plane,
            z_min: z[0].min(z[1]).min(z[2]),
            z_max: z[0].max(z[1]).max(z[2]),
            slope,
            faces_sun,
        }
    }

    /// [`Self::faces_sun`] of a triangle that is drawn at all; none of one that is edge-on.
    pub(crate) fn drawn_facing(corners_grid: [[f64; 3]; 3], flipped: bool) -> Option<bool> {
        let [a, b, c] = corners_grid;
        let area = (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]);
        if area.abs() < CLEAR_AREA {
            let shape = Self::new(corners_grid, flipped);
            return shape.plane.map(|_| shape.faces_sun);
        }
        let area = area_snapped(&corners_grid.map(|c| [snap(c[0]), snap(c[1])]));
        (area != 0).then_some((area < 0) != flipped)
    }

    /// Depth at a texel centre, clamped to the triangle's own range; only where [`Self::plane`] is some.
    pub(crate) fn depth_at(&self, plane: &Plane, x: f64, y: f64) -> FixedDepth {
        fixed_depth(plane.at(x, y).max(self.z_min).min(self.z_max))
    }

    /// Rows `[first, last]` whose centre lines the snapped triangle may cross.
    pub(crate) fn rows(&self) -> (i64, i64) {
        let y = self.snapped.map(|c| c[1]);
        let low = y[0].min(y[1]).min(y[2]);
        let high = y[0].max(y[1]).max(y[2]);
        ((low + SUBTEXEL / 2 - 1).div_euclid(SUBTEXEL), (high - SUBTEXEL / 2).div_euclid(SUBTEXEL))
    }

    /// Texels `[first, last]` of `row` whose centres the triangle covers; empty where first > last.
    ///
    /// A centre exactly on an edge belongs to the triangle on one fixed side of that edge, by the edge's direction.
    pub(crate) fn span(&self, row: i64) -> (i64, i64) {
        let y = row * SUBTEXEL + SUBTEXEL / 2;
        let (mut first, mut last) = (i64::MIN, i64::MAX);
        for e in 0..3 {
            let (a, b) = (self.snapped[e], self.snapped[(e + 1) % 3]);
            let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
            let on_edge_counts = dy > 0 || (dy == 0 && dx > 0);
            // Inside where dx·(y - a.y) - dy·(x - a.x) >= needed, x = 256 i + 128.
            let needed = i64::from(!on_edge_counts);
            let bound = if self.wide {
                let r = i128::from(dx) * i128::from(y - a[1])
                    + i128::from(dy) * i128::from(a[0] - SUBTEXEL / 2)
                    - i128::from(needed);
                let step = i128::from(SUBTEXEL) * i128::from(dy.abs());
                if dy == 0 { r.signum() as i64 } else { r.div_euclid(step) as i64 }
            } else {
                let r = dx * (y - a[1]) + dy * (a[0] - SUBTEXEL / 2) - needed;
                if dy == 0 { r.signum() } else { r.div_euclid(SUBTEXEL * dy.abs()) }
            };
            match dy.signum() {
                1 => last = last.min(bound),
                -1 => first = first.max(-bound),
                _ if bound < 0 => return (1, 0),
                _ => {}
            }
        }
        (first, last)
    }

    /// Whether the triangle covers the centre of texel (i, j): what [`Self::span`] says, without a division.
    pub(crate) fn covers(&self, i: i64, j: i64) -> bool {
        let (x, y) = (i * SUBTEXEL + SUBTEXEL / 2, j * SUBTEXEL + SUBTEXEL / 2);
        (0..3).all(|e| {
            let (a, b) = (self.snapped[e], self.snapped[(e + 1) % 3]);
            let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
            let side = if self.wide {
                (i128::from(dx) * i128::from(y - a[1]) - i128::from(dy) * i128::from(x - a[0])).signum()
                    as i64
            } else {
                dx * (y - a[1]) - dy * (x - a[0])
            };
            side > 0 || (side == 0 && (dy > 0 || (dy == 0 && dx > 0)))
        })
    }

    /// The texels of the 8 × 8 from (x, y) whose centres the triangle covers, bit row · 8 + column: what [`Self::span`] says.
    pub(crate) fn coverage(&self, x: u32, y: u32) -> u64 {
        if self.wide {
            let at = |bit: u32| self.covers(i64::from(x + bit % 8), i64::from(y + bit / 8));
            return (0..64).fold(0, |mask, bit| mask | u64::from(at(bit)) << bit);
        }
        let p = [x, y].map(|c| i64::from(c) * SUBTEXEL + SUBTEXEL / 2);
        let mut covered = u64::MAX;
        for e in 0..3 {
            let (a, b) = (self.snapped[e], self.snapped[(e + 1) % 3]);
            let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
            let on_edge_counts = dy > 0 || (dy == 0 && dx > 0);
            // Inside where this is not negative.
            let corner = dx * (p[1] - a[1]) - dy * (p[0] - a[0]) - i64::from(!on_edge_counts);
            let (step_x, step_y) = (-dy * SUBTEXEL, dx * SUBTEXEL);
            let (far_x, far_y) = (7 * step_x, 7 * step_y);
            if corner + far_x.min(0) + far_y.min(0) >= 0 {
                continue;
            }
            if corner + far_x.max(0) + far_y.max(0) < 0 {
                return 0;
            }
            let mut inside = 0;
            for row in 0..8 {
                let mut side = corner + row * step_y;
                for column in 0..8 {
                    inside |= u64::from(side >= 0) << (row * 8 + column);
                    side += step_x;
                }
            }
            covered &= inside;
        }
        covered
    }

    /// Depth range of the part within the square of half side `reach` around `center`, or more.
    pub(crate) fn range_near(&self, center: [f64; 2], reach: f64) -> [f64; 2] {
        let (mut low, mut high) = (self.z_min, self.z_max);
        if let Some(plane) = &self.plane {
            let rise = plane.gradient_sum() * reach;
            let z = plane.at(center[0], center[1]);
            let slack = RELATIVE_SLACK * (rise + z.abs());
            low = low.max((z - rise - slack).min(high));
            high = high.min((z + rise + slack).max(low));
        }
        [low, high]
    }

    /// How much its plane rises over `reach` texels along both axes, 1/256 voxel; without end where it is edge-on.
    pub(crate) fn rise(&self, reach: f64) -> f64 {
        self.plane.as_ref().map_or(f64::INFINITY, |plane| plane.gradient_sum() * reach * SUBTEXEL as f64)
    }

    /// Depth range of the part in a `band` over the footprint around (x, y), or more; and the plane at its centre with the sum
    /// of its gradient's magnitudes.
    pub(crate) fn footprint_range(
        &self,
        band: &Band,
        x: f64,
        y: f64,
        half: f64,
    ) -> ([f64; 2], Option<(f64, f64)>) {
        let mut range = band.z;
        let z_plane = self.plane.as_ref().map(|plane| (plane.at(x, y), plane.gradient_sum()));
        if let Some((z, gradient_sum)) = z_plane {
            let reach = half * gradient_sum;
            range[0] = range[0].max((z - reach).min(range[1]));
            range[1] = range[1].min((z + reach).max(range[0]));
        }
        (range, z_plane)
    }

    /// A plane over (x, y) for an attribute given at the corners as the caller lists them.
    pub(crate) fn attribute_plane(corners_grid: &[[f64; 3]; 3], values: [f64; 3]) -> Option<Plane> {
        plane_through(corners_grid, values)
    }

    /// Calls `visit(x_first, x_last, z_low, z_high)` for the part of the triangle in the band
    /// `[y_center - half, y_center + half]`, with x and z ranges of that part; nothing where it misses the band.
    pub(crate) fn band(&self, y_center: f64, half: f64) -> Option<Band> {
        let (low, high) = (y_center - half, y_center + half);
        let mut band = Band { x: [f64::INFINITY, f64::NEG_INFINITY], z: [f64::INFINITY, f64::NEG_INFINITY] };
        for e in 0..3 {
            let (a, b) = (self.corners[e], self.corners[(e + 1) % 3]);
            let (a, b) = if a[1] <= b[1] { (a, b) } else { (b, a) };
            if b[1] < low || a[1] > high {
                continue;
            }
            let at = |y: f64| {
                let t = (y - a[1]) / (b[1] - a[1]);
                [a[0] + t * (b[0] - a[0]), a[2] + t * (b[2] - a[2])]
            };
            let start = if a[1] < low { at(low) } else { [a[0], a[2]] };
            let end = if b[1] > high { at(high) } else { [b[0], b[2]] };
            for p in [start, end] {
                band.x = [band.x[0].min(p[0]), band.x[1].max(p[0])];
                band.z = [band.z[0].min(p[1]), band.z[1].max(p[1])];
            }
        }
        (band.x[0] <= band.x[1]).then_some(band)
    }
}

/// Ranges of the part of a triangle in a band of rows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Band {
    pub(crate) x: [f64; 2],
    pub(crate) z: [f64; 2],
}

/// Twice the area, in texels, above which a triangle's plane is finite whatever rounding does.
const CLEAR_AREA: f64 = 1e-3;

fn snap(c: f64) -> i64 {
    (c * SUBTEXEL as f64).clamp(-COORDINATE_LIMIT, COORDINATE_LIMIT).round() as i64
}

fn area_snapped(c: &[[i64; 2]; 3]) -> i128 {
    let d = |i: usize, a: usize| i128::from(c[i][a] - c[0][a]);
    d(1, 0) * d(2, 1) - d(1, 1) * d(2, 0)
}

fn plane_through(c: &[[f64; 3]; 3], z: [f64; 3]) -> Option<Plane> {
    let (x1, y1, z1) = (c[1][0] - c[0][0], c[1][1] - c[0][1], z[1] - z[0]);
    let (x2, y2, z2) = (c[2][0] - c[0][0], c[2][1] - c[0][1], z[2] - z[0]);
    let area = x1 * y2 - x2 * y1;
    let gradient = [(z1 * y2 - z2 * y1) / area, (x1 * z2 - x2 * z1) / area];
    gradient.iter().all(|g| g.is_finite()).then_some(Plane { origin: [c[0][0], c[0][1], z[0]], gradient })
}
