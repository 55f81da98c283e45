//! Draws frames according to the settings. Keeps the scene on the device, the techniques of both sides, and
//! their pictures.

mod sides;

use std::sync::Arc;

use adumbra::Bounds;
use adumbra_compare::pictures::picture_of_rgba;
use adumbra_render::layers::{Layer, LayerPass, LinePass, PresentKind, PresentPass, WorldLine};
use adumbra_render::occlusion::{
    AmbientSettings, AmbientSource, DEFAULT_RADIUS_SHARE, GivenAmbient, OcclusionPasses,
};
use adumbra_render::readback::read_texture;
use adumbra_render::{Gpu, RenderError, Renderer, Result, SceneOptions, Shot, SpecText};
use adumbra_scene::{Camera, Scene};
use adumbra_truth::movers::BallPath;
use adumbra_truth::picture::Picture;

pub(crate) use self::sides::SideView;
use crate::command::Side;
use crate::loaded_scene::LoadedScene;
use crate::settings::{Settings, Shown};
use crate::shadow_file::ShownFile;
use crate::traced::{TraceKey, Traced};

/// A scene with everything that is needed to draw it.
pub(crate) struct Stage {
    gpu: Gpu,
    scene: Arc<LoadedScene>,
    renderer: Renderer,
    /// Everything that moves, the ball last.
    moving: Scene,
    ball: Option<BallPath>,
    /// Number of balls so far. Visibilities traced with another ball belong to another scene.
    balls: u64,
    layer_pass: LayerPass,
    line_pass: LinePass,
    sides: [SideView; 2],
    ambient: Option<SpecText>,
    traced: Option<Traced>,
    given_ambient: Option<TraceKey>,
    frame: u32,
}

/// Inputs of a frame besides the settings.
pub(crate) struct FrameContext<'a> {
    pub(crate) file: Option<&'a ShownFile>,
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

    /// Returns the faults of either side since the last call.
    pub(crate) fn take_faults(&mut self) -> impl Iterator<Item = String> {
        self.sides.iter_mut().filter_map(SideView::take_fault)
    }

    pub(crate) fn ball(&self) -> Option<&BallPath> {
        self.ball.as_ref()
    }

    /// Returns the time in seconds at which all movements have ended; `None` if nothing moves.
    pub(crate) fn end_seconds(&self) -> Option<f64> {
        (!self.moving.movers.is_empty()).then(|| self.moving.movers.end_seconds())
    }

    /// Adds a ball on its path, or removes it.
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

    /// Marks the shadow file as changed: techniques that read it are rebuilt.
    pub(crate) fn forget_file(&mut self) {
        self.sides.iter_mut().for_each(SideView::forget_file);
    }

    pub(crate) fn set_traced(&mut self, traced: Traced) {
        self.traced = Some(traced);
        self.given_ambient = None;
    }

    /// Returns the key of the rays that these settings need, if they need any.
    pub(crate) fn trace_key(&self, settings: &Settings) -> Option<TraceKey> {
        let sun = settings.uses_traced().then(|| settings.sun.towards());
        let ambient = match AmbientSettings::from_spec(&settings.ambient, self.default_radius()) {
            Ok(AmbientSettings::Traced(traced)) => Some((traced.radius_world, traced.rays)),
            _ => None,
        };
        if sun.is_none() && ambient.is_none() {
            return None;
        }
        let seconds = if self.moving.movers.is_empty() { 0.0 } else { settings.seconds };
        let ball = if self.ball.is_some() { self.balls } else { 0 };
        let scene = [self.scene.number, ball];
        Some(TraceKey { scene, camera: fine(settings), seconds, sun, ambient })
    }

    /// Whether the rays with this key are available.
    pub(crate) fn has_traced(&self, key: &TraceKey) -> bool {
        self.traced.as_ref().is_some_and(|t| t.key == *key)
    }

    /// Default radius of ambient occlusion, in world units.
    pub(crate) fn default_radius(&self) -> f64 {
        DEFAULT_RADIUS_SHARE * self.scene.usual_diagonal_world
    }

    /// Draws the visible sides.
    ///
    /// # Errors
    /// Returns the device's errors. A technique that cannot be drawn is a fault of its side, which is then
    /// shown without shadows.
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
            side.prepare(&self.renderer, spec, context.file, traced, size, settings.antialias)?;
            side.draw(&mut self.renderer, &shot, (settings.layer, settings.antialias), &self.layer_pass)?;
            let anchor = settings.camera.eye.map(|c| f64::from(c as f32));
            self.renderer.draw_lines(&self.line_pass, side.picture(), anchor, context.lines)?;
        }
        Ok(())
    }

    /// Sets the renderer's ambient occlusion according to the settings.
    fn set_ambient(&mut self, settings: &Settings, key: Option<&TraceKey>) -> Result<()> {
        let spec = &settings.ambient;
        let asked = AmbientSettings::from_spec(spec, self.default_radius())?;
        if let AmbientSettings::Traced(_) = asked {
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
            let source = match asked {
                AmbientSettings::Estimated(settings) => {
                    Some(AmbientSource::from(OcclusionPasses::new(&self.gpu, settings)))
                }
                AmbientSettings::Traced(_) | AmbientSettings::Open => None,
            };
            self.gpu.check()?;
            self.renderer.set_ambient(source);
        }
        self.ambient = Some(spec.clone());
        Ok(())
    }

    /// Draws the sides to a target of their size.
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

    /// Returns the picture that is shown, without any overlay.
    ///
    /// # Errors
    /// Returns the device's errors.
    pub(crate) fn screenshot(&self, settings: &Settings) -> Result<Picture> {
        let format = adumbra_render::layers::SHOWN_FORMAT;
        let size = [settings.camera.width, settings.camera.height];
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
        let texture = self.gpu.texture("view::screenshot", size, format, usage);
        let pass = PresentPass::new(&self.gpu, format)?;
        let mut encoder = self.gpu.encoder("view::screenshot");
        self.present(&pass, &mut encoder, &texture.create_view(&Default::default()), settings);
        self.gpu.finish(encoder.finish())?;
        let rgba = read_texture(&self.gpu, &texture, 0, 0)?;
        Ok(picture_of_rgba(size, &rgba))
    }

    /// Returns why a visible technique cannot be drawn, if there is one.
    pub(crate) fn failure(&self, settings: &Settings) -> Option<&str> {
        let seen = if settings.shows_both() { 2 } else { 1 };
        self.sides[..seen].iter().find_map(SideView::failure)
    }

    /// Returns why a side lacks a layer, if it does.
    pub(crate) fn missing(&self, side: Side, layer: Layer) -> Option<String> {
        self.side(side).missing(layer)
    }
}

/// Returns the settings' camera with one pixel per sample.
fn fine(settings: &Settings) -> Camera {
    let Settings { camera, antialias, .. } = settings;
    Camera { width: camera.width * antialias, height: camera.height * antialias, ..*camera }
}

/// Whether an error ends the view, as the loss of the device does. All other errors are shown in it.
pub(crate) fn is_fatal(error: &RenderError) -> bool {
    matches!(error, RenderError::Lost { .. })
}
