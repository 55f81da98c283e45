//! Where the plugin's systems run.

use bevy::app::{AnimationSystems, App, PostUpdate};
use bevy::camera::visibility::VisibilitySystems;
use bevy::ecs::prelude::*;
use bevy::light::SimulationLightSystems;
use bevy::transform::TransformSystems;

/// Where the plugin's systems run, so that an app can order its own against them.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub enum AdumbraSystems {
    /// Bevy's shaders get their look-ups. In `PreUpdate`.
    PatchShaders,
    /// Lights of glTF files get the files that they name. In `PreUpdate`, with the feature `gltf`.
    AttachFiles,
    /// Lights turn to the suns of their files. In `PostUpdate`, before [`TransformSystems::Propagate`].
    AlignLights,
    /// Meshes below a [`ShadowStatic`](crate::ShadowStatic) get [`IncludedInBake`](crate::IncludedInBake),
    /// others lose it. In `PostUpdate`.
    MarkStatics,
    /// Bakes start, and finished files are put on their lights. In `PostUpdate`, after
    /// [`TransformSystems::Propagate`] and [`AdumbraSystems::MarkStatics`], with the feature `bake`.
    Bake,
    /// Streamed files take the views of cameras, and the data that has been read. In `PostUpdate`, after
    /// [`VisibilitySystems::UpdateFrusta`] and before [`AdumbraSystems::ApplyFiles`].
    Stream,
    /// Loaded files are applied to their lights. After that, [`BakedShadowStatus`](crate::BakedShadowStatus)
    /// is up to date for this frame. In `PostUpdate`, after [`AdumbraSystems::Bake`] and before
    /// [`SimulationLightSystems::UpdateDirectionalLightCascades`].
    ApplyFiles,
    /// Meshes in the files leave the cascades. After that, [`CascadeCasters`](crate::CascadeCasters) is up to
    /// date for this frame. In `PostUpdate`, after [`SimulationLightSystems::CheckLightVisibility`].
    LeaveCascades,
    /// Files in use go to the device. In the render world's `ExtractSchedule`, and in `Render` in
    /// [`RenderSystems::PrepareResourcesCollectPhaseBuffers`](bevy::render::RenderSystems).
    Upload,
}

/// Orders the sets of `PostUpdate`.
pub(crate) fn order(app: &mut App) {
    app.configure_sets(
        PostUpdate,
        (
            // Animations turn roots, and parents of lights.
            AdumbraSystems::AlignLights.after(AnimationSystems).before(TransformSystems::Propagate),
            (AdumbraSystems::MarkStatics, AdumbraSystems::Bake, AdumbraSystems::ApplyFiles).chain(),
            AdumbraSystems::Bake.after(TransformSystems::Propagate),
            AdumbraSystems::Stream.after(VisibilitySystems::UpdateFrusta).before(AdumbraSystems::ApplyFiles),
            AdumbraSystems::ApplyFiles
                .after(TransformSystems::Propagate)
                .before(SimulationLightSystems::UpdateDirectionalLightCascades),
            AdumbraSystems::LeaveCascades.after(SimulationLightSystems::CheckLightVisibility),
        ),
    );
}
