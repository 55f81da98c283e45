//! The JSON of a glTF 2.0 file (Khronos, ISO/IEC 12113). It is read one element at a time, so that a file is
//! not rejected for a faulty element that the bake does not need.
//!
//! Departures from the specification, each seen in files that other programs load: whole numbers may be
//! written `4.0`, a name may be anything, and a scene may lack its list of nodes. An element that cannot be
//! read even so is replaced by an empty one, and is an error only where it is used. Cameras, generators and
//! extras of the whole file are not read.

use std::collections::BTreeMap;
use std::path::Path;

use ::gltf::json::{Camera, Index, Root};
use serde::de::{DeserializeOwned, IgnoredAny};
use serde_json::Value;
use serde_json::value::RawValue;

use crate::budget::Budget;
use crate::error::{Error, Result};
use crate::gltf::faults::{Faults, bad};
use crate::gltf::numbers::{make_whole, whole};
use crate::gltf::transforms::NodeTransform;

/// A parsed file.
pub(super) struct GltfDocument {
    pub(super) root: Root,
    /// The transforms of all nodes, in double precision.
    pub(super) transforms: Vec<NodeTransform>,
    /// For each light of `KHR_lights_punctual`, whether it is directional and shines.
    pub(super) lights: Vec<bool>,
    /// Number of morph targets of texture coordinates or colours.
    pub(super) other_targets: u64,
    /// Number of animation channels that move no node.
    pub(super) other_channels: u64,
    /// The elements that cannot be read.
    pub(super) faults: Faults,
    /// Messages for the user.
    pub(super) warnings: Vec<String>,
}

/// The members of the file's top-level object, as raw text. If two members have the same name, the last one
/// counts.
type Members<'a> = BTreeMap<String, &'a RawValue>;

/// Memory per object of the file's JSON once parsed, bytes: that of an empty node, which takes three bytes in
/// the file.
const OBJECT_BYTES: u64 = 512;

/// Memory per list item of the file's JSON once parsed, bytes: that of a number in an unknown extension,
/// while its list grows.
const ITEM_BYTES: u64 = 64;

/// Memory needed to read an element leniently, per byte of its text.
const SOFTENING_BYTES: u64 = 96;

/// Says in plain words where a text is not JSON.
fn broken(error: &serde_json::Error) -> String {
    let what = if error.is_eof() { "it ends too early" } else { "what stands there is not JSON" };
    format!("its JSON is broken at line {}, column {}: {what}", error.line(), error.column())
}

impl GltfDocument {
    /// Parses the JSON of a file.
    ///
    /// # Errors
    /// Returns [`Error::GltfVersion`] for versions other than 2.0, [`Error::SceneParse`] if the text is not
    /// JSON or a list is something else, and [`Error::SceneMemory`].
    pub(super) fn parse(path: &Path, json: &[u8], budget: &Budget<'_>) -> Result<Self> {
        let objects = json.iter().filter(|&&byte| byte == b'{').count() as u64;
        let items = json.iter().filter(|&&byte| byte == b',').count() as u64;
        budget.charge(objects * OBJECT_BYTES + items * ITEM_BYTES + json.len() as u64, || {
            format!("the {objects} objects of its JSON")
        })?;
        let members: Members<'_> = serde_json::from_slice(json).map_err(|e| bad(path, broken(&e)))?;
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
        let transforms = lists.read("nodes", "node", "{}")?;
        if members.get("cameras").is_some_and(|raw| raw.get().starts_with('[')) {
            // Cameras are read only for the warning about elements that cannot be read.
            let empty = r#"{"type":"perspective","perspective":{"yfov":1,"znear":1}}"#;
            lists.read::<Camera>("cameras", "camera", empty)?;
        }
        let targets: Vec<Targets> = lists.read("meshes", "mesh", "{}")?;
        let other_targets = targets.iter().map(Targets::others).sum();
        let channels: Vec<Channels> = lists.read("animations", "animation", "{}")?;
        let other_channels = channels.iter().map(Channels::others).sum();
        let faults = lists.faults;
        root.extensions_used = names(&members, "extensionsUsed");
        root.extensions_required = names(&members, "extensionsRequired");
        if let Some(scene) = members.get("scene").filter(|raw| raw.get() != "null") {
            let number = serde_json::from_str(scene.get()).ok().and_then(|value| whole(&value));
            let number = number.and_then(|number| u32::try_from(number).ok());
            let number = number.ok_or_else(|| bad(path, "its default scene is not the number of a scene"))?;
            root.scene = Some(Index::new(number));
        }
        let lights = lights(&members);
        Ok(Self { root, transforms, lights, other_targets, other_channels, faults, warnings })
    }
}

/// The attributes that a mesh's morph targets change besides its geometry.
#[derive(serde::Deserialize)]
struct Targets {
    #[serde(default)]
    primitives: Vec<TargetsOfPrimitive>,
}

#[derive(serde::Deserialize)]
struct TargetsOfPrimitive {
    targets: Option<Vec<BTreeMap<String, IgnoredAny>>>,
}

impl Targets {
    fn others(&self) -> u64 {
        let is_other = |semantic: &String| ["TEXCOORD_", "COLOR_"].iter().any(|s| semantic.starts_with(s));
        let targets = self.primitives.iter().flat_map(|p| p.targets.iter().flatten());
        targets.filter(|target| target.keys().any(is_other)).count() as u64
    }
}

/// The targets of an animation's channels.
#[derive(serde::Deserialize)]
struct Channels {
    #[serde(default)]
    channels: Vec<Channel>,
}

#[derive(serde::Deserialize)]
struct Channel {
    target: ChannelTarget,
}

#[derive(serde::Deserialize)]
struct ChannelTarget {
    node: Option<IgnoredAny>,
}

impl Channels {
    /// Number of channels without a node: an extension defines what they move (glTF 2.0, 5.5).
    fn others(&self) -> u64 {
        self.channels.iter().filter(|channel| channel.target.node.is_none()).count() as u64
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
        let each = size_of::<T>() as u64;
        let objects = elements.iter().filter(|element| element.get().starts_with('{')).count() as u64;
        let others = elements.len() as u64 - objects;
        // Objects have been charged already.
        let bytes = objects * each.saturating_sub(OBJECT_BYTES) + others * each.max(OBJECT_BYTES);
        self.budget.charge(bytes, || format!("the {} elements of its {list}", elements.len()))?;
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
                    self.faults.add(self.budget, kind, index, &what)?;
                    let empty = with_the_name_of(text, empty);
                    out.push(empty.map_err(|e| bad(self.path, e.to_string()))?);
                }
            }
        }
        Ok(out)
    }
}

/// The element `empty`, with the name of the element in `text`, for use in messages.
fn with_the_name_of<T: DeserializeOwned>(text: &str, empty: &str) -> serde_json::Result<T> {
    #[derive(serde::Deserialize)]
    struct Named {
        name: String,
    }
    let mut empty: Value = serde_json::from_str(empty)?;
    if let (Value::Object(members), Ok(Named { name })) = (&mut empty, serde_json::from_str(text)) {
        members.insert("name".to_owned(), name.into());
    }
    serde_json::from_str(&empty.to_string())
}

/// Reads an element that departs from the specification, ignoring departures that do not matter. The error is
/// a clause.
fn soften<T: DeserializeOwned>(text: &str, kind: &str) -> Result<T, String> {
    let clause = |e: serde_json::Error| {
        let text = e.to_string();
        text.rsplit_once(" at line ").map_or(text.clone(), |(what, _)| what.to_owned())
    };
    let mut value: Value = serde_json::from_str(text).map_err(clause)?;
    make_whole(&mut value);
    if let Value::Object(members) = &mut value {
        members.retain(|key, value| key != "name" || value.is_string());
        if kind == "scene" && members.get("nodes").is_none_or(Value::is_null) {
            members.insert("nodes".to_owned(), Value::Array(Vec::new()));
        }
        if kind == "animation"
            && let Some(Value::Array(channels)) = members.get_mut("channels")
        {
            channels.retain(|channel| channel.pointer("/target/node").is_some_and(|node| !node.is_null()));
        }
    }
    // Through text, because the types of extras can only be read from text.
    serde_json::from_str(&value.to_string()).map_err(clause)
}

/// The strings of a list; other items are skipped.
fn names(members: &Members<'_>, list: &str) -> Vec<String> {
    let elements: Vec<&RawValue> =
        members.get(list).and_then(|raw| serde_json::from_str(raw.get()).ok()).unwrap_or_default();
    elements.into_iter().filter_map(|raw| serde_json::from_str(raw.get()).ok()).collect()
}

/// For each light, whether it is directional and shines: a light with no intensity, or a black one, is not a
/// sun.
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
    struct Light<'a> {
        r#type: String,
        #[serde(borrow)]
        intensity: Option<&'a RawValue>,
        #[serde(borrow)]
        color: Option<&'a RawValue>,
    }
    let parsed =
        members.get("extensions").and_then(|raw| serde_json::from_str::<Extensions<'_>>(raw.get()).ok());
    let lights = parsed.and_then(|e| e.punctual).map_or_else(Vec::new, |p| p.lights);
    // Ignore an intensity or a colour that cannot be read: a light shines by default.
    let is_sun = |raw: &RawValue| {
        serde_json::from_str::<Light<'_>>(raw.get()).is_ok_and(|light| {
            let intensity = light.intensity.and_then(|raw| serde_json::from_str(raw.get()).ok());
            let color: Option<Vec<f64>> = light.color.and_then(|raw| serde_json::from_str(raw.get()).ok());
            light.r#type == "directional"
                && intensity.is_none_or(|intensity: f64| intensity > 0.0)
                && color.is_none_or(|color| color.iter().any(|&c| c > 0.0))
        })
    };
    lights.into_iter().map(is_sun).collect()
}

/// Rejects every version but 2.0. A later 2.x is read unless its minimum version is above 2.0 (glTF 2.0,
/// 3.2).
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
        let mut numbers = text.split('.');
        Some((numbers.next()?.parse().ok()?, numbers.next().unwrap_or("0").parse().ok()?))
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
    fn faults_are_errors_only_where_they_are_used() {
        let path = Path::new("a.gltf");
        let json = br#"{"asset": {"version": "2.0"}, "cameras": 5, "accessors": [{"count": "x"}], "meshes": [{}, {}]}"#;
        let document = GltfDocument::parse(path, json, &Budget::new(path, None)).expect("is read");
        assert_eq!((document.root.accessors.len(), document.root.meshes.len()), (1, 2));
        let message = document.faults.check(path, "accessor", 0).expect_err("has no type").to_string();
        assert!(message.contains("accessor 0 cannot be read: ") && !message.contains("line 1"), "{message}");
        document.faults.check(path, "accessor", 1).expect("is no fault");
        assert_eq!(document.faults.count("mesh"), 2);
        assert_eq!(document.faults.warnings().count(), 2);
    }
}
