//! Tests of shadow files on disk: a file is either complete or absent, and errors say what is wrong with the
//! path.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use adumbra::{Encoding, IoError, ShadowFile};
use adumbra_files::replace_file;
use adumbra_testing::{EarlierFile, vectors};

fn example() -> Vec<u8> {
    fs::read(vectors("valid/example_8_depths.adumbra")).expect("the example")
}

fn write(file: &ShadowFile, path: &Path) -> Result<u64, IoError> {
    replace_file(path, |out| file.write_to(out, Encoding::Raw))
}

#[test]
fn written_file_reads_back_and_replaces_the_earlier_one() {
    let output = EarlierFile::new();
    let file = ShadowFile::from_bytes(&example()).unwrap();
    assert_eq!(write(&file, output.path()).unwrap(), example().len() as u64);
    output.assert_replaced_by(&example());
    assert_eq!(ShadowFile::read(output.path()).unwrap(), file);
}

#[test]
fn rejected_write_keeps_previous_output() {
    let output = EarlierFile::new();
    let mut file = ShadowFile::from_bytes(&example()).unwrap();
    file.grid.size[0] += 1;
    let error = write(&file, output.path()).expect_err("the quadtree has another size");
    assert_eq!((error.action, error.source.kind()), ("write", ErrorKind::InvalidData));
    output.assert_kept();
}

#[test]
fn write_error_explains_what_is_wrong_with_the_path() {
    let folder = tempfile::tempdir().unwrap();
    let regular = folder.path().join("regular");
    fs::write(&regular, "a file").unwrap();
    let file = ShadowFile::from_bytes(&example()).unwrap();
    let says = |path: PathBuf| write(&file, &path).expect_err("the path is not that of a file").to_string();
    assert!(says(regular.join("a.adumbra")).contains("is a file, not a folder"));
    assert!(says(regular.join("deeper/a.adumbra")).contains("is a file, not a folder"));
    assert!(says(folder.path().join("missing/a.adumbra")).contains("does not exist; create it first"));
    assert!(says(folder.path().to_owned()).contains("it is a folder"));
    if cfg!(unix) {
        assert!(says("/dev/null".into()).contains("device"));
    }
    assert_eq!(fs::read(&regular).unwrap(), b"a file");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}
