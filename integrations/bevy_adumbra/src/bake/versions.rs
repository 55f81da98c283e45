//! Versions of meshes, materials and images. An asset that loads or that the app changes in place keeps its
//! handle, but a bake would see different data.

use std::collections::HashMap;

use bevy::asset::{Asset, AssetEvent, AssetId, UntypedAssetId};
use bevy::ecs::message::MessageReader;
use bevy::ecs::prelude::*;
use bevy::ecs::system::SystemParam;
use bevy::image::Image;
use bevy::mesh::Mesh;
use bevy::pbr::StandardMaterial;

/// How often assets of bakes were changed.
#[derive(Resource, Default)]
pub(crate) struct AssetVersions {
    /// Versions of the assets that a bake reads. Other assets are not tracked.
    versions: HashMap<UntypedAssetId, u32>,
    /// Counts all changes.
    changes: u64,
}

impl AssetVersions {
    /// Returns how often an asset was changed, and tracks it from now on.
    pub(super) fn of(&mut self, id: impl Into<UntypedAssetId>) -> u32 {
        *self.versions.entry(id.into()).or_default()
    }

    /// Returns how often any tracked asset was changed.
    pub(super) fn changes(&self) -> u64 {
        self.changes
    }

    fn count<A: Asset>(&mut self, events: &mut MessageReader<AssetEvent<A>>) {
        for event in events.read() {
            // An added asset counts as a change: earlier bakes did not have it.
            let (AssetEvent::Modified { id } | AssetEvent::Added { id }) = event else { continue };
            let id: AssetId<A> = *id;
            if let Some(version) = self.versions.get_mut(&id.into()) {
                *version += 1;
                self.changes += 1;
            }
        }
    }
}

/// Changes of the assets that a bake reads.
#[derive(SystemParam)]
pub(crate) struct AssetChanges<'w, 's> {
    meshes: MessageReader<'w, 's, AssetEvent<Mesh>>,
    materials: MessageReader<'w, 's, AssetEvent<StandardMaterial>>,
    images: MessageReader<'w, 's, AssetEvent<Image>>,
}

/// Updates [`AssetVersions`].
pub(crate) fn count_changes(mut changes: AssetChanges, mut versions: ResMut<AssetVersions>) {
    // Do not mark the resource as changed in every frame.
    let versions = versions.bypass_change_detection();
    versions.count(&mut changes.meshes);
    versions.count(&mut changes.materials);
    versions.count(&mut changes.images);
}
