//! The results of the tuner in `data/ao_tuning.json`, and the settings with which each scene is measured.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::LazyLock;

use adumbra_render::occlusion::{Estimator, MAX_PARAMETERS, OcclusionSettings, Search};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::views::{Fold, scene_named};

/// The scenes that a setting was tuned on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum TunedOn {
    /// The scenes of [`Fold::A`].
    FoldA,
    /// The scenes of [`Fold::B`].
    FoldB,
    /// All eight scenes. These are the settings that users get.
    All,
}

/// All results of `adumbra-lab tune-ao`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Name of the adapter that drew.
    pub adapter: String,
    /// Size of each picture in pixels.
    pub size: [u32; 2],
    /// Rays per pixel of the truth.
    pub rays: u32,
    /// Taps per pixel.
    pub samples: u32,
    /// Evaluations per run.
    pub budget: u32,
    /// The scenes in order.
    pub scenes: Vec<RecordScene>,
    /// One entry per estimator and [`TunedOn`].
    pub entries: Vec<RecordEntry>,
}

/// A scene used for tuning.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecordScene {
    /// Name by which [`scene_named`] finds it.
    pub name: String,
    /// The half that the scene is in.
    pub fold: Fold,
    /// Largest distance of an occluder in world units.
    pub radius_world: f64,
    /// RMSE of open sky everywhere.
    pub none_rmse: f64,
}

/// The result of one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecordEntry {
    /// Name of the estimator, see [`Estimator::name`].
    pub estimator: String,
    /// The scenes that it was tuned on.
    pub on: TunedOn,
    /// Values of the varied parameters by their names in [`Estimator::parameters`].
    pub settings: BTreeMap<String, f64>,
    /// Mean over those scenes of RMSE after the filter, divided by that of open sky.
    pub objective: f64,
    /// Mean of that ratio over the other scenes; `None` if there are no others.
    pub elsewhere: Option<f64>,
    /// RMSE after the filter by scene, including scenes that were not tuned on.
    pub rmse: BTreeMap<String, f64>,
}

static EMBEDDED: LazyLock<Record> =
    LazyLock::new(|| serde_json::from_str(include_str!("../../data/ao_tuning.json")).unwrap_or_default());

impl TunedOn {
    /// Every value.
    pub const ALL: [Self; 3] = [Self::FoldA, Self::FoldB, Self::All];

    /// Returns whether scenes of `fold` are tuned on.
    pub fn has(self, fold: Fold) -> bool {
        match self {
            Self::FoldA => fold == Fold::A,
            Self::FoldB => fold == Fold::B,
            Self::All => true,
        }
    }

    /// Returns the half that excludes the named scene, so that the scene is measured with settings not tuned
    /// on it.
    ///
    /// Returns [`Self::All`] if neither half has the scene.
    pub fn without(scene: &str) -> Self {
        match scene_named(scene).map(|s| s.fold) {
            Some(Fold::A) => Self::FoldB,
            Some(Fold::B) => Self::FoldA,
            None => Self::All,
        }
    }

    /// Returns its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::FoldA => "fold A",
            Self::FoldB => "fold B",
            Self::All => "all",
        }
    }
}

impl Record {
    /// Returns the record embedded in this build.
    pub fn embedded() -> &'static Self {
        &EMBEDDED
    }

    /// Returns a run's entry.
    pub fn entry(&self, estimator: Estimator, on: TunedOn) -> Option<&RecordEntry> {
        self.entries.iter().find(|e| e.estimator == estimator.name() && e.on == on)
    }

    /// Returns an estimator's parameters as tuned by a run.
    ///
    /// Returns `None` if there is no entry, or if it names other parameters than those that the tuner varies
    /// today.
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

    /// Returns this record with entries replaced by those of `other` if both have the same scenes and
    /// options.
    ///
    /// Otherwise returns `other`.
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

    /// Returns the record as JSON text.
    ///
    /// # Errors
    /// Returns the error of the serialiser.
    pub fn json(&self) -> serde_json::Result<String> {
        Ok(format!("{}\n", serde_json::to_string_pretty(self)?))
    }

    /// Returns the record as Markdown.
    pub fn markdown(&self) -> String {
        let [width, height] = self.size;
        let names: Vec<&str> = self.scenes.iter().map(|s| s.name.as_str()).collect();
        let fold = |fold: Fold| {
            let inside = self.scenes.iter().filter(|s| s.fold == fold).map(|s| s.name.as_str());
            inside.collect::<Vec<_>>().join(", ")
        };
        let mut text = format!(
            "# Ambient occlusion, tuned\n\nBy `adumbra-lab tune-ao`, drawn by {}: {width} x {height}, {} samples, \
            each estimator with its filter, compared with {} rays per pixel of the same radius over the pixels \
            where rays and G-buffer see the same surface. Every estimator is tuned by the same search of {} \
            evaluations per run: a third of them are spread over the full range of its parameters, the rest \
            follow a simplex from the best of those. The objective is the mean, over the run's scenes, of the \
            RMSE divided by that of no occlusion. Fold A: {}. Fold B: {}. *Elsewhere* is the same mean over the \
            scenes that the run did not use. RMSE in brackets is of scenes that were tuned on. A star marks a \
            parameter at an end of its range.\n\n\
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
        // Writing to a `String` never fails.
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

/// Returns whether a parameter is in the outer hundredth of the tuner's range, at either end.
fn at_an_end(estimator: &str, name: &str, value: f64) -> bool {
    let of = |e: &Estimator| e.parameters().iter().find(|p| p.name == name).and_then(|p| p.search);
    let place = match Estimator::ALL.iter().find(|e| e.name() == estimator).and_then(of) {
        Some(Search::Even(low, high)) => (value - low) / (high - low),
        Some(Search::Factors(low, high)) => libm::log(value / low) / libm::log(high / low),
        None => return false,
    };
    !(0.01..=0.99).contains(&place)
}

/// Returns an estimator's parameters as tuned `on` those scenes, or its defaults if [`Record::shape`] has
/// none.
pub fn tuned(estimator: Estimator, on: TunedOn) -> [f64; MAX_PARAMETERS] {
    let defaults = || OcclusionSettings::new(estimator, 1.0).shape;
    Record::embedded().shape(estimator, on).unwrap_or_else(defaults)
}

/// Returns `settings` with the parameters that the tuner varies as tuned `on` those scenes. All others are
/// unchanged.
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
    fn tuned_settings_come_from_half_without_the_scene() {
        assert_eq!(TunedOn::without("dragon"), TunedOn::FoldB);
        assert_eq!(TunedOn::without("bunny"), TunedOn::FoldA);
        assert_eq!(TunedOn::without("box-city-5k"), TunedOn::All);
        for scene in super::super::SCENES {
            assert!(!TunedOn::without(scene.name).has(scene.fold));
        }
    }

    #[test]
    fn tuned_record_with_other_parameters_is_ignored() {
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
    fn tuned_settings_at_range_ends_are_marked() {
        let p = Estimator::Issao.parameters().iter().find(|p| p.search.is_some()).unwrap();
        let Some(Search::Even(low, high) | Search::Factors(low, high)) = p.search else { return };
        let at = |value| at_an_end("issao", p.name, value);
        assert!(at(low) && at(high) && !at((low * high).sqrt()) && !at_an_end("issao", "none", low));
        let entries = vec![entry(Estimator::Issao, TunedOn::All, low)];
        let text = Record { entries, ..Record::default() }.markdown();
        assert!(text.contains(&format!("{} {low}*", p.name)), "{text}");
    }

    #[test]
    fn tuned_records_join_only_with_equal_options() {
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
    fn tuned_record_round_trips_as_json() {
        let text = include_str!("../../data/ao_tuning.json");
        let record: Record = serde_json::from_str(text).unwrap();
        assert_eq!(record.json().unwrap(), text);
        assert_eq!(&record, Record::embedded());
    }
}
