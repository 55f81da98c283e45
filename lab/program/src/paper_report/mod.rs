//! `adumbra-lab report`: measurements of every paper implemented here, and one page that shows them next to
//! the papers' own.
//!
//! A section is a list of commands of this program and of `adumbra`, each run in a separate process. The page
//! is made from the files that they write to the folder. Page and record are rewritten after each section, so
//! that a later failure loses nothing.

mod data;
mod group;
mod inputs;
mod machine;
mod page;
mod papers;
mod plan;
mod record;
mod step;

use adumbra::IoError;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use adumbra_files::{TEXT_BYTES, read_whole};
use adumbra_program::exit::{Code, Failure};
use adumbra_program::output::{format_bytes, make_folder, print_json, refuse_same, write_whole};
use adumbra_program::{say, signals};
use adumbra_scene::{GeneratedKind, generate, to_glb};
use serde_json::{Map, Value};

use self::data::Data;
use self::machine::Machine;
pub(crate) use self::record::Record;
use self::record::{Outcome as Found, SectionRecord};
use self::step::{CommandStep, Places};
use crate::args::{Report, SECTIONS};
use crate::programs::Program;
use adumbra_compare::Result;

/// Folder in which benchmarks cache traced pictures.
const CACHE: &str = "truth-cache";
/// Seed of generated scenes, the default of `adumbra generate`.
const SEED: u64 = 1;
/// Maximum size of the page.
const MAX_BYTES: u64 = 25_000_000;

/// Measures the requested sections, and writes page and record.
///
/// # Errors
///
/// Returns an error if the arguments ask for something that cannot be measured, the program `adumbra` is
/// missing, or the folder cannot be written. A section that fails is not an error; the page reports it.
pub fn run(args: &Report) -> Result<Code> {
    args.check()?;
    // Checked before anything is written, because most sections run it.
    Program::Product.path()?;
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
    // Sections measured by an earlier run are kept until they are measured again.
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
                adumbra_program::note!("{name}: skipped: {why}");
                continue;
            }
        };
        let was_measured = record.section(name).is_some();
        let begun = SectionRecord::begun(name, args.full, &record.machine);
        // Write the record first, so that even after a failure the record matches the files next to it.
        record.put(begun.clone(), &names);
        record.write(&args.output)?;
        if was_measured {
            clear(&args.output.join("data").join(name))?;
        }
        let section = measure(begun, &steps, &places, &cancel)?;
        adumbra_program::note!("{name}: {}, {:.0} s", section.outcome.words(), section.seconds());
        record.put(section, &names);
        record.write(&args.output)?;
        data.recorded(name);
        write_page(args, &record, &mut data)?;
        if cancel.load(Ordering::Relaxed) {
            break;
        }
    }
    let path = args.output.join("report.html");
    let bytes = std::fs::metadata(&path).map_err(IoError::at("read", &path))?.len();
    adumbra_program::note!("{}, {:.0} s", format_bytes(bytes), start.elapsed().as_secs_f64());
    if args.json {
        print_json(&record)?;
    } else {
        say!("{}", path.display());
    }
    if bytes > MAX_BYTES {
        adumbra_program::note!(
            "check failed: {} is larger than {}, even with its pictures at their smallest",
            path.display(),
            format_bytes(MAX_BYTES)
        );
    }
    Ok(code(&record, bytes, &cancel))
}

/// Generates a scene unless the file exists.
///
/// An existing file is never overwritten, because it may be the user's only copy. It must be identical, or
/// the report would show another scene.
fn make_scene(kind: GeneratedKind, path: &Path) -> Result<(), Failure> {
    let bytes = to_glb(&generate(kind, SEED));
    match std::fs::read(path) {
        Ok(found) if found == bytes => Ok(()),
        Ok(_) => Err(Failure::Usage(format!(
            "{}: the report generates a scene of this name, but this file is a different scene; move it to another folder, or give \
             another --output",
            path.display()
        ))),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => write_whole(path, &bytes),
        Err(e) => Err(IoError::at("read", path)(e).into()),
    }
}

/// Returns the folder in which commands run, and the folders that their variables name.
fn places(args: &Report) -> Result<Places, Failure> {
    let absolute =
        |path: &Path| Ok::<_, Failure>(std::path::absolute(path).map_err(IoError::at("find", path))?);
    let mut variables = Vec::new();
    for (name, folder) in [(plan::SCENES, &args.scenes), (plan::TRUTH, &args.truth)] {
        if let Some(folder) = folder {
            refuse_measured(args, folder)?;
            variables.push((name, absolute(folder)?));
        }
    }
    Ok(Places { folder: absolute(&args.output)?, variables })
}

/// Refuses scenes and truth inside the report's data folder, because a section is cleared before it is
/// measured again.
fn refuse_measured(args: &Report, folder: &Path) -> Result<(), Failure> {
    let data = args.output.join("data");
    match (folder.canonicalize(), data.canonicalize()) {
        (Ok(given), Ok(measured)) if given.starts_with(&measured) => Err(Failure::Usage(format!(
            "{}: this folder is in {}, which the report clears before it measures; move it elsewhere, or give another --output",
            folder.display(),
            data.display()
        ))),
        _ => Ok(()),
    }
}

/// Removes the files of an earlier report, except cached traced pictures, which are keyed by their content.
fn clear(folder: &Path) -> Result<()> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Ok(()) };
    for path in entries.filter_map(Result::ok).map(|e| e.path()) {
        let removed = match path.is_dir() {
            true if path.ends_with(CACHE) => Ok(()),
            true => std::fs::remove_dir_all(&path),
            false => std::fs::remove_file(&path),
        };
        removed.map_err(IoError::at("remove", &path))?;
    }
    Ok(())
}

/// Runs all of a section's commands, even if one of them fails. An interrupt stops the section.
fn measure(
    mut section: SectionRecord,
    steps: &[CommandStep],
    places: &Places,
    cancel: &AtomicBool,
) -> Result<SectionRecord> {
    let folder = format!("data/{}", section.section);
    make_folder(&places.folder.join(&folder))?;
    section.outcome = Found::Measured;
    for step in steps {
        adumbra_program::note!("{}", step.command());
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

/// Collects the JSON files below a folder by path.
fn collect(root: &Path, folder: &str, figures: &mut Map<String, Value>) -> Result<()> {
    let path = root.join(folder);
    let mut entries: Vec<_> = std::fs::read_dir(&path)
        .map_err(IoError::at("read", &path))?
        .filter_map(Result::ok)
        .map(|e| (e.file_name().to_string_lossy().into_owned(), e.path()))
        .collect();
    entries.sort();
    for (name, path) in entries {
        let below = format!("{folder}/{name}");
        if path.is_dir() && name != CACHE {
            collect(root, &below, figures)?;
        } else if name.ends_with(".json") {
            let bytes = read_whole(&path, TEXT_BYTES)?;
            // A file that is not valid JSON was not written by a benchmark.
            if let Ok(value) = serde_json::from_slice(&bytes) {
                figures.insert(below, value);
            }
        }
    }
    Ok(())
}

/// Writes the page, compressing its pictures more strongly if it would be larger than [`MAX_BYTES`].
fn write_page(args: &Report, record: &Record, data: &mut Data) -> Result<(), Failure> {
    let mut html = page::page(record, data);
    while html.len() as u64 > MAX_BYTES && data.save_bytes() {
        html = page::page(record, data);
    }
    write_whole(&args.output.join("report.html"), html.as_bytes())
}

/// Returns the exit code for the sections measured now and before, and for the page's size.
fn code(record: &Record, bytes: u64, cancel: &AtomicBool) -> Code {
    if cancel.load(Ordering::Relaxed) {
        return Code::Interrupted;
    }
    let fine = bytes <= MAX_BYTES && record.sections.iter().all(|s| s.outcome == Found::Measured);
    if fine { Code::Fine } else { Code::CheckFailed }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn report_code_is_fine_only_if_all_measured_and_page_fits() {
        let machine = Machine::default();
        let section = |outcome| SectionRecord { outcome, ..SectionRecord::begun("blur", false, &machine) };
        let record = |outcomes: &[Found]| Record {
            machine: machine.clone(),
            sections: outcomes.iter().map(|outcome| section(*outcome)).collect(),
        };
        let code = |outcomes: &[Found], bytes| code(&record(outcomes), bytes, &AtomicBool::new(false));
        assert_eq!(code(&[Found::Measured; 2], MAX_BYTES), Code::Fine);
        assert_eq!(code(&[Found::Measured; 2], MAX_BYTES + 1), Code::CheckFailed);
        for outcome in [Found::CheckFailed, Found::Failed, Found::Interrupted] {
            assert_eq!(code(&[Found::Measured, outcome], 0), Code::CheckFailed, "{outcome:?}");
        }
        let cancelled = super::code(&record(&[Found::Measured]), MAX_BYTES + 1, &AtomicBool::new(true));
        assert_eq!(cancelled, Code::Interrupted);
    }
}
