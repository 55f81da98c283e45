//! Which meshes are in the files, and how they are kept out of the cascades.

use adumbra::Receivers;
use bevy::camera::visibility::CascadesVisibleEntities;
use bevy::ecs::entity::EntityHashSet;
use bevy::ecs::prelude::*;
use bevy::light::{CascadeShadowConfig, NotShadowCaster, NotShadowReceiver};
use bevy::log::warn;
use bevy::mesh::Mesh3d;
use bevy::mesh::skinning::SkinnedMesh;
use bevy::prelude::{Assets, ChildOf, Children, DirectionalLight};
use bevy::reflect::prelude::*;

use crate::BakedShadowFile;
use crate::components::{BakedShadow, BakedStatic, InBake, NotBaked, StaticCasters};
use crate::status::BakedShadowStatus;
use crate::stream::ShadowStreams;

/// Whether an entity is moved by an animation.
#[cfg(feature = "animation")]
type Animated = Or<(With<bevy::animation::AnimatedBy>, With<SkinnedMesh>)>;
#[cfg(not(feature = "animation"))]
type Animated = With<SkinnedMesh>;

/// What may change which meshes are in the files.
type Changes = Or<(Added<Mesh3d>, Added<BakedStatic>, Added<NotBaked>, Changed<ChildOf>)>;

/// Keeps [`InBake`] on the meshes below a [`BakedStatic`]. Cost: nothing while the hierarchy does not change; then one
/// walk over what is below the entities that changed.
pub(crate) fn mark_meshes(
    mut commands: Commands,
    changed: Query<Entity, Changes>,
    (mut roots_removed, mut exceptions_removed): (
        RemovedComponents<BakedStatic>,
        RemovedComponents<NotBaked>,
    ),
    parents: Query<&ChildOf>,
    children: Query<&Children>,
    roots: Query<(), With<BakedStatic>>,
    moving: Query<(), Or<(With<NotBaked>, Animated)>>,
    meshes: Query<Has<InBake>, With<Mesh3d>>,
) {
    let mut seen = EntityHashSet::default();
    for from in changed.iter().chain(roots_removed.read()).chain(exceptions_removed.read()) {
        let mut open = vec![from];
        while let Some(entity) = open.pop() {
            if !seen.insert(entity) {
                continue;
            }
            open.extend(children.get(entity).into_iter().flatten());
            let Ok(is_marked) = meshes.get(entity) else { continue };
            let is_static = is_in_bake(entity, &parents, &roots, &moving);
            if is_static != is_marked {
                let mut entity = commands.entity(entity);
                if is_static {
                    entity.try_insert(InBake)
                } else {
                    entity.try_remove::<InBake>()
                };
            }
        }
    }
}

/// Whether the nearest ancestor that says anything, or the entity itself, says that it does not move.
fn is_in_bake(
    entity: Entity,
    parents: &Query<&ChildOf>,
    roots: &Query<(), With<BakedStatic>>,
    moving: &Query<(), Or<(With<NotBaked>, Animated)>>,
) -> bool {
    let mut at = entity;
    loop {
        if moving.contains(at) {
            return false;
        }
        if roots.contains(at) {
            return true;
        }
        let Ok(parent) = parents.get(at) else { return false };
        at = parent.parent();
    }
}

/// A mesh below a [`BakedStatic`] that the file in use does not have where it is now.
#[derive(Component, Debug)]
pub(crate) struct NotYetBaked;

/// The cascades of a light that has nothing to draw into them.
#[derive(Component, Debug)]
pub(crate) struct RestingCascades(CascadeShadowConfig);

/// Takes a light's cascades away while its files are in use and no mesh moves, so that no depth pass is made, and gives
/// them back in the frame in which that ends. A change of the configuration in between is kept.
pub(crate) fn rest_cascades(
    mut commands: Commands,
    choice: Res<StaticCasters>,
    mut lights: Query<
        (Entity, Option<&BakedShadowStatus>, &mut CascadeShadowConfig, Option<&RestingCascades>),
        Or<(With<BakedShadow>, With<RestingCascades>)>,
    >,
    with_files: Query<(), With<BakedShadow>>,
    movers: Query<(), (With<Mesh3d>, Without<NotShadowCaster>, Or<(Without<InBake>, With<NotYetBaked>)>)>,
) {
    if lights.is_empty() {
        return;
    }
    let nothing_moves = movers.is_empty() && *choice == StaticCasters::LeaveOut;
    for (entity, status, mut config, resting) in &mut lights {
        let is_active = with_files.contains(entity) && status.is_some_and(BakedShadowStatus::is_active);
        if nothing_moves && is_active {
            if !config.bounds.is_empty() {
                commands.entity(entity).try_insert(RestingCascades(config.clone()));
                config.bounds.clear();
            }
        } else if let Some(RestingCascades(before)) = resting {
            if config.bounds.is_empty() {
                *config = before.clone();
            }
            commands.entity(entity).try_remove::<RestingCascades>();
        }
    }
}

/// Warns once if something moves and receives a file that answers only static surfaces. Without a [`BakedStatic`] it is
/// not known what moves.
pub(crate) fn warn_of_movers(
    mut done: Local<bool>,
    lights: Query<(Entity, &BakedShadow, &BakedShadowStatus)>,
    (files, streams): (Res<Assets<BakedShadowFile>>, Res<ShadowStreams>),
    in_bake: Query<(), With<InBake>>,
    movers: Query<(), (With<Mesh3d>, Without<NotShadowReceiver>, Without<InBake>)>,
) {
    if *done || in_bake.is_empty() || movers.is_empty() {
        return;
    }
    for (entity, shadow, status) in &lights {
        let whole = shadow.files.iter().filter_map(|file| files.get(file)).map(BakedShadowFile::receivers);
        let streamed = shadow.streams.iter().filter_map(|source| streams.open_file(source)?.receivers());
        let is_static = whole.chain(streamed).any(|receivers| receivers == Receivers::Static);
        if status.is_active() && is_static {
            warn!(
                "a file of light {entity} was baked with --receivers static, so what moves has wrong shadows in 1 to 3 % \
                 of its points; bake it without that option"
            );
            *done = true;
            return;
        }
    }
}

/// Number of casters in all cascades of lights whose files are in use, in the last frame. A resource, to observe.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Resource, Default, Clone, Debug, PartialEq)]
pub struct CascadeCasters {
    /// Before meshes in the files were left out.
    pub found: usize,
    /// After that.
    pub kept: usize,
}

/// Removes the meshes in the files from the cascades of lights whose files are in use.
pub(crate) fn leave_out(
    choice: Res<StaticCasters>,
    mut lights: Query<
        (&BakedShadowStatus, &mut CascadesVisibleEntities),
        (With<DirectionalLight>, With<BakedShadow>),
    >,
    in_bake: Query<(), (With<InBake>, Without<NotYetBaked>)>,
    mut casters: ResMut<CascadeCasters>,
) {
    let mut counts = CascadeCasters::default();
    for (status, mut visible) in &mut lights {
        if !status.is_active() || visible.entities.is_empty() {
            continue;
        }
        for cascade in visible.entities.values_mut().flatten() {
            counts.found += cascade.entities.len();
            if *choice == StaticCasters::LeaveOut {
                cascade.entities.retain(|entity| !in_bake.contains(*entity));
            }
            counts.kept += cascade.entities.len();
        }
    }
    casters.set_if_neq(counts);
}
