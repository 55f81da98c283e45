//! Same input, same bytes: compares files with those that an earlier revision wrote, byte for byte. A change
//! that is meant to alter them must rewrite the lists in `same_bytes/` and give the reason.

use std::io::Cursor;
use std::path::Path;

use adumbra::{Encoding, Sun};
use adumbra_bake::{AssumeGround, Bake, BakeOptions, FrameChoice, Size, Watch};
use adumbra_papers::dag::DagLayout;
use adumbra_papers::dag::build::{self, DagOptions};
use adumbra_papers::tree::{TreeFile, TreeOptions, bake_tree};
use adumbra_scene::{GeneratedKind, LoadOptions, Scene, generate, load, to_glb};
use adumbra_testing::{full, shared};
use rayon::prelude::*;
use sha2::{Digest, Sha256};

/// Returns the entries of a list: digest, scene and kind of file.
fn listed(text: &str) -> impl Iterator<Item = [&str; 3]> {
    text.lines().filter(|line| !line.starts_with('#')).map(|line| {
        let words: Vec<&str> = line.split(' ').collect();
        words.try_into().expect("a digest, a scene and a kind")
    })
}

/// Returns the digest of the file of this kind.
fn digest(scene: &Scene, kind: &str, [resolution, tree_resolution]: [u64; 2]) -> String {
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    let assume_ground = AssumeGround::Yes;
    let in_frame = |frame| {
        BakeOptions::new(sun, Size::Resolution(resolution)).with(|o| {
            o.frame = frame;
            o.assume_ground = assume_ground;
        })
    };
    let mut bytes = Cursor::new(Vec::new());
    let mut quadtree = |frame| {
        Bake::with_options(scene, &in_frame(frame)).in_memory().unwrap().write_to(&mut bytes, Encoding::Raw)
    };
    match kind {
        "depths" => quadtree(FrameChoice::Light),
        "oblique" => quadtree(FrameChoice::Oblique),
        "auto" => quadtree(FrameChoice::Auto),
        "packed" | "plain" => {
            let layout = if kind == "plain" { DagLayout::Plain } else { DagLayout::Packed };
            let options = DagOptions { bake: in_frame(FrameChoice::Light), layout };
            build::bake(scene, &options, Watch::none()).unwrap().file.write_to(&mut bytes)
        }
        "tree" => {
            let options = TreeOptions::new(sun, Size::Resolution(tree_resolution));
            TreeFile::from(bake_tree(scene, &options, Watch::none()).unwrap()).write_to(&mut bytes)
        }
        other => panic!("no kind of file is called {other}"),
    }
    .unwrap();
    hex(bytes.get_ref())
}

fn hex(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect()
}

/// Compares each listed digest with that of the file baked from the scene of that name or, for the kind
/// `glb`, with that of the scene's own bytes. Scenes are baked in parallel, because their order must not
/// change the bytes. A failure prints the lines that a new list would have. Only every `every`-th file of the
/// list is baked.
fn check(
    list: &str,
    resolutions: [u64; 2],
    every: usize,
    scene_of: impl Fn(&str) -> (Scene, Vec<u8>) + Sync,
) {
    let all: Vec<[&str; 3]> = listed(list).step_by(every).collect();
    let scenes: Vec<&[[&str; 3]]> = all.chunk_by(|a, b| a[1] == b[1]).collect();
    let changed = scenes.par_iter().flat_map_iter(|kinds| {
        let name = kinds[0][1];
        let (scene, bytes) = scene_of(name);
        kinds.iter().filter_map(move |[expected, _, kind]| {
            let found = if *kind == "glb" { hex(&bytes) } else { digest(&scene, kind, resolutions) };
            (found != *expected).then(|| format!("{found} {name} {kind}"))
        })
    });
    let changed: Vec<String> = changed.collect();
    assert!(
        changed.is_empty(),
        "{} of {} files have other bytes:\n{}",
        changed.len(),
        all.len(),
        changed.join("\n")
    );
}

#[test]
fn same_bytes_for_a_generated_scene() {
    let all = include_str!("same_bytes/generated.txt").lines();
    let of_primitives: Vec<&str> = all.filter(|line| line.contains(" primitives ")).collect();
    generated_scenes_have_the_same_bytes(&of_primitives.join("\n"), 4);
}

#[test]
#[ignore = "slow: bakes nine scenes; in every kind of file with ADUMBRA_FULL"]
fn same_bytes_for_generated_scenes() {
    generated_scenes_have_the_same_bytes(
        include_str!("same_bytes/generated.txt"),
        if full() { 1 } else { 3 },
    );
}

fn generated_scenes_have_the_same_bytes(list: &str, every: usize) {
    check(list, [1024, 256], every, |name| {
        let all = [
            ("spheres", GeneratedKind::Spheres),
            ("primitives", GeneratedKind::Primitives),
            ("landscape", GeneratedKind::Landscape),
            ("city", GeneratedKind::City),
            ("ball", GeneratedKind::Ball),
            ("sphere-grid", GeneratedKind::SphereGrid),
            ("wires", GeneratedKind::Wires),
            ("cornell", GeneratedKind::Cornell),
            ("forest", GeneratedKind::Forest),
        ];
        let (_, kind) = all.into_iter().find(|(known, _)| *known == name).unwrap();
        // Loaded from a file, as the program does.
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.glb");
        let bytes = to_glb(&generate(kind, 1));
        std::fs::write(&path, &bytes).unwrap();
        (load(&path, &LoadOptions::default()).unwrap(), bytes)
    });
}

#[test]
#[ignore = "slow: real scenes; all of their files with ADUMBRA_FULL"]
fn shared_scenes_give_the_same_bytes() {
    let Some(scenes) = shared("scenes") else { return };
    check(include_str!("same_bytes/shared.txt"), [2048, 1024], if full() { 1 } else { 23 }, |name| {
        let options = LoadOptions { allow_outside: true, ..LoadOptions::default() };
        (load(&Path::new(&scenes).join(name), &options).unwrap(), Vec::new())
    });
}
