//! Files in which Z points up.

use std::fs;

use adumbra_scene::{Error, LoadOptions, Scene, UpAxis, load};

use crate::kit::Glb;

/// A town with Z up, far away as in map coordinates: a ground, and a wedge with its foot at (1, 2) and its
/// top at (1, 6, 8).
const CORNERS: [[f64; 3]; 7] = [
    [500_000.0, 5e6, 0.0],
    [500_040.0, 5e6, 0.0],
    [500_000.0, 5e6 + 30.0, 0.0],
    [500_001.0, 5e6 + 2.0, 0.0],
    [500_003.0, 5e6 + 2.0, 0.0],
    [500_001.0, 5e6 + 6.0, 8.0],
    [500_001.0, 5e6 + 6.0, 0.0],
];
const FACES: [[usize; 3]; 3] = [[0, 1, 2], [3, 4, 5], [3, 5, 6]];

fn obj(corners: &[[f64; 3]]) -> String {
    let vertices = corners.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n"));
    vertices.chain(FACES.map(|face| format!("f {} {} {}\n", face[0] + 1, face[1] + 1, face[2] + 1))).collect()
}

fn ply(corners: &[[f64; 3]]) -> String {
    let header = "ply\nformat ascii 1.0\nelement vertex 7\nproperty double x\nproperty double y\nproperty double z\n\
        element face 3\nproperty list uchar int vertex_indices\nend_header\n";
    let vertices = corners.iter().map(|[x, y, z]| format!("{x} {y} {z}\n"));
    let faces = FACES.map(|[a, b, c]| format!("3 {a} {b} {c}\n"));
    header.to_owned() + &vertices.chain(faces).collect::<String>()
}

fn triangles(scene: &Scene) -> Vec<[[f64; 3]; 3]> {
    let of = |i: &adumbra_scene::Instance| {
        let mesh = scene.meshes[i.mesh as usize].clone();
        let i = i.clone();
        mesh.triangles.into_iter().map(move |t| t.map(|v| i.to_world(mesh.positions[v as usize])))
    };
    scene.instances.iter().flat_map(of).collect()
}

#[test]
fn z_up_files_are_rotated_to_y_up() {
    let folder = tempfile::tempdir().unwrap();
    let turned = CORNERS.map(|[x, y, z]| [x, z, -y]);
    for (ending, text) in [("obj", obj as fn(&[[f64; 3]]) -> String), ("ply", ply)] {
        let with = |name: &str, text: String, up| {
            let path = folder.path().join(format!("{name}.{ending}"));
            fs::write(&path, text).unwrap();
            load(&path, &LoadOptions { up, ..LoadOptions::default() }).unwrap()
        };
        let z_up = with("z", text(&CORNERS), Some(UpAxis::Z));
        let y_up = with("y", text(&turned), None);
        assert_eq!(triangles(&z_up), triangles(&y_up), "{ending}");
        assert_eq!(triangles(&y_up)[2][1], [500_001.0, 8.0, -5e6 - 6.0]);
        assert_eq!((z_up.up, y_up.up), (UpAxis::Z, UpAxis::Y));
        // Read as Y up, the town stands on edge, which is noted unless the axis is given.
        let noted =
            [None, Some(UpAxis::Y), Some(UpAxis::Z)].map(|up| with("z", text(&CORNERS), up).notes.looks_z_up);
        assert_eq!((noted, y_up.notes.looks_z_up), ([true, false, false], false), "{ending}");
    }
}

#[test]
fn gltf_rejects_up_axes_other_than_y() {
    let glb = Glb::triangle();
    let with = |up| glb.load_with(&LoadOptions { up, ..LoadOptions::default() });
    assert!(matches!(with(Some(UpAxis::Z)), Err(Error::GltfIsYUp { .. })));
    assert!(!with(Some(UpAxis::Y)).unwrap().notes.looks_z_up && !with(None).unwrap().notes.looks_z_up);
}
