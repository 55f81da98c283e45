//! Where an app places the files' worlds: the roots that files follow.

use adumbra::Placement;
use bevy::asset::AssetId;
use bevy::ecs::prelude::*;
use bevy::math::{Mat4, Vec3};
use bevy::platform::collections::HashSet;
use bevy::prelude::GlobalTransform;

use crate::components::FileRoot;
use crate::error::BakedShadowError;
use crate::{BakedShadowFile, StreamSource};

/// The files that have had a root. While such a file has no root, as between two levels, it has no place.
#[derive(Resource, Default)]
pub(crate) struct Rooted {
    whole: HashSet<AssetId<BakedShadowFile>>,
    streamed: Vec<StreamSource>,
}

/// Updates [`Rooted`].
pub(crate) fn note_roots(roots: Query<&FileRoot, Changed<FileRoot>>, mut rooted: ResMut<Rooted>) {
    for root in &roots {
        match root {
            FileRoot::Whole(file) => {
                rooted.whole.insert(file.id());
            }
            FileRoot::Streamed(source) if !rooted.streamed.contains(source) => {
                rooted.streamed.push(source.clone());
            }
            FileRoot::Streamed(_) => {}
        }
    }
}

/// The roots of files, with the matrices that they had when this was made.
pub(crate) struct Roots<'a> {
    roots: Vec<(Entity, &'a FileRoot, Mat4)>,
    rooted: &'a Rooted,
}

impl<'a> Roots<'a> {
    pub(crate) fn new(
        rooted: &'a Rooted,
        roots: impl Iterator<Item = (Entity, &'a FileRoot, GlobalTransform)>,
    ) -> Self {
        let mut roots: Vec<_> = roots.map(|(entity, root, at)| (entity, root, at.to_matrix())).collect();
        // The first root turns the light. Sort them, so that it is the same root in every frame, whatever
        // components the app inserts.
        roots.sort_unstable_by_key(|(entity, ..)| entity.index_u32());
        Self { roots, rooted }
    }

    /// Returns the places of a file: those of its roots, or where it was baked if it never had one.
    pub(crate) fn of_file(&self, file: AssetId<BakedShadowFile>) -> Places {
        let is_of_file = |root: &FileRoot| matches!(root, FileRoot::Whole(handle) if handle.id() == file);
        self.places(is_of_file, self.rooted.whole.contains(&file))
    }

    /// Returns the places of a streamed file.
    pub(crate) fn of_stream(&self, source: &StreamSource) -> Places {
        let is_of_stream = |root: &FileRoot| matches!(root, FileRoot::Streamed(of_root) if of_root == source);
        self.places(is_of_stream, self.rooted.streamed.contains(source))
    }

    fn places(&self, is_of_file: impl Fn(&FileRoot) -> bool, is_rooted: bool) -> Places {
        let of_file = self.roots.iter().filter(|(_, root, _)| is_of_file(root));
        let mut places: Places = of_file.map(|(.., matrix)| place(*matrix)).collect();
        if places.is_empty() && !is_rooted {
            places.push(Ok(Placement::BAKED));
        }
        places
    }
}

/// The places of one file. A root that it cannot follow is an error.
pub(crate) type Places = Vec<Result<Placement, BakedShadowError>>;

fn place(world_from_file: Mat4) -> Result<Placement, BakedShadowError> {
    let columns = world_from_file.to_cols_array_2d().map(|column| column.map(f64::from));
    Placement::from_matrix(columns).map_err(BakedShadowError::Root)
}

/// Returns the unit vector towards a file's sun in the app's world.
pub(crate) fn turned(placement: &Placement, towards_sun: [f64; 3]) -> Vec3 {
    Vec3::from_array(placement.direction_to_world(towards_sun).map(|c| c as f32))
}
