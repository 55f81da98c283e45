//! Draws what the settings say: keeps a scene on the device, the techniques of both sides, and their pictures.

mod sides;

use std::sync::Arc;

use adumbra::camera::Camera;
use adumbra::picture::Picture;
use adumbra::scene::{Bounds, Scene};
use adumbra_lab::pictures::picture_of_rgba;
use adumbra_render::layers::{Layer, LayerPass, LinePass, PresentKind, PresentPass, WorldLine};
use adumbra_render::movers::BallPath;
use adumbra_render::occlusion::{
    AmbientSource, DEFAULT_RADIUS_SHARE, GivenAmbient, OcclusionPasses, OcclusionSettings, TracedSettings,
};
use adumbra_render::readback::read_texture;
use adumbra_render::{Gpu, RenderError, Renderer, Result, SceneOptions, Shot, TechniqueSpec};

pub(crate) use self::sides::{Files, SideView};
use crate::command::Side;
use crate::loading::LoadedScene;
use crate::settings::{Settings, Shown};
use crate::tracing::{TraceKey, Traced};

/// A scene with everything that is drawn of it.
pub(crate) struct Stage {
    gpu: Gpu,
    scene: Arc<LoadedScene>,
    renderer: Renderer,
    /// What moves, the ball last.
    moving: Scene,
    ball: Option<BallPath>,
    /// Counts the balls that there were: what was traced with another is of another scene.
    balls: u64,
    layer_pass: LayerPass,
    line_pass: LinePass,
    sides: [SideView; 2],
    ambient: Option<TechniqueSpec>,
    traced: Option<Traced>,
    given_ambient: Option<TraceKey>,
    frame: u32,
}

/// What a frame is drawn with besides the settings.
pub(crate) struct FrameContext<'a> {
    pub(crate) files: &'a Files,
    pub(crate) lines: &'a [WorldLine],
}

impl Stage {
    pub(crate) fn new(gpu: &Gpu, scene: Arc<LoadedScene>) -> Result<Self> {
        let options = SceneOptions { ignore_alpha: scene.ignore_alpha };
        let mut renderer = Renderer::new(gpu.clone(), &scene.still, options)?;
        if !scene.moving.movers.is_empty() {
            renderer.set_movers(&scene.moving, options)?;
        }
        let moving = scene.moving.clone();
        Ok(Self {
            sides: [SideView::new(gpu)?, SideView::new(gpu)?],
            layer_pass: LayerPass::new(gpu)?,
            line_pass: LinePass::new(gpu)?,
            gpu: gpu.clone(),
            scene,
            renderer,
            moving,
            ball: None,
            balls: 0,
            ambient: None,
            traced: None,
            given_ambient: None,
            frame: 0,
        })
    }

    pub(crate) fn scene(&self) -> &Arc<LoadedScene> {
        &self.scene
    }

    pub(crate) fn bounds(&self) -> Bounds {
        self.scene.whole.bounds()
    }

    pub(crate) fn side(&self, side: Side) -> &SideView {
        &self.sides[side as usize]
    }

    /// What went wrong with either side since this was asked last.
    pub(crate) fn take_faults(&mut self) -> impl Iterator<Item = String> {
        self.sides.iter_mut().filter_map(SideView::take_fault)
    }

    pub(crate) fn ball(&self) -> Option<&BallPath> {
        self.ball.as_ref()
    }

    /// Seconds after which everything has come to its end; none where nothing moves.
    pub(crate) fn end_seconds(&self) -> Option<f64> {
        (!self.moving.movers.is_empty()).then(|| self.moving.movers.end_seconds())
    }

    /// Puts a ball on its way, or takes it away.
    pub(crate) fn set_ball(&mut self, ball: Option<BallPath>) -> Result<()> {
        self.moving = self.scene.moving.clone();
        if let Some(ball) = &ball {
            ball.add_to(&mut self.moving);
            self.balls += 1;
        }
        self.ball = ball;
        self.given_ambient = None;
        if self.moving.movers.is_empty() {
            self.renderer.remove_movers();
            return Ok(());
        }
        let options = SceneOptions { ignore_alpha: self.scene.ignore_alpha };
        self.renderer.set_movers(&self.moving, options)
    }

    /// Files changed: techniques that read them are built anew.
    pub(crate) fn forget_files(&mut self) {
        self.sides.iter_mut().for_each(SideView::forget_file);
    }

    pub(crate) fn set_traced(&mut self, traced: Traced) {
        self.traced = Some(traced);
        self.given_ambient = None;
    }

    /// The rays that these settings need, where some do.
    pub(crate) fn trace_key(&self, settings: &Settings) -> Option<TraceKey> {
        let sun = settings.uses("truth").then(|| settings.sun.towards());
        let ambient = (settings.ambient.name() == "truth")
            .then(|| TracedSettings::from_spec(&settings.ambient, self.default_radius()).ok())
            .flatten()
            .map(|traced| (traced.radius_world, traced.rays));
        if sun.is_none() && ambient.is_none() {
            return None;
        }
        let seconds = if self.moving.movers.is_empty() { 0.0 } else { settings.seconds };
        let ball = if self.ball.is_some() { self.balls } else { 0 };
        let scene = [self.scene.number, ball];
        Some(TraceKey { scene, camera: fine(settings), seconds, sun, ambient })
    }

    /// Whether the rays that these settings need are there.
    pub(crate) fn has_traced(&self, key: &TraceKey) -> bool {
        self.traced.as_ref().is_some_and(|t| t.key == *key)
    }

    /// Of ambient occlusion, where it does not say, world units.
    pub(crate) fn default_radius(&self) -> f64 {
        DEFAULT_RADIUS_SHARE * self.scene.usual_diagonal_world
    }

    /// Draws the sides that are seen.
    ///
    /// # Errors
    /// What the device reports; a technique that cannot be drawn is told by its side, which then shows no shadows.
    pub(crate) fn draw(&mut self, settings: &Settings, context: &FrameContext<'_>) -> Result<()> {
        self.moving.pose(settings.seconds);
        self.renderer.move_movers(&self.moving);
        let key = self.trace_key(settings);
        self.set_ambient(settings, key.as_ref())?;
        self.frame = self.frame.wrapping_add(1);
        let shot = Shot { camera: settings.camera, towards_sun: settings.sun.towards(), number: self.frame };
        let size = [settings.camera.width, settings.camera.height];
        let seen = if settings.shows_both() { 2 } else { 1 };
        for (side, spec) in self.sides.iter_mut().zip(&settings.shadows).take(seen) {
            let traced = self.traced.as_ref().filter(|t| Some(&t.key) == key.as_ref());
            side.prepare(&self.renderer, spec, context.files, traced, size, settings.antialias)?;
            side.draw(&mut self.renderer, &shot, (settings.layer, settings.antialias), &self.layer_pass)?;
            let anchor = settings.camera.eye.map(|c| f64::from(c as f32));
            self.renderer.draw_lines(&self.line_pass, side.picture(), anchor, context.lines)?;
        }
        Ok(())
    }

    /// Makes the renderer's ambient occlusion what the settings ask for.
    fn set_ambient(&mut self, settings: &Settings, key: Option<&TraceKey>) -> Result<()> {
        let spec = &settings.ambient;
        if spec.name() == "truth" {
            let traced = self.traced.as_ref().filter(|t| Some(&t.key) == key);
            let (Some(traced), Some(key)) = (traced, key) else {
                self.ambient = None;
                self.renderer.set_ambient(None);
                return Ok(());
            };
            if self.given_ambient == Some(*key) && self.ambient.as_ref() == Some(spec) {
                return Ok(());
            }
            if let Some(visibility) = &traced.ambient {
                let size = [key.camera.width, key.camera.height];
                let given = GivenAmbient::new(&self.gpu, size, visibility)?;
                self.renderer.set_ambient(Some(given.into()));
                self.given_ambient = Some(*key);
            }
        } else if self.ambient.as_ref() != Some(spec) {
            let source = if spec.name() == "none" {
                None
            } else {
                let settings = OcclusionSettings::from_spec(spec, self.default_radius())?;
                Some(AmbientSource::from(OcclusionPasses::new(&self.gpu, settings)))
            };
            self.gpu.check()?;
            self.renderer.set_ambient(source);
        }
        self.ambient = Some(spec.clone());
        Ok(())
    }

    /// Puts the sides onto a target of their size.
    pub(crate) fn present(
        &self,
        pass: &PresentPass,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
        settings: &Settings,
    ) {
        let divider = |at: f64| (at * f64::from(settings.camera.width)).round() as u32;
        let kind = match settings.shown {
            Shown::Single => PresentKind::First,
            Shown::Split(at) => PresentKind::Split { divider: divider(at) },
            Shown::Difference(gain) => PresentKind::Difference { gain },
        };
        let second = if settings.shows_both() { 1 } else { 0 };
        let pictures = [self.sides[0].picture(), self.sides[second].picture()];
        pass.encode(&self.gpu, encoder, target, pictures, kind);
    }

    /// What is shown, without anything over it.
    ///
    /// # Errors
    /// What the device reports.
    pub(crate) fn screenshot(&self, settings: &Settings) -> Result<Picture> {
        let format = adumbra_render::layers::SHOWN_FORMAT;
        let size = [settings.camera.width, settings.camera.height];
        let texture = self.gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("view::screenshot"),
            size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let pass = PresentPass::new(&self.gpu, format)?;
        let mut encoder = self.gpu.encoder("view::screenshot");
        self.present(&pass, &mut encoder, &texture.create_view(&Default::default()), settings);
        self.gpu.finish(encoder.finish())?;
        let rgba = read_texture(&self.gpu, &texture, 0, 0)?;
        Ok(picture_of_rgba(size, &rgba))
    }

    /// Why a technique that is seen cannot be drawn, where one cannot.
    pub(crate) fn failure(&self, settings: &Settings) -> Option<&str> {
        let seen = if settings.shows_both() { 2 } else { 1 };
        self.sides[..seen].iter().find_map(SideView::failure)
    }

    /// Why a layer is not there on a side, where it is not.
    pub(crate) fn missing(&self, side: Side, layer: Layer) -> Option<String> {
        self.side(side).missing(layer)
    }
}

/// The settings' camera with all samples as pixels.
fn fine(settings: &Settings) -> Camera {
    let Settings { camera, antialias, .. } = settings;
    Camera { width: camera.width * antialias, height: camera.height * antialias, ..*camera }
}

/// A device that is gone ends the view; everything else is shown in it.
pub(crate) fn is_fatal(error: &RenderError) -> bool {
    matches!(error, RenderError::Lost { .. })
}
