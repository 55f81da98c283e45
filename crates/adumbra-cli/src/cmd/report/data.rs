//! What the commands left in the report's folder, as the page takes it.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use adumbra_lab::page::{Embedded, Encoding};
use serde_json::Value;

/// How pictures are kept, and how many pixels wide at most: each way makes a smaller page than the one before.
const WAYS: [(Encoding, u32); 3] =
    [(Encoding::Lossless, 1600), (Encoding::Lossy(88), 1280), (Encoding::Lossy(75), 800)];

/// A file below `data`, and the part of it at `[x, y, width, height]` pixels.
type Part = (String, Option<[u32; 4]>);

/// The folder, and the pictures that were made ready for the page.
pub(super) struct Data {
    folder: PathBuf,
    pictures: HashMap<Part, Embedded>,
    way: usize,
}

impl Data {
    pub(super) fn new(folder: &Path) -> Self {
        Self { folder: folder.to_owned(), pictures: HashMap::new(), way: 0 }
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

    /// Drops what is known of a section that was measured again.
    pub(super) fn forget(&mut self, section: &str) {
        let below = format!("{section}/");
        self.pictures.retain(|(path, _), _| !path.starts_with(&below));
    }

    fn path(&self, path: &str) -> PathBuf {
        self.folder.join("data").join(path)
    }

    /// A JSON file below `data`; none where there is none.
    pub(super) fn json(&self, path: &str) -> Option<Value> {
        serde_json::from_slice(&std::fs::read(self.path(path)).ok()?).ok()
    }

    /// A text below `data`.
    pub(super) fn text(&self, path: &str) -> Option<String> {
        std::fs::read_to_string(self.path(path)).ok()
    }

    /// A picture below `data`, or a part of it.
    pub(super) fn picture(&mut self, path: &str, part: Option<[u32; 4]>) -> Option<Embedded> {
        let key = (path.to_owned(), part);
        if let Some(known) = self.pictures.get(&key) {
            return Some(known.clone());
        }
        let (encoding, widest) = WAYS.get(self.way).copied()?;
        let bytes = std::fs::read(self.path(path)).ok()?;
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
        assert_eq!(data.picture("ao/a.png", None).unwrap().width, 900);
        draw(1000);
        assert_eq!(data.picture("ao/a.png", None).unwrap().width, 900);
        data.forget("ao");
        assert_eq!(data.picture("ao/a.png", None).unwrap().width, 1000);
        assert!(data.save_bytes() && data.save_bytes() && !data.save_bytes());
        let small = data.picture("ao/a.png", None).unwrap();
        assert!(small.width == 800 && small.uri.starts_with("data:image/jpeg;"), "{}", small.width);
        assert_eq!(data.picture("ao/a.png", Some([10, 0, 20, 5])).unwrap().width, 20);
        assert!(data.picture("ao/b.png", None).is_none());
    }
}
