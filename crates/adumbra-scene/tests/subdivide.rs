//! Subdivided meshes have the requested triangle count and the same surface, without gaps along edges.

use std::collections::BTreeMap;

use adumbra_scene::topology::analyse;
use adumbra_scene::{GeneratedKind, LoadOptions, Material, Mesh, generate, load};
use adumbra_testing::{scene_file, shared};

/// Triangle counts of the shared dragon and of the paper's.
const DRAGON: [usize; 2] = [202_520, 2_400_000];

/// A torus: closed, 2,304 triangles with edges of many lengths.
fn torus() -> Mesh {
    let scene = generate(GeneratedKind::Primitives, 1);
    scene.meshes.into_iter().find(|m| m.name == "torus").unwrap()
}

/// The torus with three vertices per triangle, and texture coordinates that differ across every edge.
fn seamed() -> Mesh {
    let torus = torus();
    let corners = torus.triangles.iter().flatten();
    let count = torus.triangles.len() as u32;
    Mesh {
        positions: corners.map(|&v| torus.positions[v as usize]).collect(),
        uvs: (0..count * 3).map(|i| [(i / 3) as f32, (i % 3) as f32]).collect(),
        colors: Vec::new(),
        triangles: (0..count).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        triangle_materials: (0..count).collect(),
        ..torus
    }
}

fn cut_to(mut mesh: Mesh, wanted: usize) -> Mesh {
    mesh.subdivide_to(wanted);
    mesh
}

fn corners(mesh: &Mesh) -> impl Iterator<Item = [[f32; 3]; 3]> {
    mesh.triangles.iter().map(|t| t.map(|v| mesh.positions[v as usize]))
}

fn area([a, b, c]: [[f32; 3]; 3]) -> f64 {
    let from_a = |p: [f32; 3]| [0, 1, 2].map(|i| f64::from(p[i]) - f64::from(a[i]));
    let (u, v) = (from_a(b), from_a(c));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    n.iter().map(|c| c * c).sum::<f64>().sqrt() / 2.0
}

fn total_area(mesh: &Mesh) -> f64 {
    corners(mesh).map(area).sum()
}

fn bounds(mesh: &Mesh) -> [[f32; 3]; 2] {
    let all = || corners(mesh).flatten();
    let extreme = |pick: fn(f32, f32) -> f32| [0, 1, 2].map(|a| all().map(|p| p[a]).reduce(pick).unwrap());
    [extreme(f32::min), extreme(f32::max)]
}

/// Number of triangles next to each edge; edges are identified by the positions of their ends.
fn triangles_beside_edges(mesh: &Mesh) -> BTreeMap<[[u32; 3]; 2], u32> {
    let mut beside = BTreeMap::new();
    for triangle in corners(mesh) {
        for k in 0..3 {
            let mut ends = [triangle[k], triangle[(k + 1) % 3]].map(|p| p.map(|c| (c + 0.0).to_bits()));
            ends.sort_unstable();
            *beside.entry(ends).or_default() += 1;
        }
    }
    beside
}

#[test]
fn subdivision_reaches_the_count_of_a_closed_mesh() {
    let count = torus().triangles.len();
    let like_the_dragon = count * DRAGON[1] / DRAGON[0];
    for wanted in [count + 2, 2 * count, 4 * count - 2, 4 * count, like_the_dragon & !1, 16 * count + 6] {
        assert_eq!(cut_to(torus(), wanted).triangles.len(), wanted);
        assert_eq!(cut_to(torus(), wanted + 1).triangles.len(), wanted);
    }
}

#[test]
fn subdivision_keeps_area_and_bounds() {
    let before = torus();
    let after = cut_to(torus(), 27_000);
    assert_eq!(bounds(&after), bounds(&before));
    assert!((total_area(&after) / total_area(&before) - 1.0).abs() < 1e-6);
    assert!(corners(&after).all(|t| area(t) > 0.0));
    assert_eq!(after.positions[..before.positions.len()], before.positions);
}

#[test]
fn subdivision_leaves_no_gap_along_an_edge() {
    let opaque = vec![Material::opaque("any", [1.0; 4]); torus().triangles.len()];
    for mesh in [torus(), seamed()] {
        for wanted in [2_400, 5_000, 8_000, 27_000] {
            let after = cut_to(mesh.clone(), wanted);
            assert!(triangles_beside_edges(&after).values().all(|&n| n == 2), "{wanted}");
            let topology = analyse(&after, &opaque);
            assert_eq!((topology.components.len(), topology.solid_share()), (1, 1.0));
            let volume = |m: &Mesh| analyse(m, &opaque).components[0].signed_volume;
            assert!((volume(&after) / volume(&mesh) - 1.0).abs() < 1e-6);
        }
    }
}

#[test]
fn subdivision_of_an_open_mesh_keeps_its_rim() {
    let mut open = torus();
    open.triangles.truncate(1_531);
    open.triangle_materials.truncate(1_531);
    let after = cut_to(open.clone(), 18_001);
    assert_eq!(after.triangles.len(), 18_001);
    let rim = |mesh: &Mesh| -> f64 {
        let length = |ends: &[[u32; 3]; 2]| {
            let [p, q] = ends.map(|p| p.map(|c| f64::from(f32::from_bits(c))));
            (0..3).map(|a| (p[a] - q[a]).powi(2)).sum::<f64>().sqrt()
        };
        triangles_beside_edges(mesh).iter().filter(|e| *e.1 == 1).map(|e| length(e.0)).sum()
    };
    assert!(rim(&open) > 1.0 && (rim(&after) / rim(&open) - 1.0).abs() < 1e-6);
}

#[test]
fn subdivision_carries_texture_coordinates_and_materials() {
    let before = seamed();
    let after = cut_to(before.clone(), 27_000);
    assert_eq!(after.uvs.len(), after.positions.len());
    assert_eq!(after.triangle_materials.len(), after.triangles.len());
    let mut areas = vec![0.0; before.triangles.len()];
    for ((triangle, &of), p) in after.triangles.iter().zip(&after.triangle_materials).zip(corners(&after)) {
        areas[of as usize] += area(p);
        // The first coordinate is the index of the original triangle; the second varies across it.
        for &v in triangle {
            let [s, t] = after.uvs[v as usize];
            assert!(s == of as f32 && (0.0..=2.0).contains(&t), "{s} {t} of {of}");
        }
    }
    for (p, found) in corners(&before).zip(areas) {
        assert!((found / area(p) - 1.0).abs() < 1e-3);
    }
}

#[test]
fn subdivision_to_fewer_triangles_changes_nothing() {
    for wanted in [0, 1, 2_303, 2_304] {
        let after = cut_to(torus(), wanted);
        assert_eq!((after.triangles, after.positions), (torus().triangles, torus().positions));
    }
    assert!(cut_to(Mesh::default(), 100).triangles.is_empty());
}

#[test]
fn subdivision_is_the_same_every_time() {
    let [a, b] = [(); 2].map(|()| cut_to(seamed(), 19_876));
    assert_eq!((a.triangles, a.positions, a.uvs), (b.triangles, b.positions, b.uvs));
}

#[test]
#[ignore = "slow: real scenes"]
fn shared_dragon_reaches_the_papers_count() {
    let Some(scenes) = shared("scenes") else { return };
    let scene = load(&scene_file(&scenes, "dragon_202k"), &LoadOptions::default()).unwrap();
    let before = &scene.meshes[0];
    assert_eq!(before.triangles.len(), DRAGON[0]);
    let after = cut_to(before.clone(), DRAGON[1]);
    assert!(after.triangles.len().abs_diff(DRAGON[1]) <= 1, "{}", after.triangles.len());
    assert_eq!(bounds(&after), bounds(before));
    assert!((total_area(&after) / total_area(before) - 1.0).abs() < 1e-6);
    assert!(corners(&after).all(|t| area(t) > 0.0));
}
