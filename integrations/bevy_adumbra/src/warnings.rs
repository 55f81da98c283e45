//! One-time warnings of mistakes that make shadows wrong without a fault in a status.

use adumbra::Receivers;
use bevy::ecs::prelude::*;
use bevy::light::NotShadowReceiver;
use bevy::log::warn;
use bevy::math::Affine3A;
use bevy::mesh::Mesh3d;
use bevy::prelude::{Assets, GlobalTransform};

use crate::BakedShadowFile;
use crate::components::{BakedShadow, FileRoot, IncludedInBake, ShadowStatic};
use crate::status::BakedShadowStatus;
use crate::stream::ShadowStreams;

/// A light whose files were not baked by the running app. Files that the app bakes always fit, because it
/// bakes meshes where they are now.
#[cfg(feature = "bake")]
type Loaded = (With<BakedShadow>, Without<crate::bake::RuntimeBake>);
#[cfg(not(feature = "bake"))]
type Loaded = With<BakedShadow>;

/// Warns if a moving mesh receives shadows from a file that answers for static surfaces only. Without a
/// [`ShadowStatic`] the plugin cannot know which meshes move.
pub(crate) fn warn_of_movers(
    mut done: Local<bool>,
    lights: Query<(Entity, &BakedShadow, &BakedShadowStatus)>,
    (files, streams): (Res<Assets<BakedShadowFile>>, Res<ShadowStreams>),
    in_bake: Query<(), With<IncludedInBake>>,
    movers: Query<(), (With<Mesh3d>, Without<NotShadowReceiver>, Without<IncludedInBake>)>,
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

/// Returns, once, a static root that is moved, turned or scaled away from where it was baked, if no file
/// follows a root. A root that is itself a mesh is skipped: it is a part of a world whose origin is
/// elsewhere.
pub(crate) fn find_moved_root(
    mut has_found: Local<bool>,
    lights: Query<&BakedShadowStatus, Loaded>,
    statics: Query<(Entity, &GlobalTransform), (With<ShadowStatic>, Without<Mesh3d>)>,
    roots: Query<(), With<FileRoot>>,
) -> Option<Entity> {
    if *has_found || !roots.is_empty() || !lights.iter().any(BakedShadowStatus::is_active) {
        return None;
    }
    let is_moved = |at: &GlobalTransform| !at.affine().abs_diff_eq(Affine3A::IDENTITY, 1e-5);
    let moved = statics.iter().find(|(_, at)| is_moved(at)).map(|(entity, _)| entity);
    *has_found = moved.is_some();
    moved
}

/// Warns about the root that [`find_moved_root`] has found.
pub(crate) fn warn_of_moved_root(In(moved): In<Option<Entity>>) {
    let Some(entity) = moved else { return };
    warn!(
        "the ShadowStatic {entity} is moved, turned or scaled, and its file stays where it was baked; if the file was baked \
         from what is below it, put FileRoot::new(file) on it"
    );
}

#[cfg(test)]
mod tests {
    use bevy::ecs::system::RunSystemOnce;
    use bevy::prelude::Transform;

    use super::*;

    #[test]
    fn finds_a_moved_static_root_unless_a_file_follows_a_root() {
        let mut world = World::new();
        let find = |world: &mut World| world.run_system_once(find_moved_root).unwrap();
        world.spawn((ShadowStatic, GlobalTransform::default()));
        let root =
            world.spawn((ShadowStatic, GlobalTransform::from(Transform::from_xyz(0.0, 2.0, 0.0)))).id();
        assert_eq!(find(&mut world), None, "no light has a file");
        let light = world.spawn((BakedShadow::default(), BakedShadowStatus::Active { files: 1 })).id();
        assert_eq!(find(&mut world), Some(root));
        #[cfg(feature = "bake")]
        {
            world.entity_mut(light).insert(crate::bake::RuntimeBake::default());
            assert_eq!(find(&mut world), None, "the app bakes where things are");
            world.entity_mut(light).remove::<crate::bake::RuntimeBake>();
        }
        world.entity_mut(light).insert(BakedShadowStatus::Waiting);
        assert_eq!(find(&mut world), None);
        world.entity_mut(light).insert(BakedShadowStatus::Active { files: 1 });
        world.entity_mut(root).insert(FileRoot::new(Default::default()));
        assert_eq!(find(&mut world), None);
    }
}
