//! What the tuner found: `data/ao_tuning.json`, and the settings that each scene is judged with.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::LazyLock;

use adumbra_render::occlusion::{Estimator, MAX_PARAMETERS, OcclusionSettings, Search};
use serde::{Deserialize, Serialize};

use super::views::{Fold, scene_named};

/// Which scenes a setting was tuned on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TunedOn {
    /// Those of [`Fold::A`].
    FoldA,
    /// Those of [`Fold::B`].
    FoldB,
    /// All eight: what users get.
    All,
}

/// All that `cargo xtask tune-ao` found.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// What drew.
    pub adapter: String,
    /// Pixels of each picture.
    pub size: [u32; 2],
    /// Rays a pixel of the truth.
    pub rays: u32,
    /// Taps a pixel.
    pub samples: u32,
    /// Evaluations a run.
    pub budget: u32,
    /// In order.
    pub scenes: Vec<RecordScene>,
    /// One an estimator and [`TunedOn`].
    pub entries: Vec<RecordEntry>,
}

/// A scene that was tuned on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecordScene {
    /// As [`scene_named`] finds it.
    pub name: String,
    /// Its half.
    pub fold: Fold,
    /// How far what occludes may be, world units.
    pub radius_world: f64,
    /// RMSE of open sky everywhere.
    pub none_rmse: f64,
}

/// What one run found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecordEntry {
    /// By [`Estimator::name`].
    pub estimator: String,
    /// On which scenes.
    pub on: TunedOn,
    /// What varied, by the names of [`Estimator::parameters`].
    pub settings: BTreeMap<String, f64>,
    /// Mean over those scenes of RMSE after the filter by that of open sky.
    pub objective: f64,
    /// The same over the other scenes; none where there are no others.
    pub elsewhere: Option<f64>,
    /// RMSE after the filter by scene, those that were not tuned on too.
    pub rmse: BTreeMap<String, f64>,
}

static EMBEDDED: LazyLock<Record> =
    LazyLock::new(|| serde_json::from_str(include_str!("../../data/ao_tuning.json")).unwrap_or_default());

impl TunedOn {
    /// Each.
    pub const ALL: [Self; 3] = [Self::FoldA, Self::FoldB, Self::All];

    /// Whether scenes of `fold` are tuned on.
    pub fn has(self, fold: Fold) -> bool {
        match self {
            Self::FoldA => fold == Fold::A,
            Self::FoldB => fold == Fold::B,
            Self::All => true,
        }
    }

    /// What judges the scene of that name fairly: the half that lacks it; all eight where neither has it.
    pub fn without(scene: &str) -> Self {
        match scene_named(scene).map(|s| s.fold) {
            Some(Fold::A) => Self::FoldB,
            Some(Fold::B) => Self::FoldA,
            None => Self::All,
        }
    }

    /// As tables call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::FoldA => "fold A",
            Self::FoldB => "fold B",
            Self::All => "all",
        }
    }
}

impl Record {
    /// The one of this build.
    pub fn embedded() -> &'static Self {
        &EMBEDDED
    }

    /// A run's entry.
    pub fn entry(&self, estimator: Estimator, on: TunedOn) -> Option<&RecordEntry> {
        self.entries.iter().find(|e| e.estimator == estimator.name() && e.on == on)
    }

    /// An estimator's parameters as a run left them; none where there is no entry, or where it names other parameters
    /// than those that the tuner varies today.
    pub fn shape(&self, estimator: Estimator, on: TunedOn) -> Option<[f64; MAX_PARAMETERS]> {
        let entry = self.entry(estimator, on)?;
        let mut shape = OcclusionSettings::new(estimator, 1.0).shape;
        let mut varied = 0;
        for (value, p) in shape.iter_mut().zip(estimator.parameters()) {
            if p.search.is_some() {
                *value = *entry.settings.get(p.name)?;
                varied += 1;
            }
        }
        (varied == entry.settings.len()).then_some(shape)
    }

    /// This one with the entries of `other` in place of its own, if both are of the same scenes and options; else
    /// `other`.
    #[must_use]
    pub fn joined(&self, other: Self) -> Self {
        let head = |r: &Self| Self { entries: Vec::new(), ..r.clone() };
        if head(self) != head(&other) {
            return other;
        }
        let mut joined = Self { entries: Vec::new(), ..other.clone() };
        for (estimator, on) in Estimator::ALL.iter().flat_map(|e| TunedOn::ALL.map(|on| (*e, on))) {
            joined.entries.extend(other.entry(estimator, on).or_else(|| self.entry(estimator, on)).cloned());
        }
        joined
    }

    /// The record as JSON text, and as a table.
    ///
    /// # Errors
    /// What the serialiser says.
    pub fn json(&self) -> serde_json::Result<String> {
        Ok(format!("{}\n", serde_json::to_string_pretty(self)?))
    }

    /// The record as Markdown.
    pub fn markdown(&self) -> String {
        let [width, height] = self.size;
        let names: Vec<&str> = self.scenes.iter().map(|s| s.name.as_str()).collect();
        let fold = |fold: Fold| {
            let inside = self.scenes.iter().filter(|s| s.fold == fold).map(|s| s.name.as_str());
            inside.collect::<Vec<_>>().join(", ")
        };
        let mut text = format!(
            "# Ambient occlusion, tuned\n\nBy `cargo xtask tune-ao`, drawn by {}: {width} x {height}, {} samples, \
            each estimator with its filter, judged by {} rays a \
            pixel of the same radius over the pixels where rays and G-buffer see the same surface. Every estimator \
            has the same search: {} evaluations a run, a third of \
            them spread over all that its parameters may be, the rest a simplex from the best of them on. What is made \
            small is the mean over the \
            run's scenes of RMSE by the RMSE of open sky everywhere. Fold A: {}. Fold B: {}. *Elsewhere* is the same \
            mean over the \
            scenes that the run did not see. RMSE in brackets is of scenes that were tuned on. A star marks a parameter \
            at an end of what it may be.\n\n\
            | estimator | tuned on | settings | mean | elsewhere | {} |\n|---|---|---|---|---|{}\n",
            self.adapter,
            self.samples,
            self.rays,
            self.budget,
            fold(Fold::A),
            fold(Fold::B),
            names.join(" | "),
            "---|".repeat(names.len())
        );
        let none: String = self.scenes.iter().map(|s| format!(" {:.4} |", s.none_rmse)).collect();
        // Writing to a String does not fail.
        let _ = writeln!(text, "| none | – | – | 1 | – |{none}");
        for e in &self.entries {
            let settings = e.settings.iter().map(|(name, value)| {
                let end = if at_an_end(&e.estimator, name, *value) { "*" } else { "" };
                format!("{name} {value}{end}")
            });
            let settings: Vec<String> = settings.collect();
            let elsewhere = e.elsewhere.map_or_else(|| "–".to_owned(), |m| format!("{m:.4}"));
            let _ = write!(
                text,
                "| `{}` | {} | {} | {:.4} | {elsewhere} |",
                e.estimator,
                e.on.name(),
                settings.join(", "),
                e.objective
            );
            for s in &self.scenes {
                let _ = match e.rmse.get(&s.name) {
                    Some(rmse) if e.on.has(s.fold) => write!(text, " ({rmse:.4}) |"),
                    Some(rmse) => write!(text, " {rmse:.4} |"),
                    None => write!(text, " – |"),
                };
            }
            text.push('\n');
        }
        text
    }
}

/// Whether a parameter lies in the outer hundredth of where the tuner looks.
fn at_an_end(estimator: &str, name: &str, value: f64) -> bool {
    let of = |e: &Estimator| e.parameters().iter().find(|p| p.name == name).and_then(|p| p.search);
    let place = match Estimator::ALL.iter().find(|e| e.name() == estimator).and_then(of) {
        Some(Search::Even(low, high)) => (value - low) / (high - low),
        Some(Search::Factors(low, high)) => libm::log(value / low) / libm::log(high / low),
        None => return false,
    };
    !(0.01..=0.99).contains(&place)
}

/// An estimator's parameters as tuned `on` those scenes; its defaults where [`Record::shape`] has none.
pub fn tuned(estimator: Estimator, on: TunedOn) -> [f64; MAX_PARAMETERS] {
    let defaults = || OcclusionSettings::new(estimator, 1.0).shape;
    Record::embedded().shape(estimator, on).unwrap_or_else(defaults)
}

/// `settings` with what the tuner varies as tuned `on` those scenes; all else stays.
#[must_use]
pub fn with_tuned(mut settings: OcclusionSettings, on: TunedOn) -> OcclusionSettings {
    let shape = tuned(settings.estimator, on);
    for (i, p) in settings.estimator.parameters().iter().enumerate() {
        if p.search.is_some() {
            settings.shape[i] = shape[i];
        }
    }
    settings
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(estimator: Estimator, on: TunedOn, value: f64) -> RecordEntry {
        let varied = estimator.parameters().iter().filter(|p| p.search.is_some());
        RecordEntry {
            estimator: estimator.name().to_owned(),
            on,
            settings: varied.map(|p| (p.name.to_owned(), value)).collect(),
            objective: 0.5,
            elsewhere: None,
            rmse: BTreeMap::new(),
        }
    }

    #[test]
    fn tuned_settings_of_a_scene_are_of_the_half_that_lacks_it() {
        assert_eq!(TunedOn::without("dragon"), TunedOn::FoldB);
        assert_eq!(TunedOn::without("bunny"), TunedOn::FoldA);
        assert_eq!(TunedOn::without("box-city-5k"), TunedOn::All);
        for scene in super::super::SCENES {
            assert!(!TunedOn::without(scene.name).has(scene.fold));
        }
    }

    #[test]
    fn tuned_record_with_other_parameters_counts_nothing() {
        let mut record =
            Record { entries: vec![entry(Estimator::Issao, TunedOn::All, 0.25)], ..Record::default() };
        let shape = record.shape(Estimator::Issao, TunedOn::All).unwrap();
        for (value, p) in shape.iter().zip(Estimator::Issao.parameters()) {
            assert_eq!(*value, if p.search.is_some() { 0.25 } else { p.default }, "{}", p.name);
        }
        assert_eq!(record.shape(Estimator::Issao, TunedOn::FoldA), None);
        record.entries[0].settings.insert("gone".to_owned(), 1.0);
        assert_eq!(record.shape(Estimator::Issao, TunedOn::All), None);
        record.entries[0].settings.clear();
        assert_eq!(record.shape(Estimator::Issao, TunedOn::All), None);
    }

    #[test]
    fn tuned_settings_at_an_end_are_marked() {
        let p = Estimator::Issao.parameters().iter().find(|p| p.search.is_some()).unwrap();
        let Some(Search::Even(low, high) | Search::Factors(low, high)) = p.search else { return };
        let at = |value| at_an_end("issao", p.name, value);
        assert!(at(low) && at(high) && !at((low * high).sqrt()) && !at_an_end("issao", "none", low));
        let entries = vec![entry(Estimator::Issao, TunedOn::All, low)];
        let text = Record { entries, ..Record::default() }.markdown();
        assert!(text.contains(&format!("{} {low}*", p.name)), "{text}");
    }

    #[test]
    fn tuned_records_join_where_they_are_of_one_kind() {
        let of = |budget, entries| Record { budget, entries, ..Record::default() };
        let old = of(
            9,
            vec![entry(Estimator::Ssao, TunedOn::All, 1.0), entry(Estimator::Issao, TunedOn::All, 2.0)],
        );
        let new = of(9, vec![entry(Estimator::Issao, TunedOn::All, 3.0)]);
        let joined = old.joined(new.clone());
        assert_eq!(joined.entries.len(), 2);
        assert_eq!(joined.entry(Estimator::Issao, TunedOn::All), Some(&new.entries[0]));
        assert_eq!(joined.entry(Estimator::Ssao, TunedOn::All), Some(&old.entries[0]));
        let other = of(10, new.entries);
        assert_eq!(old.joined(other.clone()), other);
    }

    #[test]
    fn tuned_record_is_readable() {
        let text = include_str!("../../data/ao_tuning.json");
        let record: Record = serde_json::from_str(text).unwrap();
        assert_eq!(record.json().unwrap(), text);
        assert_eq!(&record, Record::embedded());
    }
}
