//! Finds the files in use: those whose sun matches a light. It runs once per frame, before Bevy builds
//! cascades, so that cascades and files never both leave a shadow out.

use bevy::asset::{AssetServer, Assets, LoadState};
use bevy::ecs::prelude::*;
use bevy::log::{info, warn};
use bevy::prelude::{DirectionalLight, GlobalTransform};
use bevy::shader::Shader;

use crate::components::{BakedShadow, FileRoot};
use crate::error::BakedShadowError;
use crate::in_use::{FileInUse, FilesInUse, LightFiles, way};
use crate::moving::SunKeys;
use crate::patch::{PatchState, ShaderPatch};
use crate::placing::{Rooted, Roots, turned};
use crate::status::{BakedShadowChanged, BakedShadowStatus};
use crate::stream::ShadowStreams;
use crate::{BakedShadowFile, DeviceLimits};

/// The resources that hold the files of lights.
type Files<'w> = (Res<'w, Assets<BakedShadowFile>>, Res<'w, AssetServer>, Res<'w, ShadowStreams>);

/// The component that bakes files for a light.
#[cfg(feature = "bake")]
type Bakes = crate::bake::RuntimeBake;
#[cfg(not(feature = "bake"))]
#[derive(Component)]
enum Bakes {}

/// Finds the files in use, and updates the status of every light.
pub(crate) fn find_files_in_use(
    mut commands: Commands,
    mut lights: Query<(
        Entity,
        &BakedShadow,
        &GlobalTransform,
        Option<&DirectionalLight>,
        Option<&SunKeys>,
        Has<Bakes>,
        &mut BakedShadowStatus,
    )>,
    without_files: Query<Entity, (With<BakedShadowStatus>, Without<BakedShadow>)>,
    (roots, rooted): (Query<(Entity, &FileRoot, &GlobalTransform)>, Res<Rooted>),
    files: Files,
    (patch, limits): (Res<ShaderPatch>, Res<DeviceLimits>),
    mut in_use: ResMut<FilesInUse>,
) {
    for light in &without_files {
        commands.entity(light).try_remove::<BakedShadowStatus>();
    }
    let roots = Roots::new(&rooted, roots.iter().map(|(entity, root, at)| (entity, root, *at)));
    let mut found = FilesInUse::default();
    for (entity, shadow, transform, light, keys, bakes, mut status) in &mut lights {
        let new = match patch.state() {
            PatchState::Pending => BakedShadowStatus::Waiting,
            PatchState::Failed(error) => BakedShadowStatus::Unusable(error.clone()),
            PatchState::Done if light.is_none() => BakedShadowStatus::Unusable(BakedShadowError::NoLight),
            PatchState::Done if light.is_some_and(|light| !light.shadow_maps_enabled) => {
                BakedShadowStatus::Unusable(BakedShadowError::NoShadowMaps)
            }
            PatchState::Done => {
                let mut of_light = LightFiles {
                    in_use: &mut found.files,
                    limits: *limits,
                    towards_light: transform.back().as_vec3(),
                    added: 0,
                    missing: 0,
                    is_loading: false,
                    nearest_degrees: f32::INFINITY,
                    error: None,
                };
                let status = if shadow.follow {
                    follow(shadow, keys, &mut of_light)
                } else {
                    add_files(shadow, &files, &roots, &mut of_light)
                };
                // The bake has not delivered its file yet.
                let is_none = status == BakedShadowStatus::Unusable(BakedShadowError::NoFiles);
                let status = if bakes && is_none { BakedShadowStatus::Waiting } else { status };
                if !of_light.is_complete() {
                    found.partial.insert(entity);
                }
                status
            }
        };
        if *status != new {
            if !status.is_like(&new) {
                log_change(entity, &new);
                commands.trigger(BakedShadowChanged { entity, status: new.clone() });
            }
            *status = new;
        }
    }
    in_use.set_if_neq(found);
}

fn log_change(light: Entity, now: &BakedShadowStatus) {
    match now {
        BakedShadowStatus::Waiting | BakedShadowStatus::Active { .. } | BakedShadowStatus::Night => {
            info!("the baked shadow of light {light} is {now}");
        }
        BakedShadowStatus::Incomplete { .. } => warn!("the baked shadow of light {light} is {now}"),
        BakedShadowStatus::Misaligned { .. } | BakedShadowStatus::Unusable(_) => {
            warn!("the baked shadow of light {light} is {now}. Shadows come from the light's cascades");
        }
    }
}

/// Adds the keys of a light that is followed to the files in use. Returns its status.
fn follow(shadow: &BakedShadow, keys: Option<&SunKeys>, of_light: &mut LightFiles) -> BakedShadowStatus {
    let Some(keys) = keys else {
        return BakedShadowStatus::Unusable(BakedShadowError::NothingFollows);
    };
    if shadow.sun_degrees.is_some() {
        return BakedShadowStatus::Unusable(BakedShadowError::SoftFollow);
    }
    if keys.is_night() {
        return BakedShadowStatus::Night;
    }
    let towards_light = of_light.towards_light;
    let before = of_light.in_use.len();
    let put = |files: Vec<FileInUse>| files.into_iter().try_for_each(|file| of_light.put(file).map(|_| ()));
    match keys.files(shadow, towards_light).and_then(put) {
        Err(error) => {
            // Keep either all keys of the light or none.
            of_light.in_use.truncate(before);
            BakedShadowStatus::Unusable(error)
        }
        Ok(()) if keys.is_ready() => BakedShadowStatus::Active { files: 1 },
        Ok(()) => BakedShadowStatus::Waiting,
    }
}

/// Adds a light's files to those in use. Returns its status.
fn add_files(
    shadow: &BakedShadow,
    (files, server, streams): &Files,
    roots: &Roots,
    of_light: &mut LightFiles,
) -> BakedShadowStatus {
    for handle in &shadow.files {
        if let Some(file) = files.get(handle) {
            let towards_sun = file.file().sun().towards();
            let places = roots.of_file(handle.id());
            of_light.is_loading |= places.is_empty();
            for place in places {
                match place {
                    Ok(place) => {
                        of_light.add(turned(&place, towards_sun), || FileInUse::whole(file, place, shadow))
                    }
                    Err(error) => of_light.miss(error),
                }
            }
        } else if let Some(LoadState::Failed(cause)) = server.get_load_state(handle) {
            of_light.miss(BakedShadowError::NotLoaded(cause.into()));
        } else {
            of_light.is_loading = true;
        }
    }
    let mut part = None;
    for source in &shadow.streams {
        let Some(file) = streams.open_file(source) else {
            match streams.fault(source) {
                Some(fault) => of_light.miss(fault),
                None => of_light.is_loading = true,
            }
            continue;
        };
        let places = roots.of_stream(source);
        of_light.is_loading |= places.is_empty();
        for place in places {
            match place {
                Ok(place) => {
                    of_light.add(turned(&place, file.towards_sun), || file.in_use(place, shadow));
                }
                Err(error) => of_light.miss(error),
            }
        }
        part = streams.fault(source).or(part);
    }
    let LightFiles { added: files, missing, nearest_degrees: degrees, .. } = *of_light;
    match (of_light.error.take(), part) {
        (Some(fault), _) if files > 0 => BakedShadowStatus::Incomplete { files, missing, fault },
        (None, Some(fault)) if files > 0 => BakedShadowStatus::Incomplete { files, missing, fault },
        _ if files > 0 => BakedShadowStatus::Active { files },
        (Some(error), _) => BakedShadowStatus::Unusable(error),
        _ if degrees.is_finite() => BakedShadowStatus::Misaligned { degrees },
        _ if shadow.files.is_empty() && shadow.streams.is_empty() => {
            BakedShadowStatus::Unusable(BakedShadowError::NoFiles)
        }
        _ => BakedShadowStatus::Waiting,
    }
}

/// Adds the look-up ways that lights need to the shaders. A way is added as soon as a light needs it, before
/// the light's file is loaded, so that pipelines are not recompiled when the file arrives.
pub(crate) fn add_ways(
    lights: Query<&BakedShadow>,
    mut shaders: ResMut<Assets<Shader>>,
    mut patch: ResMut<ShaderPatch>,
) {
    let ways = lights.iter().map(way);
    // Do not mark either resource as changed without need.
    if !ways.clone().all(|way| patch.has_way(way)) {
        patch.add_ways(ways, &mut shaders);
    }
}
