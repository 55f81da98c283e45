//! Settings of ambient occlusion.

use adumbra_shaders::layout::{Frame, OcclusionFilterParams, OcclusionParams, OcclusionShape, OcclusionView};

use super::estimator::{Estimator, MAX_PARAMETERS, ShapeParameter};

/// Default radius, as a share of the scene's usual diagonal ([`adumbra_scene::Scene::usual_diagonal`]).
pub const DEFAULT_RADIUS_SHARE: f64 = 0.02;
/// Difference of visibility that the edge test ignores: one step of eight bits.
const EDGE_TOLERANCE: f32 = 1.0 / 255.0;
/// Smallest standard deviation of view depth, world units. Keeps the square of its inverse finite.
const MIN_SIGMA_WORLD: f64 = 1e-15;

/// The source of normals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Normals {
    /// The G-buffer's.
    GBuffer,
    /// Computed from depth.
    Depth,
}

/// The filter that smooths the noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// No filter.
    None,
    /// Two depth-aware lines, one after the other. Close to the square on flat surfaces. On the generated
    /// city, their RMS difference from the square is 0.15 of the change that the square makes.
    Bilateral,
    /// The square of equation 7.
    BilateralSquare,
    /// Two lines that ignore depth.
    Gauss,
}

/// The term that `issao` sums, each in its own shader file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Term {
    /// The paper's.
    Attenuated,
    /// With the falloff of the second interpretation of φ.
    Falloff,
    /// Without the attenuation.
    Bare,
}

/// Settings of one ambient occlusion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OcclusionSettings {
    /// The estimator.
    pub estimator: Estimator,
    /// The estimator's parameters, in the order of [`Estimator::parameters`].
    pub shape: [f64; MAX_PARAMETERS],
    /// Distance beyond which nothing occludes, world units.
    pub radius_world: f64,
    /// Taps per texel, 1 to 64.
    pub samples: u32,
    /// Largest radius on the screen, texels.
    pub cap_texels: f64,
    /// Whether to take fewer taps if the radius covers few texels (`issao`).
    pub levels: bool,
    /// The source of normals.
    pub normals: Normals,
    /// The filter that smooths the noise.
    pub filter: Filter,
    /// Neighbours on either side that the filter reads, 1 to 16.
    pub filter_side: u32,
    /// Standard deviation of the filter, texels.
    pub sigma_texels: f64,
    /// Standard deviation of view depth in the filter, radii.
    pub sigma_depth: f64,
    /// Whether the filter measures differences of depth from the centre's surface, extrapolated to each tap,
    /// so that it smooths planes at any angle. Otherwise it measures them from the centre's depth, as
    /// equation 7 is printed.
    pub planes: bool,
    /// Whether the filter skips texels whose neighbourhood needs no smoothing.
    pub edge_test: bool,
    /// Whether to estimate at half the width and height.
    pub half: bool,
    /// Whether to reuse the still valid parts of previous frames.
    pub reuse: bool,
    /// Largest number of frames in the mean, 1 to 64.
    pub frames: u32,
}

impl OcclusionSettings {
    /// Default settings of an estimator.
    pub fn new(estimator: Estimator, radius_world: f64) -> Self {
        let mut shape = [0.0; MAX_PARAMETERS];
        shape.iter_mut().zip(estimator.parameters()).for_each(|(s, p)| *s = p.default);
        Self {
            estimator,
            shape,
            radius_world,
            samples: 12,
            cap_texels: 256.0,
            levels: true,
            normals: Normals::GBuffer,
            filter: Filter::Bilateral,
            filter_side: 4,
            sigma_texels: 2.5,
            sigma_depth: 0.03,
            planes: true,
            edge_test: false,
            half: false,
            reuse: false,
            frames: 8,
        }
    }

    /// Returns a parameter's value by its name, 0 if the estimator does not have it.
    pub fn parameter(&self, name: &str) -> f64 {
        let named = |p: &ShapeParameter| p.name == name;
        self.estimator.parameters().iter().position(named).map_or(0.0, |i| self.shape[i])
    }

    /// The term that `issao` sums.
    pub(super) fn term(&self) -> Term {
        match (self.parameter("attenuation") > 0.5, self.parameter("reading").round() as u8) {
            (false, _) => Term::Bare,
            (true, 2) => Term::Falloff,
            (true, _) => Term::Attenuated,
        }
    }

    /// Width and height of the textures in which occlusion is estimated.
    pub fn size(&self, [width, height]: [u32; 2]) -> [u32; 2] {
        if self.half { [width.div_ceil(2), height.div_ceil(2)] } else { [width, height] }
    }

    /// Returns the estimator's uniform for a frame. Each quantity that depends on the scene's unit of length
    /// appears once, so that scaling a scene together with its radius gives the same picture.
    pub fn params(&self, frame: &Frame) -> OcclusionParams {
        let scale = if self.half { 2 } else { 1 };
        let size = self.size(frame.size);
        let length = |v: [f32; 3]| (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
        let along = |origin: [f32; 3], ray: [f32; 3]| {
            let whole = length(origin) + length(ray);
            [0, 1, 2].map(|a| (origin[a] + ray[a]) / whole)
        };
        let half_view = [frame.origin_x, frame.origin_y].map(length);
        let half_view_per_depth = [frame.ray_x, frame.ray_y].map(length);
        let per_texel = 2.0 * scale as f32 / frame.size[1] as f32;
        let ndc = |pixels: u32, side: f32| {
            let step = 2.0 * scale as f32 / pixels as f32;
            [side * step, side * (1.0 / pixels as f32 - 1.0)]
        };
        let ([ax, bx], [ay, by]) = (ndc(frame.size[0], 1.0), ndc(frame.size[1], -1.0));
        let [tap_count, step_count] = self.counted_taps();
        OcclusionParams {
            view: OcclusionView {
                ndc_per_texel: [ax, ay],
                ndc_of_first_texel: [bx, by],
                half_view,
                half_view_per_depth,
                right: along(frame.origin_x, frame.ray_x),
                up: along(frame.origin_y, frame.ray_y),
                forward: frame.forward,
            },
            depth_to_z: frame.depth_to_z,
            shape: self.shape_uniform(),
            size,
            pixels_per_texel: scale,
            pixels_per_normal: if self.normals == Normals::GBuffer { scale } else { 1 },
            tap_count,
            step_count,
            tile_offset: if self.reuse { frame.number % 16 * 5 } else { 0 },
            min_quarters: if self.levels { 0 } else { 4 },
            radius_world: self.radius_world as f32,
            max_radius_texels: self.cap_texels as f32,
            texel_world: per_texel * half_view[1],
            texel_world_per_depth: per_texel * half_view_per_depth[1],
        }
    }

    /// Number of taps taken, and number of march steps among them.
    fn counted_taps(&self) -> [u32; 2] {
        match self.estimator {
            Estimator::Hbao | Estimator::Gtao => {
                let [directions, steps] = march(self.samples);
                [directions * steps, steps]
            }
            _ => [self.samples, 1],
        }
    }

    /// Returns the parameters as the estimator's shader takes them.
    fn shape_uniform(&self) -> OcclusionShape {
        let double = |name| self.parameter(name);
        let p = |name| self.parameter(name) as f32;
        let none = OcclusionShape {
            strength: 0.0,
            exponent: 0.0,
            bias: 0.0,
            max_bias_depth: 0.0,
            epsilon: 0.0,
            range: 0.0,
            min_rise: 0.0,
            falloff_exponent: 0.0,
            falloff_slope: 0.0,
            depth_stretch: 0.0,
            hides_from_outside: 0,
        };
        match self.estimator {
            Estimator::Issao => {
                // The role of φ in each interpretation: factor, exponent of the falloff, exponent of the
                // visibility.
                let [factor, falloff, contrast] = match double("reading").round() as u8 {
                    1 => [double("phi"), 0.0, 1.0],
                    2 => [1.0, 1.0 / double("phi"), 1.0],
                    _ => [1.0, 0.0, 1.0 / double("phi")],
                };
                OcclusionShape {
                    strength: (2.0 * double("lambda") * factor) as f32,
                    exponent: contrast as f32,
                    bias: p("psi"),
                    max_bias_depth: p("zcap"),
                    epsilon: p("sigma"),
                    falloff_exponent: falloff as f32,
                    hides_from_outside: (double("before") > 0.0).into(),
                    ..none
                }
            }
            Estimator::Ssao => OcclusionShape {
                strength: p("strength"),
                exponent: p("power"),
                bias: p("bias"),
                range: p("range"),
                min_rise: if double("tangent") > 0.5 { p("bias") } else { f32::MIN },
                ..none
            },
            Estimator::Hbao => OcclusionShape {
                strength: p("strength"),
                exponent: p("power"),
                bias: p("bias"),
                falloff_exponent: (0.5 * double("falloff")) as f32,
                ..none
            },
            Estimator::Alchemy => OcclusionShape {
                strength: (2.0 * double("sigma")) as f32,
                exponent: p("k"),
                bias: p("beta"),
                epsilon: p("epsilon"),
                ..none
            },
            Estimator::Gtao => OcclusionShape {
                exponent: p("power"),
                falloff_slope: (1.0 / (1.0 - double("falloff"))) as f32,
                depth_stretch: (1.0 + double("thin")) as f32,
                ..none
            },
        }
    }

    /// Number of filter passes.
    pub(super) fn filter_passes(&self) -> u32 {
        match self.filter {
            Filter::None => 0,
            Filter::BilateralSquare => 1,
            Filter::Bilateral | Filter::Gauss => 2,
        }
    }

    /// Returns a filter pass's uniform along an axis (0 x, 1 y).
    pub(crate) fn filter_params(&self, frame: &Frame, axis: u32) -> OcclusionFilterParams {
        let sigma_world = (self.sigma_depth * self.radius_world).max(MIN_SIGMA_WORLD);
        let is_perspective = frame.depth_to_z.is_perspective();
        let follows = |projection: bool| f32::from(u8::from(self.planes && projection));
        OcclusionFilterParams {
            size: self.size(frame.size),
            taps_per_side: self.filter_side,
            axis,
            plane_kind: [follows(is_perspective), follows(!is_perspective)],
            inverse_depth_width: (std::f64::consts::FRAC_1_SQRT_2 / sigma_world) as f32,
            inverse_distance_width: (0.5 / (self.sigma_texels * self.sigma_texels)) as f32,
            edge_tolerance: if self.edge_test { EDGE_TOLERANCE } else { -1.0 },
        }
    }
}

/// Directions of a march of `samples` taps, and steps along each. The number of directions is even, so that
/// two make a slice, except for a single tap. It is 1/2 to 3 times the number of steps, so a few taps may be
/// unused. Picks the pair that leaves the fewest unused; among equals, the one nearest to four directions per
/// three steps.
pub(super) fn march(samples: u32) -> [u32; 2] {
    let pairs = (2..=samples).step_by(2).map(|directions| [directions, samples / directions]);
    let fitting = pairs.filter(|&[d, s]| s <= 2 * d && d <= 3 * s);
    let off = |[d, s]: [u32; 2]| (3 * d).abs_diff(4 * s);
    fitting.min_by_key(|&[d, s]| (samples - d * s, off([d, s]))).unwrap_or([1, 1])
}

#[cfg(test)]
mod tests {
    use super::march;

    #[test]
    fn march_takes_nearly_all_taps() {
        for (samples, expected) in [
            (1, [1, 1]),
            (2, [2, 1]),
            (4, [2, 2]),
            (8, [4, 2]),
            (12, [4, 3]),
            (16, [4, 4]),
            (24, [6, 4]),
            (64, [8, 8]),
        ] {
            assert_eq!(march(samples), expected, "{samples}");
        }
        for samples in 1..=64 {
            let [directions, steps] = march(samples);
            assert!(
                3 * (samples - directions * steps) <= samples.min(15),
                "{samples}: {directions} × {steps}"
            );
        }
    }
}
