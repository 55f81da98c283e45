//! Baking while the app runs: gather, bake on threads of its own, swap.
//!
//! [`BakeShadow`] on a light asks for it, or [`BakeShadowCommands::bake_shadow`]. The meshes below
//! [`BakedStatic`](crate::BakedStatic) are copied once per bake. A coarse file comes first, then the asked one; each takes the place of
//! the one before in a single frame. When a mesh moves, or the light turns, shadows of that mesh, or all, come from the
//! cascades again until a new bake is done. It bakes what the change touches, and has the rest in memory: about as many bytes
//! as the file.
//!
//! A light that is followed ([`BakedShadow::follow_sun`](crate::BakedShadow::follow_sun)) has keys baked ahead of it in place of
//! a file.

mod follow;
mod gather;
mod job;
mod progress;
mod versions;

use std::sync::Arc;
use std::time::Duration;

use adumbra_bake::MemoryObjects;
use bevy::asset::Assets;
use bevy::ecs::entity::EntityHashMap;
use bevy::ecs::prelude::*;
use bevy::image::Image;
use bevy::light::NotShadowCaster;
use bevy::log::{info, warn};
use bevy::math::Vec3;
use bevy::mesh::{Mesh, Mesh3d};
use bevy::pbr::{MeshMaterial3d, StandardMaterial};
use bevy::prelude::{DirectionalLight, GlobalTransform};
use bevy::reflect::prelude::*;
use bevy::time::{Real, Time};

use crate::components::{BakedShadow, InBake};
use crate::statics::NotYetBaked;
use crate::{BakedShadowFile, DeviceLimits};
use follow::Following;
pub(crate) use follow::follow_suns;
use gather::{Placed, gather};
use job::{Finished, Job};
pub use progress::{BakeError, BakeProgress};
pub(crate) use versions::{AssetVersions, count_changes};

/// Settings of a bake while the app runs.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Default, Clone, Debug, PartialEq)]
pub struct BakeSettings {
    /// Texels on the longest side of the world as the sun sees it, a power of two from 8 to 262,144.
    pub resolution: u32,
    /// Resolution of the file that comes first. None comes first if it is not less than `resolution`. Not that of the first
    /// key of a light that is followed, which is an eighth of `resolution`.
    pub first_resolution: u32,
    /// How far below an open surface its shadow may begin, world units. More makes smaller files.
    pub thickness_world: f32,
    /// Worker threads; 0 is one less than the processor has, and one for a light that is followed.
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

/// Bakes the shadow of this directional light, and again when meshes below a [`BakedStatic`](crate::BakedStatic) or the
/// light change. Removing it ends a bake that is under way; the last file stays.
#[derive(Component, Debug, Default, Reflect)]
#[reflect(Component, Default, Debug)]
#[require(BakeProgress)]
pub struct BakeShadow {
    /// The settings. A change of them bakes again.
    pub settings: BakeSettings,
    // Work under way is no data, so reflection leaves the rest out.
    /// What the newest bake saw, and the bake itself while it is under way.
    #[reflect(ignore)]
    seen: Option<Seen>,
    #[reflect(ignore)]
    job: Option<Job>,
    /// What bakes keys ahead of the light, if it is followed.
    #[reflect(ignore)]
    following: Option<Following>,
    /// What its bakes have made: after a change, only what it touches is baked.
    #[reflect(ignore)]
    objects: Arc<MemoryObjects>,
    /// What there is now if the newest bake saw something else, and since when.
    #[reflect(ignore)]
    pending: Option<(Seen, Duration)>,
    /// The meshes in the file that is in use.
    #[reflect(ignore)]
    in_use: Option<Arc<Keys>>,
}

impl BakeShadow {
    /// Bakes with these settings.
    pub fn new(settings: BakeSettings) -> Self {
        Self { settings, ..Self::default() }
    }
}

/// For each mesh in a bake: a number that differs where its geometry, place or material does.
type Keys = EntityHashMap<u64>;

/// What a bake depends on.
#[derive(Clone, Debug)]
struct Seen {
    settings: BakeSettings,
    towards_light: Vec3,
    keys: Arc<Keys>,
}

impl PartialEq for Seen {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.keys, &other.keys)
            && (self.settings, self.towards_light) == (other.settings, other.towards_light)
    }
}

/// The meshes that a bake would see now.
#[derive(Resource, Default)]
pub(crate) struct StaticKeys {
    keys: Arc<Keys>,
    /// Changes of assets that are in the keys.
    changes: u64,
}

/// Adds [`BakeShadowCommands::bake_shadow`] to `Commands`.
pub trait BakeShadowCommands {
    /// Bakes the shadow of a directional light while the app runs, with a [`BakeShadow`].
    fn bake_shadow(&mut self, light: Entity, settings: BakeSettings);
}

impl BakeShadowCommands for Commands<'_, '_> {
    fn bake_shadow(&mut self, light: Entity, settings: BakeSettings) {
        self.entity(light).insert(BakeShadow::new(settings));
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
    ),
    With<InBake>,
>;

/// What may change a bake.
type Changes = (
    With<InBake>,
    Or<(
        Added<InBake>,
        Changed<Mesh3d>,
        Changed<GlobalTransform>,
        Changed<MeshMaterial3d<StandardMaterial>>,
        Added<NotShadowCaster>,
    )>,
);

/// Keeps [`StaticKeys`]. Cost: nothing while no mesh of a bake changes.
pub(crate) fn find_meshes(
    lights: Query<(), With<BakeShadow>>,
    placed: Meshes,
    changed: Query<(), Changes>,
    (mut removed, mut casts): (RemovedComponents<InBake>, RemovedComponents<NotShadowCaster>),
    materials: Res<Assets<StandardMaterial>>,
    (mut keys, mut versions): (ResMut<StaticKeys>, ResMut<AssetVersions>),
) {
    let has_changes = removed.read().count() + casts.read().count() > 0
        || !changed.is_empty()
        || keys.changes != versions.changes();
    if lights.is_empty() || (!has_changes && !keys.keys.is_empty()) {
        return;
    }
    let mut key = |placed: Placed| placed.key(&materials, &mut versions);
    let new: Keys = placed.iter().map(|mesh| (mesh.0, key(mesh.into()))).collect();
    keys.changes = versions.changes();
    if *keys.keys != new {
        keys.keys = Arc::new(new);
    }
}

/// Starts bakes when the world is still, and takes their files.
pub(crate) fn bake_shadows(
    mut commands: Commands,
    mut lights: Query<
        (Entity, &GlobalTransform, &mut BakeShadow, &mut BakeProgress, Option<&mut BakedShadow>),
        With<DirectionalLight>,
    >,
    placed: Meshes,
    (meshes, materials, images): (Res<Assets<Mesh>>, Res<Assets<StandardMaterial>>, Res<Assets<Image>>),
    mut files: ResMut<Assets<BakedShadowFile>>,
    (keys, limits, time): (Res<StaticKeys>, Res<DeviceLimits>, Res<Time<Real>>),
) {
    for (light, transform, mut bake, mut progress, mut shadow) in &mut lights {
        if shadow.as_ref().is_some_and(|shadow| shadow.follow) {
            continue;
        }
        let bake = bake.bypass_change_detection();
        let now = Seen {
            settings: bake.settings,
            towards_light: transform.back().as_vec3(),
            keys: Arc::clone(&keys.keys),
        };
        if bake.seen.as_ref() == Some(&now) {
            bake.pending = None;
        } else if is_still(&mut bake.pending, &now, bake.seen.is_none(), time.elapsed()) {
            bake.pending = None;
            // A bake of what has changed since would be of no use.
            bake.job = None;
            match gather(placed.iter().map(Placed::from), &meshes, &materials, &images) {
                // Some meshes are not loaded yet.
                Ok(None) => {}
                Ok(Some(scene)) => {
                    let objects = Arc::clone(&bake.objects);
                    bake.job = Some(Job::start(scene, now.settings, now.towards_light, *limits, objects));
                    bake.seen = Some(now);
                }
                Err(error) => {
                    fail(light, &mut progress, error);
                    bake.seen = Some(now);
                }
            }
        }
        let Some(job) = &bake.job else { continue };
        // Asked first: whatever was finished by then is found below.
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
                            commands.entity(light).insert(shadow);
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

/// Whether what there is now has not changed for long enough.
fn is_still(pending: &mut Option<(Seen, Duration)>, now: &Seen, is_first: bool, at: Duration) -> bool {
    if now.keys.is_empty() {
        return false;
    }
    match pending {
        Some((seen, since)) if seen == now => is_first || at - *since >= now.settings.settle,
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

/// Marks the meshes that the file in use does not have where they are now. They cast through the cascades.
pub(crate) fn mark_changes(
    mut commands: Commands,
    lights: Query<&BakeShadow>,
    placed: Query<(Entity, Has<NotYetBaked>), With<InBake>>,
    keys: Res<StaticKeys>,
    mut known: Local<Vec<Arc<Keys>>>,
) {
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
                entity.try_remove::<NotYetBaked>()
            } else {
                entity.try_insert(NotYetBaked)
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use adumbra::Sun;
    use adumbra_bake::{BakeOptions, Size, Watch, bake};
    use adumbra_scene::{GeneratedKind, generate};
    use bevy::asset::AssetEvent;
    use bevy::ecs::message::Messages;

    use super::*;

    /// A light and a mesh, without a renderer. The mesh is not loaded, so that no bake begins by itself.
    struct Stage {
        world: World,
        systems: Schedule,
        light: Entity,
        mesh: Entity,
    }

    impl Stage {
        fn new() -> Self {
            let mut world = World::new();
            world.init_resource::<Assets<Mesh>>();
            world.init_resource::<Assets<StandardMaterial>>();
            world.init_resource::<Assets<Image>>();
            world.init_resource::<Assets<BakedShadowFile>>();
            world.init_resource::<StaticKeys>();
            world.init_resource::<AssetVersions>();
            world.init_resource::<Messages<AssetEvent<Mesh>>>();
            world.init_resource::<Messages<AssetEvent<StandardMaterial>>>();
            world.init_resource::<Messages<AssetEvent<Image>>>();
            world.init_resource::<DeviceLimits>();
            world.init_resource::<Time<Real>>();
            let light = world.spawn((DirectionalLight::default(), BakeShadow::default())).id();
            let mesh = world.spawn((Mesh3d::default(), InBake)).id();
            let mut systems = Schedule::default();
            systems.add_systems((count_changes, find_meshes, bake_shadows, mark_changes).chain());
            let mut stage = Self { world, systems, light, mesh };
            stage.update();
            stage
        }

        fn update(&mut self) {
            self.systems.run(&mut self.world);
        }

        /// Has a bake of what there is now finish a file.
        fn finish(&mut self, is_last: bool) {
            let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
            let options = BakeOptions::new(sun, Size::Resolution(64));
            let file = bake(&generate(GeneratedKind::Primitives, 1), &options, Watch::none()).unwrap().file;
            let file = BakedShadowFile::new(file, DeviceLimits::default()).unwrap();
            let (sender, results) = channel();
            sender.send(Ok(Finished { file, seconds: 0.0, triangles: 0, blocks: [1, 0], is_last })).unwrap();
            let keys = Arc::clone(&self.world.resource::<StaticKeys>().keys);
            let towards_light = self.world.get::<GlobalTransform>(self.light).unwrap().back().as_vec3();
            let mut light = self.world.get_mut::<BakeShadow>(self.light).unwrap();
            light.seen = Some(Seen { settings: light.settings, towards_light, keys });
            light.job = Some(Job::of_test(results));
            self.update();
        }

        fn move_mesh(&mut self, x: f32) {
            let mut transform = self.world.get_mut::<GlobalTransform>(self.mesh).unwrap();
            *transform = GlobalTransform::from_xyz(x, 0.0, 0.0);
            self.update();
        }

        /// Whether the newest bake saw something else than there is now.
        fn is_pending(&self) -> bool {
            self.world.get::<BakeShadow>(self.light).unwrap().pending.is_some()
        }

        /// Whether the mesh casts through the cascades.
        fn is_marked(&self) -> bool {
            self.world.get::<NotYetBaked>(self.mesh).is_some()
        }
    }

    #[test]
    fn a_mesh_that_casts_no_more_or_again_is_baked_anew() {
        let mut stage = Stage::new();
        stage.finish(true);
        assert!(!stage.is_pending());
        stage.world.entity_mut(stage.mesh).insert(NotShadowCaster);
        stage.update();
        assert!(stage.is_pending());
        stage.finish(true);
        assert!(!stage.is_pending());
        stage.world.entity_mut(stage.mesh).remove::<NotShadowCaster>();
        stage.update();
        assert!(stage.is_pending());
    }

    #[test]
    fn a_mesh_or_a_material_that_is_changed_in_place_is_baked_anew() {
        let mut stage = Stage::new();
        let material =
            stage.world.resource_mut::<Assets<StandardMaterial>>().add(StandardMaterial::default());
        stage.world.entity_mut(stage.mesh).insert(MeshMaterial3d(material.clone()));
        stage.update();
        stage.finish(true);
        assert!(!stage.is_pending());
        let mesh = stage.world.get::<Mesh3d>(stage.mesh).unwrap().id();
        let of_mesh = AssetEvent::<Mesh>::Modified { id: mesh };
        stage.world.resource_mut::<Messages<AssetEvent<Mesh>>>().write(of_mesh);
        stage.update();
        assert!(stage.is_pending() && stage.is_marked());
        stage.finish(true);
        assert!(!stage.is_pending());
        let of_material = AssetEvent::<StandardMaterial>::Modified { id: material.id() };
        stage.world.resource_mut::<Messages<AssetEvent<StandardMaterial>>>().write(of_material);
        stage.update();
        assert!(stage.is_pending());
        stage.finish(true);
        // Materials of other meshes are none of the bake's.
        let other = stage.world.resource_mut::<Assets<StandardMaterial>>().add(StandardMaterial::default());
        let of_other = AssetEvent::<StandardMaterial>::Modified { id: other.id() };
        stage.world.resource_mut::<Messages<AssetEvent<StandardMaterial>>>().write(of_other);
        stage.update();
        assert!(!stage.is_pending());
    }

    #[test]
    fn meshes_in_use_are_those_of_the_newest_file_be_it_coarse() {
        let mut stage = Stage::new();
        stage.finish(true);
        assert!(!stage.is_marked());
        stage.move_mesh(1.0);
        assert!(stage.is_marked());
        stage.finish(false);
        assert!(!stage.is_marked());
        // Back to where the file before has it.
        stage.move_mesh(0.0);
        assert!(stage.is_marked());
    }
}
