//! Flicker: the change of ambient visibility from frame to frame at fixed points of the world while the
//! camera moves.
//!
//! Definition: each pixel with a surface represents the point hit by the ray through its centre. The point is
//! projected into the previous frame. It counts if each of the four pixels whose centres surround the
//! projection shows the same surface. For that, the cosine between the normals must be at least
//! [`MIN_COSINE`], and the pixel's view depth must be within [`DEPTH_SHARE`] of the depth at which its ray
//! intersects the plane through the point. Surfaces seen at a grazing angle thus count as well as those seen
//! head-on.
//!
//! The change is the absolute difference between the point's visibility and that of the previous frame,
//! interpolated bilinearly between the four pixels. Nothing in the world moves, so the correct value is 0.
//! The truth's own pictures give the floor set by resampling.

use adumbra_scene::{Camera, View};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use adumbra_compare::error::{Error, Result};
use adumbra_compare::vector::dot;

/// Changes of visibility up to this size are taken as invisible.
pub const CHANGE: f64 = 0.05;
/// Largest difference of a surface's view depth from the expected one, as a share of the latter.
const DEPTH_SHARE: f64 = 0.005;
/// Smallest cosine between normals of one surface.
const MIN_COSINE: f64 = 0.9;
/// Smallest cosine between a ray and a plane's normal at which the two are intersected.
const MIN_MEETING: f64 = 1e-4;

/// A frame of the path, one value per pixel.
#[derive(Clone, Copy, Debug)]
pub struct FlickerFrame<'a> {
    /// Camera of the frame.
    pub camera: Camera,
    /// Distance along the camera's forward direction in world units; infinite without a surface.
    pub view_depth: &'a [f64],
    /// Unit normals in world space; undefined without a surface.
    pub normal: &'a [[f32; 3]],
    /// Ambient visibility, 1 = unoccluded.
    pub visibility: &'a [f32],
}

/// The flicker over a path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Flicker {
    /// Number of pixels counted, once per pair of frames.
    pub pixels: u64,
    /// Mean absolute change of their visibility.
    pub mean: f64,
    /// Share of them that changed by more than [`CHANGE`].
    pub share: f64,
}

/// Accumulates changes pair by pair.
#[derive(Clone, Copy, Debug, Default)]
pub struct FlickerCount {
    pixels: u64,
    sum: f64,
    changed: u64,
}

impl FlickerCount {
    /// Adds the changes from the frame `before` to the frame `after`.
    ///
    /// Cost: about 0.1 µs per pixel. Rows run in parallel on the current rayon pool and are summed in order.
    ///
    /// # Errors
    /// Returns [`Error::Sizes`] if the number of a frame's values differs from its camera's pixels.
    pub fn add(&mut self, before: &FlickerFrame<'_>, after: &FlickerFrame<'_>) -> Result<()> {
        before.check()?;
        after.check()?;
        let (view, old_view) = (after.camera.view(), before.camera.view());
        let rows: Vec<Self> = (0..after.camera.height)
            .into_par_iter()
            .map(|y| {
                let mut row = Self::default();
                for x in 0..after.camera.width {
                    let i = y as usize * after.camera.width as usize + x as usize;
                    let Some(p) = after.point(&view, x, y) else { continue };
                    let normal = after.normal[i].map(f64::from);
                    let Some(old) = before.resampled(&old_view, p, normal) else { continue };
                    let change = (f64::from(after.visibility[i]) - old).abs();
                    row.pixels += 1;
                    row.sum += change;
                    row.changed += u64::from(change > CHANGE);
                }
                row
            })
            .collect();
        for row in rows {
            self.pixels += row.pixels;
            self.sum += row.sum;
            self.changed += row.changed;
        }
        Ok(())
    }

    /// Returns the flicker so far, or `None` if no pixel was counted.
    pub fn finish(&self) -> Option<Flicker> {
        let whole = self.pixels as f64;
        (self.pixels > 0).then(|| Flicker {
            pixels: self.pixels,
            mean: self.sum / whole,
            share: self.changed as f64 / whole,
        })
    }
}

impl FlickerFrame<'_> {
    fn check(&self) -> Result<()> {
        let pixels = self.camera.width as usize * self.camera.height as usize;
        Error::check_sizes("view depths and pixels", self.view_depth.len(), pixels)?;
        Error::check_sizes("normals and pixels", self.normal.len(), pixels)?;
        Error::check_sizes("visibility and pixels", self.visibility.len(), pixels)
    }

    /// Returns the world point that a pixel shows, or `None` without a surface.
    fn point(&self, view: &View, x: u32, y: u32) -> Option<[f64; 3]> {
        let depth = self.view_depth[y as usize * self.camera.width as usize + x as usize];
        let (origin, direction) = view.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let t = depth / dot(view.forward, direction);
        depth.is_finite().then(|| std::array::from_fn(|a| origin[a] + t * direction[a]))
    }

    /// Returns the visibility at the world point `p` with this `normal`, if all pixels around it show its
    /// surface.
    fn resampled(&self, view: &View, p: [f64; 3], normal: [f64; 3]) -> Option<f64> {
        if view.depth(p) <= 0.0 {
            return None;
        }
        let [px, py] = view.pixel(p)?.map(|c| c - 0.5);
        let inside = |c: f64, size: u32| c >= 0.0 && c <= f64::from(size) - 1.0;
        if !inside(px, self.camera.width) || !inside(py, self.camera.height) {
            return None;
        }
        let (x, y) = (px as u32, py as u32);
        let (fx, fy) = (px - f64::from(x), py - f64::from(y));
        let mut sum = 0.0;
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            // At the last centre of a row or column, the next one has no weight.
            let (sx, sy) = ((x + dx).min(self.camera.width - 1), (y + dy).min(self.camera.height - 1));
            if !self.shows(view, sx, sy, p, normal) {
                return None;
            }
            let along = |step: u32, f: f64| if step == 0 { 1.0 - f } else { f };
            let i = sy as usize * self.camera.width as usize + sx as usize;
            sum += along(dx, fx) * along(dy, fy) * f64::from(self.visibility[i]);
        }
        Some(sum)
    }

    /// Returns whether a pixel shows the surface through `p` with this `normal`.
    fn shows(&self, view: &View, x: u32, y: u32, p: [f64; 3], normal: [f64; 3]) -> bool {
        let i = y as usize * self.camera.width as usize + x as usize;
        let seen = self.view_depth[i];
        if !seen.is_finite() || dot(self.normal[i].map(f64::from), normal) < MIN_COSINE {
            return false;
        }
        let (origin, direction) = view.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let towards = dot(direction, normal);
        if towards.abs() < MIN_MEETING {
            return false;
        }
        let t = dot(std::array::from_fn(|a| p[a] - origin[a]), normal) / towards;
        let expected = view.depth(std::array::from_fn(|a| origin[a] + t * direction[a]));
        (seen - expected).abs() <= DEPTH_SHARE * expected.abs()
    }
}

#[cfg(test)]
mod tests {
    use adumbra_scene::Projection;

    use super::*;

    const SIZE: [u32; 2] = [64, 36];

    struct GBuffer {
        camera: Camera,
        view_depth: Vec<f64>,
        normal: Vec<[f32; 3]>,
    }

    /// Returns the ground at y = 0 seen from `eye_x`, two metres up. Pixels near and above the horizon have
    /// no surface.
    fn ground(eye_x: f64) -> GBuffer {
        let projection = Projection::Perspective { fov_degrees: 60.0 };
        let [width, height] = SIZE;
        let camera = Camera { eye: [eye_x, 2.0, 0.0], target: [eye_x, 1.0, -6.0], projection, width, height };
        let view = camera.view();
        let depth = |i: u32| {
            let (origin, d) = view.ray(f64::from(i % width) + 0.5, f64::from(i / width) + 0.5);
            let t = -origin[1] / d[1];
            if d[1] < -1e-3 { t * dot(view.forward, d) } else { f64::INFINITY }
        };
        let view_depth = (0..width * height).map(depth).collect();
        GBuffer { camera, view_depth, normal: vec![[0.0, 1.0, 0.0]; (width * height) as usize] }
    }

    impl GBuffer {
        fn frame<'a>(&'a self, visibility: &'a [f32]) -> FlickerFrame<'a> {
            FlickerFrame {
                camera: self.camera,
                view_depth: &self.view_depth,
                normal: &self.normal,
                visibility,
            }
        }

        fn valid(&self) -> u64 {
            self.view_depth.iter().filter(|d| d.is_finite()).count() as u64
        }
    }

    /// Returns uniform noise, reproducible by seed.
    fn noise(seed: u32) -> Vec<f32> {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
            ((word >> 22) ^ word) as f32 / u32::MAX as f32
        };
        (0..SIZE[0] * SIZE[1]).map(|_| next()).collect()
    }

    fn flicker(before: &FlickerFrame<'_>, after: &FlickerFrame<'_>) -> Option<Flicker> {
        let mut count = FlickerCount::default();
        count.add(before, after).unwrap();
        count.finish()
    }

    #[test]
    fn flicker_of_still_picture_is_zero() {
        let seen = ground(0.0);
        let picture = noise(1);
        let f = flicker(&seen.frame(&picture), &seen.frame(&picture)).unwrap();
        assert!(f.mean < 1e-6 && f.share == 0.0, "{f:?}");
        // Rounding may move a point off its pixel's centre, across the edge of the picture or of the ground.
        assert!(f.pixels > seen.valid() * 9 / 10, "{f:?} of {}", seen.valid());
    }

    #[test]
    fn flicker_of_constant_visibility_is_zero_under_motion() {
        let (before, after) = (ground(0.0), ground(0.13));
        let picture = vec![0.37; before.normal.len()];
        let f = flicker(&before.frame(&picture), &after.frame(&picture)).unwrap();
        assert!(f.mean < 1e-6 && f.share == 0.0, "{f:?}");
        assert!(f.pixels > after.valid() * 8 / 10, "grazing views count: {f:?} of {}", after.valid());
    }

    #[test]
    fn flicker_of_world_fixed_pattern_is_small() {
        let (before, after) = (ground(0.0), ground(0.13));
        // Waves of eight metres in length along x.
        let painted = |seen: &GBuffer| -> Vec<f32> {
            let view = seen.camera.view();
            let frame = seen.frame(&[]);
            let pixels = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y)));
            let value = |p: [f64; 3]| (0.5 + 0.5 * libm::sin(0.25 * std::f64::consts::PI * p[0])) as f32;
            pixels.map(|(x, y)| frame.point(&view, x, y).map_or(1.0, value)).collect()
        };
        let (a, b) = (painted(&before), painted(&after));
        let fixed = flicker(&before.frame(&a), &after.frame(&b)).unwrap();
        let dragged = flicker(&before.frame(&a), &after.frame(&a)).unwrap();
        assert!(fixed.mean < 0.25 * dragged.mean, "{fixed:?} {dragged:?}");
    }

    #[test]
    fn flicker_of_noise_equals_its_mean_difference() {
        let seen = ground(0.0);
        let (a, b) = (noise(1), noise(2));
        let f = flicker(&seen.frame(&a), &seen.frame(&b)).unwrap();
        // For two uniform values the mean difference is a third, and the probability of less than c is 1 -
        // (1 - c)².
        assert!((f.mean - 1.0 / 3.0).abs() < 0.025, "{f:?}");
        assert!((f.share - 0.95 * 0.95).abs() < 0.025, "{f:?}");
    }

    #[test]
    fn flicker_ignores_points_of_other_surfaces() {
        let (near, far) = (ground(0.0), ground(0.0));
        let wall = GBuffer {
            view_depth: vec![1.5; near.view_depth.len()],
            normal: vec![[0.0, 0.0, 1.0]; near.normal.len()],
            ..near
        };
        let picture = noise(3);
        assert_eq!(flicker(&wall.frame(&picture), &far.frame(&picture)), None);
        let turned = GBuffer { normal: vec![[0.0, 0.0, 1.0]; far.normal.len()], ..ground(0.0) };
        assert_eq!(flicker(&turned.frame(&picture), &far.frame(&picture)), None, "another side");
        let sky = GBuffer { view_depth: vec![f64::INFINITY; far.view_depth.len()], ..ground(0.0) };
        assert_eq!(flicker(&far.frame(&picture), &sky.frame(&picture)), None);
    }

    #[test]
    fn flicker_refuses_frames_of_other_sizes() {
        let seen = ground(0.0);
        let picture = noise(1);
        let short = seen.frame(&picture[1..]);
        assert!(FlickerCount::default().add(&short, &seen.frame(&picture)).is_err());
        assert!(FlickerCount::default().add(&seen.frame(&picture), &short).is_err());
        assert_eq!(FlickerCount::default().finish(), None);
    }
}
