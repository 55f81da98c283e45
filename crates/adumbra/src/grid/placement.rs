//! The placement of a file's world in an app's world: translation, rotation and uniform scale.
//!
//! A grid maps a world to voxels, so a placed file has the same voxels with another grid. Nothing else of a
//! look-up changes: bias, filters and penumbrae are in texels.

use super::vec3::{cross, dot, normalize};
use super::{LightGrid, Sun};
use crate::error::{RangeError, RangeField};

/// Largest relative difference between the scales of two axes, and largest cosine between two axes. Products
/// of matrices of 32-bit numbers have such errors. Points are exact nevertheless; bias and slopes have an
/// error of this size.
const TOLERANCE: f64 = 1e-5;

/// The placement of a file's world in an app's world: translation, rotation and uniform scale. By default the
/// file's world is where it was baked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// The images of the file's X, Y and Z axes, and the position of its origin.
    columns: [[f64; 3]; 4],
    scale: f64,
}

impl Default for Placement {
    fn default() -> Self {
        Self::BAKED
    }
}

impl Placement {
    /// The app's world is the file's.
    pub const BAKED: Self =
        Self { columns: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]], scale: 1.0 };

    /// Creates a placement from a matrix from the file's world to the app's, column by column: the images of
    /// the X, Y and Z axes, and the position of the origin. The fourth number of a column is not used.
    ///
    /// # Errors
    /// Returns [`RangeError`] if the matrix is not finite, has no size, mirrors, stretches one axis more than
    /// another, or shears.
    pub fn from_matrix(world_from_file: [[f64; 4]; 4]) -> Result<Self, RangeError> {
        let columns = world_from_file.map(|[x, y, z, _]| [x, y, z]);
        let [x, y, z, _] = columns;
        let refused = |value: String, range| Err(RangeError::new(RangeField::Placement, value, range));
        if !columns.as_flattened().iter().all(|c| c.is_finite()) {
            return refused(format!("{columns:?}"), "finite");
        }
        let lengths = [x, y, z].map(|axis| dot(axis, axis).sqrt());
        let scales = format!("scales of {} x {} x {}", lengths[0], lengths[1], lengths[2]);
        let [least, most] = [f64::min, f64::max].map(|end| lengths.into_iter().fold(lengths[0], end));
        if least == 0.0 || most == f64::INFINITY {
            return refused(scales, "of a scale above 0 that is finite");
        }
        if most > least * (1.0 + TOLERANCE) {
            return refused(
                scales,
                "of the same scale along all axes; apply other scales to the scene before it is baked",
            );
        }
        let [x, y, z] = [x, y, z].map(normalize);
        let cosine =
            [dot(x, y), dot(y, z), dot(z, x)].into_iter().fold(0.0, |most: f64, c| most.max(c.abs()));
        if cosine > TOLERANCE {
            let angle = format!("an angle of {} degrees between axes", libm::acos(cosine).to_degrees());
            return refused(angle, "without shear, with axes at right angles");
        }
        if dot(cross(x, y), z) < 0.0 {
            return refused("a reflection".into(), "without reflection; mirror the scene before it is baked");
        }
        Ok(Self { columns, scale: (lengths[0] + lengths[1] + lengths[2]) / 3.0 })
    }

    /// Returns the length in the app's world of a length of 1 in the file's.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Converts a point of the file's world to the app's.
    pub fn to_world(self, p_file: [f64; 3]) -> [f64; 3] {
        let [x, y, z, origin] = self.columns;
        std::array::from_fn(|a| x[a] * p_file[0] + y[a] * p_file[1] + z[a] * p_file[2] + origin[a])
    }

    /// Converts a point of the app's world to the file's.
    pub fn to_file(self, p_world: [f64; 3]) -> [f64; 3] {
        let origin = self.columns[3];
        let apart = [0, 1, 2].map(|a| p_world[a] - origin[a]);
        self.turned_back().map(|row| dot(row, apart) / self.scale)
    }

    /// Converts a plane of the app's world, `n · p + d = 0`, to the file's. The length of its normal is
    /// multiplied by [`Placement::scale`].
    pub(crate) fn plane_to_file(&self, [nx, ny, nz, d]: [f64; 4]) -> [f64; 4] {
        let [x, y, z, o] = self.columns.map(|column| dot([nx, ny, nz], column));
        [x, y, z, d + o]
    }

    /// Converts a direction of the app's world to the file's, such as a sun's. Its length changes by 1e-5 at
    /// most.
    pub fn direction_to_file(&self, d_world: [f64; 3]) -> [f64; 3] {
        self.turned_back().map(|row| dot(row, d_world))
    }

    /// Converts a direction of the file's world to the app's. Its length changes by 1e-5 at most.
    pub fn direction_to_world(&self, d_file: [f64; 3]) -> [f64; 3] {
        let [x, y, z, _] = self.columns;
        std::array::from_fn(|a| (x[a] * d_file[0] + y[a] * d_file[1] + z[a] * d_file[2]) / self.scale)
    }

    /// Returns the rows of the inverse's linear part, times the scale.
    fn turned_back(&self) -> [[f64; 3]; 3] {
        let [x, y, z, _] = self.columns.map(|column| column.map(|c| c / self.scale));
        let volume = dot(cross(x, y), z);
        [cross(y, z), cross(z, x), cross(x, y)].map(|row| row.map(|c| c / volume))
    }
}

impl LightGrid {
    /// Returns the grid in the world of an app that has placed the file. The sun may then be below the app's
    /// horizon. [`LightGrid::frame`] still refers to the file's world, so call
    /// [`LightGrid::circle_across_light`] on the file's own grid. Placing a placed grid combines the two
    /// placements.
    #[must_use]
    pub fn placed(&self, placement: &Placement) -> Self {
        if *placement == Placement::BAKED {
            return *self;
        }
        let back = placement.turned_back();
        let axes = self.axes.map(|axis| {
            std::array::from_fn(|a| axis[0] * back[0][a] + axis[1] * back[1][a] + axis[2] * back[2][a])
        });
        let voxel_size = self.voxel_size * placement.scale;
        let origin = placement.columns[3];
        Self {
            sun: Sun::from_stored(normalize(placement.direction_to_world(self.sun.towards()))),
            frame: self.frame,
            voxel_size,
            corner: std::array::from_fn(|a| self.corner[a] + dot(axes[a], origin) / voxel_size),
            axes,
            edges: self.edges.map(|edge| placement.direction_to_world(edge)),
            size: self.size,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Frame;

    /// A rotation about the diagonal by 120 degrees, which maps X, Y and Z to Y, Z and X.
    fn matrix(scale: f64, place: [f64; 3]) -> [[f64; 4]; 4] {
        let [x, y, z] = place;
        [[0.0, scale, 0.0, 0.0], [0.0, 0.0, scale, 0.0], [scale, 0.0, 0.0, 0.0], [x, y, z, 1.0]]
    }

    #[test]
    fn placed_grid_has_the_same_voxels() {
        let sun = Sun::from_angles(200.0, 35.0).unwrap();
        for frame in [Frame::Light, Frame::Oblique { yaw_radians: 0.7 }] {
            let grid = LightGrid::new(sun, frame, 0.25, [-40.0, 3.0, 17.0], [64, 80, 96]);
            for (scale, place) in [(1.0, [5.0, -2.0, 9.0]), (0.01, [0.0; 3]), (100.0, [1e5, 3.0, -1e5])] {
                let placement = Placement::from_matrix(matrix(scale, place)).unwrap();
                assert!((placement.scale() / scale - 1.0).abs() < 1e-12);
                let placed = grid.placed(&placement);
                let p_file = [12.0, -3.0, 6.5];
                let p_world = placement.to_world(p_file);
                assert_eq!(
                    p_world,
                    [6.5 * scale + place[0], 12.0 * scale + place[1], -3.0 * scale + place[2]]
                );
                let [expected, found] = [grid.to_grid(p_file), placed.to_grid(p_world)];
                assert!(
                    (0..3).all(|a| (expected[a] - found[a]).abs() < 1e-6),
                    "{frame:?} {scale}: {found:?}"
                );
                let from = placement.to_file(p_world);
                assert!((0..3).all(|a| (from[a] - p_file[a]).abs() < 1e-7), "{from:?}");
                let back = placed.to_world(found);
                assert!((0..3).all(|a| (back[a] - p_world[a]).abs() < 1e-9 * scale.max(1.0)), "{back:?}");
                assert!((placed.voxel_along_light() - scale * grid.voxel_along_light()).abs() < 1e-9 * scale);
                let direction = placement.direction_to_file(placement.direction_to_world([0.6, 0.0, 0.8]));
                assert!((0..3).all(|a| (direction[a] - [0.6, 0.0, 0.8][a]).abs() < 1e-12), "{direction:?}");
                let normal = grid.normal_to_grid([0.6, 0.0, 0.8]);
                let turned = placed.normal_to_grid(placement.direction_to_world([0.6, 0.0, 0.8]));
                assert!((0..3).all(|a| (normal[a] - turned[a]).abs() < 1e-12), "{frame:?} {turned:?}");
            }
            assert_eq!(grid.placed(&Placement::default()), grid);
        }
    }

    #[test]
    fn rejects_uneven_scale_shear_and_mirroring_with_reason() {
        let with = |change: fn(&mut [[f64; 4]; 4])| {
            let mut matrix = matrix(2.0, [1.0, 2.0, 3.0]);
            change(&mut matrix);
            Placement::from_matrix(matrix)
        };
        assert!(with(|m| m[0][1] *= 1.0 + 5e-6).is_ok());
        for (change, said) in [
            ((|m| m[0][1] *= 1.0001) as fn(&mut [[f64; 4]; 4]), "the same scale along all axes"),
            (|m| m[1] = [0.0; 4], "a scale above 0"),
            (|m| m[0] = [1e200, 0.0, 0.0, 0.0], "finite"),
            (|m| m[3][0] = f64::NAN, "finite"),
            (|m| m[0][1] = f64::NAN, "finite"),
            (|m| m[2][2] = f64::NEG_INFINITY, "finite"),
            (|m| m[0] = [0.0, 2.0, 0.001, 0.0], "without shear"),
            (|m| m[2][0] = -2.0, "mirror the scene"),
        ] {
            let error = with(change).unwrap_err();
            assert_eq!(error.field, RangeField::Placement);
            assert!(error.to_string().contains(said), "{error}");
        }
    }
}
