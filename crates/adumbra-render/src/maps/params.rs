//! What a shadow-map technique is made of: plain settings, each with a default.

use wgpu::TextureFormat;

/// How a view's depth is shared between cascades.
///
/// Source: Zhang, Sun, Xu, Lun, *Parallel-Split Shadow Maps for Large-Scale Virtual Environments*, 2006.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Split {
    /// Slices of equal depth.
    Uniform,
    /// Slices of equal ratio.
    Logarithmic,
    /// A blend: 0 = uniform, 1 = logarithmic.
    Practical {
        /// Share of the logarithmic split, 0 to 1.
        lambda: f64,
    },
}

/// The settings of cascades.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CascadeSettings {
    /// Layers, 1 to 8.
    pub cascades: u32,
    /// How depth is shared between them.
    pub split: Split,
    /// View depth where shadows end, world units; none = where the camera's sight of the scene ends (see [`super::cascades::reach`]).
    pub far_world: Option<f64>,
    /// Share of a slice's depth in which it blends into the next, and of the last one in which shadows fade to lit; 0 to 0.5.
    pub blend: f64,
}

impl Default for CascadeSettings {
    fn default() -> Self {
        Self { cascades: 4, split: Split::Practical { lambda: 0.5 }, far_world: None, blend: 0.1 }
    }
}

/// Where the layers lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MapFit {
    /// One layer over the whole scene.
    Scene,
    /// Layers fitted to the camera's view.
    Cascades(CascadeSettings),
}

/// How a comparison with the map becomes a visibility.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MapFilter {
    /// The texel that the point lies in, compared.
    Nearest,
    /// Percentage closer: texels in a square of this width compared, and the answers weighted. Width 2 is the sampler's own
    /// 2 × 2; 3, 5 and 7 compare each texel with the receiver's plane.
    Pcf {
        /// 2, 3, 5 or 7 texels.
        width: u32,
    },
    /// 16 taps of a Poisson disc, turned from pixel to pixel.
    Poisson {
        /// Texels.
        radius: f64,
    },
    /// Percentage-closer soft shadows for a sun of this size.
    Pcss {
        /// Diameter of the sun, degrees.
        angle_degrees: f64,
        /// Penumbrae are not made wider than this many texels, from middle to edge.
        max_radius: f64,
    },
    /// Statistics of blurred depth.
    Moments(MomentSettings),
}

/// Which statistics are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MomentKind {
    /// Mean and mean square of depth: variance shadow maps.
    Variance,
    /// The same of two exponentials of depth: exponential variance shadow maps.
    ExponentialVariance,
    /// The first four moments of depth: moment shadow maps.
    FourMoments,
}

/// The settings of filters that blur statistics of depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MomentSettings {
    /// Which statistics.
    pub kind: MomentKind,
    /// Width of the Gaussian, odd, 1 (none) to 31 texels.
    pub blur: u32,
    /// Share of the upper bound's tail that counts as shadow, 0 to 0.9: more means less light bleeding and harder edges.
    pub bleed: f64,
    /// Least standard deviation of depth, in texels.
    pub least_deviation_texels: f64,
    /// Exponents of the two warps, positive and negative; at most 42 in 32-bit floats.
    pub exponents: [f64; 2],
}

impl MomentSettings {
    /// Defaults of this kind: what errs least by rays on four scenes.
    pub fn new(kind: MomentKind) -> Self {
        let bleed = if kind == MomentKind::Variance { 0.3 } else { 0.1 };
        Self { kind, blur: 3, bleed, least_deviation_texels: 0.5, exponents: [40.0, 5.0] }
    }
}

/// How far a look-up moves its point towards the light: the form of `adumbra::settings::Bias`, for shadow maps.
///
/// All in texels of the layer, times `1 + filter_factor · (width - 1)` for a filter of that width: neither another resolution nor
/// another filter needs other numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapBias {
    /// Along the light, everywhere.
    pub constant_texels: f64,
    /// Along the light, times the tangent of the angle between normal and light.
    pub slope_texels: f64,
    /// Along the normal.
    pub normal_offset_texels: f64,
    /// How the filter's width widens all three.
    pub filter_factor: f64,
}

impl MapBias {
    /// The usual bias of this filter: what errs least by rays on four scenes, with no acne to speak of.
    pub fn of(filter: &MapFilter) -> Self {
        // The sampler's own comparison makes room for the slope itself.
        let (constant_texels, slope_texels) =
            if *filter == (MapFilter::Pcf { width: 2 }) { (0.25, 0.0) } else { (0.5, 0.05) };
        Self { constant_texels, slope_texels, normal_offset_texels: 0.0, filter_factor: 0.1 }
    }
}

/// How exactly a map holds the depth of a layer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DepthPrecision {
    /// A float: 24 bits or better, four bytes a texel.
    #[default]
    Bits32,
    /// The nearest of 65,536 depths, two bytes a texel.
    Bits16,
}

impl DepthPrecision {
    /// Of the textures.
    pub fn format(self) -> TextureFormat {
        match self {
            Self::Bits32 => TextureFormat::Depth32Float,
            Self::Bits16 => TextureFormat::Depth16Unorm,
        }
    }

    /// The least bias along the light, as a share of the layer's range: what rounding may move a caster and a receiver apart. With 16 bits a
    /// step of stored depth, of which rounding takes half at most; with 32 bits some units in the last place of 1, because light depth is
    /// computed in floats, by sums of four terms on either side.
    pub fn least_bias(self) -> f64 {
        match self {
            Self::Bits32 => 8.0 / 16_777_216.0,
            Self::Bits16 => 1.0 / 65535.0,
        }
    }
}

/// A shadow-map technique.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapSettings {
    /// Texels a side of each layer, a power of two.
    pub size: u32,
    /// How exactly depth is held.
    pub depth: DepthPrecision,
    /// Where the layers lie.
    pub fit: MapFit,
    /// How they are read.
    pub filter: MapFilter,
    /// How the receiver is moved.
    pub bias: MapBias,
    /// Keep each layer's static casters, and draw only movers while the layer stays where it is.
    pub cache_static: bool,
    /// What is drawn into it.
    pub casters: MapCasters,
}

/// Which casters a shadow map holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapCasters {
    /// Everything.
    All,
    /// What moves; something else answers for the rest.
    Movers,
}

impl MapSettings {
    /// Default settings of this fit and filter: 2048 texels a side, 32-bit depth.
    pub fn new(fit: MapFit, filter: MapFilter) -> Self {
        let bias = MapBias::of(&filter);
        let (depth, casters) = (DepthPrecision::default(), MapCasters::All);
        Self { size: 2048, depth, fit, filter, bias, cache_static: false, casters }
    }

    /// Layers.
    pub fn layers(&self) -> u32 {
        match self.fit {
            MapFit::Scene => 1,
            MapFit::Cascades(c) => c.cascades,
        }
    }
}

impl MapFilter {
    /// How far from a point the filter reads, texels.
    pub fn reach_texels(&self) -> f64 {
        match *self {
            Self::Nearest => 1.0,
            Self::Pcf { width } => 0.5 * f64::from(width) + 1.0,
            Self::Poisson { radius } => radius + 2.0,
            Self::Pcss { max_radius, .. } => max_radius + 2.0,
            Self::Moments(m) => 0.5 * f64::from(m.blur) + 2.0,
        }
    }

    /// The width that the bias grows with, texels. Penumbrae of soft shadows are left out of it: their taps are compared with the
    /// receiver's plane, and near their casters they are narrow.
    pub fn bias_width(&self) -> f64 {
        match *self {
            Self::Nearest => 1.0,
            Self::Pcf { width } => f64::from(width),
            Self::Poisson { radius } => 2.0 * radius + 1.0,
            Self::Pcss { .. } => 2.0,
            Self::Moments(m) => f64::from(m.blur),
        }
    }
}
