//! Which files are in use: those whose sun a light has. Decided once per frame, before cascades are made, so that
//! cascades and files never both leave a shadow out.

use bevy::asset::{AssetServer, Assets, LoadState};
use bevy::ecs::prelude::*;
use bevy::log::{info, warn};
use bevy::math::{Quat, Vec3};
use bevy::prelude::{ChildOf, DirectionalLight, GlobalTransform, Transform};
use bevy::shader::Shader;

use crate::components::BakedShadow;
use crate::error::BakedShadowError;
use crate::in_use::{FileInUse, FilesInUse, LightFiles};
use crate::moving::SunKeys;
use crate::patch::{PatchState, ShaderPatch};
use crate::status::{BakedShadowChanged, BakedShadowStatus};
use crate::stream::ShadowStreams;
use crate::{BakedShadowFile, DeviceLimits};

/// Turns lights to the sun of their first loaded file.
pub(crate) fn align_lights(
    mut lights: Query<(&BakedShadow, &mut Transform, Option<&ChildOf>), With<DirectionalLight>>,
    parents: Query<&GlobalTransform>,
    files: Res<Assets<BakedShadowFile>>,
    streams: Res<ShadowStreams>,
) {
    for (shadow, mut transform, parent) in &mut lights {
        let mut whole =
            shadow.files.iter().filter_map(|file| files.get(file).map(BakedShadowFile::towards_sun));
        let streamed =
            || shadow.streams.iter().find_map(|source| Some(streams.open_file(source)?.towards_sun));
        let Some(towards_sun) = whole.next().or_else(streamed) else { continue };
        if !shadow.align {
            continue;
        }
        let parent = parent.and_then(|parent| parents.get(parent.parent()).ok());
        let parent = parent.map_or(Quat::IDENTITY, |parent| parent.rotation());
        // An exact test would turn a light at every frame that cannot have just this direction.
        if (parent * transform.rotation * Vec3::Z).distance(towards_sun) > 1e-5 {
            let world = Transform::default().looking_to(-towards_sun, Vec3::Y).rotation;
            transform.rotation = parent.inverse() * world;
        }
    }
}

/// Where the files of lights are.
type Files<'w> = (Res<'w, Assets<BakedShadowFile>>, Res<'w, AssetServer>, Res<'w, ShadowStreams>);

/// Finds the files in use, and updates the status of every light.
pub(crate) fn find_files_in_use(
    mut commands: Commands,
    mut lights: Query<(
        Entity,
        &BakedShadow,
        &GlobalTransform,
        &DirectionalLight,
        Option<&SunKeys>,
        &mut BakedShadowStatus,
    )>,
    without_files: Query<Entity, (With<BakedShadowStatus>, Without<BakedShadow>)>,
    files: Files,
    (patch, limits): (Res<ShaderPatch>, Res<DeviceLimits>),
    mut in_use: ResMut<FilesInUse>,
) {
    for light in &without_files {
        commands.entity(light).try_remove::<BakedShadowStatus>();
    }
    let mut found = FilesInUse::default();
    for (entity, shadow, transform, light, keys, mut status) in &mut lights {
        let new = match patch.state() {
            PatchState::Pending => BakedShadowStatus::Waiting,
            PatchState::Failed(error) => BakedShadowStatus::Unusable(error.clone()),
            PatchState::Done if !light.shadow_maps_enabled => {
                BakedShadowStatus::Unusable(BakedShadowError::NoShadowMaps)
            }
            PatchState::Done => {
                let of_light = LightFiles {
                    in_use: &mut found.0,
                    limits: *limits,
                    towards_light: transform.back().as_vec3(),
                    added: 0,
                    nearest_degrees: f32::INFINITY,
                    error: None,
                };
                if shadow.follow {
                    follow(shadow, keys, of_light)
                } else {
                    add_files(shadow, &files, of_light)
                }
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
        (_, BakedShadowStatus::Waiting | BakedShadowStatus::Active { .. } | BakedShadowStatus::Night) => {
            info!("the baked shadow of light {light} is {now}");
        }
        (_, BakedShadowStatus::Incomplete { .. }) => warn!("the baked shadow of light {light} is {now}"),
        (_, BakedShadowStatus::Misaligned { .. } | BakedShadowStatus::Unusable(_)) => {
            warn!("the baked shadow of light {light} is {now}. Shadows come from the light's cascades");
        }
    }
}

/// Adds the keys of a light that is followed to the files in use. Returns its status.
fn follow(shadow: &BakedShadow, keys: Option<&SunKeys>, mut of_light: LightFiles) -> BakedShadowStatus {
    let Some(keys) = keys else {
        return BakedShadowStatus::Unusable(BakedShadowError::NothingFollows);
    };
    if shadow.softness.is_some() {
        return BakedShadowStatus::Unusable(BakedShadowError::SoftFollow);
    }
    if keys.is_night() {
        return BakedShadowStatus::Night;
    }
    let towards_light = of_light.towards_light;
    let put = |files: Vec<FileInUse>| files.into_iter().try_for_each(|file| of_light.put(file).map(|_| ()));
    match keys.files(shadow, towards_light).and_then(put) {
        Err(error) => BakedShadowStatus::Unusable(error),
        Ok(()) if keys.is_ready() => BakedShadowStatus::Active { files: 1 },
        Ok(()) => BakedShadowStatus::Waiting,
    }
}

/// Adds a light's files to those in use. Returns its status.
fn add_files(
    shadow: &BakedShadow,
    (files, server, streams): &Files,
    mut of_light: LightFiles,
) -> BakedShadowStatus {
    for handle in &shadow.files {
        if let Some(file) = files.get(handle) {
            of_light.add(file.towards_sun(), || FileInUse::whole(file, shadow));
        } else if let Some(LoadState::Failed(cause)) = server.get_load_state(handle) {
            of_light.error = Some(BakedShadowError::NotLoaded(cause.into()));
        }
    }
    let mut fault = None;
    for source in &shadow.streams {
        match streams.open_file(source) {
            Some(file) => {
                of_light.add(file.towards_sun, || file.in_use(shadow));
                fault = streams.fault(source).or(fault);
            }
            None => of_light.error = streams.fault(source).or(of_light.error),
        }
    }
    let LightFiles { added: files, nearest_degrees: degrees, error, .. } = of_light;
    match (error, fault) {
        (_, Some(fault)) if files > 0 => BakedShadowStatus::Incomplete { files, fault },
        _ if files > 0 => BakedShadowStatus::Active { files },
        (Some(error), _) => BakedShadowStatus::Unusable(error),
        _ if degrees.is_finite() => BakedShadowStatus::Misaligned { degrees },
        _ if shadow.files.is_empty() && shadow.streams.is_empty() => {
            BakedShadowStatus::Unusable(BakedShadowError::NoFiles)
        }
        _ => BakedShadowStatus::Waiting,
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
