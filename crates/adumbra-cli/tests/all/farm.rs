//! `plan`, `tile` and `link`, and the makefile that `plan` exports. The jobs for other schedulers are tested
//! in `python/tests`, because their programs come with Python.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use adumbra_testing::{Folder, adumbra, json};

const PROGRAM: &str = env!("CARGO_BIN_EXE_adumbra");

fn runs(words: &[&str]) -> String {
    let (code, said) = adumbra(words);
    assert_eq!(code, 0, "{words:?}: {said}");
    said
}

/// Bakes a scene in one go, and plans its bake: the scene, the plan, and the bytes of the file.
fn planned(folder: &Folder, resolution: &str) -> (String, String, Vec<u8>) {
    let (scene, plan, whole) = (folder.generate("city"), folder.path("city.plan.json"), folder.path("whole"));
    runs(&["bake", &scene, "--resolution", resolution, "-o", &whole]);
    runs(&["plan", &scene, "--resolution", resolution, "-o", &plan]);
    (scene, plan, fs::read(whole).unwrap())
}

#[test]
fn shards_link_to_the_file_of_one_bake() {
    let folder = Folder::new();
    let (_, plan, whole) = planned(&folder, "1024");
    let output = folder.write("linked", b"earlier");
    let (code, error) = adumbra(&["link", "--plan", &plan, "-o", &output]);
    assert!(code == 75 && error.contains("link again"), "{code}: {error}");
    assert_eq!(fs::read(&output).unwrap(), b"earlier");
    let mut parts = 0;
    for shard in ["2/3", "0/3", "1/3"] {
        let said = json(&["tile", "--plan", &plan, "--shard", shard, "--json"]);
        assert!(said["reused"] == 0 && said["baked"].as_u64() > Some(0), "{said}");
        parts += said["baked"].as_u64().unwrap();
    }
    let said = json(&["tile", "--plan", &plan, "--ids", "0,2-4", "--json"]);
    assert!(said["baked"] == 0 && said["reused"] == 4, "{said}");
    let last = (parts - 1).to_string();
    let (code, error) = adumbra(&["tile", "--plan", &plan, "--ids", &format!("0-{parts}")]);
    assert!(code == 2 && error.contains(&last), "{code}: {error}");
    let said = json(&["link", "--plan", &plan, "-o", &output, "--json"]);
    assert_eq!(said["file_bytes"].as_u64(), Some(whole.len() as u64));
    assert!(fs::read(&output).unwrap() == whole && folder.no_temporary_files());
}

#[test]
fn plans_of_other_scenes_and_wrong_plans_are_refused() {
    let folder = Folder::new();
    let (scene, plan, _) = planned(&folder, "512");
    let other = folder.path("other.glb");
    runs(&["generate", "city", "--seed", "9", "-o", &other]);
    let (code, error) = adumbra(&["tile", "--plan", &plan, "--scene", &other]);
    assert!(code == 3 && error.contains("not the one that was planned"), "{code}: {error}");
    let text = fs::read_to_string(&plan).unwrap();
    let wrong =
        folder.write("wrong.json", text.replace("\"encoding\":\"coded\"", "\"encoding\":\"raw\"").as_bytes());
    let (code, error) = adumbra(&["tile", "--plan", &wrong]);
    assert!(
        code == 3 && error.contains("changed after it was written") && error.contains("wrong.json"),
        "{error}"
    );
    let half = folder.write("half.json", &text.as_bytes()[..text.len() / 2]);
    let (code, error) = adumbra(&["link", "--plan", &half, "-o", &folder.path("o")]);
    assert!(code == 3 && error.contains("half.json"), "{code}: {error}");
    let (code, error) = adumbra(&["tile", "--plan", &folder.path("none.json")]);
    assert!(code == 3 && error.contains("none.json"), "{code}: {error}");
    let (code, error) = adumbra(&["link", "--plan", &plan, "-o", &plan]);
    assert!(code != 0 && error.contains("--output"), "{code}: {error}");
    let (code, error) = adumbra(&["plan", &scene, "-o", &scene]);
    assert!(code != 0 && error.contains("--output"), "{code}: {error}");
    let taken = folder.write("taken", b"a file");
    let (code, error) = adumbra(&["tile", "--plan", &plan, "--cache", &taken]);
    assert!(code != 0 && error.contains("taken"), "{code}: {error}");
}

#[test]
#[ignore = "slow: takes over eight seconds"]
fn makefile_bakes_on_two_cores_and_continues() {
    if Command::new("make").arg("--version").stdout(Stdio::null()).status().is_err() {
        eprintln!("skipped: make is not installed");
        return;
    }
    let folder = Folder::new();
    // All characters that a shell or make would interpret.
    let odd = folder.path(r#"a 'b' "c" $HOME #d \# e"#);
    fs::create_dir(&odd).unwrap();
    let at = |name: &str| format!("{odd}/{name}");
    let (scene, whole) = (at("city.glb"), folder.path("whole"));
    fs::rename(folder.generate("city"), &scene).unwrap();
    runs(&["bake", &scene, "--resolution", "2048", "-o", &whole]);
    let said = json(&[
        "plan",
        &scene,
        "--resolution",
        "2048",
        "--export",
        "make",
        "--shards",
        "5",
        "--threads",
        "1",
        "--json",
    ]);
    assert_eq!(said["job"].as_str(), Some(at("city.plan.mk").as_str()), "{said}");
    let make = || {
        let command = Command::new("make").args(["-j2", "-f", &at("city.plan.mk")]).output().unwrap();
        assert!(command.status.success(), "{}", String::from_utf8_lossy(&command.stderr));
        String::from_utf8(command.stdout).unwrap()
    };
    let said = make();
    assert!(said.contains("0 were there"), "{said}");
    assert!(fs::read(at("city.adumbra")).unwrap() == fs::read(&whole).unwrap());
    let again = make();
    assert!(!again.contains(" 0 were there") && again.contains(": 0 parts"), "{again}");
    // A task that fails fails the job.
    fs::write(&scene, b"not a scene").unwrap();
    let command = Command::new("make").args(["-f", &at("city.plan.mk")]).output().unwrap();
    assert!(!command.status.success());
}

/// Runs a program, and kills it after a while unless it has ended. Returns whether it was killed.
fn kill_after(words: &[&str], pause: Duration) -> bool {
    let mut child =
        Command::new(PROGRAM).args(words).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    thread::sleep(pause);
    let running = child.try_wait().unwrap().is_none();
    // SIGKILL: nothing of the program runs after it.
    let _ = child.kill();
    child.wait().unwrap();
    running
}

/// The temporary files in a folder and below.
fn stray(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if entry.is_dir() {
            found.extend(stray(&entry));
        } else if entry.file_name().is_some_and(|name| name.to_string_lossy().contains("tmp")) {
            found.push(entry.display().to_string());
        }
    }
    found
}

fn killed_at_any_moment(kills: u32) {
    let folder = Folder::new();
    let (scene, plan, whole) = planned(&folder, "4096");
    let plan_bytes = fs::read(&plan).unwrap();
    let (linked, cache) = (folder.path("linked"), folder.path("city.plan.cache"));
    let verbs: [Vec<&str>; 3] = [
        vec!["plan", &scene, "--resolution", "4096", "-o", &plan],
        vec!["tile", "--plan", &plan],
        vec!["link", "--plan", &plan, "-o", &linked],
    ];
    let mut killed = 0;
    for verb in &verbs {
        let _ = fs::remove_dir_all(&cache);
        if verb[0] == "link" {
            runs(&["tile", "--plan", &plan]);
        }
        let start = Instant::now();
        if verb[0] != "link" || !Path::new(&linked).exists() {
            runs(verb);
        }
        let whole_run = start.elapsed();
        for number in 0..kills {
            if verb[0] == "tile" && number % 8 == 0 {
                let _ = fs::remove_dir_all(&cache);
            }
            // Kill at moments from the end of a run to its start, at which every run is killed.
            let share = f64::from(kills - 1 - number) / f64::from(kills);
            killed += u32::from(kill_after(verb, whole_run.mul_f64(share)));
        }
        runs(verb);
        assert_eq!(stray(Path::new(&folder.path("."))), Vec::<String>::new(), "{}", verb[0]);
        assert!(fs::read(&plan).unwrap() == plan_bytes);
    }
    println!("{killed} of {} runs were killed", 3 * kills);
    assert!(killed >= 3, "{killed}");
    followers_are_killed(kills, &folder, (&scene, &plan), &whole);
    assert!(fs::read(&linked).unwrap() == whole);
    let said = json(&["tile", "--plan", &plan, "--json"]);
    assert_eq!(said["baked"], 0, "no entry is damaged: {said}");
}

/// Kills programs that follow a scene while edits are made and undone.
fn followers_are_killed(kills: u32, folder: &Folder, (scene, plan): (&str, &str), whole: &[u8]) {
    let (edits, output, cache) =
        (folder.path("moves.json"), folder.path("followed"), folder.path("followed.cache"));
    let options = ["--edit", &edits, "--resolution", "4096", "--cache", &cache, "-o", &output];
    let follow = [&["bake", scene, "--watch"][..], &options].concat();
    for number in 0..kills {
        let moved = format!(r#"{{ "removed": [{number}] }}"#);
        fs::write(&edits, if number % 2 == 0 { "{}" } else { &moved }).unwrap();
        if number % 8 == 0 {
            let _ = fs::remove_dir_all(&cache);
        }
        kill_after(&follow, Duration::from_millis(u64::from(number * 37 % 100) * 12));
    }
    fs::write(&edits, "{}").unwrap();
    runs(&[&["bake", scene][..], &options].concat());
    assert!(fs::read(&output).unwrap() == whole);
    assert_eq!(stray(Path::new(&folder.path("."))), Vec::<String>::new(), "bake --watch");
    let said = json(&["tile", "--plan", plan, "--cache", &cache, "--json"]);
    assert_eq!(said["baked"], 0, "no entry is damaged: {said}");
}

/// A separate, nearly full disk. Only an administrator can mount it.
#[cfg(target_os = "linux")]
struct SmallDisk(String);

#[cfg(target_os = "linux")]
impl SmallDisk {
    fn new(folder: String) -> Option<Self> {
        fs::create_dir_all(&folder).unwrap();
        let disk = Self(folder);
        disk.mount("size=256k").then_some(disk)
    }

    fn mount(&self, option: &str) -> bool {
        let mount = Command::new("mount").args(["-t", "tmpfs", "-o", option, "tmpfs", &self.0]).output();
        mount.is_ok_and(|done| done.status.success())
    }
}

#[cfg(target_os = "linux")]
impl Drop for SmallDisk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(&self.0).status();
    }
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "slow: takes over eight seconds"]
fn full_disks_lose_nothing() {
    let folder = Folder::new();
    let Some(disk) = SmallDisk::new(folder.path("disk")) else {
        eprintln!("skipped: no file system can be mounted; run as root");
        return;
    };
    let (scene, plan, whole) = planned(&folder, "8192");
    let cache = format!("{}/cache", disk.0);
    let full = |words: &[&str]| {
        let (code, error) = adumbra(words);
        assert!(code == 4 && error.contains("disk") && error.contains("free some space"), "{code}: {error}");
    };
    full(&["tile", "--plan", &plan, "--cache", &cache]);
    // A bake needs no cache.
    let out = folder.path("out");
    let (code, error) = adumbra(&["bake", &scene, "--resolution", "8192", "--cache", &cache, "-o", &out]);
    assert!(
        code == 0 && error.contains("free some space") && error.contains("goes on without"),
        "{code}: {error}"
    );
    assert!(fs::read(&out).unwrap() == whole);
    // The baked entries are intact, and the run needs only more room.
    assert!(disk.mount("remount,size=64m"));
    let said = json(&["tile", "--plan", &plan, "--cache", &cache, "--json"]);
    assert!(said["baked"].as_u64() > Some(0) && said["reused"].as_u64() > Some(0), "{said}");
    let linked = format!("{}/linked", disk.0);
    fs::write(&linked, b"earlier").unwrap();
    // Fill the disk: the second file does not fit.
    fs::write(format!("{}/filler", disk.0), vec![0; (64 << 20) - (2 << 20)]).unwrap();
    fs::write(format!("{}/more", disk.0), vec![0; 2 << 20]).unwrap_err();
    full(&["link", "--plan", &plan, "--cache", &cache, "-o", &linked]);
    full(&["plan", &scene, "-o", &format!("{}/plan", disk.0)]);
    assert_eq!(fs::read(&linked).unwrap(), b"earlier");
    assert_eq!(stray(Path::new(&disk.0)), Vec::<String>::new());
    fs::remove_file(format!("{}/filler", disk.0)).unwrap();
    runs(&["link", "--plan", &plan, "--cache", &cache, "-o", &linked]);
    assert!(fs::read(&linked).unwrap() == whole);
}

#[test]
#[ignore = "slow: takes over eight seconds"]
fn verbs_that_are_killed_continue() {
    killed_at_any_moment(4);
}

#[test]
#[ignore = "slow: a hundred moments of each verb"]
fn verbs_that_are_killed_many_times_continue() {
    killed_at_any_moment(100);
}
