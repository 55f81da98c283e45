//! Tests shadows that no receiver in the same column requires: beside a wall's foot under a filter, and below
//! casters sunward of the bounds.

use adumbra::{Bounds, Filter, ShadowFile, Sun};
use adumbra_bake::{Bake, BakeOptions, FrameChoice, Size};
use adumbra_scene::{Instance, Material, Mesh, Scene};

const UP: [f64; 3] = [0.0, 1.0, 0.0];

/// Builds closed boxes from minimum and maximum corners.
fn boxes(corners: &[([f32; 3], [f32; 3])]) -> Scene {
    let mut mesh = Mesh { name: "boxes".to_owned(), ..Default::default() };
    for (min, max) in corners {
        let first = mesh.positions.len() as u32;
        let corner = |c: usize| [0, 1, 2].map(|a| if c >> a & 1 == 0 { min[a] } else { max[a] });
        mesh.positions.extend((0..8).map(corner));
        // Anticlockwise from outside; bit 0 of a corner's number is x, bit 1 y, bit 2 z.
        let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6_u32]];
        for [a, b, c, d] in faces.map(|face| face.map(|corner| first + corner)) {
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh.triangle_materials = vec![0; mesh.triangles.len()];
    let world_from_mesh = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    Scene {
        meshes: vec![mesh],
        instances: vec![Instance { name: "boxes".to_owned(), mesh: 0, world_from_mesh, casts: true }],
        materials: vec![Material::opaque("white", [1.0; 4])],
        ..Default::default()
    }
}

fn bake(scene: &Scene, sun: [f64; 3], change: impl FnOnce(&mut BakeOptions)) -> ShadowFile {
    let sun = Sun::from_direction(sun).unwrap();
    let options = BakeOptions::new(sun, Size::Resolution(512)).with(change);
    Bake::with_options(scene, &options).in_memory().unwrap()
}

/// Returns the mean visibility of points with this normal under a filter.
fn mean(file: &ShadowFile, points: &[[f64; 3]], normal: Option<[f64; 3]>, filter: Filter) -> f64 {
    let sampler = file.sampler(filter);
    let sum: f64 = points.iter().map(|&p| f64::from(sampler.visibility(p, normal))).sum();
    sum / points.len() as f64
}

/// Walls on flat ground: along the foot, on the side away from the sun, every tap of a filter finds wall or
/// shadow.
#[test]
fn contact_shadows_reach_a_walls_foot_under_a_filter() {
    let sun = [0.6, 0.7, 0.2];
    for frame in [FrameChoice::Light, FrameChoice::Oblique] {
        // Wider than the reach of the filters, beyond which the ground is lit.
        for half_thickness in [1.0_f32, 2.0] {
            let (near, far) = ([-half_thickness, 0.0, -8.0], [half_thickness, 6.0, 8.0]);
            let scene = boxes(&[([-20.0, -1.0, -20.0], [20.0, 0.0, 20.0]), (near, far)]);
            let baked = bake(&scene, sun, |o| o.frame = frame);
            let along = |i: u32| -5.0 + 0.1 * f64::from(i);
            let from_foot =
                |d: u32| -f64::from(half_thickness) - baked.grid.voxel_size * (0.25 + 0.5 * f64::from(d));
            let points: Vec<_> = (0..100)
                .flat_map(|i| (0..5).map(move |d| (i, d)))
                .map(|(i, d)| [from_foot(d), 0.0, along(i)])
                .collect();
            for (filter, limit) in [(Filter::Box9, 0.004), (Filter::Box17, 0.01)] {
                let found = mean(&baked, &points, Some(UP), filter);
                println!("{frame:?}, {half_thickness}, {filter:?}: {found:.4}");
                assert!(found <= limit, "{frame:?}, {half_thickness}: {found}");
            }
        }
    }
}

/// A ledge on a wall at grazing sun: below the ledge nearly every tap of the filter finds ledge or shadow,
/// although the wall's plane rises by many voxels over a block of texels.
#[test]
fn contact_shadows_begin_at_a_ledge_under_a_filter() {
    let scene = boxes(&[
        ([-20.0, -1.0, -20.0], [20.0, 0.0, 20.0]),
        ([-0.5, 0.0, -8.0], [0.5, 14.0, 8.0]),
        ([0.4, 9.0, -8.0], [3.5, 10.9, 8.0]),
    ]);
    let baked = bake(&scene, [0.3, 0.9, 0.2], |_| {});
    let points: Vec<_> = (0..120)
        .flat_map(|i| (0..10).map(move |d| [0.5, 8.95 - 0.1 * f64::from(d), -6.0 + 0.1 * f64::from(i)]))
        .collect();
    let below = mean(&baked, &points, Some([1.0, 0.0, 0.0]), Filter::Box9);
    println!("visibility below the ledge: {below:.4}");
    assert!(below < 0.05, "{below}");
}

/// The bounds contain only air below a roof, so nothing is behind the first surfaces of their columns.
#[test]
fn bounds_below_a_roof_are_dark() {
    let scene = boxes(&[([-20.0, 10.0, -20.0], [20.0, 10.5, 20.0])]);
    let bounds = Bounds { min: [-5.0, 0.0, -5.0], max: [5.0, 4.0, 5.0] };
    let baked = bake(&scene, [0.1, 1.0, 0.05], |o| o.bounds = Some(bounds));
    let at = |i: u32| -4.0 + f64::from(i);
    let points: Vec<_> = (0..9).flat_map(|x| (0..9).map(move |z| [at(x), 1.0, at(z)])).collect();
    assert_eq!(mean(&baked, &points, None, Filter::Box9), 0.0);
}

/// No caster is within the bounds, so no block has a surface. A memory limit must still be divided among
/// workers.
#[test]
fn bounds_beside_the_scene_bake_within_a_limit() {
    let scene = boxes(&[([-1.0, 0.0, -1.0], [1.0, 1.0, 1.0])]);
    let bounds = Bounds { min: [100.0, 0.0, 100.0], max: [110.0, 10.0, 110.0] };
    let max_memory_bytes = Some(64 << 20);
    let baked = bake(&scene, [0.1, 1.0, 0.05], |o| {
        o.bounds = Some(bounds);
        o.max_memory_bytes = max_memory_bytes;
    });
    assert_eq!(mean(&baked, &[[105.0, 1.0, 105.0]], None, Filter::Box9), 1.0);
}
