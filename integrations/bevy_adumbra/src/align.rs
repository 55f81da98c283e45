//! Lights are kept at the sun of their files, and are the app's again afterwards.

use bevy::asset::Assets;
use bevy::ecs::prelude::*;
use bevy::log::warn;
use bevy::math::{Mat3A, Quat, Vec3};
use bevy::prelude::{ChildOf, DirectionalLight, Transform, TransformHelper};

use crate::BakedShadowFile;
use crate::components::{BakedShadow, FileRoot};
use crate::placing::{Places, Rooted, Roots, turned};
use crate::stream::ShadowStreams;

/// A light that was turned.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub(crate) struct Aligned {
    /// The rotation that the app has set last.
    of_app: Quat,
    /// The rotation that the light was given.
    given: Quat,
    has_warned: bool,
}

/// A light that is off by less is not turned, degrees.
const TURNED_DEGREES: f32 = 6e-4;

/// Turns lights to the sun of their first loaded file, where its root is now.
pub(crate) fn align_lights(
    mut commands: Commands,
    lights: Query<(Entity, &BakedShadow, Option<&ChildOf>), With<DirectionalLight>>,
    (roots, rooted): (Query<(Entity, &FileRoot)>, Res<Rooted>),
    mut transforms: ParamSet<(TransformHelper, Query<(&mut Transform, Option<&mut Aligned>)>)>,
    files: Res<Assets<BakedShadowFile>>,
    streams: Res<ShadowStreams>,
) {
    let helper = transforms.p0();
    let at_root = |(entity, root)| Some((entity, root, helper.compute_global_transform(entity).ok()?));
    let roots = Roots::new(&rooted, roots.iter().filter_map(at_root));
    let mut turns = Vec::new();
    for (light, shadow, parent) in lights.iter().filter(|(_, shadow, _)| shadow.align) {
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
        let parent = parent.map_or(Mat3A::IDENTITY, |parent| parent.affine().matrix3);
        turns.push((light, parent, towards_sun));
    }
    let mut all = transforms.p1();
    for (light, parent, towards_sun) in turns {
        let Ok((mut transform, aligned)) = all.get_mut(light) else { continue };
        // An exact test would turn a light at every frame that cannot have just this direction.
        let degrees = (parent * (transform.rotation * Vec3::Z)).angle_between(towards_sun).to_degrees();
        // A parent may stretch or mirror its lights. Below one without a size there is no direction.
        let [towards, up] = [towards_sun, Vec3::Y].map(|d| (parent.inverse() * d).normalize_or_zero());
        if degrees.is_nan() || degrees <= TURNED_DEGREES || !towards.is_normalized() {
            continue;
        }
        let of_app = transform.rotation;
        let given = Transform::default().looking_to(-towards, up).rotation;
        transform.rotation = given;
        match aligned {
            None => {
                commands.entity(light).try_insert(Aligned { of_app, given, has_warned: false });
            }
            // Its parent turns, or its file.
            Some(mut aligned) if aligned.given == of_app => aligned.given = given,
            Some(mut aligned) => {
                if !aligned.has_warned {
                    warn!(
                        "light {light} was turned by {degrees:.2} degrees, and BakedShadow::align keeps it at the sun of its \
                         file; set it to false for a light that something else turns"
                    );
                }
                *aligned = Aligned { of_app, given, has_warned: true };
            }
        }
    }
}

/// Gives lights that are kept no longer the rotation that the app has set last.
pub(crate) fn give_back(
    mut commands: Commands,
    mut lights: Query<(Entity, &Aligned, Option<&BakedShadow>, &mut Transform)>,
) {
    for (light, aligned, shadow, mut transform) in &mut lights {
        if shadow.is_some_and(|shadow| shadow.align) {
            continue;
        }
        if transform.rotation == aligned.given {
            transform.rotation = aligned.of_app;
        }
        commands.entity(light).try_remove::<Aligned>();
    }
}
