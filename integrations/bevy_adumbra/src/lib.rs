//! Baked sun shadows of a whole static world for Bevy: one look-up for any point, sharp at every distance, from a file
//! of a few megabytes.
//!
//! ```no_run
//! use bevy::prelude::*;
//! use bevy_adumbra::{AdumbraPlugin, BakedShadow, BakedStatic};
//!
//! fn main() {
//!     App::new().add_plugins((DefaultPlugins, AdumbraPlugin)).add_systems(Startup, setup).run();
//! }
//!
//! fn setup(mut commands: Commands, assets: Res<AssetServer>) {
//!     commands.spawn((
//!         DirectionalLight { shadow_maps_enabled: true, ..default() },
//!         BakedShadow::new(assets.load("city.adumbra")),
//!     ));
//!     commands.spawn((WorldAssetRoot(assets.load("city.glb#Scene0")), BakedStatic));
//! }
//! ```
//!
//! Every material that calls `apply_pbr_lighting` receives these shadows, and so does volumetric fog. Meshes that are not
//! below a [`BakedStatic`] go on casting through Bevy's cascades; a world without any makes no depth pass.
//!
//! | module | what it does |
//! |---|---|
//! | `file` | the asset and its loader |
//! | `shaders`, `patch` | the WGSL of look-ups, and the places in Bevy's shaders that call it |
//! | `lights` | which files are in use |
//! | `statics` | which meshes are in the files, and how they leave the cascades |
//! | `gpu` | the texture with the files' words |
//! | `gltf` | lights of glTF files that name their file (feature `gltf`) |
//! | `bake` | baking while the app runs (feature `bake`) |
//! | `processor` | baking as an asset step (feature `processor`) |
//!
//! Whatever cannot work falls back to Bevy's own shadows in the same frame and says why: see [`BakedShadowStatus`].

#[cfg(feature = "bake")]
mod bake;
mod components;
mod file;
#[cfg(feature = "gltf")]
mod gltf;
mod gpu;
mod lights;
mod patch;
#[cfg(feature = "processor")]
mod processor;
mod shaders;
mod statics;
#[cfg(any(feature = "bake", feature = "processor"))]
mod threads;

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use bevy::app::{App, Plugin, PostUpdate, PreUpdate};
use bevy::asset::{AssetApp, Assets};
use bevy::ecs::schedule::IntoScheduleConfigs;
use bevy::light::SimulationLightSystems;
use bevy::render::renderer::RenderDevice;
use bevy::render::{ExtractSchedule, Render, RenderApp, RenderSystems};
use bevy::shader::Shader;
use bevy::transform::TransformSystems;

#[cfg(feature = "bake")]
pub use bake::{BakeProgress, BakeSettings, BakeShadow, BakeShadowCommands};
pub use components::{
    BakedShadow, BakedShadowChanged, BakedShadowStatus, BakedStatic, InBake, NotBaked, StaticCasters,
};
pub use file::{BakedShadowFile, ShadowFileError, ShadowFileLoader, ShadowFileSettings};
#[cfg(feature = "processor")]
pub use processor::{ShadowBake, ShadowBakeError, ShadowBakeLoader, ShadowFileSaver};
pub use statics::CascadeCasters;

/// Texels that every device allows along a side of a texture.
const MIN_MAX_TEXTURE_SIDE: u32 = 8192;

/// Adds baked shadows to an app. It goes after `DefaultPlugins`.
#[derive(Clone, Debug, Default)]
pub struct AdumbraPlugin;

/// Texels that the device allows along a side of a texture. It is known once there is a device.
#[derive(bevy::ecs::resource::Resource, Clone)]
struct MaxTextureSide(Arc<AtomicU32>);

impl MaxTextureSide {
    #[cfg(feature = "bake")]
    fn get(&self) -> u32 {
        self.0.load(Ordering::Relaxed)
    }
}

impl Plugin for AdumbraPlugin {
    fn build(&self, app: &mut App) {
        let max_side = MaxTextureSide(Arc::new(AtomicU32::new(MIN_MAX_TEXTURE_SIDE)));
        app.init_asset::<BakedShadowFile>()
            .register_asset_loader(ShadowFileLoader::new(Arc::clone(&max_side.0)));
        #[cfg(feature = "processor")]
        app.register_asset_loader(ShadowBakeLoader::new(Arc::clone(&max_side.0)))
            .register_asset_processor(processor::ShadowBakeProcess::from(ShadowFileSaver))
            .set_default_asset_processor::<processor::ShadowBakeProcess>("shadow.ron");
        app.insert_resource(max_side)
            .init_resource::<StaticCasters>()
            .init_resource::<CascadeCasters>()
            .init_resource::<lights::FilesInUse>();
        let Some(mut shaders) = app.world_mut().get_resource_mut::<Assets<Shader>>() else {
            bevy::log::error!(
                "AdumbraPlugin draws nothing, because there is no renderer; add it after DefaultPlugins"
            );
            return;
        };
        let patch = patch::ShaderPatch::new(&mut shaders);
        app.insert_resource(patch).add_systems(PreUpdate, patch::patch_shaders).add_systems(
            PostUpdate,
            (
                statics::mark_meshes,
                lights::align_lights.before(TransformSystems::Propagate),
                (
                    lights::find_files_in_use,
                    lights::add_ways,
                    statics::warn_of_movers,
                    statics::rest_cascades,
                )
                    .chain()
                    .after(TransformSystems::Propagate)
                    .after(statics::mark_meshes)
                    .before(SimulationLightSystems::UpdateDirectionalLightCascades),
                statics::leave_out.after(SimulationLightSystems::CheckLightVisibility),
            ),
        );
        #[cfg(feature = "gltf")]
        app.add_systems(PreUpdate, gltf::attach_files);
        #[cfg(feature = "bake")]
        app.init_resource::<bake::StaticKeys>().add_systems(
            PostUpdate,
            (bake::find_meshes, bake::bake_shadows, bake::mark_changes)
                .chain()
                .after(TransformSystems::Propagate)
                .after(statics::mark_meshes)
                .before(lights::find_files_in_use),
        );
        let Some(render) = app.get_sub_app_mut(RenderApp) else { return };
        render
            .init_resource::<gpu::ExtractedFiles>()
            .init_resource::<gpu::WordTextures>()
            .add_systems(ExtractSchedule, gpu::extract_files)
            // After Bevy's own transmission textures, and before bind groups.
            .add_systems(Render, gpu::give_words.in_set(RenderSystems::PrepareResourcesCollectPhaseBuffers));
    }

    fn finish(&self, app: &mut App) {
        let Some(device) = app.world().get_resource::<RenderDevice>() else { return };
        let side = device.limits().max_texture_dimension_2d;
        app.world().resource::<MaxTextureSide>().0.store(side, Ordering::Relaxed);
        if let Some(mut patch) = app.world_mut().get_resource_mut::<patch::ShaderPatch>() {
            patch.set_max_rows(side);
        }
    }
}
