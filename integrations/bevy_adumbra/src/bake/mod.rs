//! Baking while the app runs: gather meshes, bake on separate threads, swap files.
//!
//! A [`RuntimeBake`] on a light requests a bake, and so does [`RuntimeBakeCommands::bake_shadow`]. The meshes
//! below [`ShadowStatic`](crate::ShadowStatic) are copied once per bake. A coarse file comes first, then the
//! file of the requested resolution; each replaces the previous file in a single frame. After a mesh moves,
//! its shadow comes from the cascades until a new bake is done. After the light turns, all shadows do. The
//! new bake recomputes only the blocks that the change touches; the other blocks are kept in memory, in about
//! as many bytes as the file.
//!
//! For a light that is followed ([`BakedShadow::follow_sun`](crate::BakedShadow::follow_sun)), keys are baked
//! ahead of the light in place of a file.

mod follow;
mod gather;
mod job;
mod progress;
mod versions;

use std::sync::Arc;
use std::time::Duration;

use adumbra_bake::MemoryCache;
use bevy::asset::Assets;
use bevy::camera::visibility::VisibilityRange;
use bevy::ecs::entity::EntityHashMap;
use bevy::ecs::entity_disabling::Disabled;
use bevy::ecs::prelude::*;
use bevy::light::NotShadowCaster;
use bevy::log::{info, warn};
use bevy::math::Vec3;
use bevy::mesh::Mesh3d;
use bevy::pbr::{MeshMaterial3d, StandardMaterial};
use bevy::prelude::{DirectionalLight, GlobalTransform};
use bevy::reflect::prelude::*;
use bevy::time::{Real, Time};

use crate::components::{BakedShadow, IncludedInBake};
use crate::statics::AwaitingBake;
use crate::{BakedShadowFile, DeviceLimits};
use follow::Following;
pub(crate) use follow::follow_suns;
use gather::{Placed, SceneAssets, gather};
use job::{Finished, Job};
pub use progress::{BakeError, BakeProgress};
pub(crate) use versions::{AssetVersions, count_changes};

/// Settings of a bake while the app runs.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Default, Clone, Debug, PartialEq)]
pub struct BakeSettings {
    /// Texels on the longest side of the world as the sun sees it, a power of two from 8 to 262,144.
    pub resolution: u32,
    /// Resolution of a coarse file that is baked first. If it is not less than `resolution`, no coarse file
    /// is baked. It does not apply to a light that is followed: the first key has an eighth of `resolution`.
    pub first_resolution: u32,
    /// How far below an open surface its shadow may begin, world units. More makes smaller files.
    pub thickness_world: f32,
    /// Worker threads. 0 stands for one less than the processor has; for a light that is followed, for one
    /// thread.
    pub threads: usize,
    /// How long meshes and light must be still before a bake begins.
    pub settle: Duration,
}

impl Default for BakeSettings {
    fn default() -> Self {
        Self {
            resolution: 8192,
            first_resolution: 2048,
            thickness_world: 0.0,
            threads: 0,
            settle: Duration::from_millis(500),
        }
    }
}

/// Bakes the shadow of this directional light, and again when meshes below a
/// [`ShadowStatic`](crate::ShadowStatic) or the light change. When no such mesh is left, the file is removed.
/// Removing this component cancels a bake that is under way; the last file stays in use. If the app removes
/// the [`BakedShadow`] that a bake has added, baking stops until
/// [`bake_shadow`](RuntimeBakeCommands::bake_shadow) is called again.
#[derive(Component, Debug, Default, Reflect)]
#[reflect(Component, Default, Debug)]
#[require(BakeProgress)]
pub struct RuntimeBake {
    /// The settings. A change of them bakes again.
    pub settings: BakeSettings,
    // Work under way is not data, so reflection ignores the remaining fields.
    /// The inputs of the newest bake. `job` is the bake itself while it is under way.
    #[reflect(ignore)]
    seen: Option<BakeInputs>,
    #[reflect(ignore)]
    job: Option<Job>,
    /// The follower that bakes keys ahead of the light, if the light is followed.
    #[reflect(ignore)]
    following: Option<Following>,
    /// Results of earlier bakes: after a change, only the blocks that it touches are baked.
    #[reflect(ignore)]
    cache: Arc<MemoryCache>,
    /// The current inputs if they differ from those of the newest bake, and the time of their last change.
    #[reflect(ignore)]
    pending: Option<(BakeInputs, Duration)>,
    /// Whether the app has removed the [`BakedShadow`].
    #[reflect(ignore)]
    is_paused: bool,
    /// The meshes in the file that is in use.
    #[reflect(ignore)]
    in_use: Option<Arc<Keys>>,
}

impl RuntimeBake {
    /// Bakes with these settings.
    pub fn new(settings: BakeSettings) -> Self {
        Self { settings, ..Self::default() }
    }

    /// Whether none of the meshes in the file in use is left. Without a file in use, the meshes of the newest
    /// bake count.
    fn has_lost_all(&self, now: &Keys) -> bool {
        let are_gone = |keys: &Keys| keys.keys().all(|entity| !now.contains_key(entity));
        let known = self.in_use.as_deref().or(self.seen.as_ref().map(|seen| &*seen.keys));
        known.is_some_and(are_gone)
    }
}

/// For each mesh in a bake: a hash of its geometry, transform and material.
type Keys = EntityHashMap<u64>;

/// The inputs of a bake.
#[derive(Clone, Debug)]
struct BakeInputs {
    settings: BakeSettings,
    towards_light: Vec3,
    keys: Arc<Keys>,
}

impl BakeInputs {
    /// Whether both give the same bake. Directions are compared with a tolerance, because a light that is set
    /// in every frame differs by rounding.
    fn is_like(&self, other: &Self) -> bool {
        (Arc::ptr_eq(&self.keys, &other.keys) || self.keys == other.keys)
            && self.settings == other.settings
            && self.towards_light.distance(other.towards_light) <= SAME_LIGHT
    }
}

/// Directions of a light are the same if their unit vectors are at most this far apart, 6e-4 degrees.
const SAME_LIGHT: f32 = 1e-5;

/// The meshes that a bake would see now.
#[derive(Resource, Default)]
pub(crate) struct StaticKeys {
    keys: Arc<Keys>,
    /// The value of [`AssetVersions::changes`] that the keys include.
    changes: u64,
}

/// Adds [`RuntimeBakeCommands::bake_shadow`] to `Commands`.
pub trait RuntimeBakeCommands {
    /// Bakes the shadow of a directional light while the app runs, with a [`RuntimeBake`]. An existing one
    /// gets the new settings.
    fn bake_shadow(&mut self, light: Entity, settings: BakeSettings);
}

impl RuntimeBakeCommands for Commands<'_, '_> {
    fn bake_shadow(&mut self, light: Entity, settings: BakeSettings) {
        // Keep the results of an existing bake.
        self.entity(light).queue_silenced(move |mut light: EntityWorldMut| {
            match light.get_mut::<RuntimeBake>() {
                Some(mut bake) => {
                    (bake.settings, bake.seen, bake.is_paused) = (settings, None, false);
                }
                None => _ = light.insert(RuntimeBake::new(settings)),
            }
        });
    }
}

/// The meshes that a bake sees.
type Meshes<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        &'static Mesh3d,
        &'static GlobalTransform,
        Option<&'static MeshMaterial3d<StandardMaterial>>,
        Has<NotShadowCaster>,
        Option<&'static VisibilityRange>,
    ),
    With<IncludedInBake>,
>;

/// Changes after which the keys may differ.
type Changes = (
    With<IncludedInBake>,
    Or<(
        Added<IncludedInBake>,
        Changed<Mesh3d>,
        Changed<GlobalTransform>,
        Changed<MeshMaterial3d<StandardMaterial>>,
        Changed<VisibilityRange>,
        Added<NotShadowCaster>,
    )>,
);

/// Updates [`StaticKeys`]. Cost: nothing while no mesh of a bake changes.
pub(crate) fn find_meshes(
    lights: Query<(), With<RuntimeBake>>,
    placed: Meshes,
    (changed, disabled, in_bake): (
        Query<(), Changes>,
        Query<(), (With<IncludedInBake>, Added<Disabled>)>,
        Query<(), With<IncludedInBake>>,
    ),
    (mut removed, mut enabled, mut no_casters, mut no_meshes, mut no_materials): (
        RemovedComponents<IncludedInBake>,
        RemovedComponents<Disabled>,
        RemovedComponents<NotShadowCaster>,
        RemovedComponents<Mesh3d>,
        RemovedComponents<MeshMaterial3d<StandardMaterial>>,
    ),
    materials: Res<Assets<StandardMaterial>>,
    (mut keys, mut versions): (ResMut<StaticKeys>, ResMut<AssetVersions>),
) {
    // Ignore entities outside of the bake: they lose components too.
    let others = no_casters.read().chain(no_meshes.read()).chain(no_materials.read()).chain(enabled.read());
    let has_changes = removed.read().count() + others.filter(|e| in_bake.contains(*e)).count() > 0
        || !changed.is_empty()
        || !disabled.is_empty()
        || keys.changes != versions.changes();
    if lights.is_empty() {
        // Clear the keys; they are rebuilt for the next light.
        if !keys.keys.is_empty() {
            keys.keys = Arc::default();
        }
        return;
    }
    if !has_changes && !keys.keys.is_empty() {
        return;
    }
    let mut key = |placed: Placed| placed.key(&materials, &mut versions);
    let new: Keys = placed.iter().map(|mesh| (mesh.0, key(mesh.into()))).collect();
    keys.changes = versions.changes();
    if *keys.keys != new {
        keys.keys = Arc::new(new);
    }
}

/// Pauses the bakes of a light whose [`BakedShadow`] the app has removed. It runs as an observer, so that the
/// app can ask again in the same frame.
pub(crate) fn pause_bakes(removed: On<Remove, BakedShadow>, mut lights: Query<&mut RuntimeBake>) {
    if let Ok(mut bake) = lights.get_mut(removed.entity) {
        let bake = bake.bypass_change_detection();
        (bake.is_paused, bake.seen, bake.job, bake.pending, bake.in_use) = (true, None, None, None, None);
    }
}

/// Starts bakes when the world has stopped changing, and takes their files.
pub(crate) fn bake_shadows(
    mut commands: Commands,
    mut lights: Query<
        (Entity, &GlobalTransform, &mut RuntimeBake, &mut BakeProgress, Option<&mut BakedShadow>),
        With<DirectionalLight>,
    >,
    placed: Meshes,
    assets: SceneAssets,
    mut files: ResMut<Assets<BakedShadowFile>>,
    (keys, limits, time): (Res<StaticKeys>, Res<DeviceLimits>, Res<Time<Real>>),
    without_bake: Query<Entity, (With<BakeProgress>, Without<RuntimeBake>)>,
) {
    for light in &without_bake {
        commands.entity(light).try_remove::<BakeProgress>();
    }
    for (light, transform, mut bake, mut progress, mut shadow) in &mut lights {
        let bake = bake.bypass_change_detection();
        bake.is_paused &= shadow.is_none();
        if shadow.as_ref().is_some_and(|shadow| shadow.follow) {
            continue;
        }
        if bake.is_paused {
            progress.set_if_neq(BakeProgress::Waiting);
            continue;
        }
        let now = BakeInputs {
            settings: bake.settings,
            towards_light: transform.back().as_vec3(),
            keys: Arc::clone(&keys.keys),
        };
        if bake.has_lost_all(&now.keys) {
            // This happens between two levels.
            if let Some(shadow) = &mut shadow
                && bake.in_use.is_some()
            {
                shadow.files.clear();
            }
            (bake.seen, bake.job, bake.pending, bake.in_use) = (None, None, None, None);
            progress.set_if_neq(BakeProgress::Waiting);
            continue;
        }
        if bake.seen.as_ref().is_some_and(|seen| seen.is_like(&now)) {
            bake.pending = None;
        } else if is_still(&mut bake.pending, &now, bake.seen.is_none(), time.elapsed()) {
            match gather(placed.iter().map(Placed::from), &assets) {
                // Some are not loaded yet.
                Ok(None) => bake.pending = Some((now, time.elapsed())),
                Ok(Some(scene)) => {
                    bake.pending = None;
                    let cache = Arc::clone(&bake.cache);
                    bake.job = Some(Job::start(scene, now.settings, now.towards_light, *limits, cache));
                    bake.seen = Some(now);
                }
                Err(error) => {
                    fail(light, &mut progress, error);
                    (bake.pending, bake.job, bake.seen) = (None, None, Some(now));
                }
            }
        }
        let Some(job) = &bake.job else { continue };
        // Read the progress before the files: if the job is done by now, all its files are received below.
        let under_way = job.progress();
        for finished in job.finished() {
            match finished {
                Ok(Finished { file, seconds, triangles, blocks: [blocks, reused], is_last }) => {
                    let handle = files.add(file);
                    info!(
                        "the shadow of light {light} is baked: {triangles} triangles in {seconds:.2} s, {reused} of {blocks} \
                         blocks as before"
                    );
                    match &mut shadow {
                        Some(shadow) => shadow.files = vec![handle],
                        None => {
                            let shadow = BakedShadow { align: false, ..BakedShadow::new(handle) };
                            commands.entity(light).try_insert(shadow);
                        }
                    }
                    bake.in_use = bake.seen.as_ref().map(|seen| Arc::clone(&seen.keys));
                    if is_last {
                        progress.set_if_neq(BakeProgress::Done { seconds, triangles });
                    }
                }
                Err(error) => fail(light, &mut progress, error),
            }
        }
        match under_way {
            Some((resolution, share)) => {
                progress.set_if_neq(BakeProgress::Baking { resolution, share });
            }
            None => bake.job = None,
        }
    }
}

/// Whether the inputs have been unchanged for long enough.
fn is_still(
    pending: &mut Option<(BakeInputs, Duration)>,
    now: &BakeInputs,
    is_first: bool,
    at: Duration,
) -> bool {
    if now.keys.is_empty() {
        return false;
    }
    match pending {
        Some((seen, since)) if seen.is_like(now) => is_first || at - *since >= now.settings.settle,
        _ => {
            *pending = Some((now.clone(), at));
            false
        }
    }
}

fn fail(light: Entity, progress: &mut Mut<BakeProgress>, error: BakeError) {
    warn!("the shadow of light {light} is not baked: {error}. Shadows come from the light's cascades");
    progress.set_if_neq(BakeProgress::Failed(error));
}

/// Marks the meshes whose current shadow is not in the file in use. They cast through the cascades.
pub(crate) fn mark_changes(
    mut commands: Commands,
    lights: Query<&RuntimeBake>,
    placed: Query<(Entity, Has<AwaitingBake>), With<IncludedInBake>>,
    keys: Res<StaticKeys>,
    mut known: Local<Vec<Arc<Keys>>>,
) {
    if lights.is_empty() {
        return;
    }
    let of_files = lights.iter().filter_map(|bake| bake.in_use.as_ref()).chain([&keys.keys]);
    let is_known = known.len() == of_files.clone().count()
        && of_files.clone().zip(known.iter()).all(|(now, before)| Arc::ptr_eq(now, before));
    if is_known {
        return;
    }
    *known = of_files.cloned().collect();
    for (entity, is_marked) in &placed {
        let key = keys.keys.get(&entity);
        let is_baked = known.iter().all(|keys| keys.get(&entity) == key);
        if is_baked == is_marked {
            let mut entity = commands.entity(entity);
            if is_baked {
                entity.try_remove::<AwaitingBake>()
            } else {
                entity.try_insert(AwaitingBake)
            };
        }
    }
}

#[cfg(test)]
mod tests;
