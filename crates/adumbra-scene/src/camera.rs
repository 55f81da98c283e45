//! A perspective or orthographic camera, shared by rays, pictures and GPU frames.
//!
//! Pixel (0, 0) is at the top left, its centre at (0.5, 0.5). Right-handed: x to the right, y up; the camera
//! looks along forward.

use adumbra::grid::Bounds;
use adumbra::grid::vec3::{cross, dot, normalize};

/// How points are projected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Perspective projection.
    Perspective {
        /// Vertical field of view, degrees, above 0 and below 180.
        fov_degrees: f64,
    },
    /// Parallel projection.
    Orthographic {
        /// Height of the visible area, world units.
        height_world: f64,
    },
}

impl Projection {
    /// Returns the height of the visible area at a distance along the view direction, in world units.
    pub fn height_at(self, view_depth: f64) -> f64 {
        match self {
            Self::Perspective { fov_degrees } => 2.0 * view_depth * (0.5 * fov_degrees.to_radians()).tan(),
            Self::Orthographic { height_world } => height_world,
        }
    }
}

/// A camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// World position.
    pub eye: [f64; 3],
    /// World point at the centre of the picture.
    pub target: [f64; 3],
    /// The projection.
    pub projection: Projection,
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
}

/// A camera's axes and extent, ready for rays.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// The camera's eye, world units.
    pub eye: [f64; 3],
    /// Unit vector into the picture.
    pub forward: [f64; 3],
    /// Unit vector to the right.
    pub right: [f64; 3],
    /// Unit vector up.
    pub up: [f64; 3],
    /// Half the extent of the view, to the right and up: at distance 1 for a perspective camera, in world
    /// units for an orthographic one.
    pub half: [f64; 2],
    /// Whether rays are parallel.
    pub orthographic: bool,
    size: [f64; 2],
}

impl Camera {
    /// A camera of 1280 × 720 pixels that sees a whole box from above at an angle. The default sun is to its
    /// side, so that shadows fall across the view.
    pub fn overview(bounds: &Bounds, fov_degrees: f64) -> Self {
        let mut center: [f64; 3] = std::array::from_fn(|a| 0.5 * (bounds.min[a] + bounds.max[a]));
        let extent: [f64; 3] = std::array::from_fn(|a| bounds.max[a] - bounds.min[a]);
        if extent[1] < extent[0].max(extent[2]) {
            // A ground with a few tall objects.
            center[1] = 0.8 * bounds.min[1] + 0.2 * bounds.max[1];
        }
        let distance = 0.5 * bounds.diagonal() / (fov_degrees.to_radians() * 0.5).tan() * 0.7;
        // From the south-west.
        let direction = [-0.6, 0.5, 0.62];
        let eye = std::array::from_fn(|a| center[a] + direction[a] * distance);
        Self {
            eye,
            target: center,
            projection: Projection::Perspective { fov_degrees },
            width: 1280,
            height: 720,
        }
    }

    /// The camera's axes and extent. If it looks straight up or down, the picture's top is towards -Z.
    pub fn view(&self) -> View {
        let forward = normalize(std::array::from_fn(|a| self.target[a] - self.eye[a]));
        let flat = forward[0].abs() + forward[2].abs() < 1e-6;
        let reference = if flat { [0.0, 0.0, -1.0] } else { [0.0, 1.0, 0.0] };
        let right = normalize(cross(forward, reference));
        let (half_height, orthographic) = match self.projection {
            Projection::Perspective { fov_degrees } => (libm::tan(fov_degrees.to_radians() * 0.5), false),
            Projection::Orthographic { height_world } => (0.5 * height_world, true),
        };
        let size = [f64::from(self.width), f64::from(self.height)];
        let half = [half_height * size[0] / size[1], half_height];
        View { eye: self.eye, forward, right, up: cross(right, forward), half, orthographic, size }
    }
}

impl View {
    /// Origin and unit direction of the ray through (x, y), in pixels from the top left corner.
    pub fn ray(&self, x: f64, y: f64) -> ([f64; 3], [f64; 3]) {
        let u = (2.0 * x / self.size[0] - 1.0) * self.half[0];
        let v = (1.0 - 2.0 * y / self.size[1]) * self.half[1];
        let aside = |p: [f64; 3]| std::array::from_fn(|a| p[a] + u * self.right[a] + v * self.up[a]);
        if self.orthographic {
            (aside(self.eye), self.forward)
        } else {
            (self.eye, normalize(aside(self.forward)))
        }
    }

    /// Distance of a point along the forward axis, world units.
    pub fn depth(&self, p_world: [f64; 3]) -> f64 {
        dot(self.forward, std::array::from_fn(|a| p_world[a] - self.eye[a]))
    }

    /// Projects a world point to pixels from the top left corner. Returns `None` if the point is at or behind
    /// a perspective camera's eye.
    pub fn pixel(&self, p_world: [f64; 3]) -> Option<[f64; 2]> {
        let d: [f64; 3] = std::array::from_fn(|a| p_world[a] - self.eye[a]);
        let z = if self.orthographic { 1.0 } else { dot(self.forward, d) };
        (z > 0.0).then(|| {
            let u = dot(self.right, d) / (z * self.half[0]);
            let v = dot(self.up, d) / (z * self.half[1]);
            [0.5 * (1.0 + u) * self.size[0], 0.5 * (1.0 - v) * self.size[1]]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixel_is_the_inverse_of_ray() {
        for projection in
            [Projection::Perspective { fov_degrees: 50.0 }, Projection::Orthographic { height_world: 7.0 }]
        {
            for target in [[4.0, 1.0, -3.0], [1.0, -9.0, 2.0]] {
                let view = Camera { eye: [1.0, 2.0, 2.0], target, projection, width: 64, height: 36 }.view();
                for (x, y) in [(0.5, 0.5), (32.0, 18.0), (60.25, 3.0)] {
                    let (origin, direction) = view.ray(x, y);
                    let p = std::array::from_fn(|a| origin[a] + 3.0 * direction[a]);
                    let [px, py] = view.pixel(p).unwrap();
                    assert!((px - x).abs() < 1e-9 && (py - y).abs() < 1e-9, "{projection:?} {px} {py}");
                }
            }
        }
    }

    #[test]
    fn pixel_rows_run_downwards() {
        let projection = Projection::Perspective { fov_degrees: 90.0 };
        let view =
            Camera { eye: [0.0; 3], target: [0.0, 0.0, -1.0], projection, width: 10, height: 10 }.view();
        let [x, y] = view.pixel([0.5, 0.5, -1.0]).unwrap();
        assert!((x - 7.5).abs() < 1e-12 && (y - 2.5).abs() < 1e-12);
        assert_eq!(view.pixel([0.0, 0.0, 1.0]), None);
    }
}
