//! Which files are in use: those whose sun a light has. Decided once per frame, before cascades are made, so that
//! cascades and files never both leave a shadow out.

use bevy::asset::{AssetServer, Assets, LoadState};
use bevy::ecs::prelude::*;
use bevy::log::{info, warn};
use bevy::math::{Quat, Vec3};
use bevy::prelude::{ChildOf, DirectionalLight, GlobalTransform, Transform, TransformHelper};
use bevy::shader::Shader;

use crate::components::{BakedShadow, FileRoot};
use crate::error::BakedShadowError;
use crate::in_use::{FileInUse, FilesInUse, LightFiles};
use crate::moving::SunKeys;
use crate::patch::{PatchState, ShaderPatch};
use crate::placing::{Places, Roots, turned};
use crate::status::{BakedShadowChanged, BakedShadowStatus};
use crate::stream::ShadowStreams;
use crate::{BakedShadowFile, DeviceLimits};

/// The sun that a light was turned to last.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct AlignedTo {
    towards_sun: Vec3,
    has_warned: bool,
}

/// Turns lights to the sun of their first loaded file, where its root is now.
pub(crate) fn align_lights(
    mut commands: Commands,
    lights: Query<(Entity, &BakedShadow, Option<&ChildOf>, Option<&AlignedTo>), With<DirectionalLight>>,
    roots: Query<(Entity, &FileRoot)>,
    mut transforms: ParamSet<(TransformHelper, Query<&mut Transform>)>,
    files: Res<Assets<BakedShadowFile>>,
    streams: Res<ShadowStreams>,
) {
    let helper = transforms.p0();
    let roots = Roots::new(
        roots.iter().filter_map(|(entity, root)| Some((root, helper.compute_global_transform(entity).ok()?))),
    );
    let mut turns = Vec::new();
    for (light, shadow, parent, before) in lights.iter().filter(|(_, shadow, ..)| shadow.align) {
        let first = |places: Places, towards: [f64; 3]| {
            places.into_iter().flatten().next().map(|place| turned(&place, towards))
        };
        let mut whole = shadow
            .files
            .iter()
            .filter_map(|file| first(roots.of_file(file.id()), files.get(file)?.file().sun().towards()));
        let streamed = || {
            shadow
                .streams
                .iter()
                .find_map(|source| first(roots.of_stream(source), streams.open_file(source)?.towards_sun))
        };
        let Some(towards_sun) = whole.next().or_else(streamed) else { continue };
        let parent = parent.and_then(|parent| helper.compute_global_transform(parent.parent()).ok());
        let parent = parent.map_or(Quat::IDENTITY, |parent| parent.rotation());
        turns.push((light, parent, towards_sun, before.copied()));
    }
    let mut all = transforms.p1();
    for (light, parent, towards_sun, before) in turns {
        let Ok(mut transform) = all.get_mut(light) else { continue };
        // An exact test would turn a light at every frame that cannot have just this direction.
        let degrees = (parent * transform.rotation * Vec3::Z).angle_between(towards_sun).to_degrees();
        if degrees > TURNED_DEGREES {
            let world = Transform::default().looking_to(-towards_sun, Vec3::Y).rotation;
            transform.rotation = parent.inverse() * world;
        }
        let is_turned =
            degrees > TURNED_DEGREES && before.is_some_and(|before| before.towards_sun == towards_sun);
        let has_warned = before.is_some_and(|before| before.has_warned);
        if is_turned && !has_warned {
            warn!(
                "light {light} was turned by {degrees:.2} degrees, and BakedShadow::align keeps it at the sun of its file; \
                 set it to false for a light that something else turns"
            );
        }
        if before.is_none_or(|before| before.towards_sun != towards_sun) || (is_turned && !has_warned) {
            let aligned = AlignedTo { towards_sun, has_warned: has_warned || is_turned };
            commands.entity(light).try_insert(aligned);
        }
    }
}

/// A light that is off by less is not turned, degrees.
const TURNED_DEGREES: f32 = 6e-4;

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
    roots: Query<(&FileRoot, &GlobalTransform)>,
    files: Files,
    (patch, limits): (Res<ShaderPatch>, Res<DeviceLimits>),
    mut in_use: ResMut<FilesInUse>,
) {
    for light in &without_files {
        commands.entity(light).try_remove::<BakedShadowStatus>();
    }
    let roots = Roots::new(roots.iter().map(|(root, transform)| (root, *transform)));
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
                    missing: 0,
                    nearest_degrees: f32::INFINITY,
                    error: None,
                };
                if shadow.follow {
                    follow(shadow, keys, of_light)
                } else {
                    add_files(shadow, &files, &roots, of_light)
                }
            }
        };
        if *status != new {
            // A sun that moves changes the angle in every frame.
            let is_angle =
                |status: &BakedShadowStatus| matches!(status, BakedShadowStatus::Misaligned { .. });
            if !(is_angle(&status) && is_angle(&new)) {
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
    roots: &Roots,
    mut of_light: LightFiles,
) -> BakedShadowStatus {
    for handle in &shadow.files {
        if let Some(file) = files.get(handle) {
            let towards_sun = file.file().sun().towards();
            for place in roots.of_file(handle.id()) {
                match place {
                    Ok(place) => {
                        of_light.add(turned(&place, towards_sun), || FileInUse::whole(file, place, shadow))
                    }
                    Err(error) => of_light.miss(error),
                }
            }
        } else if let Some(LoadState::Failed(cause)) = server.get_load_state(handle) {
            of_light.miss(BakedShadowError::NotLoaded(cause.into()));
        }
    }
    let mut part = None;
    for source in &shadow.streams {
        let Some(file) = streams.open_file(source) else {
            if let Some(fault) = streams.fault(source) {
                of_light.miss(fault);
            }
            continue;
        };
        for place in roots.of_stream(source) {
            match place {
                Ok(place) => {
                    of_light.add(turned(&place, file.towards_sun), || file.in_use(place, shadow));
                }
                Err(error) => of_light.miss(error),
            }
        }
        part = streams.fault(source).or(part);
    }
    let LightFiles { added: files, missing, nearest_degrees: degrees, error, .. } = of_light;
    match (error, part) {
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
