//! Opacity of glTF materials: alpha modes, textures and their transforms, and vertex colours.

use adumbra_scene::{AlphaMode, Error, LoadOptions, MippedTexture};
use serde_json::json;

use crate::kit::{Glb, png, refused, refused_any, textured};

#[test]
fn gltf_mask_and_blend_load_their_alpha() {
    let image = json!({"uri": "data:image/png;base64,"});
    let texture = json!({"index": 0, "texCoord": 1});
    let mut glb = textured(
        json!({"alphaMode": "MASK", "alphaCutoff": 0.25, "pbrMetallicRoughness": {"baseColorTexture": texture}}),
        &image,
    );
    let view = glb.view(&png(&[0, 255]));
    glb.json["images"][0] = json!({"bufferView": view, "mimeType": "image/png"});
    let scene = glb.load().expect("loads");
    assert_eq!(scene.materials[0].alpha, AlphaMode::Mask { cutoff: 0.25 });
    assert_eq!(scene.meshes[0].uvs.len(), 3);
    assert!(!scene.is_opaque(0, [0.25, 0.5], 1.0) && scene.is_opaque(0, [0.75, 0.5], 1.0));
    assert_eq!(scene.notes.blended_materials, 0);
    let colored = LoadOptions { color_textures: true, ..LoadOptions::default() };
    let scene = glb.load_with(&colored).expect("loads");
    assert_eq!(MippedTexture::new(&scene.textures[0]).color([0.75, 0.5], 0.0)[0], 1.0);
    assert!(!scene.is_opaque(0, [0.25, 0.5], 1.0) && scene.is_opaque(0, [0.75, 0.5], 1.0));

    glb.json["materials"][0]["alphaMode"] = json!("BLEND");
    let scene = glb.load().expect("loads");
    assert_eq!(scene.materials[0].alpha, AlphaMode::Mask { cutoff: 0.5 });
    assert_eq!((scene.notes.blended_materials, scene.notes.blended_triangles), (1, 1));
    let ignoring = LoadOptions { ignore_alpha: true, ..LoadOptions::default() };
    let scene = glb.load_with(&ignoring).expect("loads");
    assert!(scene.materials[0].alpha == AlphaMode::Opaque && scene.textures.is_empty());
    assert_eq!(scene.notes.blended_materials, 0);
}

#[test]
fn gltf_vertex_colours_are_read_only_where_they_have_an_effect() {
    let with_colors = |make: &dyn Fn(&mut Glb) -> usize, material: serde_json::Value| {
        let mut glb = Glb::triangle();
        let colors = make(&mut glb);
        glb.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
        glb.json["meshes"][0]["primitives"][0]["material"] = json!(0);
        glb.push("materials", material);
        glb
    };
    let floats = |glb: &mut Glb| glb.floats(&[1.0, 0.5, 0.0, -1.0, 7.0, 0.214_041, 0.0, 0.0, 1.0], "VEC3");
    let bytes = |glb: &mut Glb| {
        let colors = glb.accessor(&[255, 128, 0, 255, 0, 0, 255, 128, 255, 255, 255, 0], 5121, "VEC4", 3);
        glb.json["accessors"][colors]["normalized"] = json!(true);
        colors
    };
    let colored = LoadOptions { color_textures: true, ..LoadOptions::default() };
    let read =
        |glb: Glb, options: &LoadOptions| glb.load_with(options).expect("loads").meshes[0].colors.clone();
    // Colours are sRGB, with linear alpha.
    let opaque = with_colors(&floats, json!({}));
    assert_eq!(read(opaque, &colored), [[255, 188, 0, 255], [0, 255, 127, 255], [0, 0, 255, 255]]);
    let expected = [[255, 188, 0, 255], [0, 0, 255, 128], [255, 255, 255, 0]];
    assert_eq!(read(with_colors(&bytes, json!({})), &colored), expected);
    // For a bake, vertex colours are loaded only if they cut.
    assert!(read(with_colors(&bytes, json!({})), &LoadOptions::default()).is_empty());
    let masked = with_colors(&bytes, json!({"alphaMode": "MASK"}));
    let scene = masked.load().expect("loads");
    assert_eq!(scene.meshes[0].colors, expected);
    assert_eq!(scene.meshes[0].corner_alphas(0), [1.0, 128.0 / 255.0, 0.0]);
    assert!(scene.is_opaque(0, [0.0; 2], 0.5) && !scene.is_opaque(0, [0.0; 2], 0.49));

    let pairs = |glb: &mut Glb| glb.floats(&[0.0; 6], "VEC2");
    let error = refused_any(with_colors(&pairs, json!({})).load_with(&colored));
    assert!(error.to_string().contains("COLOR_0"), "{error}");
    assert!(with_colors(&pairs, json!({})).load().is_ok());
}

#[test]
fn gltf_texture_transform_moves_the_coordinates() {
    let info = json!({"index": 0, "extensions": {"KHR_texture_transform":
        {"offset": [0.5, 0.25], "scale": [2, 3], "rotation": std::f32::consts::FRAC_PI_2, "texCoord": 1}}});
    let mut glb = textured(
        json!({"alphaMode": "MASK", "pbrMetallicRoughness": {"baseColorTexture": info}}),
        &json!({}),
    );
    let view = glb.view(&png(&[0, 255]));
    glb.json["images"][0] = json!({"bufferView": view});
    let scene = glb.load().expect("loads");
    let expected = [[0.5, 0.25], [0.5, -1.75], [3.5, 0.25]];
    for (uv, want) in scene.meshes[0].uvs.iter().zip(expected) {
        assert!((uv[0] - want[0]).abs() < 1e-6 && (uv[1] - want[1]).abs() < 1e-6, "{uv:?} {want:?}");
    }
}

#[test]
fn gltf_missing_texture_is_an_error_only_for_opacity() {
    let pbr = json!({"baseColorTexture": {"index": 0, "texCoord": 1}});
    let mut glb = textured(
        json!({"name": "leaf", "alphaMode": "MASK", "pbrMetallicRoughness": pbr}),
        &json!({"uri": "no%20leaf.png"}),
    );
    let error = refused(glb.load());
    assert!(matches!(&error, Error::Texture { material, texture, .. }
        if material == "leaf" && texture == "no%20leaf.png"));
    assert!(error.to_string().contains("with its alpha ignored"));
    glb.load_with(&LoadOptions { ignore_alpha: true, ..LoadOptions::default() }).expect("loads");
    glb.json["materials"][0]["alphaMode"] = json!("OPAQUE");
    assert!(glb.load().expect("loads").notes.warnings.is_empty());
    let scene =
        glb.load_with(&LoadOptions { color_textures: true, ..LoadOptions::default() }).expect("loads");
    assert!(scene.notes.warnings[0].contains("no%20leaf.png"));
}
