//! Tests of the tracer on scenes small enough to check by hand or by brute force.

use crate::trace::*;
use adumbra::grid::vec3::normalize;
use adumbra_scene::{Instance, Material, Mesh, Pixels, Texture, Wrap, icosphere};

type Points = Vec<[f32; 3]>;
type Triangles = Vec<[u32; 3]>;

const IDENTITY: [[f64; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// Deterministic random numbers in 0 .. 1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as f64 / (1_u64 << 31) as f64
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() * n as f64) as usize
    }

    /// A random point in the cube -1 .. 1.
    fn point(&mut self) -> [f64; 3] {
        std::array::from_fn(|_| 2.0 * self.next() - 1.0)
    }
}

fn scene((positions, triangles): (Points, Triangles), places: &[[[f64; 4]; 3]]) -> Scene {
    let triangle_materials = vec![0; triangles.len()];
    let mesh = Mesh { positions, triangles, triangle_materials, ..Mesh::default() };
    let instance = |&world_from_mesh| Instance { name: String::new(), mesh: 0, world_from_mesh, casts: true };
    Scene {
        meshes: vec![mesh],
        instances: places.iter().map(instance).collect(),
        materials: vec![Material::opaque("stone", [1.0; 4])],
        ..Scene::default()
    }
}

fn tracer(scene: &Scene) -> Tracer<'_> {
    Tracer::build(scene, TraceOptions::default())
}

/// A square with half side `half` in the plane y = 0, facing up.
fn square(half: f32) -> (Points, Triangles) {
    let corner = |x: f32, z: f32| [x * half, 0.0, z * half];
    let points = vec![corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
    (points, vec![[0, 1, 2], [0, 2, 3]])
}

/// A ball of radius 1 about the origin, wound outwards, see [`icosphere`].
fn ball(cuts: u32) -> (Points, Triangles) {
    let (directions, triangles) = icosphere(cuts);
    (directions.into_iter().map(|direction| direction.map(|c| c as f32)).collect(), triangles)
}

/// A ray from `origin` through `target`, where t = 1.
fn through(origin: [f64; 3], target: [f64; 3]) -> Ray {
    let direction = [0, 1, 2].map(|a| target[a] - origin[a]);
    Ray { origin, direction, t_min: 0.0, t_max: f64::INFINITY }
}

fn down(origin: [f64; 3]) -> Ray {
    Ray { origin, direction: [0.0, -1.0, 0.0], t_min: 0.0, t_max: f64::INFINITY }
}

/// Calls `check` with rays to random corners and edge points of the only mesh, from `distance` away in all
/// directions.
fn aim_at_seams(scene: &Scene, rays: usize, distance: f64, mut check: impl FnMut(&Ray)) {
    let (mut random, mesh, instance) = (Random(1), &scene.meshes[0], &scene.instances[0]);
    for i in 0..rays {
        let t = mesh.triangles[random.below(mesh.triangles.len())];
        let k = random.below(3);
        let [a, b] = [t[k], t[(k + 1) % 3]].map(|v| instance.to_world(mesh.positions[v as usize]));
        let w = if i % 3 == 0 { 0.0 } else { random.next() };
        let target = [0, 1, 2].map(|r| a[r] + w * (b[r] - a[r]));
        let away = normalize(random.point());
        check(&through([0, 1, 2].map(|r| target[r] + distance * away[r]), target));
    }
}

#[test]
fn trace_closed_mesh_has_no_leak_at_its_seams() {
    for offset in [0.0, 1e5] {
        let map = [[3.0, 0.5, 0.0, offset], [0.0, 2.0, 0.25, -offset], [-0.5, 0.0, 1.0, offset]];
        let scene = scene(ball(5), &[map]);
        let tracer = tracer(&scene);
        let center = map.map(|row| row[3]);
        // From the centre every ray must be blocked on its way out, and from outside every ray through a seam
        // towards the centre must be blocked on its way in.
        aim_at_seams(&scene, 50_000, 10.0, |ray| {
            let seam = [0, 1, 2].map(|a| ray.origin[a] + ray.direction[a]);
            assert!(tracer.occluded(&through(center, seam)), "leaves through {seam:?}");
            let from = [0, 1, 2].map(|a| center[a] + 3.0 * (seam[a] - center[a]));
            assert!(tracer.occluded(&through(from, center)), "enters through {seam:?}");
            let inside = [0, 1, 2].map(|a| center[a] + 0.5 * (seam[a] - center[a]));
            let outside = [0, 1, 2].map(|a| ray.origin[a] - center[a]);
            if dot(outside, outside) > 25.0 {
                assert!(tracer.occluded(&through(ray.origin, inside)), "reaches {inside:?}");
            }
        });
    }
}

#[test]
fn trace_fan_of_slivers_has_no_gap() {
    // A disc of 5,000 slivers about one corner, with thin rings: every ray from above hits it.
    let spokes = 5_000_u32;
    let mut points: Points = vec![[0.1, 0.0, 0.2]];
    let mut triangles = Triangles::new();
    for ring in [1.0, 1.000_01, 50.0] {
        for i in 0..spokes {
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(i) / f64::from(spokes));
            points.push([(ring * cos) as f32, (0.001 * sin * ring) as f32, (ring * sin) as f32]);
        }
    }
    for i in 0..spokes {
        let j = (i + 1) % spokes;
        triangles.push([0, 1 + j, 1 + i]);
        for ring in 0..2 {
            let [a, b] = [1 + ring * spokes + i, 1 + ring * spokes + j];
            triangles.extend([[a, b, b + spokes], [a, b + spokes, a + spokes]]);
        }
    }
    let scene = scene((points, triangles), &[IDENTITY]);
    let tracer = tracer(&scene);
    let mut random = Random(5);
    aim_at_seams(&scene, 100_000, 1.0, |ray| {
        let seam = [0, 1, 2].map(|a| ray.origin[a] + ray.direction[a]);
        if seam[0] * seam[0] + seam[2] * seam[2] < 2400.0 {
            let above = [seam[0], 1.0 + random.next(), seam[2]];
            assert!(tracer.occluded(&down(above)), "{above:?}");
            let slanted = [seam[0] + random.next() - 0.5, 1.0, seam[2] + random.next() - 0.5];
            assert!(tracer.occluded(&through(slanted, seam)), "{slanted:?} to {seam:?}");
        }
    });
}

#[test]
fn trace_equals_brute_force_on_small_soups() {
    equals_brute_force(&[(1, 1.0, 0.0), (3, 1.0, 0.0), (40, 0.8, 0.0), (300, 0.3, 1e5)], 300);
}

#[test]
#[ignore = "slow: takes over eight seconds"]
fn trace_equals_brute_force_on_soups() {
    equals_brute_force(
        &[(1, 1.0, 0.0), (3, 1.0, 0.0), (40, 0.8, 0.0), (700, 0.3, 1e5), (3000, 0.1, 1e3)],
        2000,
    );
}

/// Compares rays with brute force in triangle soups, given by number of triangles, their size, and distance
/// from the origin.
fn equals_brute_force(soups: &[(u32, f64, f64)], rays: usize) {
    let mut random = Random(11);
    for &(count, size, offset) in soups {
        let mut soup = (Points::new(), Triangles::new());
        for i in 0..count {
            let center = random.point();
            (0..3).for_each(|_| {
                let p = random.point();
                soup.0.push([0, 1, 2].map(|a| (center[a] + size * p[a]) as f32));
            });
            soup.1.push([3 * i, 3 * i + 1, 3 * i + 2]);
        }
        let mut places = Vec::new();
        for _ in 0..5 {
            let mut map =
                [random.point(), random.point(), random.point()].map(|r| [r[0], r[1], r[2], offset]);
            map.iter_mut().for_each(|r| r[3] += 2.0 * random.next());
            places.push(map);
        }
        for placed in [1, 5] {
            let scene = scene(soup.clone(), &places[..placed]);
            let tracer = tracer(&scene);
            for _ in 0..rays {
                let mut ray = through(random.point(), random.point());
                ray.origin.iter_mut().for_each(|c| *c = 1.5 * *c + offset);
                ray.t_max = if random.next() < 0.5 { f64::INFINITY } else { random.next() };
                if random.next() < 0.3 {
                    ray.direction[random.below(3)] = 0.0;
                }
                check_against_brute_force(&tracer, &ray);
            }
        }
    }
}

fn check_against_brute_force(tracer: &Tracer<'_>, ray: &Ray) {
    let mut all = Vec::new();
    for instance in &tracer.instances {
        let mesh =
            &tracer.scene.meshes[tracer.scene.instances[instance.scene_instance as usize].mesh as usize];
        for (number, t) in mesh.triangles.iter().enumerate() {
            let corners = t.map(|i| mesh.positions[i as usize]);
            if let Some(hit) = instance.try_one(ray, &corners) {
                all.push((hit.t, instance.scene_instance, number as u32));
            }
        }
    }
    all.sort_by(|a, b| a.partial_cmp(b).unwrap());
    let mut seen = Vec::new();
    tracer.for_each_hit(ray, |hit| seen.push((hit.t, hit.instance, hit.triangle)));
    seen.sort_by(|a, b| a.partial_cmp(b).unwrap());
    assert_eq!(seen, all, "{ray:?}");
    let nearest = tracer.nearest_surface(ray).map(|hit| (hit.t, hit.instance, hit.triangle));
    assert_eq!(nearest, all.first().copied(), "{ray:?}");
    assert_eq!(tracer.occluded(ray), !all.is_empty(), "{ray:?}");
}

#[test]
fn trace_normals_follow_winding_and_mirrors() {
    let mirrored = [[-1.0, 0.0, 0.0, 10.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let tilted = [[1.0, 0.0, 0.0, 20.0], [1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 8.0, 0.0]];
    let upside_down = [[1.0, 0.0, 0.0, 30.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0]];
    let scene = scene(square(1.0), &[IDENTITY, mirrored, tilted, upside_down]);
    let tracer = tracer(&scene);
    let diagonal = 0.5_f64.sqrt();
    let expected = [[0.0, 1.0, 0.0], [0.0, 1.0, 0.0], [-diagonal, diagonal, 0.0], [0.0, -1.0, 0.0]];
    for (i, normal) in expected.into_iter().enumerate() {
        let above = tracer.nearest_surface(&down([10.0 * i as f64, 5.0, 0.3])).unwrap();
        assert_eq!((above.instance as usize, above.front), (i, i != 3));
        assert!((0..3).all(|a| (above.normal[a] - normal[a]).abs() < 1e-12), "{i}: {above:?}");
        let up = Ray { direction: [0.0, 1.0, 0.0], ..down([10.0 * i as f64, -5.0, 0.3]) };
        let below = tracer.nearest_surface(&up).unwrap();
        assert_eq!((below.normal, below.front), (above.normal, i == 3));
    }
}

#[test]
fn trace_scaling_keeps_t_in_world_lengths() {
    let map = [[100.0, 0.0, 0.0, 3.0], [0.0, 0.01, 0.0, -2.0], [0.0, 0.0, 7.0, 1.0]];
    let scene = scene(ball(3), &[map]);
    let hit = tracer(&scene).nearest_surface(&down([3.0, 8.0, 1.0])).unwrap();
    assert!((hit.t - 9.99).abs() < 1e-6 && hit.normal[1] > 0.99, "{hit:?}");
    let fast = Ray { direction: [0.0, -4.0, 0.0], ..down([3.0, 8.0, 1.0]) };
    assert!((tracer(&scene).nearest_surface(&fast).unwrap().t - 9.99 / 4.0).abs() < 1e-6);
}

#[test]
fn trace_flat_instance_still_blocks() {
    let flat = [[2.0, 0.0, 0.0, 1e4], [0.0, 0.0, 0.0, 3.0], [0.0, 0.0, 2.0, 0.0]];
    let scene = scene(ball(2), &[IDENTITY, flat]);
    let tracer = tracer(&scene);
    let hit = tracer.nearest_surface(&down([1e4 + 0.5, 5.0, 0.25])).unwrap();
    assert!((hit.t - 2.0).abs() < 1e-6 && hit.instance == 1 && hit.normal[1].abs() == 1.0, "{hit:?}");
    assert!(!tracer.occluded(&down([1e4 + 2.5, 5.0, 0.25])));
}

#[test]
fn trace_range_is_inclusive() {
    let scene = scene(square(1.0), &[IDENTITY]);
    let tracer = tracer(&scene);
    let ray = |t_min, t_max| Ray { t_min, t_max, ..down([0.25, 2.0, 0.5]) };
    assert!(
        tracer.occluded(&ray(0.0, 2.0)) && tracer.occluded(&ray(2.0, 5.0)) && tracer.occluded(&ray(2.0, 2.0))
    );
    assert!(!tracer.occluded(&ray(0.0, 1.999)) && !tracer.occluded(&ray(2.001, 5.0)));
    assert!(!tracer.occluded(&ray(5.0, 0.0)) && !tracer.occluded(&ray(f64::NAN, 9.0)));
    assert!(tracer.occluded(&Ray { t_min: f64::NEG_INFINITY, ..down([0.25, -2.0, 0.5]) }));
    assert!(!tracer.occluded(&Ray { direction: [0.0; 3], ..ray(0.0, 9.0) }));
    assert!(!tracer.occluded(&Ray { direction: [0.0, f64::INFINITY, 0.0], ..ray(0.0, 9.0) }));
}

#[test]
fn trace_axis_parallel_rays_hit_far_from_the_origin() {
    let offset = [1e5, 300.0, -1e5];
    let map: [[f64; 4]; 3] = std::array::from_fn(|r| {
        let mut row = IDENTITY[r];
        row[3] = offset[r];
        row
    });
    let (near, far) = (scene(ball(4), &[IDENTITY]), scene(ball(4), &[map]));
    let (near, far) = (tracer(&near), tracer(&far));
    for axis in 0..3 {
        for i in 0..=40 {
            for j in 0..=40 {
                let mut o = [0.0; 3];
                o[(axis + 1) % 3] = -1.0 + 0.05 * f64::from(i);
                o[(axis + 2) % 3] = -1.0 + 0.05 * f64::from(j);
                o[axis] = 7.0;
                let mut direction = [0.0, -0.0, 0.0];
                direction[axis] = -1.0;
                let ray = Ray { origin: o, direction, t_min: 0.0, t_max: f64::INFINITY };
                let moved = Ray { origin: std::array::from_fn(|a| o[a] + offset[a]), ..ray };
                let inside = o[(axis + 1) % 3].hypot(o[(axis + 2) % 3]);
                if (inside - 1.0).abs() > 0.01 {
                    assert_eq!(near.occluded(&ray), inside < 1.0, "{ray:?}");
                    assert_eq!(far.occluded(&moved), inside < 1.0, "{moved:?}");
                }
            }
        }
    }
    assert!(!far.sun_visible([1e5, 298.0, -1e5], [0.0, 1.0, 0.0]));
    assert!(far.sun_visible([1e5, 302.0, -1e5], [0.0, 1.0, 0.0]));
}

#[test]
fn trace_honours_masks_and_casting() {
    let mut scene = scene(square(1.0), &[IDENTITY]);
    let masked = |name, alpha| Material {
        alpha: AlphaMode::Mask { cutoff: 0.5 },
        ..Material::opaque(name, [1.0, 1.0, 1.0, alpha])
    };
    scene.materials = vec![masked("leaf", 0.7), masked("gap", 0.3)];
    scene.meshes[0].triangle_materials = vec![0, 1];
    scene.meshes[0].uvs = vec![[0.0, 0.0], [0.0, 2.0], [2.0, 2.0], [2.0, 0.0]];
    let (leaf, gap) = (down([-0.5, 1.0, 0.25]), down([0.5, 1.0, -0.25]));
    let hit = tracer(&scene).nearest_surface(&leaf).unwrap();
    assert_eq!((hit.material, hit.uv), (0, [0.5, 1.25]));
    assert!(!tracer(&scene).occluded(&gap) && tracer(&scene).nearest_surface(&gap).is_none());
    assert!(Tracer::build(&scene, TraceOptions { ignore_alpha: true }).occluded(&gap));
    scene.materials[0].casts = false;
    assert!(!tracer(&scene).occluded(&leaf) && tracer(&scene).nearest_blocker(&leaf).is_none());
    assert!(tracer(&scene).nearest_surface(&leaf).is_some());
    scene.materials[0].casts = true;
    scene.instances[0].casts = false;
    assert!(!tracer(&scene).occluded(&leaf) && tracer(&scene).nearest_blocker(&leaf).is_none());
    assert!(tracer(&scene).nearest_surface(&leaf).is_some());
}

#[test]
fn trace_honours_a_mask_texture() {
    let mut scene = scene(square(1.0), &[IDENTITY]);
    scene.textures = vec![Texture {
        name: "chequered".to_owned(),
        width: 2,
        height: 2,
        pixels: Pixels::Alpha(vec![255, 0, 0, 255]),
        wrap: [Wrap::Repeat; 2],
        nearest: true,
    }];
    scene.materials[0].alpha = AlphaMode::Mask { cutoff: 0.5 };
    scene.materials[0].texture = Some(0);
    // u along x, v along z, with the texture repeated three times across.
    scene.meshes[0].uvs = vec![[0.0, 0.0], [0.0, 3.0], [3.0, 3.0], [3.0, 0.0]];
    let (masked, opaque) = (tracer(&scene), Tracer::build(&scene, TraceOptions { ignore_alpha: true }));
    for i in 0..6 {
        for j in 0..6 {
            let ray = down([(f64::from(i) + 0.4) / 3.0 - 1.0, 1.0, (f64::from(j) + 0.7) / 3.0 - 1.0]);
            let there = (i + j) % 2 == 0;
            assert_eq!(masked.occluded(&ray), there, "{i} {j}");
            assert_eq!(masked.nearest_surface(&ray).is_some(), there, "{i} {j}");
            assert!(opaque.occluded(&ray), "{i} {j}");
        }
    }
}

#[test]
fn trace_nearest_sees_through_gaps_and_counts_crossings() {
    let at = |y: f64| [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, 0.0]];
    let places: Vec<_> = (0..100).map(|i| at(f64::from(i))).collect();
    let mut scene = scene(ball(1), &[places.as_slice(), &[at(500.0)]].concat());
    scene.instances[100].casts = false;
    let tracer = tracer(&scene);
    let ray = down([0.05, 1000.0, 0.02]);
    assert_eq!(tracer.nearest_surface(&ray).unwrap().instance, 100);
    assert_eq!(tracer.nearest_blocker(&ray).unwrap().instance, 99);
    let (mut hits, mut winding) = (0, 0);
    tracer.for_each_hit(&ray, |hit| {
        hits += 1;
        winding += if hit.front { 1 } else { -1 };
    });
    assert_eq!((hits, winding), (202, 0));
    assert!(tracer.memory_bytes() > 0);
}

#[test]
fn trace_sun_disc_is_half_visible_over_a_half_plane() {
    // The edge of the half plane passes through the zenith.
    let mut half_plane = square(1e4);
    half_plane.0.iter_mut().for_each(|p| *p = [p[0] + 1e4, 100.0, p[2]]);
    let scene = scene(half_plane, &[IDENTITY]);
    let tracer = tracer(&scene);
    for degrees in [0.53, 10.0, 60.0] {
        let seen = tracer.sun_disc_visibility([0.0; 3], [0.0, 2.0, 0.0], degrees, 1024, 3);
        assert!((seen - 0.5).abs() < 0.02, "{degrees}: {seen}");
    }
    assert_eq!(tracer.sun_disc_visibility([-0.3; 3], [0.0, 2.0, 0.0], 0.0, 1024, 3), 1.0);
    assert_eq!(tracer.sun_disc_visibility([0.3; 3], [0.0, 2.0, 0.0], 0.0, 1024, 3), 0.0);
    let soft = |seed| tracer.sun_disc_visibility([0.0; 3], [0.1, 1.0, 0.3], 20.0, 64, seed);
    assert_eq!(soft(1), soft(1));
}

#[test]
fn trace_weighs_what_materials_let_through() {
    // From y = 1 up: a crown with two faces, x < 3, another, x < 2, and a roof, x < 1.
    let mut scene = scene((Points::new(), Triangles::new()), &[IDENTITY]);
    scene.materials = [0.5, 0.125, 0.0]
        .map(|transmissivity| Material { transmissivity, ..Material::opaque("", [1.0; 4]) })
        .to_vec();
    let mesh = &mut scene.meshes[0];
    for (y, (east, material)) in (1_u8..).zip([(3.0, 0), (3.0, 0), (2.0, 1), (1.0, 2)]) {
        let first = mesh.positions.len() as u32;
        let y = f32::from(y);
        mesh.positions.extend([[-9.0, y, -9.0], [-9.0, y, 9.0], [east, y, 9.0], [east, y, -9.0]]);
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        mesh.triangle_materials.extend([material; 2]);
    }
    let tracer = tracer(&scene);
    let up = |x| Ray { origin: [x, 0.0, 0.3], direction: [0.0, 1.0, 0.0], t_min: 0.0, t_max: 9.0 };
    assert_eq!([0.5, 1.5, 2.5, 3.5].map(|x| tracer.transmitted(&up(x))), [0.0, 0.125, 0.5, 1.0]);
    assert_eq!([0.5, 1.5, 2.5, 3.5].map(|x| tracer.occluded(&up(x))), [true, true, true, false]);
    // The disc's centre is seen past the edge of the upper face of the first crown.
    let light = |x| tracer.sun_disc_light([x, 1.5, 0.3], [0.0, 1.0, 0.0], 10.0, 1024, 3);
    assert!((light(3.0) - 0.75).abs() < 0.01, "{}", light(3.0));
    assert_eq!([1.5, 2.5, 3.5].map(light), [0.125, 0.5, 1.0]);
    assert_eq!(tracer.sun_disc_visibility([2.5, 1.5, 0.3], [0.0, 1.0, 0.0], 10.0, 16, 3), 0.0);
}

#[test]
fn trace_ambient_is_open_on_a_plane_and_closed_in_a_ball() {
    let plane = scene(square(1e3), &[IDENTITY]);
    let tracer_of_plane = tracer(&plane);
    assert_eq!(tracer_of_plane.ambient_visibility([3.0, 1e-4, 2.0], [0.0, 1.0, 0.0], 1e3, 1024, 9), 1.0);
    assert_eq!(tracer_of_plane.ambient_visibility([3.0, 1e-4, 2.0], [0.0, 1.0, 0.0], 1e3, 0, 9), 1.0);
    // A ceiling at half the radius blocks up to 60° from the zenith: three quarters, weighted by the cosine.
    let ceiling = tracer_of_plane.ambient_visibility([3.0, -1.0, 2.0], [0.0, 1.0, 0.0], 2.0, 4096, 9);
    assert!((ceiling - 0.25).abs() < 0.005, "{ceiling}");
    let ball = scene(ball(3), &[IDENTITY]);
    let ball = tracer(&ball);
    assert_eq!(ball.ambient_visibility([0.0; 3], [1.0, 2.0, 3.0], 1.01, 1024, 9), 0.0);
    assert_eq!(ball.ambient_visibility([0.0; 3], [1.0, 2.0, 3.0], 0.9, 1024, 9), 1.0);
}

#[test]
fn trace_handles_coincident_shrinking_and_huge_triangles() {
    let empty = Scene::default();
    assert!(!tracer(&empty).occluded(&down([0.0; 3])));
    // Test one triangle many times over, and triangles of ever smaller size, which give a very deep tree.
    let (points, _) = square(1.0);
    let coincident = scene((points.clone(), vec![[0, 1, 2]; 20_000]), &[IDENTITY]);
    let mut hits = 0;
    tracer(&coincident).for_each_hit(&down([-0.5, 1.0, 0.25]), |_| hits += 1);
    assert_eq!(hits, 20_000);
    let mut shrinking = (Points::new(), Triangles::new());
    for i in 0..120_u32 {
        let s = libm::exp2f(60.0 - i as f32);
        shrinking.0.extend([[0.0, s, 0.0], [s, s, 0.0], [0.0, s, s]]);
        shrinking.1.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    let shrinking = scene(shrinking, &[IDENTITY]);
    assert_eq!(tracer(&shrinking).nearest_surface(&down([0.0, 1e20, 0.0])).unwrap().triangle, 0);
    let huge = scene(
        (points.iter().map(|p| p.map(|c| c * f32::MAX)).collect(), vec![[0, 1, 2], [0, 2, 3]]),
        &[IDENTITY],
    );
    assert!(tracer(&huge).occluded(&down([1e37, 1.0, -1e37])));
}
