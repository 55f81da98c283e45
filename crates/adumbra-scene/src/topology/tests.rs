//! Small shells whose topology is known.

use crate::topology::*;
use crate::{AlphaMode, Material};

/// Adds the twelve triangles of a box, as six faces with four separate vertices each.
fn hard_box(mesh: &mut Mesh, min: [f32; 3], max: [f32; 3], inverted: bool) {
    let corner = |i: usize| [0, 1, 2].map(|a| if i >> a & 1 == 0 { min[a] } else { max[a] });
    for face in [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]] {
        let v = mesh.positions.len() as u32;
        mesh.positions.extend(face.map(corner));
        for triangle in [[v, v + 1, v + 2], [v, v + 2, v + 3]] {
            let [a, b, c] = triangle;
            mesh.triangles.push(if inverted { [a, c, b] } else { triangle });
            mesh.triangle_materials.push(0);
        }
    }
}

fn boxes(list: &[([f32; 3], [f32; 3], bool)]) -> Mesh {
    let mut mesh = Mesh::default();
    for &(min, max, inverted) in list {
        hard_box(&mut mesh, min, max, inverted);
    }
    mesh
}

fn opaque() -> Vec<Material> {
    vec![Material::opaque("stone", [1.0; 4])]
}

const UNIT: ([f32; 3], [f32; 3], bool) = ([0.0; 3], [1.0; 3], false);

#[test]
fn hard_edged_box_is_closed_and_solid() {
    let mesh = boxes(&[UNIT]);
    assert_eq!(mesh.positions.len(), 24);
    let topology = analyse(&mesh, &opaque());
    assert_eq!(
        topology.components,
        [Component { triangles: 12, closed: true, signed_volume: 1.0, solid: true }]
    );
    assert!(topology.is_solid(11));
    assert_eq!((topology.closed_share(), topology.solid_share()), (1.0, 1.0));
}

#[test]
fn negative_zero_welds_with_zero() {
    let mut mesh = boxes(&[UNIT]);
    mesh.positions[0] = [-0.0, 0.0, -0.0];
    assert!(analyse(&mesh, &opaque()).components[0].closed);
}

#[test]
fn box_without_a_face_is_open() {
    let mut mesh = boxes(&[UNIT]);
    mesh.triangles.truncate(10);
    mesh.triangle_materials.truncate(10);
    let topology = analyse(&mesh, &opaque());
    assert_eq!(topology.components.len(), 1);
    assert!(!topology.components[0].closed && !topology.components[0].solid);
    assert_eq!(topology.closed_triangles(), 0);
}

#[test]
fn box_with_a_turned_triangle_is_open() {
    let mut mesh = boxes(&[UNIT]);
    mesh.triangles[3].swap(0, 1);
    assert!(!analyse(&mesh, &opaque()).components[0].closed);
}

#[test]
fn inverted_box_is_closed_but_not_solid() {
    let topology = analyse(&boxes(&[([0.0; 3], [1.0; 3], true)]), &opaque());
    assert_eq!(
        topology.components,
        [Component { triangles: 12, closed: true, signed_volume: -1.0, solid: false }]
    );
}

#[test]
fn cavity_in_a_box_is_solid() {
    let mesh = boxes(&[([0.25; 3], [0.75; 3], true), UNIT]);
    let topology = analyse(&mesh, &opaque());
    assert!(topology.components.iter().all(|c| c.solid), "{topology:?}");
    assert!(topology.components[0].signed_volume < 0.0);
}

#[test]
fn room_beside_a_box_or_around_it_is_not_solid() {
    let beside = boxes(&[([2.25; 3], [2.75; 3], true), UNIT]);
    let around = boxes(&[([-5.0; 3], [5.0; 3], true), UNIT]);
    for mesh in [beside, around] {
        let topology = analyse(&mesh, &opaque());
        assert_eq!(topology.components.iter().map(|c| c.solid).collect::<Vec<_>>(), [false, true]);
    }
}

#[test]
fn room_in_the_notch_of_a_solid_is_not_solid() {
    // An L made of two boxes joined at a whole face. Its bounding box contains the room, but the solid does
    // not.
    let l = [([0.0, 0.0, 0.0], [1.0, 1.0, 4.0], false), ([1.0, 0.0, 0.0], [4.0, 1.0, 4.0], false)];
    let mut mesh = boxes(&l);
    for p in &mut mesh.positions {
        // Pulls the second box's far end up, so that the component's box is 5 high there and the corner below
        // is free.
        if p[0] == 4.0 {
            p[1] += 4.0;
        }
    }
    hard_box(&mut mesh, [3.0, 0.5, 1.0], [3.5, 1.0, 2.0], true);
    let topology = analyse(&mesh, &opaque());
    assert_eq!(topology.components.iter().map(|c| c.solid).collect::<Vec<_>>(), [true, false]);
}

#[test]
fn solids_in_many_cavities_are_solid() {
    let mut list = vec![([-1.0; 3], [20.0; 3], false)];
    for i in 0..200_usize {
        let low = [(i % 6) as f32 * 3.0, (i / 6 % 6) as f32 * 3.0, (i / 36) as f32 * 3.0];
        list.push((low, low.map(|c| c + 2.0), true));
        list.push((low.map(|c| c + 0.5), low.map(|c| c + 1.5), false));
    }
    let topology = analyse(&boxes(&list), &opaque());
    assert_eq!(topology.components.len(), 401);
    assert!(topology.components.iter().all(|c| c.solid));
}

#[test]
fn cavity_in_a_masked_box_is_not_solid() {
    let mut mesh = boxes(&[([0.25; 3], [0.75; 3], true), UNIT]);
    let mut materials = opaque();
    materials.push(Material { alpha: AlphaMode::Mask { cutoff: 0.5 }, ..Material::opaque("leaf", [1.0; 4]) });
    mesh.triangle_materials[23] = 1;
    let topology = analyse(&mesh, &materials);
    assert!(topology.components.iter().all(|c| c.closed && !c.solid));
}

#[test]
fn masked_transmissive_and_non_casting_materials_make_no_solid() {
    let base = Material::opaque("odd", [1.0; 4]);
    let odd = [
        Material { alpha: AlphaMode::Mask { cutoff: 0.5 }, ..base.clone() },
        Material { transmissivity: 0.5, ..base.clone() },
        Material { casts: false, ..base },
    ];
    for material in odd {
        let mut mesh = boxes(&[UNIT, ([2.0; 3], [3.0; 3], false)]);
        mesh.triangle_materials[5] = 1;
        let topology = analyse(&mesh, &[opaque(), vec![material]].concat());
        assert_eq!(topology.components.iter().map(|c| c.solid).collect::<Vec<_>>(), [false, true]);
        assert_eq!(topology.solid_share(), 0.5);
    }
}

#[test]
fn boxes_that_share_an_edge_are_one_closed_component() {
    let mesh = boxes(&[UNIT, ([1.0, 1.0, 0.0], [2.0, 2.0, 1.0], false)]);
    let topology = analyse(&mesh, &opaque());
    assert_eq!(
        topology.components,
        [Component { triangles: 24, closed: true, signed_volume: 2.0, solid: true }]
    );
}

#[test]
fn boxes_that_share_a_corner_stay_apart() {
    let topology = analyse(&boxes(&[UNIT, ([1.0; 3], [2.0; 3], false)]), &opaque());
    assert_eq!(topology.components.len(), 2);
    assert!(topology.components.iter().all(|c| c.solid));
}

#[test]
fn two_sided_sheet_encloses_nothing() {
    let mut mesh = Mesh {
        positions: vec![[0.1, 0.2, 0.3], [7.7, 1.3, 0.9], [6.1, 9.7, 4.1], [-0.3, 8.9, 5.3]],
        triangles: vec![[0, 1, 2], [0, 2, 3], [2, 1, 0], [3, 2, 0]],
        triangle_materials: vec![0; 4],
        ..Mesh::default()
    };
    let topology = analyse(&mesh, &opaque());
    assert_eq!(
        topology.components,
        [Component { triangles: 4, closed: true, signed_volume: 0.0, solid: false }]
    );
    mesh.triangles.clear();
    mesh.triangle_materials.clear();
    assert_eq!(analyse(&mesh, &opaque()), Topology::default());
}

#[test]
fn order_of_triangles_and_corners_changes_nothing() {
    let mut list = Vec::new();
    for i in 0..40_u8 {
        let low = [f32::from(i) * 1.1, f32::from(i % 7) * 0.7, f32::from(i % 3) * 0.3];
        let high = low.map(|c| c + 0.37 + f32::from(i) / 11.0);
        list.push((low, high, false));
        list.push((low.map(|c| c + 0.1), low.map(|c| c + 0.3), i % 2 == 0));
    }
    let mesh = boxes(&list);
    let before = analyse(&mesh, &opaque());
    let mut shuffled = mesh.clone();
    // 461 and 960 have no common factor: a permutation.
    let order: Vec<usize> = (0..mesh.triangles.len()).map(|t| t * 461 % mesh.triangles.len()).collect();
    shuffled.triangles = order
        .iter()
        .map(|&t| {
            let [a, b, c] = mesh.triangles[t];
            [[a, b, c], [b, c, a], [c, a, b]][t % 3]
        })
        .collect();
    let after = analyse(&shuffled, &opaque());
    assert!(before.components.iter().any(|c| c.solid && c.signed_volume < 0.0));
    for (t, &old) in order.iter().enumerate() {
        let was = before.components[before.component_of_triangle[old] as usize];
        assert_eq!(after.components[after.component_of_triangle[t] as usize], was);
    }
}
