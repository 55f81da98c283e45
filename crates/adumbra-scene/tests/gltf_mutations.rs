//! Random glTF files, valid and damaged. A valid file gives the same scene in every container and in every
//! way to write numbers. A damaged file loads or is rejected, without a panic and within the memory limit of
//! the load.
//!
//! The damage knows JSON and the container: values become values of other types, huge, negative or missing,
//! lists are cut or repeat, and bytes and lengths change. A case depends only on its seed.
//! `ADUMBRA_FUZZ_SECONDS=600` runs from seed 0 for that many seconds. With `TMPDIR=/dev/shm` it runs many
//! times as many cases:
//! `ADUMBRA_FUZZ_SECONDS=600 cargo test --release -p adumbra-scene --test gltf_mutations -- --nocapture`.

#[path = "gltf_mutations/damage.rs"]
mod damage;
#[path = "gltf_mutations/dice.rs"]
mod dice;
#[path = "scene_loading/kit.rs"]
#[allow(dead_code, reason = "shared with the other loading tests")]
mod kit;
#[path = "gltf_mutations/valid.rs"]
mod valid;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use adumbra::Sun;
use adumbra_scene::{Error, LoadOptions, MoverPolicy, Scene, files_of_gltf, load, write_shadow_name};
use adumbra_testing::{full, fuzz_time};
use dice::Dice;
use kit::{Glb, file};
use peak_alloc::PeakAlloc;
use serde_json::Value;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Memory that a load may hold.
const MAX_BYTES: u64 = 64 << 20;
/// Memory of the test itself.
const TEST_BYTES: u64 = 64 << 20;
/// Seeds of the quick test.
const QUICK_SEEDS: u64 = 500;
/// Damaged files per seed.
const DAMAGED: usize = 12;

/// Lets only one test run at a time, because all memory of the program is counted.
fn alone() -> MutexGuard<'static, ()> {
    static TURN: Mutex<()> = Mutex::new(());
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The counts of a run.
#[derive(Debug, Default)]
struct Totals {
    seeds: u64,
    damaged: u64,
    loaded: u64,
    refused: u64,
    too_large: u64,
    named: u64,
}

fn options(dice: &mut Dice) -> LoadOptions {
    LoadOptions {
        max_memory_bytes: Some(MAX_BYTES),
        color_textures: dice.chance(0.5),
        movers: dice.pick(&[MoverPolicy::Skip, MoverPolicy::Freeze, MoverPolicy::Keep]),
        ..LoadOptions::default()
    }
}

/// The content of a scene as text to compare, without the file of its buffer.
fn summary(scene: &Scene) -> String {
    let mut notes = scene.notes.clone();
    notes.named_files.clear();
    format!("{:?} {:?} {:?} {:?} {notes:?}", scene.meshes, scene.instances, scene.materials, scene.suns)
}

/// Checks the invariants of every loaded scene.
fn check_scene(scene: &Scene) {
    assert!(!scene.instances.is_empty());
    for instance in &scene.instances {
        assert!((instance.mesh as usize) < scene.meshes.len());
        assert!(instance.world_from_mesh.iter().flatten().all(|c| c.is_finite()));
    }
    for mesh in &scene.meshes {
        let vertices = mesh.positions.len();
        assert!(!mesh.triangles.is_empty() && mesh.triangles.len() == mesh.triangle_materials.len());
        assert!(mesh.positions.iter().flatten().all(|c| c.is_finite()));
        assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < vertices));
        assert!(mesh.triangle_materials.iter().all(|&m| (m as usize) < scene.materials.len()));
        assert!(mesh.uvs.is_empty() || mesh.uvs.len() == vertices);
        assert!(mesh.colors.is_empty() || mesh.colors.len() == vertices);
    }
    let textures = scene.textures.len();
    assert!(scene.materials.iter().all(|m| m.texture.is_none_or(|t| (t as usize) < textures)));
    for sun in &scene.suns {
        let length = sun.unit_towards().iter().map(|c| c * c).sum::<f64>();
        assert!((length - 1.0).abs() < 1e-9, "{sun:?}");
    }
}

impl Totals {
    fn check(&mut self, folder: &Path, seed: u64) {
        self.seeds += 1;
        let dice = &mut Dice::new(seed);
        let glb = valid::file(dice);
        let options = options(dice);
        let mut expected: Option<String> = None;
        for (what, name, bytes) in valid::ways_to_write(&glb, folder) {
            let path = folder.join(name);
            std::fs::write(&path, &bytes).expect("writes");
            let scene = load(&path, &options).unwrap_or_else(|error| panic!("{what}: {error}\n{}", glb.json));
            check_scene(&scene);
            let found = summary(&scene);
            assert!(*expected.get_or_insert_with(|| found.clone()) == found, "{what}: {}", glb.json);
        }
        for _ in 0..DAMAGED {
            let bytes = damage::damaged(dice, &glb);
            self.check_damaged(&folder.join("scene.glb"), &bytes, &options, dice.chance(0.1));
        }
    }

    fn check_damaged(&mut self, path: &Path, bytes: &[u8], options: &LoadOptions, takes_name: bool) {
        self.damaged += 1;
        std::fs::write(path, bytes).expect("writes");
        let listed = files_of_gltf(path, bytes);
        let loaded = load(path, options);
        match &loaded {
            Ok(scene) => {
                self.loaded += 1;
                check_scene(scene);
                assert!(listed.is_ok(), "{listed:?}");
            }
            Err(error) => {
                let message = error.to_string();
                assert!(!message.contains('\n') && message.len() < 2000, "{message}");
                let of_scene = message.contains("scene.glb");
                // The missing file may be that of a buffer or an image.
                assert!(of_scene || matches!(error, Error::Io(_)), "{message}");
                self.refused += 1;
                self.too_large += u64::from(matches!(error, Error::SceneMemory { .. }));
            }
        }
        let sun = Sun::from_direction([0.5, 0.8, 0.35]).expect("above the horizon");
        if takes_name && write_shadow_name(path, "a.adumbra", sun).is_ok() {
            self.named += 1;
            let again = load(path, options);
            // The additional node and light may exceed the memory limit.
            assert!(
                again.is_ok() == loaded.is_ok() || matches!(again, Err(Error::SceneMemory { .. })),
                "{loaded:?} {again:?}"
            );
        }
    }
}

#[test]
fn gltf_all_forms_load_alike_and_damage_never_panics() {
    let _turn = alone();
    let time = fuzz_time();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (mut totals, started) = (Totals::default(), Instant::now());
    for seed in 0.. {
        if time.map_or(seed >= QUICK_SEEDS, |time| started.elapsed() >= time) {
            break;
        }
        if catch_unwind(AssertUnwindSafe(|| totals.check(folder.path(), seed))).is_err() {
            panic!("seed {seed} fails");
        }
    }
    println!("{totals:?}, peak {} bytes", MEMORY.peak_usage());
    let tenth = totals.damaged / 10;
    assert!(totals.loaded > tenth && totals.refused > tenth, "damage is too weak or too strong: {totals:?}");
    assert!(totals.named > 0, "no damaged file takes a name: {totals:?}");
    assert_memory_is_bounded(MAX_BYTES + TEST_BYTES);
}

fn assert_memory_is_bounded(most_bytes: u64) {
    let peak = MEMORY.peak_usage() as u64;
    assert!(peak < most_bytes, "{peak} of {most_bytes} bytes");
}

#[test]
#[ignore = "slow: 60 files of up to 10 MB; 180 with ADUMBRA_FULL"]
fn gltf_densest_files_stay_within_the_memory_limit() {
    densest_files_keep_to_their_memory(if full() { 1 } else { 3 }, 1);
}

#[test]
fn gltf_dense_files_stay_within_the_memory_limit() {
    densest_files_keep_to_their_memory(7, 8);
}

/// Elements of a few bytes become structures of hundreds of bytes. Loads one in `one_of` kinds of file.
/// Divides the number of elements and the memory limit by `fewer`.
fn densest_files_keep_to_their_memory(one_of: usize, fewer: usize) {
    let _turn = alone();
    MEMORY.reset_peak_usage();
    let max_bytes = MAX_BYTES / fewer as u64;
    let most_bytes = max_bytes + TEST_BYTES / fewer as u64;
    let options = LoadOptions { max_memory_bytes: Some(max_bytes), ..LoadOptions::default() };
    let lists = [
        "accessors",
        "animations",
        "buffers",
        "bufferViews",
        "images",
        "materials",
        "meshes",
        "nodes",
        "samplers",
        "scenes",
        "skins",
        "textures",
    ];
    let elements = [
        "0",
        "{}",
        "[]",
        "{\"name\":1}",
        "\"\\n\\n\\n\\n\\n\\n\\n\\n\\n\\n\\n\\n\\n\\n\\n\\n\\n\\n\\n\\n\\n\\n\\n\\n\"",
    ];
    for (l, list) in lists.into_iter().enumerate() {
        for (e, element) in elements.into_iter().enumerate() {
            if (l + e) % one_of != 0 {
                continue;
            }
            // Counts that nearly fit, and a count that does not.
            for (count, may_fit) in [(30_000, true), (60_000, true), (400_000, false)] {
                let count = count / fewer;
                let mut text = String::with_capacity(count * (element.len() + 1) + 100);
                text += &format!("{{\"asset\":{{\"version\":\"2.0\"}},\"{list}\":[{element}");
                text.extend(std::iter::repeat_n(format!(",{element}"), count - 1));
                text += "]}";
                let (_folder, path) = file("scene.gltf", text.as_bytes());
                // Free the text, so that only the load's memory is measured.
                drop(text);
                let error = load(&path, &options).expect_err("holds no triangles");
                let fits = !matches!(error, Error::SceneMemory { .. });
                assert!(may_fit || !fits, "{list} {element}: {error}");
                assert_memory_is_bounded(most_bytes);
            }
        }
    }
}

/// Visits every value of a JSON document, to damage it or to write it in another way.
fn each_value(value: &mut Value, visit: &mut impl FnMut(&mut Value)) {
    visit(value);
    match value {
        Value::Array(list) => list.iter_mut().for_each(|v| each_value(v, visit)),
        Value::Object(members) => members.values_mut().for_each(|v| each_value(v, visit)),
        _ => {}
    }
}

#[test]
fn gltf_files_truncated_anywhere_are_rejected() {
    let _turn = alone();
    let dice = &mut Dice::new(3);
    let glb: Glb = valid::file(dice);
    let bytes = glb.bytes();
    let (_folder, path) = file("scene.glb", &bytes);
    for length in (0..bytes.len()).step_by(7) {
        std::fs::write(&path, &bytes[..length]).expect("writes");
        let error = load(&path, &LoadOptions::default()).expect_err("is cut off");
        assert!(matches!(error, Error::SceneParse { .. }), "{length}: {error}");
    }
}
