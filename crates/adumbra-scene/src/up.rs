//! Which axis points up in a file. Scenes are Y up, like glTF. OBJ and PLY files do not state an axis, and
//! those of surveyors, planners and CAD programs are Z up.

use adumbra::Bounds;
use serde::{Deserialize, Serialize};

use crate::Scene;
use crate::affine::{Affine, multiply};

/// The axis that points up in a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum UpAxis {
    /// Y, as in glTF.
    #[default]
    Y,
    /// Z, as in IFC, CityJSON and most surveys.
    Z,
}

/// A quarter turn about X, from Z up to Y up. All of its products are exact.
const FROM_Z_UP: Affine = [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 0.0]];

impl UpAxis {
    /// Converts coordinates from a file with this up axis to the scene: (x, z, −y) for Z.
    pub fn to_scene(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Y => [x, y, z],
            // Subtracting from 0 never gives -0.
            Self::Z => [x, z, 0.0 - y],
        }
    }

    /// Converts coordinates from the scene to a file with this up axis: (x, −z, y) for Z.
    pub fn to_file(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Y => [x, y, z],
            Self::Z => [x, 0.0 - z, y],
        }
    }
}

impl Scene {
    /// Rotates a scene from the axes of its file, so that Y points up.
    pub(crate) fn turn_up(&mut self, up: UpAxis) {
        self.up = up;
        if up == UpAxis::Z {
            for instance in &mut self.instances {
                instance.world_from_mesh = multiply(&FROM_Z_UP, &instance.world_from_mesh);
            }
        }
    }
}

/// Whether a scene that was read as Y up looks Z up: it is less than half as long along Z as along X and Y,
/// like a town standing on edge, or more than twice as tall as it is wide.
pub(crate) fn looks_z_up(bounds: &Bounds) -> bool {
    let [x, y, z] = [0, 1, 2].map(|a| bounds.max[a] - bounds.min[a]);
    z < 0.5 * x.min(y) || y > 2.0 * x.max(z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::affine::{IDENTITY, decompose};

    #[test]
    fn z_up_directions_and_matrices_rotate_alike() {
        let (_, [x, y, z, w], scale) = decompose(&FROM_Z_UP);
        let half = std::f64::consts::FRAC_1_SQRT_2;
        assert_eq!(([y, z], scale), ([0.0; 2], [1.0; 3]));
        assert!((x + half).abs() < 1e-15 && (w - half).abs() < 1e-15, "a quarter turn about X: {x} {w}");
        assert_eq!(multiply(&FROM_Z_UP, &IDENTITY), FROM_Z_UP);
        let p = [1.0, 2.0, 3.0];
        assert_eq!(UpAxis::Z.to_scene(p), FROM_Z_UP.map(|row| (0..3).map(|c| row[c] * p[c]).sum::<f64>()));
        assert_eq!(UpAxis::Z.to_scene([0.0, 0.0, 1.0]).map(f64::to_bits), [0.0, 1.0, 0.0].map(f64::to_bits));
        assert_eq!((UpAxis::Y.to_scene(p), UpAxis::Y.to_file(p)), (p, p));
        assert_eq!(UpAxis::Z.to_file(UpAxis::Z.to_scene(p)), p);
    }

    #[test]
    fn scenes_on_edge_or_too_tall_look_z_up() {
        let looks = |size: [f64; 3]| looks_z_up(&Bounds { min: [5.0; 3], max: size.map(|s| s + 5.0) });
        for size in [[80.0, 80.0, 20.0], [1000.0, 300.0, 60.0], [30.0, 400.0, 20.0]] {
            assert!(looks(size), "{size:?}");
        }
        for size in [[80.0, 20.0, 80.0], [10.0, 10.0, 10.0], [10.0, 18.0, 10.0], [500.0, 30.0, 30.0]] {
            assert!(!looks(size), "{size:?}");
        }
    }
}
