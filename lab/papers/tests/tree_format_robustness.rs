//! Tests the tree file with `test_vectors/tree/` and with damaged bytes: any input gives either a file that
//! can be looked up everywhere or an error that names the fault.

#[path = "tree_format_support/reference.rs"]
mod reference;
#[path = "tree_format_support/mod.rs"]
mod tree_format_support;

use std::collections::BTreeMap;
use std::fs;
use std::io::ErrorKind;

use adumbra::{Bounds, FormatError, IoError, ShadowFile};
use adumbra_files::replace_file;
use adumbra_papers::SectionFault;
use adumbra_papers::tree::symmetric::SymmetricTree;
use adumbra_papers::tree::{
    AttributeKind, Blocks, Error, LossyChange, Node, Region, Regions, TREE_HEADER_BYTES, TreeBody, TreeFile,
    TreeFileError, VoxelTree, Word, leaf_voxels,
};
use adumbra_testing::{
    EarlierFile, ExpectedPoint, assert_faults_found, count_faults, expected_points, faulty_vectors,
    named_vectors, specified_example, vector_answers, vectors,
};
use tree_format_support::{LAYOUT, exercise, sweep};

/// Returns name and bytes of every valid vector, sorted by name.
fn valid() -> Vec<(String, Vec<u8>)> {
    named_vectors("tree/valid", 13)
}

/// Returns name and bytes of every vector with a symmetric body, sorted by name.
fn symmetric() -> Vec<(String, Vec<u8>)> {
    named_vectors("tree/symmetric", 20)
}

fn vector(name: &str) -> Vec<u8> {
    fs::read(vectors("tree/valid").join(format!("{name}.adumbra"))).expect("the vector")
}

fn file(name: &str) -> TreeFile {
    TreeFile::from_bytes(&vector(name)).expect("a valid file")
}

fn words(file: &TreeFile) -> &VoxelTree {
    match &file.body {
        TreeBody::Words(tree) => tree,
        TreeBody::Symmetric(_) => panic!("no words"),
    }
}

#[test]
fn tree_valid_vectors_give_expected_answers() {
    let (mut bytes_of_attribute, mut none) = (0, 0);
    for (name, bytes) in valid() {
        let file = exercise(&bytes).unwrap_or_else(|e| panic!("{name}: {e}"));
        let answers = vector_answers("tree/valid", &name);
        assert_eq!(answers["leaf_voxels"].as_u64(), Some(leaf_voxels(words(&file))), "{name}");
        assert_eq!(
            reference::leaf_voxels(&bytes, reference::root(&bytes)),
            leaf_voxels(words(&file)),
            "{name}"
        );
        for ExpectedPoint { world, visibility: expected, all: point } in expected_points(&answers) {
            assert_eq!(u64::from(reference::visibility(&bytes, world)), expected, "{name}: {point}");
            let Some(voxel) = reference::voxel_of(&bytes, world) else { continue };
            assert_eq!(file.space.to_tree(world).map(|c| c.floor() as u32), voxel, "{name}: {point}");
            assert_eq!(u64::from(words(&file).voxel(voxel)), expected, "{name}: {point}");
            let byte = reference::voxel(&bytes, voxel).1;
            assert_eq!(byte.map(u64::from), point["attribute"].as_u64(), "{name}: {point}");
            if point.get("attribute").is_some() {
                *(if byte.is_some() { &mut bytes_of_attribute } else { &mut none }) += 1;
            }
        }
    }
    assert!(bytes_of_attribute > 10 && none > 3, "{bytes_of_attribute} bytes, {none} without");
}

#[test]
fn tree_agrees_with_the_reference_on_every_voxel() {
    for (name, bytes) in valid() {
        let file = TreeFile::from_bytes(&bytes).unwrap();
        let (tree, side) = (words(&file), words(&file).side());
        if side > 64 {
            continue;
        }
        let mut lit = 0;
        for i in 0..side.pow(3) {
            let v = [i % side, i / side % side, i / side / side];
            let expected = reference::voxel(&bytes, v).0 == 1;
            assert_eq!(tree.voxel(v), expected, "{name} {v:?}");
            lit += u64::from(expected);
        }
        assert_eq!(sweep(tree, side, u64::MAX), lit, "{name}");
    }
}

/// Compares every voxel of cubes up to 64 a side, as read by the library, by a reader made from the
/// specification, and from words.
#[test]
fn tree_symmetric_vectors_match_words() {
    for (name, bytes) in symmetric() {
        let symmetric = exercise(&bytes).unwrap_or_else(|e| panic!("{name}: {e}"));
        let TreeBody::Symmetric(tree) = &symmetric.body else { panic!("{name}: words") };
        let (name, kind) = name.rsplit_once('-').unwrap();
        assert_eq!(tree.mirrors(), kind == "mirrors");
        let file = file(name);
        // For larger cubes, a few hundred thousand voxels spread over the cube.
        let side = u64::from(words(&file).side());
        let step = (side.pow(3) / (1 << 18)).max(1);
        for i in (0..side.pow(3)).step_by(step as usize) {
            let v = [i % side, i / side % side, i / side / side].map(|c| c as u32);
            let expected = words(&file).voxel(v);
            assert_eq!(tree.voxel(v), expected, "{name} {v:?}");
            assert_eq!(reference::symmetric_voxel(&bytes, v) == 1, expected, "{name} {v:?}");
        }
    }
}

#[test]
fn tree_invalid_vectors_give_expected_errors() {
    let mut seen = BTreeMap::new();
    for vector in faulty_vectors("tree/invalid") {
        let Err(Error::Format { source, .. }) = TreeFile::read(&vector.path) else {
            panic!("{}: no format error", vector.path.display());
        };
        vector.check(source.kind(), source.fault(), &source.to_string());
        // The bytes and the file give the same error.
        assert_eq!(exercise(&fs::read(&vector.path).unwrap()).unwrap_err(), *source);
        *seen.entry(source.fault().unwrap_or(source.kind())).or_insert(0) += 1;
    }
    assert_eq!(seen.values().sum::<i32>(), 69, "{seen:?}");
    assert_eq!(seen.len(), 17, "one kind has no vector: {seen:?}");
}

#[test]
fn tree_example_in_specification_matches_vector() {
    let example = specified_example("adumbra-tree.md");
    assert_eq!(example.bytes, vector("example_8"));
    for (world, answer) in &example.answers {
        assert_eq!(reference::visibility(&example.bytes, *world).to_string(), *answer, "{world:?}");
    }
    assert_eq!(example.answers.len(), 6);
}

#[test]
fn tree_settings_and_space_round_trip_bit_for_bit() {
    let mut file = file("example_8");
    for bits in 0..16_u32 {
        let s = &mut file.settings;
        (s.closed_regions, s.ignore_alpha) = (bits & 1 != 0, bits & 2 != 0);
        s.bounds = (bits & 4 != 0).then_some(Bounds { min: [-1.5, -0.0, 1e-300], max: [0.1, 2.5, 1e300] });
        let changed_voxels = u64::from(bits);
        s.lossy =
            (bits & 8 != 0).then_some(LossyChange { max_share: 0.1, leaf_voxels: u64::MAX, changed_voxels });
        (s.triangles, s.instances) = (u64::MAX - u64::from(bits), 3 << 40);
        (s.capture_bias.constant_texels, s.capture_bias.slope_texels) = (0.1 * f64::from(bits), 1.0 / 3.0);
        (s.bias.slope_texels, s.bias.normal_offset_texels) = (1.0 / 7.0, -0.0);
        (file.space.p_min, file.space.voxel_size) = ([0.1 + f64::from(bits), -1e15, 5e-324], 1e-3);
        let region = Region { x: [-1e300, 0.1], z: [-0.0, f64::from(bits) + 5e-324], depth: 1 + bits % 3 };
        file.regions = Regions { base_depth: 3, list: vec![region; bits as usize * 17] };
        assert_eq!(exercise(&file.encode()).unwrap(), file);
    }
}

#[test]
fn tree_truncation_at_every_length_is_an_error() {
    for (name, bytes) in valid() {
        for length in 0..bytes.len() {
            let error = exercise(&bytes[..length]).expect_err(&name);
            assert_eq!(error.kind(), "Truncated", "{name} at {length}: {error}");
        }
    }
}

#[test]
fn tree_every_changed_byte_is_an_error() {
    for name in ["example_8", "regions", "penumbra"] {
        let valid = vector(name);
        for at in 0..valid.len() {
            for other in 1..=255 {
                let mut bytes = valid.clone();
                bytes[at] ^= other;
                assert!(TreeFile::from_bytes(&bytes).is_err(), "{name} byte {at} xor {other}");
            }
        }
    }
}

#[test]
fn tree_mutated_files_are_rejected_or_answer_everywhere() {
    let seeds = [valid(), symmetric()].concat();
    let (accepted, faults) = count_faults(&seeds, 100_000, |bytes, seed| {
        let read = exercise(&LAYOUT.mutate(bytes, seed));
        read.map(drop).map_err(|error| error.fault().unwrap_or(error.kind()))
    });
    // The mutations reach every check, and some of the trees remain valid.
    assert!(accepted > 5_000, "{accepted} accepted");
    assert_faults_found(
        &faults,
        &[
            "Padding",
            "Region",
            "Length",
            "Word",
            "Index",
            "Order",
            "TooDeep",
            "NotMerged",
            "Flags",
            "Root",
            "Cut",
            "Mask",
            "Pointer",
            "Unreached",
        ],
    );
}

#[test]
fn tree_fuzz_input_with_even_first_byte_gets_valid_checksums() {
    let mut input = vector("example_8");
    assert_eq!(LAYOUT.interpret(&input), input);
    input[0] = b'@';
    input[208] = 99;
    assert_eq!(exercise(&LAYOUT.interpret(&input)).unwrap().settings.triangles, 99);
    assert_eq!(exercise(&LAYOUT.interpret(&[])).unwrap_err().kind(), "Truncated");
}

#[test]
fn tree_symmetric_body_round_trips() {
    let mut file = file("regions");
    let TreeBody::Words(tree) = &file.body else { panic!("the vector holds words") };
    let tree = tree.clone();
    for mirrors in [false, true] {
        file.body = TreeBody::Symmetric(SymmetricTree::of(&tree, mirrors).unwrap());
        assert_eq!(exercise(&file.encode()).unwrap(), file);
    }
    assert_eq!(file.without_words(), None);
    (file.attribute, file.attribute_kind) = (vec![0], Some(AttributeKind::Penumbra));
    assert_eq!(exercise(&file.encode()).unwrap_err(), file.check().unwrap_err());
    assert_eq!(file.check().unwrap_err().kind(), "HeaderField");
}

#[test]
fn tree_words_stored_separately_restore_the_file() {
    let file = file("penumbra");
    let (rest, tree) = (file.without_words().unwrap(), words(&file).words().to_vec());
    assert_eq!(rest.len() + tree.len() * 4, file.encode().len());
    assert_eq!(TreeFile::with_words(&rest, &tree).unwrap(), file);
    let kind = |rest: &[u8], words: &[u32]| TreeFile::with_words(rest, words).unwrap_err().kind();
    let mut other = tree.clone();
    other[3] ^= 1;
    assert_eq!(kind(&rest, &other), "SectionChecksum");
    assert_eq!(kind(&rest, &tree[1..]), "SectionBounds");
    assert_eq!(kind(&rest, &[]), "SectionBounds");
    assert_eq!(kind(&file.encode(), &tree), "Padding", "the words twice");
    for length in 0..rest.len() {
        assert_eq!(kind(&rest[..length], &tree), "Truncated", "{length}");
    }
}

#[test]
fn tree_and_light_files_are_distinguished() {
    let light = vectors("valid/example_8_depths.adumbra");
    let tree = vectors("tree/valid/example_8.adumbra");
    assert!(TreeFile::is_one(&tree).unwrap() && !TreeFile::is_one(&light).unwrap());
    let other_kind = |error: &FormatError| matches!(error, FormatError::OtherKind { .. });
    let error = ShadowFile::read(&tree).unwrap_err().to_string();
    assert!(error.contains("not a shadow file: it begins with \"ADUMTREE\""), "{error}");
    let error = TreeFile::read(&light).unwrap_err();
    let Error::Format { source, .. } = &error else { panic!("{error}") };
    assert!(
        matches!(&**source, TreeFileError::Sections(SectionFault::Format(fault)) if other_kind(fault)),
        "{error}"
    );
    let found = "this is a light-aligned shadow file, but a tree file is needed";
    assert!(error.to_string().contains(found), "{error}");
    let picture = TreeFile::from_bytes(b"GIF89a\0\0").unwrap_err();
    assert!(picture.to_string().contains("instead of \"ADUMTREE\";"), "{picture}");
    let mut long = fs::read(&tree).unwrap();
    long.push(0);
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("missing");
    for error in [TreeFile::is_one(&missing).map(drop), TreeFile::read(&missing).map(drop)] {
        assert!(matches!(error, Err(Error::Io(IoError { action: "read", .. }))), "{error:?}");
    }
    let path = folder.path().join("long.adumbra");
    fs::write(&path, long).unwrap();
    let error = TreeFile::read(&path).unwrap_err();
    let Error::Format { source, .. } = error else { panic!("{error:?}") };
    assert_eq!(source.kind(), "TrailingBytes");
}

#[test]
fn tree_written_file_reads_back_and_replaces_the_earlier_one() {
    let output = EarlierFile::new();
    let file = file("penumbra");
    let written = replace_file(output.path(), |out| file.write_to(out)).unwrap();
    assert_eq!(written, vector("penumbra").len() as u64);
    output.assert_replaced_by(&vector("penumbra"));
    assert_eq!(TreeFile::read(output.path()).unwrap(), file);
}

/// Tries to write invalid contents: the write is refused, the earlier output remains, and the reader refuses
/// the encoded bytes too.
#[test]
fn tree_refused_write_leaves_the_earlier_output() {
    let output = EarlierFile::new();
    let region = Region { x: [0.0, 1.0], z: [0.0, f64::NAN], depth: 3 };
    let cycle = Blocks { root: Word::new(Node::Inner(0)), blocks: vec![[Word::new(Node::Inner(0)); 8]] };
    let breaks: [&dyn Fn(&mut TreeFile); 9] = [
        &|f| f.space.p_min[1] = f64::INFINITY,
        &|f| f.settings.bias.constant_texels = f64::NAN,
        &|f| f.regions.list.push(region),
        &|f| f.regions.list = vec![Region { z: [0.0, 1.0], ..region }; 257],
        &|f| f.regions.base_depth = 2,
        &|f| f.attribute.push(7),
        &|f| f.attribute_kind = Some(AttributeKind::Penumbra),
        &|f| (f.attribute, f.attribute_kind) = (vec![1; 63], Some(AttributeKind::Penumbra)),
        &|f| f.body = TreeBody::Words(cycle.number(3)),
    ];
    let refused =
        |file: &TreeFile| replace_file(output.path(), |out| file.write_to(out)).unwrap_err().source.kind();
    for (i, change) in breaks.into_iter().enumerate() {
        let mut file = file("example_8");
        change(&mut file);
        assert_eq!(refused(&file), ErrorKind::InvalidData, "{i}");
        assert!(TreeFile::from_bytes(&file.encode()).is_err(), "{i}");
    }
    // Depths that differ: the bytes are those of another file.
    let mut file = file("all_lit");
    (file.space.depth, file.regions.base_depth) = (2, 2);
    assert_eq!(refused(&file), ErrorKind::InvalidData);
    output.assert_kept();
}

#[test]
fn tree_header_with_huge_size_allocates_nothing() {
    // The reader refuses a declared body of 8 GiB because the file is shorter.
    let mut bytes = vector("example_8");
    bytes[248 + 8..][..8].copy_from_slice(&(4_u64 << 31).to_le_bytes());
    bytes[272..][..8].copy_from_slice(&((4_u64 << 31) + 320).to_le_bytes());
    bytes[0] = b'@';
    let error = exercise(&LAYOUT.interpret(&bytes)).unwrap_err();
    let is_body = matches!(&error, TreeFileError::Sections(SectionFault::Format(FormatError::Truncated { what, .. })) if what == "body");
    assert!(is_body, "{error}");
    assert_eq!(TREE_HEADER_BYTES, 320);
}
