//! Detects whether a scene has its own ground.
//!
//! A bake may leave out shadows that fall on nothing: those below the last surface of a column. That saves
//! bytes if the scene's own ground receives the shadows. It loses shadows if the ground is drawn by the
//! engine, by a map or by the camera of an augmented-reality app. The scene is therefore cut by vertical
//! lines, about 256 across its longer side, and has a ground if three things hold:
//!
//! - The lowest surfaces on the lines form a floor: it fills the scene's outline, and continues from line to
//!   line without steps. Buildings alone leave the streets open, and the lowest leaves of a wood are at all
//!   heights.
//! - The floor reaches down to the scene's lowest point. The roof of a hall does not.
//! - Little of the shadow falls through holes or beyond the outline, under a sun 45° high in each of four
//!   directions. All of the shadow of a lone house does, even if the house has a floor.

use adumbra::Bounds;
use adumbra_scene::{Instance, Scene};
use rayon::prelude::*;

use crate::options::AssumeGround;

/// Lines across the longer side of the scene's outline.
const LINES: usize = 256;
/// The steepest floor, as rise over run from line to line.
const STEEPEST: f32 = 2.0;
/// The least share of the outline that is floor.
const LEAST_FLOOR: f64 = 0.9;
/// How much shadow may be lost in holes and beyond the outline: a share of the outline, for the rim of a
/// slab, and shares of the shadow on the scene.
const LEAST_LOST: f64 = 0.01;
const MOST_IN_HOLES: f64 = 0.1;
const MOST_BEYOND: f64 = 0.6;
/// A surface counts as shadowed only if it is more than this below the shadow's upper edge, in distances
/// between lines.
const LEAST_SHADOW: f64 = 0.5;
/// How far the floor may be above the scene's lowest point, as a share of the scene's height, or of its
/// longer side if that is more.
const MOST_ABOVE_LOWEST: f64 = 0.1;
const MOST_ABOVE_LOWEST_OF_SIDE: f64 = 1.0 / 80.0;
/// The floor's height is this quantile of the heights of its lines.
const LOW_SHARE: f64 = 0.01;

/// The measurements of a scene's ground. All shares are from 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ground {
    /// Share of the outline that is floor.
    pub floor: f64,
    /// How far the floor is above the scene's lowest point, as a share of the most that it may be.
    pub above_lowest: f64,
    /// Share of the outline in shadow, seen from above.
    pub shadow: f64,
    /// The shadow that falls through holes, as a share of the outline.
    pub in_holes: f64,
    /// The shadow beyond the outline, as a share of the outline.
    pub beyond: f64,
}

impl Ground {
    /// Measures the ground of a scene. Cost: two passes over the triangles, instances counted. Runs on the
    /// current rayon pool.
    pub fn of(scene: &Scene) -> Self {
        match Lines::of(scene) {
            Some(lines) => lines.ground(),
            None => Self::default(),
        }
    }

    /// Whether the scene has a ground.
    pub fn is_there(&self) -> bool {
        self.floor >= LEAST_FLOOR
            && self.above_lowest <= 1.0
            && self.in_holes <= LEAST_LOST + MOST_IN_HOLES * self.shadow
            && self.beyond <= LEAST_LOST + MOST_BEYOND * self.shadow
    }
}

impl AssumeGround {
    /// Returns `Yes` or `No`. `Auto` becomes `Yes` if `scene` has a ground. Cost, for `Auto`: two passes over
    /// the triangles, instances counted.
    #[must_use]
    pub fn decided(self, scene: &Scene) -> Self {
        match self {
            Self::Auto if Ground::of(scene).is_there() => Self::Yes,
            Self::Auto => Self::No,
            decided => decided,
        }
    }
}

/// Where vertical lines cross a scene.
struct Lines {
    /// Number of lines along x and z.
    size: [usize; 2],
    /// Distance between lines, world units.
    spacing: f64,
    /// Height of the scene, world units.
    height: f64,
    /// The heights of the lowest and the highest surface on each line, above the scene's lowest point;
    /// `lowest` is infinite where there is none.
    lowest: Vec<f32>,
    highest: Vec<f32>,
}

/// The triangles of an instance in the world. A ground that casts no shadow still counts as a ground.
fn triangles<'s>(scene: &'s Scene, instance: &'s Instance) -> impl Iterator<Item = [[f64; 3]; 3]> + 's {
    let mesh = &scene.meshes[instance.mesh as usize];
    mesh.triangles.iter().map(|corners| corners.map(|v| instance.to_world(mesh.positions[v as usize])))
}

impl Lines {
    fn of(scene: &Scene) -> Option<Self> {
        let Bounds { min: low, max: high } = scene.bounds();
        let sides = [0, 2].map(|a| high[a] - low[a]);
        let spacing = sides[0].max(sides[1]) / LINES as f64;
        if !(spacing > 0.0 && spacing.is_finite()) {
            return None;
        }
        let size = sides.map(|side| ((side / spacing).ceil() as usize).clamp(1, LINES));
        let count = size[0] * size[1];
        let uncrossed = || (vec![f32::INFINITY; count], vec![f32::NEG_INFINITY; count]);
        let crossed = scene.instances.par_iter().fold(uncrossed, |(mut lowest, mut highest), instance| {
            for corners in triangles(scene, instance) {
                let on_lines = corners.map(|p| {
                    [(p[0] - low[0]) / spacing - 0.5, p[1] - low[1], (p[2] - low[2]) / spacing - 0.5]
                });
                for_each_crossing(&on_lines, size, |[i, j], height| {
                    let line = j * size[0] + i;
                    lowest[line] = lowest[line].min(height as f32);
                    highest[line] = highest[line].max(height as f32);
                });
            }
            (lowest, highest)
        });
        let (lowest, highest) = crossed.reduce(uncrossed, |(mut low, mut high), (lower, higher)| {
            low.iter_mut().zip(lower).for_each(|(one, other)| *one = one.min(other));
            high.iter_mut().zip(higher).for_each(|(one, other)| *one = one.max(other));
            (low, high)
        });
        Some(Self { size, spacing, height: high[1] - low[1], lowest, highest })
    }

    fn ground(&self) -> Ground {
        let mut floor: Vec<f32> = Vec::new();
        let mut outline = 0;
        let spans = self.spans();
        for j in 0..self.size[1] {
            for i in 0..self.size[0] {
                let is_within = |axis: usize, along: usize, across: usize| {
                    let [first, last] = spans[axis][across];
                    (first..=last).contains(&along)
                };
                outline += usize::from(is_within(0, i, j) && is_within(1, j, i));
                if self.is_floor(i, j) {
                    floor.push(self.lowest[j * self.size[0] + i]);
                }
            }
        }
        floor.sort_unstable_by(f32::total_cmp);
        let low = floor.get((floor.len() as f64 * LOW_SHARE) as usize).copied().unwrap_or_default();
        let [columns, rows] = self.size;
        let along_x = (0..rows).map(|j| (0..columns).map(move |i| j * columns + i));
        let along_z = (0..columns).map(|i| (0..rows).map(move |j| j * columns + i));
        let mut all = [0.0; 3];
        let mut add = |of_row: [f64; 3]| (0..3).for_each(|a| all[a] += of_row[a]);
        for row in along_x {
            add(self.shadow_along(row.clone()));
            add(self.shadow_along(row.rev()));
        }
        for row in along_z {
            add(self.shadow_along(row.clone()));
            add(self.shadow_along(row.rev()));
        }
        let share = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
        let [shadow, in_holes, beyond] = all.map(|lines| share(lines, 4.0 * outline as f64));
        let side = self.spacing * LINES as f64;
        let most_above = (MOST_ABOVE_LOWEST * self.height).max(MOST_ABOVE_LOWEST_OF_SIDE * side);
        Ground {
            floor: share(floor.len() as f64, outline as f64),
            above_lowest: share(low.into(), most_above),
            shadow,
            in_holes,
            beyond,
        }
    }

    fn is_crossed(&self, i: usize, j: usize) -> bool {
        self.lowest[j * self.size[0] + i].is_finite()
    }

    /// Returns the first and the last line that is crossed in each row, and in each column. The outline is
    /// the set of lines within both spans.
    fn spans(&self) -> [Vec<[usize; 2]>; 2] {
        let none = [usize::MAX, 0];
        let grown = |[first, last]: [usize; 2], along: usize| [first.min(along), last.max(along)];
        let [mut rows, mut columns] = [vec![none; self.size[1]], vec![none; self.size[0]]];
        for (j, row) in rows.iter_mut().enumerate() {
            for i in (0..self.size[0]).filter(|&i| self.is_crossed(i, j)) {
                *row = grown(*row, i);
                columns[i] = grown(columns[i], j);
            }
        }
        [rows, columns]
    }

    /// Returns the line `steps` along a direction, if there is one.
    fn along(&self, [i, j]: [usize; 2], [di, dj]: [isize; 2], steps: usize) -> Option<[usize; 2]> {
        let at = |from: usize, by: isize| from.checked_add_signed(by * steps as isize);
        let next = [at(i, di)?, at(j, dj)?];
        (next[0] < self.size[0] && next[1] < self.size[1]).then_some(next)
    }

    /// Whether the lowest surface continues to all neighbours but at most one, where there may be a step or
    /// the end of the outline.
    fn is_floor(&self, i: usize, j: usize) -> bool {
        let own = self.lowest[j * self.size[0] + i];
        let goes_on = |direction: &&[isize; 2]| {
            let next = self.along([i, j], **direction, 1);
            // Infinite if the neighbouring line crosses nothing.
            let rise = next.map_or(0.0, |[i, j]| (self.lowest[j * self.size[0] + i] - own).abs());
            rise <= STEEPEST * self.spacing as f32
        };
        own.is_finite() && DIRECTIONS.iter().filter(goes_on).count() + 1 >= DIRECTIONS.len()
    }

    /// Follows light that comes from 45° above, along a row of lines. Returns the number of lines whose
    /// highest surface is in shadow, the number of shadowed lines that cross nothing, and how many lines the
    /// shadow reaches beyond the last line that crosses the scene.
    fn shadow_along(&self, row: impl Iterator<Item = usize>) -> [f64; 3] {
        let mut height = f64::NEG_INFINITY;
        let [mut inside, mut in_holes] = [0.0; 2];
        // Of the last line that is crossed: the height of its floor, and the shadow behind it.
        let (mut floor, mut hole, mut beyond) = (f64::INFINITY, 0.0, 0.0);
        for line in row {
            height -= self.spacing;
            let [lowest, highest] = [self.lowest[line], self.highest[line]].map(f64::from);
            if lowest.is_finite() {
                inside += f64::from(u8::from(height > highest + LEAST_SHADOW * self.spacing));
                height = height.max(highest);
                in_holes += hole;
                (floor, hole, beyond) = (lowest, 0.0, (height - lowest) / self.spacing);
            } else if height > floor {
                hole += 1.0;
            }
        }
        [inside, in_holes, beyond]
    }
}

/// Steps to the four neighbours of a line.
const DIRECTIONS: [[isize; 2]; 4] = [[1, 0], [-1, 0], [0, 1], [0, -1]];

/// Calls `visit(line, height)` for the lines that a triangle crosses. Its corners are (x, height, z), with x
/// and z in lines.
fn for_each_crossing(corners: &[[f64; 3]; 3], size: [usize; 2], mut visit: impl FnMut([usize; 2], f64)) {
    let z = corners.map(|c| c[2]);
    let (first, last) = (z[0].min(z[1]).min(z[2]).ceil(), z[0].max(z[1]).max(z[2]).floor());
    for row in first.max(0.0) as usize..size[1] {
        let at = row as f64;
        if at > last {
            return;
        }
        let mut ends = [[f64::INFINITY, 0.0], [f64::NEG_INFINITY, 0.0]];
        for edge in 0..3 {
            let (a, b) = (corners[edge], corners[(edge + 1) % 3]);
            if (a[2] <= at) == (b[2] <= at) {
                continue;
            }
            let t = (at - a[2]) / (b[2] - a[2]);
            let [x, height] = [0, 1].map(|axis| a[axis] + t * (b[axis] - a[axis]));
            if x < ends[0][0] {
                ends[0] = [x, height];
            }
            if x > ends[1][0] {
                ends[1] = [x, height];
            }
        }
        let [[left, low], [right, high]] = ends;
        if !(left <= right) {
            continue;
        }
        let slope = if right > left { (high - low) / (right - left) } else { 0.0 };
        for column in left.ceil().max(0.0) as usize..size[0] {
            let x = column as f64;
            if x > right {
                break;
            }
            visit([column, row], low + slope * (x - left));
        }
    }
}
