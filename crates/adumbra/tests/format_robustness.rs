//! Tests of the file format with `test_vectors/` and with damaged files. For any bytes, reading must return either a
//! file in which every voxel can be looked up, or an error that names the fault. Writing an invalid file must be an
//! error.

#[path = "format_support/mod.rs"]
mod format_support;
#[path = "format_support/reference.rs"]
mod reference;

use std::fs;
use std::io::{self, ErrorKind, Write};

use adumbra::file::VERSION;
use adumbra::layout::depths::DepthTree;
use adumbra::{Bounds, Error, Frame, IoError, Receivers, ShadowFile};
use adumbra_testing::{
    assert_faults_found, count_faults, expected_points, faulty_vectors, named_vectors, specified_example,
    vector_answers, vectors,
};
use format_support::{LAYOUT, encode, exercise, sweep};

/// Returns name and bytes of every valid vector, sorted by name.
fn valid() -> Vec<(String, Vec<u8>)> {
    named_vectors("valid", 10)
}

fn example() -> Vec<u8> {
    fs::read(vectors("valid/example_8_depths.adumbra")).expect("the example")
}

#[test]
fn valid_vectors_give_their_answers() {
    give_their_answers("valid");
}

#[test]
fn earlier_version_is_read_and_written_as_the_latest() {
    give_their_answers("valid_v2");
    for (name, bytes) in named_vectors("valid_v2", 10) {
        let file = ShadowFile::from_bytes(&bytes).unwrap();
        assert_eq!((u32::from(bytes[8]), u32::from(encode(&file)[8])), (2, VERSION), "{name}");
        assert_eq!(file.grid.frame, Frame::Light, "{name}");
    }
}

fn give_their_answers(folder: &str) {
    for (name, bytes) in named_vectors(folder, 10) {
        let file = exercise(&bytes).unwrap_or_else(|e| panic!("{name}: {e}"));
        for point in expected_points(&vector_answers(folder, &name)) {
            let (expected, what) = (point.visibility, point.all);
            assert_eq!(u64::from(reference::visibility(&bytes, point.world)), expected, "{name}: {what}");
            let at = file.grid.to_grid(point.world);
            if (0..3).all(|a| at[a] >= 0.0 && at[a] < f64::from(file.grid.size[a])) {
                let [i, j, k] = at.map(|c| c.floor() as u32);
                assert_eq!(u64::from(file.tree.voxel(i, j, k)), expected, "{name}: {what}");
            }
        }
    }
}

#[test]
fn decoded_quadtree_agrees_with_the_reference_on_every_voxel() {
    for (name, bytes) in valid() {
        let file = ShadowFile::from_bytes(&bytes).unwrap();
        let size = file.grid.size;
        let mut lit = 0;
        for z in 0..size[2] {
            for y in 0..size[1] {
                for x in 0..size[0] {
                    let expected = reference::voxel(&bytes, [x, y, z]) == 1;
                    assert_eq!(file.tree.voxel(x, y, z), expected, "{name} ({x}, {y}, {z})");
                    lit += u64::from(expected);
                }
            }
        }
        assert_eq!(sweep(&file, u64::MAX), lit, "{name}");
    }
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
fn specification_shows_the_example_as_it_is() {
    let example_in_text = specified_example("adumbra-file.md");
    assert_eq!(example_in_text.bytes, example());
    for (world, answer) in &example_in_text.answers {
        assert_eq!(reference::visibility(&example_in_text.bytes, *world).to_string(), *answer, "{world:?}");
    }
    assert_eq!(example_in_text.answers.len(), 8);
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
        file.grid.corner = [0.1 + f64::from(bits), -1e15, 5e-324];
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

/// Compares some voxels of an accepted file with the reference, spread over its columns and near where they switch.
fn agrees_with_the_reference(file: &ShadowFile, bytes: &[u8], seed: u64) {
    let size = file.grid.size;
    for at in 0..24 {
        let spread =
            |a: u64| (seed.wrapping_add(at * 7 + a).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32) as u32;
        let [i, j] = [0, 1].map(|a| spread(a as u64) % size[a]);
        let k = file.tree.value(i, j).wrapping_sub(at as u32 & 1).min(size[2] - 1);
        let expected = reference::voxel(bytes, [i, j, k]) == 1;
        assert_eq!(file.tree.voxel(i, j, k), expected, "seed {seed}: ({i}, {j}, {k})");
    }
}

#[test]
#[ignore = "slow: thousands of damaged files"]
fn mutations_are_refused_or_answer_everywhere() {
    let (accepted, faults) = count_faults(&valid(), 200_000, |bytes, seed| {
        let mutated = LAYOUT.mutate(bytes, seed);
        let file = exercise(&mutated).map_err(|error| error.fault().unwrap_or(error.kind()))?;
        agrees_with_the_reference(&file, &mutated, seed);
        Ok(())
    });
    // The mutations reach every check, and also produce quadtrees that are still valid.
    assert!(accepted > 10_000, "{accepted} accepted");
    assert_faults_found(&faults, &["Layout", "RootLevel", "Order", "End", "Wide", "Bits", "Ranks"]);
}

#[test]
fn fuzz_input_of_even_first_byte_gets_its_checksums() {
    let mut input = example();
    assert_eq!(LAYOUT.interpret(&input), example());
    input[0] = b'@';
    input[20] = 99;
    assert_eq!(exercise(&LAYOUT.interpret(&input)).unwrap().settings.resolution, 99);
    assert_eq!(exercise(&LAYOUT.interpret(&[])).unwrap_err().kind(), "Truncated");
}

/// A writer that accepts `room` bytes and then reports that the disk is full.
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
fn invalid_file_is_not_written() {
    let file = ShadowFile::from_bytes(&example()).unwrap();
    let breaks: [&dyn Fn(&mut DepthTree); 3] = [
        // No shape begins at the end of the code.
        &|tree| tree.top[0] = [2 * tree.code.len() as u32, 0],
        &|tree| tree.root_level = 6,
        &|tree| tree.size[2] += 1,
    ];
    for (i, change) in breaks.into_iter().enumerate() {
        let mut tree = (*file.tree).clone();
        change(&mut tree);
        let mut written = Vec::new();
        let error = ShadowFile::new(file.grid, file.settings, tree).write_to(&mut written).unwrap_err();
        assert_eq!((error.kind(), written.len()), (ErrorKind::InvalidData, 0), "{i}: {error}");
    }
}

#[test]
fn read_says_what_is_wrong_with_the_path() {
    let folder = vectors("valid");
    for path in [folder.clone(), folder.join("missing")] {
        let Err(Error::Io(IoError { action: "read", path: named, .. })) = ShadowFile::read(&path) else {
            panic!("{}", path.display());
        };
        assert_eq!(named, path);
    }
}
