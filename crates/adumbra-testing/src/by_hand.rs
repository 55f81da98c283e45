//! Grids and settings of hand-made files.

use adumbra::{Bias, FileSettings, Frame, LightGrid, Receivers, Sun};

/// Returns a grid with the sun overhead and voxels of one unit: x is +X, y is +Z, z points down from
/// `origin`.
pub fn overhead_grid(origin: [f64; 3], size: [u32; 3]) -> LightGrid {
    let sun = Sun::from_direction([0.0, 1.0, 0.0]).expect("straight up is a direction");
    let [x, y, z] = origin;
    LightGrid::new(sun, Frame::Light, 1.0, [x, z, -y], size)
}

/// Returns plain settings of a file with this grid, as if a box had been baked.
pub fn settings_for(grid: &LightGrid) -> FileSettings {
    FileSettings {
        resolution: grid.size[0].max(grid.size[1]),
        thickness_world: 0.0,
        assume_ground: true,
        closed_regions: true,
        ignore_alpha: false,
        scene_is_z_up: false,
        receivers: Receivers::All,
        switch_within_voxels: 0,
        dark_after_voxels: 0,
        bounds: None,
        region: None,
        bias: Bias::default(),
        triangles: 12,
        instances: 1,
    }
}
