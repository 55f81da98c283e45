//! The files in `test_vectors/` with their expected answers and faults, and the examples that `spec/` shows.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

/// Faults of the header and of the section positions, which occur in all kinds of file.
const HEADER_FAULTS: [&str; 8] = [
    "Magic",
    "FutureVersion",
    "Truncated",
    "TrailingBytes",
    "HeaderChecksum",
    "SectionChecksum",
    "HeaderField",
    "SectionBounds",
];

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Returns the path of a file or folder in `test_vectors/`.
pub fn vectors(path: &str) -> PathBuf {
    repository().join("test_vectors").join(path)
}

/// Returns name and bytes of every file of a folder in `test_vectors/`, sorted by name. Panics if there are
/// fewer than `at_least`.
pub fn named_vectors(folder: &str, at_least: usize) -> Vec<(String, Vec<u8>)> {
    let mut all: Vec<_> = fs::read_dir(vectors(folder))
        .expect(folder)
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|e| e == "adumbra"))
        .map(|path| (path.file_stem().unwrap().to_string_lossy().into_owned(), fs::read(&path).unwrap()))
        .collect();
    all.sort();
    assert!(all.len() >= at_least, "only {} vectors", all.len());
    all
}

/// Reads the expected answers of a file in `test_vectors/`.
pub fn vector_answers(folder: &str, name: &str) -> Value {
    read_json(&vectors(folder).join(format!("{name}.json")))
}

/// A point of the expected answers of a file.
pub struct ExpectedPoint<'a> {
    /// The point in the world.
    pub world: [f64; 3],
    /// Its visibility: 1 = lit, 0 = shadowed.
    pub visibility: u64,
    /// The whole entry of the point in the file of answers.
    pub all: &'a Value,
}

/// Returns the points of the expected answers of a file.
pub fn expected_points(answers: &Value) -> impl Iterator<Item = ExpectedPoint<'_>> {
    answers["points"].as_array().unwrap().iter().map(|point| ExpectedPoint {
        world: [0, 1, 2].map(|i| point["world"][i].as_f64().unwrap()),
        visibility: point["visibility"].as_u64().unwrap(),
        all: point,
    })
}

/// A file with one fault, and the error that reading it must give.
pub struct FaultyVector {
    /// The file.
    pub path: PathBuf,
    expected: Value,
}

impl FaultyVector {
    /// Checks kind, fault and message of the error that reading the file gave.
    ///
    /// # Panics
    /// Panics if they are not the expected ones, or if the message does not say what to do.
    pub fn check(&self, kind: &str, fault: Option<&str>, message: &str) {
        let (expected, path) = (&self.expected, self.path.display());
        let wanted = (expected["error"].as_str().unwrap(), expected["fault"].as_str());
        assert_eq!((kind, fault), wanted, "{path}: {message}");
        assert!(message.contains(expected["names"].as_str().unwrap()), "{path}: {message}");
        assert!(["bake", "update"].iter().any(|hint| message.contains(hint)), "no hint: {message}");
    }
}

/// Returns the files with a fault in a folder of `test_vectors/`.
pub fn faulty_vectors(folder: &str) -> Vec<FaultyVector> {
    let folders = fs::read_dir(vectors(folder)).unwrap().map(|entry| entry.unwrap().path());
    folders
        .map(|folder| FaultyVector {
            path: folder.join("file.adumbra"),
            expected: read_json(&folder.join("expected.json")),
        })
        .collect()
}

/// Reads `count` damaged files. `read` damages the bytes of a valid file according to a seed and reads them;
/// its error is the name of the fault. Returns how many were accepted, and the number of each fault.
pub fn count_faults(
    valid: &[(String, Vec<u8>)],
    count: u64,
    read: impl Fn(&[u8], u64) -> Result<(), &'static str>,
) -> (u32, BTreeMap<&'static str, u32>) {
    let (mut accepted, mut faults) = (0, BTreeMap::new());
    for seed in 0..count {
        let (_, bytes) = &valid[seed as usize % valid.len()];
        match read(bytes, seed) {
            Ok(()) => accepted += 1,
            Err(fault) => *faults.entry(fault).or_insert(0) += 1,
        }
    }
    (accepted, faults)
}

/// Checks that damaged files had every fault of the header and every one of
/// `others` at least ten times. `found` has the number of each.
///
/// # Panics
/// Panics if one is missing.
pub fn assert_faults_found(found: &BTreeMap<&str, u32>, others: &[&str]) {
    for fault in HEADER_FAULTS.iter().chain(others) {
        assert!(found.get(fault).is_some_and(|&n| n >= 10), "too few of {fault} in {found:?}");
    }
}

/// The example of a specification.
pub struct SpecifiedExample {
    /// The bytes of the file, which the specification shows as a dump.
    pub bytes: Vec<u8>,
    /// Points of its table of answers, each with the visibility as text.
    pub answers: Vec<([f64; 3], String)>,
}

/// Reads the example of a document in `spec/`.
pub fn specified_example(document: &str) -> SpecifiedExample {
    let text = fs::read_to_string(repository().join("spec").join(document)).unwrap();
    let mut bytes = Vec::new();
    for line in text.lines() {
        let Some((at, hex)) = line.split_once(": ") else { continue };
        if at.len() != 8 || usize::from_str_radix(at, 16) != Ok(bytes.len()) {
            continue;
        }
        bytes.extend(hex.split_whitespace().map_while(|b| u8::from_str_radix(b, 16).ok()));
    }
    let answers = text.lines().filter(|line| line.starts_with("| (")).map(|line| {
        let cells: Vec<_> = line.split('|').map(|cell| cell.trim().replace('−', "-")).collect();
        let mut world = cells[1].trim_matches(['(', ')']).split(", ").map(|c| c.parse().unwrap());
        ([0; 3].map(|_| world.next().unwrap()), cells[4].clone())
    });
    SpecifiedExample { bytes, answers: answers.collect() }
}

fn read_json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

/// Returns the little-endian word at byte `at` of a file.
pub fn u32_at(file: &[u8], at: u64) -> u32 {
    let at = at as usize;
    u32::from_le_bytes([file[at], file[at + 1], file[at + 2], file[at + 3]])
}

/// Returns the little-endian word of 64 bits at byte `at` of a file.
pub fn u64_at(file: &[u8], at: u64) -> u64 {
    u64::from(u32_at(file, at)) | u64::from(u32_at(file, at + 4)) << 32
}

/// Returns the number at byte `at` of a file.
pub fn f64_at(file: &[u8], at: u64) -> f64 {
    f64::from_bits(u64_at(file, at))
}
