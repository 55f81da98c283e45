//! Tests of the file format with `test_vectors/` and with damaged files. For any bytes, reading must return
//! either a file in which every voxel can be looked up, or an error that names the fault. Writing an invalid
//! file must be an error.

#[path = "format_support/mod.rs"]
mod format_support;
#[path = "format_support/reference.rs"]
mod reference;

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Cursor, ErrorKind, Seek, SeekFrom, Write};

use adumbra::file::Header;
use adumbra::layout::depths::page::{IN_PAGE, Page};
use adumbra::layout::depths::{NEVER, UNIFORM};
use adumbra::{Bounds, Encoding, Error, IoError, Receivers, ShadowFile};
use adumbra_testing::{
    PageParts, TreeParts, assert_faults_found, count_faults, expected_points, faulty_vectors, named_vectors,
    overhead_grid, settings_for, specified_example, vector_answers, vectors,
};
use format_support::{encode, exercise, interpret, mutate, sweep};

/// Returns name and bytes of every valid vector, sorted by name.
fn valid() -> Vec<(String, Vec<u8>)> {
    named_vectors("valid", 10)
}

/// Returns name and bytes of every raw vector, sorted by name.
fn raw() -> Vec<(String, Vec<u8>)> {
    valid().into_iter().filter(|(_, bytes)| encoding(bytes) == Encoding::Raw).collect()
}

fn encoding(bytes: &[u8]) -> Encoding {
    Header::parse(bytes).expect("a header").encoding
}

fn example() -> Vec<u8> {
    fs::read(vectors("valid/example_8_depths.adumbra")).expect("the example")
}

#[test]
fn valid_vectors_give_their_answers() {
    let folder = "valid";
    for (name, bytes) in named_vectors(folder, 10) {
        let file = exercise(&bytes).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(file.to_bytes(encoding(&bytes)), Ok(bytes), "{name}");
        let raw = encode(&file);
        for point in expected_points(&vector_answers(folder, &name)) {
            let (expected, what) = (point.visibility, point.all);
            assert_eq!(u64::from(reference::visibility(&raw, point.world)), expected, "{name}: {what}");
            let at = file.grid.to_grid(point.world);
            if (0..3).all(|a| at[a] >= 0.0 && at[a] < f64::from(file.grid.size[a])) {
                let [i, j, k] = at.map(|c| c.floor() as u32);
                assert_eq!(u64::from(file.tree.voxel(i, j, k)), expected, "{name}: {what}");
            }
        }
    }
}

/// Largest number of voxels of a level that are all compared. Of a larger level, some are.
const MOST_VOXELS: u64 = 1 << 18;

#[test]
fn decoded_quadtree_agrees_with_the_reference() {
    for (name, bytes) in raw() {
        let file = ShadowFile::from_bytes(&bytes).unwrap();
        for number in 0..file.level_count() {
            let level = file.level(number).unwrap();
            let [nx, ny, nz] = level.grid.size.map(u64::from);
            let all = nx * ny * nz;
            // An odd step visits every column of a small grid, and spreads over a large one.
            let step = all.div_ceil(MOST_VOXELS) as usize | 1;
            let mut lit = 0;
            for at in (0..all).step_by(step) {
                let [x, y, z] = [at % nx, at / nx % ny, at / (nx * ny)].map(|c| c as u32);
                let expected = reference::voxel(&bytes, number.into(), [x, y, z]) == 1;
                assert_eq!(level.tree.voxel(x, y, z), expected, "{name}, level {number}: ({x}, {y}, {z})");
                lit += u64::from(expected);
            }
            if step == 1 {
                assert_eq!(sweep(&level, u64::MAX), lit, "{name}, level {number}");
            }
        }
    }
}

#[test]
fn each_level_round_trips_as_its_own_file() {
    let bytes = fs::read(vectors("valid/levels_depths.adumbra")).unwrap();
    let file = ShadowFile::from_bytes(&bytes).unwrap();
    assert_eq!(file.level_count(), 3);
    assert_eq!(file.level(0).as_ref(), Some(&file));
    let coarse = file.level(1).unwrap();
    assert_eq!(coarse.grid.voxel_size, 4.0 * file.grid.voxel_size);
    assert_eq!(coarse.settings.resolution, file.settings.resolution.div_ceil(4));
    assert_eq!((coarse.level_count(), coarse.level(1)), (2, file.level(2)));
    assert_eq!(file.level(3), None);
    // A level is written as a separate file, in which it is the finest.
    let again = ShadowFile::from_bytes(&encode(&coarse)).unwrap();
    assert_eq!(again, coarse);
}

#[test]
fn pages_share_shapes_of_common_section() {
    let bytes = fs::read(vectors("valid/many_pages_depths.adumbra")).unwrap();
    let tree = &ShadowFile::from_bytes(&bytes).unwrap().tree;
    assert_eq!(tree.page_dims(), [5, 5]);
    assert!(!tree.common().is_empty());
    let pages: Vec<Page<'_>> = (0..25).map(|i| tree.page([i % 5, i / 5])).collect();
    let is_common = |page: &&Page<'_>| page.root != UNIFORM && page.root & IN_PAGE == 0;
    assert!(pages.iter().filter(is_common).count() >= 3, "whole pages are equal");
    assert!(pages.iter().any(|page| page.root & IN_PAGE != 0 && page.root != UNIFORM));
}

#[test]
fn pointers_within_the_common_section_may_be_relative() {
    // A node of level 7, whose first child switches at its base; and a root, whose first child is that node,
    // three half-words back and 5 deeper. Their other children never switch.
    let common = vec![0, 0xfffe, 0xfffe_0001, 0x0503];
    let page = PageParts { root: 3, base: 10, words: Vec::new() };
    let tree = TreeParts { size: [512, 512, 64], common, pages: vec![page] }.tree().unwrap();
    let grid = overhead_grid([0.0; 3], tree.size());
    let bytes = encode(&ShadowFile::new(grid, settings_for(&grid), tree));
    let file = exercise(&bytes).unwrap();
    assert_eq!([31, 32].map(|i| file.tree.value(i, 31)), [15, NEVER]);
    assert_eq!([14, 15].map(|k| reference::voxel(&bytes, 0, [31, 31, k])), [1, 0]);
}

#[test]
fn invalid_vectors_give_their_errors() {
    let faulty = faulty_vectors("invalid");
    for vector in &faulty {
        let Err(Error::Format { source, .. }) = ShadowFile::read(&vector.path) else {
            panic!("{}: no format error", vector.path.display());
        };
        vector.check(source.kind(), source.fault(), &source.to_string());
        // Reading from memory and from a file must give the same error.
        assert_eq!(exercise(&fs::read(&vector.path).unwrap()).unwrap_err(), *source);
    }
    assert!(faulty.len() >= 50, "only {} faults", faulty.len());
}

#[test]
fn example_in_specification_matches_its_vector() {
    let example_in_text = specified_example("adumbra-file.md");
    assert_eq!(example_in_text.bytes, example());
    for (world, answer) in &example_in_text.answers {
        assert_eq!(reference::visibility(&example_in_text.bytes, *world).to_string(), *answer, "{world:?}");
    }
    assert_eq!(example_in_text.answers.len(), 8);
}

#[test]
fn coded_files_decode_to_the_same_words() {
    for (name, bytes) in raw() {
        let file = ShadowFile::from_bytes(&bytes).unwrap();
        let coded = file.to_bytes(Encoding::Coded).unwrap();
        assert_eq!(encoding(&coded), Encoding::Coded);
        let decoded = exercise(&coded).unwrap();
        assert_eq!(decoded, file, "{name}");
        assert_eq!(encode(&decoded), bytes, "{name}");
        assert_eq!(decoded.to_bytes(Encoding::Coded), Ok(coded), "{name}");
    }
}

#[test]
fn rejects_coding_of_words_that_decoder_would_not_restore() {
    // The example's page begins at byte 0x2d8 and has nine words. An unreferenced tenth word is valid.
    let mut bytes = example();
    bytes.extend([0; 4]);
    for (at, value) in [(0x220, 10_u32), (0x200, 232), (0x204, 232), (0x1d8, 232), (136, 768)] {
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
    }
    bytes[0] = b'@';
    let bytes = interpret(&bytes);
    let file = exercise(&bytes).unwrap();
    let error = file.to_bytes(Encoding::Coded).unwrap_err();
    assert_eq!((error.kind(), error.to_string().contains("bundle (0, 0)")), ("Uncodable", true), "{error}");
    let error = file.write_to(Cursor::new(Vec::new()), Encoding::Coded).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::InvalidData);
}

#[test]
fn settings_and_grid_round_trip_bit_for_bit() {
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
        file.grid.corner = [0.1 + f64::from(bits), -1e15, 5e-324];
        assert_eq!(exercise(&encode(&file)).unwrap(), file);
    }
}

#[test]
fn truncation_at_every_length_is_an_error() {
    for (name, bytes) in valid() {
        // Every length of the small files, and some of the others.
        let step = 1 + bytes.len() / 1024;
        for length in (0..bytes.len()).step_by(step) {
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

/// Compares some voxels of an accepted file with the reference, spread over its columns and near where they
/// switch.
fn agrees_with_the_reference(file: &ShadowFile, bytes: &[u8], seed: u64) {
    let size = file.grid.size;
    for at in 0..24 {
        let spread =
            |a: u64| (seed.wrapping_add(at * 7 + a).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32) as u32;
        let [i, j] = [0, 1].map(|a| spread(a as u64) % size[a]);
        let k = file.tree.value(i, j).wrapping_sub(at as u32 & 1).min(size[2] - 1);
        let expected = reference::voxel(bytes, 0, [i, j, k]) == 1;
        assert_eq!(file.tree.voxel(i, j, k), expected, "seed {seed}: ({i}, {j}, {k})");
    }
}

/// Damages files. Returns how many are still accepted, and the faults of the others with how often they are
/// found.
fn damage(count: u64) -> (u32, BTreeMap<&'static str, u32>) {
    let coded = raw().into_iter().map(|(name, bytes)| {
        let file = ShadowFile::from_bytes(&bytes).expect("a valid vector");
        (format!("{name}, coded"), file.to_bytes(Encoding::Coded).expect("a file of a writer"))
    });
    let all: Vec<_> = raw().into_iter().chain(coded).collect();
    count_faults(&all, count, |bytes, seed| {
        let mutated = mutate(bytes, seed);
        let file = exercise(&mutated).map_err(|error| error.fault().unwrap_or(error.kind()))?;
        agrees_with_the_reference(&file, &encode(&file), seed);
        Ok(())
    })
}

#[test]
fn a_few_mutations_are_refused_or_answer_everywhere() {
    let (accepted, _) = damage(6000);
    assert!(accepted > 150, "{accepted} accepted");
}

#[test]
#[ignore = "slow: thousands of damaged files"]
fn mutations_are_refused_or_answer_everywhere() {
    let (accepted, faults) = damage(150_000);
    // The mutations reach every check, and also produce quadtrees that are still valid.
    assert!(accepted > 3750, "{accepted} accepted");
    assert_faults_found(&faults, &["Bundle", "Coded", "Root", "Order", "End", "Bits", "Overlap", "Ranks"]);
}

#[test]
fn fuzz_input_with_even_first_byte_gets_valid_checksums() {
    let mut input = example();
    assert_eq!(interpret(&input), example());
    input[0] = b'@';
    input[20] = 99;
    assert_eq!(exercise(&interpret(&input)).unwrap().settings.resolution, 99);
    assert_eq!(exercise(&interpret(&[])).unwrap_err().kind(), "Truncated");
}

/// A file of at most `room` bytes, after which the disk is full.
struct FullDisk {
    room: u64,
    file: Cursor<Vec<u8>>,
}

impl Seek for FullDisk {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

impl Write for FullDisk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let left = self.room.saturating_sub(self.file.position());
        let taken = bytes.len().min(left as usize);
        if taken == 0 && !bytes.is_empty() {
            return Err(ErrorKind::StorageFull.into());
        }
        self.file.write(&bytes[..taken])
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn failing_writer_is_an_error_after_any_byte() {
    for (_, bytes) in valid() {
        let file = ShadowFile::from_bytes(&bytes).unwrap();
        let write = |room: usize| {
            let mut disk = FullDisk { room: room as u64, file: Cursor::default() };
            file.write_to(&mut disk, encoding(&bytes)).map(|length| (length, disk.file.into_inner()))
        };
        // Coding takes longer than writing.
        let rooms = if encoding(&bytes) == Encoding::Raw { 1024 } else { 16 };
        for room in (0..bytes.len()).step_by(1 + bytes.len() / rooms) {
            assert_eq!(write(room).unwrap_err().kind(), ErrorKind::StorageFull);
        }
        assert_eq!(write(bytes.len()).unwrap(), (bytes.len() as u64, bytes));
    }
}

#[test]
fn writes_file_at_current_position_of_output() {
    let file = ShadowFile::from_bytes(&example()).unwrap();
    let mut out = Cursor::new(b"before".to_vec());
    out.set_position(6);
    file.write_to(&mut out, Encoding::Raw).unwrap();
    assert_eq!(out.position() as usize, out.get_ref().len());
    assert_eq!(out.into_inner(), [b"before".as_slice(), &example()].concat());
}

#[test]
fn rejects_writing_a_file_that_could_not_be_read() {
    let file = ShadowFile::from_bytes(&example()).unwrap();
    let tree = || (*file.tree).clone();
    let mut grids = [file.grid; 3];
    grids[0].size[2] += 1;
    grids[1].voxel_size = f64::NAN;
    grids[2].corner[1] = f64::INFINITY;
    let mut settings = file.settings;
    settings.resolution = 0;
    let level_of_one_size =
        ShadowFile::new(file.grid, file.settings, tree()).with_coarser([(file.grid, tree())]);
    let wrong = grids.map(|grid| ShadowFile::new(grid, file.settings, tree()));
    let all = wrong.into_iter().chain([ShadowFile::new(file.grid, settings, tree()), level_of_one_size]);
    for (i, wrong) in all.enumerate() {
        let mut written = Cursor::new(Vec::new());
        let error = wrong.write_to(&mut written, Encoding::Coded).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::InvalidData, "{i}: {error}");
        assert_eq!(wrong.to_bytes(Encoding::Raw).unwrap_err().kind(), "HeaderField", "{i}");
    }
}

#[test]
fn read_error_names_the_path() {
    let folder = vectors("valid");
    for path in [folder.clone(), folder.join("missing")] {
        let Err(Error::Io(IoError { action: "read", path: named, .. })) = ShadowFile::read(&path) else {
            panic!("{}", path.display());
        };
        assert_eq!(named, path);
    }
}
