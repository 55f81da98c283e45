//! The light's camera as matrices: p = C · P · V · x. Source: equations (2-1) and (2-2) of *The Optimization
//! and realization of Compact Precomputed Voxelized Shadows Algorithm* (2021). The product equals the mapping
//! of the grid, in the steps used to render a shadow map. Position, rotation and extent follow from the grid.

use adumbra::grid::LightGrid;
use adumbra::grid::vec3::dot;

/// A 4 × 4 matrix in row-major order.
pub type Matrix = [[f64; 4]; 4];

/// The orthographic camera of a light-aligned grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightCamera {
    /// V: from world space to the axes of the light, with the origin at the centre of the grid's near face; z
    /// points away from the sun.
    pub light_from_world: Matrix,
    /// P: from the box of the grid to clip space, x and y in [-1, 1], depth in [0, 1]. Clip y points along
    /// the y of the grid.
    pub clip_from_light: Matrix,
    /// C (2-1): from clip x and y to texture coordinates in [0, 1]; depth is unchanged.
    pub texture_from_clip: Matrix,
}

impl LightCamera {
    /// Builds the camera whose image is the columns of the grid.
    pub fn from_grid(grid: &LightGrid) -> Self {
        let extent = grid.size.map(|n| f64::from(n) * grid.voxel_size);
        let middle = [0.5 * extent[0], 0.5 * extent[1], 0.0];
        let mut light_from_world = [[0.0; 4]; 4];
        for (a, row) in light_from_world.iter_mut().take(3).enumerate() {
            let axis = grid.axes[a];
            *row = [axis[0], axis[1], axis[2], -grid.corner[a] * grid.voxel_size - middle[a]];
        }
        light_from_world[3][3] = 1.0;
        Self {
            light_from_world,
            clip_from_light: diagonal([2.0 / extent[0], 2.0 / extent[1], 1.0 / extent[2]], 0.0),
            texture_from_clip: diagonal([0.5, 0.5, 1.0], 0.5),
        }
    }

    /// Returns C · P · V.
    pub fn texture_from_world(&self) -> Matrix {
        multiply(&self.texture_from_clip, &multiply(&self.clip_from_light, &self.light_from_world))
    }

    /// Projects a world point to texture coordinates and depth (2-2).
    pub fn project(&self, p_world: [f64; 3]) -> [f64; 3] {
        let m = self.texture_from_world();
        std::array::from_fn(|r| dot([m[r][0], m[r][1], m[r][2]], p_world) + m[r][3])
    }
}

/// A matrix that scales, and translates x and y.
fn diagonal(scale: [f64; 3], move_xy: f64) -> Matrix {
    let mut m = [[0.0; 4]; 4];
    for (a, s) in scale.into_iter().enumerate() {
        m[a][a] = s;
    }
    (m[0][3], m[1][3], m[3][3]) = (move_xy, move_xy, 1.0);
    m
}

fn multiply(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|r| std::array::from_fn(|c| (0..4).map(|k| a[r][k] * b[k][c]).sum()))
}

#[cfg(test)]
mod tests {
    use super::LightCamera;
    use adumbra::grid::{Bounds, LightExtent, LightGrid, Sun};

    #[test]
    fn light_camera_matches_mapping_of_grid() {
        for (azimuth, elevation) in [(0.0, 90.0), (200.0, 3.0), (310.0, 40.0)] {
            let sun = Sun::from_angles(azimuth, elevation).unwrap();
            let bounds = Bounds { min: [-3.0, 0.0, 5.0], max: [40.0, 7.0, 9.0] };
            let mut extent = LightExtent::empty(&sun);
            extent.add_box(&bounds);
            let grid = LightGrid::covering(sun, &extent, extent.longest_side() / 64.0);
            let camera = LightCamera::from_grid(&grid);
            assert_eq!(camera.texture_from_clip[0], [0.5, 0.0, 0.0, 0.5]);
            for p in [[12.0, 3.0, 6.5], bounds.min, bounds.max] {
                let (p_texture, p_grid) = (camera.project(p), grid.to_grid(p));
                for a in 0..3 {
                    let expected = p_grid[a] / f64::from(grid.size[a]);
                    assert!((p_texture[a] - expected).abs() < 1e-9, "{a}: {p_texture:?}, {p_grid:?}");
                    // The image covers the box exactly.
                    assert!((-1e-9..=1.0 + 1e-9).contains(&p_texture[a]));
                }
            }
        }
    }
}
