//! Random PLY files, valid and damaged. A valid file loads identically in every format. A damaged file loads
//! or is rejected, without a panic and with at most [`FILE_MULTIPLE`] times the file's size in memory.
//!
//! A case depends on its seed alone. `ADUMBRA_FUZZ_SECONDS=600` runs from seed 0 on for that many seconds:
//! `ADUMBRA_FUZZ_SECONDS=600 cargo test --release -p adumbra-scene --lib ply::mutations -- --nocapture`.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::Instant;

use adumbra_testing::{PLY_FORMATS, Ply, PlyElement, fuzz_time};

use super::scene_of;
use crate::random::Random;
use crate::sources::Sources;
use crate::{Error, LoadOptions, Result, Scene};

/// Memory that a load may take, as a multiple of the file's size.
const FILE_MULTIPLE: u64 = 40;
/// Seeds of the quick test.
const QUICK_SEEDS: u64 = 12_000;
/// Damaged files per seed and format.
const DAMAGED: usize = 4;

const INTEGERS: [&str; 10] =
    ["char", "uchar", "short", "ushort", "int", "uint", "int8", "uint16", "int64", "uint64"];
const SCALARS: [&str; 6] = ["float", "double", "uchar", "int", "float64", "int16"];
/// Words that replace a word of a text file.
const WORDS: [&str; 24] = [
    "-1",
    "0",
    "1",
    "2",
    "3",
    "255",
    "65536",
    "4294967295",
    "18446744073709551616",
    "1e308",
    "-1e308",
    "nan",
    "1.#IND",
    "0.5",
    "x",
    "property",
    "element",
    "list",
    "end_header",
    "format",
    "\u{fc}",
    "",
    "uchar",
    "double",
];

/// A valid file: vertices, faces, strips and elements of other names, in any order and with any properties.
fn valid(dice: &mut Random) -> Ply {
    let vertices = 3 + dice.below(30);
    let mut elements = vec![vertex_element(dice, vertices)];
    let faces = dice.chance(0.9).then_some(("face", false));
    let strips = (faces.is_none() || dice.chance(0.3)).then_some(("tristrips", true));
    for (name, separated) in faces.into_iter().chain(strips) {
        elements.push(corner_element(dice, name, vertices, separated));
    }
    if dice.chance(0.3) {
        let count = dice.below(4);
        elements.push(other_element(dice, count));
    }
    let last = elements.len() - 1;
    for i in 0..last {
        let j = i + dice.below(last + 1 - i);
        elements.swap(i, j);
    }
    Ply { elements }
}

/// Appends an unused property and its values.
fn add_spare(dice: &mut Random, element: &mut PlyElement, number: usize) {
    let is_list = dice.chance(0.4);
    let kind = dice.pick(&SCALARS);
    let list = if is_list { format!("list {} ", dice.pick(&INTEGERS)) } else { String::new() };
    element.properties.push(format!("{list}{kind} tex_{number}"));
    for record in &mut element.records {
        let count = if is_list { dice.below(4) } else { 1 };
        if is_list {
            record.push(count as f64);
        }
        record.extend((0..count).map(|_| dice.below(100) as f64));
    }
}

fn vertex_element(dice: &mut Random, count: usize) -> PlyElement {
    let mut element =
        PlyElement { name: "vertex".to_owned(), properties: Vec::new(), records: vec![Vec::new(); count] };
    for (number, axis) in ["x", "y", "z"].into_iter().enumerate() {
        if dice.chance(0.2) {
            add_spare(dice, &mut element, number);
        }
        element.properties.push(format!("{} {axis}", dice.pick(&SCALARS)));
        element.records.iter_mut().for_each(|record| record.push(dice.below(64) as f64));
    }
    if dice.chance(0.3) {
        add_spare(dice, &mut element, 3);
    }
    element
}

fn corner_element(dice: &mut Random, name: &str, vertices: usize, separated: bool) -> PlyElement {
    let count = 1 + dice.below(12);
    let mut element =
        PlyElement { name: name.to_owned(), properties: Vec::new(), records: vec![Vec::new(); count] };
    if dice.chance(0.2) {
        add_spare(dice, &mut element, 0);
    }
    let item = if separated { dice.pick(&["char", "short", "int"]) } else { dice.pick(&INTEGERS) };
    let list = dice.pick(&["vertex_indices", "vertex_index", "corners"]);
    element.properties.push(format!("list {} {item} {list}", dice.pick(&INTEGERS)));
    for record in &mut element.records {
        let count = dice.below(if separated { 20 } else { 7 });
        record.push(count as f64);
        let corner = |dice: &mut Random| dice.below(vertices) as f64;
        record.extend((0..count).map(|_| if separated && dice.chance(0.1) { -1.0 } else { corner(dice) }));
    }
    if dice.chance(0.2) {
        add_spare(dice, &mut element, 1);
    }
    element
}

fn other_element(dice: &mut Random, count: usize) -> PlyElement {
    let mut element =
        PlyElement { name: "edge".to_owned(), properties: Vec::new(), records: vec![Vec::new(); count] };
    (0..=dice.below(3)).for_each(|number| add_spare(dice, &mut element, number));
    element
}

/// Changes bytes, words, counts or the length of a file.
fn damage(dice: &mut Random, bytes: &[u8], header: usize) -> Vec<u8> {
    let mut out = bytes.to_vec();
    for _ in 0..=dice.below(2) {
        let from = if dice.chance(0.8) { header.min(out.len()) } else { 0 };
        let at = from + dice.below((out.len() - from).max(1));
        match dice.below(7) {
            0 => out.truncate(at),
            1 => out.iter_mut().skip(at).take(1).for_each(|b| *b ^= 1 << (at % 8)),
            2 => out.iter_mut().skip(at).take(1 + at % 8).for_each(|b| *b = [0, 255, b' ', b'\n'][at % 4]),
            3 => {
                let end = (at + 1 + dice.below(20)).min(out.len());
                out.drain(at.min(end)..end);
            }
            4 => {
                let end = (at + 1 + dice.below(40)).min(out.len());
                let copy = out[at.min(end)..end].to_vec();
                let to = dice.below(out.len().max(1));
                out.splice(to..to, copy);
            }
            _ => {
                let blank = |b: &u8| b.is_ascii_whitespace();
                let from = out[..at].iter().rposition(blank).map_or(0, |i| i + 1);
                let end = out[at..].iter().position(blank).map_or(out.len(), |i| at + i);
                let word = dice.pick(&WORDS);
                out.splice(from.min(end)..end, word.bytes());
            }
        }
    }
    out
}

/// The counts of a run.
#[derive(Debug, Default)]
struct Totals {
    seeds: u64,
    whole: u64,
    whole_empty: u64,
    damaged: u64,
    loaded: u64,
    cut_off: u64,
    other_values: u64,
    out_of_range: u64,
    unusable: u64,
}

/// Loads a file with these bytes.
fn load(bytes: &[u8]) -> Result<Scene> {
    let limit = FILE_MULTIPLE * bytes.len() as u64;
    let options = LoadOptions { max_memory_bytes: Some(limit), ..LoadOptions::default() };
    let sources = Sources::new(Path::new("scene.ply"), "PLY", &options);
    sources.budget.charge(bytes.len() as u64, String::new)?;
    scene_of(&sources, bytes.to_vec(), &options)
}

impl Totals {
    fn check(&mut self, seed: u64) {
        self.seeds += 1;
        let dice = &mut Random::new(seed, 0);
        let ply = valid(dice);
        let files = PLY_FORMATS.map(|format| ply.bytes(format));
        let [text, little, big] = files.each_ref().map(|bytes| summary(load(bytes), seed));
        assert!(text == little && text == big, "seed {seed}: {text}\n{little}\n{big}");
        self.whole += 3;
        self.whole_empty += if text.starts_with('[') { 0 } else { 3 };
        for (format, bytes) in PLY_FORMATS.iter().zip(&files) {
            let header = ply.header(format).len();
            for _ in 0..DAMAGED {
                let damaged = damage(dice, bytes, header);
                self.check_damaged(&damaged, seed);
            }
        }
    }

    fn check_damaged(&mut self, bytes: &[u8], seed: u64) {
        self.damaged += 1;
        let error = match load(bytes) {
            Ok(scene) => {
                check_scene(&scene, seed);
                self.loaded += 1;
                return;
            }
            Err(error) => error,
        };
        let message = error.to_string();
        assert!(message.contains("scene.ply") && !message.contains('\n'), "seed {seed}: {message}");
        match error {
            Error::SceneParse { .. } if message.contains("cut off") => self.cut_off += 1,
            Error::SceneParse { .. } => self.other_values += 1,
            Error::IndexOutOfRange { .. } => self.out_of_range += 1,
            Error::NoTriangles { .. } | Error::ZeroExtent { .. } | Error::NotFinite { .. } => {
                self.unusable += 1;
            }
            other => panic!("seed {seed}: {other}"),
        }
    }
}

/// Checks the invariants of every loaded scene.
fn check_scene(scene: &Scene, seed: u64) {
    let mesh = &scene.meshes[0];
    assert!(
        !mesh.triangles.is_empty() && mesh.triangles.len() == mesh.triangle_materials.len(),
        "seed {seed}"
    );
    assert!(mesh.positions.iter().flatten().all(|c| c.is_finite()), "seed {seed}");
    let vertices = mesh.positions.len();
    assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < vertices), "seed {seed}");
}

/// A scene, or the error in its place, as text to compare.
fn summary(result: Result<Scene>, seed: u64) -> String {
    match result {
        Ok(scene) => {
            check_scene(&scene, seed);
            format!("{:?} {:?} {:?}", scene.meshes, scene.instances, scene.notes)
        }
        Err(error @ (Error::ZeroExtent { .. } | Error::NoTriangles { .. })) => error.to_string(),
        Err(error) => panic!("seed {seed}: a whole file is refused: {error}"),
    }
}

#[test]
fn all_formats_load_alike_and_damage_never_panics() {
    let time = fuzz_time();
    let mut totals = Totals::default();
    let started = Instant::now();
    for seed in 0.. {
        if time.map_or(seed >= QUICK_SEEDS, |time| started.elapsed() >= time) {
            break;
        }
        if catch_unwind(AssertUnwindSafe(|| totals.check(seed))).is_err() {
            panic!("seed {seed} fails");
        }
    }
    println!("{totals:?} in {:.1} s", started.elapsed().as_secs_f64());
    assert!(totals.whole_empty * 5 < totals.whole, "few files have faces: {totals:?}");
    let tenth = totals.damaged / 10;
    assert!(totals.loaded > tenth && totals.cut_off > tenth, "damage is too weak or too strong: {totals:?}");
    assert!(totals.other_values > tenth && totals.out_of_range > 0, "few values are damaged: {totals:?}");
}

#[test]
fn densest_files_load_within_the_memory_multiple() {
    let bytes = ["char x", "char y", "char z"];
    let corners: Vec<f64> = (0..300_000).map(|i| f64::from(i % 100)).collect();
    let points: Vec<[f64; 3]> =
        (0..100).map(|i| [f64::from(i), f64::from(i * i % 91), f64::from(i % 5)]).collect();
    let records: Vec<&[f64]> = points.iter().map(|p| &p[..]).collect();
    let list = |corners: &[f64]| [&[corners.len() as f64], corners].concat();
    let vertices = || Ply::default().with("vertex", &bytes, &records);
    let properties: Vec<String> = (0..20_000).map(|i| format!("char {i}")).collect();
    let properties: Vec<&str> = properties.iter().map(String::as_str).collect();
    let triangle: &[f64] = &[3.0, 0.0, 1.0, 2.0];
    let (all, half) = (list(&corners), list(&corners[..150_000]));
    let cases = [
        (
            "vertices",
            Ply::default().with("vertex", &bytes, &records.repeat(3000)).with(
                "face",
                &["list uchar uchar vertex_indices"],
                &[triangle],
            ),
        ),
        ("triangles", vertices().with("face", &["list uchar uchar vertex_indices"], &[triangle; 70_000])),
        ("a face", vertices().with("face", &["list uint uchar vertex_indices"], &[&all])),
        (
            "three faces",
            vertices().with("face", &["list uint uchar vertex_indices"], &[&half, &half, triangle]),
        ),
        ("a strip", vertices().with("tristrips", &["list uint uchar vertex_indices"], &[&all])),
        ("two strips", vertices().with("tristrips", &["list uint uchar vertex_indices"], &[&all, triangle])),
        (
            "properties",
            vertices().with("face", &["list uint uchar vertex_indices"], &[triangle]).with(
                "wide",
                &properties,
                &[&vec![0.0; properties.len()]],
            ),
        ),
    ];
    for (what, ply) in cases {
        for format in PLY_FORMATS {
            load(&ply.bytes(format)).unwrap_or_else(|error| panic!("{what}, {format}: {error}"));
        }
    }
}
