//! Writes the name of a shadow file into a glTF file, where engines look for it.
//!
//! A directional light of `KHR_lights_punctual` gets `extras: {"adumbra": {"shadow": "city.adumbra"}}`. The
//! path is relative to the glTF file. Extras survive most tools, and loaders pass them on. Unchanged parts of
//! the JSON keep the exact text of their numbers, and the binary chunk keeps its bytes.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

use adumbra::{IoError, Sun};
use adumbra_files::replace_file;
use serde_json::value::{RawValue, to_raw_value};
use serde_json::{Value, json};

use super::casting::Casting;
use super::container::split;
use super::document::GltfDocument;
use super::faults::bad;
use super::nodes::Nodes;
use crate::affine::compose;
use crate::budget::Budget;
use crate::error::Result;
use crate::glb::container;

const LIGHTS: &str = "KHR_lights_punctual";

/// Writes the name of a shadow file into the `.glb` or `.gltf` at `path`. The name goes into the extras of
/// the file's first directional light that shines, that is, the light of the first of
/// [`Scene::suns`](crate::Scene::suns). If there is no such light, a new light towards `sun` gets the name.
/// `name` is the file's path relative to the folder of `path`, with `/` between its parts.
///
/// # Errors
/// Returns [`Error::Io`](crate::Error::Io), or the error with which [`load`](crate::load) rejects such JSON.
/// The file is then unchanged.
pub fn write_shadow_name(path: &Path, name: &str, sun: Sun) -> Result<()> {
    let bytes = std::fs::read(path).map_err(IoError::at("read", path))?;
    let bytes = with_shadow_name(path, &bytes, name, sun)?;
    replace_file(path, |file| file.write_all(&bytes).map(|()| bytes.len() as u64))?;
    Ok(())
}

/// The members of a JSON object, as raw text.
type JsonMembers = BTreeMap<String, Box<RawValue>>;

/// Returns a glTF file's bytes after writing the name of a shadow file into them.
fn with_shadow_name(path: &Path, bytes: &[u8], name: &str, sun: Sun) -> Result<Vec<u8>> {
    let parts = split(path, bytes)?;
    let budget = Budget::new(path, None);
    let GltfDocument { root: document, transforms, lights: kinds, faults, .. } =
        GltfDocument::parse(path, parts.json, &budget)?;
    let nodes = Nodes::load(path, &document, transforms, &kinds, &faults, &mut Casting::default())?;
    let fault = |e: serde_json::Error| bad(path, e.to_string());
    let mut root: JsonMembers = serde_json::from_slice(parts.json).map_err(fault)?;
    let mut extensions: Value = read(&root, "extensions").map_err(fault)?.unwrap_or_else(|| json!({}));
    let no_object = |what: &str| bad(path, format!("{what} is no JSON object"));
    let of_lights = member(&mut extensions, LIGHTS).ok_or_else(|| no_object("extensions"))?;
    let lights = member(of_lights, "lights").ok_or_else(|| no_object(LIGHTS))?;
    if lights.is_null() {
        *lights = json!([]);
    }
    let Value::Array(lights) = lights else {
        return Err(bad(path, format!("{LIGHTS} has no list of lights")));
    };
    // Prefer a sun that a node of the scene has.
    let existing = nodes.first_sun(&document).or_else(|| kinds.iter().position(|&is_sun| is_sun));
    if let Some(light) = existing.and_then(|index| lights.get_mut(index)) {
        let extras = member(light, "extras").and_then(|extras| member(extras, "adumbra"));
        let shadow = extras.and_then(|adumbra| member(adumbra, "shadow"));
        *shadow.ok_or_else(|| no_object("the extras of the directional light"))? = name.into();
    } else {
        lights.push(json!({
            "type": "directional", "name": "sun", "intensity": 10_000.0,
            "extras": {"adumbra": {"shadow": name}},
        }));
        let index = lights.len() - 1;
        let scene = document.scene.map_or(0, |scene| scene.value());
        add_light(path, &mut root, index, scene, sun)?;
    }
    root.insert("extensions".to_owned(), to_raw_value(&extensions).map_err(fault)?);
    let text = serde_json::to_vec(&root).map_err(fault)?;
    let is_binary = bytes.starts_with(b"glTF");
    Ok(if is_binary { container(text, parts.bin.unwrap_or_default().to_vec(), &parts.others) } else { text })
}

/// Adds a node with light `index` to the scene, and lists the extension as used. In a file without scenes
/// every node is drawn, so the node is not added to a scene.
fn add_light(path: &Path, root: &mut JsonMembers, index: usize, scene: usize, sun: Sun) -> Result<()> {
    let fault = |e: serde_json::Error| bad(path, e.to_string());
    // Keep nodes and scenes as raw text, so that their numbers do not change.
    let mut nodes: Vec<Box<RawValue>> = read(root, "nodes").map_err(fault)?.unwrap_or_default();
    let mut scenes: Vec<JsonMembers> = read(root, "scenes").map_err(fault)?.unwrap_or_default();
    let mut used: Vec<Value> = read(root, "extensionsUsed").map_err(fault)?.unwrap_or_default();
    let node = json!({
        "name": "sun", "matrix": placement(sun), "extensions": {LIGHTS: {"light": index}},
    });
    if !scenes.is_empty() {
        let count = scenes.len();
        let Some(of_scene) = scenes.get_mut(scene) else {
            return Err(bad(path, format!("its default scene is {scene}, but it has {count}")));
        };
        let mut roots: Vec<Box<RawValue>> = read(of_scene, "nodes").map_err(fault)?.unwrap_or_default();
        roots.push(to_raw_value(&nodes.len()).map_err(fault)?);
        of_scene.insert("nodes".to_owned(), to_raw_value(&roots).map_err(fault)?);
        root.insert("scenes".to_owned(), to_raw_value(&scenes).map_err(fault)?);
    }
    nodes.push(to_raw_value(&node).map_err(fault)?);
    if !used.iter().any(|name| name == LIGHTS) {
        used.push(LIGHTS.into());
    }
    root.insert("nodes".to_owned(), to_raw_value(&nodes).map_err(fault)?);
    root.insert("extensionsUsed".to_owned(), to_raw_value(&used).map_err(fault)?);
    Ok(())
}

/// Returns a member of an object, or `null` if the object lacks it. Returns `None` if `value` is neither an
/// object nor `null`.
fn member<'v>(value: &'v mut Value, name: &str) -> Option<&'v mut Value> {
    if value.is_null() {
        *value = json!({});
    }
    Some(value.as_object_mut()?.entry(name).or_insert(Value::Null))
}

fn read<T: serde::de::DeserializeOwned>(parts: &JsonMembers, name: &str) -> serde_json::Result<Option<T>> {
    parts
        .get(name)
        .filter(|text| text.get() != "null")
        .map(|text| serde_json::from_str(text.get()))
        .transpose()
}

/// Returns the column-major matrix of a light's node. A light shines along its -Z, which the matrix turns
/// away from the sun. The scale, from 1 to the square root of 3, does not affect lights.
///
/// A bake finds cache entries of earlier bakes by the bits of the sun. The Z axis is therefore chosen such
/// that a loader computes exactly the same sun from it. No quaternion can guarantee that.
fn placement(sun: Sun) -> [f64; 16] {
    let axis = axis_towards(sun);
    let length = axis.iter().map(|c| c * c).sum::<f64>().sqrt();
    let [x, y, z] = sun.towards();
    // The shortest rotation from +Z towards the sun. If the sun is opposite +Z, any half turn about a
    // perpendicular axis works.
    let w = 1.0 + z;
    let rotation = if w < 1e-9 { [0.0, 1.0, 0.0, 0.0] } else { [-y, x, 0.0, w] };
    let map = compose([0.0; 3], rotation, [length; 3]);
    std::array::from_fn(|i| match (i / 4, i % 4) {
        (_, 3) => f64::from(u8::from(i == 15)),
        (2, row) => axis[row],
        (3, _) => 0.0,
        (column, row) => map[row][column],
    })
}

/// Returns the vector, with a largest component of 1 or -1, from which [`Sun::from_direction`] computes
/// exactly this sun. The sun's components were divided by a length, so the vector's components are within two
/// units in the last place of their quotients.
fn axis_towards(sun: Sun) -> [f64; 3] {
    let towards = sun.towards();
    let largest = towards.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
    let axis = towards.map(|c| c / largest);
    let near = |c: f64| {
        let all = [c, c.next_up(), c.next_down(), c.next_up().next_up(), c.next_down().next_down()];
        all.into_iter().take(if c == 0.0 { 1 } else { all.len() }).filter(|c| c.abs() <= 1.0)
    };
    let all = near(axis[0])
        .flat_map(|x| near(axis[1]).flat_map(move |y| near(axis[2]).map(move |z| [x, y, z])))
        .filter(|axis| axis.iter().any(|c| c.abs() == 1.0));
    let found = all.into_iter().find(|&axis| Sun::from_direction(axis).is_ok_and(|found| found == sun));
    found.unwrap_or(axis)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MINIMAL: &str = r#"{"asset":{"version":"2.0"},"nodes":[{"matrix":[1.10000000000000000001,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}],"scene":0,"scenes":[{"nodes":[0]}]}"#;

    fn named(text: &str) -> Value {
        let sun = Sun::from_direction([0.5, 0.8, 0.35]).expect("above the horizon");
        let bytes = with_shadow_name(Path::new("a.gltf"), text.as_bytes(), "city.adumbra", sun);
        let bytes = bytes.expect("a glTF file");
        assert!(!text.contains("1.10") || String::from_utf8_lossy(&bytes).contains("1.10000000000000000001"));
        serde_json::from_slice(&bytes).expect("JSON")
    }

    #[test]
    fn scene_without_a_light_gets_one_towards_the_sun() {
        let json = named(MINIMAL);
        assert_eq!(json["extensionsUsed"], json!([LIGHTS]));
        assert_eq!(json["scenes"][0]["nodes"], json!([0, 1]));
        let light = &json["extensions"][LIGHTS]["lights"][0];
        assert_eq!(light["extras"]["adumbra"]["shadow"], "city.adumbra");
        // The axes are perpendicular and of equal length, and +Z points towards the sun.
        let matrix: Vec<f64> =
            serde_json::from_value(json["nodes"][1]["matrix"].clone()).expect("16 numbers");
        let axis = |c: usize| [0, 1, 2].map(|row| matrix[4 * c + row]);
        let dot = |a: usize, b: usize| (0..3).map(|i| axis(a)[i] * axis(b)[i]).sum::<f64>();
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            assert!(dot(a, b).abs() < 1e-12 && (dot(a, a) - dot(b, b)).abs() < 1e-12, "{matrix:?}");
        }
        let sun = Sun::from_direction([0.5, 0.8, 0.35]).expect("above the horizon");
        assert_eq!(Sun::from_direction(axis(2)).expect("above the horizon"), sun);
        // Writing the name again does not add another light.
        assert_eq!(named(&json.to_string()), json);
    }

    /// A bake finds the cache entries of an earlier bake only if the sun has the same bits.
    #[test]
    fn written_light_loads_as_exactly_the_same_sun() {
        let mut random = crate::random::Random::new(3, 0);
        for number in 0..200 {
            let mut towards = [0; 3].map(|_| 2.0 * random.unit() - 1.0);
            towards[1] = [towards[1].abs(), 1e-3, 1e3][number % 3] + 1e-9;
            towards[number % 2 * 2] *= [1.0, 1e-6, 0.0, 1.0][number % 4];
            let sun = Sun::from_direction(towards).expect("above the horizon");
            let bytes =
                with_shadow_name(Path::new("a.gltf"), MINIMAL.as_bytes(), "a", sun).expect("a glTF file");
            let json: Value = serde_json::from_slice(&bytes).expect("JSON");
            let light = json["nodes"].as_array().and_then(|nodes| nodes.last()).expect("a node");
            let matrix: [f64; 16] = serde_json::from_value(light["matrix"].clone()).expect("16 numbers");
            let axis = crate::affine::from_columns(&matrix).map(|row| row[2]);
            assert_eq!(Sun::from_direction(axis).expect("above the horizon"), sun, "{towards:?}");
        }
    }

    #[test]
    fn first_directional_light_gets_name_and_keeps_its_extras() {
        let lights = r#"[{"type":"point"},{"type":"directional","color":[1,0,0],"extras":{"mine":7}}]"#;
        let extensions = format!(r#","extensions":{{"{LIGHTS}":{{"lights":{lights}}},"OTHER":{{"a":1}}}}}}"#);
        let json = named(&MINIMAL.replace(
            "\"scenes\":[{\"nodes\":[0]}]}",
            &format!("\"scenes\":[{{\"nodes\":[0]}}]{extensions}"),
        ));
        let light = &json["extensions"][LIGHTS]["lights"][1];
        assert_eq!(light["extras"], json!({"mine": 7, "adumbra": {"shadow": "city.adumbra"}}));
        assert_eq!((&light["color"], &json["extensions"]["OTHER"]["a"]), (&json!([1, 0, 0]), &json!(1)));
        assert_eq!(json["nodes"].as_array().map(Vec::len), Some(1));
    }

    #[test]
    fn name_goes_to_the_light_of_the_first_sun() {
        let lights = r#"[{"type":"directional"},{"type":"directional"}]"#;
        let json = format!(
            r#"{{"asset":{{"version":"2.0"}},"scene":0.0,"scenes":[{{"nodes":[0]}}],
            "nodes":[{{"extensions":{{"{LIGHTS}":{{"light":1}}}}}},{{"extensions":{{"{LIGHTS}":{{"light":0}}}}}}],
            "extensions":{{"{LIGHTS}":{{"lights":{lights}}}}}}}"#
        );
        let lights = &named(&json)["extensions"][LIGHTS]["lights"];
        assert_eq!(lights[1]["extras"]["adumbra"]["shadow"], "city.adumbra");
        assert!(lights[0].get("extras").is_none());
    }

    #[test]
    fn dark_light_gets_no_name() {
        for (lights, named_light) in [
            (r#"[{"type":"directional","intensity":0}]"#, 1),
            (r#"[{"type":"directional","color":[0,0,0]},{"type":"directional"}]"#, 1),
            (r#"[{"type":"directional"},{"type":"directional"}]"#, 0),
        ] {
            let json = format!(
                r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
                "nodes":[{{"extensions":{{"{LIGHTS}":{{"light":0}}}}}}],
                "extensions":{{"{LIGHTS}":{{"lights":{lights}}}}}}}"#
            );
            let lights = &named(&json)["extensions"][LIGHTS]["lights"];
            for (index, light) in lights.as_array().expect("a list").iter().enumerate() {
                assert_eq!(light.get("extras").is_some(), index == named_light, "{lights}");
            }
        }
    }

    #[test]
    fn file_without_scenes_gets_no_scene() {
        let json = named(r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{"primitives":[]}]}"#);
        assert!(json.get("scenes").is_none());
        assert_eq!(json["nodes"].as_array().map(Vec::len), Some(2));
    }

    #[test]
    fn glb_keeps_its_binary_and_unknown_chunks() {
        let glb = container(MINIMAL.as_bytes().to_vec(), vec![7; 12], &[b"\x04\0\0\0ABCDabcd"]);
        let sun = Sun::from_direction([0.0, 1.0, 0.0]).expect("above the horizon");
        let bytes = with_shadow_name(Path::new("a.glb"), &glb, "a.adumbra", sun).expect("a glTF file");
        let parts = split(Path::new("a.glb"), &bytes).expect("a container");
        assert!(String::from_utf8_lossy(parts.json).contains("a.adumbra"));
        assert_eq!(parts.bin, Some(&[7; 12][..]));
        assert_eq!(parts.others, [b"\x04\0\0\0ABCDabcd"]);
        let refused = [
            "glTF".to_owned(),
            MINIMAL.replace("\"scene\":0", "\"scene\":4"),
            MINIMAL.replace("\"asset\"", "\"extensions\":5,\"asset\""),
            MINIMAL
                .replace("\"asset\"", &format!("\"extensions\":{{\"{LIGHTS}\":{{\"lights\":3}}}},\"asset\"")),
        ];
        for text in refused {
            assert!(with_shadow_name(Path::new("a.gltf"), text.as_bytes(), "a", sun).is_err(), "{text}");
        }
    }
}
