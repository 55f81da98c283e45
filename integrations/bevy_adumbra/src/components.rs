//! Components that an app puts on its entities or finds there.

use adumbra::{Bias, Filter};
use bevy::asset::Handle;
use bevy::ecs::prelude::*;
use bevy::prelude::Transform;
use bevy::reflect::prelude::*;

use crate::BakedShadowFile;
use crate::source::StreamSource;
use crate::status::BakedShadowStatus;

/// Shadows of a directional light from baked files. Put it on the light, whose `shadow_maps_enabled` must be
/// true.
///
/// While a file is in use, entities below a [`ShadowStatic`] cast no shadow through this light's cascades,
/// because their shadows are in the file. Everything else goes on casting through them, and the darker shadow
/// wins. [`BakedShadowStatus`] on the same entity says where shadows come from.
#[derive(Component, Clone, Debug, Reflect)]
#[reflect(Component, Default, Clone, Debug)]
#[require(BakedShadowStatus)]
pub struct BakedShadow {
    /// The files: parts of a large world, or several suns. A point is looked up in the file whose grid
    /// contains it; if several do, in the file that it is farthest inside of. At most eight files are in use
    /// at once in an app.
    pub files: Vec<Handle<BakedShadowFile>>,
    /// Files that are streamed: the parts that cameras see are read, within a
    /// [`StreamBudget`](crate::StreamBudget). They are in use in addition to `files`.
    pub streams: Vec<StreamSource>,
    /// The texels whose mean a look-up returns.
    pub filter: ShadowFilter,
    /// Full angle of the sun's disc in degrees, 0.01 to 20, for shadows that soften with distance; the real
    /// sun has 0.53. It takes the place of `filter`, and costs about 64 look-ups per pixel.
    pub sun_degrees: Option<f32>,
    /// Whether to turn the light towards the sun of the first file. Otherwise a file is in use while the
    /// light's direction is that of its sun, to within 0.05 degrees.
    pub align: bool,
    /// How far points are lifted off their surfaces. `None` is the bias that the file was baked for.
    pub bias: Option<ShadowBias>,
    /// Whether shadows follow the light wherever it turns, as the sun does in a day. They come from keys that
    /// a `RuntimeBake` on the same light bakes ahead of it (feature `bake`), in place of
    /// `files` and `streams`. A filter is the mean of 3 × 3 rays; `sun_degrees` is not possible. Of the files
    /// that an app may have in use, such a light takes four.
    pub follow: bool,
}

impl BakedShadow {
    /// Shadows from one file, with the default filter. The light turns to the file's sun.
    pub fn new(file: Handle<BakedShadowFile>) -> Self {
        Self { files: vec![file], ..Self::default() }
    }

    /// Shadows from one streamed file of any size. The source is an asset's path, a path on a disk, or a
    /// custom source. Bake the file with several levels (`adumbra bake --levels 5`), so that a coarse level
    /// answers at once.
    pub fn streamed(source: impl Into<StreamSource>) -> Self {
        Self { streams: vec![source.into()], ..Self::default() }
    }

    /// Shadows that follow the light wherever it turns, as the sun does in a day: put a `RuntimeBake` on the
    /// same light (feature `bake`). Keys are baked ahead of the light in the background, coarse to fine.
    /// After the first key, every frame has an answer, even if the light jumps.
    pub fn follow_sun() -> Self {
        Self { align: false, follow: true, ..Self::default() }
    }
}

/// As [`BakedShadow::new`], without a file.
impl Default for BakedShadow {
    fn default() -> Self {
        Self {
            files: Vec::new(),
            streams: Vec::new(),
            filter: ShadowFilter::default(),
            sun_degrees: None,
            align: true,
            bias: None,
            follow: false,
        }
    }
}

/// The texels whose mean a look-up returns, around the point's texel.
///
/// It mirrors [`Filter`], which does not implement reflection. Reflecting another crate's type takes `unsafe`
/// code, which this crate forbids.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Reflect)]
#[reflect(Default, Clone, Debug, PartialEq, Hash)]
pub enum ShadowFilter {
    /// One texel: a hard edge.
    Nearest,
    /// 3 × 3 texels.
    Box3,
    /// 5 × 5 texels, the default.
    Box5,
    /// 9 × 9 texels.
    Box9,
    /// 17 × 17 texels.
    Box17,
}

impl Default for ShadowFilter {
    fn default() -> Self {
        Filter::default().into()
    }
}

impl From<Filter> for ShadowFilter {
    fn from(filter: Filter) -> Self {
        match filter {
            Filter::Nearest => Self::Nearest,
            Filter::Box3 => Self::Box3,
            Filter::Box5 => Self::Box5,
            Filter::Box9 => Self::Box9,
            Filter::Box17 => Self::Box17,
        }
    }
}

impl From<ShadowFilter> for Filter {
    fn from(filter: ShadowFilter) -> Self {
        match filter {
            ShadowFilter::Nearest => Self::Nearest,
            ShadowFilter::Box3 => Self::Box3,
            ShadowFilter::Box5 => Self::Box5,
            ShadowFilter::Box9 => Self::Box9,
            ShadowFilter::Box17 => Self::Box17,
        }
    }
}

/// How far a look-up lifts its point off the surface, in texels of the file.
///
/// It mirrors [`Bias`] for the same reason as [`ShadowFilter`].
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Default, Clone, Debug, PartialEq)]
pub struct ShadowBias {
    /// Distance towards the sun, on every surface.
    pub constant_texels: f64,
    /// Distance towards the sun, multiplied by the tangent of the angle between normal and light.
    pub slope_texels: f64,
    /// Distance along the normal.
    pub normal_offset_texels: f64,
}

impl Default for ShadowBias {
    fn default() -> Self {
        Bias::default().into()
    }
}

impl From<Bias> for ShadowBias {
    fn from(bias: Bias) -> Self {
        let Bias { constant_texels, slope_texels, normal_offset_texels } = bias;
        Self { constant_texels, slope_texels, normal_offset_texels }
    }
}

impl From<ShadowBias> for Bias {
    fn from(bias: ShadowBias) -> Self {
        let ShadowBias { constant_texels, slope_texels, normal_offset_texels } = bias;
        Self { constant_texels, slope_texels, normal_offset_texels }
    }
}

/// This entity and everything below it does not move, and is in the files. Skinned and animated meshes are
/// left out, as in a bake.
#[derive(Component, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Component, Default, Clone, Debug)]
pub struct ShadowStatic;

/// The root of the scene that a file was baked from: the file's world coordinates are local to this entity.
/// Shadows and the file's sun follow it wherever the app moves it, turns it, or scales it by one number, at
/// any time. Without a root, the file's world coordinates are the app's.
///
/// It requires a `Transform`. A file with several roots is in several places. Each place counts as one of the
/// at most eight files in use, with a separate copy of the words on the GPU.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component, Clone, Debug, PartialEq)]
#[require(Transform)]
pub enum FileRoot {
    /// The root of a file that is loaded whole, as in [`BakedShadow::files`].
    Whole(Handle<BakedShadowFile>),
    /// The root of a file that is streamed, as in [`BakedShadow::streams`].
    Streamed(StreamSource),
}

impl FileRoot {
    /// The root of a file that is loaded whole.
    pub fn new(file: Handle<BakedShadowFile>) -> Self {
        Self::Whole(file)
    }

    /// The root of a file that is streamed.
    pub fn streamed(source: impl Into<StreamSource>) -> Self {
        Self::Streamed(source.into())
    }
}

/// This entity and everything below it may move, although it is below a [`ShadowStatic`].
#[derive(Component, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Component, Default, Clone, Debug)]
pub struct ExcludeFromBake;

/// A mesh whose shadow is in the files. The plugin keeps this marker on the meshes below a [`ShadowStatic`].
#[derive(Component, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Component, Default, Clone, Debug)]
pub struct IncludedInBake;

/// How shadows of meshes in the files are kept out of the cascades. A resource.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Resource, Default, Clone, Debug, PartialEq)]
pub enum StaticCasters {
    /// They are left out of the cascades of lights whose files are in use. Shadows of other lights keep them.
    #[default]
    LeaveOut,
    /// They stay in the cascades and cast twice. For comparisons.
    Keep,
}
