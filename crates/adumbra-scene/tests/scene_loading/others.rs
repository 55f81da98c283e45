//! OBJ, PLY, missing files, and the shared scenes.

use adumbra::IoError;
use adumbra_scene::Error;
use adumbra_scene::{AlphaMode, LoadOptions, Scene, load};

use crate::kit::{file, load_bytes, only, refused, world_triangles};

const PLAIN: fn() -> LoadOptions = LoadOptions::default;

fn obj(text: &str) -> adumbra_scene::Result<Scene> {
    load_bytes("scene.obj", text.as_bytes(), &PLAIN())
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0 0.5 0.5 0.5\nv 1 0 1\nv 0 0 1\n";

#[test]
fn obj_reads_polygons_negative_indices_and_names() {
    let scene =
        obj(&format!("{SQUARE}o quad\nf 1/7/3 2//1 3 -1\nf 1 \\\n 2 3\ng other\nf 1 2 4\nl 1 2 3 4\n"));
    let scene = scene.expect("loads");
    let names: Vec<_> = scene.meshes.iter().map(|m| (m.name.as_str(), m.triangles.len())).collect();
    assert_eq!(names, [("quad", 3), ("other", 1)]);
    assert_eq!(scene.notes.omissions.iter().map(|o| o.count).sum::<u64>(), 1);
    assert_eq!(world_triangles(&scene)[1], [[0.0; 3], [1.0, 0.0, 1.0], [0.0, 0.0, 1.0]]);
    // Faces may precede their vertices, and objects of the same name become one mesh.
    let scene = obj(&format!("o a\nf 1 2 3\no b\nf 1 2 4\no a\nf 1 3 4\n{SQUARE}")).expect("loads");
    assert_eq!(scene.meshes.iter().map(|m| m.triangles.len()).collect::<Vec<_>>(), [2, 1]);
}

#[test]
fn obj_reads_opacity_and_reports_missing_materials() {
    let (folder, path) = file(
        "scene.obj",
        format!("mtllib my lib.mtl\nmtllib lost.mtl\n{SQUARE}usemtl glass\nf 1 2 3\nusemtl lost\nf 1 3 4\n")
            .as_bytes(),
    );
    let mtl = "newmtl glass\nKd 0.5\nKd 0.25 0.5 1\nTr 0.7\nNs x\n";
    std::fs::write(folder.path().join("my lib.mtl"), mtl).expect("writes");
    let scene = load(&path, &PLAIN()).expect("loads");
    let glass = &scene.materials[0];
    assert_eq!(glass.alpha, AlphaMode::Mask { cutoff: 0.5 });
    assert!((glass.base_color[3] - 0.3).abs() < 1e-6 && glass.base_color[2] == 1.0);
    assert_eq!((scene.notes.blended_materials, scene.notes.blended_triangles), (1, 1));
    assert!(scene.notes.omissions.iter().any(|o| o.what.contains("lost.mtl")));
    assert_eq!(load(&path, &only(&["lost"], &[])).expect("loads").stored_triangles(), 1);
    assert_eq!(load(&path, &only(&[], &["glass"])).expect("loads").stored_triangles(), 1);
}

#[test]
fn obj_rejects_bad_files() {
    assert!(matches!(refused(obj(&format!("{SQUARE}f 1 2 5\n"))), Error::IndexOutOfRange { index: 5, .. }));
    for line in ["f 1 2 x", "f 1 2 0", "f 1 2 -5", "v 1 2", "v 1 2 x"] {
        let error = refused(obj(&format!("{SQUARE}{line}\n")));
        assert!(error.to_string().contains("line 5"), "{line}: {error}");
    }
    assert!(matches!(refused(obj(&format!("{SQUARE}v nan 0 0\nf 1 2 5\n"))), Error::NotFinite { .. }));
    assert!(matches!(refused(obj(SQUARE)), Error::NoTriangles { .. }));
    assert!(matches!(refused(obj("v 1 1 1\nf 1 1 1\n")), Error::ZeroExtent { .. }));
    obj(&format!("# caf\u{e9}\n{SQUARE}f 1/999999999999999999 2/-9 3\n")).expect("loads");
}

#[test]
fn obj_truncated_anywhere_does_not_panic() {
    let text = format!("mtllib a\n{SQUARE}vt 0 0\nvn 0 1 0\no q\nusemtl m\nf 1/1/1 2/1/1 3/1/1 4\\\n/1\n");
    for length in 0..text.len() {
        let _ = load_bytes("scene.obj", &text.as_bytes()[..length], &PLAIN());
    }
}

/// A square with one unused vertex, as PLY.
fn ply(encoding: &str) -> Vec<u8> {
    let mut out = format!(
        "ply\nformat {encoding} 1.0\ncomment made here\nelement vertex 5\nproperty float x\nproperty double y\n\
         property int z\nproperty uchar red\nelement face 2\nproperty list uchar int vertex_indices\n\
         property short tag\nend_header\n"
    )
    .into_bytes();
    let points = [(0.0_f32, 0.0_f64, 0_i32), (1.0, 0.0, 0), (1.0, 0.0, 1), (0.0, 0.5, 1), (f32::NAN, 0.0, 0)];
    let faces: [&[i32]; 2] = [&[0, 1, 2, 3], &[0, 1]];
    if encoding == "ascii" {
        for (x, y, z) in points {
            let x = if x.is_finite() { x.to_string() } else { "1e39".to_owned() };
            out.extend(format!("{x} {y} {z} 7\n").bytes());
        }
        for face in faces {
            let corners: Vec<String> = face.iter().map(i32::to_string).collect();
            out.extend(format!("{} {} 3\n", face.len(), corners.join(" ")).bytes());
        }
        return out;
    }
    let big = encoding.contains("big");
    let put = |out: &mut Vec<u8>, bytes: &[u8]| {
        if big {
            out.extend(bytes.iter().rev());
        } else {
            out.extend(bytes);
        }
    };
    for (x, y, z) in points {
        put(&mut out, &x.to_le_bytes());
        put(&mut out, &y.to_le_bytes());
        put(&mut out, &z.to_le_bytes());
        out.push(7);
    }
    for face in faces {
        out.push(face.len() as u8);
        face.iter().for_each(|i| put(&mut out, &i.to_le_bytes()));
        put(&mut out, &3_i16.to_le_bytes());
    }
    out
}

const ENCODINGS: [&str; 3] = ["ascii", "binary_little_endian", "binary_big_endian"];

#[test]
fn ply_loads_in_all_encodings() {
    for encoding in ENCODINGS {
        let scene = load_bytes("scene.ply", &ply(encoding), &PLAIN()).expect(encoding);
        assert_eq!(scene.meshes[0].triangles, [[0, 1, 2], [0, 2, 3]], "{encoding}");
        assert_eq!(scene.meshes[0].positions.len(), 4);
        assert_eq!(scene.meshes[0].positions[3], [0.0, 0.5, 1.0]);
        assert_eq!(scene.notes.omissions.iter().map(|o| o.count).sum::<u64>(), 1);
    }
    let windows = String::from_utf8(ply("ascii")).expect("text").replace('\n', "\r\n");
    load_bytes("scene.ply", windows.as_bytes(), &PLAIN()).expect("loads");
}

#[test]
fn ply_truncated_at_any_length_is_an_error() {
    for encoding in ENCODINGS {
        let bytes = ply(encoding);
        let last = if encoding == "ascii" { bytes.len() - 1 } else { bytes.len() };
        for length in 0..last {
            let error = refused(load_bytes("scene.ply", &bytes[..length], &PLAIN()));
            assert!(matches!(error, Error::SceneParse { .. }), "{encoding} {length}: {error}");
        }
    }
}

#[test]
fn ply_rejects_bad_files() {
    let text = String::from_utf8(ply("ascii")).expect("text");
    let changed = |from: &str, to: &str| {
        assert!(text.contains(from));
        refused(load_bytes("scene.ply", text.replace(from, to).as_bytes(), &PLAIN()))
    };
    assert!(matches!(changed("4 0 1 2 3 3", "4 0 1 2 9 3"), Error::IndexOutOfRange { index: 9, .. }));
    assert!(matches!(changed("4 0 1 2 3 3", "4 0 1 2 4 3"), Error::NotFinite { .. }));
    assert!(matches!(changed("4 0 1 2 3 3", "4 0 1 2 -1 3"), Error::SceneParse { .. }));
    assert!(matches!(changed("4 0 1 2 3 3", "4000000 0 1 2 3 3"), Error::SceneParse { .. }));
    assert!(matches!(changed("vertex 5", "vertex 99999999999999"), Error::SceneParse { .. }));
    assert!(matches!(changed("float x", "float u"), Error::SceneParse { .. }));
    assert!(matches!(
        changed("list uchar int vertex_indices", "list uchar float other"),
        Error::NoTriangles { .. }
    ));
    let _ = changed("element face 2", "element nothing 9999999999999\nelement face 2");
}

#[test]
fn ply_with_any_byte_changed_does_not_panic() {
    for encoding in ENCODINGS {
        let bytes = ply(encoding);
        for at in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[at] ^= 0x81;
            let _ = load_bytes("scene.ply", &changed, &PLAIN());
        }
    }
}

#[test]
fn rejects_missing_empty_and_unknown_files() {
    let folder = tempfile::tempdir().expect("a folder");
    for ending in ["glb", "gltf", "obj", "ply"] {
        let path = folder.path().join("scene.").with_extension(ending);
        let error = refused(load(&path, &PLAIN()));
        assert!(
            matches!(&error, Error::Io(IoError { source, .. }) if source.kind() == std::io::ErrorKind::NotFound)
        );
        std::fs::write(&path, "").expect("writes");
        let error = refused(load(&path, &PLAIN()));
        assert!(error.to_string().contains("empty"), "{error}");
        std::fs::remove_file(&path).expect("removes");
        std::fs::create_dir(&path).expect("creates");
        let error = refused(load(&path, &PLAIN()));
        assert!(matches!(&error, Error::Io(_)), "{error}");
    }
    let error = refused(load(&folder.path().join("scene.fbx"), &PLAIN()));
    assert!(matches!(error, Error::UnknownSceneFormat { .. }));
}

#[test]
fn shared_scenes_have_the_listed_triangle_counts() {
    let Some(folder) = adumbra_testing::shared("scenes") else { return };
    // Name, stored triangles, instanced triangles (0: the same number).
    let list = [
        ("bunny_69k.ply", 69_451, 0),
        ("dragon_202k.ply", 202_520, 0),
        ("armadillo.ply", 86_482, 0),
        ("teapot.obj", 6_320, 0),
        ("zdm2.glb", 58_772, 0),
        ("dream_apartment.glb", 177_934, 0),
        ("bridge_garden.glb", 21_883, 0),
        ("kaykit_city_21.glb", 17_909, 438_968),
        ("kaykit_city_121.glb", 17_909, 15_115_691),
        ("delft.glb", 36_267, 0),
        ("oak_medium.glb", 13_806, 0),
        ("pine_medium.glb", 19_872, 0),
        ("alpine-2.glb", 41_620, 0),
        ("street-1.glb", 25_508, 0),
        ("jacksboro.glb", 275_772, 0),
        ("auster.obj", 46_603, 0),
        ("box-city-5k.glb", 60_002, 0),
        ("box-city-51k.glb", 614_402, 0),
    ];
    for (name, stored, instanced) in list {
        let started = std::time::Instant::now();
        let scene = load(&folder.join(name), &PLAIN()).unwrap_or_else(|e| panic!("{e}"));
        let seconds = started.elapsed().as_secs_f64();
        let notes = &scene.notes;
        println!(
            "{name}: {} + {} degenerate, {} instanced, {} meshes, {} instances, {} textures, {seconds:.3} s {:?}",
            scene.stored_triangles(),
            notes.degenerate_triangles,
            scene.instanced_triangles(),
            scene.meshes.len(),
            scene.instances.len(),
            scene.textures.len(),
            notes.warnings,
        );
        assert_eq!(scene.stored_triangles() + notes.degenerate_triangles, stored, "{name}");
        if instanced > 0 {
            // Degenerate triangles are missing from every instance.
            let missing = instanced - scene.instanced_triangles();
            let most = notes.degenerate_triangles * scene.instances.len() as u64;
            assert!((1..=most).contains(&missing), "{name}: {missing}");
        }
        let mirrored = scene.instances.iter().any(|i| i.determinant() < 0.0);
        assert!(!mirrored || instanced > 0, "{name}");
    }
}

/// A right triangle with legs of 10 m in map coordinates. Every corner is a quarter of a metre away from the
/// nearest `f32` position.
const MAP_CORNERS: [[f64; 3]; 3] =
    [[500_000.125, 31.5, 5_000_000.25], [500_010.125, 31.5, 5_000_000.25], [500_000.125, 31.5, 5_000_010.25]];

#[test]
fn obj_and_ply_at_map_coordinates_keep_double_precision() {
    let lines = |prefix: &str| -> String {
        MAP_CORNERS.iter().map(|[x, y, z]| format!("{prefix}{x} {y} {z}\n")).collect()
    };
    let obj_text = format!("{}f 1 2 3\n", lines("v "));
    let ply_text = format!(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\n\
         element face 1\nproperty list uchar int vertex_indices\nend_header\n{}3 0 1 2\n",
        lines("")
    );
    for (file, text) in [("scene.obj", obj_text), ("scene.ply", ply_text)] {
        let scene = load_bytes(file, text.as_bytes(), &PLAIN()).expect("loads");
        assert_eq!(world_triangles(&scene), [MAP_CORNERS], "{file}");
        assert_eq!(scene.meshes[0].positions[1], [10.0, 31.5, 0.0], "{file}");
    }
}
