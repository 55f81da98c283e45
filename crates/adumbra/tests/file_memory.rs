//! What a file says that it takes in memory, compared with what it takes.

use adumbra::file::FileMemory;
use adumbra::layout::depths::PLACED_PAGE_BYTES;
use adumbra::{AtRest, Error, FormatError, ShadowFile};
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
fn memory_of_every_valid_file_is_what_it_holds() {
    let folder = Folder::new();
    let mut with_levels = 0;
    for entry in std::fs::read_dir(vectors("valid")).unwrap() {
        let path = entry.unwrap().path();
        // The lab's files are there too.
        let Ok(file) = ShadowFile::read(&path) else { continue };
        with_levels += u32::from(file.level_count() > 1);
        for at_rest in [AtRest::Raw, AtRest::Coded] {
            let bytes = file.to_bytes(at_rest).unwrap();
            let memory = ShadowFile::memory(folder.write("a.adumbra", &bytes)).unwrap();
            assert_eq!(memory.held_bytes, held_bytes(&file), "{}, {at_rest:?}", path.display());
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
fn files_that_are_read_one_after_the_other_hold_both() {
    let memory = |held_bytes, peak_bytes, writing_bytes| FileMemory { held_bytes, peak_bytes, writing_bytes };
    let [first, second] = [memory(10, 100, 40), memory(20, 50, 60)];
    assert_eq!(first.then(second), memory(30, 100, 70));
    assert_eq!(second.then(first), memory(30, 120, 70));
}
