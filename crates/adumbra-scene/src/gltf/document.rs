//! The JSON of a glTF 2.0 file (Khronos, ISO/IEC 12113), read one element at a time, so that a fault in what a bake does
//! not need refuses no file.
//!
//! Departures from the definition, each seen in files that other programs load: whole numbers may be written `4.0`, a
//! name may be anything, and a scene may lack its list of nodes. An element that cannot be read otherwise is replaced by
//! an empty one, and is an error only where it is used. Cameras, generators and extras of the whole file are not read.

use std::collections::BTreeMap;
use std::path::Path;

use ::gltf::json::{Index, Root};
use serde::de::{DeserializeOwned, IgnoredAny};
use serde_json::Value;
use serde_json::value::RawValue;

use crate::budget::Budget;
use crate::error::{Error, Result};
use crate::gltf::container::bad;
use crate::gltf::nodes::Place;

/// A parsed file.
pub(super) struct Document {
    pub(super) root: Root,
    /// The transforms of all nodes, in double precision.
    pub(super) places: Vec<Place>,
    /// For each light of `KHR_lights_punctual`, whether it is directional.
    pub(super) lights: Vec<bool>,
    /// Number of morph targets with more than positions, normals and tangents.
    pub(super) other_targets: u64,
    /// The elements that cannot be read.
    pub(super) faults: Faults,
    /// Messages for the user.
    pub(super) warnings: Vec<String>,
}

/// The elements of a file that cannot be read.
#[derive(Default)]
pub(super) struct Faults {
    of: BTreeMap<(&'static str, usize), String>,
}

impl Faults {
    /// An error if this element cannot be read. `kind` is the singular, such as "accessor".
    pub(super) fn check(&self, path: &Path, kind: &'static str, index: usize) -> Result<()> {
        match self.of.get(&(kind, index)) {
            Some(what) => Err(bad(path, format!("{kind} {index} cannot be read: {what}"))),
            None => Ok(()),
        }
    }

    /// Number of elements of a kind that cannot be read.
    pub(super) fn count(&self, kind: &'static str) -> u64 {
        self.of.keys().filter(|(of, _)| *of == kind).count() as u64
    }

    /// A warning for each kind, once it is known that none of them was needed.
    pub(super) fn warnings(&self) -> impl Iterator<Item = String> {
        let mut counts: BTreeMap<&str, u64> = BTreeMap::new();
        for (kind, _) in self.of.keys() {
            *counts.entry(kind).or_default() += 1;
        }
        counts.into_iter().map(|(kind, count)| {
            format!("elements that cannot be read, and that nothing needs: {count} of kind {kind}")
        })
    }
}

/// The members of the file's object, as texts. Of two members with one name the last counts.
type Members<'a> = BTreeMap<String, &'a RawValue>;

/// Memory that an element takes while its faults are looked for, per byte of its text.
const SOFTENING_BYTES: u64 = 96;

impl Document {
    /// Parses the JSON of a file.
    ///
    /// # Errors
    /// Returns [`Error::GltfVersion`] for other versions than 2.0, [`Error::SceneParse`] if it is no JSON or a list is
    /// something else, and [`Error::SceneMemory`].
    pub(super) fn parse(path: &Path, json: &[u8], budget: &Budget<'_>) -> Result<Self> {
        let members: Members<'_> =
            serde_json::from_slice(json).map_err(|e| bad(path, format!("its JSON is broken: {e}")))?;
        let mut warnings = Vec::new();
        check_version(path, &members, &mut warnings)?;
        let mut lists = Lists { path, budget, members: &members, faults: Faults::default() };
        let mut root = Root {
            accessors: lists.read(
                "accessors",
                "accessor",
                r#"{"componentType":5126,"count":0,"type":"SCALAR"}"#,
            )?,
            animations: lists.read("animations", "animation", r#"{"channels":[],"samplers":[]}"#)?,
            buffers: lists.read("buffers", "buffer", r#"{"byteLength":0}"#)?,
            buffer_views: lists.read("bufferViews", "buffer view", r#"{"buffer":0,"byteLength":0}"#)?,
            images: lists.read("images", "image", "{}")?,
            materials: lists.read("materials", "material", "{}")?,
            meshes: lists.read("meshes", "mesh", r#"{"primitives":[]}"#)?,
            nodes: lists.read("nodes", "node", "{}")?,
            samplers: lists.read("samplers", "sampler", "{}")?,
            scenes: lists.read("scenes", "scene", r#"{"nodes":[]}"#)?,
            skins: lists.read("skins", "skin", r#"{"joints":[]}"#)?,
            textures: lists.read("textures", "texture", "{}")?,
            ..Root::default()
        };
        let places = lists.read("nodes", "node", "{}")?;
        let targets: Vec<Targets> = lists.read("meshes", "mesh", "{}")?;
        let other_targets = targets.iter().map(Targets::others).sum();
        let faults = lists.faults;
        root.extensions_used = names(&members, "extensionsUsed");
        root.extensions_required = names(&members, "extensionsRequired");
        if let Some(scene) = members.get("scene").filter(|raw| raw.get() != "null") {
            let number = serde_json::from_str::<f64>(scene.get()).ok().filter(|n| n.fract() == 0.0);
            let number = number.filter(|n| (0.0..f64::from(u32::MAX)).contains(n));
            let number = number.ok_or_else(|| bad(path, "its default scene is not the number of a scene"))?;
            root.scene = Some(Index::new(number as u32));
        }
        Ok(Self { root, places, lights: lights(&members), other_targets, faults, warnings })
    }
}

/// What morph targets of a mesh change besides its geometry.
#[derive(serde::Deserialize)]
struct Targets {
    #[serde(default)]
    primitives: Vec<TargetsOfPrimitive>,
}

#[derive(serde::Deserialize)]
struct TargetsOfPrimitive {
    #[serde(default)]
    targets: Vec<Target>,
}

#[derive(serde::Deserialize)]
struct Target {
    #[serde(rename = "TEXCOORD_0")]
    texture_coordinates: Option<IgnoredAny>,
    #[serde(rename = "COLOR_0")]
    colors: Option<IgnoredAny>,
}

impl Targets {
    fn others(&self) -> u64 {
        let targets = self.primitives.iter().flat_map(|p| &p.targets);
        targets.filter(|t| t.texture_coordinates.is_some() || t.colors.is_some()).count() as u64
    }
}

/// Reads the lists of the file.
struct Lists<'a> {
    path: &'a Path,
    budget: &'a Budget<'a>,
    members: &'a Members<'a>,
    faults: Faults,
}

impl Lists<'_> {
    /// Reads a list, with `empty` in place of the elements that cannot be read.
    fn read<T: DeserializeOwned>(&mut self, list: &str, kind: &'static str, empty: &str) -> Result<Vec<T>> {
        let Some(raw) = self.members.get(list).filter(|raw| raw.get() != "null") else {
            return Ok(Vec::new());
        };
        let elements: Vec<&RawValue> = serde_json::from_str(raw.get())
            .map_err(|_| bad(self.path, format!("its {list} are not a list")))?;
        let mut out = Vec::with_capacity(elements.len());
        for (index, element) in elements.into_iter().enumerate() {
            let text = element.get();
            let read = match serde_json::from_str(text) {
                Ok(read) => Ok(read),
                Err(_) => {
                    let bytes = SOFTENING_BYTES * text.len() as u64;
                    self.budget.charge(bytes, || format!("{kind} {index}"))?;
                    let softened = soften(text, kind);
                    self.budget.release(bytes);
                    softened
                }
            };
            match read {
                Ok(read) => out.push(read),
                Err(what) => {
                    self.faults.of.insert((kind, index), what);
                    let empty = serde_json::from_str(empty).map_err(|e| bad(self.path, e.to_string()))?;
                    out.push(empty);
                }
            }
        }
        Ok(out)
    }
}

/// Reads an element that is not written as the definition asks, without what does not matter. The error is a clause.
fn soften<T: DeserializeOwned>(text: &str, kind: &str) -> Result<T, String> {
    let clause = |e: serde_json::Error| {
        let text = e.to_string();
        text.rsplit_once(" at line ").map_or(text.clone(), |(what, _)| what.to_owned())
    };
    let mut value: Value = serde_json::from_str(text).map_err(clause)?;
    make_whole(&mut value);
    if let Value::Object(members) = &mut value {
        members.retain(|key, value| key != "name" || value.is_string());
        if kind == "scene" && !members.contains_key("nodes") {
            members.insert("nodes".to_owned(), Value::Array(Vec::new()));
        }
    }
    // Through text, because the types of extras can only be read from text.
    serde_json::from_str(&value.to_string()).map_err(clause)
}

/// Turns `4.0` into `4`, everywhere.
fn make_whole(value: &mut Value) {
    const EXACT: f64 = (1_u64 << 53) as f64;
    match value {
        Value::Number(number) => {
            if let Some(float) =
                number.as_f64().filter(|f| number.is_f64() && f.fract() == 0.0 && f.abs() < EXACT)
            {
                *number = (float as i64).into();
            }
        }
        Value::Array(list) => list.iter_mut().for_each(make_whole),
        Value::Object(members) => members.values_mut().for_each(make_whole),
        _ => {}
    }
}

/// The strings of a list; anything else in it is passed over.
fn names(members: &Members<'_>, list: &str) -> Vec<String> {
    let elements: Vec<&RawValue> =
        members.get(list).and_then(|raw| serde_json::from_str(raw.get()).ok()).unwrap_or_default();
    elements.into_iter().filter_map(|raw| serde_json::from_str(raw.get()).ok()).collect()
}

/// For each light, whether it is directional.
fn lights(members: &Members<'_>) -> Vec<bool> {
    #[derive(serde::Deserialize)]
    struct Extensions<'a> {
        #[serde(borrow, rename = "KHR_lights_punctual")]
        punctual: Option<Punctual<'a>>,
    }
    #[derive(serde::Deserialize)]
    struct Punctual<'a> {
        #[serde(borrow, default)]
        lights: Vec<&'a RawValue>,
    }
    #[derive(serde::Deserialize)]
    struct Light {
        r#type: String,
    }
    let parsed =
        members.get("extensions").and_then(|raw| serde_json::from_str::<Extensions<'_>>(raw.get()).ok());
    let lights = parsed.and_then(|e| e.punctual).map_or_else(Vec::new, |p| p.lights);
    let is_directional = |raw: &RawValue| {
        serde_json::from_str::<Light>(raw.get()).is_ok_and(|light| light.r#type == "directional")
    };
    lights.into_iter().map(is_directional).collect()
}

/// Refuses every version but 2.0. A later 2.x is read if it does not ask for more than 2.0 (glTF 2.0, 3.2).
fn check_version(path: &Path, members: &Members<'_>, warnings: &mut Vec<String>) -> Result<()> {
    #[derive(Default, serde::Deserialize)]
    #[serde(default, rename_all = "camelCase")]
    struct Asset<'a> {
        #[serde(borrow)]
        version: Option<&'a RawValue>,
        #[serde(borrow)]
        min_version: Option<&'a RawValue>,
    }
    let wrong = |version: &str| Error::GltfVersion { path: path.to_owned(), version: version.to_owned() };
    // The lists of glTF 1.0 are dictionaries.
    let lists = ["accessors", "bufferViews", "buffers", "meshes", "nodes", "scenes"];
    if lists.iter().any(|list| members.get(*list).is_some_and(|raw| raw.get().starts_with('{'))) {
        return Err(wrong("1.0"));
    }
    let asset: Asset<'_> =
        members.get("asset").and_then(|raw| serde_json::from_str(raw.get()).ok()).unwrap_or_default();
    let number = |raw: &RawValue| -> Option<(u32, u32)> {
        let text = raw.get().trim_matches('"').trim();
        let (major, minor) = text.split_once('.').unwrap_or((text, "0"));
        Some((major.parse().ok()?, minor.parse().ok()?))
    };
    let stated = asset.version.and_then(number);
    match (stated, asset.min_version.and_then(number)) {
        (_, Some(least)) if least > (2, 0) => Err(wrong(&format!("{}.{}", least.0, least.1))),
        (Some(version), _) if version.0 != 2 => Err(wrong(&format!("{}.{}", version.0, version.1))),
        (Some(_), _) => Ok(()),
        (None, _) => {
            warnings.push("it does not say which version of glTF it is; read as 2.0".to_owned());
            Ok(())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_may_have_a_point() {
        let mut value: Value = serde_json::from_str(r#"{"a": [4.0, 1e2, -3.0, 0.5, 1e300]}"#).expect("JSON");
        make_whole(&mut value);
        assert_eq!(value.to_string(), r#"{"a":[4,100,-3,0.5,1e+300]}"#);
    }

    #[test]
    fn faults_are_errors_only_where_they_are_used() {
        let path = Path::new("a.gltf");
        let json = br#"{"asset": {"version": "2.0"}, "cameras": 5, "accessors": [{"count": "x"}], "meshes": [{}, {}]}"#;
        let document = Document::parse(path, json, &Budget::new(path, None)).expect("is read");
        assert_eq!((document.root.accessors.len(), document.root.meshes.len()), (1, 2));
        let message = document.faults.check(path, "accessor", 0).expect_err("has no type").to_string();
        assert!(message.contains("accessor 0 cannot be read: ") && !message.contains("line 1"), "{message}");
        document.faults.check(path, "accessor", 1).expect("is no fault");
        assert_eq!(document.faults.count("mesh"), 2);
        assert_eq!(document.faults.warnings().count(), 2);
    }
}
