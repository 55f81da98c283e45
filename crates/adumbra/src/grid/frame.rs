//! The orientation of a grid in the world.

use super::Sun;
use super::vec3::{cross, dot, normalize};

/// The orientation of a grid in the world. In either frame a sun ray is one column of voxels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Frame {
    /// Perpendicular to the light. Voxels are cubes, with z away from the sun and x horizontal.
    #[default]
    Light,
    /// Upright: a shear turns the light to the vertical. x and y are horizontal, and z is depth below the top
    /// of the grid. A voxel is a horizontal square with edges along the light, and its height equals the
    /// square's side. Roofs and floors have constant depth, and walls along x or y are rows of texels.
    Oblique {
        /// Angle from the world's +X to the grid's x axis, in radians, positive towards +Z.
        yaw_radians: f64,
    },
}

impl Frame {
    /// Returns the rows of the linear map from world to grid for voxels of size 1.
    ///
    /// In the light's frame they are unit vectors at right angles: x, y across the light, z away from the
    /// sun. In the oblique frame they are not: z is straight down, and x and y also depend on the height,
    /// because the light shifts higher points sideways.
    pub fn axes(self, sun: &Sun) -> [[f64; 3]; 3] {
        match self {
            Self::Light => light_axes(sun),
            Self::Oblique { yaw_radians } => {
                let [sx, sy, sz] = sun.towards();
                let row = |[x, z]: [f64; 2]| [x, -(x * sx + z * sz) / sy, z];
                let [x, y] = horizontal(yaw_radians);
                [row(x), row(y), [0.0, -1.0, 0.0]]
            }
        }
    }

    /// Returns the edges of a voxel of size 1 in the world, the columns of the inverse of `axes`.
    pub fn edges(self, sun: &Sun, axes: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
        match self {
            Self::Light => *axes,
            Self::Oblique { yaw_radians } => {
                let [sx, sy, sz] = sun.towards();
                let [x, y] = horizontal(yaw_radians).map(|[x, z]| [x, 0.0, z]);
                [x, y, [-sx / sy, -1.0, -sz / sy]]
            }
        }
    }

    /// Returns the frame's name in messages and options.
    pub fn name(self) -> &'static str {
        match self {
            Self::Light => "light",
            Self::Oblique { .. } => "oblique",
        }
    }
}

/// Returns the horizontal directions of the oblique frame's x and y, as world x and z.
fn horizontal(yaw_radians: f64) -> [[f64; 2]; 2] {
    let (sin, cos) = (libm::sin(yaw_radians), libm::cos(yaw_radians));
    [[cos, sin], [-sin, cos]]
}

/// Returns the light's axes, right-handed: z away from the sun, x horizontal, or +X if the sun is overhead.
fn light_axes(sun: &Sun) -> [[f64; 3]; 3] {
    let l = sun.towards();
    let z = l.map(|c| -c);
    let flat = (l[0] * l[0] + l[2] * l[2]).sqrt();
    let x = if flat < 1e-9 { [1.0, 0.0, 0.0] } else { [l[2] / flat, 0.0, -l[0] / flat] };
    let x = normalize(sub_projection(x, z));
    let y = cross(z, x);
    [x, y, z]
}

fn sub_projection(v: [f64; 3], unit: [f64; 3]) -> [f64; 3] {
    let d = dot(v, unit);
    [v[0] - d * unit[0], v[1] - d * unit[1], v[2] - d * unit[2]]
}
