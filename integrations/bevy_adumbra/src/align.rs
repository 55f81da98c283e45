//! Keeps lights at the sun of their files, and restores the app's rotation afterwards.

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

/// A light is not turned if its unit vector is at most this far from its sun's, 6e-4 degrees.
const TURNED: f32 = 1e-5;

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
    for (light, shadow, parent) in lights.iter().filter(|(_, shadow, _)| is_kept(shadow)) {
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
        // With an exact test, a light that rounding keeps off this direction would turn in every frame.
        let towards_light = (parent * (transform.rotation * Vec3::Z)).normalize_or_zero();
        // A parent may stretch or mirror its lights. Below a parent with zero scale there is no direction.
        let [towards, up] = [towards_sun, Vec3::Y].map(|d| (parent.inverse() * d).normalize_or_zero());
        if towards_light.distance(towards_sun) <= TURNED || !towards.is_normalized() {
            continue;
        }
        let of_app = transform.rotation;
        let given = Transform::default().looking_to(-towards, up).rotation;
        transform.rotation = given;
        match aligned {
            None => {
                commands.entity(light).try_insert(Aligned { of_app, given, has_warned: false });
            }
            // The light's parent or its file has turned.
            Some(mut aligned) if aligned.given == of_app => aligned.given = given,
            Some(mut aligned) => {
                if !aligned.has_warned {
                    let degrees = towards_light.angle_between(towards_sun).to_degrees();
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

/// Whether a light is kept at the sun of its files. A light that is followed keeps the app's direction.
fn is_kept(shadow: &BakedShadow) -> bool {
    shadow.align && !shadow.follow
}

/// Restores the app's last rotation of lights that are no longer kept.
pub(crate) fn give_back(
    mut commands: Commands,
    mut lights: Query<(Entity, &Aligned, Option<&BakedShadow>, &mut Transform)>,
) {
    for (light, aligned, shadow, mut transform) in &mut lights {
        if shadow.is_some_and(is_kept) {
            continue;
        }
        if transform.rotation == aligned.given {
            transform.rotation = aligned.of_app;
        }
        commands.entity(light).try_remove::<Aligned>();
    }
}

#[cfg(test)]
mod tests {
    use adumbra_bake::{Bake, BakeOptions, Size};
    use adumbra_scene::{GeneratedKind, generate};

    use super::*;

    #[test]
    fn aligns_a_light_below_a_rig_that_turns() {
        let sun = adumbra::Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
        let towards_sun = Vec3::from_array(sun.towards().map(|c| c as f32));
        let options = BakeOptions::new(sun, Size::Resolution(64));
        let file = Bake::with_options(&generate(GeneratedKind::Primitives, 1), &options).in_memory().unwrap();
        let mut world = World::new();
        world.init_resource::<Rooted>();
        world.init_resource::<ShadowStreams>();
        world.init_resource::<Assets<BakedShadowFile>>();
        let file = BakedShadowFile::new(file, crate::DeviceLimits::default()).unwrap();
        let file = world.resource_mut::<Assets<BakedShadowFile>>().add(file);
        let of_app = Quat::from_rotation_x(-1.0);
        let rig = world.spawn(Transform::default()).id();
        let light = (DirectionalLight::default(), BakedShadow::new(file), Transform::from_rotation(of_app));
        let light = world.spawn((light, ChildOf(rig))).id();
        let mut systems = Schedule::default();
        systems.add_systems((give_back, align_lights).chain());
        for radians in [1.570_796_4, 1.6, 2.9, -0.4] {
            let turned = Quat::from_rotation_y(radians);
            world.get_mut::<Transform>(rig).unwrap().rotation = turned;
            systems.run(&mut world);
            let towards = turned * (world.get::<Transform>(light).unwrap().rotation * Vec3::Z);
            assert!(towards.distance(towards_sun) < TURNED, "{radians}");
            assert!(!world.get::<Aligned>(light).unwrap().has_warned);
        }
        world.entity_mut(light).remove::<BakedShadow>();
        systems.run(&mut world);
        assert_eq!(world.get::<Transform>(light).unwrap().rotation, of_app);
    }

    #[test]
    fn does_not_align_a_light_that_is_followed() {
        let kept = BakedShadow { align: true, ..BakedShadow::default() };
        assert!(is_kept(&kept));
        assert!(!is_kept(&BakedShadow { follow: true, ..kept }));
    }
}
