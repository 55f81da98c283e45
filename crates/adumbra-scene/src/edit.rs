//! Edits of a scene's instances, as an editor or an engine makes them: moved, added, removed.

use std::collections::HashMap;
use std::path::Path;

use adumbra_files::{TEXT_BYTES, read_whole};
use serde::{Deserialize, Serialize};

use crate::affine::{Affine, is_finite};
use crate::{Error, Instance, Result, Scene};

/// Edits of a scene's instances. All of them refer to the instances as they are before the first edit.
///
/// As JSON, with matrices by rows:
///
/// ```json
/// { "moved": [{ "instance": "tree_7", "world_from_mesh": [[1, 0, 0, 12.5], [0, 1, 0, 0], [0, 0, 1, -3]] }],
///   "added": [{ "like": 41, "name": "tree_99",
///                "world_from_mesh": [[1, 0, 0, 8], [0, 1, 0, 0], [0, 0, 1, 2]] }],
///   "removed": ["bench_3", 12] }
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Edits {
    /// Instances to move.
    pub moved: Vec<Moved>,
    /// New instances of the scene's meshes. They are appended to the other instances, in this order.
    pub added: Vec<Added>,
    /// Instances to remove.
    pub removed: Vec<Which>,
}

/// An instance to move.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Moved {
    /// The instance.
    pub instance: Which,
    /// Its new transform, as [`Instance::world_from_mesh`].
    pub world_from_mesh: [[f64; 4]; 3],
}

/// A new instance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Added {
    /// An instance with the same mesh.
    pub like: Which,
    /// The new instance's name; empty if it has none.
    #[serde(default)]
    pub name: String,
    /// Its transform, as [`Instance::world_from_mesh`].
    pub world_from_mesh: [[f64; 4]; 3],
}

/// An instance of a scene.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Which {
    /// By its index in [`Scene::instances`].
    Number(usize),
    /// By its name, which must be unique.
    Named(String),
}

impl Edits {
    /// Reads edits from a JSON file.
    ///
    /// # Errors
    /// Returns [`Error::Io`] if the file cannot be read, and [`Error::Edits`] if it does not hold edits.
    pub fn read(path: &Path) -> Result<Self> {
        let text = read_whole(path, TEXT_BYTES)?;
        serde_json::from_slice(&text).map_err(|e| Error::Edits { what: format!("{}: {e}", path.display()) })
    }
}

impl Scene {
    /// Edits the instances. Makes either all edits or none.
    ///
    /// # Errors
    /// Returns [`Error::Edits`] if an instance does not exist, has an ambiguous name, is edited twice or is
    /// animated, if a matrix is not finite, or if nothing would cast a shadow any more.
    pub fn edit(&mut self, edits: &Edits) -> Result<()> {
        let names = Names::new(self);
        let mut instances = self.instances.clone();
        let mut kept = vec![true; instances.len()];
        let mut touched = vec![false; instances.len()];
        let mut touch = |which: &Which| {
            let index = names.find(self, which)?;
            match std::mem::replace(&mut touched[index], true) {
                false => Ok(index),
                true => refuse(format!("{} is edited twice", which.text())),
            }
        };
        for Moved { instance, world_from_mesh } in &edits.moved {
            instances[touch(instance)?].world_from_mesh = checked(instance, world_from_mesh)?;
        }
        for which in &edits.removed {
            kept[touch(which)?] = false;
        }
        for Added { like, name, world_from_mesh } in &edits.added {
            let source = &self.instances[names.find(self, like)?];
            instances.push(Instance {
                name: name.clone(),
                world_from_mesh: checked(like, world_from_mesh)?,
                ..source.clone()
            });
            kept.push(true);
        }
        let mut keep = kept.iter();
        instances.retain(|_| keep.next().is_some_and(|&kept| kept));
        if !instances.iter().any(|instance| instance.casts) {
            return refuse("no instance would cast a shadow any more".to_owned());
        }
        self.movers.forget(&kept);
        self.instances = instances;
        Ok(())
    }
}

/// The index of each name, or `None` if several instances have it.
struct Names(HashMap<String, Option<usize>>);

impl Names {
    fn new(scene: &Scene) -> Self {
        let mut names = HashMap::new();
        for (index, instance) in scene.instances.iter().enumerate() {
            names.entry(instance.name.clone()).and_modify(|one| *one = None).or_insert(Some(index));
        }
        Self(names)
    }

    fn find(&self, scene: &Scene, which: &Which) -> Result<usize> {
        let found = match which {
            Which::Number(index) => (*index < scene.instances.len()).then_some(Some(*index)),
            Which::Named(name) => self.0.get(name).copied(),
        };
        match found {
            None => refuse(format!(
                "the scene's {} instances do not have {}",
                scene.instances.len(),
                which.text()
            )),
            Some(None) => refuse(format!("several instances are {}; give the number of one", which.text())),
            Some(Some(index)) if scene.movers.contains(index as u32) => {
                refuse(format!("{} is animated", which.text()))
            }
            Some(Some(index)) => Ok(index),
        }
    }
}

impl Which {
    fn text(&self) -> String {
        match self {
            Self::Number(index) => format!("instance {index}"),
            Self::Named(name) => format!("instance {name:?}"),
        }
    }
}

fn checked(which: &Which, place: &Affine) -> Result<Affine> {
    if is_finite(place) {
        Ok(*place)
    } else {
        refuse(format!("the matrix of {} is not finite", which.text()))
    }
}

fn refuse<T>(what: String) -> Result<T> {
    Err(Error::Edits { what })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{GeneratedKind, generate};

    fn read(text: &str) -> Edits {
        serde_json::from_str(text).expect("edits")
    }

    #[test]
    fn instances_are_moved_added_and_removed() {
        let mut scene = generate(GeneratedKind::City, 1);
        scene.instances[3].name = "three".to_owned();
        let before = scene.instances.clone();
        let edits = read(
            r#"{ "moved": [{ "instance": "three", "world_from_mesh": [[2, 0, 0, 1], [0, 1, 0, 0], [0, 0, 1, 5]] }],
                 "added": [{ "like": 4, "name": "new", "world_from_mesh": [[1, 0, 0, 9], [0, 1, 0, 0], [0, 0, 1, 0]] }],
                 "removed": [0, 4] }"#,
        );
        scene.edit(&edits).unwrap();
        assert_eq!(scene.instances.len(), before.len() - 1);
        assert_eq!(scene.instances[0].world_from_mesh, before[1].world_from_mesh);
        assert_eq!(scene.instances[2].world_from_mesh[0], [2.0, 0.0, 0.0, 1.0]);
        assert_eq!(scene.instances[3].world_from_mesh, before[5].world_from_mesh);
        let last = scene.instances.last().unwrap();
        assert_eq!((last.name.as_str(), last.mesh, last.world_from_mesh[0][3]), ("new", before[4].mesh, 9.0));
    }

    #[test]
    fn invalid_edits_change_nothing() {
        let mut scene = generate(GeneratedKind::City, 1);
        (scene.instances[0].name, scene.instances[1].name) = ("twin".to_owned(), "twin".to_owned());
        let before = scene.instances.clone();
        let place = "[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]";
        for (text, expected) in [
            (r#"{ "removed": [5, 99999] }"#.to_owned(), "instance 99999"),
            (r#"{ "removed": ["nobody"] }"#.to_owned(), "\"nobody\""),
            (r#"{ "removed": ["twin"] }"#.to_owned(), "several"),
            (r#"{ "removed": [2, 2] }"#.to_owned(), "twice"),
            (format!(r#"{{ "removed": [2], "moved": [{{ "instance": 2, "world_from_mesh": {place} }}] }}"#), "twice"),
            (r#"{ "moved": [{ "instance": 2, "world_from_mesh": [[1e300, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]] }] }"#.to_owned(), "finite"),
        ] {
            let error = scene.edit(&read(&text)).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
        let all: Vec<Which> = (0..before.len()).map(Which::Number).collect();
        let error = scene.edit(&Edits { removed: all, ..Edits::default() }).unwrap_err();
        assert!(error.to_string().contains("no instance would cast"), "{error}");
        let same = |a: &Instance, b: &Instance| a.world_from_mesh == b.world_from_mesh && a.name == b.name;
        assert!(
            scene.instances.len() == before.len()
                && scene.instances.iter().zip(&before).all(|(a, b)| same(a, b))
        );
        for wrong in [r#"{ "moves": [] }"#, r#"{ "removed": [1.5] }"#, "[{}]"] {
            assert!(serde_json::from_str::<Edits>(wrong).is_err(), "{wrong}");
        }
    }
}
