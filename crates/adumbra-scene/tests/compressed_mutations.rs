//! Mutated streams and images: whatever a file holds, it loads or is rejected with a message, without a panic
//! and within the memory limit of the load.
//!
//! Each input is changed where decoders branch: at numbers of the headers and of the glTF extension, at codes
//! at the start of a stream, at lengths, and at bytes anywhere. `ADUMBRA_FUZZ_SECONDS=600` runs each decoder
//! for that many seconds.
#![cfg(all(feature = "ktx2", feature = "meshopt"))]

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::Instant;

use adumbra_scene::random::Random;
use adumbra_scene::{LoadOptions, load};
use adumbra_testing::{fuzz_time, glb};
use base64::Engine;
use peak_alloc::PeakAlloc;
use serde_json::{Value, json};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Inputs of the quick test.
const SEEDS: u64 = 400;
/// Memory that a load may hold, bytes.
const LIMIT: u64 = 96 << 20;
/// Memory of the test itself: its fixtures and the decoders' tables, bytes.
const OWN: u64 = 96 << 20;

/// Numbers at which decoders branch.
const EDGES: [u64; 18] = [
    0,
    1,
    2,
    3,
    4,
    7,
    16,
    17,
    255,
    256,
    4096,
    65_535,
    65_536,
    1 << 24,
    0x7fff_ffff,
    0xffff_ffff,
    1 << 40,
    u64::MAX,
];

fn fixtures(folder: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures").join(folder)
}

fn below(random: &mut Random, count: usize) -> usize {
    ((random.unit() * count as f64) as usize).min(count.saturating_sub(1))
}

fn edge(random: &mut Random) -> u64 {
    EDGES[below(random, EDGES.len())]
}

/// Changes some of the bytes, most of them at the start.
fn mutate(bytes: &mut Vec<u8>, random: &mut Random) {
    for _ in 0..1 + below(random, 6) {
        if bytes.is_empty() {
            return;
        }
        let spread = [16, 64, bytes.len()][below(random, 3)].min(bytes.len());
        let at = below(random, spread);
        match below(random, 8) {
            0 => bytes[at] ^= 1 << below(random, 8),
            1 => bytes[at] = below(random, 256) as u8,
            2 => bytes[at] = [0, 1, 0x7f, 0x80, 0xfe, 0xff][below(random, 6)],
            3 => bytes.truncate(bytes.len() - below(random, 32).min(bytes.len())),
            4 => bytes.insert(at, below(random, 256) as u8),
            5 => drop(bytes.remove(at)),
            6 => {
                let from = below(random, bytes.len());
                let length = below(random, 40).min(bytes.len() - from).min(bytes.len() - at);
                bytes.copy_within(from..from + length, at);
            }
            _ => {
                let (value, at) = (edge(random), at / 4 * 4);
                let width = [2, 4, 8][below(random, 3)].min(bytes.len() - at);
                bytes[at..at + width].copy_from_slice(&value.to_le_bytes()[..width]);
            }
        }
    }
}

/// Loads the files that `make` creates from successive seeds. Both tests may hold their memory at the same
/// time.
fn run(name: &str, make: impl Fn(&mut Random) -> Vec<u8>) {
    let time = fuzz_time();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("scene.glb");
    let (begun, mut seed, mut loaded, mut failed) = (Instant::now(), 0, 0_u64, Vec::new());
    MEMORY.reset_peak_usage();
    while time.map_or(seed < SEEDS, |time| begun.elapsed() < time) {
        let bytes = make(&mut Random::new(seed, 0));
        std::fs::write(&path, bytes).expect("writes");
        let options = LoadOptions {
            color_textures: seed % 2 == 0,
            max_memory_bytes: Some(LIMIT),
            ..LoadOptions::default()
        };
        match catch_unwind(AssertUnwindSafe(|| load(&path, &options))) {
            Ok(Ok(_)) => loaded += 1,
            Ok(Err(error)) => {
                let message = error.to_string();
                assert!(message.contains("scene.glb") && !message.contains('\n'), "seed {seed}: {message}");
            }
            Err(_) => failed.push(seed),
        }
        seed += 1;
    }
    let peak = MEMORY.peak_usage() as u64;
    eprintln!("{name}: {seed} inputs, {loaded} loaded, {} panics, peak {} MiB", failed.len(), peak >> 20);
    assert!(failed.is_empty(), "{name}: panics with the seeds {failed:?}");
    assert!(loaded > 0 && loaded < seed, "{name}: {loaded} of {seed} loaded");
    assert!(peak < 2 * LIMIT + OWN, "{name}: {peak} bytes");
}

#[test]
fn meshopt_streams_survive_mutation() {
    let text = std::fs::read(fixtures("meshopt").join("streams.json")).expect("the fixture");
    let cases: Vec<Value> = serde_json::from_slice(&text).expect("JSON");
    let streams: Vec<Vec<u8>> = cases
        .iter()
        .map(|case| {
            let text = case["stream"].as_str().expect("a text");
            base64::engine::general_purpose::STANDARD.decode(text).expect("base64")
        })
        .collect();
    run("meshopt", |random| {
        let index = below(random, cases.len());
        let (case, mut stream) = (&cases[index], streams[index].clone());
        if random.unit() < 0.9 {
            mutate(&mut stream, random);
        }
        let mut extension = json!({
            "buffer": 0, "byteLength": stream.len(), "byteStride": case["stride"], "count": case["count"],
            "mode": case["mode"], "filter": case["filter"],
        });
        if random.unit() < 0.4 {
            let key = ["byteLength", "byteOffset", "byteStride", "count", "buffer"][below(random, 5)];
            let near = case["count"].as_u64().unwrap_or(0) + below(random, 40) as u64;
            extension[key] = json!(if random.unit() < 0.5 { near } else { edge(random) });
        }
        if random.unit() < 0.3 {
            extension["mode"] = json!(["ATTRIBUTES", "TRIANGLES", "INDICES"][below(random, 3)]);
        }
        if random.unit() < 0.3 {
            let filters = ["NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR"];
            extension["filter"] = json!(filters[below(random, 5)]);
        }
        let count = extension["count"].clone();
        let stride = extension["byteStride"].clone();
        let attributes = case["mode"] == "ATTRIBUTES";
        let view =
            json!({"buffer": 1, "byteLength": 64, "extensions": {"KHR_meshopt_compression": extension}});
        let mut accessor = json!({"bufferView": 0, "componentType": case["componentType"], "count": count,
            "type": if attributes { "VEC3" } else { "SCALAR" }});
        let mut views = json!([view, {"buffer": 0, "byteLength": stream.len()}]);
        let mut primitive = json!({"attributes": {"POSITION": 0}});
        if attributes {
            views[0]["byteStride"] = stride;
            accessor["normalized"] = json!(random.unit() < 0.5);
        } else {
            primitive = json!({"attributes": {"POSITION": 1}, "indices": 0});
        }
        let zeros = json!({"componentType": 5126, "count": 60, "type": "VEC3"});
        let json = json!({
            "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [primitive, {"attributes": {"POSITION": 2}}]}],
            "accessors": [accessor, zeros, {"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC3"}],
            "bufferViews": [views[0], views[1], {"buffer": 2, "byteLength": 36}],
            "buffers": [{"byteLength": stream.len()}, {"byteLength": 64}, {"byteLength": 36, "uri": TRIANGLE}],
        });
        glb(&json, &stream)
    });
}

/// Three positions: the corners of a triangle.
const TRIANGLE: &str = "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAAAAAAIA/";

#[test]
fn ktx2_images_survive_mutation() {
    let mut images: Vec<PathBuf> = std::fs::read_dir(fixtures("ktx2"))
        .expect("the fixtures")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|e| e == "ktx2"))
        .collect();
    images.sort();
    let images: Vec<Vec<u8>> = images.iter().map(|path| std::fs::read(path).expect("reads")).collect();
    let word = |bytes: &[u8], at: usize| {
        u64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight bytes")) as usize
    };
    run("ktx2", |random| {
        let mut image = images[below(random, images.len())].clone();
        match below(random, 4) {
            // Change the header, the index of levels or the data format descriptor.
            0 => {
                let at = 12 + below(random, 50) * 4;
                let value = edge(random);
                let width = [4, 8][below(random, 2)];
                image[at..at + width].copy_from_slice(&value.to_le_bytes()[..width]);
            }
            // Change the codebooks or the data of the first level, but keep the file's structure.
            1 | 2 => {
                let parts =
                    [(64, 72), (80, 88)].map(|(from, length)| (word(&image, from), word(&image, length)));
                let (from, length) = parts[below(random, 2)];
                let mut part = image[from..from + length].to_vec();
                mutate(&mut part, random);
                part.resize(length, 0);
                image[from..from + length].copy_from_slice(&part);
            }
            _ => mutate(&mut image, random),
        }
        let texture = json!({"baseColorTexture": {"index": 0}});
        let json = json!({
            "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
            "materials": [{"alphaMode": "MASK", "pbrMetallicRoughness": texture}],
            "textures": [{"extensions": {"KHR_texture_basisu": {"source": 0}}}],
            "images": [{"bufferView": 0, "mimeType": "image/ktx2"}],
            "accessors": [{"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3"}],
            "bufferViews": [{"buffer": 0, "byteLength": image.len()}, {"buffer": 1, "byteLength": 36}],
            "buffers": [{"byteLength": image.len()}, {"byteLength": 36, "uri": TRIANGLE}],
        });
        glb(&json, &image)
    });
}
