//! Images in KTX2 files with Basis Universal texels. The Basis Universal encoder made the fixtures
//! (`tests/fixtures/encode.mjs`); the PNG files beside them hold the output of the project's decoder.

use std::path::PathBuf;

#[cfg(feature = "ktx2")]
use adumbra_scene::Pixels;
use adumbra_scene::{Error, LoadOptions, Result, Scene};
use serde_json::json;

use crate::kit::{Glb, png, refused};

fn fixture(name: &str) -> Vec<u8> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/ktx2");
    std::fs::read(folder.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// A triangle masked by a KTX2 image.
fn masked(image: &[u8]) -> Glb {
    let mut glb = Glb::triangle();
    let uvs = glb.floats(&[0.0, 0.0, 0.0, 1.0, 1.0, 0.0], "VEC2");
    let view = glb.view(image);
    glb.push("images", json!({"bufferView": view, "mimeType": "image/ktx2"}));
    glb.push("textures", json!({"extensions": {"KHR_texture_basisu": {"source": 0}}}));
    let texture = json!({"baseColorTexture": {"index": 0}});
    glb.push("materials", json!({"name": "leaf", "alphaMode": "MASK", "pbrMetallicRoughness": texture}));
    glb.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(uvs);
    glb.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    glb.json["extensionsRequired"] = json!(["KHR_texture_basisu"]);
    glb
}

fn in_colour(glb: &Glb) -> Result<Scene> {
    glb.load_with(&LoadOptions { color_textures: true, ..LoadOptions::default() })
}

#[cfg(feature = "ktx2")]
const FORMS: [&str; 7] =
    ["etc1s", "etc1s-opaque", "etc1s-odd-size", "uastc", "uastc-opaque", "uastc-zstd", "uastc-zstd-odd-size"];

#[cfg(feature = "ktx2")]
#[test]
fn ktx2_images_match_the_reference_decoder() {
    for form in FORMS {
        let glb = masked(&fixture(&format!("{form}.ktx2")));
        let expected = image::load_from_memory(&fixture(&format!("{form}.png"))).expect("a PNG").into_rgba8();
        let scene = in_colour(&glb).unwrap_or_else(|e| panic!("{form}: {e}"));
        let texture = &scene.textures[0];
        assert_eq!((texture.width, texture.height), expected.dimensions(), "{form}");
        let Pixels::Rgba(texels) = &texture.pixels else { panic!("{form} has no colours") };
        assert_eq!(texels, expected.as_raw(), "{form}");

        let scene = glb.load().unwrap_or_else(|e| panic!("{form}: {e}"));
        let alpha: Vec<u8> = expected.pixels().map(|p| p.0[3]).collect();
        match scene.textures.first().map(|t| &t.pixels) {
            None => assert!(form.ends_with("opaque") && alpha.iter().all(|&a| a == 255), "{form}"),
            Some(Pixels::Alpha(texels)) => assert_eq!(texels, &alpha, "{form}"),
            Some(Pixels::Rgba(_)) => panic!("{form}: colours were not asked for"),
        }
    }
}

#[cfg(feature = "ktx2")]
#[test]
fn ktx2_files_of_gltf_transform_load() {
    for name in ["wave-etc1s.glb", "wave-uastc.glb"] {
        let scene = crate::kit::load_bytes("scene.glb", &fixture(name), &LoadOptions::default()).expect(name);
        assert_eq!((scene.stored_triangles(), scene.textures.len()), (98, 1), "{name}");
        let texture = &scene.textures[0];
        // The leaf covers the middle of the image.
        assert!(texture.alpha([0.5, 0.5]) > 0.9 && texture.alpha([0.02, 0.02]) < 0.1, "{name}");
    }
}

#[cfg(feature = "ktx2")]
#[test]
fn ktx2_is_used_only_without_a_plain_image() {
    let mut glb = masked(&fixture("etc1s.ktx2"));
    let plain = glb.view(&png(&[255, 0, 7]));
    glb.push("images", json!({"bufferView": plain}));
    assert_eq!(in_colour(&glb).expect("loads").textures[0].width, 32);
    glb.json["textures"][0]["source"] = json!(1);
    assert_eq!(in_colour(&glb).expect("loads").textures[0].width, 3);
    // An image index that does not exist counts as no image.
    glb.json["textures"][0]["source"] = json!(9);
    assert_eq!(in_colour(&glb).expect("loads").textures[0].width, 32);
}

/// The message for a mask that cannot be read. Checks that the material is named.
fn what(image: &[u8]) -> String {
    let error = refused(masked(image).load());
    let Error::Texture { material, what, .. } = error else { panic!("{error}") };
    assert_eq!(material, "leaf");
    what
}

#[cfg(feature = "ktx2")]
fn with_word(image: &[u8], at: usize, word: u32) -> Vec<u8> {
    let mut image = image.to_vec();
    image[at..at + 4].copy_from_slice(&word.to_le_bytes());
    image
}

#[cfg(feature = "ktx2")]
#[test]
fn ktx2_faults_are_errors_that_say_why() {
    let etc1s = fixture("etc1s.ktx2");
    let zstd = fixture("uastc-zstd.ktx2");
    let format_at = u32::from_le_bytes(etc1s[48..52].try_into().unwrap()) as usize;
    for (image, part) in [
        (with_word(&etc1s, 12, 43), "R8G8B8A8_SRGB"),
        (with_word(&etc1s, 12, 145), "a BC format"),
        (with_word(&etc1s, 12, 7000), "Vulkan format 7000"),
        (with_word(&etc1s, 20, 0), "another kind"),
        (with_word(&etc1s, 28, 2), "another kind"),
        (with_word(&etc1s, 32, 3), "another kind"),
        (with_word(&etc1s, 36, 6), "another kind"),
        (with_word(&etc1s, 44, 3), "supercompression scheme 3"),
        (with_word(&etc1s, 44, 0), "supercompression scheme 0"),
        (with_word(&etc1s, format_at + 12, 0x0002_01a7), "UASTC HDR"),
        (with_word(&etc1s, format_at + 12, 0x0002_0101), "RGBSDA"),
        (with_word(&etc1s, 52, 76), "data format descriptor"),
        (with_word(&etc1s, 48, u32::MAX), "cut off"),
        (with_word(&etc1s, 80, u32::MAX), "cut off"),
        (with_word(&etc1s, 64, u32::MAX), "cut off"),
        (with_word(&etc1s, 40, 1 << 30), "past the KTX2 file"),
        (with_word(&zstd, 20, 64), "Zstandard data is broken"),
        (with_word(&zstd, 20, 1 << 24), "more than an image may have"),
        (with_word(&fixture("uastc.ktx2"), 20, 256), "Basis Universal data is broken"),
        (etc1s[..60].to_vec(), "cut off"),
        (etc1s[..etc1s.len() - 9].to_vec(), "cut off"),
    ] {
        let what = what(&image);
        assert!(what.contains(part), "{part}: {what}");
    }
}

#[cfg(feature = "ktx2")]
#[test]
fn ktx2_memory_is_counted_before_decoding() {
    // A few bytes describe 16 million texels.
    let image = with_word(&with_word(&fixture("etc1s.ktx2"), 20, 4096), 24, 4096);
    let within = |bytes| LoadOptions { max_memory_bytes: Some(bytes), ..LoadOptions::default() };
    let error = masked(&image).load_with(&within(64 << 20)).expect_err("too large");
    assert!(matches!(error, Error::SceneMemory { .. }), "{error}");
    assert!(error.to_string().contains("4096 x 4096"), "{error}");
}

#[cfg(not(feature = "ktx2"))]
#[test]
fn ktx2_without_its_feature_is_an_error_naming_it() {
    let what = what(&fixture("etc1s.ktx2"));
    assert!(what.contains("without the feature ktx2"), "{what}");
    let mut glb = masked(&fixture("etc1s.ktx2"));
    let plain = glb.view(&png(&[255, 0, 7]));
    glb.push("images", json!({"bufferView": plain}));
    glb.json["textures"][0]["source"] = json!(1);
    assert_eq!(in_colour(&glb).expect("loads").textures[0].width, 3);
}

#[test]
fn ktx2_faults_in_colour_textures_are_warnings() {
    let mut glb = masked(&fixture("etc1s.ktx2")[..40]);
    glb.json["materials"][0]["alphaMode"] = json!("OPAQUE");
    let scene = in_colour(&glb).expect("loads");
    assert!(scene.textures.is_empty());
    assert!(scene.notes.warnings.iter().any(|w| w.contains("KTX2")), "{:?}", scene.notes.warnings);
}
