//! The plugin in an app without a renderer: needs no GPU.

use std::any::TypeId;
use std::path::Path;

use adumbra::stream::BytesSource;
use bevy::asset::AssetPlugin;
use bevy::ecs::entity::EntityHashMap;
use bevy::ecs::reflect::AppTypeRegistry;
use bevy::prelude::*;
use bevy::reflect::{TypeData, TypeRegistry};
use bevy::world_serialization::DynamicWorldBuilder;
use bevy::world_serialization::serde::WorldDeserializer;
use bevy_adumbra::prelude::*;
use bevy_adumbra::{CascadeCasters, DeviceLimits, IncludedInBake, StaticCasters};
use serde::de::DeserializeSeed;

fn has<T: 'static, D: TypeData>(registry: &TypeRegistry) -> bool {
    registry.get_type_data::<D>(TypeId::of::<T>()).is_some()
}

#[test]
fn components_and_resources_are_registered() {
    let mut app = App::new();
    // Start with an empty registry: the default one registers types automatically here, but not in every app.
    app.insert_resource(AppTypeRegistry::default());
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), AdumbraPlugin));
    let registry = app.world().resource::<AppTypeRegistry>().read();
    assert!(has::<BakedShadow, ReflectComponent>(&registry));
    assert!(has::<BakedShadowStatus, ReflectComponent>(&registry));
    assert!(has::<ShadowStatic, ReflectComponent>(&registry));
    assert!(has::<ExcludeFromBake, ReflectComponent>(&registry));
    assert!(has::<IncludedInBake, ReflectComponent>(&registry));
    assert!(has::<BakedShadowChanged, ReflectEvent>(&registry));
    assert!(has::<StaticCasters, ReflectResource>(&registry));
    assert!(has::<CascadeCasters, ReflectResource>(&registry));
    assert!(has::<DeviceLimits, ReflectResource>(&registry));
    assert!(has::<StreamBudget, ReflectResource>(&registry));
    #[cfg(feature = "bake")]
    {
        assert!(has::<RuntimeBake, ReflectComponent>(&registry));
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

fn count(in_bake: Query<(), With<IncludedInBake>>, mut marked: ResMut<Marked>) {
    marked.0.push(in_bake.iter().count());
}

/// Returns an app with the renderer's assets that the plugin needs.
fn with_assets() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default()))
        .init_asset::<Shader>()
        .init_asset::<Mesh>()
        .init_asset::<Image>()
        .init_asset::<StandardMaterial>()
        .add_plugins(AdumbraPlugin);
    app
}

#[test]
fn app_systems_can_be_ordered_against_the_plugin() {
    let mut app = with_assets();
    app.init_resource::<Marked>().add_systems(
        PostUpdate,
        (count.before(AdumbraSystems::MarkStatics), count.after(AdumbraSystems::MarkStatics)),
    );
    app.finish();
    app.cleanup();
    app.world_mut().spawn((Mesh3d::default(), ShadowStatic));
    app.update();
    assert_eq!(app.world().resource::<Marked>().0, [0, 1]);
}

#[test]
fn marks_a_mesh_in_the_frame_in_which_it_becomes_static() {
    let mut app = with_assets();
    app.finish();
    app.cleanup();
    let [house, other] = [0, 1].map(|_| app.world_mut().spawn(Mesh3d::default()).id());
    let mut marked = |change: &dyn Fn(&mut World)| {
        change(app.world_mut());
        app.update();
        [house, other].map(|mesh| app.world().get::<IncludedInBake>(mesh).is_some())
    };
    assert_eq!(marked(&|_| {}), [false, false]);
    assert_eq!(marked(&|world| _ = world.entity_mut(house).insert(ShadowStatic)), [true, false]);
    assert_eq!(marked(&|world| _ = world.entity_mut(house).remove::<ShadowStatic>()), [false, false]);
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

#[test]
fn saves_and_loads_a_world_with_lights_in_any_state() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), AdumbraPlugin));
    let light = app.world_mut().spawn(BakedShadow::streamed("world.adumbra")).id();
    app.world_mut().entity_mut(light).insert(BakedShadowStatus::Unusable(BakedShadowError::NoShadowMaps));
    #[cfg(feature = "bake")]
    app.world_mut().entity_mut(light).insert(BakeProgress::Failed(BakeError::NoTriangles));
    #[cfg(feature = "bake")]
    app.world_mut().entity_mut(light).insert(RuntimeBake::default());
    let root =
        app.world_mut().spawn((FileRoot::streamed(Path::new("folder/world.adumbra")), ShadowStatic)).id();
    let registry = app.world().resource::<AppTypeRegistry>().clone();
    let types = registry.read();
    let saved = DynamicWorldBuilder::from_world(app.world(), &types);
    let text = saved.extract_entities([light, root].into_iter()).build().serialize(&types).unwrap();
    assert!(text.contains("set DirectionalLight::shadow_maps_enabled"), "{text}");

    let loaded = WorldDeserializer {
        type_registry: &types,
        load_from_path: &mut app.world().resource::<AssetServer>(),
    };
    let loaded = loaded.deserialize(&mut ron::Deserializer::from_str(&text).unwrap()).unwrap();
    drop(types);
    let (mut new, mut entities) = (World::new(), EntityHashMap::default());
    new.insert_resource(registry.clone());
    loaded.write_to_world(&mut new, &mut entities).unwrap();
    let [light, root] = [light, root].map(|entity| entities[&entity]);
    assert_eq!(new.get::<BakedShadow>(light).unwrap().streams, ["world.adumbra".into()]);
    assert_eq!(new.get::<FileRoot>(root), Some(&FileRoot::streamed(Path::new("folder/world.adumbra"))));
    assert!(new.get::<Transform>(root).is_some(), "a root has a place");
    assert_eq!(new.get::<BakedShadowStatus>(light), Some(&BakedShadowStatus::Waiting));
    #[cfg(feature = "bake")]
    assert_eq!(new.get::<BakeProgress>(light), Some(&BakeProgress::Waiting));
    assert!(new.get::<ShadowStatic>(root).is_some());

    // The error for a custom source says what to do.
    let own = StreamSource::ranges(BytesSource(Vec::new()));
    let light = app.world_mut().spawn(BakedShadow::streamed(own)).id();
    let types = registry.read();
    let saved = DynamicWorldBuilder::from_world(app.world(), &types).extract_entities([light].into_iter());
    let error = saved.build().serialize(&types).unwrap_err().to_string();
    assert!(error.contains("leave its component out"), "{error}");
}
