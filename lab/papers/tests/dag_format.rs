//! Tests of the graph file with `test_vectors/dag/` and with damaged files. For any bytes, reading must
//! return either a file in which every voxel can be looked up, or an error that names the fault. Writing an
//! invalid file must be an error.

#[path = "dag_format_support/mod.rs"]
mod dag_format_support;
#[path = "dag_format_support/reference.rs"]
mod reference;

use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use adumbra::{Bounds, FormatError, Frame, IoError, Receivers, ShadowFile, Sun};
use adumbra_papers::SectionFault;
use adumbra_papers::dag::plain::LIT;
use adumbra_papers::dag::{DagBody, DagFile, DagFileError, DagLayout, Error};
use adumbra_testing::{
    assert_faults_found, count_faults, expected_points, faulty_vectors, named_vectors, specified_example,
    vector_answers, vectors,
};
use dag_format_support::{LAYOUT, encode, exercise, is_lit, sweep};

/// Returns name and bytes of every valid vector, sorted by name.
fn valid() -> Vec<(String, Vec<u8>)> {
    named_vectors("dag/valid", 29)
}

fn vector(name: &str) -> Vec<u8> {
    fs::read(vectors("dag/valid").join(format!("{name}.adumbra"))).expect("the vector")
}

/// Reads a file that must not be valid, and returns the fault.
fn fault(path: &Path) -> DagFileError {
    match DagFile::read(path) {
        Err(Error::Format { source, .. }) => *source,
        other => panic!("{}: {other:?}", path.display()),
    }
}

#[test]
fn dag_valid_vectors_give_expected_answers() {
    let mut layouts = [0; 2];
    for (name, bytes) in valid() {
        let file = exercise(&bytes).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(file.body.layout() == DagLayout::Packed, name.ends_with("_packed"), "{name}");
        layouts[usize::from(file.body.layout() == DagLayout::Packed)] += 1;
        for point in expected_points(&vector_answers("dag/valid", &name)) {
            let (expected, what) = (point.visibility, point.all);
            assert_eq!(u64::from(reference::visibility(&bytes, point.world)), expected, "{name}: {what}");
            let at = file.grid.to_grid(point.world);
            if (0..3).all(|a| at[a] >= 0.0 && at[a] < f64::from(file.grid.size[a])) {
                let lit = is_lit(&file, at.map(|c| c.floor() as u32));
                assert_eq!(u64::from(lit), expected, "{name}: {what}");
            }
        }
    }
    assert_eq!(layouts, [16, 14]);
}

#[test]
fn dag_agrees_with_the_reference_on_every_voxel() {
    for (name, bytes) in valid() {
        let file = DagFile::from_bytes(&bytes).unwrap();
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
fn dag_invalid_vectors_give_expected_errors() {
    let faulty = faulty_vectors("dag/invalid");
    for vector in &faulty {
        let fault = fault(&vector.path);
        vector.check(fault.kind(), fault.fault(), &fault.to_string());
        // Reading from memory and from a file must give the same error.
        let bytes = fs::read(&vector.path).unwrap();
        assert_eq!(exercise(&bytes).unwrap_err().to_string(), fault.to_string());
    }
    assert!(faulty.len() >= 70, "only {} faults", faulty.len());
}

#[test]
fn dag_example_in_specification_matches_vector() {
    let example = specified_example("adumbra-dag.md");
    assert_eq!(example.bytes, vector("example_8"));
    for (world, answer) in &example.answers {
        for bytes in [&example.bytes, &vector("example_8_packed")] {
            assert_eq!(reference::visibility(bytes, *world).to_string(), *answer, "{world:?}");
        }
    }
    assert_eq!(example.answers.len(), 8);
}

#[test]
fn dag_settings_and_grid_round_trip_bit_for_bit() {
    for layout in ["example_8", "example_8_packed"] {
        let mut file = DagFile::from_bytes(&vector(layout)).unwrap();
        let sun = Sun::from_direction([0.3, 0.6, -0.2]).unwrap();
        for bits in 0..16_u32 {
            let s = &mut file.settings;
            (s.assume_ground, s.closed_regions, s.ignore_alpha) =
                (bits & 1 != 0, bits & 2 != 0, bits & 4 != 0);
            s.receivers = if bits & 8 != 0 { Receivers::Static } else { Receivers::All };
            let bounds = Bounds { min: [-1.5, -0.0, 1e-300], max: [0.1, 2.5, 1e300] };
            s.bounds = (bits % 3 == 0).then_some(bounds);
            (s.resolution, s.triangles, s.instances) = (1 << bits, u64::MAX - u64::from(bits), 3 << 40);
            s.switch_within_voxels = bits;
            s.thickness_world = 0.1 * f64::from(bits);
            (s.bias.slope_texels, s.bias.normal_offset_texels) = (1.0 / 3.0, 0.7);
            if bits % 5 == 0 {
                let frame = Frame::Oblique { yaw_radians: 0.1 * f64::from(bits) - 0.7 };
                let axes = frame.axes(&sun);
                (file.grid.sun, file.grid.frame, file.grid.axes) = (sun, frame, axes);
                file.grid.edges = frame.edges(&sun, &axes);
            }
            file.grid.corner = [0.1 + f64::from(bits), -1e15, 5e-324];
            assert_eq!(exercise(&encode(&file)).unwrap(), file);
        }
    }
}

#[test]
fn dag_truncation_at_every_length_is_an_error() {
    for (name, bytes) in valid() {
        for length in 0..bytes.len() {
            let error = exercise(&bytes[..length]).expect_err(&name);
            assert_eq!(error.kind(), "Truncated", "{name} at {length}: {error}");
        }
    }
}

#[test]
fn dag_every_flipped_bit_is_an_error() {
    for name in ["example_8", "example_8_packed"] {
        let valid = vector(name);
        for (at, bit) in (0..valid.len()).flat_map(|at| (0..8).map(move |bit| (at, bit))) {
            let mut bytes = valid.clone();
            bytes[at] ^= 1 << bit;
            assert!(exercise(&bytes).is_err(), "{name}: byte {at} bit {bit}");
        }
    }
}

/// Compares some voxels of an accepted file with the reference, spread over the grid.
fn agrees_with_the_reference(file: &DagFile, bytes: &[u8], seed: u64) {
    for at in 0..24 {
        let spread =
            |a: u64| (seed.wrapping_add(at * 7 + a).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32) as u32;
        let v = [0, 1, 2].map(|a| spread(a as u64) % file.grid.size[a]);
        let expected = reference::voxel(bytes, v) == 1;
        assert_eq!(is_lit(file, v), expected, "seed {seed}: {v:?}");
    }
}

#[test]
#[ignore = "slow: thousands of damaged files"]
fn dag_mutated_files_are_rejected_or_answer_everywhere() {
    let (accepted, faults) = count_faults(&valid(), 200_000, |bytes, seed| {
        let mutated = LAYOUT.mutate(bytes, seed);
        let file = exercise(&mutated).map_err(|error| error.fault().unwrap_or(error.kind()))?;
        agrees_with_the_reference(&file, &mutated, seed);
        Ok(())
    });
    // The mutations reach every check, and also produce graphs that are still valid.
    assert!(accepted > 10_000, "{accepted} accepted");
    assert_faults_found(
        &faults,
        &[
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
            "LeafMaskRange",
            "LeafMasks",
            "Pointer",
            "Unreached",
        ],
    );
}

#[test]
fn dag_fuzz_input_with_even_first_byte_gets_valid_checksums() {
    let mut input = vector("example_8");
    assert_eq!(LAYOUT.interpret(&input), input);
    input[0] = b'@';
    input[20] = 99;
    assert_eq!(exercise(&LAYOUT.interpret(&input)).unwrap().settings.resolution, 99);
    assert_eq!(exercise(&LAYOUT.interpret(&[])).unwrap_err().kind(), "Truncated");
}

#[test]
fn dag_invalid_file_is_not_written() {
    let breaks: [&dyn Fn(&mut DagFile); 3] = [
        &|file| match &mut file.body {
            DagBody::Plain(dag) => dag.nodes.push(LIT),
            DagBody::Packed(packed) => packed.units.push(1),
        },
        &|file| file.grid.size[2] += 1,
        &|file| file.grid.voxel_size = f64::NAN,
    ];
    for name in ["example_8", "example_8_packed"] {
        for (i, change) in breaks.iter().enumerate() {
            let mut file = DagFile::from_bytes(&vector(name)).unwrap();
            change(&mut file);
            let mut written = Vec::new();
            let error = file.write_to(&mut written).unwrap_err();
            assert_eq!((error.kind(), written.len()), (ErrorKind::InvalidData, 0), "{name}, {i}: {error}");
        }
    }
}

#[test]
fn dag_and_shadow_files_are_distinguished() {
    let (shadow, graph) = (vectors("valid/example_8_depths.adumbra"), vectors("dag/valid/example_8.adumbra"));
    assert!(DagFile::is_one(&graph).unwrap() && !DagFile::is_one(&shadow).unwrap());
    let fault = fault(&shadow);
    assert!(
        matches!(fault, DagFileError::Sections(SectionFault::Format(FormatError::OtherKind { .. }))),
        "{fault}"
    );
    let error = ShadowFile::read(&graph).unwrap_err().to_string();
    assert!(error.contains("not a shadow file: it begins with \"ADUMDAG\\n\""), "{error}");
    let missing = vectors("dag/valid/missing");
    assert!(matches!(DagFile::is_one(&missing), Err(Error::Io(IoError { action: "read", .. }))));
    let error = DagFile::read(&missing).unwrap_err().to_string();
    assert!(error.contains("cannot read") && error.contains("missing"), "{error}");
}
