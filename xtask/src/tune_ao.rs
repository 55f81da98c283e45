//! `cargo xtask tune-ao`: gives every estimator of ambient occlusion the same search on the eight scenes, and
//! records what it finds in
//! `crates/adumbra-lab/data/ao_tuning.json` and `docs/bench/ao-tuning.md`.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use adumbra_lab::occlusion::{Record, TuneOptions, TuneScene, tune};
use adumbra_lab::truth::Cache;
use adumbra_render::occlusion::{Estimator, OcclusionSettings};
use adumbra_render::{Gpu, GpuOptions, TechniqueSpec};

const RECORD: &str = "crates/adumbra-lab/data/ao_tuning.json";
const TABLE: &str = "docs/bench/ao-tuning.md";

/// What is asked for.
struct Asked {
    scenes: PathBuf,
    estimators: Vec<Estimator>,
    /// To be told of, not to be recorded.
    variants: Vec<TechniqueSpec>,
    options: TuneOptions,
}

/// Tunes, and writes both files; with `--only`, entries of other estimators stay if they are of the same scenes and
/// options.
pub(crate) fn run(root: &Path, words: &[&str]) -> Result<(), Box<dyn Error>> {
    let asked = Asked::read(root, words)?;
    let gpu = Gpu::request(&GpuOptions::default())?;
    let cache = Cache::in_folder(root.join("target/truth-cache"), Cache::DEFAULT_LIMIT_BYTES);
    let begun = Instant::now();
    let scenes = TuneScene::all(&gpu, &asked.scenes, &asked.options, &cache)?;
    eprintln!("{} scenes ready after {:.0} s", scenes.len(), begun.elapsed().as_secs_f64());
    if !asked.variants.is_empty() {
        return variants(&scenes, &asked);
    }
    let mut last = Instant::now();
    let estimators: Vec<_> = asked.estimators.iter().map(|e| OcclusionSettings::new(*e, 1.0)).collect();
    let found = tune(&scenes, &asked.options, &estimators, |entry| {
        eprintln!(
            "{} on {}: {:.4}, elsewhere {:?}; {:.0} s",
            entry.estimator,
            entry.on.name(),
            entry.objective,
            entry.elsewhere,
            last.elapsed().as_secs_f64()
        );
        last = Instant::now();
    })?;
    let path = root.join(RECORD);
    let known: Record = serde_json::from_str(&fs::read_to_string(&path)?)?;
    let record = known.joined(found);
    fs::write(path, record.json()?)?;
    fs::write(root.join(TABLE), record.markdown())?;
    Ok(())
}

/// Tunes estimators with some of their parameters fixed, and says what they come to.
fn variants(scenes: &[TuneScene], asked: &Asked) -> Result<(), Box<dyn Error>> {
    for spec in &asked.variants {
        let settings = OcclusionSettings::from_spec(spec, 1.0)?;
        tune(scenes, &asked.options, &[settings], |entry| {
            let elsewhere = entry.elsewhere.map_or_else(String::new, |e| format!(", elsewhere {e:.4}"));
            println!(
                "{spec} on {}: {:.4}{elsewhere}; {:?}",
                entry.on.name(),
                entry.objective,
                entry.settings
            );
        })?;
    }
    Ok(())
}

impl Asked {
    fn read(root: &Path, words: &[&str]) -> Result<Self, String> {
        let shared = std::env::var_os("ADUMBRA_SHARED").map_or_else(|| root.join("../shared"), PathBuf::from);
        let mut asked = Self {
            scenes: shared.join("scenes"),
            estimators: Estimator::ALL.to_vec(),
            variants: Vec::new(),
            options: TuneOptions::default(),
        };
        let mut words = words.iter();
        while let Some(word) = words.next() {
            let value = words.next().ok_or_else(|| format!("{word} needs a value"))?;
            match *word {
                "--scenes" => asked.scenes = PathBuf::from(value),
                "--budget" => asked.options.budget = number(value)?,
                "--variant" => asked.variants.push(value.parse().map_err(|e| format!("{e}"))?),
                "--only" => asked.estimators = estimators(value)?,
                other => return Err(format!("tune-ao does not know {other}")),
            }
        }
        Ok(asked)
    }
}

fn number(text: &str) -> Result<u32, String> {
    text.parse().ok().filter(|n| (1..=100_000).contains(n)).ok_or_else(|| format!("{text:?} is no budget"))
}

fn estimators(text: &str) -> Result<Vec<Estimator>, String> {
    let named = |name: &str| {
        let found = Estimator::ALL.into_iter().find(|e| e.name() == name);
        found.ok_or_else(|| format!("there is no estimator {name:?}"))
    };
    text.split(',').map(named).collect()
}
