//! `adumbra report`: the measurements of every paper that is realised here, and one page that shows them beside the papers' own.
//!
//! A section is a list of commands of this program, each run in a process of its own; what they leave in the folder is what the page is
//! made of. After each section page and record are written again, so whatever happens to the next one, nothing is lost.

mod data;
mod group;
mod machine;
mod page;
mod papers;
mod plan;
mod record;
mod step;

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use adumbra::Error;
use adumbra::scene::{GeneratedKind, generate, to_glb};
use serde_json::{Map, Value};

use self::data::Data;
use self::machine::Machine;
use self::record::{Outcome as Found, Record, SectionRecord};
use self::step::{Places, Step};
use super::print_json;
use crate::args::{Report, SECTIONS};
use crate::exit::{Code, Failure, Outcome};
use crate::output::{bytes_words, make_folder, refuse_same, write_whole};
use crate::signals;

/// Where benchmarks keep traced pictures.
const CACHE: &str = "truth-cache";
/// Of scenes that are generated, as `adumbra generate` has it.
const SEED: u64 = 1;
/// Of the page.
const MOST_BYTES: u64 = 25_000_000;

pub(crate) fn run(args: &Report) -> Outcome {
    args.check()?;
    let pages = ["report.html", "report.json"].map(|name| args.output.join(name));
    refuse_same(pages.iter().map(|page| &**page))?;
    let earlier = Record::earlier(&args.output)?.map_or_else(Vec::new, |e| e.sections);
    let cancel = signals::install();
    for folder in ["scenes", "data"] {
        make_folder(&args.output.join(folder))?;
    }
    let places = places(args)?;
    let start = Instant::now();
    let machine = Machine::here();
    // What an earlier run measured stays until it is measured again.
    let mut record = Record { machine, sections: earlier };
    let mut data = Data::new(&places.folder);
    record.sections.iter().for_each(|s| data.recorded(&s.section));
    for (kind, path) in plan::made_scenes() {
        if cancel.load(Ordering::Relaxed) {
            return Ok(Code::Interrupted);
        }
        make_scene(kind, &args.output.join(path))?;
    }
    let names = SECTIONS.map(|(name, _)| name);
    for name in names {
        if !args.only.is_empty() && !args.only.iter().any(|only| only == name) {
            continue;
        }
        let steps = match plan::steps(name, args) {
            Ok(steps) => steps,
            Err(why) => {
                eprintln!("{name}: left out: {why}");
                continue;
            }
        };
        let was_measured = record.section(name).is_some();
        let begun = SectionRecord::begun(name, args.full, &record.machine);
        // First: no record may stand beside files that are not its own, whatever happens from here on.
        record.put(begun.clone(), &names);
        record.write(&args.output)?;
        if was_measured {
            clear(&args.output.join("data").join(name))?;
        }
        let section = measure(begun, &steps, &places, &cancel)?;
        eprintln!("{name}: {}, {:.0} s", section.outcome.words(), section.seconds());
        record.put(section, &names);
        record.write(&args.output)?;
        data.recorded(name);
        write_page(args, &record, &mut data)?;
        if cancel.load(Ordering::Relaxed) {
            break;
        }
    }
    let path = args.output.join("report.html");
    let bytes = std::fs::metadata(&path).map_err(Error::io("read", &path))?.len();
    eprintln!("{}, {:.0} s", bytes_words(bytes), start.elapsed().as_secs_f64());
    if args.json {
        print_json(&record.value()?);
    } else {
        say!("{}", path.display());
    }
    if bytes > MOST_BYTES {
        eprintln!(
            "check failed: {} is larger than {}, with its pictures as small as they get",
            path.display(),
            bytes_words(MOST_BYTES)
        );
    }
    Ok(code(&record, bytes, &cancel))
}

/// Generates a scene where there is none. A scene that is there stays: it must be the same, or the report would be of another one, and
/// it may be the user's only copy.
fn make_scene(kind: GeneratedKind, path: &Path) -> Result<(), Failure> {
    let bytes = to_glb(&generate(kind, SEED));
    match std::fs::read(path) {
        Ok(found) if found == bytes => Ok(()),
        Ok(_) => Err(Failure::Usage(format!(
            "{}: a report generates a scene of this name, and the file there is another one; move it to another folder, or give another \
             --output",
            path.display()
        ))),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => write_whole(path, &bytes),
        Err(e) => Err(Error::io("read", path)(e).into()),
    }
}

/// Where commands run, and what their folders are called.
fn places(args: &Report) -> Result<Places, Failure> {
    let absolute =
        |path: &Path| Ok::<_, Failure>(std::path::absolute(path).map_err(Error::io("find", path))?);
    let mut variables = Vec::new();
    for (name, folder) in [(plan::SCENES, &args.scenes), (plan::TRUTH, &args.truth)] {
        if let Some(folder) = folder {
            refuse_measured(args, folder)?;
            variables.push((name, absolute(folder)?));
        }
    }
    Ok(Places { folder: absolute(&args.output)?, variables })
}

/// Refuses scenes and truth within the report's data: a section is cleared before it is measured again.
fn refuse_measured(args: &Report, folder: &Path) -> Result<(), Failure> {
    let data = args.output.join("data");
    match (folder.canonicalize(), data.canonicalize()) {
        (Ok(given), Ok(measured)) if given.starts_with(&measured) => Err(Failure::Usage(format!(
            "{}: the report clears {} before it measures again; move it to another folder, or give another --output",
            folder.display(),
            data.display()
        ))),
        _ => Ok(()),
    }
}

/// Removes what an earlier report measured, but for traced pictures: they are found by what they show.
fn clear(folder: &Path) -> Result<(), Failure> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Ok(()) };
    for path in entries.filter_map(Result::ok).map(|e| e.path()) {
        let removed = match path.is_dir() {
            true if path.ends_with(CACHE) => Ok(()),
            true => std::fs::remove_dir_all(&path),
            false => std::fs::remove_file(&path),
        };
        removed.map_err(Error::io("remove", &path))?;
    }
    Ok(())
}

/// Runs a section's commands, all of them, whatever becomes of one.
fn measure(
    mut section: SectionRecord,
    steps: &[Step],
    places: &Places,
    cancel: &AtomicBool,
) -> Result<SectionRecord, Failure> {
    let folder = format!("data/{}", section.section);
    make_folder(&places.folder.join(&folder))?;
    section.outcome = Found::Measured;
    for step in steps {
        eprintln!("{}", step.command());
        let (record, found) = step.run(places, cancel)?;
        section.steps.push(record);
        section.outcome = worse(section.outcome, found);
        if found == Found::Interrupted {
            break;
        }
    }
    collect(&places.folder, &folder, &mut section.figures)?;
    Ok(section)
}

fn worse(a: Found, b: Found) -> Found {
    let rank = |found| match found {
        Found::Measured => 0,
        Found::CheckFailed => 1,
        Found::Failed => 2,
        Found::Interrupted => 3,
    };
    if rank(a) < rank(b) { b } else { a }
}

/// JSON files below a folder, by path.
fn collect(root: &Path, folder: &str, figures: &mut Map<String, Value>) -> Result<(), Failure> {
    let path = root.join(folder);
    let mut entries: Vec<_> = std::fs::read_dir(&path)
        .map_err(Error::io("read", &path))?
        .filter_map(Result::ok)
        .map(|e| (e.file_name().to_string_lossy().into_owned(), e.path()))
        .collect();
    entries.sort();
    for (name, path) in entries {
        let below = format!("{folder}/{name}");
        if path.is_dir() && name != CACHE {
            collect(root, &below, figures)?;
        } else if name.ends_with(".json") {
            let bytes = std::fs::read(&path).map_err(Error::io("read", &path))?;
            // What is no JSON was not written by a benchmark.
            if let Ok(value) = serde_json::from_slice(&bytes) {
                figures.insert(below, value);
            }
        }
    }
    Ok(())
}

/// Writes the page, its pictures with less bytes where it would be larger than [`MOST_BYTES`].
fn write_page(args: &Report, record: &Record, data: &mut Data) -> Result<(), Failure> {
    let mut html = page::page(record, data);
    while html.len() as u64 > MOST_BYTES && data.save_bytes() {
        html = page::page(record, data);
    }
    write_whole(&args.output.join("report.html"), html.as_bytes())
}

/// What the caller is told: of the sections measured now and before, and of the page's size.
fn code(record: &Record, bytes: u64, cancel: &AtomicBool) -> Code {
    if cancel.load(Ordering::Relaxed) {
        return Code::Interrupted;
    }
    let fine = bytes <= MOST_BYTES && record.sections.iter().all(|s| s.outcome == Found::Measured);
    if fine { Code::Fine } else { Code::CheckFailed }
}
