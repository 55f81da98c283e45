//! The memory that a file's header and tables predict, compared with the memory it takes.

use adumbra::file::FileMemory;
use adumbra::layout::depths::PLACED_PAGE_BYTES;
use adumbra::{Encoding, Error, FormatError, ShadowFile};
use adumbra_testing::{Folder, vectors};

/// Returns the bytes that the levels of a file hold.
fn held_bytes(file: &ShadowFile) -> u64 {
    let held = |tree: &adumbra::layout::depths::DepthTree| {
        let pages: u64 = tree.page_dims().map(u64::from).iter().product();
        tree.bytes() + PLACED_PAGE_BYTES * pages
    };
    file.levels().iter().map(|level| held(&level.tree)).sum()
}

#[test]
fn predicted_memory_matches_every_valid_file() {
    let folder = Folder::new();
    let mut with_levels = 0;
    for entry in std::fs::read_dir(vectors("valid")).unwrap() {
        let path = entry.unwrap().path();
        // The folder also has files of the lab.
        let Ok(file) = ShadowFile::read(&path) else { continue };
        with_levels += u32::from(file.level_count() > 1);
        for encoding in [Encoding::Raw, Encoding::Coded] {
            let bytes = file.to_bytes(encoding).unwrap();
            let memory = ShadowFile::memory(folder.write("a.adumbra", &bytes)).unwrap();
            assert_eq!(memory.held_bytes, held_bytes(&file), "{}, {encoding:?}", path.display());
            // The file's bytes are there until the last level is read.
            assert!(memory.peak_bytes > memory.held_bytes + bytes.len() as u64, "{memory:?}");
        }
    }
    assert!(with_levels > 0);
}

#[test]
fn memory_is_known_before_any_page_is_read() {
    let folder = Folder::new();
    let bytes = std::fs::read(vectors("valid/many_pages_depths.adumbra")).unwrap();
    let whole = ShadowFile::memory(folder.write("whole.adumbra", &bytes)).unwrap();
    let cut = folder.write("cut.adumbra", &bytes[..bytes.len() - 1]);
    assert_eq!(ShadowFile::memory(&cut).unwrap(), whole);
    assert!(ShadowFile::read(&cut).is_err());

    // Within the tables, and within the directory.
    for length in [600, 300] {
        let error = ShadowFile::memory(folder.write("short.adumbra", &bytes[..length])).unwrap_err();
        let Error::Format { source, .. } = error else { panic!("{error}") };
        assert!(matches!(*source, FormatError::Truncated { .. }), "{source}");
    }
    assert!(matches!(ShadowFile::memory(folder.path("none")), Err(Error::Io(_))));
}

#[test]
fn file_beyond_the_limit_is_refused_before_it_is_decoded() {
    let folder = Folder::new();
    let bytes = std::fs::read(vectors("valid/many_pages_coded_depths.adumbra")).unwrap();
    let path = folder.write("whole.adumbra", &bytes);
    let most = ShadowFile::memory(&path).unwrap().peak_bytes;
    assert_eq!(ShadowFile::read_within(&path, most).unwrap(), ShadowFile::read(&path).unwrap());
    let refused = |error: Error| {
        let Error::Format { source, .. } = error else { panic!("{error}") };
        let FormatError::TooLarge { needed_bytes, limit_bytes } = *source else { panic!("{source}") };
        (needed_bytes, limit_bytes)
    };
    let error = ShadowFile::read_within(&path, most - 1).unwrap_err();
    assert!(error.to_string().contains("allow more, or stream the file"), "{error}");
    assert_eq!(refused(error), (most, most - 1));
    assert!(matches!(ShadowFile::from_bytes_within(&bytes, most - 1), Err(FormatError::TooLarge { .. })));

    // A damaged bundle goes unnoticed, because it is not decoded.
    let mut damaged = bytes.clone();
    *damaged.last_mut().unwrap() ^= 1;
    let damaged = folder.write("damaged.adumbra", &damaged);
    assert_eq!(refused(ShadowFile::read_within(&damaged, most - 1).unwrap_err()), (most, most - 1));
    // A file that is longer than the limit is not read, and neither is anything after the tables.
    let length = bytes.len() as u64;
    assert_eq!(refused(ShadowFile::read_within(&path, length - 1).unwrap_err()), (length, length - 1));
    let cut = folder.write("cut.adumbra", &bytes[..bytes.len() - 400]);
    assert_eq!(refused(ShadowFile::read_within(&cut, most - 1).unwrap_err()), (most, most - 1));
}

#[test]
fn no_file_takes_more_than_300_times_its_bytes() {
    for entry in std::fs::read_dir(vectors("valid")).unwrap() {
        let path = entry.unwrap().path();
        let Ok(memory) = ShadowFile::memory(&path) else { continue };
        let bytes = std::fs::metadata(&path).unwrap().len();
        assert!(memory.peak_bytes < 300 * bytes, "{}: {memory:?} of {bytes} bytes", path.display());
    }
}

#[test]
fn held_memory_of_successive_files_adds_up() {
    let memory = |held_bytes, peak_bytes, writing_bytes| FileMemory { held_bytes, peak_bytes, writing_bytes };
    let [first, second] = [memory(10, 100, 40), memory(20, 50, 60)];
    assert_eq!(first.then(second), memory(30, 100, 70));
    assert_eq!(second.then(first), memory(30, 120, 70));
}
