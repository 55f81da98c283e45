//! Errors and changes while the sun moves and the camera is fixed.

use adumbra_render::{Answer, Renderer, Shot};
use adumbra_scene::Camera;
use adumbra_truth::picture::Picture;

use super::{Contender, Reference, drawn_surface};
use crate::changes::{Changes, Excess};
use crate::error::Result;
use crate::metrics::{FactorErrors, factor_errors};
use crate::pictures::changes_picture;
use crate::report::{SweepReport, SweepRow};
use crate::swept::{SunMoment, SweptSun};
use crate::truth::SunShape;

/// The result of a sweep.
pub struct Swept {
    /// Tables and figures.
    pub report: SweepReport,
    /// For each technique a picture of the pixels that change more or less often than with rays.
    pub pictures: Vec<Picture>,
}

/// The results of a technique, or of rays, accumulated over the steps.
struct Track {
    changes: Changes,
    by_step: Vec<Option<f64>>,
    wrong: Vec<Option<f64>>,
}

impl Track {
    fn new(pixels: usize) -> Self {
        Self { changes: Changes::new(pixels), by_step: Vec::new(), wrong: Vec::new() }
    }

    fn add(&mut self, factors: &[f32], truth: &[f32], is_compared: &[bool]) -> Result<()> {
        self.by_step.push(self.changes.add(factors, is_compared)?.share());
        let errors = factor_errors(factors, truth, |i| is_compared[i])?;
        self.wrong.push(errors.as_ref().map(FactorErrors::wrong));
        Ok(())
    }

    /// Returns the row of the report, compared with the changes of rays.
    fn row(self, name: String, seconds: &[f64], rays: &Changes) -> Result<SweepRow> {
        let wrong = || self.wrong.iter().zip(seconds).filter_map(|(wrong, at)| Some(((*wrong)?, *at)));
        let worst = wrong().max_by(|a, b| a.0.total_cmp(&b.0));
        let count = wrong().count();
        let excess: Option<Excess> = self.changes.excess(rays)?;
        Ok(SweepRow {
            name,
            wrong: (count > 0).then(|| wrong().map(|(wrong, _)| wrong).sum::<f64>() / count as f64),
            worst_wrong: worst.map(|worst| worst.0),
            worst_seconds: worst.map(|worst| worst.1),
            changes: self.changes.total().share(),
            excess: excess.map(|excess| excess.per_step),
            steady_excess: excess.map(|excess| excess.steady_per_step),
            more_often: excess.map(|excess| excess.pixels),
            most_excess: excess.map(|excess| excess.most),
            wrong_by_step: self.wrong,
            changes_by_step: self.by_step,
        })
    }
}

/// Moves `sun` step by step, draws every contender at `camera` each time, and compares each pixel with one
/// ray towards the sun's centre. Skips steps in which the sun is below the horizon, and contenders without
/// pipelines.
///
/// Pixels where G-buffer and rays see different surfaces are excluded, and so are pixels that face away from
/// the sun in the current step.
///
/// Cost: a frame per step and contender, and a ray per pixel and step. Rays are not cached. Memory: 12 bytes
/// per pixel and contender, for any number of steps.
///
/// # Errors
/// Returns the errors of the renderer, and an error if a key of the sun's path cannot be read.
pub fn sweep(
    renderer: &mut Renderer,
    reference: &Reference<'_, '_>,
    camera: &Camera,
    sun: &mut SweptSun,
    contenders: &mut [Contender],
) -> Result<Swept> {
    let shot = |towards_sun: [f64; 3]| Shot { camera: *camera, towards_sun, number: 0 };
    let surfaces = reference.cache.surfaces(reference.truth, reference.scene, camera);
    let drawn = drawn_surface(renderer, &shot(reference.towards_sun))?;
    let (counts, _) = reference.count(&surfaces, &drawn);
    let mut prepared: Vec<_> = contenders
        .iter_mut()
        .filter_map(|Contender { spec, prepared, .. }| Some((spec.to_string(), prepared.as_mut()?)))
        .collect();
    let mut rays = Track::new(surfaces.pixels());
    let mut tracks: Vec<Track> = prepared.iter().map(|_| Track::new(surfaces.pixels())).collect();
    let moments = sun.moments().to_vec();
    let (mut seconds, mut elevation_degrees) = (Vec::new(), Vec::new());
    for moment in &moments {
        let &SunMoment { seconds: at, towards_sun: Some(towards_sun) } = moment else {
            tracks.iter_mut().chain([&mut rays]).for_each(|track| track.changes.interrupt());
            continue;
        };
        sun.set(at, towards_sun)?;
        seconds.push(at);
        elevation_degrees.push(towards_sun[1].asin().to_degrees());
        let (_, is_compared) = Reference { towards_sun, ..*reference }.count(&surfaces, &drawn);
        let truth = reference.truth.factors(&surfaces, towards_sun, SunShape::Hard);
        rays.add(&truth, &truth, &is_compared)?;
        for ((_, prepared), track) in prepared.iter_mut().zip(&mut tracks) {
            renderer.draw(&shot(towards_sun), prepared, Answer::Visibility)?;
            track.add(&renderer.read_factor(prepared)?, &truth, &is_compared)?;
        }
    }
    let size = [camera.width, camera.height];
    let beyond = tracks.iter().map(|track| changes_picture(size, &track.changes.beyond(&rays.changes)?));
    let pictures = beyond.collect::<Result<_>>()?;
    let rows = prepared.into_iter().zip(tracks);
    let techniques = rows.map(|((name, _), track)| track.row(name, &seconds, &rays.changes));
    let report = SweepReport {
        steps: moments.len() as u32,
        nights: (moments.len() - seconds.len()) as u32,
        utc_offset_seconds: sun.utc_offset_seconds(),
        keys: sun.path().map(|path| path.key_seconds().len() as u64),
        pixels: rays.changes.compared(),
        excluded: counts.excluded,
        rays_changes: rays.changes.total().share(),
        techniques: techniques.collect::<Result<_>>()?,
        rays_changes_by_step: rays.by_step,
        seconds,
        elevation_degrees,
    };
    Ok(Swept { report, pictures })
}
