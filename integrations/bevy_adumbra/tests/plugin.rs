//! The plugin in an app without a renderer: needs no GPU.

use std::any::TypeId;

use bevy::asset::AssetPlugin;
use bevy::ecs::reflect::AppTypeRegistry;
use bevy::prelude::*;
use bevy::reflect::{TypeData, TypeRegistry};
use bevy_adumbra::prelude::*;
use bevy_adumbra::{CascadeCasters, DeviceLimits, InBake, StaticCasters};

fn has<T: 'static, D: TypeData>(registry: &TypeRegistry) -> bool {
    registry.get_type_data::<D>(TypeId::of::<T>()).is_some()
}

#[test]
fn components_and_resources_are_registered() {
    let mut app = App::new();
    // The registry of these tests would find types by itself, and that of an app need not.
    app.insert_resource(AppTypeRegistry::default());
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), AdumbraPlugin));
    let registry = app.world().resource::<AppTypeRegistry>().read();
    assert!(has::<BakedShadow, ReflectComponent>(&registry));
    assert!(has::<BakedShadowStatus, ReflectComponent>(&registry));
    assert!(has::<BakedStatic, ReflectComponent>(&registry));
    assert!(has::<NotBaked, ReflectComponent>(&registry));
    assert!(has::<InBake, ReflectComponent>(&registry));
    assert!(has::<BakedShadowChanged, ReflectEvent>(&registry));
    assert!(has::<StaticCasters, ReflectResource>(&registry));
    assert!(has::<CascadeCasters, ReflectResource>(&registry));
    assert!(has::<DeviceLimits, ReflectResource>(&registry));
    assert!(has::<StreamBudget, ReflectResource>(&registry));
    #[cfg(feature = "bake")]
    {
        assert!(has::<BakeShadow, ReflectComponent>(&registry));
        assert!(has::<BakeProgress, ReflectComponent>(&registry));
    }
}

#[test]
fn a_status_survives_reflection() {
    let unusable = BakedShadowStatus::Unusable(BakedShadowError::TooManyFiles { limit: 8 });
    for status in [BakedShadowStatus::Active { files: 2 }, unusable] {
        assert_eq!(BakedShadowStatus::from_reflect(&*status.to_dynamic()), Some(status));
    }
}

/// How many meshes were marked when each of the app's systems ran.
#[derive(Resource, Default)]
struct Marked(Vec<usize>);

fn count(in_bake: Query<(), With<InBake>>, mut marked: ResMut<Marked>) {
    marked.0.push(in_bake.iter().count());
}

#[test]
fn systems_of_an_app_are_ordered_against_the_plugins() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default()))
        .init_asset::<Shader>()
        .init_asset::<Mesh>()
        .init_asset::<Image>()
        .init_asset::<StandardMaterial>()
        .add_plugins(AdumbraPlugin)
        .init_resource::<Marked>()
        .add_systems(
            PostUpdate,
            (count.before(AdumbraSystems::MarkStatics), count.after(AdumbraSystems::MarkStatics)),
        );
    app.finish();
    app.cleanup();
    app.world_mut().spawn((Mesh3d::default(), BakedStatic));
    app.update();
    assert_eq!(app.world().resource::<Marked>().0, [0, 1]);
}

#[test]
fn without_assets_or_a_renderer_nothing_is_done_and_nothing_panics() {
    let mut before = App::new();
    before.add_plugins(AdumbraPlugin).add_plugins((MinimalPlugins, AssetPlugin::default()));
    let mut server = App::new();
    server.add_plugins((MinimalPlugins, AssetPlugin::default(), AdumbraPlugin));
    for mut app in [before, server] {
        app.finish();
        app.cleanup();
        let light = app.world_mut().spawn((DirectionalLight::default(), BakedShadow::default())).id();
        app.update();
        assert_eq!(app.world().get::<BakedShadowStatus>(light), Some(&BakedShadowStatus::Waiting));
    }
}
