//! glTF geometry compressed with Draco (KHR_draco_mesh_compression), compared with the same scene
//! uncompressed. Google's encoder made the files in `fixtures/draco`; `make.mjs` beside them shows how.

#[cfg(feature = "draco")]
#[path = "draco/encoder.rs"]
mod encoder;
#[path = "draco/fixture.rs"]
mod fixture;
#[cfg(feature = "draco")]
#[path = "draco/loading.rs"]
mod loading;
#[cfg(feature = "draco")]
#[path = "draco/mutations.rs"]
mod mutations;

use adumbra_scene::{Error, LoadOptions};
use fixture::Fixture;
use serde_json::json;

#[test]
fn draco_fallback_is_read_with_and_without_the_feature() {
    let plain = Fixture::read("plain");
    let mut both = plain.clone();
    let stream = both.add_view(b"this is no Draco data");
    both.json["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    for mesh in both.json["meshes"].as_array_mut().expect("meshes") {
        for primitive in mesh["primitives"].as_array_mut().expect("primitives") {
            let extension = json!({"bufferView": stream, "attributes": {"POSITION": 0}});
            primitive["extensions"] = json!({"KHR_draco_mesh_compression": extension});
        }
    }
    let (plain, both) = (plain.load().expect("loads"), both.load().expect("loads"));
    assert!(fixture::triangles(&plain) == fixture::triangles(&both));
}

#[test]
fn draco_without_fallback_names_the_missing_feature() {
    let mut fixture = Fixture::read("edgebreaker-lossless");
    for is_required in [true, false] {
        if !is_required {
            fixture.json["extensionsRequired"] = json!([]);
        }
        let loaded = fixture.load_with(&LoadOptions::default());
        if cfg!(feature = "draco") {
            loaded.expect("loads");
            continue;
        }
        let error = loaded.expect_err("cannot be decoded");
        assert!(matches!(error, Error::MissingFeature { feature: "draco", .. }), "{error}");
        let message = error.to_string();
        assert!(message.contains("KHR_draco_mesh_compression") && message.contains("scene.glb"), "{message}");
    }
}
