//! Ambient occlusion of pictures: what `--ao` asks for.

use adumbra_lab::truth::TruthTracer;
use adumbra_render::occlusion::{
    AmbientSource, DEFAULT_RADIUS_SHARE, GivenAmbient, OcclusionPasses, OcclusionSettings, TracedSettings,
};
use adumbra_render::{FrameTimes, RenderError, Renderer, Shot, Stage, TechniqueSpec};
use serde_json::{Value, json};

use super::Job;
use crate::exit::Failure;

/// Ambient occlusion as it was asked for.
pub(super) struct Ambient {
    spec: TechniqueSpec,
    has_radius: bool,
    kind: Kind,
}

enum Kind {
    Estimated(OcclusionSettings),
    Traced(TracedSettings),
}

impl Ambient {
    /// Reads `NAME[:key=value…]`; none for open sky. Without a radius it has none yet.
    pub(super) fn read(text: &str) -> Result<Option<Self>, Failure> {
        let read = || -> Result<Option<Self>, RenderError> {
            let spec: TechniqueSpec = text.parse()?;
            let kind = match spec.name() {
                "none" => {
                    spec.reader().finish()?;
                    return Ok(None);
                }
                "truth" => Kind::Traced(TracedSettings::from_spec(&spec, 0.0)?),
                _ => Kind::Estimated(OcclusionSettings::from_spec(&spec, 0.0)?),
            };
            Ok(Some(Self { has_radius: spec.value("radius").is_some(), spec, kind }))
        };
        read().map_err(|error| match error {
            RenderError::Technique { name, reason } => Failure::Usage(format!("--ao {name}: {reason}")),
            other => other.into(),
        })
    }

    /// As it was called for.
    pub(super) fn name(&self) -> String {
        self.spec.to_string()
    }

    /// Gives it the scene's radius, and says so, where it was asked for without one.
    pub(super) fn set_radius(&mut self, usual_diagonal_world: f64) {
        if self.has_radius {
            return;
        }
        let radius = DEFAULT_RADIUS_SHARE * usual_diagonal_world;
        let percent = 100.0 * DEFAULT_RADIUS_SHARE;
        eprintln!(
            "note: --ao {}: the radius is {} in world units, {percent} % of the scene's usual diagonal; radius= sets another",
            self.spec,
            three_digits(radius)
        );
        match &mut self.kind {
            Kind::Estimated(settings) => settings.radius_world = radius,
            Kind::Traced(settings) => settings.radius_world = radius,
        }
    }

    /// Makes a renderer's ambient occlusion, before the first frame of a technique.
    pub(super) fn begin(&self, renderer: &mut Renderer) -> Result<(), Failure> {
        let Kind::Estimated(settings) = self.kind else { return Ok(()) };
        let passes = OcclusionPasses::new(renderer.gpu(), settings);
        renderer.gpu().check()?;
        renderer.set_ambient(Some(passes.into()));
        Ok(())
    }

    /// Traces a frame's, where it is traced and not the renderer's yet. `held` is the frame that the renderer's is of.
    pub(super) fn trace(
        &self,
        job: &Job<'_>,
        renderer: &mut Renderer,
        shot: &Shot,
        seconds: f64,
        held: &mut Option<u32>,
    ) -> Result<(), Failure> {
        let Kind::Traced(TracedSettings { radius_world, rays }) = self.kind else { return Ok(()) };
        if *held == Some(shot.number) {
            return Ok(());
        }
        let scene = job.scene_at(seconds);
        let truth = TruthTracer::build(&scene, job.ignore_alpha);
        let bytes = scene.memory_bytes() + truth.tracer().memory_bytes();
        job.args.work.check_memory("the scene and its rays' trees", bytes)?;
        let visibility = truth.ambient(&truth.surfaces(&shot.camera), radius_world, rays);
        let size = [shot.camera.width, shot.camera.height];
        renderer.set_ambient(Some(GivenAmbient::new(renderer.gpu(), size, &visibility)?.into()));
        *held = Some(shot.number);
        Ok(())
    }

    /// For `--json`.
    pub(super) fn figures(&self, renderer: &Renderer, times: &FrameTimes) -> Value {
        let (radius_world, is_timed) = match self.kind {
            Kind::Estimated(settings) => (settings.radius_world, true),
            Kind::Traced(settings) => (settings.radius_world, false),
        };
        let ms = |stage| is_timed.then(|| times.of(stage));
        json!({
            "name": self.name(),
            "radius_world": radius_world,
            "bytes": renderer.ambient().map_or(0, AmbientSource::bytes),
            "surface_ms": ms(Stage::AmbientSurface),
            "estimate_ms": ms(Stage::AmbientEstimate),
            "history_ms": ms(Stage::AmbientHistory),
            "filter_ms": ms(Stage::AmbientFilter),
            "ms": is_timed.then(|| times.ambient()),
        })
    }
}

/// A number with three digits that count, or all before its point.
fn three_digits(value: f64) -> String {
    let decimals = if value > 0.0 { (2.0 - value.log10().floor()).clamp(0.0, 12.0) } else { 0.0 };
    format!("{value:.*}", decimals as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ambient_takes_the_scene_s_radius_where_it_has_none() {
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
    fn radius_is_said_with_three_digits() {
        for (value, text) in [(0.0, "0"), (0.001_234_5, "0.00123"), (1.0, "1.00"), (1234.5, "1234")] {
            assert_eq!(three_digits(value), text);
        }
    }
}
