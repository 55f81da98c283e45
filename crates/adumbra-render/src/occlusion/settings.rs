//! What ambient occlusion is asked for.

use adumbra_shaders::layout::{Frame, OcclusionFilterParams, OcclusionParams};

use super::estimator::{Estimator, MAX_PARAMETERS, ShapeParameter};

/// Radius where none is given, as a share of the scene's usual diagonal ([`adumbra::scene::Scene::usual_diagonal`]).
pub const DEFAULT_RADIUS_SHARE: f64 = 0.02;
/// Difference of visibility that the edge test passes over: a step of eight bits.
const EDGE_TOLERANCE: f32 = 1.0 / 255.0;
/// Least standard deviation of view depth, world units: its inverse squared is still a number.
const LEAST_SIGMA_WORLD: f64 = 1e-15;

/// Where normals come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Normals {
    /// The G-buffer's.
    GBuffer,
    /// Made from depth.
    Depth,
}

/// What smooths the noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// Nothing.
    None,
    /// Two lines, one after the other, that see depth: near the square where surfaces are flat; over the generated city
    /// they differ from it by 0.15 of what it changes, root mean square.
    Bilateral,
    /// The square of equation 7.
    BilateralSquare,
    /// Two lines that see no depth.
    Gauss,
}

/// What `issao` adds up, each a file of the shader's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Term {
    /// The paper's.
    Attenuated,
    /// With the falloff of the second reading of φ.
    Falloff,
    /// Without the attenuation.
    Bare,
}

/// An ambient occlusion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OcclusionSettings {
    /// How it is estimated.
    pub estimator: Estimator,
    /// The estimator's parameters, by [`Estimator::parameters`].
    pub shape: [f64; MAX_PARAMETERS],
    /// Nothing further than this occludes, world units.
    pub radius_world: f64,
    /// Taps a texel, 1 to 64.
    pub samples: u32,
    /// Most texels that the radius takes on the screen.
    pub cap_texels: f64,
    /// Fewer taps where the radius takes few texels (`issao`).
    pub levels: bool,
    /// Where normals come from.
    pub normals: Normals,
    /// What smooths the noise.
    pub filter: Filter,
    /// Neighbours on either side that the filter takes, 1 to 16.
    pub filter_side: u32,
    /// Standard deviation of the filter, texels.
    pub sigma_texels: f64,
    /// Standard deviation of view depth in the filter, radii.
    pub sigma_depth: f64,
    /// The filter takes differences of depth from the centre's own surface, drawn on to each tap, so that it smooths planes
    /// at any angle; not from the centre's own depth, as equation 7 is printed.
    pub planes: bool,
    /// The filter leaves texels as they are whose neighbourhood needs none.
    pub edge_test: bool,
    /// At half of the width and height.
    pub half: bool,
    /// With what is still valid of the frame before.
    pub reuse: bool,
    /// Most frames that the mean over them goes back, 1 to 64.
    pub frames: u32,
}

impl OcclusionSettings {
    /// An estimator as it is without any parameter.
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

    /// A parameter's value by its name; 0 for one that the estimator does not have.
    pub fn parameter(&self, name: &str) -> f64 {
        let named = |p: &ShapeParameter| p.name == name;
        self.estimator.parameters().iter().position(named).map_or(0.0, |i| self.shape[i])
    }

    /// Which term `issao` adds up.
    pub(super) fn term(&self) -> Term {
        match (self.parameter("attenuation") > 0.5, self.parameter("reading").round() as u8) {
            (false, _) => Term::Bare,
            (true, 2) => Term::Falloff,
            (true, _) => Term::Attenuated,
        }
    }

    /// Width and height of the picture that occlusion is estimated in.
    pub fn size(&self, [width, height]: [u32; 2]) -> [u32; 2] {
        if self.half { [width.div_ceil(2), height.div_ceil(2)] } else { [width, height] }
    }

    /// The estimator's uniform in a frame. Every number that depends on the scene's unit is in it once, so that a scene that is scaled,
    /// its radius too, gives the same picture.
    pub fn params(&self, frame: &Frame) -> OcclusionParams {
        let scale = if self.half { 2 } else { 1 };
        let [width, height] = self.size([frame.size[0], frame.size[1]]);
        let length = |v: [f32; 4]| (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
        let along = |origin: [f32; 4], ray: [f32; 4]| {
            let whole = length(origin) + length(ray);
            [0, 1, 2, 3].map(|a| if a < 3 { (origin[a] + ray[a]) / whole } else { 0.0 })
        };
        let half_view =
            [length(frame.origin_x), length(frame.origin_y), length(frame.ray_x), length(frame.ray_y)];
        let per_texel = 2.0 * scale as f32 / frame.size[1] as f32;
        let ndc = |pixels: u32, side: f32| {
            let step = 2.0 * scale as f32 / pixels as f32;
            [side * step, side * (1.0 / pixels as f32 - 1.0)]
        };
        let ([ax, bx], [ay, by]) = (ndc(frame.size[0], 1.0), ndc(frame.size[1], -1.0));
        let (shape, shape_more) = self.packed_shape();
        let [taps, steps] = self.counted_taps();
        OcclusionParams {
            size: [width, height, scale, if self.normals == Normals::GBuffer { scale } else { 1 }],
            counts: [
                taps,
                steps,
                if self.reuse { frame.size[2] % 16 * 5 } else { 0 },
                if self.levels { 0 } else { 4 },
            ],
            region: [
                self.radius_world as f32,
                self.cap_texels as f32,
                per_texel * half_view[1],
                per_texel * half_view[3],
            ],
            ndc_from_texel: [ax, ay, bx, by],
            half_view,
            depth_to_z: frame.depth_to_z,
            right: along(frame.origin_x, frame.ray_x),
            up: along(frame.origin_y, frame.ray_y),
            forward: frame.forward,
            shape,
            shape_more,
        }
    }

    /// Taps that are taken, and steps of a march among them.
    fn counted_taps(&self) -> [u32; 2] {
        match self.estimator {
            Estimator::Hbao | Estimator::Gtao => {
                let [directions, steps] = march(self.samples);
                [directions * steps, steps]
            }
            _ => [self.samples, 1],
        }
    }

    /// The parameters as the estimator's shader takes them.
    fn packed_shape(&self) -> ([f32; 4], [f32; 4]) {
        let p = |name| self.parameter(name);
        let (shape, more) = match self.estimator {
            Estimator::Issao => {
                // What φ is of each reading: factor, exponent of the falloff, exponent of the visibility.
                let [factor, falloff, contrast] = match p("reading").round() as u8 {
                    1 => [p("phi"), 0.0, 1.0],
                    2 => [1.0, 1.0 / p("phi"), 1.0],
                    _ => [1.0, 0.0, 1.0 / p("phi")],
                };
                (
                    [2.0 * p("lambda") * factor, p("psi"), p("zcap"), p("sigma")],
                    [falloff, contrast, 0.0, p("before")],
                )
            }
            Estimator::Ssao => {
                let least_rise = if p("tangent") > 0.5 { p("bias") } else { f64::from(f32::MIN) };
                ([p("strength"), p("power"), p("bias"), p("range")], [least_rise, 0.0, 0.0, 0.0])
            }
            Estimator::Hbao => ([p("strength"), p("power"), p("bias"), 0.5 * p("falloff")], [0.0; 4]),
            Estimator::Alchemy => ([2.0 * p("sigma"), p("k"), p("beta"), p("epsilon")], [0.0; 4]),
            Estimator::Gtao => ([1.0 / (1.0 - p("falloff")), 1.0 + p("thin"), p("power"), 0.0], [0.0; 4]),
        };
        (shape.map(|v| v as f32), more.map(|v| v as f32))
    }

    /// Passes of the filter.
    pub(super) fn filter_passes(&self) -> u32 {
        match self.filter {
            Filter::None => 0,
            Filter::BilateralSquare => 1,
            Filter::Bilateral | Filter::Gauss => 2,
        }
    }

    /// A filter pass's uniform along an axis (0 x, 1 y).
    pub fn filter_params(&self, frame: &Frame, axis: u32) -> OcclusionFilterParams {
        let [width, height] = self.size([frame.size[0], frame.size[1]]);
        let sigma_world = (self.sigma_depth * self.radius_world).max(LEAST_SIGMA_WORLD);
        let is_perspective = frame.depth_to_z[3] != 0.0;
        let follows = |projection: bool| f32::from(u8::from(self.planes && projection));
        OcclusionFilterParams {
            counts: [width, height, self.filter_side, axis],
            shape: [
                (std::f64::consts::FRAC_1_SQRT_2 / sigma_world) as f32,
                follows(is_perspective),
                follows(!is_perspective),
                if self.edge_test { EDGE_TOLERANCE } else { -1.0 },
            ],
            near: [(0.5 / (self.sigma_texels * self.sigma_texels)) as f32, 0.0, 0.0, 0.0],
        }
    }
}

/// Directions of a march of `samples` taps, and steps along each. Directions are an even number, so that two make a slice, except for
/// a single tap, and 1/2 to 3 times the steps; so a few taps may be left over. Of what leaves fewest the nearest to four
/// directions for three steps.
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
