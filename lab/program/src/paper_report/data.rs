//! The files that the commands wrote to the report's folder, prepared for the page.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;

use adumbra_html::page::{Embedded, PictureEncoding};

/// Encodings of pictures with their maximum width in pixels. Each gives a smaller page than the one before.
const WAYS: [(PictureEncoding, u32); 3] = [
    (PictureEncoding::Lossless, 1600),
    (PictureEncoding::Lossy(88), 1280),
    (PictureEncoding::Lossy(75), 800),
];

/// A picture file below `data`, and the part of it to show, `[x, y, width, height]` in pixels.
type Part = (String, Option<[u32; 4]>);

/// The folder, and the pictures prepared for the page.
///
/// Files of a section without a record are ignored, because their origin is unknown.
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

    /// Switches to the next smaller encoding of pictures. Returns false if there is none.
    pub(super) fn save_bytes(&mut self) -> bool {
        let more = self.way + 1 < WAYS.len();
        if more {
            self.way += 1;
            self.pictures.clear();
        }
        more
    }

    /// Marks a section as having a new record. From now on its files are read, and its pictures are read
    /// again.
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

    /// Returns the results in a JSON file below `data`, or `None` if there is no such file or it has another
    /// format.
    pub(super) fn results<T: DeserializeOwned>(&self, path: &str) -> Option<T> {
        serde_json::from_slice(&self.read(path)?).ok()
    }

    /// Returns a text file below `data`.
    pub(super) fn text(&self, path: &str) -> Option<String> {
        String::from_utf8(self.read(path)?).ok()
    }

    /// Returns a picture below `data`, or a part of it.
    pub(super) fn picture(&mut self, path: &str, part: Option<[u32; 4]>) -> Option<Embedded> {
        let key = (path.to_owned(), part);
        if let Some(known) = self.pictures.get(&key) {
            return Some(known.clone());
        }
        let (encoding, widest) = WAYS.get(self.way).copied()?;
        let bytes = self.read(path)?;
        let embedded = Embedded::from_png(&bytes, part, widest, encoding).ok()?;
        self.pictures.insert(key, embedded.clone());
        Some(embedded)
    }
}

#[cfg(test)]
mod tests {
    use adumbra_truth::picture::Picture;

    use super::*;
    use adumbra_program::output::write_png;

    #[test]
    fn data_rereads_pictures_after_new_record_or_smaller_encoding() {
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
