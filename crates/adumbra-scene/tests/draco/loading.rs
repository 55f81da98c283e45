//! Which streams are decoded, and which are rejected.

use adumbra_scene::{Error, LoadOptions};
use serde_json::{Value, json};

use crate::fixture::{Fixture, assert_close, triangles};

const EXTENSION: &str = "KHR_draco_mesh_compression";

fn primitives(fixture: &mut Fixture) -> impl Iterator<Item = &mut Value> {
    let meshes = fixture.json["meshes"].as_array_mut().expect("meshes");
    meshes.iter_mut().flat_map(|m| m["primitives"].as_array_mut().expect("primitives"))
}

/// The error of a broken file. Checks that it names the mesh and the primitive.
fn refused(fixture: &Fixture) -> String {
    let error = fixture.load().expect_err("is broken");
    assert!(matches!(error, Error::SceneParse { .. }), "{error}");
    let message = error.to_string();
    assert!(message.contains("primitive 0 of mesh \"torus\""), "{message}");
    message
}

#[test]
fn draco_lossless_triangles_equal_the_plain_ones() {
    let plain = triangles(&Fixture::read("plain").load().expect("loads"));
    assert_eq!(plain.len(), 60 + 60 + 7);
    for name in ["edgebreaker-lossless", "sequential-lossless"] {
        let scene = Fixture::read(name).load().expect(name);
        assert!(scene.notes.omissions.is_empty() && scene.notes.degenerate_triangles == 0, "{name}");
        assert!(triangles(&scene) == plain, "{name}");
    }
}

#[test]
fn draco_quantised_triangles_are_within_half_a_step() {
    let plain = Fixture::read("plain").load().expect("loads");
    // Positions have 12 bits for the 8 units of the longest side. The joint weights of the torus have 8 bits,
    // and its joints are one unit apart.
    let (step, weight, uv_step) = (8.0 / 4095.0 / 2.0, 1.0 / 255.0, 1.0 / 1023.0 / 2.0);
    for name in ["edgebreaker-quantized", "edgebreaker-quantized-slow", "sequential-quantized"] {
        let scene = Fixture::read(name).load().expect(name);
        assert_close(&plain, &scene, (step + weight) * 1.01, uv_step * 1.01);
        assert_ne!(triangles(&plain), triangles(&scene), "{name}");
    }
}

#[test]
fn draco_used_but_not_required_is_decoded() {
    let mut fixture = Fixture::read("edgebreaker-lossless");
    let required = triangles(&fixture.load().expect("loads"));
    fixture.json.as_object_mut().expect("an object").remove("extensionsRequired");
    let scene = fixture.load().expect("loads");
    assert!(triangles(&scene) == required);
    assert_eq!(scene.notes.degenerate_triangles, 0);
}

#[test]
fn draco_required_is_decoded_even_if_accessors_have_data() {
    let mut fixture = Fixture::read("edgebreaker-lossless");
    let plain = triangles(&fixture.load().expect("loads"));
    let zeros = fixture.add_view(&[0; 4096]);
    for accessor in fixture.json["accessors"].as_array_mut().expect("accessors") {
        accessor["bufferView"] = json!(zeros);
    }
    assert!(triangles(&fixture.load().expect("loads")) == plain);
}

#[test]
fn draco_streams_may_be_shared_by_primitives() {
    let mut fixture = Fixture::read("sequential-lossless");
    let once = fixture.load().expect("loads");
    let torus = fixture.json["meshes"][0]["primitives"][0].clone();
    fixture.json["meshes"][0]["primitives"] = json!([torus, torus]);
    let twice = fixture.load().expect("loads");
    assert_eq!(twice.meshes[0].triangles.len(), 2 * once.meshes[0].triangles.len());
    assert_eq!(twice.meshes[0].positions.len(), once.meshes[0].positions.len(), "vertices are shared");
}

#[test]
fn draco_strips_hold_the_same_triangles() {
    for name in ["edgebreaker-lossless", "sequential-quantized"] {
        let mut fixture = Fixture::read(name);
        let list = triangles(&fixture.load().expect("loads"));
        primitives(&mut fixture).for_each(|p| p["mode"] = json!(5));
        assert!(triangles(&fixture.load().expect("loads")) == list, "{name}");
    }
}

#[test]
fn draco_attributes_outside_the_stream_are_read_from_their_accessors() {
    // In a sequential stream, the points are in the same order as in the plain file.
    let (mut fixture, plain) = (Fixture::read("sequential-lossless"), Fixture::read("plain"));
    let expected = triangles(&plain.load().expect("loads"));
    let color = |f: &Fixture| f.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"].as_u64();
    let [from, to] = [&plain, &fixture].map(|f| color(f).expect("an accessor") as usize);
    let accessor = plain.json["accessors"][from].clone();
    let mut view =
        plain.json["bufferViews"][accessor["bufferView"].as_u64().expect("a view") as usize].clone();
    let place = fixture.add_view(&plain.bin);
    view["byteOffset"] = json!(
        view["byteOffset"].as_u64().unwrap_or(0)
            + fixture.json["bufferViews"][place]["byteOffset"].as_u64().expect("a number")
    );
    fixture.json["bufferViews"][place] = view;
    fixture.json["accessors"][to] = accessor;
    fixture.json["accessors"][to]["bufferView"] = json!(place);
    let torus = primitives(&mut fixture).next().expect("a primitive");
    let ids = torus["extensions"][EXTENSION]["attributes"].as_object_mut().expect("attributes");
    ids.remove("COLOR_0").expect("was in the stream");
    assert!(triangles(&fixture.load().expect("loads")) == expected);
}

#[test]
fn draco_accepts_point_counts_of_the_mesh_before_seam_cuts() {
    // The accessors state fewer points than the stream has, like those of a mesh before it was cut along its
    // seams.
    for name in ["edgebreaker-lossless", "sequential-lossless"] {
        let mut fixture = Fixture::read(name);
        let stated = triangles(&fixture.load().expect("loads"));
        for accessor in fixture.json["accessors"].as_array_mut().expect("accessors") {
            if accessor["type"] != "SCALAR" {
                accessor["count"] = json!(11);
            }
        }
        assert!(triangles(&fixture.load().expect("loads")) == stated, "{name}");
    }
}

#[test]
fn draco_contradictions_are_errors_naming_mesh_and_primitive() {
    for name in ["edgebreaker-lossless", "sequential-lossless"] {
        let whole = Fixture::read(name);
        let mut fixture = whole.clone();
        fixture.json["accessors"][0]["count"] = json!(3);
        assert!(refused(&fixture).contains("60 triangles, but its accessors state 1"));

        let mut fixture = whole.clone();
        let first = |f: &mut Fixture, value| {
            let torus = primitives(f).next().expect("a primitive");
            torus["extensions"][EXTENSION]["attributes"]["POSITION"] = value;
        };
        first(&mut fixture, json!(77));
        assert!(refused(&fixture).contains("lacks its attribute POSITION"));

        let mut fixture = whole.clone();
        primitives(&mut fixture).next().expect("a primitive")["extensions"][EXTENSION] = json!({});
        assert!(refused(&fixture).contains("has no buffer view"));

        let mut fixture = whole.clone();
        fixture.json["bufferViews"][1]["byteLength"] = json!(9);
        assert!(refused(&fixture).contains("cut off within its header"));

        let mut fixture = whole.clone();
        fixture.json["bufferViews"][1]["byteLength"] = json!(300);
        assert!(refused(&fixture).contains("is damaged"));

        let mut fixture = whole.clone();
        fixture.json["accessors"][1]["sparse"] = json!({
            "count": 1, "indices": {"bufferView": 0, "componentType": 5123}, "values": {"bufferView": 0}
        });
        assert!(refused(&fixture).contains("sparse"));

        // Two components where the accessor says three.
        let mut fixture = whole.clone();
        fixture.json["accessors"][1]["type"] = json!("VEC2");
        let error = fixture.load().expect_err("is broken").to_string();
        assert!(error.contains("as many components as its Draco data"), "{error}");
    }
}

#[test]
fn draco_integer_normals_are_an_error_with_advice() {
    let error = Fixture::read("integer-normals").load().expect_err("are refused").to_string();
    assert!(error.contains("primitive 0 of mesh \"leaf\"") && error.contains("normals as floats"), "{error}");
}

#[test]
fn draco_memory_is_counted_before_it_is_allocated() {
    let fixture = Fixture::read("edgebreaker-quantized");
    let within = |max| LoadOptions { max_memory_bytes: Some(max), ..LoadOptions::default() };
    fixture.load_with(&within(16 << 20)).expect("fits");
    let error = fixture.load_with(&within(4 << 20)).expect_err("the decoder's tables do not fit");
    assert!(matches!(error, Error::SceneMemory { .. }), "{error}");
    assert!(error.to_string().contains("the Draco data of primitive 0 of mesh \"torus\""), "{error}");
}
