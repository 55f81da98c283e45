//! Draws frames (G-buffer, a technique's passes, its look-up, composite) and reads their results back.

use adumbra::Bounds;
use adumbra_scene::{Camera, Projection, Scene};
use adumbra_shaders::layout::PointQuery;

use crate::composite::Composite;
use crate::error::{RenderError, Result};
use crate::frame::{GBuffer, Target, Targets, check_camera, frame, visible_volume};
use crate::gpu::Gpu;
use crate::occlusion::{AmbientSource, OcclusionInput, OcclusionPasses};
use crate::readback::{read_floats, read_texture};
use crate::scene::{InstanceList, SceneBuffers, SceneOptions};
use crate::technique::{Answer, FrameInput, Lookup, Resolver, Technique};
use crate::timing::{FrameTimes, Stage, StageTimer};

/// A scene on a device, with everything needed to draw it except a technique.
pub struct Renderer {
    gpu: Gpu,
    gbuffer: GBuffer,
    resolver: Resolver,
    composite: Composite,
    scene: Part,
    movers: Option<Part>,
    targets: Option<Targets>,
    frame: wgpu::Buffer,
    ambient: Option<AmbientSource>,
    /// The kind of answer in the last frame.
    answered: Answer,
    /// The parts of the last frame that can be reused.
    drawn: Option<Drawn>,
}

/// A frame whose G-buffer still matches the scene.
struct Drawn {
    shot: Shot,
    /// Whether its ambient occlusion can be reused too.
    ambient: bool,
    /// Times of the G-buffer and of ambient occlusion.
    times: FrameTimes,
}

struct Part {
    buffers: SceneBuffers,
    seen: InstanceList,
}

/// A technique with its pipelines.
pub struct Prepared {
    technique: Box<dyn Technique>,
    lookup: Lookup,
}

impl Prepared {
    /// The technique.
    pub fn technique(&self) -> &dyn Technique {
        &*self.technique
    }
}

/// The camera and sun of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shot {
    /// The camera.
    pub camera: Camera,
    /// Unit vector towards the sun.
    pub towards_sun: [f64; 3],
    /// Frame number.
    pub number: u32,
}

/// A surface point to look up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// World position.
    pub p_world: [f64; 3],
    /// Unit normal, or zero.
    pub normal: [f64; 3],
}

/// Per-pixel content of the last frame's G-buffer, row 0 at the top.
pub struct SurfaceImage {
    /// Distance along the camera's forward direction, world units; infinite for the background.
    pub view_depth: Vec<f32>,
    /// World normal, facing the viewer.
    pub normal: Vec<[f32; 3]>,
}

impl Renderer {
    /// Uploads a scene.
    ///
    /// # Errors
    /// Returns an error if the device cannot hold the scene.
    pub fn new(gpu: Gpu, scene: &Scene, options: SceneOptions) -> Result<Self> {
        let buffers = SceneBuffers::new(&gpu, scene, options)?;
        let seen = InstanceList::new(&gpu, "scene::seen", &buffers);
        let empty = frame(&EMPTY_CAMERA, &buffers.bounds(), [0.0, 1.0, 0.0], 0);
        let renderer = Self {
            gbuffer: GBuffer::new(&gpu),
            resolver: Resolver::new(&gpu),
            composite: Composite::new(&gpu),
            scene: Part { buffers, seen },
            movers: None,
            targets: None,
            answered: Answer::Visibility,
            drawn: None,
            ambient: None,
            frame: gpu.uniform("frame", &empty.bytes()),
            gpu,
        };
        renderer.gpu.check()?;
        Ok(renderer)
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// The static scene.
    pub fn scene(&self) -> &SceneBuffers {
        &self.scene.buffers
    }

    /// Uploads the movers. They cast and receive shadows like everything else, but no baked file contains
    /// them.
    ///
    /// # Errors
    /// Returns an error if the device cannot hold the movers.
    pub fn set_movers(&mut self, movers: &Scene, options: SceneOptions) -> Result<()> {
        let buffers = SceneBuffers::new(&self.gpu, movers, options)?;
        let seen = InstanceList::new(&self.gpu, "movers::seen", &buffers);
        self.movers = Some(Part { buffers, seen });
        self.drawn = None;
        Ok(())
    }

    /// Removes the movers.
    pub fn remove_movers(&mut self) {
        self.movers = None;
        self.drawn = None;
    }

    /// Updates the transforms of the movers. `movers` is the scene given to [`Renderer::set_movers`] with new
    /// transforms.
    pub fn move_movers(&mut self, movers: &Scene) {
        if let Some(part) = &mut self.movers {
            part.buffers.move_instances(movers);
            self.drawn = None;
        }
    }

    /// Sets the ambient occlusion of the frames that follow. `None` means unoccluded everywhere.
    pub fn set_ambient(&mut self, ambient: Option<AmbientSource>) {
        self.ambient = ambient;
        self.drawn = None;
    }

    /// The ambient occlusion in use.
    pub fn ambient(&self) -> Option<&AmbientSource> {
        self.ambient.as_ref()
    }

    /// The ambient occlusion in use, mutable, for example to reset its history.
    pub fn ambient_mut(&mut self) -> Option<&mut AmbientSource> {
        self.drawn = None;
        self.ambient.as_mut()
    }

    /// Runs ambient occlusion alone on the G-buffer of the last frame, which must have been drawn from
    /// `shot`.
    ///
    /// # Errors
    /// Returns whatever error the device reports.
    pub fn occlude(&self, shot: &Shot, ambient: &mut OcclusionPasses) -> Result<FrameTimes> {
        let mut timer = StageTimer::new(&self.gpu);
        if let Some(targets) = &self.targets {
            self.encode_ambient(shot, targets, ambient, &mut timer)?;
        }
        timer.finish(&self.gpu)
    }

    fn encode_ambient(
        &self,
        shot: &Shot,
        targets: &Targets,
        ambient: &mut OcclusionPasses,
        timer: &mut StageTimer,
    ) -> Result<()> {
        let gpu = &self.gpu;
        let frame = frame(&shot.camera, &self.bounds(), shot.towards_sun, shot.number);
        let input =
            OcclusionInput { frame: &frame, depth: &targets.depth.view, normal: &targets.normal.view };
        ambient.prepare(gpu, &frame);
        timer.stage(gpu, Stage::AmbientSurface, |encoder| ambient.encode_surfaces(gpu, encoder, &input))?;
        timer.stage(gpu, Stage::AmbientEstimate, |encoder| ambient.encode_estimate(gpu, encoder, &input))?;
        if ambient.has_history() {
            timer
                .stage(gpu, Stage::AmbientHistory, |encoder| ambient.encode_history(gpu, encoder, &input))?;
        }
        timer.stage(gpu, Stage::AmbientFilter, |encoder| ambient.encode_filter(gpu, encoder, &input))
    }

    /// Builds a technique's pipelines.
    ///
    /// # Errors
    /// Returns whatever error the device reports.
    pub fn prepare(&self, technique: Box<dyn Technique>) -> Result<Prepared> {
        let lookup = self.resolver.lookup(&self.gpu, &*technique);
        self.gpu.check()?;
        Ok(Prepared { technique, lookup })
    }

    /// Draws a frame. Its results can be read back until the next frame. Screen passes and ambient occlusion
    /// run for [`Answer::Visibility`] only: other answers stay unfiltered, and the history of ambient
    /// occlusion is unchanged.
    ///
    /// # Errors
    /// Returns [`RenderError::Camera`] if nothing can be drawn from the camera, [`RenderError::Technique`] if
    /// the technique does not support `answer`, and [`RenderError::Ambient`] if the given ambient visibility
    /// has another size. Also returns whatever error the technique or the device reports.
    pub fn draw(&mut self, shot: &Shot, prepared: &mut Prepared, answer: Answer) -> Result<FrameTimes> {
        self.drawn = None;
        self.draw_again(shot, prepared, answer)
    }

    /// Draws a frame as [`Renderer::draw`] does, but reuses what it can of the last frame. If `shot` equals
    /// that of the last frame, including its number, and nothing has moved since, the G-buffer is kept, and
    /// so is the ambient occlusion once it has been computed. This serves to draw one frame with another
    /// technique or for another answer. The returned times include those of the reused passes.
    ///
    /// # Errors
    /// Returns the errors of [`Renderer::draw`].
    pub fn draw_again(&mut self, shot: &Shot, prepared: &mut Prepared, answer: Answer) -> Result<FrameTimes> {
        check_camera(&shot.camera)?;
        if !prepared.lookup.answers(answer) {
            let reason = format!("it cannot answer {answer:?}");
            return Err(RenderError::Technique { name: prepared.technique.name(), reason });
        }
        let size = [shot.camera.width, shot.camera.height];
        if let Some(ambient) = &self.ambient {
            ambient.check(size)?;
        }
        // Take the frame out while drawing, so that a failed draw leaves no reusable frame behind.
        let drawn = self.drawn.take().filter(|drawn| drawn.shot == *shot);
        let targets = match self.targets.take() {
            Some(targets) if targets.size == size => targets,
            _ => Targets::new(&self.gpu, size)?,
        };
        self.write_frame(shot);
        let view = shot.camera.view();
        if drawn.is_none() {
            let volume = visible_volume(&view);
            for part in std::iter::once(&mut self.scene).chain(&mut self.movers) {
                part.seen.update(&self.gpu, &part.buffers, view.eye, &volume, false);
            }
        }
        let input = self.input(shot, &view);
        let Prepared { technique, lookup } = prepared;
        technique.prepare(&input)?;
        let mut timer = StageTimer::new(&self.gpu);
        if drawn.is_none() {
            timer.stage(&self.gpu, Stage::GBuffer, |encoder| {
                let parts = std::iter::once(&self.scene).chain(&self.movers);
                let parts = parts.map(|p| (&p.buffers, &p.seen));
                self.gbuffer.encode(&self.gpu, encoder, &self.frame, &targets, parts);
            })?;
        }
        timer.stage(&self.gpu, Stage::Depth, |encoder| technique.encode_depth(&input, encoder))?;
        timer.stage(&self.gpu, Stage::Build, |encoder| technique.encode_build(&input, encoder))?;
        timer.stage(&self.gpu, Stage::Lookup, |encoder| {
            let asked = (&*lookup, answer);
            self.resolver.encode(&self.gpu, encoder, &self.frame, &targets, &**technique, asked);
        })?;
        let filtered = answer == Answer::Visibility && technique.has_screen_passes();
        timer.stage(&self.gpu, Stage::Screen, |encoder| {
            if filtered {
                technique.encode_screen(&input, &self.frame, &targets, encoder);
            }
        })?;
        let mut ambient = self.ambient.take();
        let has_ambient = drawn.as_ref().is_some_and(|drawn| drawn.ambient);
        let open = ambient.as_mut().filter(|_| answer == Answer::Visibility && !has_ambient);
        if let Some(AmbientSource::Estimated(passes)) = open {
            self.encode_ambient(shot, &targets, passes, &mut timer)?;
        }
        timer.stage(&self.gpu, Stage::Composite, |encoder| {
            let factor = if filtered { &targets.filtered } else { &targets.factor };
            let open = ambient.as_ref().filter(|_| answer == Answer::Visibility);
            let open = open.and_then(AmbientSource::target).map(|t| &t.view);
            self.composite.encode(&self.gpu, encoder, &self.frame, &targets, &factor.view, open);
        })?;
        self.ambient = ambient;
        let mut times = timer.finish(&self.gpu)?;
        technique.check(&self.gpu)?;
        if let Some(drawn) = &drawn {
            times.add(&drawn.times);
        }
        self.drawn = Some(Drawn {
            shot: *shot,
            ambient: has_ambient || answer == Answer::Visibility,
            times: times.without_shadows(),
        });
        self.targets = Some(targets);
        self.answered = answer;
        Ok(times)
    }

    /// Looks up the visibility of a list of points, as in a frame drawn from `shot`: cascades are fitted to
    /// its camera.
    ///
    /// # Errors
    /// Returns [`RenderError::Camera`] if nothing can be drawn from the camera, and
    /// [`RenderError::Technique`] if the technique works on whole pictures only, such as a screen-space blur.
    /// Also returns whatever error the technique or the device reports.
    pub fn answer(
        &mut self,
        shot: &Shot,
        prepared: &mut Prepared,
        points: &[SurfacePoint],
    ) -> Result<Vec<f32>> {
        check_camera(&shot.camera)?;
        self.write_frame(shot);
        let view = shot.camera.view();
        let input = self.input(shot, &view);
        let Prepared { technique, lookup } = prepared;
        technique.prepare(&input)?;
        let mut encoder = self.gpu.encoder("answer::depth");
        technique.encode_depth(&input, &mut encoder);
        technique.encode_build(&input, &mut encoder);
        self.gpu.finish(encoder.finish())?;
        technique.check(&self.gpu)?;
        let queries: Vec<PointQuery> = points
            .iter()
            .map(|p| {
                let r: [f64; 3] = std::array::from_fn(|a| p.p_world[a] - input.anchor_world[a]);
                let n = p.normal.map(|c| c as f32);
                // The pixel that the point would have in a frame, because noise is fixed in screen space, not
                // on surfaces.
                let [x, y] = view.pixel(p.p_world).unwrap_or_default();
                let [x, y] = [(x, shot.camera.width), (y, shot.camera.height)]
                    .map(|(c, size)| (c.max(0.0) as u32).min(size.saturating_sub(1)));
                PointQuery {
                    p_relative: r.map(|c| c as f32),
                    view_depth: view.depth(p.p_world) as f32,
                    normal: n,
                    pixel: [x, y],
                }
            })
            .collect();
        self.resolver.answer(&self.gpu, &self.frame, &**technique, lookup, &queries)
    }

    /// Reads the answers of the last frame, row 0 at the top: visibilities after the technique's screen
    /// passes, with 1 for the background, or whichever other [`Answer`] it was drawn for. Empty before the
    /// first frame.
    ///
    /// # Errors
    /// Returns whatever error the device reports.
    pub fn read_factor(&self, prepared: &Prepared) -> Result<Vec<f32>> {
        let Some(targets) = &self.targets else { return Ok(Vec::new()) };
        read_floats(&self.gpu, &self.factor_of(prepared, targets).texture, 0, 0)
    }

    /// Reads the ambient visibility of the last frame drawn for [`Answer::Visibility`], row 0 at the top. 1
    /// means unoccluded or background. All values are 1 without ambient occlusion.
    ///
    /// # Errors
    /// Returns whatever error the device reports.
    pub fn read_ambient(&self) -> Result<Vec<f32>> {
        let Some(targets) = &self.targets else { return Ok(Vec::new()) };
        match &self.ambient {
            Some(ambient) => ambient.read(&self.gpu),
            None => Ok(vec![1.0; targets.size[0] as usize * targets.size[1] as usize]),
        }
    }

    /// Reads the picture of the last frame: RGBA, sRGB-encoded, row 0 at the top. Empty before the first
    /// frame.
    ///
    /// # Errors
    /// Returns whatever error the device reports.
    pub fn read_picture(&self) -> Result<Vec<u8>> {
        let Some(targets) = &self.targets else { return Ok(Vec::new()) };
        read_texture(&self.gpu, &targets.picture.texture, 0, 0)
    }

    /// Reads the surfaces of the last frame, which must have been drawn from `shot`.
    ///
    /// # Errors
    /// Returns whatever error the device reports.
    pub fn read_surface(&self, shot: &Shot) -> Result<SurfaceImage> {
        let Some(targets) = &self.targets else {
            return Ok(SurfaceImage { view_depth: Vec::new(), normal: Vec::new() });
        };
        let depth_to_z = frame(&shot.camera, &self.bounds(), shot.towards_sun, shot.number).depth_to_z;
        let to_z = |d: f32| if d == 0.0 { f32::INFINITY } else { depth_to_z.view_depth(d) };
        let depth = read_floats(&self.gpu, &targets.depth.texture, 0, 0)?;
        let normals = read_texture(&self.gpu, &targets.normal.texture, 0, 0)?;
        let normal = normals
            .as_chunks::<8>()
            .0
            .iter()
            .map(|b| std::array::from_fn(|a| half_to_f32(u16::from_le_bytes([b[2 * a], b[2 * a + 1]]))));
        Ok(SurfaceImage { view_depth: depth.into_iter().map(to_z).collect(), normal: normal.collect() })
    }

    /// The last frame's targets, for tests that compare a pass with its CPU twin.
    pub fn targets(&self) -> Option<&Targets> {
        self.targets.as_ref()
    }

    /// The uniform buffer of the last frame.
    pub(crate) fn frame_buffer(&self) -> &wgpu::Buffer {
        &self.frame
    }

    /// The target that holds the factors of the last frame.
    pub(crate) fn factor_of<'t>(&self, prepared: &Prepared, targets: &'t Targets) -> &'t Target {
        let filtered = self.answered == Answer::Visibility && prepared.technique.has_screen_passes();
        if filtered { &targets.filtered } else { &targets.factor }
    }

    /// Ambient visibility of the last frame, if there is ambient occlusion.
    pub(crate) fn ambient_view(&self) -> Option<&wgpu::TextureView> {
        self.ambient.as_ref().and_then(AmbientSource::target).map(|t| &t.view)
    }

    /// Bounding box of everything, movers included.
    pub fn bounds(&self) -> Bounds {
        let all = self.scene.buffers.bounds();
        self.movers.as_ref().map_or(all, |m| {
            let b = m.buffers.bounds();
            Bounds {
                min: std::array::from_fn(|a| all.min[a].min(b.min[a])),
                max: std::array::from_fn(|a| all.max[a].max(b.max[a])),
            }
        })
    }

    fn write_frame(&self, shot: &Shot) {
        let frame = frame(&shot.camera, &self.bounds(), shot.towards_sun, shot.number);
        self.gpu.queue.write_buffer(&self.frame, 0, &frame.bytes());
    }

    fn input<'a>(&'a self, shot: &'a Shot, view: &'a adumbra_scene::View) -> FrameInput<'a> {
        FrameInput {
            gpu: &self.gpu,
            camera: &shot.camera,
            view,
            anchor_world: view.eye,
            towards_sun: shot.towards_sun,
            scene: &self.scene.buffers,
            movers: self.movers.as_ref().map(|m| &m.buffers),
            bounds: self.bounds(),
            number: shot.number,
        }
    }
}

const EMPTY_CAMERA: Camera = Camera {
    eye: [0.0; 3],
    target: [0.0, 0.0, -1.0],
    projection: Projection::Perspective { fov_degrees: 45.0 },
    width: 1,
    height: 1,
};

/// Converts an IEEE 754 binary16 to `f32`. Infinities and NaN are not handled, because normals have none.
fn half_to_f32(bits: u16) -> f32 {
    let sign = if bits >> 15 == 0 { 1.0 } else { -1.0 };
    let exponent = i32::from(bits >> 10 & 31);
    let fraction = f32::from(bits & 1023) / 1024.0;
    let magnitude = if exponent == 0 {
        fraction * 2.0_f32.powi(-14)
    } else {
        (1.0 + fraction) * 2.0_f32.powi(exponent - 15)
    };
    sign * magnitude
}

#[cfg(test)]
mod tests {
    use super::half_to_f32;

    #[test]
    fn half_to_f32_converts_known_values() {
        for (bits, value) in [(0x3c00, 1.0), (0xbc00, -1.0), (0x3800, 0.5), (0, 0.0), (0x3555, 0.333_251_95)]
        {
            assert_eq!(half_to_f32(bits), value);
        }
    }
}
