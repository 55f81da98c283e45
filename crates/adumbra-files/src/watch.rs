//! Reports when files change, for programs that follow them.

use std::collections::HashSet;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use adumbra::IoError;
use notify::{Event, EventKind, RecommendedWatcher, RecursiveMode, Watcher};

use crate::folder_of;

/// How long files must stay unchanged before a change is reported, because programs write files piece by
/// piece.
const REST: Duration = Duration::from_millis(200);

/// Watches files until it is dropped.
pub struct FileWatch {
    // The thread that reports changes ends with the watcher, which holds the other end of its channel.
    _watcher: RecommendedWatcher,
}

impl FileWatch {
    /// Calls `changed`, on another thread, whenever some of the files have been written, replaced, created or
    /// removed, and then stayed unchanged for a fifth of a second. Files that do not exist yet are watched
    /// too, if their folders exist.
    ///
    /// # Errors
    /// Returns [`IoError`] if a folder of the files cannot be watched.
    pub fn new(files: &[PathBuf], changed: impl Fn() + Send + 'static) -> Result<Self, IoError> {
        let (sender, changes) = mpsc::channel();
        // Programs replace files by renaming others, so folders are watched.
        let mut names = HashSet::new();
        let mut folders = HashSet::new();
        for file in files {
            let folder = folder_of(file);
            let whole = folder.canonicalize().map_err(IoError::at("watch", &folder))?;
            names.extend(file.file_name().map(|name| whole.join(name)));
            folders.insert(whole);
        }
        let handler = move |event: notify::Result<Event>| {
            let is_ours = match &event {
                Ok(event) if matches!(event.kind, EventKind::Access(_)) => false,
                Ok(event) => event.need_rescan() || event.paths.iter().any(|path| names.contains(path)),
                Err(_) => true,
            };
            if is_ours {
                // The receiving thread lives as long as this handler.
                let _ = sender.send(());
            }
        };
        let mut watcher =
            notify::recommended_watcher(handler).map_err(|error| failed(Path::new("."), error))?;
        for folder in &folders {
            watcher.watch(folder, RecursiveMode::NonRecursive).map_err(|error| failed(folder, error))?;
        }
        thread::spawn(move || {
            while changes.recv().is_ok() {
                while changes.recv_timeout(REST).is_ok() {}
                changed();
            }
        });
        Ok(Self { _watcher: watcher })
    }
}

fn failed(folder: &Path, error: notify::Error) -> IoError {
    let source = match error.kind {
        notify::ErrorKind::Io(error) => error,
        _ => io::Error::other(error.to_string()),
    };
    IoError::at("watch", folder)(source)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::replace_file;

    #[test]
    fn changes_are_reported_once_after_files_stop_changing() {
        let folder = tempfile::tempdir().unwrap();
        let [scene, buffer, other] =
            ["scene.gltf", "scene.bin", "other"].map(|name| folder.path().join(name));
        fs::write(&scene, "a").unwrap();
        let (sender, reports) = mpsc::channel();
        let watch =
            FileWatch::new(&[scene.clone(), buffer.clone()], move || sender.send(()).unwrap()).unwrap();
        let is_reported = || reports.recv_timeout(Duration::from_secs(5)).is_ok();
        let is_quiet = || reports.recv_timeout(Duration::from_millis(600)).is_err();
        assert!(is_quiet());
        // Several writes are reported as one change.
        for text in ["b", "c", "d"] {
            fs::write(&scene, text).unwrap();
        }
        assert!(is_reported() && is_quiet());
        // A file that did not exist before, and a file that is replaced.
        fs::write(&buffer, "new").unwrap();
        assert!(is_reported() && is_quiet());
        replace_file(&scene, |file| io::Write::write_all(file, b"e").map(|()| 1)).unwrap();
        assert!(is_reported());
        fs::write(&other, "not ours").unwrap();
        fs::read(&scene).unwrap();
        assert!(is_quiet());
        fs::remove_file(&buffer).unwrap();
        assert!(is_reported());
        drop(watch);
        fs::write(&scene, "f").unwrap();
        assert!(is_quiet());
        let error = FileWatch::new(&[folder.path().join("none/a")], || {}).map(|_| ()).unwrap_err();
        assert!(error.to_string().contains("none"), "{error}");
    }
}
