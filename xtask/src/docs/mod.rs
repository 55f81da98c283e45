//! `cargo xtask docs`: runs the commands of the documents and checks what the documents say about them.
//!
//! The `sh` blocks of the README, of `docs/` and of `docs/guides/` run in order in a copy of the repository,
//! one copy per document. The comment after each block states its checks ([`check`]). A block without such a
//! comment is an error, and so is a block that takes longer than its [`Depth`] allows. The task also follows
//! every link, looks up every verb and option that the text names in its program's help, and runs the
//! examples.

mod check;
mod display;
mod limit;
mod links;
mod markdown;
mod shell;

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use check::{Check, Printed};
use limit::{Interrupt, Limit};
use markdown::{Block, MarkdownFile};
use shell::Clone;

use crate::steps::{Cargo, PROFILE, target_folder};

/// Folders whose documents are read.
const FOLDERS: [&str; 6] = ["", "docs", "docs/guides", "docs/bench", "spec", "fuzz"];
/// Folders whose documents' commands are run. The commands of the fuzzer need another compiler.
const RUN: [&str; 3] = ["", "docs", "docs/guides"];
/// Examples that are run in addition to the documents.
const EXAMPLES: [&str; 3] = ["bake_and_query", "engine", "compare_two"];
/// Names of the programs.
const PRODUCT: &str = "adumbra";
const LABORATORY: &str = "adumbra-lab";
/// Command that runs the second program from a checkout.
const RUN_LABORATORY: &str = "cargo run --release -p adumbra-lab -- ";
/// Option of both programs that ends them once their arguments are parsed.
const PARSE_ONLY: &str = "--check-arguments";

/// The document whose commands are run at every [`Depth`].
const README: &str = "README.md";

/// How much of the documents is run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Depth {
    /// Every command unchanged, with 20 minutes per block.
    Full,
    /// Existing builds, with smaller numbers where a check gives them. For blocks marked `long`, only the
    /// arguments are parsed. 5 minutes per block.
    Quick,
    /// Like `Quick`, but for all documents except the README, only the arguments are parsed.
    Parse,
}

impl Depth {
    fn limit(self) -> Duration {
        Duration::from_secs(60 * if self == Self::Full { 20 } else { 5 })
    }

    /// The profile of the programs, by the name of its folder.
    fn profile(self) -> &'static str {
        if self == Self::Full { "release" } else { PROFILE }
    }
}

pub(crate) fn run(root: &Path, words: &[&str]) -> Result<(), Box<dyn Error>> {
    let interrupt = Interrupt::install()?;
    let (depth, named) = match words {
        ["--quick", named @ ..] => (Depth::Quick, named),
        ["--parse", named @ ..] => (Depth::Parse, named),
        named => (Depth::Full, named),
    };
    let documents = read(root, named)?;
    let mut faults = links::faults(root, &documents);
    if depth == Depth::Full {
        Cargo::new(root).run(&["build", "--release", "--workspace", "--bins", "--examples"])?;
    } else {
        Cargo::linting(root)?.run(&BUILD)?;
    }
    let mut order: Vec<&PathBuf> = documents.keys().collect();
    order.sort();
    for path in order {
        if path.parent().is_some_and(|folder| RUN.iter().any(|run| Path::new(run) == folder)) {
            faults.extend(run_document(root, path, &documents[path], depth, &interrupt)?);
        }
    }
    for name in [PRODUCT, LABORATORY] {
        let program = Program {
            name,
            path: target_folder(root).join(depth.profile()).join(name),
            help: BTreeMap::new(),
        };
        faults.extend(program.faults(&documents, named.is_empty()));
    }
    if named.is_empty() {
        faults.extend(run_examples(root, depth, &interrupt)?);
    }
    if faults.is_empty() {
        return Ok(());
    }
    Err(format!("{}\n{} faults in the documents", faults.join("\n"), faults.len()).into())
}

/// Reads the named documents, or all if none is named, by their paths below the root.
fn read(root: &Path, named: &[&str]) -> Result<HashMap<PathBuf, MarkdownFile>, Box<dyn Error>> {
    let mut paths: Vec<PathBuf> = named.iter().map(PathBuf::from).collect();
    if named.is_empty() {
        for folder in FOLDERS {
            for entry in fs::read_dir(root.join(folder))? {
                let name = PathBuf::from(entry?.file_name());
                if name.extension().is_some_and(|e| e == "md") {
                    paths.push(Path::new(folder).join(name));
                }
            }
        }
    }
    let document = |path: PathBuf| match fs::read_to_string(root.join(&path)) {
        Ok(text) => Ok((path, MarkdownFile::read(&text))),
        Err(e) => Err(format!("{}: {e}", path.display()).into()),
    };
    paths.into_iter().map(document).collect()
}

/// Arguments of cargo that build the programs, the examples and all tests. Building the programs alone would
/// build most of the workspace a second time, without the features that only tests request.
pub(crate) const BUILD: [&str; 6] = ["test", "--no-run", "--quiet", "--profile", PROFILE, "--workspace"];

/// Runs a document's blocks and returns all faults.
fn run_document(
    root: &Path,
    path: &Path,
    document: &MarkdownFile,
    depth: Depth,
    interrupt: &Interrupt,
) -> std::io::Result<Vec<String>> {
    let mut faults = Vec::new();
    if document.blocks.is_empty() {
        return Ok(faults);
    }
    let mut clone = Clone::of(root, depth)?;
    if document.blocks.iter().flat_map(|b| &b.commands).any(|c| c.starts_with("adumbra view ")) {
        clone.open_display()?;
    }
    for block in &document.blocks {
        let start = Instant::now();
        let is_parsed_only = depth == Depth::Parse && path != Path::new(README);
        let found = run_block(&clone, block, depth, is_parsed_only, &interrupt.after(depth.limit()));
        interrupt.check()?;
        let (place, seconds) = (format!("{}:{}", path.display(), block.line), start.elapsed().as_secs_f64());
        eprintln!("{place}: {} ({seconds:.1} s)", if found.is_empty() { "ok" } else { "failed" });
        faults.extend(found.into_iter().map(|fault| format!("{place}: {fault}")));
    }
    Ok(faults)
}

fn run_block(clone: &Clone, block: &Block, depth: Depth, is_parsed_only: bool, limit: &Limit) -> Vec<String> {
    let check =
        match block.check.as_deref().ok_or("no check follows this block".to_owned()).and_then(Check::parse) {
            Ok(check) => check,
            Err(fault) => return vec![fault],
        };
    let quick = depth != Depth::Full;
    let parse_only = is_parsed_only || check.parse || quick && check.long;
    let mut commands = block.commands.clone();
    if quick {
        for (from, to) in &check.quick {
            if !commands.iter().any(|c| c.contains(from.as_str())) {
                return vec![format!("quick: no command contains {from:?}")];
            }
            commands.iter_mut().for_each(|c| *c = c.replace(from.as_str(), to));
        }
    }
    let mut printed = Printed::default();
    for (i, command) in commands.iter().enumerate() {
        let line = match program_and_rest(command) {
            _ if !parse_only => command.clone(),
            Some((program, rest)) => format!("{program} {PARSE_ONLY} {rest}"),
            None => continue,
        };
        let output = match clone.run(&line, limit) {
            Ok(output) => output,
            Err(fault) => return vec![fault],
        };
        printed.stdout.push_str(&String::from_utf8_lossy(&output.stdout));
        printed.stderr.push_str(&String::from_utf8_lossy(&output.stderr));
        let wanted = if i + 1 == commands.len() && !parse_only { check.exit } else { 0 };
        if output.status.code() != Some(wanted) {
            return vec![format!("{line}: {}, not {wanted}\n{}", output.status, printed.stderr)];
        }
    }
    if parse_only {
        return Vec::new();
    }
    let mut faults = check.faults(clone.folder(), &printed);
    faults.extend(check::not_printed(block.shown.as_deref().unwrap_or_default(), &printed.stdout));
    faults
}

/// Returns the program that a command runs, and its arguments.
fn program_and_rest(command: &str) -> Option<(&'static str, &str)> {
    let begins = [("adumbra ", PRODUCT), ("adumbra-lab ", LABORATORY), (RUN_LABORATORY, LABORATORY)];
    begins.into_iter().find_map(|(begin, program)| Some((program, command.strip_prefix(begin)?)))
}

fn run_examples(root: &Path, depth: Depth, interrupt: &Interrupt) -> std::io::Result<Vec<String>> {
    let clone = Clone::of(root, depth)?;
    let mut faults = Vec::new();
    for name in EXAMPLES {
        let start = Instant::now();
        let output = clone.run(&format!("target/release/examples/{name}"), &interrupt.after(depth.limit()));
        interrupt.check()?;
        let fault = match output {
            Ok(output) if output.status.success() => None,
            Ok(output) => Some(format!("{}\n{}", output.status, String::from_utf8_lossy(&output.stderr))),
            Err(fault) => Some(fault),
        };
        let word = if fault.is_none() { "ok" } else { "failed" };
        eprintln!("example {name}: {word} ({:.1} s)", start.elapsed().as_secs_f64());
        faults.extend(fault.map(|f| format!("example {name}: {f}")));
    }
    Ok(faults)
}

/// A program and its help texts by verb.
struct Program {
    name: &'static str,
    path: PathBuf,
    help: BTreeMap<Vec<String>, Option<String>>,
}

impl Program {
    /// Returns the verbs and options that the documents name but the program does not have. If `all`
    /// documents were read, also the verbs that the README does not list.
    fn faults(mut self, documents: &HashMap<PathBuf, MarkdownFile>, all: bool) -> Vec<String> {
        let mut faults = BTreeSet::new();
        for (path, document) in documents {
            for (line, span) in &document.spans {
                if let Err(fault) = self.knows(span) {
                    faults.insert(format!("{}:{line}: {fault}", path.display()));
                }
            }
        }
        if all {
            let readme = documents.get(Path::new(README));
            let listed: Vec<&str> =
                readme.map_or_else(Vec::new, |d| d.spans.iter().map(|s| s.1.as_str()).collect());
            for verb in self.verbs() {
                if !listed.iter().any(|span| span.split_whitespace().next() == Some(verb.as_str())) {
                    faults.insert(format!("README.md: does not list `{verb}`"));
                }
            }
        }
        faults.into_iter().collect()
    }

    /// Checks that a span that begins with the program's name has a verb and options that exist.
    fn knows(&mut self, span: &str) -> Result<(), String> {
        let mut words = span.split_whitespace();
        if words.next() != Some(self.name) {
            return Ok(());
        }
        let mut verb: Vec<String> = Vec::new();
        for word in words {
            let is_verb = !word.is_empty() && word.chars().all(|c| c.is_ascii_lowercase() || c == '-');
            let takes_verb = verb.is_empty() || verb.len() == 1 && self.help(&verb)?.contains("\nCommands:");
            if takes_verb && is_verb && !word.starts_with('-') {
                verb.push(word.to_owned());
            } else if let Some(option) = word.strip_prefix("--") {
                let name: String =
                    option.chars().take_while(|c| c.is_ascii_lowercase() || *c == '-').collect();
                let help = self.help(&verb)?;
                if !help.contains(&format!("--{name}")) {
                    return Err(format!("`{span}`: no option --{name}"));
                }
            }
        }
        if verb.is_empty() { Ok(()) } else { self.help(&verb).map(|_| ()) }
    }

    fn help(&mut self, verb: &[String]) -> Result<String, String> {
        let path = &self.path;
        let help = self.help.entry(verb.to_vec()).or_insert_with(|| {
            let output = Command::new(path).args(verb).arg("--help").output().ok()?;
            output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
        });
        help.clone().ok_or_else(|| format!("{} {} --help fails", self.name, verb.join(" ")))
    }

    fn verbs(&mut self) -> Vec<String> {
        let help = self.help(&[]).unwrap_or_default();
        let commands = help.lines().skip_while(|l| *l != "Commands:").skip(1).take_while(|l| !l.is_empty());
        // The description of a verb continues on the lines below it, which are indented further.
        let verbs = commands.filter_map(|l| l.strip_prefix("  ").filter(|l| !l.starts_with(' ')));
        let first = verbs.filter_map(|l| l.split_whitespace().next());
        first.filter(|verb| *verb != "help").map(str::to_owned).collect()
    }
}
