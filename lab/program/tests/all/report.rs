//! `report`: the page as a browser shows it, and the results kept and errors reported after failures.

use std::fs;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use adumbra_testing::{Folder, lab, lab_program};
use serde_json::{Value, json};

use crate::browser::Browser;

/// Maximum size of the page in bytes.
const MAX_BYTES: u64 = 25_000_000;

fn record(folder: &Folder) -> Value {
    serde_json::from_slice(&fs::read(folder.path("r/report.json")).unwrap()).unwrap()
}

fn page(folder: &Folder) -> String {
    fs::read_to_string(folder.path("r/report.html")).unwrap()
}

/// Runs the program without a Vulkan driver, so that the blur has no device to draw on.
fn without_driver(arguments: &[&str]) -> Output {
    let mut command = Command::new(lab_program());
    command.args(arguments);
    command.env("VK_DRIVER_FILES", "/nowhere.json").env("VK_ICD_FILENAMES", "/nowhere.json");
    command.output().unwrap()
}

/// Writes the record of another machine with the given sections and outcomes.
fn earlier(folder: &Folder, sections: &[(&str, &str)]) {
    let machine = json!({
        "date": "2020-02-20", "adumbra": "0.0.1", "revision": "abcdef", "cpu": "a processor", "cores": 3, "memory_bytes": 0,
        "system": "a system", "adapter": "an adapter", "software": false, "missing_features": [],
    });
    let section = |(name, outcome): &(&str, &str)| {
        fs::create_dir_all(folder.path(&format!("r/data/{name}"))).unwrap();
        json!({"section": name, "full": true, "machine": machine, "outcome": outcome, "steps": [], "figures": {}})
    };
    let sections: Vec<Value> = sections.iter().map(section).collect();
    let record = json!({"machine": machine, "sections": sections});
    folder.write("r/report.json", record.to_string().as_bytes());
}

#[test]
fn report_rejects_arguments_it_cannot_measure() {
    let folder = Folder::new();
    let out = folder.path("r");
    for (options, word) in [
        (vec!["--full"], "--scenes"),
        (vec!["--only", "peers"], "--truth"),
        (vec!["--only", "fast"], "--full"),
        (vec!["--scenes", "/nowhere"], "no such folder"),
        (vec!["--size", "8x8"], "--size"),
        (vec!["--quick", "--full"], "--full"),
    ] {
        let (code, error) = lab(&[&["report", "-o", &out][..], &options].concat());
        assert_eq!(code, 2, "{options:?}: {error}");
        assert!(error.contains(word), "{options:?}: {error}");
    }
    assert!(!folder.exists("r"));
    folder.write("report.json", b"[1, 2]");
    let (code, error) = lab(&["report", "-o", &folder.path(""), "--only", "verify"]);
    assert_eq!(code, 3, "{error}");
    assert!(error.contains("not the record of an earlier report") && !folder.exists("data"), "{error}");
}

#[test]
#[ignore = "slow: a report"]
fn report_keeps_measured_sections_and_lists_failures() {
    let folder = Folder::new();
    let out = folder.path("r");
    let (code, error) = lab(&["report", "-o", &out, "--only", "verify"]);
    assert_eq!(code, 0, "{error}");
    assert_eq!(record(&folder)["sections"][0]["outcome"], "measured");

    let run = without_driver(&["report", "-o", &out, "--only", "blur", "--json"]);
    assert_eq!(run.status.code(), Some(1), "{}", adumbra_testing::stderr(&run));
    let said: Value = serde_json::from_slice(&run.stdout).unwrap();
    assert_eq!(said, record(&folder), "--json prints what is written");
    let sections = said["sections"].as_array().unwrap();
    let outcomes: Vec<[&str; 2]> =
        sections.iter().map(|s| ["section", "outcome"].map(|key| s[key].as_str().unwrap())).collect();
    assert_eq!(outcomes, [["verify", "measured"], ["blur", "failed"]]);
    let cause = sections[1]["steps"][0]["error"].as_str().unwrap();
    assert!(cause.contains("adapter"), "{cause}");
    let figures = &sections[0]["figures"]["data/verify/verify.json"];
    assert_eq!(figures["rows"].as_array().unwrap().len(), 42, "three scenes, seven suns, two layouts");
    let page = page(&folder);
    assert!(page.contains("Agreement with rays") && page.contains("adumbra-lab bench verify"));
    assert!(
        page.contains("Not every section succeeded: blur (failed)")
            && page.contains("adumbra-lab bench blur")
    );
}

#[test]
fn report_marks_figures_of_other_runs_and_hides_unrecorded() {
    let folder = Folder::new();
    let out = folder.path("r");
    earlier(&folder, &[("verify", "measured"), ("blur", "interrupted")]);
    let kept = record(&folder)["sections"][0].clone();
    folder.write("r/data/verify/verify.md", b"# Kept\n\nkept words\n");
    folder.write("r/data/blur/blur.md", b"# Cut off\n\nwords of a run cut off\n");
    fs::create_dir_all(folder.path("r/data/bake")).unwrap();
    folder.write("r/data/bake/bake.md", b"# Unknown\n\nwords without a record\n");

    let run = without_driver(&["report", "-o", &out, "--only", "blur"]);
    assert_eq!(run.status.code(), Some(1), "{}", adumbra_testing::stderr(&run));
    let record = record(&folder);
    assert_eq!(record["sections"][0], kept);
    assert_eq!(record["sections"][1]["outcome"], "failed");
    assert_eq!(record["sections"][1]["machine"], record["machine"]);
    assert_ne!(record["machine"]["adapter"], "an adapter");
    let page = page(&folder);
    assert!(page.contains("kept words") && page.contains("2020-02-20"));
    assert!(
        page.contains("<code>verify</code> was measured on another machine")
            && page.contains("adapter an adapter")
    );
    assert!(page.contains("revision abcdef"));
    assert!(!page.contains("words without a record"));
    assert!(!page.contains("words of a run cut off") && !folder.exists("r/data/blur/blur.md"));
}

#[test]
fn report_error_names_an_oversized_page() {
    let folder = Folder::new();
    earlier(&folder, &[("bake", "measured")]);
    let text = format!("# Bakes\n\n{}\n", "many words ".repeat(MAX_BYTES as usize / 11));
    folder.write("r/data/bake/bake.md", text.as_bytes());
    // Without a driver the section fails at once. That alone also causes exit code 1; the unit tests of
    // `code` cover the page size alone.
    let run = without_driver(&["report", "-o", &folder.path("r"), "--only", "blur"]);
    let error = adumbra_testing::stderr(&run);
    assert_eq!(run.status.code(), Some(1), "{error}");
    let says = |line: &str| line.starts_with("check failed: ") && line.contains("report.html is larger than");
    assert!(error.lines().any(says), "{error}");
    let page = page(&folder);
    assert!(page.len() as u64 > MAX_BYTES && page.contains("blur (failed)"), "{} bytes", page.len());
}

#[test]
fn report_names_the_revision_of_its_sources() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let git = |arguments: &[&str]| {
        let output = Command::new("git").args(["-C", root]).args(arguments).output();
        let output = output.ok().filter(|o| o.status.success());
        output.map_or_else(String::new, |o| String::from_utf8_lossy(&o.stdout).trim().to_owned())
    };
    // Sources outside their own repository have no revision.
    let own = !git(&["ls-files", "lab/program/build.rs"]).is_empty()
        && git(&["rev-parse", "--show-prefix"]).is_empty();
    let head = if own { git(&["rev-parse", "--short=12", "HEAD"]) } else { String::new() };
    let folder = Folder::new();
    let run = without_driver(&["report", "-o", &folder.path("r"), "--only", "blur"]);
    assert_eq!(run.status.code(), Some(1), "{}", adumbra_testing::stderr(&run));
    let record = record(&folder);
    let revision = record["machine"]["revision"].as_str().unwrap();
    assert_eq!(revision.trim_end_matches("-dirty"), head);
}

/// Sends a signal to one process.
#[cfg(unix)]
fn signal(name: &str, process: u32) {
    // If it has ended already, there is nothing to signal.
    let _ = Command::new("kill").args([&format!("-{name}"), &process.to_string()]).status().unwrap();
}

/// Starts a report with its output discarded.
#[cfg(unix)]
fn start_report(out: &str, options: &[&str]) -> Child {
    let mut command = Command::new(lab_program());
    command.args(["report", "-o", out]).args(options).stderr(Stdio::null()).stdout(Stdio::null());
    command.spawn().unwrap()
}

#[cfg(unix)]
#[test]
#[ignore = "slow: a report"]
fn interrupted_report_keeps_finished_sections() {
    let folder = Folder::new();
    let mut child = start_report(&folder.path("r"), &["--only", "verify,tree"]);
    while !folder.exists("r/data/tree") {
        std::thread::sleep(Duration::from_millis(20));
    }
    // The signal goes to this process alone. The command that it runs must end too.
    signal("INT", child.id());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let record = record(&folder);
    assert_eq!(record["sections"][0]["section"], "verify");
    assert_eq!(record["sections"][0]["outcome"], "measured");
    assert_eq!(record["sections"][1]["outcome"], "interrupted");
    assert!(page(&folder).contains("Agreement with rays"));
}

#[cfg(unix)]
#[test]
fn report_keeps_earlier_records_until_they_are_replaced() {
    let folder = Folder::new();
    earlier(&folder, &[("bake", "measured"), ("hrsm", "measured")]);
    folder.write("r/data/bake/bake.md", b"# Old\n");
    folder.write("r/data/hrsm/hrsm.md", b"# Kept\n\nkept words\n");
    let kept = record(&folder)["sections"][1].clone();
    // All sections are run. The first one clears its old data.
    let mut child = start_report(&folder.path("r"), &[]);
    while folder.exists("r/data/bake/bake.md") {
        std::thread::sleep(Duration::from_millis(20));
    }
    signal("INT", child.id());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let record = record(&folder);
    assert_eq!(record["sections"].as_array().unwrap().len(), 2);
    assert_eq!(record["sections"][0]["outcome"], "interrupted");
    assert_eq!(record["sections"][0]["machine"], record["machine"]);
    assert_eq!(record["sections"][1], kept);
    assert!(page(&folder).contains("kept words"));
}

/// Returns the processes that run in `folder`, each with its first argument.
#[cfg(target_os = "linux")]
fn running(folder: &str) -> Vec<(u32, String)> {
    let folder = fs::canonicalize(folder).unwrap();
    let processes = fs::read_dir("/proc").unwrap().flatten().filter_map(|entry| {
        let process = entry.file_name().to_str()?.parse().ok()?;
        let here = fs::read_link(entry.path().join("cwd")).ok()? == folder;
        let words = fs::read_to_string(entry.path().join("cmdline")).ok()?;
        here.then(|| (process, words.split('\0').nth(1).unwrap_or_default().to_owned()))
    });
    processes.collect()
}

#[cfg(target_os = "linux")]
#[test]
fn interrupted_report_ends_processes_of_its_command() {
    let folder = Folder::new();
    let out = folder.path("r");
    let mut child = start_report(&out, &["--only", "bake"]);
    // Stop the bake, so that it cannot react to a request to end.
    loop {
        std::thread::sleep(Duration::from_millis(5));
        let processes = if folder.exists("r") { running(&out) } else { Vec::new() };
        let Some((bake, _)) = processes.into_iter().find(|(_, verb)| verb == "bake") else { continue };
        signal("STOP", bake);
        let state = fs::read_to_string(format!("/proc/{bake}/stat")).unwrap_or_default();
        if state.contains(") T ") {
            break;
        }
    }
    signal("TERM", child.id());
    let status = child.wait().unwrap();
    let left = running(&out);
    // Kill the processes before any assertion, because a failure would leave them running.
    left.iter().map(|(process, _)| *process).for_each(|process| signal("KILL", process));
    assert_eq!(status.code(), Some(130));
    assert_eq!(left, []);
    assert_eq!(record(&folder)["sections"][0]["outcome"], "interrupted");
}

#[test]
#[ignore = "slow: a report in a browser"]
fn report_page_works_in_browser_without_other_files() {
    let Some(mut browser) = Browser::start() else { return };
    let folder = Folder::new();
    let out = folder.path("r");
    let (code, error) = lab(&["report", "-o", &out, "--only", "blur,shadows", "--size", "96x64"]);
    assert_eq!(code, 0, "{error}");
    let path = folder.path("r/report.html");
    assert!(fs::metadata(&path).unwrap().len() <= MAX_BYTES);

    browser.resize(1280, 900, false);
    browser.open(&path);
    let loaded = browser.eval("[...document.images].map(i => i.complete && i.naturalWidth > 0)");
    let loaded = loaded.as_array().unwrap();
    assert!(loaded.len() >= 18 && loaded.iter().all(|l| *l == true), "{loaded:?}");
    assert_eq!(browser.requests(), [format!("file://{path}")], "only the page is requested");
    assert!(browser.eval("[...document.images].every(i => i.alt.length > 5)") == true);

    sliders_move(&mut browser);
    links_lead_somewhere(&mut browser);

    browser.resize(390, 844, true);
    let [scrolled, shown] = ["scrollWidth", "clientWidth"]
        .map(|w| browser.eval(&format!("document.documentElement.{w}")).as_f64().unwrap());
    assert!(scrolled <= shown && shown <= 390.0, "{scrolled} in {shown}");
    let tables = browser.eval("[...document.querySelectorAll('table')].every(t => t.closest('.scroll'))");
    assert_eq!(tables, true, "tables scroll in boxes of their own");

    prints(&mut browser);
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// Checks that sliders move, by keyboard input to the range and by pointer.
fn sliders_move(browser: &mut Browser) {
    let pairs = browser.eval("document.querySelectorAll('figure.pair').length").as_u64().unwrap();
    assert!(pairs >= 9, "{pairs} pairs");
    let clip = "getComputedStyle(document.querySelector('figure.pair .right')).clipPath";
    let middle = browser.eval(clip);
    browser.eval("document.querySelector('figure.pair').scrollIntoView({block: 'center'})");
    browser.eval("document.querySelector('figure.pair input').focus()");
    for kind in ["keyDown", "keyUp"] {
        let key = json!({"type": kind, "key": "ArrowLeft", "code": "ArrowLeft", "windowsVirtualKeyCode": 37});
        browser.call("Input.dispatchKeyEvent", &key);
    }
    assert_eq!(browser.eval("document.querySelector('figure.pair input').value"), "49");
    let stepped = browser.eval(clip);
    assert_ne!(middle, stepped);
    let corner = "(b => [b.left + b.width / 4, b.top + b.height / 2])(document.querySelector('figure.pair .frame').getBoundingClientRect())";
    let [x, y] = [0, 1].map(|i| browser.eval(corner)[i].as_f64().unwrap());
    for kind in ["mousePressed", "mouseReleased"] {
        let event = json!({"type": kind, "x": x, "y": y, "button": "left", "clickCount": 1});
        browser.call("Input.dispatchMouseEvent", &event);
    }
    assert_eq!(browser.eval("document.querySelector('figure.pair input').value"), "25");
    assert_ne!(browser.eval(clip), stepped);
    // Every slider moves when its value is set.
    let all = browser.eval(
        "[...document.querySelectorAll('figure.pair')].every(p => { const i = p.querySelector('input'); i.value = 10; \
         i.dispatchEvent(new Event('input')); return getComputedStyle(p.querySelector('.right')).clipPath.includes('10%'); })",
    );
    assert_eq!(all, true);
}

fn links_lead_somewhere(browser: &mut Browser) {
    let broken = browser.eval(
        "[...document.querySelectorAll('a[href^=\"#\"]')].map(a => a.getAttribute('href')).filter(h => !document.querySelector(h))",
    );
    assert_eq!(broken, json!([]));
    let twice = browser.eval(
        "(ids => ids.filter((id, i) => ids.indexOf(id) !== i))([...document.querySelectorAll('[id]')].map(e => e.id))",
    );
    assert_eq!(twice, json!([]), "ids are unique");
}

/// Checks printing to PDF: both pictures of a pair are side by side, and folded parts are open.
fn prints(browser: &mut Browser) {
    browser.call("Emulation.setEmulatedMedia", &json!({"media": "print"}));
    let beside = browser.eval(
        "[...document.querySelectorAll('figure.pair')].every(p => { const [a, b] = ['.left', '.right'].map(s => \
         p.querySelector(s).getBoundingClientRect()); return b.left >= a.right && b.width > 0 && \
         getComputedStyle(p.querySelector('.right')).clipPath === 'none'; })",
    );
    assert_eq!(beside, true);
    browser.call("Emulation.setEmulatedMedia", &json!({"media": ""}));
    let pdf = browser.call("Page.printToPDF", &json!({"printBackground": true}));
    let pdf = pdf["data"].as_str().unwrap();
    assert!(pdf.starts_with("JVBERi") && pdf.len() > 100_000, "{} characters of PDF", pdf.len());
}
