//! The tree file against `test_vectors/tree/` and against damage: whatever bytes are read, the answer is a file that
//! can be looked up everywhere or an error that names the fault.

#[path = "tree_format_support/reference.rs"]
mod reference;
#[path = "tree_format_support/mod.rs"]
mod tree_format_support;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use adumbra::Error;
use adumbra::format::tree::TREE_HEADER_BYTES;
use adumbra::format::{AnyFile, AttributeKind, FormatError, ShadowFile, TreeBody, TreeFile};
use adumbra::scene::Bounds;
use adumbra::tree::symmetric::SymmetricTree;
use adumbra::tree::{Blocks, LossyChange, Node, Region, Regions, VoxelTree, Word, leaf_voxels};
use serde_json::Value;
use tree_format_support::{Mutator, exercise, interpret, sweep};

fn vectors(folder: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../test_vectors").join(folder)
}

/// Name and bytes of every valid vector, by name.
fn valid() -> Vec<(String, Vec<u8>)> {
    named("tree/valid", 13)
}

/// The same of those with a symmetric body.
fn symmetric() -> Vec<(String, Vec<u8>)> {
    named("tree/symmetric", 20)
}

fn named(folder: &str, at_least: usize) -> Vec<(String, Vec<u8>)> {
    let mut all: Vec<_> = fs::read_dir(vectors(folder))
        .expect("test_vectors")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|e| e == "adumbra"))
        .map(|path| (path.file_stem().unwrap().to_string_lossy().into_owned(), fs::read(&path).unwrap()))
        .collect();
    all.sort();
    assert!(all.len() >= at_least, "only {} vectors", all.len());
    all
}

fn vector(name: &str) -> Vec<u8> {
    fs::read(vectors("tree/valid").join(format!("{name}.adumbra"))).expect("the vector")
}

fn file(name: &str) -> TreeFile {
    TreeFile::parse(&vector(name)).expect("a valid file")
}

fn words(file: &TreeFile) -> &VoxelTree {
    match &file.body {
        TreeBody::Words(tree) => tree,
        TreeBody::Symmetric(_) => panic!("no words"),
    }
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

#[test]
fn tree_valid_vectors_give_their_answers() {
    let (mut bytes_of_attribute, mut none) = (0, 0);
    for (name, bytes) in valid() {
        let file = exercise(&bytes).unwrap_or_else(|e| panic!("{name}: {e}"));
        let answers = json(&vectors("tree/valid").join(format!("{name}.json")));
        assert_eq!(answers["leaf_voxels"].as_u64(), Some(leaf_voxels(words(&file))), "{name}");
        assert_eq!(
            reference::leaf_voxels(&bytes, reference::root(&bytes)),
            leaf_voxels(words(&file)),
            "{name}"
        );
        for point in answers["points"].as_array().unwrap() {
            let world = [0, 1, 2].map(|i| point["world"][i].as_f64().unwrap());
            let expected = point["visibility"].as_u64().unwrap();
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
        let file = TreeFile::parse(&bytes).unwrap();
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

/// Every voxel of cubes up to 64 a side, read by the library, by a reader made from the specification, and from words.
#[test]
fn tree_symmetric_vectors_answer_as_their_words() {
    for (name, bytes) in symmetric() {
        let symmetric = exercise(&bytes).unwrap_or_else(|e| panic!("{name}: {e}"));
        let TreeBody::Symmetric(tree) = &symmetric.body else { panic!("{name}: words") };
        let (name, kind) = name.rsplit_once('-').unwrap();
        assert_eq!(tree.mirrors(), kind == "mirrors");
        let file = file(name);
        // Deeper cubes: some thousand voxels all over.
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
fn tree_invalid_vectors_give_their_errors() {
    let mut seen = BTreeMap::new();
    for entry in fs::read_dir(vectors("tree/invalid")).unwrap() {
        let folder = entry.unwrap().path();
        let expected = json(&folder.join("expected.json"));
        let path = folder.join("file.adumbra");
        let Err(Error::Format { source, .. }) = TreeFile::read(&path) else {
            panic!("{}: no format error", folder.display());
        };
        let message = source.to_string();
        let found = (source.kind(), source.fault());
        let wanted = (expected["error"].as_str().unwrap(), expected["fault"].as_str());
        assert_eq!(found, wanted, "{}: {message}", folder.display());
        assert!(message.contains(expected["names"].as_str().unwrap()), "{}: {message}", folder.display());
        assert!(["bake", "update"].iter().any(|mend| message.contains(mend)), "no mend: {message}");
        // Bytes and file give the same error.
        assert_eq!(exercise(&fs::read(&path).unwrap()).unwrap_err(), source);
        *seen.entry(found.1.unwrap_or(found.0)).or_insert(0) += 1;
    }
    assert_eq!(seen.values().sum::<i32>(), 69, "{seen:?}");
    assert_eq!(seen.len(), 17, "one kind has no vector: {seen:?}");
}

#[test]
fn tree_specification_shows_the_example_as_it_is() {
    let text =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../spec/adumbra-tree.md")).unwrap();
    let mut bytes = Vec::new();
    for line in text.lines() {
        let Some((at, hex)) = line.split_once(": ") else { continue };
        if at.len() != 8 || usize::from_str_radix(at, 16) != Ok(bytes.len()) {
            continue;
        }
        bytes.extend(hex.split_whitespace().map_while(|b| u8::from_str_radix(b, 16).ok()));
    }
    assert_eq!(bytes, vector("example_8"));
    let answers = text.lines().filter(|line| line.starts_with("| (")).map(|line| {
        let cells: Vec<_> = line.split('|').map(|cell| cell.trim().replace('−', "-")).collect();
        let mut world = cells[1].trim_matches(['(', ')']).split(", ").map(|c| c.parse().unwrap());
        let world = [0; 3].map(|_| world.next().unwrap());
        assert_eq!(reference::visibility(&bytes, world).to_string(), cells[4], "{line}");
    });
    assert_eq!(answers.count(), 6);
}

#[test]
fn tree_settings_and_space_come_back_bit_for_bit() {
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
            assert_eq!(AnyFile::parse(&bytes[..length]).unwrap_err().kind(), "Truncated");
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
                assert!(TreeFile::parse(&bytes).is_err(), "{name} byte {at} xor {other}");
            }
        }
    }
}

#[test]
fn tree_mutations_are_refused_or_answer_everywhere() {
    let seeds = [valid(), symmetric()].concat();
    let (mut accepted, mut kinds) = (0, BTreeMap::new());
    for seed in 0..100_000_u64 {
        let (_, bytes) = &seeds[seed as usize % seeds.len()];
        match exercise(&Mutator::new(seed).mutate(bytes)) {
            Ok(_) => accepted += 1,
            Err(error) => *kinds.entry(error.fault().unwrap_or(error.kind())).or_insert(0) += 1,
        }
    }
    // The mutations reach every check, and trees that are still valid.
    assert!(accepted > 5_000, "{accepted} accepted");
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
    ] {
        assert!(kinds.contains(&kind), "no {kind} in {kinds:?}");
    }
}

#[test]
fn tree_fuzz_input_of_even_first_byte_gets_its_checksums() {
    let mut input = vector("example_8");
    assert_eq!(interpret(&input), input);
    input[0] = b'@';
    input[208] = 99;
    assert_eq!(exercise(&interpret(&input)).unwrap().settings.triangles, 99);
    assert_eq!(exercise(&interpret(&[])).unwrap_err().kind(), "Truncated");
}

#[test]
fn tree_symmetric_body_comes_back() {
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
fn tree_words_travel_apart_and_come_back() {
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
fn tree_and_light_files_are_told_apart() {
    let light = vectors("valid/example_8.adumbra");
    let tree = vectors("tree/valid/example_8.adumbra");
    assert!(
        matches!(AnyFile::read(&light).unwrap(), AnyFile::Light(f) if f == ShadowFile::read(&light).unwrap())
    );
    assert!(matches!(AnyFile::read(&tree).unwrap(), AnyFile::Tree(f) if f == TreeFile::read(&tree).unwrap()));
    for (error, found) in [
        (
            ShadowFile::read(&tree).unwrap_err(),
            "this is a tree file, but a light-aligned shadow file is needed",
        ),
        (
            TreeFile::read(&light).unwrap_err(),
            "this is a light-aligned shadow file, but a tree file is needed",
        ),
    ] {
        assert!(matches!(&error, Error::Format { source: FormatError::OtherKind { .. }, .. }), "{error}");
        assert!(error.to_string().contains(found), "{error}");
    }
    let picture = AnyFile::parse(b"GIF89a\0\0").unwrap_err();
    assert!(picture.to_string().contains("instead of \"ADUMBRA\\n\" or \"ADUMTREE\";"), "{picture}");
    let mut long = fs::read(&tree).unwrap();
    long.push(0);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("long.adumbra");
    fs::write(&path, long).unwrap();
    for error in [AnyFile::read(&path).map(drop), TreeFile::read(&path).map(drop)] {
        let Err(Error::Format { source, .. }) = error else { panic!("{error:?}") };
        assert_eq!(source.kind(), "TrailingBytes");
    }
}

#[test]
fn tree_written_file_reads_back_and_replaces_the_earlier_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.adumbra");
    fs::write(&path, "earlier").unwrap();
    let file = file("penumbra");
    assert_eq!(file.write(&path).unwrap(), vector("penumbra").len() as u64);
    assert_eq!(fs::read(&path).unwrap(), vector("penumbra"));
    assert_eq!(TreeFile::read(&path).unwrap(), file);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "a temporary file is left");
}

/// Writes what is not valid: refused, with the earlier output left, and its bytes are refused by the reader alike.
#[test]
fn tree_refused_write_leaves_the_earlier_output() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.adumbra");
    fs::write(&path, "earlier").unwrap();
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
    for (i, change) in breaks.into_iter().enumerate() {
        let mut file = file("example_8");
        change(&mut file);
        assert!(matches!(file.write(&path), Err(Error::Format { .. })), "{i}");
        assert!(TreeFile::parse(&file.encode()).is_err(), "{i}");
    }
    // Depths that differ: the bytes are those of another file.
    let mut file = file("all_lit");
    (file.space.depth, file.regions.base_depth) = (2, 2);
    assert!(matches!(file.write(&path), Err(Error::Format { .. })));
    assert_eq!(fs::read(&path).unwrap(), b"earlier");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn tree_header_that_promises_too_much_costs_no_memory() {
    // A body of 8 GiB that is not there is refused by the file's length.
    let mut bytes = vector("example_8");
    bytes[248 + 8..][..8].copy_from_slice(&(4_u64 << 31).to_le_bytes());
    bytes[272..][..8].copy_from_slice(&((4_u64 << 31) + 320).to_le_bytes());
    bytes[0] = b'@';
    let error = exercise(&interpret(&bytes)).unwrap_err();
    assert!(matches!(error, FormatError::Truncated { what: "body", .. }), "{error}");
    assert_eq!(TREE_HEADER_BYTES, 320);
}
