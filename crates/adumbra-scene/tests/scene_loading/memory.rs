//! Memory limits of loading, and very long text files.

use adumbra_scene::{Error, Result};
use adumbra_scene::{LoadOptions, Scene, load};
use serde_json::{Value, json};

use crate::kit::{FLOAT, Glb, file, load_bytes};

fn within(max_memory_bytes: u64) -> LoadOptions {
    LoadOptions { max_memory_bytes: Some(max_memory_bytes), ..LoadOptions::default() }
}

fn assert_too_large(result: Result<Scene>, part: &str) {
    let error = result.expect_err("more than is allowed");
    assert!(matches!(error, Error::SceneMemory { .. }), "{error}");
    let message = error.to_string();
    assert!(
        message.contains("raise the memory limit") && message.contains(part) && message.contains("scene."),
        "{message}"
    );
}

/// A grey image whose alpha is 0 everywhere.
fn clear_png(side: u32) -> Vec<u8> {
    let mut out = std::io::Cursor::new(Vec::new());
    image::GrayAlphaImage::new(side, side).write_to(&mut out, image::ImageFormat::Png).expect("encodes");
    out.into_inner()
}

/// The header of a PNG of this size, with nothing after it.
fn png_header(side: u32) -> Vec<u8> {
    let mut out = clear_png(1);
    out.truncate(33);
    out[16..20].copy_from_slice(&side.to_be_bytes());
    out[20..24].copy_from_slice(&side.to_be_bytes());
    let check = crc32fast::hash(&out[12..29]);
    out[29..33].copy_from_slice(&check.to_be_bytes());
    out.extend([0; 4]);
    out.extend(b"IDAT");
    out
}

/// One triangle per image, masked by that image.
fn masked(images: &[Value], sampler: Option<usize>) -> Glb {
    let mut glb = Glb::triangle();
    let uvs = glb.floats(&[0.0, 0.0, 0.0, 1.0, 1.0, 0.0], "VEC2");
    for (index, image) in images.iter().enumerate() {
        glb.push("images", image.clone());
        let sampler = sampler.map_or(json!({"source": index}), |s| json!({"source": index, "sampler": s}));
        glb.push("textures", sampler);
        let texture = json!({"baseColorTexture": {"index": index}});
        glb.push("materials", json!({"alphaMode": "MASK", "pbrMetallicRoughness": texture}));
    }
    let primitive = |i: usize| json!({"attributes": {"POSITION": 0, "TEXCOORD_0": uvs}, "material": i});
    glb.json["meshes"][0]["primitives"] = (0..images.len()).map(primitive).collect();
    glb
}

#[test]
fn images_of_the_same_bytes_are_decoded_once() {
    let side = 256;
    let texels = u64::from(side * side);
    // One image needs five bytes per texel while it is decoded. Twenty decoded images would need twenty.
    let enough = within((1 << 18) + 5 * texels);
    let mut glb = masked(&vec![json!({"bufferView": 2, "mimeType": "image/png"}); 20], None);
    assert_eq!(glb.view(&clear_png(side)), 2);
    let scene = glb.load_with(&enough).expect("loads");
    assert_eq!(scene.textures.len(), 1);
    assert!(scene.materials[..20].iter().all(|m| m.texture == Some(0)));
    assert_too_large(glb.load_with(&within(2 * texels)), "256 x 256");

    // Separate views of the same bytes, and different names for the same file.
    let mut glb = masked(&(0..20).map(|i| json!({"bufferView": 2 + i})).collect::<Vec<_>>(), None);
    let view = glb.view(&clear_png(side));
    let view = glb.json["bufferViews"][view].clone();
    for _ in 1..20 {
        glb.push("bufferViews", view.clone());
    }
    assert_eq!(glb.load_with(&enough).expect("loads").textures.len(), 1);

    let uris = (0..20).map(|i| json!({"uri": format!("{}leaf.png", "./".repeat(i))})).collect::<Vec<_>>();
    let (folder, path) = file("scene.glb", &masked(&uris, None).bytes());
    std::fs::write(folder.path().join("leaf.png"), clear_png(side)).expect("writes");
    assert_eq!(load(&path, &enough).expect("loads").textures.len(), 1);
}

#[test]
fn copies_for_other_samplers_are_counted() {
    let side = 256;
    let texels = u64::from(side * side);
    let mut glb = masked(&vec![json!({"bufferView": 2}); 4], None);
    glb.view(&clear_png(side));
    for (index, wrap) in [10_497, 33_071, 33_648].into_iter().enumerate() {
        glb.push("samplers", json!({"wrapS": wrap}));
        glb.json["textures"][index + 1]["sampler"] = json!(index);
    }
    let scene = glb.load().expect("loads");
    assert_eq!(scene.textures.len(), 3);
    assert_eq!(scene.materials[0].texture, scene.materials[1].texture);
    assert_ne!(scene.textures[1].wrap, scene.textures[2].wrap);
    // Enough memory to decode one copy, but not to keep three.
    let needed = 3 * texels;
    glb.load_with(&within(needed + (1 << 16))).expect("loads");
    assert_too_large(glb.load_with(&within(needed)), "256");
}

#[test]
fn images_are_counted_before_they_are_decoded() {
    // The file has only a header, so decoding it would report an invalid image instead.
    for uri in [false, true] {
        let image = if uri { json!({"uri": "leaf.png"}) } else { json!({"bufferView": 2}) };
        let mut glb = masked(&[image], None);
        glb.view(&png_header(11_000));
        let (folder, path) = file("scene.glb", &glb.bytes());
        std::fs::write(folder.path().join("leaf.png"), png_header(11_000)).expect("writes");
        assert_too_large(load(&path, &within(100 << 20)), "11000 x 11000");
        let error = load(&path, &LoadOptions::default()).expect_err("broken");
        assert!(matches!(error, Error::Texture { .. }), "{error}");
    }
    let (folder, path) = file("scene.obj", b"mtllib a.mtl\nv 0 0 0\nv 0 0 1\nv 1 0 0\nusemtl m\nf 1 2 3\n");
    std::fs::write(folder.path().join("a.mtl"), "newmtl m\nmap_Kd leaf.png\n").expect("writes");
    std::fs::write(folder.path().join("leaf.png"), png_header(11_000)).expect("writes");
    assert_too_large(
        load(&path, &LoadOptions { color_textures: true, ..within(100 << 20) }),
        "11000 x 11000",
    );
    load(&path, &within(100 << 20)).expect("loads without colours");
}

#[test]
fn rejects_images_above_the_size_limit_of_an_image() {
    let mut glb = masked(&[json!({"bufferView": 2})], None);
    glb.view(&png_header(60_000));
    let message = glb.load_with(&within(1 << 40)).expect_err("too large").to_string();
    assert!(
        message.contains("60000 x 60000 texels") || message.contains("larger than an image"),
        "{message}"
    );
}

/// This many primitives on one accessor with this many vertices.
fn shared(primitives: usize, vertices: usize) -> Glb {
    let mut glb = Glb::new();
    let corners: Vec<f32> = (0..3 * vertices).map(|i| (i * i % 101) as f32).collect();
    glb.floats(&corners, "VEC3");
    let primitive = json!({"attributes": {"POSITION": 0}});
    glb.push("meshes", json!({"primitives": vec![primitive; primitives]}));
    glb
}

#[test]
fn primitives_that_share_an_accessor_are_counted() {
    // 6 KB of positions and 1 MB of JSON describe 40 million triangles.
    let glb = shared(30_000, 3_999);
    assert_too_large(glb.load_with(&within(256 << 20)), "39990000 triangles");
    // Without an explicit limit, memory is bounded for a file of two megabytes too.
    assert_too_large(shared(20_000, 60_000).load(), "400000000 triangles");
    let scene = shared(1_000, 30).load_with(&within(8 << 20)).expect("loads");
    let notes = &scene.notes;
    assert_eq!(scene.stored_triangles() + notes.degenerate_triangles, 10_000);
}

#[test]
fn json_objects_are_counted() {
    let mut glb = Glb::triangle();
    glb.json["nodes"] = json!(vec![json!({}); 100_000]);
    glb.json["nodes"][0]["mesh"] = json!(0);
    assert_too_large(glb.load_with(&within(16 << 20)), "objects of its JSON");
    glb.load_with(&within(64 << 20)).expect("loads");
}

#[test]
fn lists_of_unknown_extensions_are_counted() {
    let mut glb = Glb::triangle();
    glb.json["nodes"][0]["extensions"] = json!({"unknown": vec![0; 1_000_000]});
    assert_too_large(glb.load_with(&within(32 << 20)), "objects of its JSON");
    glb.load_with(&within(80 << 20)).expect("loads");
}

#[test]
fn accessors_without_bytes_are_counted() {
    let mut glb = shared(5_000, 3);
    glb.json["accessors"][0] = json!({"componentType": FLOAT, "type": "VEC3", "count": 4_000});
    assert_too_large(glb.load_with(&within(64 << 20)), "triangles");
}

#[test]
fn rejects_sparse_accessors_with_too_many_replacements() {
    let mut glb = Glb::triangle();
    let (indices, values) = (glb.view(&[0; 400]), glb.view(&[0; 4_800]));
    glb.json["accessors"][0]["sparse"] = json!({
        "count": 400, "indices": {"bufferView": indices, "componentType": 5121}, "values": {"bufferView": values},
    });
    let error = glb.load().expect_err("three elements");
    assert!(error.to_string().contains("replaces more elements than it has"), "{error}");
}

#[test]
fn instances_are_counted() {
    let mut glb = Glb::triangle();
    let count = 2_000;
    let places = glb.floats(&vec![1.0; 3 * count], "VEC3");
    let node = json!({
        "mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places}}},
    });
    glb.json["nodes"] = json!(vec![node; 100]);
    glb.json["scenes"] = json!([{"nodes": (0..100).collect::<Vec<_>>()}]);
    assert_too_large(glb.load_with(&within(4 << 20)), "instances of node");
    glb.json["scenes"] = json!([{"nodes": [0, 1]}]);
    assert_eq!(glb.load_with(&within(4 << 20)).expect("loads").instances.len(), 2 * count);
}

#[test]
fn animation_keys_are_counted() {
    let mut glb = Glb::triangle();
    let count = 100_000;
    let times = glb.floats(&(0..count).map(|i| i as f32).collect::<Vec<_>>(), "SCALAR");
    let moves = glb.floats(&vec![1.0; 3 * count], "VEC3");
    glb.json["nodes"] = json!(vec![json!({"mesh": 0}); 3_000]);
    let channel = |node: usize| json!({"sampler": 0, "target": {"node": node, "path": "translation"}});
    glb.push(
        "animations",
        json!({
            "samplers": [{"input": times, "output": moves}],
            "channels": (0..3_000).map(channel).collect::<Vec<_>>(),
        }),
    );
    assert_too_large(glb.load_with(&within(64 << 20)), "keys of node");
}

#[test]
fn text_files_and_their_geometry_are_counted() {
    let corners: String = (0..30_000).map(|i| format!("v {i} 0 {}\n", i % 7)).collect();
    let faces: String = (1..29_998).map(|i| format!("f {i} {} {}\n", i + 1, i + 2)).collect();
    let obj = (corners + &faces).into_bytes();
    assert_too_large(load_bytes("scene.obj", &obj, &within(obj.len() as u64 / 2)), "the file");
    assert_too_large(load_bytes("scene.obj", &obj, &within(4 << 20)), "the triangles and vertices");
    load_bytes("scene.obj", &obj, &within(16 << 20)).expect("loads");

    let mut ply =
        b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nelement face 20000\nproperty list uchar int vertex_indices\nend_header\n"
            .to_vec();
    ply.extend([0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0].iter().flat_map(|c| c.to_le_bytes()));
    for _ in 0..20_000 {
        ply.push(3);
        ply.extend([0_i32, 1, 2].iter().flat_map(|c| c.to_le_bytes()));
    }
    assert_too_large(load_bytes("scene.ply", &ply, &within(400 << 10)), "corners of faces");
    load_bytes("scene.ply", &ply, &within(4 << 20)).expect("loads");
}

#[test]
fn corners_of_a_face_are_counted_before_allocation() {
    let obj = format!("v 0 0 0\nv 0 0 1\nv 1 0 0\nf{}\n", " 1 2 3".repeat(100_000));
    let text = 3 * obj.len() as u64;
    let least = text + 4096;
    assert_too_large(load_bytes("scene.obj", obj.as_bytes(), &within(least)), "a face of 300000 corners");

    let mut ply =
        b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nelement face 1\nproperty list uint uchar vertex_indices\nend_header\n"
            .to_vec();
    ply.extend([0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0].iter().flat_map(|c| c.to_le_bytes()));
    ply.extend(300_000_u32.to_le_bytes());
    ply.extend([0, 1, 2].repeat(100_000));
    assert_too_large(load_bytes("scene.ply", &ply, &within(1 << 20)), "300000 corners of faces");
}

/// Each of these files took seconds to hours when the time grew with the square of the length.
#[test]
fn long_text_files_load_in_linear_time() {
    // Work that grows with the square of the length would exceed the time limit of a test.
    let triangle = "v 0 0 0\nv 0 0 1\nv 1 0 0\nf 1 2 3\n";
    let numbered = |line: &str| (0..100_000).map(|i| line.replace('#', &i.to_string())).collect::<String>();
    let cases = [
        ("joined lines", format!("{triangle}{}", "\\\n".repeat(1_500_000)), 1),
        ("a joined face", format!("{triangle}f 1 \\\n 2 \\\n 3{}\n", "\\\n".repeat(1_000_000)), 2),
        ("materials", format!("{triangle}{}", numbered("usemtl m#\nf 1 2 3\n")), 100_001),
        ("objects", format!("{triangle}{}", numbered("o m#\nf 1 2 3\n")), 100_001),
        ("libraries", format!("{triangle}{}", numbered("mtllib m#\n")), 1),
    ];
    for (name, text, triangles) in cases {
        let scene = load_bytes("scene.obj", text.as_bytes(), &LoadOptions::default()).expect(name);
        assert_eq!(scene.stored_triangles(), triangles, "{name}");
    }
}

#[test]
fn polygons_of_very_many_corners_load_in_bounded_time() {
    // Numbers of teeth below and above the corner limit of ear clipping.
    for teeth in [8_000, 200_000_u32] {
        let (mut text, mut face) = (String::new(), "f".to_owned());
        let corners = 2 * teeth + 2;
        for i in 0..corners - 2 {
            text += &format!(
                "v {} 0 {}\n",
                f64::from(i),
                if i % 2 == 0 { 1.0 } else { 50.0 + f64::from(i % 97) }
            );
        }
        text += &format!("v {} 0 0\nv 0 0 0\n", corners - 3);
        (1..=corners).for_each(|i| face += &format!(" {i}"));
        let scene = load_bytes("scene.obj", (text + &face + "\n").as_bytes(), &LoadOptions::default());
        let scene = scene.expect("loads");
        assert_eq!(scene.notes.untriangulated_polygons, u64::from(corners > 1 << 14));
    }
}

#[test]
fn skinned_copies_of_a_mesh_are_counted() {
    let skinned = |copies: usize, mut glb: Glb| {
        glb.json["nodes"] = json!(vec![json!({"mesh": 0, "skin": 0}); copies]);
        glb.json["skins"] = json!([{"joints": [0]}]);
        glb.json["scenes"] = json!([{"nodes": (0..copies).collect::<Vec<_>>()}]);
        glb
    };
    // A 100 KB name, or 1,000 primitives: stored once in the file, but copied for each node.
    let mut named = Glb::triangle();
    named.json["meshes"][0]["name"] = json!("n".repeat(100_000));
    assert_too_large(skinned(1_000, named.clone()).load_with(&within(32 << 20)), "1000 skinned copies");
    assert_too_large(skinned(2_000, shared(1_000, 3)).load_with(&within(32 << 20)), "2000000 triangles");
    let scene = skinned(20, named).load_with(&within(32 << 20)).expect("loads");
    assert_eq!((scene.meshes.len(), scene.meshes[19].name.len()), (20, 100_000));
    // Nodes that a filter treats alike share the kept primitives; other nodes keep different primitives.
    let mut glb = skinned(3, shared(2, 3));
    glb.json["nodes"][1]["name"] = json!("tree");
    glb.json["materials"] = json!([{"name": "leaf"}]);
    glb.json["meshes"][0]["primitives"][1]["material"] = json!(0);
    let kept = |only: &[&str], exclude: &[&str]| {
        let scene = glb.load_with(&crate::kit::only(only, exclude)).expect("loads");
        scene.meshes.iter().map(|m| m.triangles.len()).collect::<Vec<_>>()
    };
    assert_eq!(kept(&[], &[]), [2, 2, 2]);
    assert_eq!(kept(&["tree", "leaf"], &[]), [1, 2, 1]);
    assert_eq!(kept(&[], &["tree", "leaf"]), [1, 1]);
}

#[test]
fn extras_of_a_mesh_are_read_once() {
    let mut glb = Glb::triangle();
    glb.json["meshes"][0]["extras"] = json!({"adumbra": {"cast": false}, "more": vec![0; 200_000]});
    glb.json["nodes"] = json!(vec![json!({"mesh": 0}); 80_000]);
    glb.json["nodes"][0] = json!({"mesh": 1});
    glb.json["scenes"] = json!([{"nodes": (0..80_000).collect::<Vec<_>>()}]);
    glb.push("meshes", json!({"primitives": [{"attributes": {"POSITION": 0}}]}));
    // Scanning the mesh once per node would take minutes, longer than the time limit of a test.
    let scene = glb.load().expect("loads");
    assert_eq!(scene.instances.iter().filter(|i| i.casts).count(), 1);
}

#[test]
fn names_of_objects_are_kept_once() {
    let text = |name: &str| {
        let faces: String = (0..2_000).map(|i| format!("usemtl {}\nf 1 2 3\n", i % 2)).collect();
        format!("v 0 0 0\nv 0 0 1\nv 1 0 0\nf 1 2 3\no {name}\n{faces}o other\nf 1 2 3\no {name}\nf 1 2 3\n")
    };
    let scene =
        load_bytes("scene.obj", text(&"n".repeat(100_000)).as_bytes(), &within(8 << 20)).expect("loads");
    let found: Vec<_> = scene.meshes.iter().map(|m| (m.name.len(), m.triangles.len())).collect();
    assert_eq!(found, [(14, 1), (100_000, 2_001), (5, 1)]);
    assert_eq!(scene.meshes[0].name, "unnamed_object");
    let small = text("n").len() as u64;
    assert_too_large(
        load_bytes("scene.obj", text("n").as_bytes(), &within(4 * small)),
        "the triangles and vertices of \"n\"",
    );
    load_bytes("scene.obj", text("n").as_bytes(), &within(16 * small)).expect("loads");
}

#[test]
fn decoding_one_image_under_many_lengths_is_limited() {
    // The file has only a header, so each image is released at once. A different length makes a different
    // image.
    let count = 12;
    let mut png = png_header(11_000);
    let least = png.len();
    png.resize(least + count, 0);
    let images: Vec<_> = (0..count).map(|i| json!({"bufferView": 2 + i})).collect();
    let mut glb = masked(&images, None);
    for material in 0..count {
        glb.json["materials"][material]["alphaMode"] = json!("OPAQUE");
    }
    let view = glb.view(&png);
    let view = glb.json["bufferViews"][view].clone();
    for i in 1..count {
        let mut view = view.clone();
        view["byteLength"] = json!(least + i);
        glb.push("bufferViews", view);
    }
    let options = LoadOptions { color_textures: true, ..LoadOptions::default() };
    assert_too_large(glb.load_with(&options), "decoded one by one");
    let trusted = LoadOptions { max_memory_bytes: Some(4 << 30), ..options };
    assert_eq!(glb.load_with(&trusted).expect("loads").notes.warnings.len(), count);
}
