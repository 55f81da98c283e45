//! The stage on which estimators are measured: a scene drawn on a device, and the ray-traced truth of a
//! camera's view.

use adumbra_render::occlusion::OcclusionPasses;
use adumbra_render::{
    Answer, FrameTimes, Gpu, Prepared, Renderer, SceneOptions, Shot, SurfaceImage, TechniqueFiles, build,
};
use adumbra_scene::{Camera, Scene};

use super::{OcclusionErrors, occlusion_errors};
use adumbra_compare::compare::{SAME_SURFACE, take_turns};
use adumbra_compare::error::Result;
use adumbra_compare::report::PixelCounts;
use adumbra_compare::truth::{Cache, Key, Surfaces, TruthTracer, standard_error};

/// Straight up, as no result here depends on the sun.
const TOWARDS_SUN: [f64; 3] = [0.0, 1.0, 0.0];

/// A scene on a device, seen by a camera.
pub struct OcclusionStage {
    renderer: Renderer,
    none: Prepared,
    shot: Shot,
}

/// Ray-traced truth, kept in a cache.
#[derive(Clone, Copy)]
pub struct OcclusionReference<'a, 's> {
    /// Ray tracer of the scene.
    pub truth: &'a TruthTracer<'s>,
    /// Cache of traced pictures.
    pub cache: &'a Cache,
    /// The scene's part of the cache keys.
    pub scene: &'a Key,
    /// Largest distance of an occluder in world units.
    pub radius_world: f64,
    /// Rays per pixel.
    pub rays: u32,
}

/// The truth for the view of a stage's camera, one value per pixel.
pub struct TracedView {
    /// Surfaces hit by rays.
    pub surfaces: Surfaces,
    /// Ambient visibility by rays.
    pub truth: Vec<f32>,
    /// Whether rays and G-buffer see the same surface, within [`SAME_SURFACE`].
    pub counted: Vec<bool>,
    /// Counts of these pixels and of the others by reason. No pixel counts as facing away, because the sky
    /// has no direction.
    pub pixels: PixelCounts,
}

impl OcclusionStage {
    /// Uploads a scene and draws the view of `camera`.
    ///
    /// # Errors
    /// Returns the errors of the renderer.
    pub fn new(gpu: Gpu, scene: &Scene, options: SceneOptions, camera: Camera) -> Result<Self> {
        let renderer = Renderer::new(gpu, scene, options)?;
        let none = renderer.prepare(build(renderer.gpu(), &"none".parse()?, TechniqueFiles::default())?)?;
        let shot = Shot { camera, towards_sun: TOWARDS_SUN, number: 0 };
        let mut stage = Self { renderer, none, shot };
        stage.look(camera, 0)?;
        Ok(stage)
    }

    /// Draws the view of `camera`, as frame `number`.
    ///
    /// # Errors
    /// Returns the errors of the renderer.
    pub fn look(&mut self, camera: Camera, number: u32) -> Result<()> {
        self.shot = Shot { camera, towards_sun: TOWARDS_SUN, number };
        self.renderer.draw(&self.shot, &mut self.none, Answer::Visibility)?;
        Ok(())
    }

    /// Returns the device.
    pub fn gpu(&self) -> &Gpu {
        self.renderer.gpu()
    }

    /// Returns the current camera.
    pub fn camera(&self) -> &Camera {
        &self.shot.camera
    }

    /// Reads the G-buffer.
    ///
    /// # Errors
    /// Returns the errors of the device.
    pub fn surface(&self) -> Result<SurfaceImage> {
        Ok(self.renderer.read_surface(&self.shot)?)
    }

    /// Runs the occlusion passes on the current view.
    ///
    /// # Errors
    /// Returns the errors of the device.
    pub fn occlude(&self, passes: &mut OcclusionPasses) -> Result<FrameTimes> {
        Ok(self.renderer.occlude(&self.shot, passes)?)
    }

    /// Runs each of `passes` on the current view for `frames` frames, in alternation, and returns the times
    /// of each. Each round begins with a different pass, so that no pass always runs first.
    ///
    /// # Errors
    /// Returns the errors of the device.
    pub fn times(&self, passes: &mut [OcclusionPasses], frames: u32) -> Result<Vec<Vec<FrameTimes>>> {
        take_turns(passes.len(), frames, |at| self.occlude(&mut passes[at]))
    }

    /// Returns the ambient visibility of the current view, row 0 at the top.
    ///
    /// # Errors
    /// Returns the errors of the device.
    pub fn visibility(&self, passes: &mut OcclusionPasses) -> Result<Vec<f32>> {
        self.occlude(passes)?;
        Ok(passes.read(self.gpu())?)
    }
}

impl OcclusionReference<'_, '_> {
    /// Returns the truth for the view of the stage's camera.
    ///
    /// Cost: that of [`TruthTracer::ambient`], if it is not cached yet.
    ///
    /// # Errors
    /// Returns the errors of the device.
    pub fn trace_view(&self, stage: &OcclusionStage) -> Result<TracedView> {
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
        Ok(TracedView { surfaces, truth, counted, pixels })
    }

    /// Traces the surfaces that `camera` sees and their ambient visibility, or takes them from the cache.
    pub(super) fn trace(&self, camera: &Camera) -> (Surfaces, Vec<f32>) {
        let surfaces = self.cache.surfaces(self.truth, self.scene, camera);
        let (radius, rays) = (self.radius_world, self.rays);
        let truth = self.cache.ambient(self.truth, self.scene, camera, &surfaces, radius, rays);
        (surfaces, truth)
    }
}

impl TracedView {
    /// Returns the errors over the pixels that count.
    ///
    /// # Errors
    /// Returns [`adumbra_compare::Error::Sizes`] if the visibility is of another size.
    pub fn errors(&self, visibility: &[f32]) -> Result<OcclusionErrors> {
        occlusion_errors(visibility, &self.truth, |i| self.counted[i])
    }

    /// Returns the errors of open sky everywhere.
    pub fn errors_of_none(&self) -> OcclusionErrors {
        self.errors(&vec![1.0; self.truth.len()]).unwrap_or_default()
    }

    /// Returns a bound on the truth's standard error, see [`standard_error`].
    pub(crate) fn error_bound(&self, rays: u32) -> f64 {
        standard_error(&self.truth, rays, |i| self.counted[i])
    }
}
