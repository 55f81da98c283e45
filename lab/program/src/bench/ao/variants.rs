//! Variants of issao: its options with the tuned parameters, the paper's ablation, and the paper's settings.

use std::borrow::Cow;

use adumbra_render::occlusion::{OcclusionPasses, OcclusionSettings};
use adumbra_render::{FrameTimes, SpecText};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Bench;
use super::measure::{Pictures, unfiltered};
use crate::occlusion::{ClaimProbe, Claims, Flicker, OcclusionErrors, with_tuned};
use crate::results::or_nan;
use adumbra_compare::Result;
use adumbra_compare::compare::{median_ratio, median_time};

/// Options, and whether the parameters are the tuned ones or the paper's.
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
/// Frames accumulated before a mean over frames is measured.
const STILL_FRAMES: u32 = 16;

/// A variant's results.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct Variant {
    /// Options as given to `--ao issao:…`.
    pub(crate) options: Cow<'static, str>,
    /// Whether the tuned parameters were used.
    pub(crate) tuned: bool,
    /// Median milliseconds of all passes.
    pub(crate) ms: f64,
    /// Time divided by that of the first variant, issao itself: the median of the ratios frame by frame.
    #[serde(deserialize_with = "or_nan")]
    #[schemars(with = "Option<f64>")]
    pub(crate) by_issao: f64,
    /// Errors with the filter.
    pub(crate) errors: OcclusionErrors,
    /// Measures of detail, edges and noise.
    pub(crate) claims: Claims,
    /// Errors before the filter.
    pub(crate) raw_errors: OcclusionErrors,
    /// Measures of detail, edges and noise before the filter.
    pub(crate) raw_claims: Claims,
    /// Flicker along the camera path; `None` if it was not measured.
    pub(crate) flicker: Option<Flicker>,
    /// `None` if the variant was read from a file.
    #[serde(skip)]
    pub(crate) settings: Option<OcclusionSettings>,
}

impl Variant {
    /// Returns its name in tables.
    pub(super) fn name(&self) -> String {
        name(&self.options)
    }
}

pub(super) fn name(options: &str) -> String {
    if options.is_empty() { "issao".to_owned() } else { format!("issao:{options}") }
}

impl Bench<'_, '_, '_> {
    /// Measures one row per variant, and adds every picture but issao's own to `pictures`.
    ///
    /// Variants that this build does not support are added to `skipped`.
    pub(super) fn variants(
        &mut self,
        probe: &ClaimProbe<'_>,
        pictures: &mut Pictures,
        skipped: &mut Vec<[String; 2]>,
    ) -> Result<Vec<Variant>> {
        let mut known = Vec::new();
        for (options, tuned) in VARIANTS {
            let spec: SpecText = name(options).parse()?;
            match OcclusionSettings::from_spec(&spec, self.reference.radius_world) {
                Ok(s) => known.push((options, tuned, if tuned { with_tuned(s, self.on) } else { s })),
                Err(e) => {
                    let noted = [name(options), e.to_string()];
                    if !skipped.contains(&noted) {
                        skipped.push(noted);
                    }
                }
            }
        }
        let gpu = self.stage.gpu();
        let mut passes: Vec<OcclusionPasses> =
            known.iter().map(|(_, _, s)| OcclusionPasses::new(gpu, *s)).collect();
        let times = self.times(&mut passes, self.args.common.frames)?;
        let mut variants = Vec::new();
        for (((options, tuned, settings), passes), own) in known.into_iter().zip(&mut passes).zip(&times) {
            let visibility = self.still(passes)?;
            let raw = self.still(&mut OcclusionPasses::new(self.stage.gpu(), unfiltered(settings)))?;
            let variant = Variant {
                options: options.into(),
                tuned,
                ms: median_time(own, FrameTimes::ambient),
                by_issao: median_ratio(own, &times[0], FrameTimes::ambient),
                errors: self.traced_view.errors(&visibility)?,
                claims: probe.claims(&visibility)?,
                raw_errors: self.traced_view.errors(&raw)?,
                raw_claims: probe.claims(&raw)?,
                flicker: None,
                settings: Some(settings),
            };
            adumbra_program::note!(
                "{}: {:.1} ms, RMSE {:.4}",
                variant.name(),
                variant.ms,
                variant.errors.rmse
            );
            variants.push(variant);
            if !options.is_empty() {
                pictures.push((name(options), visibility));
            }
        }
        Ok(variants)
    }

    /// Returns the visibility seen by a still camera.
    ///
    /// With `reuse`, the mean over frames is taken after [`STILL_FRAMES`] frames.
    fn still(&mut self, passes: &mut OcclusionPasses) -> Result<Vec<f32>> {
        if passes.settings().reuse {
            let camera = *self.stage.camera();
            for number in 0..STILL_FRAMES {
                self.stage.look(camera, number)?;
                self.stage.occlude(passes)?;
            }
            self.stage.look(camera, 0)?;
            return Ok(passes.read(self.stage.gpu())?);
        }
        self.stage.visibility(passes)
    }
}
