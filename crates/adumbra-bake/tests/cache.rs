//! Bakes that use entries of earlier bakes write the bytes of fresh bakes, whatever was edited in between.

use std::fs;
use std::io::Cursor;
use std::path::PathBuf;
use std::sync::Arc;

use adumbra::{Bias, Bounds, Encoding, Receivers, Sun};
use adumbra_bake::{
    AssumeGround, Bake, BakeCache, BakeOptions, CacheKey, ColumnBuilder, DiskCache, Fetched, FrameChoice,
    Report, Size,
};
use adumbra_scene::random::Random;
use adumbra_scene::{
    AlphaMode, GeneratedKind, LoadOptions, Mesh, Pixels, Scene, Texture, Wrap, generate, load,
};
use adumbra_testing::{add_quad, cuboid, full, scene_file, scene_of, shared};

mod store;

use store::InMemory;

fn each(memory: &InMemory, change: impl FnMut(&mut Vec<u8>)) {
    memory.0.lock().unwrap().values_mut().for_each(change);
}

fn options(resolution: u64) -> BakeOptions {
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    let frame = FrameChoice::ObliqueAt(0.0);
    // The bounds keep voxels where they are when something beyond the scene's extent is added.
    let bounds = Some(Bounds { min: [-150.0, -1.0, -150.0], max: [150.0, 60.0, 150.0] });
    BakeOptions::new(sun, Size::Resolution(resolution)).with(|o| {
        o.frame = frame;
        o.bounds = bounds;
        o.encoding = Encoding::Raw;
    })
}

fn fresh(scene: &Scene, options: &BakeOptions) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    Bake::with_options(scene, options).write_to(&mut out).expect("a good bake");
    out.into_inner()
}

fn with_cache(scene: &Scene, options: &BakeOptions, cache: &Arc<dyn BakeCache>) -> (Vec<u8>, Report) {
    let mut out = Cursor::new(Vec::new());
    let written =
        Bake::with_options(scene, options).cache(Arc::clone(cache)).write_to(&mut out).expect("a good bake");
    (out.into_inner(), written.report)
}

/// Edits a scene at random, and returns a description of the edit.
fn edit(scene: &mut Scene, random: &mut Random) -> String {
    let mut below = |count: usize| (random.unit() * count as f64) as usize;
    let instance = below(scene.instances.len());
    let what = below(8);
    let [x, z] = [0, 0].map(|_| 0.01 * (below(2000) as f64 - 1000.0));
    match what {
        0 => {
            let place = &mut scene.instances[instance].world_from_mesh;
            place[0][3] += x;
            place[2][3] += z;
        }
        1 => {
            let mut copy = scene.instances[instance].clone();
            copy.world_from_mesh[0][3] += 4.0 * x;
            copy.world_from_mesh[2][3] += 4.0 * z;
            scene.instances.push(copy);
        }
        2 if scene.instances.len() > 4 => {
            scene.instances.remove(instance);
        }
        3 => scene.instances[instance].world_from_mesh[1][1] *= 0.75 + 0.0003 * (x + 10.0),
        4 => {
            let mesh = scene.instances[instance].mesh as usize;
            let vertex = below(scene.meshes[mesh].positions.len());
            scene.meshes[mesh].positions[vertex][1] += 0.5;
        }
        5 => {
            let material = below(scene.materials.len());
            scene.materials[material].alpha = match scene.materials[material].alpha {
                AlphaMode::Opaque => AlphaMode::Mask { cutoff: 0.5 },
                AlphaMode::Mask { .. } => AlphaMode::Opaque,
            };
        }
        6 if !scene.textures.is_empty() => {
            let texture = below(scene.textures.len());
            let (Pixels::Alpha(bytes) | Pixels::Rgba(bytes)) = &mut scene.textures[texture].pixels;
            bytes.iter_mut().skip(3).step_by(29).for_each(|byte| *byte = !*byte);
        }
        _ => scene.instances[instance].casts ^= true,
    }
    format!("edit {what} of instance {instance} by ({x}, {z})")
}

fn edited_bakes_are_fresh_bakes(kind: GeneratedKind, options: &BakeOptions, edits: u64) {
    edits_are_fresh_bakes(&format!("{kind:?}"), generate(kind, 3), options, edits);
}

fn edits_are_fresh_bakes(name: &str, mut scene: Scene, options: &BakeOptions, edits: u64) {
    let memory = Arc::new(InMemory::default());
    let cache: Arc<dyn BakeCache> = memory.clone();
    let (bytes, report) = with_cache(&scene, options, &cache);
    assert!(bytes == fresh(&scene, options));
    assert_eq!(report.reused_root_blocks, 0);
    assert!(memory.len() > 0);
    let mut random = Random::for_batch(edits, 7);
    let mut reused = 0;
    for number in 0..edits {
        let what = edit(&mut scene, &mut random);
        let (bytes, report) = with_cache(&scene, options, &cache);
        assert!(bytes == fresh(&scene, options), "{name}: {number}: {what}");
        reused += report.reused_root_blocks;
        // Nothing has changed, so all entries are found.
        let (again, report) = with_cache(&scene, options, &cache);
        assert!(
            again == bytes && report.reused_root_blocks == report.root_blocks,
            "{name}: {number}: {what}"
        );
    }
    assert!(reused > 0);
}

#[test]
fn edited_small_scenes_have_the_bytes_of_fresh_bakes() {
    edited_bakes_are_fresh_bakes(GeneratedKind::City, &options(1024), 1);
    // The grid follows the scene.
    let unbounded = options(2048).with(|o| o.bounds = None);
    edited_bakes_are_fresh_bakes(GeneratedKind::Primitives, &unbounded, 3);
}

#[test]
#[ignore = "slow: takes over eight seconds"]
fn edited_scenes_have_the_bytes_of_fresh_bakes() {
    edited_bakes_are_fresh_bakes(GeneratedKind::City, &options(1024), if full() { 200 } else { 2 });
    let of_receivers = options(1024).with(|o| o.receivers = Receivers::Static);
    edited_bakes_are_fresh_bakes(GeneratedKind::City, &of_receivers, 1);
}

#[test]
#[ignore = "slow: several edits of each of two scenes; 200 with ADUMBRA_FULL"]
fn edited_scenes_without_bounds_have_the_bytes_of_fresh_bakes() {
    let edits = if full() { 200 } else { 4 };
    // The grid follows the scene.
    let unbounded = options(2048).with(|o| o.bounds = None);
    for kind in [GeneratedKind::Primitives, GeneratedKind::Wires] {
        edited_bakes_are_fresh_bakes(kind, &unbounded, edits);
    }
}

/// Real scenes: instances and, with `ADUMBRA_FULL`, one mesh of a whole town, and terrain with trees under
/// masks.
#[test]
#[ignore = "slow: real scenes"]
fn edits_of_real_scenes_have_the_bytes_of_fresh_bakes() {
    let Some(scenes) = shared("scenes") else { return };
    let edits = if full() { 200 } else { 2 };
    let names: &[&str] = if full() { &["kaykit_city_21", "alpine-2", "delft"] } else { &["kaykit_city_21"] };
    for name in names {
        let scene = load(&scene_file(&scenes, name), &LoadOptions::default()).expect("a good scene");
        // The grid follows the scene: an edit may move every voxel.
        let options = options(4096).with(|o| {
            o.bounds = None;
            o.frame = FrameChoice::Auto;
        });
        edits_are_fresh_bakes(name, scene, &options, edits);
    }
}

#[test]
#[ignore = "slow: large root blocks"]
fn edits_of_root_blocks_of_several_pages_have_the_bytes_of_fresh_bakes() {
    edited_bakes_are_fresh_bakes(GeneratedKind::City, &options(32768), 3);
}

/// A bake reuses no entry of a bake with other options, unless the option that differs affects no page.
#[test]
fn every_relevant_option_changes_the_keys() {
    let scene = generate(GeneratedKind::Primitives, 3);
    let plain = options(512);
    let bias = |constant_texels, slope_texels, normal_offset_texels| {
        let bias = Bias { constant_texels, slope_texels, normal_offset_texels };
        plain.clone().with(|o| o.bias = bias)
    };
    let Bias { constant_texels: c, slope_texels: s, normal_offset_texels: n } = plain.bias;
    let cases = [
        plain.clone().with(|o| o.builder = ColumnBuilder::Plain),
        plain.clone().with(|o| o.sun = Sun::from_direction([0.5, 0.8, 0.36]).unwrap()),
        plain.clone().with(|o| o.frame = FrameChoice::ObliqueAt(0.1)),
        plain.clone().with(|o| o.frame = FrameChoice::Light),
        plain.clone().with(|o| o.thickness_world = 0.5),
        plain.clone().with(|o| o.assume_ground = AssumeGround::No),
        plain.clone().with(|o| o.closed_regions = false),
        plain.clone().with(|o| o.ignore_alpha = true),
        plain.clone().with(|o| o.receivers = Receivers::Static),
        plain.clone().with(|o| o.switch_within_voxels = 3),
        bias(c + 0.25, s, n),
        bias(c, s + 0.25, n),
        bias(c, s, n + 0.25),
    ];
    let cache: Arc<dyn BakeCache> = Arc::new(InMemory::default());
    let (bytes, _) = with_cache(&scene, &plain, &cache);
    for (number, options) in cases.iter().enumerate() {
        let (found, report) = with_cache(&scene, options, &cache);
        assert!(found == fresh(&scene, options), "{number}");
        assert_eq!(report.reused_root_blocks, 0, "{number}");
    }
    let (again, report) = with_cache(&scene, &plain, &cache);
    assert!(again == bytes && report.reused_root_blocks == report.root_blocks);
}

/// A ground, and above it a box and a card with a texture that cuts holes.
fn small_scene() -> Scene {
    let (mut ground, mut card) = (Mesh::default(), Mesh::default());
    add_quad(&mut ground, [[-8.0, 0.0, -8.0], [-8.0, 0.0, 8.0], [8.0, 0.0, 8.0], [8.0, 0.0, -8.0]]);
    add_quad(&mut card, [[-4.0, 3.0, -4.0], [-4.0, 3.0, 4.0], [4.0, 3.0, 4.0], [4.0, 3.0, -4.0]]);
    card.uvs = vec![[0.0, 0.0], [0.0, 3.0], [3.0, 3.0], [3.0, 0.0]];
    card.triangle_materials.fill(1);
    let mut scene = scene_of(vec![ground, cuboid([4.5, 1.0, 4.5], [6.0, 2.0, 6.0]), card]);
    let mut material = scene.materials[0].clone();
    (material.alpha, material.texture) = (AlphaMode::Mask { cutoff: 0.5 }, Some(0));
    scene.materials.push(material);
    let pixels = Pixels::Alpha(vec![0, 255, 153, 204]);
    let wrap = [Wrap::Repeat; 2];
    scene.textures.push(Texture {
        name: "holes".to_owned(),
        width: 2,
        height: 2,
        pixels,
        wrap,
        nearest: true,
    });
    scene
}

/// One page.
fn small_options() -> BakeOptions {
    let bounds = Some(Bounds { min: [-8.0, -1.0, -8.0], max: [8.0, 4.0, 8.0] });
    options(128).with(|o| o.bounds = bounds)
}

/// A bake reuses no entry of a scene that differs in a property that may affect pages.
#[test]
fn every_relevant_property_changes_the_keys() {
    let changes: [fn(&mut Scene); 22] = [
        |s| s.materials[1].base_color[3] = 0.4,
        |s| s.materials[1].alpha = AlphaMode::Mask { cutoff: 0.7 },
        |s| s.materials[1].alpha = AlphaMode::Opaque,
        |s| s.materials[1].texture = None,
        |s| s.materials[1].casts = false,
        |s| s.materials[0].transmissivity = 0.9,
        |s| s.textures[0].wrap[0] = Wrap::Mirror,
        |s| s.textures[0].wrap[1] = Wrap::Clamp,
        |s| s.textures[0].nearest = false,
        |s| s.textures[0].pixels = Pixels::Alpha(vec![255, 0, 153, 204]),
        |s| (s.textures[0].width, s.textures[0].height) = (4, 1),
        |s| s.meshes[2].uvs[2] = [5.0, 3.0],
        |s| s.meshes[2].colors = vec![[255, 255, 255, 160]; 4],
        |s| s.meshes[2].positions[2][1] = 3.5,
        |s| s.meshes[2].triangles[1] = [0, 1, 3],
        |s| s.meshes[2].triangle_materials[0] = 0,
        |s| s.meshes[1].triangles[0].swap(1, 2),
        |s| s.instances[2].world_from_mesh[0][3] = 0.7,
        |s| s.instances[2].mesh = 1,
        |s| s.instances[2].casts = false,
        |s| s.instances.truncate(2),
        |s| s.instances.push(s.instances[1].clone()),
    ];
    let cache: Arc<dyn BakeCache> = Arc::new(InMemory::default());
    let (scene, options) = (small_scene(), small_options());
    let (bytes, _) = with_cache(&scene, &options, &cache);
    for (number, change) in changes.iter().enumerate() {
        let mut changed = scene.clone();
        change(&mut changed);
        let (found, report) = with_cache(&changed, &options, &cache);
        assert!(found == fresh(&changed, &options), "{number}");
        assert_eq!(report.reused_root_blocks, 0, "{number}");
    }
    let (again, report) = with_cache(&scene, &options, &cache);
    assert!(again == bytes && report.reused_root_blocks == report.root_blocks);
}

#[test]
fn damaged_entries_are_rebuilt() {
    let (scene, options) = (generate(GeneratedKind::City, 3), options(1024));
    let memory = Arc::new(InMemory::default());
    let cache: Arc<dyn BakeCache> = memory.clone();
    let (bytes, _) = with_cache(&scene, &options, &cache);
    let whole: Vec<(CacheKey, Vec<u8>)> =
        memory.0.lock().unwrap().iter().map(|(key, bytes)| (*key, bytes.clone())).collect();
    let mut number = 0;
    each(&memory, |entry| {
        number += 1;
        match number % 4 {
            0 => entry.truncate(entry.len() / 2),
            1 => entry.clear(),
            2 => entry[40] ^= 1,
            _ => {
                let last = entry.len() - 1;
                entry[last] ^= 0x80;
            }
        }
    });
    let (again, report) = with_cache(&scene, &options, &cache);
    assert!(again == bytes && report.reused_root_blocks == 0);
    // The damaged entries have been replaced.
    for (key, entry) in &whole {
        assert_eq!(memory.get(key, u64::MAX).unwrap(), Fetched::Whole(entry.clone()));
    }
    // An entry under the key of another is damaged too.
    let first = whole[0].1.clone();
    each(&memory, |entry| entry.clone_from(&first));
    let (again, report) = with_cache(&scene, &options, &cache);
    // The entry is valid only under its own key: a page has at most 16 x 16 root blocks of 32 texels.
    assert!(again == bytes && (1..=256).contains(&report.reused_root_blocks), "{report:?}");
}

#[test]
fn disk_cache_removes_least_recently_used_entries_first() {
    let folder = adumbra_testing::Folder::new();
    let disk = DiskCache::create(folder.path("cache")).unwrap();
    let cache: Arc<dyn BakeCache> = Arc::new(disk.clone());
    let (scene, options) = (generate(GeneratedKind::City, 3), options(1024));
    let (bytes, _) = with_cache(&scene, &options, &cache);
    let all = disk.contents().unwrap();
    assert!(all.entries > 0 && all.bytes > 0);
    let (again, report) = with_cache(&scene, &options, &cache);
    assert!(again == bytes && report.reused_root_blocks == report.root_blocks);
    let found = disk.contents().unwrap();
    assert_eq!((found.entries, found.bytes), (all.entries, all.bytes));
    let removed = disk.prune(all.bytes / 2).unwrap();
    let left = disk.contents().unwrap();
    assert!(
        left.bytes <= all.bytes / 2 && removed.entries + left.entries == all.entries,
        "{removed:?} {left:?}"
    );
    assert_eq!(removed.bytes + left.bytes, all.bytes);
    let (again, report) = with_cache(&scene, &options, &cache);
    assert!(again == bytes && report.reused_root_blocks < report.root_blocks);
    assert!(folder.no_temporary_files());
    let error = DiskCache::open(folder.path("none")).unwrap_err();
    assert!(error.to_string().contains("none"), "{error}");
}

#[test]
fn entries_damaged_on_disk_are_rebuilt() {
    let folder = adumbra_testing::Folder::new();
    let path = PathBuf::from(folder.path("cache"));
    let cache: Arc<dyn BakeCache> = Arc::new(DiskCache::create(&path).unwrap());
    let (scene, options) = (small_scene(), small_options());
    let (bytes, _) = with_cache(&scene, &options, &cache);
    let list = |folder: PathBuf| fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let files: Vec<PathBuf> = list(path).flat_map(list).collect();
    let [file] = &files[..] else { panic!("{files:?}") };
    let whole = fs::read(file).unwrap();
    for at in [40, whole.len() - 1] {
        let mut damaged = whole.clone();
        damaged[at] ^= 1;
        fs::write(file, damaged).unwrap();
        let (again, report) = with_cache(&scene, &options, &cache);
        assert!(again == bytes && report.reused_root_blocks == 0, "{at}");
        // The damaged entry has been replaced.
        assert!(fs::read(file).unwrap() == whole, "{at}");
    }
}

/// The keys of entries include the version of the rules by which pages are made. If pages change for the same
/// surfaces, `RULES` in `src/inputs.rs` must change too, so that no bake takes pages that were made by other
/// rules.
#[test]
fn pages_change_only_with_the_version_of_the_rules() {
    let mut digest = blake3::Hasher::new();
    let generated = [GeneratedKind::City, GeneratedKind::Primitives, GeneratedKind::Wires];
    // The last one has a card with holes.
    let scenes = generated.into_iter().map(|kind| generate(kind, 3)).chain([small_scene()]);
    for scene in scenes {
        for receivers in [Receivers::All, Receivers::Static] {
            let options = options(1024).with(|o| {
                o.receivers = receivers;
                o.levels = 1;
                o.bounds = None;
            });
            let memory = Arc::new(InMemory::default());
            let cache: Arc<dyn BakeCache> = memory.clone();
            with_cache(&scene, &options, &cache);
            // Skip the heads, which depend on the version of the rules.
            let mut pages: Vec<Vec<u8>> =
                memory.0.lock().unwrap().values().map(|bytes| bytes[40..].to_vec()).collect();
            pages.sort_unstable();
            pages.iter().for_each(|page| _ = digest.update(page));
        }
    }
    let expected = "4818f7593db569c25608424b7d5674d7138e6eb36e10eaa3e3251b8211c7fddb";
    assert_eq!(
        digest.finalize().to_hex().as_str(),
        expected,
        "raise RULES in src/inputs.rs, then put this here"
    );
}
