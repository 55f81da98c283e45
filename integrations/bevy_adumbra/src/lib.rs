//! Baked sun shadows of a whole static world for Bevy: one look-up for any point, sharp at every distance,
//! from a file of a few megabytes.
//!
//! ```no_run
//! use bevy::prelude::*;
//! use bevy_adumbra::prelude::*;
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
//!     commands.spawn((WorldAssetRoot(assets.load("city.glb#Scene0")), ShadowStatic));
//! }
//! ```
//!
//! Every material that calls `apply_pbr_lighting` receives these shadows, and so does volumetric fog. Meshes
//! that are not below a [`ShadowStatic`] go on casting through Bevy's cascades; without any such mesh, no
//! depth pass is drawn.
//!
//! | module | what it does |
//! |---|---|
//! | [`prelude`] | what most apps need |
//! | `file` | the asset and its loader |
//! | `shaders`, `patch` | the WGSL of look-ups, and the places in Bevy's shaders that call it |
//! | `in_use`, `placing`, `lights`, `align` | which files are in use, and where; lights are kept at their sun |
//! | `source`, `stream` | files that are streamed: where from, and what is resident of them |
//! | `status`, `error` | what a light's shadows come from, and why not from its files |
//! | `systems` | where the plugin's systems run |
//! | `moving` | the keys of a sun that moves |
//! | `limits` | what the device allows |
//! | `statics` | which meshes are in the files, and how they leave the cascades |
//! | `texels`, `pools`, `encode`, `gpu` | the texture with the files' words |
//! | `gltf` | lights of glTF files that name their file (feature `gltf`) |
//! | `bake` | baking while the app runs (feature `bake`) |
//! | `processor` | baking as an asset step (feature `processor`) |
//!
//! If a file cannot be used, Bevy's own shadows take over in the same frame, and [`BakedShadowStatus`] says
//! why.

mod align;
#[cfg(feature = "bake")]
mod bake;
mod components;
mod encode;
mod error;
mod file;
#[cfg(feature = "gltf")]
mod gltf;
mod gpu;
mod in_use;
mod layout;
mod lights;
mod limits;
mod moving;
mod patch;
mod placing;
mod pools;
pub mod prelude;
#[cfg(feature = "processor")]
mod processor;
mod shaders;
mod source;
mod statics;
mod status;
mod stream;
mod systems;
mod texels;
#[cfg(any(feature = "bake", feature = "processor"))]
mod threads;
mod warnings;

use bevy::app::{App, Plugin, PostUpdate, PreUpdate};
use bevy::asset::{AssetApp, AssetEventSystems, AssetServer, Assets};
use bevy::ecs::schedule::IntoScheduleConfigs;
use bevy::ecs::system::IntoSystem;
use bevy::light::SimulationLightSystems;
use bevy::pbr::prepare_lights;
use bevy::render::renderer::RenderDevice;
use bevy::render::{ExtractSchedule, GpuResourceAppExt, Render, RenderApp, RenderSystems};
use bevy::shader::Shader;

#[cfg(feature = "bake")]
pub use bake::{BakeError, BakeProgress, BakeSettings, RuntimeBake, RuntimeBakeCommands};
pub use components::{
    BakedShadow, ExcludeFromBake, FileRoot, IncludedInBake, ShadowBias, ShadowFilter, ShadowStatic,
    StaticCasters,
};
pub use error::{BakedShadowError, SharedError};
pub use file::{BakedShadowFile, ShadowFileError, ShadowFileLoader, ShadowFileSettings};
pub use limits::DeviceLimits;
pub use moving::SunKeys;
#[cfg(feature = "processor")]
pub use processor::{AssetBake, AssetBakeError, AssetBakeLoader, ShadowFileSaver};
pub use source::StreamSource;
pub use statics::CascadeCasters;
pub use status::{BakedShadowChanged, BakedShadowStatus};
pub use stream::{ShadowStreams, StreamBudget, StreamDiagnostics};
pub use systems::AdumbraSystems;

/// Registers the public types for reflection. Bevy registers types automatically only with its feature
/// `reflect_auto_register`.
fn register_types(app: &mut App) {
    app.register_type::<BakedShadow>()
        .register_type::<BakedShadowStatus>()
        .register_type::<BakedShadowChanged>()
        .register_type::<ShadowStatic>()
        .register_type::<ExcludeFromBake>()
        .register_type::<IncludedInBake>()
        .register_type::<FileRoot>()
        .register_type::<StaticCasters>()
        .register_type::<CascadeCasters>()
        .register_type::<StreamSource>()
        .register_type::<StreamBudget>()
        .register_type::<DeviceLimits>();
    #[cfg(feature = "bake")]
    app.register_type::<RuntimeBake>().register_type::<BakeProgress>();
}

/// Adds baked shadows to an app. Add it after `DefaultPlugins`.
#[derive(Clone, Debug, Default)]
pub struct AdumbraPlugin;

impl Plugin for AdumbraPlugin {
    fn build(&self, app: &mut App) {
        if !app.world().contains_resource::<AssetServer>() {
            bevy::log::error!(
                "AdumbraPlugin does nothing, because there are no assets; add it after DefaultPlugins"
            );
            return;
        }
        register_types(app);
        app.init_asset::<BakedShadowFile>()
            .register_asset_reflect::<BakedShadowFile>()
            .preregister_asset_loader::<ShadowFileLoader>(&ShadowFileLoader::EXTENSIONS);
        #[cfg(feature = "processor")]
        app.preregister_asset_loader::<AssetBakeLoader>(&AssetBakeLoader::EXTENSIONS)
            .register_asset_processor(processor::AssetBakeProcess::from(ShadowFileSaver))
            .set_default_asset_processor::<processor::AssetBakeProcess>("shadow.ron");
        app.init_resource::<DeviceLimits>()
            .init_resource::<StaticCasters>()
            .init_resource::<CascadeCasters>()
            .init_resource::<in_use::FilesInUse>()
            .init_resource::<statics::RestingLights>()
            .init_resource::<placing::Rooted>()
            .init_resource::<StreamBudget>()
            .init_resource::<ShadowStreams>()
            .init_resource::<stream::PoolUploads>();
        StreamDiagnostics::register(app);
        let Some(mut shaders) = app.world_mut().get_resource_mut::<Assets<Shader>>() else {
            // For example, on a server.
            bevy::log::info!("AdumbraPlugin draws nothing, because there is no renderer before it");
            return;
        };
        let patch = patch::ShaderPatch::new(&mut shaders);
        systems::order(app);
        app.insert_resource(patch)
            .add_systems(PreUpdate, patch::patch_shaders.in_set(AdumbraSystems::PatchShaders))
            .add_systems(
                PostUpdate,
                (
                    (placing::note_roots, align::give_back, align::align_lights)
                        .chain()
                        .in_set(AdumbraSystems::AlignLights),
                    statics::mark_meshes.in_set(AdumbraSystems::MarkStatics),
                    (stream::drive_streams, moving::write_keys).chain().in_set(AdumbraSystems::Stream),
                    (
                        lights::find_files_in_use,
                        warnings::warn_of_movers,
                        warnings::find_moved_root.pipe(warnings::warn_of_moved_root),
                    )
                        .chain()
                        .in_set(AdumbraSystems::ApplyFiles),
                    statics::skip_cascades
                        .after(SimulationLightSystems::UpdateDirectionalLightCascades)
                        .before(SimulationLightSystems::UpdateLightFrusta),
                    // Before shaders are extracted, so that they change in the same frame in which a light
                    // needs a way.
                    lights::add_ways.before(AssetEventSystems),
                    statics::leave_out.in_set(AdumbraSystems::LeaveCascades),
                ),
            );
        #[cfg(feature = "gltf")]
        app.add_systems(PreUpdate, gltf::attach_files.in_set(AdumbraSystems::AttachFiles));
        #[cfg(feature = "bake")]
        app.add_observer(bake::pause_bakes)
            .init_resource::<bake::StaticKeys>()
            .init_resource::<bake::AssetVersions>()
            .add_systems(
                PostUpdate,
                (
                    bake::count_changes,
                    bake::find_meshes,
                    bake::bake_shadows,
                    bake::follow_suns,
                    bake::mark_changes,
                )
                    .chain()
                    .in_set(AdumbraSystems::Bake),
            );
        let Some(render) = app.get_sub_app_mut(RenderApp) else { return };
        render
            // Recreated if the device is lost.
            .init_gpu_resource::<gpu::WordTextures>()
            .init_resource::<DeviceLimits>()
            .init_resource::<gpu::ExtractedFiles>()
            .init_resource::<pools::Pools>()
            .init_resource::<statics::RestingLights>()
            .add_systems(
                ExtractSchedule,
                (gpu::extract_files, pools::extract_pools, statics::extract_resting)
                    .in_set(AdumbraSystems::Upload),
            )
            .add_systems(
                Render,
                statics::rest_cascades.before(prepare_lights).in_set(RenderSystems::CreateViews),
            )
            // After Bevy's own transmission textures, and before bind groups.
            .add_systems(
                Render,
                gpu::give_words
                    .in_set(AdumbraSystems::Upload)
                    .in_set(RenderSystems::PrepareResourcesCollectPhaseBuffers),
            );
    }

    /// Registers the loaders, which need the limits of the device. The device is known by now.
    fn finish(&self, app: &mut App) {
        if !app.world().contains_resource::<DeviceLimits>() {
            return;
        }
        if let Some(limits) = app.world().get_resource::<RenderDevice>().map(DeviceLimits::from) {
            app.insert_resource(limits);
            if let Some(render) = app.get_sub_app_mut(RenderApp) {
                render.insert_resource(limits);
            }
        }
        let limits = *app.world().resource::<DeviceLimits>();
        app.register_asset_loader(ShadowFileLoader::new(limits));
        #[cfg(feature = "processor")]
        app.register_asset_loader(AssetBakeLoader::new(limits));
    }
}
