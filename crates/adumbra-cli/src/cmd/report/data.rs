//! What the commands left in the report's folder, as the page takes it.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use adumbra_lab::page::{Embedded, Encoding};
use serde_json::Value;

/// How pictures are kept, and how many pixels wide at most: each way makes a smaller page than the one before.
const WAYS: [(Encoding, u32); 3] =
    [(Encoding::Lossless, 1600), (Encoding::Lossy(88), 1280), (Encoding::Lossy(75), 800)];

/// A file below `data`, and the part of it at `[x, y, width, height]` pixels.
type Part = (String, Option<[u32; 4]>);

/// The folder, and the pictures that were made ready for the page. Files of a section without a record are none: nobody knows what made them.
pub(super) struct Data {
    folder: PathBuf,
    recorded: HashSet<String>,
    pictures: HashMap<Part, Embedded>,
    way: usize,
}

impl Data {
    pub(super) fn new(folder: &Path) -> Self {
        Self { folder: folder.to_owned(), recorded: HashSet::new(), pictures: HashMap::new(), way: 0 }
    }

    /// Makes smaller pictures from now on; false where there is no smaller way.
    pub(super) fn save_bytes(&mut self) -> bool {
        let more = self.way + 1 < WAYS.len();
        if more {
            self.way += 1;
            self.pictures.clear();
        }
        more
    }

    /// A section has a record from now on, or a new one: its files are read, and its pictures again.
    pub(super) fn recorded(&mut self, section: &str) {
        self.recorded.insert(section.to_owned());
        let below = format!("{section}/");
        self.pictures.retain(|(path, _), _| !path.starts_with(&below));
    }

    fn read(&self, path: &str) -> Option<Vec<u8>> {
        let section = path.split('/').next()?;
        let file = self.folder.join("data").join(path);
        self.recorded.contains(section).then(|| std::fs::read(file).ok())?
    }

    /// A JSON file below `data`; none where there is none.
    pub(super) fn json(&self, path: &str) -> Option<Value> {
        serde_json::from_slice(&self.read(path)?).ok()
    }

    /// A text below `data`.
    pub(super) fn text(&self, path: &str) -> Option<String> {
        String::from_utf8(self.read(path)?).ok()
    }

    /// A picture below `data`, or a part of it.
    pub(super) fn picture(&mut self, path: &str, part: Option<[u32; 4]>) -> Option<Embedded> {
        let key = (path.to_owned(), part);
        if let Some(known) = self.pictures.get(&key) {
            return Some(known.clone());
        }
        let (encoding, widest) = WAYS.get(self.way).copied()?;
        let bytes = self.read(path)?;
        let embedded = Embedded::of_png(&bytes, part, widest, encoding).ok()?;
        self.pictures.insert(key, embedded.clone());
        Some(embedded)
    }
}

#[cfg(test)]
mod tests {
    use adumbra::picture::Picture;

    use super::*;
    use crate::output::write_png;

    #[test]
    fn data_keeps_pictures_until_they_are_measured_again_or_take_too_much() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir_all(folder.path().join("data/ao")).unwrap();
        let path = folder.path().join("data/ao/a.png");
        let draw = |width: u32| {
            let rgb = (0..width * 30).map(|i| (i % 251) as u8).collect();
            write_png(&path, &Picture { width, height: 10, rgb, difference_share: None }).unwrap();
        };
        draw(900);
        let mut data = Data::new(folder.path());
        assert!(data.picture("ao/a.png", None).is_none(), "nothing is recorded");
        data.recorded("ao");
        assert_eq!(data.picture("ao/a.png", None).unwrap().width, 900);
        draw(1000);
        assert_eq!(data.picture("ao/a.png", None).unwrap().width, 900);
        data.recorded("ao");
        assert_eq!(data.picture("ao/a.png", None).unwrap().width, 1000);
        assert!(data.save_bytes() && data.save_bytes() && !data.save_bytes());
        let small = data.picture("ao/a.png", None).unwrap();
        assert!(small.width == 800 && small.uri.starts_with("data:image/jpeg;"), "{}", small.width);
        assert_eq!(data.picture("ao/a.png", Some([10, 0, 20, 5])).unwrap().width, 20);
        assert!(data.picture("ao/b.png", None).is_none());
    }
}
