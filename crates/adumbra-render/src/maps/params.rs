//! Plain settings of shadow-map techniques, with their defaults.

use adumbra_shaders::layout::ReceiverBias;
use wgpu::TextureFormat;

/// How a view's depth range is divided between cascades.
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
    /// Number of layers, 1 to 8.
    pub cascades: u32,
    /// How the depth range is divided between them.
    pub split: Split,
    /// View depth at which shadows end, world units. `None` = where the scene in view ends (see
    /// [`super::cascades::reach`]).
    pub far_world: Option<f64>,
    /// Share of a slice's depth over which it blends into the next, 0 to 0.5. In the last slice, shadows fade
    /// to lit over it.
    pub blend: f64,
}

impl Default for CascadeSettings {
    fn default() -> Self {
        Self { cascades: 4, split: Split::Practical { lambda: 0.5 }, far_world: None, blend: 0.1 }
    }
}

/// Placement of the layers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MapFit {
    /// One layer over the whole scene.
    Scene,
    /// Layers fitted to the camera's view.
    Cascades(CascadeSettings),
}

/// How comparisons with the map become a visibility.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MapFilter {
    /// Compares the one texel that contains the point.
    Nearest,
    /// Percentage-closer filtering: compares the texels of a square of this width and weights the results.
    /// Width 2 is the sampler's built-in 2 × 2 comparison; 3, 5 and 7 compare each texel with the receiver's
    /// plane.
    Pcf {
        /// 2, 3, 5 or 7 texels.
        width: u32,
    },
    /// 16 taps of a Poisson disc, rotated per pixel.
    Poisson {
        /// Texels.
        radius: f64,
    },
    /// Percentage-closer soft shadows for a sun of this size.
    Pcss {
        /// Diameter of the sun, degrees.
        sun_degrees: f64,
        /// Largest radius of a penumbra, from its middle to its edge, texels.
        max_radius: f64,
    },
    /// Statistics of blurred depth.
    Moments(MomentSettings),
}

/// The statistics that a moment filter stores.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MomentKind {
    /// Mean and mean square of depth: variance shadow maps.
    Variance,
    /// Mean and mean square of two exponentials of depth: exponential variance shadow maps.
    ExponentialVariance,
    /// The first four moments of depth: moment shadow maps.
    FourMoments,
}

/// The settings of filters that blur statistics of depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MomentSettings {
    /// The statistics stored.
    pub kind: MomentKind,
    /// Width of the Gaussian, odd, 1 (none) to 31 texels.
    pub blur: u32,
    /// Share of the upper bound's tail that counts as shadow, 0 to 0.9. More reduces light bleeding but
    /// hardens edges.
    pub bleed: f64,
    /// Smallest standard deviation of depth, texels.
    pub min_deviation_texels: f64,
    /// Exponents of the positive and the negative warp. At most 42, the limit of 32-bit floats.
    pub exponents: [f64; 2],
}

impl MomentSettings {
    /// Defaults of this kind: the values with the least error against ray-traced truth on four scenes.
    pub fn new(kind: MomentKind) -> Self {
        let bleed = if kind == MomentKind::Variance { 0.3 } else { 0.1 };
        Self { kind, blur: 3, bleed, min_deviation_texels: 0.5, exponents: [40.0, 5.0] }
    }
}

/// How far a look-up moves its point towards the light: `adumbra::Bias` in a form for shadow maps.
///
/// All values are in texels of the layer, times `1 + filter_factor · (width - 1)` for a filter of that width.
/// So a change of resolution or filter needs no other values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapBias {
    /// Along the light, everywhere.
    pub constant_texels: f64,
    /// Along the light, times the tangent of the angle between normal and light.
    pub slope_texels: f64,
    /// Along the normal.
    pub normal_offset_texels: f64,
    /// How much the filter's width increases all three.
    pub filter_factor: f64,
}

impl MapBias {
    /// The default bias of this filter: the values with the least error against ray-traced truth on four
    /// scenes, with no noticeable acne.
    pub(crate) fn for_filter(filter: &MapFilter) -> Self {
        // The 2 × 2 hardware comparison allows for the slope itself.
        let (constant_texels, slope_texels) =
            if *filter == (MapFilter::Pcf { width: 2 }) { (0.25, 0.0) } else { (0.5, 0.05) };
        Self { constant_texels, slope_texels, normal_offset_texels: 0.0, filter_factor: 0.1 }
    }

    /// Returns the bias as shaders take it, for this filter.
    pub(crate) fn uniform(&self, filter: &MapFilter) -> ReceiverBias {
        ReceiverBias {
            constant_texels: self.constant_texels as f32,
            slope_texels: self.slope_texels as f32,
            normal_offset_texels: self.normal_offset_texels as f32,
            width_factor: (1.0 + self.filter_factor * (filter.bias_width() - 1.0)) as f32,
        }
    }
}

/// Precision of a map's depth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DepthPrecision {
    /// 32-bit float: 24 bits of precision or better, four bytes per texel.
    #[default]
    Bits32,
    /// The nearest of 65,536 values, two bytes per texel.
    Bits16,
}

impl DepthPrecision {
    /// Format of the depth textures.
    pub fn format(self) -> TextureFormat {
        match self {
            Self::Bits32 => TextureFormat::Depth32Float,
            Self::Bits16 => TextureFormat::Depth16Unorm,
        }
    }

    /// The smallest bias along the light, as a share of the layer's range: the most by which rounding may
    /// separate a caster from a receiver on it. With 16 bits this is one step of stored depth, of which
    /// rounding takes at most half. With 32 bits it is a few units in the last place of 1, because both sides
    /// compute light depth in floats, as sums of four terms.
    pub fn min_bias_depth(self) -> f64 {
        match self {
            Self::Bits32 => 8.0 / 16_777_216.0,
            Self::Bits16 => 1.0 / 65535.0,
        }
    }
}

/// Settings of a shadow-map technique.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapSettings {
    /// Texels per side of each layer, a power of two.
    pub size: u32,
    /// Precision of the depth.
    pub depth: DepthPrecision,
    /// Placement of the layers.
    pub fit: MapFit,
    /// The filter of the look-up.
    pub filter: MapFilter,
    /// The receiver's bias.
    pub bias: MapBias,
    /// Whether to cache each layer's static casters and draw only movers while the layer does not move.
    pub cache_static: bool,
    /// The casters that are drawn.
    pub casters: MapCasters,
}

/// Which casters a shadow map holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapCasters {
    /// Everything.
    All,
    /// Only moving casters; another technique handles the static ones.
    Movers,
}

impl MapSettings {
    /// Default settings for this fit and filter: 2048 texels per side, 32-bit depth.
    pub fn new(fit: MapFit, filter: MapFilter) -> Self {
        let bias = MapBias::for_filter(&filter);
        let (depth, casters) = (DepthPrecision::default(), MapCasters::All);
        Self { size: 2048, depth, fit, filter, bias, cache_static: false, casters }
    }

    /// Number of layers.
    pub fn layers(&self) -> u32 {
        match self.fit {
            MapFit::Scene => 1,
            MapFit::Cascades(c) => c.cascades,
        }
    }
}

impl MapFilter {
    /// Distance from a point within which the filter reads, texels.
    pub fn reach_texels(&self) -> f64 {
        match *self {
            Self::Nearest => 1.0,
            Self::Pcf { width } => 0.5 * f64::from(width) + 1.0,
            Self::Poisson { radius } => radius + 2.0,
            Self::Pcss { max_radius, .. } => max_radius + 2.0,
            Self::Moments(m) => 0.5 * f64::from(m.blur) + 2.0,
        }
    }

    /// The filter width that scales the bias, texels. Penumbrae of soft shadows do not count: their taps are
    /// compared with the receiver's plane, and they are narrow near their casters.
    pub(crate) fn bias_width(&self) -> f64 {
        match *self {
            Self::Nearest => 1.0,
            Self::Pcf { width } => f64::from(width),
            Self::Poisson { radius } => 2.0 * radius + 1.0,
            Self::Pcss { .. } => 2.0,
            Self::Moments(m) => f64::from(m.blur),
        }
    }
}
