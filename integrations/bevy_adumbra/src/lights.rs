//! Which files are in use: those whose sun a light has. Decided once per frame, before cascades are made, so that
//! cascades and files never both leave a shadow out.

use std::sync::Arc;

use adumbra::gpu::{LookUp, LookUpTexture, Penumbra};
use bevy::asset::{AssetServer, Assets, LoadState};
use bevy::ecs::prelude::*;
use bevy::log::{info, warn};
use bevy::math::{Quat, Vec3};
use bevy::prelude::{ChildOf, DirectionalLight, GlobalTransform, Transform};
use bevy::shader::Shader;

use crate::components::BakedShadow;
use crate::error::BakedShadowError;
use crate::patch::{PatchState, ShaderPatch};
use crate::shaders::Way;
use crate::status::{BakedShadowChanged, BakedShadowStatus};
use crate::{BakedShadowFile, DeviceLimits};

/// Largest number of files in use at once.
pub(crate) const MAX_FILES: usize = 8;

/// A light has a file's sun if the distance of their unit vectors is at most this, 0.05 degrees.
const SAME_SUN: f32 = 1e-3;

/// A file that is in use.
#[derive(Clone, Debug)]
pub(crate) struct FileInUse {
    pub(crate) texture: Arc<LookUpTexture>,
    pub(crate) way: Way,
    /// The first row's texels: the texture's own header with the light's filter and bias.
    pub(crate) header: Vec<u8>,
    towards_sun: Vec3,
}

impl FileInUse {
    /// Whether no other file has this sun.
    pub(crate) fn is_alone(&self, all: &[Self]) -> bool {
        let same_sun = |other: &&Self| other.towards_sun.distance(self.towards_sun) <= 2.0 * SAME_SUN;
        all.iter().filter(same_sun).count() == 1
    }
}

impl PartialEq for FileInUse {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.texture, &other.texture) && (self.way, &self.header) == (other.way, &other.header)
    }
}

/// The files in use, for the render world.
#[derive(Resource, Default, PartialEq)]
pub(crate) struct FilesInUse(pub(crate) Vec<FileInUse>);

/// Turns lights to the sun of their first loaded file.
pub(crate) fn align_lights(
    mut lights: Query<(&BakedShadow, &mut Transform, Option<&ChildOf>), With<DirectionalLight>>,
    parents: Query<&GlobalTransform>,
    files: Res<Assets<BakedShadowFile>>,
) {
    for (shadow, mut transform, parent) in &mut lights {
        let Some(file) = shadow.files.iter().find_map(|file| files.get(file)) else { continue };
        if !shadow.align {
            continue;
        }
        let parent = parent.and_then(|parent| parents.get(parent.parent()).ok());
        let parent = parent.map_or(Quat::IDENTITY, |parent| parent.rotation());
        let towards_sun = file.towards_sun();
        // An exact test would turn a light at every frame that cannot have just this direction.
        if (parent * transform.rotation * Vec3::Z).distance(towards_sun) > 1e-5 {
            let world = Transform::default().looking_to(-towards_sun, Vec3::Y).rotation;
            transform.rotation = parent.inverse() * world;
        }
    }
}

/// Finds the files in use, and updates the status of every light.
pub(crate) fn find_files_in_use(
    mut commands: Commands,
    mut lights: Query<(Entity, &BakedShadow, &GlobalTransform, &DirectionalLight, &mut BakedShadowStatus)>,
    without_files: Query<Entity, (With<BakedShadowStatus>, Without<BakedShadow>)>,
    files: Res<Assets<BakedShadowFile>>,
    server: Res<AssetServer>,
    (patch, limits): (Res<ShaderPatch>, Res<DeviceLimits>),
    mut in_use: ResMut<FilesInUse>,
) {
    for light in &without_files {
        commands.entity(light).try_remove::<BakedShadowStatus>();
    }
    let mut found = FilesInUse::default();
    for (entity, shadow, transform, light, mut status) in &mut lights {
        let new = match patch.state() {
            PatchState::Pending => BakedShadowStatus::Waiting,
            PatchState::Failed(error) => BakedShadowStatus::Unusable(error.clone()),
            PatchState::Done if !light.shadow_maps_enabled => {
                BakedShadowStatus::Unusable(BakedShadowError::NoShadowMaps)
            }
            PatchState::Done => {
                add_files(shadow, transform.back().as_vec3(), &files, &server, *limits, &mut found.0)
            }
        };
        if *status != new {
            log_change(entity, &status, &new);
            commands.trigger(BakedShadowChanged { entity, status: new.clone() });
            *status = new;
        }
    }
    in_use.set_if_neq(found);
}

fn log_change(light: Entity, before: &BakedShadowStatus, now: &BakedShadowStatus) {
    match (before, now) {
        // A sun that moves changes the angle in every frame.
        (BakedShadowStatus::Misaligned { .. }, BakedShadowStatus::Misaligned { .. }) => {}
        (_, BakedShadowStatus::Waiting | BakedShadowStatus::Active { .. }) => {
            info!("the baked shadow of light {light} is {now}");
        }
        (_, BakedShadowStatus::Misaligned { .. } | BakedShadowStatus::Unusable(_)) => {
            warn!("the baked shadow of light {light} is {now}. Shadows come from the light's cascades");
        }
    }
}

/// Adds the ways in which files in use are looked up to the shaders, when the first one needs it.
pub(crate) fn add_ways(
    in_use: Res<FilesInUse>,
    mut shaders: ResMut<Assets<Shader>>,
    mut patch: ResMut<ShaderPatch>,
) {
    let ways = in_use.0.iter().map(|file| file.way);
    // Neither resource is marked as changed for nothing.
    if !ways.clone().all(|way| patch.has_way(way)) {
        patch.add_ways(ways, &mut shaders);
    }
}

/// Adds a light's files to those in use. Returns its status.
fn add_files(
    shadow: &BakedShadow,
    towards_light: Vec3,
    files: &Assets<BakedShadowFile>,
    server: &AssetServer,
    limits: DeviceLimits,
    in_use: &mut Vec<FileInUse>,
) -> BakedShadowStatus {
    let mut added = 0;
    let mut nearest_degrees = f32::INFINITY;
    let mut error = None;
    for handle in &shadow.files {
        let Some(file) = files.get(handle) else {
            if let Some(LoadState::Failed(cause)) = server.get_load_state(handle) {
                error = Some(BakedShadowError::NotLoaded(cause.into()));
            }
            continue;
        };
        let towards_sun = file.towards_sun();
        if towards_sun.distance(towards_light) > SAME_SUN {
            nearest_degrees = nearest_degrees.min(towards_sun.angle_between(towards_light).to_degrees());
            continue;
        }
        match file_in_use(file, shadow) {
            Ok(new) => {
                let is_known = in_use.iter().any(|other| Arc::ptr_eq(&other.texture, &new.texture));
                let rows: u32 = in_use.iter().chain([&new]).map(|file| file.texture.height()).sum();
                if is_known {
                    added += 1;
                } else if in_use.len() == MAX_FILES {
                    error = Some(BakedShadowError::TooManyFiles { limit: MAX_FILES });
                } else if rows >= limits.max_texture_side {
                    error = Some(BakedShadowError::TooManyRows { rows, limit: limits.max_texture_side });
                } else {
                    in_use.push(new);
                    added += 1;
                }
            }
            Err(cause) => error = Some(cause),
        }
    }
    match error {
        _ if added > 0 => BakedShadowStatus::Active { files: added },
        Some(error) => BakedShadowStatus::Unusable(error),
        None if nearest_degrees.is_finite() => BakedShadowStatus::Misaligned { degrees: nearest_degrees },
        None if shadow.files.is_empty() => BakedShadowStatus::Unusable(BakedShadowError::NoFiles),
        None => BakedShadowStatus::Waiting,
    }
}

fn file_in_use(asset: &BakedShadowFile, shadow: &BakedShadow) -> Result<FileInUse, BakedShadowError> {
    let texture = asset.texture().map_err(|error| BakedShadowError::File(error.clone()))?;
    let penumbra = shadow.softness.map(|angle| Penumbra { sun_degrees: angle.into(), ..Penumbra::default() });
    let look_up = LookUp { filter: shadow.filter.into(), bias: shadow.bias.map(Into::into), penumbra };
    let anchor = texture.anchor_world().map(f64::from);
    let parameters = asset.file().gpu().parameters(&look_up, anchor);
    let parameters = parameters.map_err(|error| BakedShadowError::Setting(error.into()))?;
    Ok(FileInUse {
        way: if penumbra.is_some() { Way::Soft } else { Way::Filtered },
        texture: Arc::clone(texture),
        header: texture.header_with(parameters),
        towards_sun: asset.towards_sun(),
    })
}
