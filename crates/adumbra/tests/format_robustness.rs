//! The file format against `test_vectors/` and against damage: whatever bytes are read, the answer is a file that can
//! be looked up everywhere or an error that names the fault; whatever goes wrong while writing, no half file is left.

#[path = "format_support/mod.rs"]
mod format_support;
#[path = "format_support/reference.rs"]
mod reference;

use std::fs;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use adumbra::Error;
use adumbra::dag::LIT;
use adumbra::format::{Layout, LightBody, ShadowFile, VERSION};
use adumbra::scene::Bounds;
use adumbra::settings::Receivers;
use format_support::{Mutator, encode, exercise, interpret, is_lit, sweep};
use serde_json::Value;

fn vectors(folder: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../test_vectors").join(folder)
}

/// Name and bytes of every valid vector, by name.
fn valid() -> Vec<(String, Vec<u8>)> {
    valid_in("valid")
}

fn valid_in(folder: &str) -> Vec<(String, Vec<u8>)> {
    let mut all: Vec<_> = fs::read_dir(vectors(folder))
        .expect(folder)
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|e| e == "adumbra"))
        .map(|path| (path.file_stem().unwrap().to_string_lossy().into_owned(), fs::read(&path).unwrap()))
        .collect();
    all.sort();
    assert!(all.len() >= 10, "only {} vectors", all.len());
    all
}

fn example() -> Vec<u8> {
    fs::read(vectors("valid/example_8.adumbra")).expect("the example")
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

#[test]
fn valid_vectors_give_their_answers() {
    give_their_answers("valid");
}

#[test]
fn version_1_is_read_and_written_as_version_2() {
    give_their_answers("valid_v1");
    for (name, bytes) in valid_in("valid_v1") {
        let file = ShadowFile::from_bytes(&bytes).unwrap();
        assert_eq!((bytes[8], u32::from(encode(&file)[8])), (1, VERSION), "{name}");
        assert_eq!(file.body.layout(), Layout::Plain);
    }
}

fn give_their_answers(folder: &str) {
    for (name, bytes) in valid_in(folder) {
        let file = exercise(&bytes).unwrap_or_else(|e| panic!("{name}: {e}"));
        let answers = json(&vectors(folder).join(format!("{name}.json")));
        for point in answers["points"].as_array().unwrap() {
            let world = [0, 1, 2].map(|i| point["world"][i].as_f64().unwrap());
            let expected = point["visibility"].as_u64().unwrap();
            assert_eq!(u64::from(reference::visibility(&bytes, world)), expected, "{name}: {point}");
            let at = file.grid.to_grid(world);
            if (0..3).all(|a| at[a] >= 0.0 && at[a] < f64::from(file.grid.size[a])) {
                let lit = is_lit(&file, at.map(|c| c.floor() as u32));
                assert_eq!(u64::from(lit), expected, "{name}: {point}");
            }
        }
    }
}

#[test]
fn decoded_graph_agrees_with_the_reference_on_every_voxel() {
    for (name, bytes) in valid() {
        let file = ShadowFile::from_bytes(&bytes).unwrap();
        let size = file.grid.size;
        let mut lit = 0;
        for z in 0..size[2] {
            for y in 0..size[1] {
                for x in 0..size[0] {
                    let expected = reference::voxel(&bytes, [x, y, z]) == 1;
                    assert_eq!(is_lit(&file, [x, y, z]), expected, "{name} ({x}, {y}, {z})");
                    lit += u64::from(expected);
                }
            }
        }
        assert_eq!(sweep(&file, u64::MAX), lit, "{name}");
    }
}

#[test]
fn invalid_vectors_give_their_errors() {
    let mut count = 0;
    for entry in fs::read_dir(vectors("invalid")).unwrap() {
        let folder = entry.unwrap().path();
        let expected = json(&folder.join("expected.json"));
        let path = folder.join("file.adumbra");
        let Err(Error::Format { source, .. }) = ShadowFile::read(&path) else {
            panic!("{}: no format error", folder.display());
        };
        let fault = source.fault();
        let message = source.to_string();
        assert_eq!(
            (source.kind(), fault),
            (expected["error"].as_str().unwrap(), expected["fault"].as_str()),
            "{}: {message}",
            folder.display()
        );
        assert!(message.contains(expected["names"].as_str().unwrap()), "{}: {message}", folder.display());
        assert!(["bake", "update"].iter().any(|mend| message.contains(mend)), "no mend: {message}");
        // Bytes and file give the same error.
        assert_eq!(exercise(&fs::read(&path).unwrap()).unwrap_err(), source);
        count += 1;
    }
    assert!(count >= 50, "only {count} faults");
}

#[test]
fn specification_shows_the_example_as_it_is() {
    let text =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../spec/adumbra-file.md")).unwrap();
    let mut bytes = Vec::new();
    for line in text.lines() {
        let Some((at, hex)) = line.split_once(": ") else { continue };
        if at.len() != 8 || usize::from_str_radix(at, 16) != Ok(bytes.len()) {
            continue;
        }
        bytes.extend(hex.split_whitespace().map_while(|b| u8::from_str_radix(b, 16).ok()));
    }
    assert_eq!(bytes, example());
    let answers = text.lines().filter(|line| line.starts_with("| (")).map(|line| {
        let cells: Vec<_> = line.split('|').map(|cell| cell.trim().replace('−', "-")).collect();
        let mut world = cells[1].trim_matches(['(', ')']).split(", ").map(|c| c.parse().unwrap());
        let world = [0; 3].map(|_| world.next().unwrap());
        assert_eq!(reference::visibility(&bytes, world).to_string(), cells[4], "{line}");
    });
    assert_eq!(answers.count(), 8);
}

#[test]
fn settings_and_grid_come_back_bit_for_bit() {
    let mut file = ShadowFile::from_bytes(&example()).unwrap();
    for bits in 0..16_u32 {
        let s = &mut file.settings;
        (s.assume_ground, s.closed_regions, s.ignore_alpha) = (bits & 1 != 0, bits & 2 != 0, bits & 4 != 0);
        s.receivers = if bits & 8 != 0 { Receivers::Static } else { Receivers::All };
        s.bounds = (bits % 3 == 0).then_some(Bounds { min: [-1.5, -0.0, 1e-300], max: [0.1, 2.5, 1e300] });
        (s.resolution, s.triangles, s.instances) = (1 << bits, u64::MAX - u64::from(bits), 3 << 40);
        s.switch_within_voxels = bits;
        s.thickness_world = 0.1 * f64::from(bits);
        s.bias.slope_texels = 1.0 / 3.0;
        s.bias.normal_offset_texels = 0.7;
        file.grid.origin = [0.1 + f64::from(bits), -1e15, 5e-324];
        assert_eq!(exercise(&encode(&file)).unwrap(), file);
    }
}

#[test]
fn truncation_at_every_length_is_an_error() {
    for (name, bytes) in valid() {
        for length in 0..bytes.len() {
            let error = exercise(&bytes[..length]).expect_err(&name);
            assert_eq!(error.kind(), "Truncated", "{name} at {length}: {error}");
        }
    }
}

#[test]
fn every_flipped_bit_is_an_error() {
    let valid = example();
    for at in 0..valid.len() {
        for bit in 0..8 {
            let mut bytes = valid.clone();
            bytes[at] ^= 1 << bit;
            assert!(exercise(&bytes).is_err(), "byte {at} bit {bit}");
        }
    }
}

/// Some voxels of an accepted file, spread over its columns and near where they switch.
fn agrees_with_the_reference(file: &ShadowFile, bytes: &[u8], seed: u64) {
    let size = file.grid.size;
    for at in 0..24 {
        let spread =
            |a: u64| (seed.wrapping_add(at * 7 + a).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32) as u32;
        let [i, j, mut k] = [0, 1, 2].map(|a| spread(a as u64) % size[a]);
        if let LightBody::Hierarchy(hierarchy) = &file.body {
            k = hierarchy.value(i, j).wrapping_sub(at as u32 & 1).min(size[2] - 1);
        }
        let expected = reference::voxel(bytes, [i, j, k]) == 1;
        assert_eq!(is_lit(file, [i, j, k]), expected, "seed {seed}: ({i}, {j}, {k})");
    }
}

#[test]
fn mutations_are_refused_or_answer_everywhere() {
    let seeds = valid();
    let (mut accepted, mut kinds) = (0, std::collections::BTreeMap::new());
    for seed in 0..200_000_u64 {
        let (_, bytes) = &seeds[seed as usize % seeds.len()];
        let mutated = Mutator::new(seed).mutate(bytes);
        match exercise(&mutated) {
            Ok(file) => {
                accepted += 1;
                agrees_with_the_reference(&file, &mutated, seed);
            }
            Err(error) => *kinds.entry(error.fault().unwrap_or(error.kind())).or_insert(0) += 1,
        }
    }
    // The mutations reach every check, and graphs that are still valid.
    assert!(accepted > 10_000, "{accepted} accepted");
    let kinds: Vec<_> = kinds.into_iter().filter(|(_, n)| *n >= 10).map(|(kind, _)| kind).collect();
    for kind in [
        "Magic",
        "FutureVersion",
        "Truncated",
        "TrailingBytes",
        "HeaderChecksum",
        "SectionChecksum",
        "HeaderField",
        "SectionBounds",
        "Padding",
        "PointerRange",
        "Order",
        "NotAHeader",
        "TwoLevels",
        "HeaderBits",
        "ChildState",
        "NodeEnd",
        "Uniform",
        "Unreachable",
        "TopLength",
        "Pools",
        "Filler",
        "Column",
        "NodeBits",
        "SlabRange",
        "Slabs",
        "Pointer",
        "Unreached",
        "Bits",
        "End",
        "Ranks",
    ] {
        assert!(kinds.contains(&kind), "no {kind} in {kinds:?}");
    }
}

#[test]
fn fuzz_input_of_even_first_byte_gets_its_checksums() {
    let mut input = example();
    assert_eq!(interpret(&input), example());
    input[0] = b'@';
    input[20] = 99;
    assert_eq!(exercise(&interpret(&input)).unwrap().settings.resolution, 99);
    assert_eq!(exercise(&interpret(&[])).unwrap_err().kind(), "Truncated");
}

/// Takes `room` bytes, then says that the disk is full.
struct FullDisk {
    room: usize,
}

impl Write for FullDisk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let taken = bytes.len().min(self.room);
        self.room -= taken;
        if taken == 0 && !bytes.is_empty() { Err(ErrorKind::StorageFull.into()) } else { Ok(taken) }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn failing_writer_is_an_error_after_any_byte() {
    for (_, bytes) in valid() {
        let file = ShadowFile::from_bytes(&bytes).unwrap();
        for room in 0..bytes.len() {
            assert_eq!(file.write_to(&mut FullDisk { room }).unwrap_err().kind(), ErrorKind::StorageFull);
        }
        assert_eq!(file.write_to(&mut FullDisk { room: bytes.len() }).unwrap(), bytes.len() as u64);
    }
}

#[test]
fn written_file_reads_back_and_replaces_the_earlier_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.adumbra");
    fs::write(&path, "earlier").unwrap();
    let file = ShadowFile::from_bytes(&example()).unwrap();
    assert_eq!(file.write(&path).unwrap(), example().len() as u64);
    assert_eq!(fs::read(&path).unwrap(), example());
    assert_eq!(ShadowFile::read(&path).unwrap(), file);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "a temporary file is left");
}

#[test]
fn refused_write_leaves_the_earlier_output() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.adumbra");
    fs::write(&path, "earlier").unwrap();
    let mut file = ShadowFile::from_bytes(&example()).unwrap();
    let LightBody::Plain(dag) = &mut file.body else { panic!("another layout") };
    dag.nodes.push(LIT);
    assert!(matches!(file.write(&path), Err(Error::Format { .. })));
    assert_eq!(file.write_to(&mut Vec::new()).unwrap_err().kind(), ErrorKind::InvalidData);
    assert_eq!(fs::read(&path).unwrap(), b"earlier");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn write_says_what_is_wrong_with_the_path() {
    let folder = tempfile::tempdir().unwrap();
    let regular = folder.path().join("regular");
    fs::write(&regular, "a file").unwrap();
    let file = ShadowFile::from_bytes(&example()).unwrap();
    let says = |path: PathBuf| match file.write(&path) {
        Err(e @ Error::Io { .. }) => e.to_string(),
        other => panic!("{}: {other:?}", path.display()),
    };
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

#[test]
fn read_says_what_is_wrong_with_the_path() {
    let folder = tempfile::tempdir().unwrap();
    for path in [folder.path().to_owned(), folder.path().join("missing")] {
        let Err(Error::Io { action: "read", path: named, .. }) = ShadowFile::read(&path) else {
            panic!("{}", path.display());
        };
        assert_eq!(named, path);
    }
}
