//! Ambient occlusion of pictures, selected by `--ao`.

use crate::Result;
use crate::truth::TruthTracer;
use adumbra_program::exit::Failure;
use adumbra_render::occlusion::{
    AmbientSettings, AmbientSource, DEFAULT_RADIUS_SHARE, GivenAmbient, OcclusionPasses, OcclusionSettings,
    TracedSettings,
};
use adumbra_render::{FrameTimes, RenderError, Renderer, Shot, SpecText, Stage};
use schemars::JsonSchema;
use serde::Serialize;

use super::Job;

/// Figures of a picture's ambient occlusion. The milliseconds are null for `truth`.
#[derive(Serialize, JsonSchema)]
pub(super) struct AmbientFigures {
    /// The ambient occlusion, as `--ao` named it.
    name: String,
    /// Largest distance of an occluder, world units.
    radius_world: f64,
    /// Bytes on the GPU for the ambient occlusion.
    bytes: u64,
    /// Milliseconds of the pass for view depths and normals.
    surface_ms: Option<f64>,
    /// Milliseconds of the estimate.
    estimate_ms: Option<f64>,
    /// Milliseconds of the reuse of earlier frames. 0 without `reuse=on`.
    history_ms: Option<f64>,
    /// Milliseconds of the filter.
    filter_ms: Option<f64>,
    /// Milliseconds of all passes of the ambient occlusion.
    ms: Option<f64>,
}

/// The ambient occlusion that was asked for.
pub(super) struct Ambient {
    spec: SpecText,
    has_radius: bool,
    kind: Kind,
}

enum Kind {
    Estimated(OcclusionSettings),
    Traced(TracedSettings),
}

impl Ambient {
    /// Parses `NAME[:key=value…]`. `None` for an open sky. Without a given radius, [`Self::set_radius`] must
    /// set it.
    pub(super) fn read(text: &str) -> Result<Option<Self>> {
        let read = || -> Result<Option<Self>, RenderError> {
            let spec: SpecText = text.parse()?;
            let kind = match AmbientSettings::from_spec(&spec, 0.0)? {
                AmbientSettings::Open => return Ok(None),
                AmbientSettings::Traced(settings) => Kind::Traced(settings),
                AmbientSettings::Estimated(settings) => Kind::Estimated(settings),
            };
            Ok(Some(Self { has_radius: spec.value("radius").is_some(), spec, kind }))
        };
        read().map_err(|error| match error {
            RenderError::Technique { name, reason } => {
                Failure::Usage(format!("--ao {name}: {reason}")).into()
            }
            other => other.into(),
        })
    }

    /// Returns the name and the parameters as they were given.
    pub(super) fn name(&self) -> String {
        self.spec.to_string()
    }

    /// Sets the radius to the scene's default and prints it, if none was given.
    pub(super) fn set_radius(&mut self, usual_diagonal_world: f64) {
        if self.has_radius {
            return;
        }
        let radius = DEFAULT_RADIUS_SHARE * usual_diagonal_world;
        let percent = 100.0 * DEFAULT_RADIUS_SHARE;
        adumbra_program::note!(
            "note: --ao {}: the radius is {} world units, {percent} % of the scene's usual diagonal; set another with radius=",
            self.spec,
            three_digits(radius)
        );
        match &mut self.kind {
            Kind::Estimated(settings) => settings.radius_world = radius,
            Kind::Traced(settings) => settings.radius_world = radius,
        }
    }

    /// Sets up a renderer's ambient occlusion, before the first frame of a technique.
    pub(super) fn begin(&self, renderer: &mut Renderer) -> Result<()> {
        let Kind::Estimated(settings) = self.kind else { return Ok(()) };
        let passes = OcclusionPasses::new(renderer.gpu(), settings);
        renderer.gpu().check()?;
        renderer.set_ambient(Some(passes.into()));
        Ok(())
    }

    /// Traces a frame's ambient occlusion, if it is traced and the renderer does not have it yet. `held` is
    /// the number of the frame that the renderer has.
    pub(super) fn trace(
        &self,
        job: &Job<'_>,
        renderer: &mut Renderer,
        shot: &Shot,
        seconds: f64,
        held: &mut Option<u32>,
    ) -> Result<()> {
        let Kind::Traced(TracedSettings { radius_world, rays }) = self.kind else { return Ok(()) };
        if *held == Some(shot.number) {
            return Ok(());
        }
        let scene = job.scene_at(seconds);
        let truth = TruthTracer::build(&scene, job.ignore_alpha);
        let bytes = scene.memory_bytes() + truth.tracer().memory_bytes();
        job.args.run.check_memory("the scene and its acceleration structure", bytes, bytes)?;
        let visibility = truth.ambient(&truth.surfaces(&shot.camera), radius_world, rays);
        let size = [shot.camera.width, shot.camera.height];
        renderer.set_ambient(Some(GivenAmbient::new(renderer.gpu(), size, &visibility)?.into()));
        *held = Some(shot.number);
        Ok(())
    }

    /// Returns the figures for `--json`.
    pub(super) fn figures(&self, renderer: &Renderer, times: &FrameTimes) -> AmbientFigures {
        let (radius_world, is_timed) = match self.kind {
            Kind::Estimated(settings) => (settings.radius_world, true),
            Kind::Traced(settings) => (settings.radius_world, false),
        };
        let ms = |stage| is_timed.then(|| times.of(stage));
        AmbientFigures {
            name: self.name(),
            radius_world,
            bytes: renderer.ambient().map_or(0, AmbientSource::bytes),
            surface_ms: ms(Stage::AmbientSurface),
            estimate_ms: ms(Stage::AmbientEstimate),
            history_ms: ms(Stage::AmbientHistory),
            filter_ms: ms(Stage::AmbientFilter),
            ms: is_timed.then(|| times.ambient()),
        }
    }
}

/// Formats a number with three significant digits, or with all digits before its decimal point.
fn three_digits(value: f64) -> String {
    let decimals = if value > 0.0 { (2.0 - value.log10().floor()).clamp(0.0, 12.0) } else { 0.0 };
    format!("{value:.*}", decimals as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ambient_radius_defaults_to_the_scene_s() {
        let radius = |text: &str| {
            let mut ambient = Ambient::read(text).ok().flatten().unwrap();
            ambient.set_radius(13.0);
            match ambient.kind {
                Kind::Estimated(settings) => settings.radius_world,
                Kind::Traced(settings) => settings.radius_world,
            }
        };
        for name in ["issao", "hbao", "truth"] {
            assert_eq!(radius(name), DEFAULT_RADIUS_SHARE * 13.0, "{name}");
            assert_eq!(radius(&format!("{name}:radius=0.5")), 0.5, "{name}");
            assert_eq!(radius(&format!("{name}:radius=0")), 0.0, "{name}");
        }
        assert!(Ambient::read("none").ok().unwrap().is_none());
    }

    #[test]
    fn formats_radius_with_three_digits() {
        for (value, text) in [(0.0, "0"), (0.001_234_5, "0.00123"), (1.0, "1.00"), (1234.5, "1234")] {
            assert_eq!(three_digits(value), text);
        }
    }
}
