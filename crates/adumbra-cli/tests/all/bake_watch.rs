//! `bake --watch` and `--edit`.

use std::fs;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::Duration;

use adumbra::ShadowFile;
use adumbra_testing::{Folder, adumbra};
use serde_json::Value;

const PROGRAM: &str = env!("CARGO_BIN_EXE_adumbra");
/// Fixes the frame, so that both bakes share it: with --watch it is chosen once.
const OPTIONS: [&str; 6] = ["--resolution", "1024", "--frame", "oblique", "--yaw", "0"];

fn runs(words: &[&str]) {
    let (code, said) = adumbra(words);
    assert_eq!(code, 0, "{words:?}: {said}");
}

/// A program that follows a scene, and the lines that it prints.
struct Follower {
    child: Child,
    lines: Receiver<String>,
    errors: Receiver<String>,
}

fn lines_of(from: impl std::io::Read + Send + 'static) -> Receiver<String> {
    let (sender, lines) = channel();
    thread::spawn(move || {
        for line in BufReader::new(from).lines().map_while(Result::ok) {
            if sender.send(line).is_err() {
                break;
            }
        }
    });
    lines
}

impl Follower {
    fn start(words: &[&str]) -> Self {
        let mut child =
            Command::new(PROGRAM).args(words).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let lines = lines_of(child.stdout.take().unwrap());
        let errors = lines_of(child.stderr.take().unwrap());
        Self { child, lines, errors }
    }

    /// Returns what the next bake prints.
    fn next(&self) -> Value {
        let line = self.lines.recv().expect("a bake");
        serde_json::from_str(&line).expect("JSON in one line")
    }

    fn next_error(&self) -> String {
        let is_warning = |line: &String| line.starts_with("warning");
        self.errors.iter().find(is_warning).expect("a warning")
    }
}

impl Drop for Follower {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn followed_scenes_have_the_files_of_fresh_bakes() {
    let folder = Folder::new();
    let [scene, edits, output, fresh, next] =
        ["city.glb", "moves.json", "city.adumbra", "fresh", "next.glb"].map(|name| folder.path(name));
    runs(&["generate", "city", "-o", &scene]);
    fs::write(&edits, "{}").unwrap();
    let follow = ["bake", &scene, "--edit", &edits, "-o", &output, "--watch", "--focus", "0,0,0", "--json"];
    let follower = Follower::start(&[&follow[..], &OPTIONS].concat());
    let same_as_fresh = |what: &str| {
        runs(&[&["bake", &scene, "--edit", &edits, "-o", &fresh][..], &OPTIONS].concat());
        assert!(fs::read(&output).unwrap() == fs::read(&fresh).unwrap(), "{what}");
    };
    let first = follower.next();
    assert_eq!(first["baked_parts"].as_u64().map(|baked| baked > 0), Some(true), "{first}");
    same_as_fresh("first");
    // An object is moved, one is added and one removed.
    let moves = r#"{ "moved": [{ "instance": 40, "world_from_mesh": [[1, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, -7]] }],
                     "added": [{ "like": 41, "world_from_mesh": [[1, 0, 0, 15], [0, 1, 0, 0], [0, 0, 1, 9]] }],
                     "removed": [90] }"#;
    fs::write(&edits, moves).unwrap();
    let edited = follower.next();
    assert!(edited["baked_parts"].as_u64() < edited["parts"].as_u64(), "{edited}");
    same_as_fresh("edited");
    // A half-written scene is not baked.
    let whole = fs::read(&scene).unwrap();
    fs::write(&scene, &whole[..whole.len() / 2]).unwrap();
    let warning = follower.next_error();
    assert!(warning.contains("city.glb") && warning.contains("as before"), "{warning}");
    assert!(fs::read(&output).unwrap() == fs::read(&fresh).unwrap(), "nothing was lost");
    // Another scene, and the first one again, which costs nothing where nothing differs.
    runs(&["generate", "city", "--seed", "8", "-o", &next]);
    fs::rename(&next, &scene).unwrap();
    follower.next();
    same_as_fresh("another");
    assert!(folder.no_temporary_files());
}

/// A file of the coarser levels is written only if there is no file yet.
#[test]
fn earlier_file_stays_until_all_levels_are_baked() {
    let folder = Folder::new();
    let (scene, output) = (folder.generate("city"), folder.write("city.adumbra", b"earlier"));
    let _follower =
        Follower::start(&["bake", &scene, "--resolution", "2048", "-o", &output, "--watch", "--json"]);
    let changed = loop {
        let bytes = fs::read(&output).unwrap();
        if bytes != b"earlier" {
            break bytes;
        }
        thread::sleep(Duration::from_millis(1));
    };
    assert_eq!(ShadowFile::from_bytes(&changed).unwrap().settings.resolution, 2048);
}

#[cfg(unix)]
#[test]
fn follower_ends_with_an_interrupt() {
    let folder = Folder::new();
    let (scene, output) = (folder.generate("city"), folder.path("city.adumbra"));
    let mut follower =
        Follower::start(&["bake", &scene, "--resolution", "512", "-o", &output, "--watch", "--json"]);
    follower.next();
    let process = follower.child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &process]).status().unwrap().success());
    let ended = follower.child.wait().unwrap();
    assert_eq!(ended.code(), Some(0));
    assert!(folder.no_temporary_files());
}

#[test]
fn impossible_edits_are_errors() {
    let folder = Folder::new();
    let (scene, output) = (folder.generate("city"), folder.write("out", b"earlier"));
    for (edits, expected) in [
        (r#"{ "removed": ["nobody"] }"#, "nobody"),
        (r#"{ "remove": [1] }"#, "remove"),
        (r#"{ "moved": [{ "instance": 1 }] }"#, "world_from_mesh"),
        ("not JSON", "edits.json"),
    ] {
        let file = folder.write("edits.json", edits.as_bytes());
        let (code, error) = adumbra(&["bake", &scene, "--edit", &file, "-o", &output]);
        assert!(code == 3 && error.contains(expected), "{code}: {error}");
    }
    assert_eq!(fs::read(&output).unwrap(), b"earlier");
}
