//! Variants of issao: its options with the tuned parameters, the paper's ablation, and the paper's settings.

use adumbra_lab::compare::{median_ratio, median_time};
use adumbra_lab::occlusion::{ClaimProbe, Claims, Flicker, OcclusionErrors, with_tuned};
use adumbra_render::occlusion::{OcclusionPasses, OcclusionSettings};
use adumbra_render::{FrameTimes, TechniqueSpec};
use serde::Serialize;

use super::Bench;
use super::measure::{Pictures, unfiltered};
use crate::exit::Failure;

/// Options, and whether the parameters are the tuned ones; of the others the paper's.
const VARIANTS: [(&str, bool); 13] = [
    ("", true),
    ("half=on", true),
    ("normals=depth", true),
    ("reuse=on", true),
    ("filter=square", true),
    ("filter=gauss", true),
    ("edges=on", true),
    (WITHOUT_ATTENUATION, true),
    (FIG_3, false),
    (FIG_4, false),
    ("preset=fig4:attenuation=off", false),
    (FIG_5, false),
    ("preset=fig5:filter=gauss", false),
];
pub(super) const WITHOUT_ATTENUATION: &str = "attenuation=off";
pub(super) const FIG_3: &str = "preset=fig3";
pub(super) const FIG_4: &str = "preset=fig4";
pub(super) const FIG_5: &str = "preset=fig5";
/// Frames that a mean over frames is given before it is judged.
const STILL_FRAMES: u32 = 16;

/// A variant's figures.
#[derive(Serialize)]
pub(super) struct Variant {
    /// As `--ao issao:…` takes them.
    pub(super) options: &'static str,
    /// With the tuned parameters.
    pub(super) tuned: bool,
    /// Median.
    pub(super) ms: f64,
    /// By the first variant's, which is issao itself, frame by frame.
    pub(super) by_issao: f64,
    pub(super) errors: OcclusionErrors,
    pub(super) claims: Claims,
    /// Before the filter.
    pub(super) raw_errors: OcclusionErrors,
    pub(super) raw_claims: Claims,
    pub(super) flicker: Option<Flicker>,
    #[serde(skip)]
    pub(super) settings: OcclusionSettings,
}

impl Variant {
    /// As tables call it.
    pub(super) fn name(&self) -> String {
        name(self.options)
    }
}

pub(super) fn name(options: &str) -> String {
    if options.is_empty() { "issao".to_owned() } else { format!("issao:{options}") }
}

impl Bench<'_, '_, '_> {
    /// A row a variant; keeps every picture, and notes as left out what this build does not know.
    pub(super) fn variants(
        &mut self,
        probe: &ClaimProbe<'_>,
        pictures: &mut Pictures,
        left_out: &mut Vec<[String; 2]>,
    ) -> Result<Vec<Variant>, Failure> {
        let mut known = Vec::new();
        for (options, tuned) in VARIANTS {
            let spec: TechniqueSpec = name(options).parse()?;
            match OcclusionSettings::from_spec(&spec, self.judge.radius_world) {
                Ok(s) => known.push((options, tuned, if tuned { with_tuned(s, self.on) } else { s })),
                Err(e) => {
                    let noted = [name(options), e.to_string()];
                    if !left_out.contains(&noted) {
                        left_out.push(noted);
                    }
                }
            }
        }
        let gpu = self.stage.gpu();
        let mut passes: Vec<OcclusionPasses> =
            known.iter().map(|(_, _, s)| OcclusionPasses::new(gpu, *s)).collect();
        let times = self.times(&mut passes, self.args.frames)?;
        let mut variants = Vec::new();
        for (((options, tuned, settings), passes), own) in known.into_iter().zip(&mut passes).zip(&times) {
            let visibility = self.still(passes)?;
            let raw = self.still(&mut OcclusionPasses::new(self.stage.gpu(), unfiltered(settings)))?;
            let variant = Variant {
                options,
                tuned,
                ms: median_time(own, FrameTimes::ambient),
                by_issao: median_ratio(own, &times[0], FrameTimes::ambient),
                errors: self.judged.errors(&visibility)?,
                claims: probe.claims(&visibility)?,
                raw_errors: self.judged.errors(&raw)?,
                raw_claims: probe.claims(&raw)?,
                flicker: None,
                settings,
            };
            eprintln!("{}: {:.1} ms, RMSE {:.4}", variant.name(), variant.ms, variant.errors.rmse);
            variants.push(variant);
            if !options.is_empty() {
                pictures.push((name(options), visibility));
            }
        }
        Ok(variants)
    }

    /// What a camera that stands still sees; of a mean over frames once it has settled.
    fn still(&mut self, passes: &mut OcclusionPasses) -> Result<Vec<f32>, Failure> {
        if passes.settings().reuse {
            let camera = *self.stage.camera();
            for number in 0..STILL_FRAMES {
                self.stage.look(camera, number)?;
                self.stage.occlude(passes)?;
            }
            self.stage.look(camera, 0)?;
            return Ok(passes.read(self.stage.gpu())?);
        }
        Ok(self.stage.visibility(passes)?)
    }
}
