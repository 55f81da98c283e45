//! Bakes keys ahead of a light that is followed.

use std::fmt;
use std::sync::{Arc, Mutex};

use adumbra::Sun;
use adumbra_bake::{BakeOptions, Size};
use adumbra_path::{FollowOptions, Followed, SunFollower};
use adumbra_scene::Scene;
use bevy::ecs::prelude::*;
use bevy::log::info;
use bevy::math::Vec3;
use bevy::prelude::{DirectionalLight, GlobalTransform};
use bevy::time::{Real, Time};

use super::gather::{Placed, SceneAssets, gather};
use super::progress::{BakeError, BakeProgress};
use super::{BakeInputs, BakeSettings, Keys, Meshes, RuntimeBake, StaticKeys, fail, is_still};
use crate::components::BakedShadow;
use crate::moving::SunKeys;

/// A follower, and the meshes in its keys.
pub(super) struct Following {
    /// Components must be `Sync`, and the follower's channels are not.
    follower: Mutex<SunFollower>,
    meshes: Arc<Keys>,
}

impl fmt::Debug for Following {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Following").field("meshes", &self.meshes.len()).finish_non_exhaustive()
    }
}

/// Lights that may be followed.
type Lights<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        &'static GlobalTransform,
        &'static mut RuntimeBake,
        &'static mut BakeProgress,
        Option<&'static BakedShadow>,
        Option<&'static mut SunKeys>,
    ),
    With<DirectionalLight>,
>;

/// Follows lights: restarts when meshes change, and takes the keys that answer in this frame.
pub(crate) fn follow_suns(
    mut commands: Commands,
    mut lights: Lights,
    placed: Meshes,
    assets: SceneAssets,
    (keys, time): (Res<StaticKeys>, Res<Time<Real>>),
) {
    for (light, transform, mut bake, mut progress, shadow, sun_keys) in &mut lights {
        let bake = bake.bypass_change_detection();
        if !shadow.is_some_and(|shadow| shadow.follow) {
            if sun_keys.is_some() {
                (bake.following, bake.seen, bake.in_use) = (None, None, None);
                commands.entity(light).remove::<SunKeys>();
            }
            continue;
        }
        let Some(mut sun_keys) = sun_keys else {
            // A bake for a fixed sun is no longer needed.
            (bake.job, bake.seen) = (None, None);
            commands.entity(light).try_insert(SunKeys::default());
            continue;
        };
        if bake.has_lost_all(&keys.keys) {
            (bake.following, bake.seen, bake.pending, bake.in_use) = (None, None, None, None);
            *sun_keys = SunKeys::default();
            progress.set_if_neq(BakeProgress::Waiting);
            continue;
        }
        let towards_light = transform.back().as_vec3();
        // Keys do not depend on where the light is now.
        let now =
            BakeInputs { settings: bake.settings, towards_light: Vec3::ZERO, keys: Arc::clone(&keys.keys) };
        if bake.seen.as_ref().is_some_and(|seen| seen.is_like(&now)) {
            bake.pending = None;
        } else if is_still(&mut bake.pending, &now, bake.seen.is_none(), time.elapsed()) {
            match gather(placed.iter().map(Placed::from), &assets) {
                // Some are not loaded yet.
                Ok(None) => bake.pending = Some((now, time.elapsed())),
                Ok(Some(scene)) => {
                    match start(Arc::new(scene), now.settings) {
                        Ok(follower) => {
                            let (follower, meshes) = (Mutex::new(follower), Arc::clone(&now.keys));
                            bake.following = Some(Following { follower, meshes });
                            // Clear an earlier failure: the bake is tried again.
                            if matches!(*progress, BakeProgress::Failed(_)) {
                                *progress = BakeProgress::Waiting;
                            }
                        }
                        Err(error) => fail(light, &mut progress, error),
                    }
                    (bake.pending, bake.seen) = (None, Some(now));
                }
                Err(error) => {
                    fail(light, &mut progress, error);
                    (bake.pending, bake.seen) = (None, Some(now));
                }
            }
        }
        let towards_sun = towards_light.as_dvec3().normalize().to_array();
        let Some(Following { follower, meshes }) = &mut bake.following else { continue };
        let follower = follower.get_mut().unwrap_or_else(|e| e.into_inner());
        match follower.follow(time.elapsed_secs_f64(), towards_sun) {
            Followed::Night => sun_keys.set_night(),
            // The keys of the previous follower answer meanwhile.
            Followed::Waiting => sun_keys.turn(towards_sun),
            Followed::Moment(moment) => {
                sun_keys.set(moment.keys, moment.towards_sun);
                let is_known = bake.in_use.as_ref().is_some_and(|known| Arc::ptr_eq(known, meshes));
                // Until the new keys are shown, moved meshes cast through the cascades.
                if !is_known && sun_keys.is_settled() {
                    bake.in_use = Some(Arc::clone(meshes));
                    info!("the shadow of light {light} follows the sun: its first key is baked");
                }
                if !matches!(*progress, BakeProgress::Failed(_)) {
                    let (is_baking, coarser) = (follower.is_baking(), moment.coarser as u32);
                    progress.set_if_neq(BakeProgress::Following { is_baking, coarser });
                }
            }
        }
        if let Some(error) = follower.take_fault() {
            // The next bake would fail the same way.
            follower.stop();
            fail(light, &mut progress, BakeError::Follow(error.into()));
        }
    }
}

/// Starts to bake keys of a scene.
fn start(scene: Arc<Scene>, settings: BakeSettings) -> Result<SunFollower, BakeError> {
    // A placeholder: each key replaces the sun.
    let any = Sun::from_direction([0.0, 1.0, 0.0]).map_err(|e| BakeError::Sun(e.into()))?;
    let bake = BakeOptions::new(any, Size::Resolution(settings.resolution.into()))
        .with(|o| o.thickness_world = settings.thickness_world.into());
    let options = FollowOptions { threads: settings.threads.max(1), ..FollowOptions::new(bake) };
    SunFollower::start(scene, options, || {}).map_err(|e| BakeError::Follow(e.into()))
}
