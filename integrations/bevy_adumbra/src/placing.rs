//! Where an app has the files' worlds: the roots that files follow.

use adumbra::Placement;
use bevy::asset::AssetId;
use bevy::ecs::prelude::*;
use bevy::math::{Mat4, Vec3};
use bevy::prelude::GlobalTransform;

use crate::components::FileRoot;
use crate::error::BakedShadowError;
use crate::{BakedShadowFile, StreamSource};

/// The roots of files, with the matrices that they had when this was made.
pub(crate) struct Roots<'a>(Vec<(&'a FileRoot, Mat4)>);

impl<'a> Roots<'a> {
    pub(crate) fn new(roots: impl Iterator<Item = (&'a FileRoot, GlobalTransform)>) -> Self {
        Self(roots.map(|(root, transform)| (root, transform.to_matrix())).collect())
    }

    /// Returns the places of a file: those of its roots, or where it was baked.
    pub(crate) fn of_file(&self, file: AssetId<BakedShadowFile>) -> Places {
        self.places(|root| matches!(root, FileRoot::Whole(handle) if handle.id() == file))
    }

    /// Returns the places of a streamed file.
    pub(crate) fn of_stream(&self, source: &StreamSource) -> Places {
        self.places(|root| matches!(root, FileRoot::Streamed(of_root) if of_root == source))
    }

    fn places(&self, is_of_file: impl Fn(&FileRoot) -> bool) -> Places {
        let mut places: Places =
            self.0.iter().filter(|(root, _)| is_of_file(root)).map(|(_, matrix)| place(*matrix)).collect();
        if places.is_empty() {
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
