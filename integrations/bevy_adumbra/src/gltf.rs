//! Lights of glTF files that name their shadow file.
//!
//! A directional light of `KHR_lights_punctual` may have `extras: {"adumbra": {"shadow": "city.adumbra",
//! "filter": 5}}`. The path is relative to the glTF file, and the filter is its width in texels. `adumbra
//! bake --link-in city.glb` writes it.

use adumbra::Filter;
use bevy::asset::{AssetPath, AssetServer};
use bevy::ecs::prelude::*;
use bevy::gltf::GltfExtras;
use bevy::log::warn;
use bevy::prelude::{ChildOf, DirectionalLight, WorldAssetRoot};
use serde::Deserialize;
use serde_json::Number;

use crate::components::BakedShadow;

/// The extras of a light, as far as they matter here.
#[derive(Deserialize)]
struct Extras {
    adumbra: Option<Shadow>,
}

#[derive(Deserialize)]
struct Shadow {
    shadow: Option<String>,
    filter: Option<Number>,
}

/// Gives lights of glTF files the shadow files that they name.
pub(crate) fn attach_files(
    mut commands: Commands,
    mut lights: Query<
        (Entity, &GltfExtras, &mut DirectionalLight),
        (Or<(Added<GltfExtras>, Added<DirectionalLight>)>, Without<BakedShadow>),
    >,
    parents: Query<&ChildOf>,
    roots: Query<&WorldAssetRoot>,
    server: Res<AssetServer>,
) {
    for (entity, extras, mut light) in &mut lights {
        // Skip extras of other kinds.
        let Ok(Extras { adumbra: Some(Shadow { shadow: Some(name), filter }) }) =
            serde_json::from_str::<Extras>(&extras.value)
        else {
            continue;
        };
        let root = parents.iter_ancestors(entity).find_map(|ancestor| roots.get(ancestor).ok());
        let Some(scene) = root.and_then(|root| root.0.path()) else {
            warn!(
                "light {entity} names the shadow file {name:?}, but is below no WorldAssetRoot that says where it is"
            );
            continue;
        };
        let path: AssetPath = match scene.resolve_embed_str(&name) {
            Ok(path) => path,
            Err(error) => {
                warn!("the shadow file {name:?} of a light in {scene} is no path: {error}");
                continue;
            }
        };
        light.shadow_maps_enabled = true;
        let mut shadow = BakedShadow::new(server.load(path));
        if let Some(width) = filter {
            match filter_of_width(&width) {
                Some(filter) => shadow.filter = filter.into(),
                None => warn!(
                    "light {entity} in {scene} names a filter {width} texels wide, and the widths are {:?}; it has the \
                     default, {}",
                    Filter::ALL.map(Filter::width),
                    Filter::default().width()
                ),
            }
        }
        commands.entity(entity).insert(shadow);
    }
}

/// Returns the filter of this width, or `None` if no filter has it.
fn filter_of_width(width: &Number) -> Option<Filter> {
    let width = u32::try_from(width.as_u64()?).ok()?;
    Filter::try_from(width).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn accepts_only_existing_filter_widths() {
        let filter = |extras: &str| {
            let extras: Extras = serde_json::from_str(extras).unwrap();
            filter_of_width(&extras.adumbra.unwrap().filter.unwrap())
        };
        assert_eq!(filter(r#"{"adumbra": {"shadow": "a.adumbra", "filter": 9}}"#), Some(Filter::Box9));
        for wrong in ["4", "0", "-1", "2.5", "4294967301"] {
            assert_eq!(filter(&format!(r#"{{"adumbra": {{"filter": {wrong}}}}}"#)), None, "{wrong}");
        }
    }
}
