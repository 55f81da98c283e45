//! Which meshes are in the files, and how they are kept out of the cascades.

use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::{CascadesVisibleEntities, NoCpuCulling};
use bevy::ecs::archetype::Archetypes;
use bevy::ecs::component::{ComponentId, ComponentInfo, Components};
use bevy::ecs::entity::EntityHashSet;
use bevy::ecs::entity_disabling::Disabled;
use bevy::ecs::prelude::*;
use bevy::ecs::system::SystemParam;
use bevy::light::{Cascades, NotShadowCaster};
use bevy::math::{Vec3, Vec3A};
use bevy::mesh::Mesh3d;
use bevy::mesh::skinning::SkinnedMesh;
use bevy::pbr::ExtractedDirectionalLight;
use bevy::prelude::{ChildOf, Children, DirectionalLight, GlobalTransform};
use bevy::reflect::prelude::*;
use bevy::render::Extract;
use bevy::render::sync_world::MainEntity;

use crate::components::{BakedShadow, ExcludeFromBake, IncludedInBake, ShadowStatic, StaticCasters};
use crate::in_use::FilesInUse;
use crate::status::BakedShadowStatus;

/// Whether an entity is moved by an animation.
#[cfg(feature = "animation")]
type Animated = Or<(With<bevy::animation::AnimatedBy>, With<SkinnedMesh>)>;
#[cfg(not(feature = "animation"))]
type Animated = With<SkinnedMesh>;

/// Removals of the components that move an entity.
#[cfg(feature = "animation")]
type NoMotion<'w, 's> =
    (RemovedComponents<'w, 's, SkinnedMesh>, RemovedComponents<'w, 's, bevy::animation::AnimatedBy>);
#[cfg(not(feature = "animation"))]
type NoMotion<'w, 's> = (RemovedComponents<'w, 's, SkinnedMesh>,);

/// Changes after which a mesh may belong to the files or leave them.
#[cfg(feature = "animation")]
type Changes = Or<(
    Added<Mesh3d>,
    Added<ShadowStatic>,
    Added<ExcludeFromBake>,
    Changed<ChildOf>,
    Added<SkinnedMesh>,
    Added<bevy::animation::AnimatedBy>,
)>;
#[cfg(not(feature = "animation"))]
type Changes =
    Or<(Added<Mesh3d>, Added<ShadowStatic>, Added<ExcludeFromBake>, Changed<ChildOf>, Added<SkinnedMesh>)>;

/// Keeps [`IncludedInBake`] on the meshes below a [`ShadowStatic`]. Cost: nothing while the hierarchy does
/// not change; after a change, one walk over the descendants of the changed entities.
pub(crate) fn mark_meshes(
    mut commands: Commands,
    changed: Query<Entity, Changes>,
    (mut roots_removed, mut exceptions_removed, mut parents_removed, mut enabled): (
        RemovedComponents<ShadowStatic>,
        RemovedComponents<ExcludeFromBake>,
        RemovedComponents<ChildOf>,
        RemovedComponents<Disabled>,
    ),
    mut still: NoMotion,
    parents: Query<&ChildOf>,
    children: Query<&Children>,
    roots: Query<(), With<ShadowStatic>>,
    moving: Query<(), Or<(With<ExcludeFromBake>, Animated)>>,
    meshes: Query<Has<IncludedInBake>, With<Mesh3d>>,
) {
    let mut seen = EntityHashSet::default();
    let removed = roots_removed.read().chain(exceptions_removed.read());
    let removed = removed.chain(parents_removed.read()).chain(still.0.read()).chain(enabled.read());
    #[cfg(feature = "animation")]
    let removed = removed.chain(still.1.read());
    for from in changed.iter().chain(removed) {
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
                    entity.try_insert(IncludedInBake)
                } else {
                    entity.try_remove::<IncludedInBake>()
                };
            }
        }
    }
}

/// Whether the entity is static. The entity itself or its nearest marked ancestor decides: [`ShadowStatic`]
/// makes it static; [`ExcludeFromBake`], an animation or a skin makes it move, and wins on the same entity.
fn is_in_bake(
    entity: Entity,
    parents: &Query<&ChildOf>,
    roots: &Query<(), With<ShadowStatic>>,
    moving: &Query<(), Or<(With<ExcludeFromBake>, Animated)>>,
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

/// A mesh below a [`ShadowStatic`] whose current shadow is not in the file in use.
#[derive(Component, Debug)]
pub(crate) struct AwaitingBake;

/// The lights whose cascades have nothing to draw in this frame. The render world makes no depth pass for
/// them; their components stay unchanged.
#[derive(Resource, Default, Debug)]
pub(crate) struct RestingLights(pub(crate) EntityHashSet);

/// Shadow-casting meshes that only the GPU culls.
type Unculled = (With<Mesh3d>, With<NoCpuCulling>, Without<NotShadowCaster>);

/// Casters that Bevy does not list by cascade: meshes that only the GPU culls, and meshlets.
#[derive(SystemParam)]
pub(crate) struct OtherCasters<'w, 's> {
    unculled: Query<'w, 's, (), (Unculled, Or<(Without<IncludedInBake>, With<AwaitingBake>)>)>,
    unculled_in_bake: Query<'w, 's, (), (Unculled, With<IncludedInBake>)>,
    components: &'w Components,
    archetypes: &'w Archetypes,
    /// The number of components at the last search for the meshlet component, and the result.
    meshlets: Local<'s, (usize, Option<ComponentId>)>,
}

impl OtherCasters<'_, '_> {
    /// Whether any such casters exist. Static meshes count too, unless all files are in use.
    fn exist(&mut self, is_complete: bool) -> bool {
        // This crate does not enable Bevy's meshlet feature, so the type may not exist. Find it by name.
        if self.meshlets.0 != self.components.len() {
            let mut all = self.components.iter_registered();
            let found = all.find(|info| info.name().to_string().ends_with("::MeshletMesh3d"));
            *self.meshlets = (self.components.len(), found.map(ComponentInfo::id));
        }
        let has_meshlets =
            |id| self.archetypes.iter().any(|archetype| !archetype.is_empty() && archetype.contains(id));
        !self.unculled.is_empty()
            || (!is_complete && !self.unculled_in_bake.is_empty())
            || self.meshlets.1.is_some_and(has_meshlets)
    }
}

/// Clears the cascades of lights whose files are in use if nothing may move, so that Bevy does not search
/// them for casters. Runs after Bevy computes cascades and before it computes their frusta.
pub(crate) fn skip_cascades(
    choice: Res<StaticCasters>,
    mut lights: Query<(Entity, &BakedShadowStatus, &mut Cascades), With<BakedShadow>>,
    files: Res<FilesInUse>,
    movers: Query<
        (),
        (With<Mesh3d>, Without<NotShadowCaster>, Or<(Without<IncludedInBake>, With<AwaitingBake>)>),
    >,
    mut others: OtherCasters,
) {
    if *choice == StaticCasters::Keep || !movers.is_empty() || others.exist(true) {
        return;
    }
    for (light, status, mut cascades) in &mut lights {
        if status.is_active() && !files.partial.contains(&light) {
            // Keep the map's entries: Bevy expects one for every view.
            for of_view in cascades.cascades.values_mut() {
                of_view.clear();
            }
        }
    }
}

/// Number of casters in all cascades of lights whose files are in use, in the last frame. A resource for
/// diagnostics.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Resource, Default, Clone, Debug, PartialEq)]
pub struct CascadeCasters {
    /// Before meshes in the files were left out.
    pub found: usize,
    /// After that.
    pub kept: usize,
}

/// Returns the corners of a mesh's bounds. Without bounds, each corner is the mesh's origin.
fn corners(bounds: Option<&Aabb>) -> impl Iterator<Item = Vec3> {
    let (center, half) =
        bounds.map_or((Vec3A::ZERO, Vec3A::ZERO), |bounds| (bounds.center, bounds.half_extents));
    (0..8_u32).map(move |corner| {
        let side = |axis: u32| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
        Vec3::from(center + half * Vec3A::new(side(0), side(1), side(2)))
    })
}

/// Removes the meshes in the files from the cascades of lights whose files are in use, and finds the lights
/// with nothing left.
pub(crate) fn leave_out(
    choice: Res<StaticCasters>,
    mut lights: Query<
        (Entity, &GlobalTransform, &BakedShadowStatus, &mut CascadesVisibleEntities),
        (With<DirectionalLight>, With<BakedShadow>),
    >,
    in_bake: Query<(&GlobalTransform, Option<&Aabb>), (With<IncludedInBake>, Without<AwaitingBake>)>,
    files: Res<FilesInUse>,
    mut others: OtherCasters,
    mut casters: ResMut<CascadeCasters>,
    mut resting: ResMut<RestingLights>,
) {
    resting.0.clear();
    let mut counts = CascadeCasters::default();
    for (light, transform, status, mut visible) in &mut lights {
        if !status.is_active() {
            continue;
        }
        let of_light = files.of_sun(transform.back().as_vec3());
        let is_complete = !files.partial.contains(&light);
        let is_in_file = |entity: Entity| {
            in_bake.get(entity).is_ok_and(|(transform, bounds)| {
                let is_inside = |p: Vec3| of_light.clone().any(|file| file.contains(p));
                is_complete || corners(bounds).all(|corner| is_inside(transform.transform_point(corner)))
            })
        };
        let mut kept = 0;
        for cascade in visible.entities.values_mut().flatten() {
            counts.found += cascade.entities.len();
            if *choice == StaticCasters::LeaveOut {
                cascade.entities.retain(|entity| !is_in_file(*entity));
            }
            kept += cascade.entities.len();
        }
        counts.kept += kept;
        if kept == 0 && *choice == StaticCasters::LeaveOut && !others.exist(is_complete) {
            resting.0.insert(light);
        }
    }
    casters.set_if_neq(counts);
}

/// Tells the render world which lights have nothing to draw into their cascades.
pub(crate) fn extract_resting(main: Extract<Res<RestingLights>>, mut resting: ResMut<RestingLights>) {
    resting.0.clone_from(&main.0);
}

/// Removes, in the render world, the cascades of the lights in [`RestingLights`].
pub(crate) fn rest_cascades(
    resting: Res<RestingLights>,
    mut lights: Query<(&MainEntity, &mut ExtractedDirectionalLight)>,
) {
    for (light, mut extracted) in &mut lights {
        if resting.0.contains(&light.id()) {
            // Bevy draws one cascade per bound.
            extracted.cascade_shadow_config.bounds.clear();
        }
    }
}
