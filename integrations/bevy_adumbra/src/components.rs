//! What an app puts on its entities, and what it finds there.

use adumbra::Bias;
use bevy::asset::Handle;
use bevy::ecs::prelude::*;

use crate::BakedShadowFile;

/// Shadows of a directional light from baked files. Put it on the light, whose `shadow_maps_enabled` must be true.
///
/// While a file is in use, entities below a [`BakedStatic`] cast no shadow through this light's cascades, because their
/// shadows are in the file. Everything else goes on casting through them, and the darker shadow wins.
/// [`BakedShadowStatus`] on the same entity tells what is going on.
#[derive(Component, Clone, Debug)]
#[require(BakedShadowStatus)]
pub struct BakedShadow {
    /// The files: parts of a large world, or several suns. A point takes the file whose grid contains it, and that which
    /// it is farthest inside of if there are several. At most eight files are in use at once in an app.
    pub files: Vec<Handle<BakedShadowFile>>,
    /// Width of the filter in texels: 1, 3, 5, 9 or 17. 1 is a hard edge.
    pub filter: u32,
    /// Full angle of the sun's disc in degrees, 0.01 to 20, for shadows that soften with distance; the real sun has 0.53.
    /// It takes the place of `filter`, and costs about 64 look-ups per pixel. Only for files in the layout depths, which
    /// is the default of a bake.
    pub softness: Option<f32>,
    /// Whether to turn the light towards the sun of the first file. Otherwise a file is in use while the light's
    /// direction is that of its sun, to within 0.05 degrees.
    pub align: bool,
    /// How far points are lifted off their surfaces, in texels. `None` is the bias that the file was baked for.
    pub bias: Option<Bias>,
}

impl BakedShadow {
    /// Shadows from one file, filtered over 5 × 5 texels. The light turns to the file's sun.
    pub fn new(file: Handle<BakedShadowFile>) -> Self {
        Self { files: vec![file], filter: 5, softness: None, align: true, bias: None }
    }
}

/// What the shadows of a [`BakedShadow`] come from. It is kept up to date on the light, and [`BakedShadowChanged`] is
/// triggered when it changes.
#[derive(Component, Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum BakedShadowStatus {
    /// No file is loaded yet. Shadows come from the light's cascades.
    #[default]
    Waiting,
    /// Files are in use: this many of [`BakedShadow::files`].
    Active(usize),
    /// The light points away from the sun of every loaded file; the nearest is this far off, degrees. Shadows come from
    /// the light's cascades.
    Misaligned(f32),
    /// Nothing can be used, for the reason given. Shadows come from the light's cascades.
    Unusable(String),
}

impl BakedShadowStatus {
    /// Returns whether files are in use.
    pub fn is_active(&self) -> bool {
        matches!(self, Self::Active(_))
    }
}

/// A light's [`BakedShadowStatus`] has changed.
#[derive(EntityEvent, Clone, Debug)]
pub struct BakedShadowChanged {
    /// The light.
    pub entity: Entity,
    /// Its new status.
    pub status: BakedShadowStatus,
}

/// Everything below this entity, and itself, is in the files: it does not move. Skinned and animated meshes are left
/// out, as a bake leaves them out.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct BakedStatic;

/// This entity and everything below it moves after all, although it is below a [`BakedStatic`].
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct NotBaked;

/// A mesh whose shadow is in the files. The plugin keeps this marker on the meshes below a [`BakedStatic`].
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct InBake;

/// How shadows of meshes in the files are kept out of the cascades. A resource.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StaticCasters {
    /// They are left out of the cascades of lights whose files are in use. Shadows of other lights keep them.
    #[default]
    LeaveOut,
    /// They stay in the cascades, and cast twice. To compare.
    Keep,
}
