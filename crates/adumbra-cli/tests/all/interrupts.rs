//! Interrupts end every verb in any phase, and leave earlier files as they were.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use adumbra_testing::{Folder, adumbra, program};

/// Waits until a process catches interrupts.
pub(crate) fn wait_for_handler(process: u32) {
    let catches_interrupts = || {
        let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap();
        assert!(!status.contains("State:\tZ"), "it ended before it could be interrupted");
        let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap().trim();
        // Bit 1 is that of signal 2, SIGINT.
        u64::from_str_radix(caught, 16).unwrap() & 0b10 != 0
    };
    while !catches_interrupts() {
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn start(words: &[&str]) -> Child {
    Command::new(program()).args(words).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

fn send(signal: &str, child: &Child) {
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
}

/// The phases are loading, sorting, the glance, the forecast of the frame and baking.
#[test]
fn interrupted_bake_ends_in_any_phase_and_keeps_earlier_file() {
    let folder = Folder::new();
    let scene = folder.generate("city");
    let file = folder.write("p.adumbra", b"earlier");
    let words = ["bake", &scene, "--resolution", "65536", "-o", &file];
    for (number, signal) in ["-INT", "-TERM", "-HUP"].into_iter().cycle().take(12).enumerate() {
        let mut child = start(&words);
        wait_for_handler(child.id());
        std::thread::sleep(Duration::from_millis(20 * number as u64));
        send(signal, &child);
        // Without its handler a signal would end the program without a code.
        assert_eq!(child.wait().unwrap().code(), Some(130), "{number}");
        assert_eq!(fs::read(&file).unwrap(), b"earlier");
        assert!(folder.no_temporary_files(), "{number}");
    }
}

#[test]
fn every_long_verb_ends_when_it_is_interrupted() {
    let folder = Folder::new();
    let scene = folder.generate("city");
    let (file, plan) = (folder.path("p.adumbra"), folder.path("p.plan.json"));
    let coarse = ["--resolution", "256", "--levels", "1"];
    assert_eq!(adumbra(&[&["bake", &scene, "-o", &file], &coarse[..]].concat()).0, 0);
    assert_eq!(adumbra(&["plan", &scene, "-o", &plan, "--resolution", "65536"]).0, 0);
    let table = folder.write("h.csv", b"earlier");
    let picture = folder.write("p.png", b"earlier");
    let fine = ["--resolution", "65536"];
    let place =
        ["--lat", "48", "--lon", "11.5", "--date", "2026-06-21", "--tz", "UTC", "--from", "7", "--to", "19"];
    let (demo, tiles, report) = (folder.path("demo"), folder.path("tiles"), folder.path("compare"));
    for words in [
        &[&["bake", &scene, "--regions=8192", "-o", &folder.path("r.json")], &fine[..]].concat()[..],
        &[&["plan", &scene, "-o", &folder.path("q.plan.json")], &fine[..]].concat(),
        &["tile", "--plan", &plan, "--cache", &tiles],
        &["verify", &file, "--scene", &scene, "--samples", "1000000000"],
        &[&["sun-hours", &scene, "--grid", "0.2", "-o", &table], &place[..]].concat(),
        &["render", &scene, "--truth", "--size", "4000x4000", "-o", &picture],
        &["compare", &scene, "--shadow", "voxel", "-o", &report],
        &["demo", "--resolution", "65536", "--out", &demo],
    ] {
        let mut child = start(words);
        wait_for_handler(child.id());
        send("-TERM", &child);
        assert_eq!(child.wait().unwrap().code(), Some(130), "{words:?}");
        assert_eq!(fs::read(&table).unwrap(), b"earlier");
        assert_eq!(fs::read(&picture).unwrap(), b"earlier");
        assert!(folder.no_temporary_files(), "{words:?}");
    }
    assert!(!Path::new(&folder.path("q.plan.json")).exists());
}

/// Ignores the signal for the program as `nohup` does.
#[test]
fn ignored_hangup_does_not_end_the_program() {
    let folder = Folder::new();
    let (scene, file) = (folder.generate("city"), folder.path("p.adumbra"));
    let mut child = Command::new("sh")
        .args(["-c", "trap '' HUP; exec \"$0\" bake \"$1\" --resolution 1024 --progress none -o \"$2\""])
        .arg(program())
        .args([&scene, &file])
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    wait_for_handler(child.id());
    send("-HUP", &child);
    assert_eq!(child.wait().unwrap().code(), Some(0));
}
