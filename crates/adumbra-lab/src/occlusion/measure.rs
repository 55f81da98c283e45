//! What estimators are measured on: a scene drawn on a device, and the rays that judge what a camera sees of it.

use adumbra::camera::Camera;
use adumbra::scene::Scene;
use adumbra_render::occlusion::OcclusionPasses;
use adumbra_render::{
    Answer, Baked, FrameTimes, Gpu, Prepared, Renderer, SceneOptions, Shot, SurfaceImage, build,
};

use super::{OcclusionErrors, occlusion_errors};
use crate::compare::SAME_SURFACE;
use crate::error::Result;
use crate::report::PixelCounts;
use crate::truth::{Cache, Key, Surfaces, TruthTracer, standard_error};

/// Straight up: no figure here depends on the sun.
const TOWARDS_SUN: [f64; 3] = [0.0, 1.0, 0.0];

/// A scene on a device, seen by a camera.
pub struct OcclusionStage {
    renderer: Renderer,
    none: Prepared,
    shot: Shot,
}

/// What judges: rays, kept in a cache.
#[derive(Clone, Copy)]
pub struct OcclusionJudge<'a, 's> {
    /// The scene's rays.
    pub truth: &'a TruthTracer<'s>,
    /// Where traced pictures are kept.
    pub cache: &'a Cache,
    /// The scene's part of their keys.
    pub scene: &'a Key,
    /// How far what occludes may be, world units.
    pub radius_world: f64,
    /// Rays a pixel.
    pub rays: u32,
}

/// The truth of what a stage's camera sees, one value a pixel.
pub struct Judged {
    /// What rays see.
    pub surfaces: Surfaces,
    /// Ambient visibility by rays.
    pub truth: Vec<f32>,
    /// Where rays and G-buffer see the same surface, within [`SAME_SURFACE`].
    pub counted: Vec<bool>,
    /// How many those are, and what became of the others; no pixel faces away from a sky.
    pub pixels: PixelCounts,
}

impl OcclusionStage {
    /// Uploads a scene and draws what `camera` sees of it.
    ///
    /// # Errors
    /// What the renderer reports.
    pub fn new(gpu: Gpu, scene: &Scene, options: SceneOptions, camera: Camera) -> Result<Self> {
        let renderer = Renderer::new(gpu, scene, options)?;
        let none = renderer.prepare(build(renderer.gpu(), &"none".parse()?, Baked::default())?)?;
        let shot = Shot { camera, towards_sun: TOWARDS_SUN, number: 0 };
        let mut stage = Self { renderer, none, shot };
        stage.look(camera, 0)?;
        Ok(stage)
    }

    /// Draws what `camera` sees, as the frame of that number.
    ///
    /// # Errors
    /// What the renderer reports.
    pub fn look(&mut self, camera: Camera, number: u32) -> Result<()> {
        self.shot = Shot { camera, towards_sun: TOWARDS_SUN, number };
        self.renderer.draw(&self.shot, &mut self.none, Answer::Visibility)?;
        Ok(())
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        self.renderer.gpu()
    }

    /// The camera that it is seen by.
    pub fn camera(&self) -> &Camera {
        &self.shot.camera
    }

    /// What the G-buffer holds.
    ///
    /// # Errors
    /// What the device reports.
    pub fn surface(&self) -> Result<SurfaceImage> {
        Ok(self.renderer.read_surface(&self.shot)?)
    }

    /// Occludes what is seen.
    ///
    /// # Errors
    /// What the device reports.
    pub fn occlude(&self, passes: &mut OcclusionPasses) -> Result<FrameTimes> {
        Ok(self.renderer.occlude(&self.shot, passes)?)
    }

    /// Ambient visibility of what is seen, row 0 at the top.
    ///
    /// # Errors
    /// What the device reports.
    pub fn visibility(&self, passes: &mut OcclusionPasses) -> Result<Vec<f32>> {
        self.occlude(passes)?;
        Ok(passes.read(self.gpu())?)
    }
}

impl OcclusionJudge<'_, '_> {
    /// The truth of what the stage's camera sees. Cost: that of [`TruthTracer::ambient`], where it is not kept yet.
    ///
    /// # Errors
    /// What the device reports.
    pub fn judge(&self, stage: &OcclusionStage) -> Result<Judged> {
        let (surfaces, truth) = self.trace(stage.camera());
        let drawn = stage.surface()?;
        let mut pixels = PixelCounts::default();
        let counted = surfaces.view_depth.iter().zip(&drawn.view_depth).map(|(&traced, &drawn)| {
            let same = (traced - f64::from(drawn)).abs() <= SAME_SURFACE * traced.abs();
            let count = match (traced.is_finite(), drawn.is_finite()) {
                (true, true) if same => &mut pixels.compared,
                (false, false) => &mut pixels.sky,
                _ => &mut pixels.excluded,
            };
            *count += 1;
            traced.is_finite() && drawn.is_finite() && same
        });
        let counted = counted.collect();
        Ok(Judged { surfaces, truth, counted, pixels })
    }

    /// What `camera` sees, and its ambient visibility.
    pub(super) fn trace(&self, camera: &Camera) -> (Surfaces, Vec<f32>) {
        let surfaces = self.cache.surfaces(self.truth, self.scene, camera);
        let (radius, rays) = (self.radius_world, self.rays);
        let truth = self.cache.ambient(self.truth, self.scene, camera, &surfaces, radius, rays);
        (surfaces, truth)
    }
}

impl Judged {
    /// Errors over the pixels that count.
    ///
    /// # Errors
    /// [`crate::Error::Sizes`] where the visibility is of another size.
    pub fn errors(&self, visibility: &[f32]) -> Result<OcclusionErrors> {
        occlusion_errors(visibility, &self.truth, |i| self.counted[i])
    }

    /// Errors of open sky everywhere.
    pub fn errors_of_none(&self) -> OcclusionErrors {
        self.errors(&vec![1.0; self.truth.len()]).unwrap_or_default()
    }

    /// Bound on the truth's standard error, see [`standard_error`].
    pub fn error_bound(&self, rays: u32) -> f64 {
        standard_error(&self.truth, rays, |i| self.counted[i])
    }
}
