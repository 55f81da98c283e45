//! Frames: G-buffer, a technique's passes, its look-up, composite; and what can be read back of them.

use adumbra::camera::{Camera, Projection};
use adumbra::scene::{Bounds, Scene};
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

/// A scene on a device, with everything that frames of it need but the technique.
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
    /// What the last frame was asked for.
    answered: Answer,
    /// What of the last frame still holds.
    drawn: Option<Drawn>,
}

/// A frame whose G-buffer is of the scene as it is.
struct Drawn {
    shot: Shot,
    /// Its ambient occlusion is there too.
    ambient: bool,
    /// Of these two.
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

/// Where a frame is seen from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shot {
    /// The camera.
    pub camera: Camera,
    /// Unit vector towards the sun.
    pub towards_sun: [f64; 3],
    /// Number of the frame.
    pub number: u32,
}

/// A surface point to answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// World position.
    pub p_world: [f64; 3],
    /// Unit normal, or zero.
    pub normal: [f64; 3],
}

/// What the last frame's G-buffer holds for each pixel, row 0 at the top.
pub struct SurfaceImage {
    /// Distance along the camera's forward direction, world units; infinite where nothing is.
    pub view_depth: Vec<f32>,
    /// World normal towards the viewer.
    pub normal: Vec<[f32; 3]>,
}

impl Renderer {
    /// Uploads a scene.
    ///
    /// # Errors
    /// What the device cannot hold.
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

    /// What stands still.
    pub fn scene(&self) -> &SceneBuffers {
        &self.scene.buffers
    }

    /// Uploads what moves; it casts and receives like the rest, but no baked file holds it.
    ///
    /// # Errors
    /// What the device cannot hold.
    pub fn set_movers(&mut self, movers: &Scene, options: SceneOptions) -> Result<()> {
        let buffers = SceneBuffers::new(&self.gpu, movers, options)?;
        let seen = InstanceList::new(&self.gpu, "movers::seen", &buffers);
        self.movers = Some(Part { buffers, seen });
        self.drawn = None;
        Ok(())
    }

    /// Takes away what moves.
    pub fn remove_movers(&mut self) {
        self.movers = None;
        self.drawn = None;
    }

    /// Places the movers anew; `movers` is the scene given to [`Renderer::set_movers`] with other transforms.
    pub fn move_movers(&mut self, movers: &Scene) {
        if let Some(part) = &mut self.movers {
            part.buffers.move_instances(movers);
            self.drawn = None;
        }
    }

    /// Ambient occlusion for the frames to come; none for open sky everywhere.
    pub fn set_ambient(&mut self, ambient: Option<AmbientSource>) {
        self.ambient = ambient;
        self.drawn = None;
    }

    /// The ambient occlusion of frames.
    pub fn ambient(&self) -> Option<&AmbientSource> {
        self.ambient.as_ref()
    }

    /// The same, to have it forget the frames before.
    pub fn ambient_mut(&mut self) -> Option<&mut AmbientSource> {
        self.drawn = None;
        self.ambient.as_mut()
    }

    /// Ambient occlusion alone, on the G-buffer of the frame drawn last, which was `shot`'s.
    ///
    /// # Errors
    /// What the device reports.
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
    /// What the device reports.
    pub fn prepare(&self, technique: Box<dyn Technique>) -> Result<Prepared> {
        let lookup = self.resolver.lookup(&self.gpu, &*technique);
        self.gpu.check()?;
        Ok(Prepared { technique, lookup })
    }

    /// Draws a frame. Its layers stay readable until the next. Screen passes and ambient occlusion are for visibilities: cascades are
    /// left as they are, and the frames before stay what they were.
    ///
    /// # Errors
    /// [`RenderError::Camera`]; [`RenderError::Technique`] for an answer that the technique does not have; [`RenderError::Ambient`] for
    /// ambient visibility given for another size; what the technique or the device reports.
    pub fn draw(&mut self, shot: &Shot, prepared: &mut Prepared, answer: Answer) -> Result<FrameTimes> {
        self.drawn = None;
        self.draw_again(shot, prepared, answer)
    }

    /// The same, but where `shot` is the frame drawn last, with its number, and nothing moved since: then its G-buffer stands, and its
    /// ambient occlusion, once reckoned, for another technique or another answer. The times are what these took then.
    ///
    /// # Errors
    /// As [`Renderer::draw`].
    pub fn draw_again(&mut self, shot: &Shot, prepared: &mut Prepared, answer: Answer) -> Result<FrameTimes> {
        check_camera(&shot.camera)?;
        if !prepared.lookup.answers(answer) {
            let reason = format!("it has no answer of the kind {answer:?}");
            return Err(RenderError::Technique { name: prepared.technique.name(), reason });
        }
        let size = [shot.camera.width, shot.camera.height];
        if let Some(ambient) = &self.ambient {
            ambient.check(size)?;
        }
        // Not there while it is drawn on: what fails leaves nothing that seems to hold.
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

    /// A technique's answers for a list of points, as it would give them in a frame of `shot`: cascades are those of its
    /// camera.
    ///
    /// # Errors
    /// [`RenderError::Camera`]; [`RenderError::Technique`] for one that answers pictures alone, such as a blur on the screen; what the
    /// technique or the device reports.
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
                // As a frame would have it: noise of the screen stands still there, not on the surface.
                let [x, y] = view.pixel(p.p_world).unwrap_or_default();
                let [x, y] = [(x, shot.camera.width), (y, shot.camera.height)]
                    .map(|(c, size)| (c.max(0.0) as u32).min(size.saturating_sub(1)));
                PointQuery {
                    p_relative: [r[0] as f32, r[1] as f32, r[2] as f32, view.depth(p.p_world) as f32],
                    normal: [n[0], n[1], n[2], 0.0],
                    pixel: [x, y, 0, 0],
                }
            })
            .collect();
        self.resolver.answer(&self.gpu, &self.frame, &**technique, lookup, &queries)
    }

    /// What the last frame was asked for: visibilities, after a technique's screen passes, 1 where nothing is; or cascades or
    /// levels. Row 0 at the top.
    ///
    /// # Errors
    /// What the device reports.
    pub fn read_factor(&self, prepared: &Prepared) -> Result<Vec<f32>> {
        let Some(targets) = &self.targets else { return Ok(Vec::new()) };
        read_floats(&self.gpu, &self.factor_of(prepared, targets).texture, 0, 0)
    }

    /// Ambient visibility of the last frame that was asked for visibilities, 1 = unoccluded and where nothing is; everywhere where there is
    /// no ambient occlusion. Row 0 at the top.
    ///
    /// # Errors
    /// What the device reports.
    pub fn read_ambient(&self) -> Result<Vec<f32>> {
        let Some(targets) = &self.targets else { return Ok(Vec::new()) };
        match &self.ambient {
            Some(ambient) => ambient.read(&self.gpu),
            None => Ok(vec![1.0; targets.size[0] as usize * targets.size[1] as usize]),
        }
    }

    /// The picture of the last frame: RGBA, sRGB, row 0 at the top.
    ///
    /// # Errors
    /// What the device reports.
    pub fn read_picture(&self) -> Result<Vec<u8>> {
        let Some(targets) = &self.targets else { return Ok(Vec::new()) };
        read_texture(&self.gpu, &targets.picture.texture, 0, 0)
    }

    /// The surfaces of the last frame.
    ///
    /// # Errors
    /// What the device reports.
    pub fn read_surface(&self, shot: &Shot) -> Result<SurfaceImage> {
        let Some(targets) = &self.targets else {
            return Ok(SurfaceImage { view_depth: Vec::new(), normal: Vec::new() });
        };
        let k = frame(&shot.camera, &self.bounds(), shot.towards_sun, shot.number).depth_to_z;
        let to_z = |d: f32| if d == 0.0 { f32::INFINITY } else { (k[0] + k[1] * d) / (k[2] + k[3] * d) };
        let depth = read_floats(&self.gpu, &targets.depth.texture, 0, 0)?;
        let normals = read_texture(&self.gpu, &targets.normal.texture, 0, 0)?;
        let normal = normals
            .as_chunks::<8>()
            .0
            .iter()
            .map(|b| std::array::from_fn(|a| half_to_f32(u16::from_le_bytes([b[2 * a], b[2 * a + 1]]))));
        Ok(SurfaceImage { view_depth: depth.into_iter().map(to_z).collect(), normal: normal.collect() })
    }

    /// The last frame's targets, for tests that hold a pass against its twin.
    pub fn targets(&self) -> Option<&Targets> {
        self.targets.as_ref()
    }

    /// The uniform of the frame drawn last.
    pub(crate) fn frame_buffer(&self) -> &wgpu::Buffer {
        &self.frame
    }

    /// Where the factors of the frame drawn last are.
    pub(crate) fn factor_of<'t>(&self, prepared: &Prepared, targets: &'t Targets) -> &'t Target {
        let filtered = self.answered == Answer::Visibility && prepared.technique.has_screen_passes();
        if filtered { &targets.filtered } else { &targets.factor }
    }

    /// Ambient visibility of the frame drawn last, where there is ambient occlusion.
    pub(crate) fn ambient_view(&self) -> Option<&wgpu::TextureView> {
        self.ambient.as_ref().and_then(AmbientSource::target).map(|t| &t.view)
    }

    /// Box of everything, movers included.
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

    fn input<'a>(&'a self, shot: &'a Shot, view: &'a adumbra::camera::View) -> FrameInput<'a> {
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

/// IEEE 754 binary16; normals need neither infinities nor NaN.
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
    fn half_floats_have_their_values() {
        for (bits, value) in [(0x3c00, 1.0), (0xbc00, -1.0), (0x3800, 0.5), (0, 0.0), (0x3555, 0.333_251_95)]
        {
            assert_eq!(half_to_f32(bits), value);
        }
    }
}
