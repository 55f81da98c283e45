//! Compares the views that Bevy draws with another renderer's ray-traced truth images. Skipped if the images
//! are absent, see CONTRIBUTING.md. One view of six, unless `ADUMBRA_FULL` is set.

use adumbra::{Filter, ShadowFile, Sun};
use adumbra_bake::{Bake, BakeOptions, Size};
use adumbra_scene::{LoadOptions, Scene, load};
use adumbra_testing::{full, npz_array, npz_camera, scene_file, shared};
use bevy::asset::RenderAssetUsages;
use bevy::camera::RenderTarget;
use bevy::math::Affine3A;
use bevy::mesh::PrimitiveTopology;
use bevy::prelude::*;
use bevy::render::render_resource::TextureFormat;
use bevy_adumbra::prelude::*;

use crate::stage::{Stage, picture};

const SIZE: UVec2 = UVec2::new(320, 240);

/// Percentage of the pixels with n·l > 0.1 that are on the wrong side of 1/2.
fn wrong_percent(found: &[f32], sun: &[f32], n_dot_l: &[f32]) -> f64 {
    let compared: Vec<usize> = (0..found.len()).filter(|&i| n_dot_l[i] > 0.1).collect();
    let wrong = compared.iter().filter(|&&i| (found[i] < 0.5) != (sun[i] < 0.5)).count();
    100.0 * wrong as f64 / compared.len() as f64
}

#[test]
#[ignore = "slow: draws many frames"]
fn bevy_is_as_accurate_as_look_ups_on_shared_views() {
    let (Some(truths), Some(scenes)) = (shared("truth"), shared("scenes")) else { return };
    let all = ["kaykit_city_21", "alpine-2", "box-city-5k", "zdm2", "auster", "dragon_202k"];
    for name in if full() { &all[..] } else { &all[..1] } {
        let (truth, path) = (truths.join(format!("{name}.npz")), scene_file(&scenes, name));
        let camera = npz_camera(&truth);
        let vector = |key: &str| [0, 1, 2].map(|i| camera[key][i].as_f64().unwrap());
        let [sun, n_dot_l]: [Vec<f32>; 2] = ["sun", "ndotl"].map(|array| npz_array(&truth, array));
        let scene = load(&path, &LoadOptions { ignore_alpha: true, ..LoadOptions::default() }).unwrap();
        let options = BakeOptions::new(Sun::from_direction(vector("sun")).unwrap(), Size::Resolution(16_384))
            .with(|o| o.ignore_alpha = true);
        let file = Bake::with_options(&scene, &options).in_memory().unwrap();
        // The file's visibility at the points that the other renderer saw.
        let [positions, normals]: [Vec<f32>; 2] = ["pos", "normal"].map(|array| npz_array(&truth, array));
        let shadow = file.sampler(Filter::Nearest);
        let at = |v: &[f32], i: usize| [0, 1, 2].map(|a| f64::from(v[3 * i + a]));
        let asked: Vec<f32> = (0..sun.len())
            .map(|i| {
                if n_dot_l[i] > 0.1 {
                    shadow.visibility(at(&positions, i), Some(at(&normals, i)))
                } else {
                    1.0
                }
            })
            .collect();
        let by_file = wrong_percent(&asked, &sun, &n_dot_l);
        let fov = camera["fov_y"].as_f64().unwrap() as f32;
        let drawn = draw(&scene, file, vector("eye"), vector("target"), fov.to_radians());
        let by_bevy = wrong_percent(&drawn, &sun, &n_dot_l);
        println!("{name}: {by_bevy:.2} % of pixels wrong, {by_file:.2} % by look-ups at the same points");
        assert!(by_bevy <= by_file + 0.1, "{name}: {by_bevy:.2} {by_file:.2}");
    }
}

/// Returns the visibility that Bevy draws at each pixel.
fn draw(scene: &Scene, file: ShadowFile, eye: [f64; 3], target: [f64; 3], fov: f32) -> Vec<f32> {
    let mut stage = Stage::new(|_| {});
    stage.give(file, |shadow| shadow.filter = ShadowFilter::Nearest);
    let world = stage.app.world_mut();
    world.despawn(stage.square);
    let picture = picture(world, SIZE, TextureFormat::Rgba16Float);
    let [eye, target] = [eye, target].map(|p| Vec3::from_array(p.map(|c| c as f32)));
    world.entity_mut(stage.camera).insert((
        RenderTarget::from(picture.clone()),
        Projection::from(PerspectiveProjection {
            fov,
            near: 1e-3 * eye.distance(target),
            far: 1e6,
            ..default()
        }),
        Transform::from_translation(eye).looking_at(target, Vec3::Y),
    ));
    stage.picture = picture;
    let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
    let material = materials.get_mut(&stage.material).unwrap().into_inner();
    (material.double_sided, material.cull_mode) = (true, None);
    let meshes: Vec<Handle<Mesh>> = scene
        .meshes
        .iter()
        .map(|mesh| {
            let corners = mesh.triangles.iter().flatten();
            let positions: Vec<[f32; 3]> = corners.map(|&i| mesh.positions[i as usize]).collect();
            let mut new = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
            new.insert_attribute(Mesh::ATTRIBUTE_POSITION, positions);
            new.compute_flat_normals();
            world.resource_mut::<Assets<Mesh>>().add(new)
        })
        .collect();
    let root = world.spawn((ShadowStatic, Transform::default(), Visibility::default())).id();
    for instance in &scene.instances {
        let row = |r: usize| instance.world_from_mesh[r].map(|c| c as f32);
        let [x, y, z] = [row(0), row(1), row(2)];
        let column = |c: usize| Vec3::new(x[c], y[c], z[c]);
        let affine =
            Affine3A::from_mat3_translation(Mat3::from_cols(column(0), column(1), column(2)), column(3));
        world.spawn((
            Mesh3d(meshes[instance.mesh as usize].clone()),
            MeshMaterial3d(stage.material.clone()),
            Transform::from_matrix(Mat4::from(affine)),
            ChildOf(root),
        ));
    }
    stage.visibility()
}
