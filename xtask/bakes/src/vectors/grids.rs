//! The voxels of the valid files: a grid and a function voxel -> lit for each.

use std::error::Error;

use adumbra::{Bounds, FileSettings, Frame, LightGrid, Receivers, Sun};
use serde_json::json;

use crate::by_hand::{overhead_grid, settings_for};
use crate::voxels::{Scatter, noise, point_in};

/// Whether the voxel (x, y, z) is lit.
pub(super) type Voxels = dyn Fn(u32, u32, u32) -> bool + Sync;

/// A grid whose voxels are known.
pub(super) struct Grid {
    pub(super) name: &'static str,
    pub(super) what: &'static str,
    pub(super) grid: LightGrid,
    pub(super) settings: FileSettings,
    /// Level of the roots of its graph.
    pub(super) root_level: u32,
    pub(super) lit: Box<Voxels>,
}

impl Grid {
    fn new(
        name: &'static str,
        what: &'static str,
        grid: LightGrid,
        root_level: u32,
        lit: impl Fn(u32, u32, u32) -> bool + Sync + 'static,
    ) -> Self {
        Self { name, what, grid, settings: settings_for(&grid), root_level, lit: Box::new(lit) }
    }

    /// Returns points in and around the grid, with their visibility according to the function.
    pub(super) fn answers(&self) -> String {
        let grid = &self.grid;
        let size = grid.size;
        let mut scatter = Scatter::new();
        let mut rows = Vec::new();
        let mut add = |what: &str, at: [f64; 3], visibility: bool| {
            let world = grid.to_world(at);
            // List the keys alphabetically, whether or not serde_json preserves the order.
            let row = json!({"visibility": u8::from(visibility), "where": what, "world": world});
            rows.push(format!("    {row}"));
        };
        for _ in 0..24 {
            let v = size.map(|n| scatter.below(n));
            add("inside", point_in(v), (self.lit)(v[0], v[1], v[2]));
        }
        let [x, y] = [size[0], size[1]].map(|n| scatter.below(n));
        let (cx, cy) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
        let [ex, ey, ez] = size.map(f64::from);
        add("outside, x below 0", [-0.5, cy, ez - 0.5], true);
        add("outside, x at the end", [ex + 0.5, cy, ez - 0.5], true);
        add("outside, y below 0", [cx, -0.5, ez - 0.5], true);
        add("outside, y at the end", [cx, ey + 0.5, ez - 0.5], true);
        add("outside and beyond the far end", [-3.5, cy, ez + 5.5], true);
        add("sunward", [cx, cy, -0.5], true);
        add("far sunward", [cx, cy, -1000.5], true);
        let last = (self.lit)(x, y, size[2] - 1);
        add("beyond the far end", [cx, cy, ez + 0.5], last);
        add("far beyond the far end", [cx, cy, ez + 1000.5], last);
        format!("{{\n  \"what\": {},\n  \"points\": [\n{}\n  ]\n}}\n", json!(self.what), rows.join(",\n"))
    }
}

/// Returns all grids.
pub(super) fn all() -> Result<Vec<Grid>, Box<dyn Error>> {
    let overhead = example_grid([8, 8, 8]);
    let slanted = |size, voxel_size| -> Result<LightGrid, Box<dyn Error>> {
        let sun = Sun::from_direction([0.5, 0.8, 0.35])?;
        Ok(LightGrid::new(sun, Frame::Light, voxel_size, [-33.0, 81.0, -55.5], size))
    };
    let low = {
        let sun = Sun::from_angles(250.0, 3.0)?;
        LightGrid::new(sun, Frame::Light, 0.1, [1.25e6, -20.0, 5e6], [24, 16, 200])
    };
    let upright = |towards, yaw_radians, corner, size| -> Result<LightGrid, Box<dyn Error>> {
        let sun = Sun::from_direction(towards)?;
        Ok(LightGrid::new(sun, Frame::Oblique { yaw_radians }, 0.5, corner, size))
    };
    let mut all = vec![
        Grid::new("example_8", "the worked example of the specification", overhead, 3, |x, y, z| {
            z < 2 || z == 2 && (x < 4 || y == 7)
        }),
        Grid::new("all_lit", "no occluder: a top grid of one lit root", overhead, 3, |_, _, _| true),
        Grid::new(
            "all_shadowed",
            "every root shadowed, eight of them",
            example_grid([16, 16, 16]),
            3,
            |_, _, _| false,
        ),
        Grid::new(
            "half_space",
            "a slanted plane, lit on one side",
            slanted([64, 64, 64], 0.5)?,
            6,
            |x, y, z| x + 2 * y + 3 * z < 190,
        ),
        Grid::new(
            "upright",
            "the oblique frame along the world's axes",
            upright([0.5, 0.8, 0.35], 0.0, [-64.0, 1024.0, 8.0], [64, 40, 48])?,
            5,
            |x, y, z| z < 10 + x / 5 + (y / 8) % 3,
        ),
        Grid::new(
            "upright_turned_low",
            "the oblique frame, turned by 0.7 radians, sun at 6°",
            upright([-0.77, 0.105, -0.63], 0.7, [5120.0, -72.0, -16.0], [40, 40, 24])?,
            3,
            |x, y, z| z < (3 * x + 5 * y) % 23,
        ),
        Grid::new("sphere", "the shadow of a sphere", slanted([64, 64, 64], 0.25)?, 4, sphere),
        Grid::new("low_sun_tall", "longer along the light than across, sun at 3°", low, 5, |x, y, z| {
            z < 20 + 6 * x + (y * y) % 17
        }),
        Grid::new(
            "odd_sizes",
            "sizes that are not multiples of 8, in roots of 16",
            slanted([13, 21, 37], 1.5)?,
            4,
            |x, y, z| (x * 7 + y * 3) % 40 > z,
        ),
        Grid::new("one_voxel", "the smallest grid", example_grid([1, 1, 1]), 3, |x, y, z| x + y + z > 0),
        Grid::new(
            "deep_root",
            "a root cube far larger than the grid: level 20",
            example_grid([9, 9, 9]),
            20,
            |x, y, z| x < 5 || y >= 3 || z == 0,
        ),
        Grid::new(
            "shared_levels",
            "one node without leaf masks, used at levels 4 and 5",
            slanted([64, 32, 32], 1.0)?,
            5,
            |x, y, z| if x < 32 { !(8..16).contains(&x) || y >= 16 || z >= 16 } else { x < 48 },
        ),
        Grid::new(
            "terraces",
            "steps of 8 and 16 voxels: a node without leaf masks at levels 4 and 5 whose columns are monotone",
            slanted([64, 32, 64], 1.0)?,
            5,
            |x, _, z| z < if x < 32 { 16 * (x / 16) } else { 8 * (x / 8 % 2) },
        ),
        Grid::new(
            "slopes",
            "up to eight masks in a node of level 3: bit planes",
            slanted([40, 40, 40], 1.0)?,
            5,
            |x, y, z| z < x / 3 + (y * y + x * 7) % 19,
        ),
        Grid::new(
            "cliff",
            "depths that differ by more than 16 bits can hold",
            slanted([16, 1, 66_000], 1.0)?,
            5,
            |x, _, z| z < if x < 8 { 5 + 65_900 * (x / 4) } else { 34_000 + 300 * (x % 3) },
        ),
        Grid::new(
            "noise",
            "nothing repeats: the graph at its largest",
            slanted([24, 24, 24], 2.0)?,
            5,
            noise,
        ),
    ];
    let settings = &mut all[6].settings;
    settings.bounds = Some(Bounds { min: [-8.0, 0.0, -8.0], max: [8.0, 12.5, 8.0] });
    settings.receivers = Receivers::Static;
    settings.thickness_world = 0.3;
    let settings = &mut all[7].settings;
    (settings.assume_ground, settings.closed_regions, settings.ignore_alpha) = (false, false, true);
    Ok(all)
}

/// Returns the grids that only shadow files have. Most are too large for a graph. Each comes with its coarser
/// levels, finest first.
pub(super) fn large() -> Result<Vec<Vec<Grid>>, Box<dyn Error>> {
    let sun = Sun::from_direction([0.5, 0.8, 0.35])?;
    let upright = |step: u32, size| {
        let frame = Frame::Oblique { yaw_radians: 0.0 };
        let corner = [-512.0, 1024.0, 16.0].map(|c| c / f64::from(step));
        LightGrid::new(sun, frame, 0.25 * f64::from(step), corner, size)
    };
    // Towers on a lattice, the same in every page except in the first column of pages. From y = 1900 on, the
    // surface between the towers differs from page to page.
    let towers = |x: u32, y: u32, z: u32| {
        let [i, j] = [x % 64, y % 64];
        let is_tower = (10..40).contains(&i) && (20..30).contains(&j) && x / 64 != 3;
        z < if is_tower {
            7 + j % 3
        } else if y >= 1900 {
            20 + x % 11
        } else {
            40
        }
    };
    let many = Grid::new(
        "many_pages",
        "pages of several bundles that share shapes, some of them uniform",
        upright(1, [2200, 2100, 64]),
        9,
        towers,
    );
    let hill = |step: u32| {
        move |x: u32, y: u32, z: u32| {
            let [x, y, z] = [x, y, z].map(|c| c * step);
            let bump = (x % 256) * (255 - x % 256) / 1024 + (y % 256) * (255 - y % 256) / 1024;
            z < 60 - bump.min(50)
        }
    };
    let levels = [1, 4, 16].map(|step: u32| {
        let size = [576, 530, 64].map(|n: u32| n.div_ceil(step));
        Grid::new("levels", "three levels of detail", upright(step, size), 9, hill(step))
    });
    // Leaf n has n + 1 depths, in an order that does not repeat.
    let many_depths =
        Grid::new("many_depths", "leaves of 1 to 64 depths", upright(1, [64, 64, 72]), 9, |x, y, z| {
            z < 1 + 67 * (x % 8 + 8 * (y % 8)) % (1 + x / 8 + 8 * (y / 8))
        });
    Ok(vec![vec![many], levels.into(), vec![many_depths]])
}

/// Returns a grid whose pages are equal: each has a hill in a corner.
pub(super) fn repeated() -> Grid {
    let size = [4 * REPEATED_PAGE, 4 * REPEATED_PAGE, 32];
    let what = "equal pages that share nothing, which are coded in few bytes";
    Grid::new("repeated", what, example_grid(size), 9, |x, y, z| {
        let [x, y] = [x, y].map(|c| (c % REPEATED_PAGE).min(63));
        z < 20 - x * (63 - x) / 128 - y / 8
    })
}

/// Number of columns along each side of a page.
pub(super) const REPEATED_PAGE: u32 = 512;

/// Returns a grid with the sun overhead and voxels of one unit: x is +X, y is +Z, z points down from y = 8.
fn example_grid(size: [u32; 3]) -> LightGrid {
    overhead_grid([0.0, 8.0, 0.0], size)
}

/// Lit unless inside or behind the sphere.
fn sphere(x: u32, y: u32, z: u32) -> bool {
    let [dx, dy, dz] = [x, y, z].map(|c| f64::from(c) - 31.5);
    let square = dx * dx + dy * dy;
    square > 400.0 || dz < -(400.0 - square).sqrt()
}
