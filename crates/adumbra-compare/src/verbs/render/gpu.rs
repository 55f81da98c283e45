//! Pictures drawn on the GPU.

use std::borrow::Cow;
use std::path::Path;

use crate::Result;
use crate::baked::{BakeOnDemand, BakedFiles};
use crate::layers::{self, Layer};
use crate::truth::{SunShape, TruthTracer};
use adumbra::ShadowFile;
use adumbra::file::LEVEL_STEP;
use adumbra_program::exit::Failure;
use adumbra_render::layers::{CASCADE_COLORS, LEVEL_COLORS};
use adumbra_render::voxel::VOXEL_LEVEL_COLORS;
use adumbra_render::{
    Answer, FrameTimes, Given, Gpu, Prepared, Renderer, SceneOptions, Shot, Stage, TechniqueSpec, build,
};
use adumbra_scene::{Camera, Scene};
use schemars::JsonSchema;
use serde::Serialize;

use super::ambient::AmbientFigures;
use super::args::LayerArg;
use super::legend::{Legend, Row};
use super::movers::numbered;
use super::{Figures, Job, output_of};

pub(super) fn draw(job: &Job<'_>, gpu: Gpu, specs: &[TechniqueSpec]) -> Result<()> {
    let args = job.args;
    for note in gpu.missing_features() {
        adumbra_program::note!("note: {}: {note}", gpu.name());
    }
    let asked = if specs.is_empty() {
        vec![job.offer.techniques.parse(&job.files.technique(&args.lookup))?]
    } else {
        specs.to_vec()
    };
    let options = SceneOptions { ignore_alpha: job.ignore_alpha };
    let mut still = Cow::Borrowed(&job.scene);
    let mut moving = Scene::default();
    if !job.scene.movers.is_empty() {
        moving = still.to_mut().take_movers();
    }
    let mut on_demand = BakedFiles::with((job.offer.more_files)());
    let unserved: Vec<TechniqueSpec> = asked.iter().filter(|spec| !job.files.serves(spec)).cloned().collect();
    let how = BakeOnDemand {
        scene: &still,
        sun: job.sun.sun,
        ignore_alpha: job.ignore_alpha,
        resolution: args.resolutions.resolution,
        max_memory_bytes: args.run.memory_limit().share(job.scene.memory_bytes()).bytes(),
    };
    on_demand.complete(&unserved, &how)?;
    let (given, made) = (job.files.baked(), on_demand.baked());
    let mut renderer = Renderer::new(gpu, &still, options)?;
    drop(still);
    if !moving.movers.is_empty() {
        renderer.set_movers(&moving, options)?;
    }
    let mut traced = None;
    for spec in &asked {
        if let Some(ambient) = &job.ambient {
            ambient.begin(&mut renderer)?;
        }
        let output = output_of(&args.output, spec, asked.len() > 1);
        if spec.is_traced() {
            draw_truth(job, &mut renderer, &mut moving, &output, &mut traced)?;
            continue;
        }
        let mut technique = renderer.prepare(build(
            renderer.gpu(),
            spec,
            if job.files.serves(spec) { given } else { made },
        )?)?;
        for note in technique.technique().notes() {
            adumbra_program::note!("note: {spec}: {note}");
        }
        if !moving.movers.is_empty() && !spec.shows_movers() {
            adumbra_program::note!(
                "note: {spec}: movers receive its shadows but cast none; voxel+csm draws theirs too"
            );
        }
        for (frame, &(seconds, number)) in (0..).zip(&job.moments) {
            moving.pose(seconds);
            renderer.move_movers(&moving);
            let output = numbered(&output, number);
            let (shot, _) = shot(job, &output, frame);
            if let Some(ambient) = &job.ambient {
                ambient.trace(job, &mut renderer, &shot, seconds, &mut traced)?;
            }
            let drawn = draw_one(job, &mut renderer, &mut technique, &output, frame)?;
            drawn.write(job, &renderer, &technique, &output)?;
        }
    }
    Ok(())
}

/// Draws the frames with traced shadows, composited like those of a technique.
fn draw_truth(
    job: &Job<'_>,
    renderer: &mut Renderer,
    moving: &mut Scene,
    output: &Path,
    traced: &mut Option<u32>,
) -> Result<()> {
    for (frame, &(seconds, number)) in (0..).zip(&job.moments) {
        moving.pose(seconds);
        renderer.move_movers(moving);
        let output = numbered(output, number);
        let (shot, _) = shot(job, &output, frame);
        if let Some(ambient) = &job.ambient {
            ambient.trace(job, renderer, &shot, seconds, traced)?;
        }
        let scene = job.scene_at(seconds);
        let truth = TruthTracer::build(&scene, job.ignore_alpha);
        let held = scene.memory_bytes() + truth.tracer().memory_bytes();
        job.args.run.check_memory("the scene and its acceleration structure", held, held)?;
        let factors = truth.factors(&truth.surfaces(&shot.camera), shot.towards_sun, SunShape::Hard);
        let size = [shot.camera.width, shot.camera.height];
        let given = Given::new(renderer.gpu(), "truth", size, &factors)?;
        let mut technique = renderer.prepare(Box::new(given))?;
        let drawn = draw_one(job, renderer, &mut technique, &output, frame)?;
        drawn.write(job, renderer, &technique, &output)?;
    }
    Ok(())
}

/// Returns a frame with all samples as pixels, and the number of samples per pixel along each axis.
fn shot(job: &Job<'_>, output: &Path, number: u32) -> (Shot, u32) {
    let mut camera = job.camera;
    // Raw values are not averaged.
    let samples = if layers::is_exr(output) { 1 } else { job.args.antialias };
    camera.width *= samples;
    camera.height *= samples;
    (Shot { camera, towards_sun: job.sun.sun.towards(), number }, samples)
}

fn draw_one(
    job: &Job<'_>,
    renderer: &mut Renderer,
    technique: &mut Prepared,
    output: &Path,
    number: u32,
) -> Result<Drawn> {
    let (shot, samples) = shot(job, output, number);
    let size = [shot.camera.width, shot.camera.height];
    let layer = job.args.layer;
    let asked = match layer {
        LayerArg::Cascades => Some((Answer::Cascade, "cascades", "no cascades")),
        LayerArg::HrsmLevels => Some((Answer::Level, "hrsm-levels", "no levels; hrsm has them")),
        LayerArg::VoxelSize => {
            Some((Answer::Voxel, "voxel-size", "no voxels; techniques that read a baked file have them"))
        }
        _ => None,
    };
    let file = job.files.light.as_ref();
    if layer == LayerArg::Level && file.is_none() {
        return Err(Failure::Usage("--layer level: give the file with --shadow-file".to_owned()).into());
    }
    let mut indices = Vec::new();
    if let Some((answer, layer, missing)) = asked {
        if technique.technique().sources(answer).is_none() {
            let name = technique.technique().name();
            return Err(Failure::Usage(format!("--layer {layer}: {name} has {missing}")).into());
        }
        renderer.draw(&shot, technique, answer)?;
        indices = renderer.read_factor(technique)?;
    }
    let times = renderer.draw(&shot, technique, Answer::Visibility)?;
    let voxel_world = technique.technique().voxel_world().filter(|_| layer == LayerArg::VoxelSize);
    let legend = voxel_world.map(|voxel_world| Legend::new(&indices, voxel_world));
    let layer = match layer {
        LayerArg::Color => layers::color(size, &renderer.read_picture()?),
        LayerArg::Shadow => layers::grey(size, renderer.read_factor(technique)?),
        LayerArg::Ao => layers::grey(size, renderer.read_ambient()?),
        LayerArg::Depth => layers::depth(size, renderer.read_surface(&shot)?.view_depth),
        LayerArg::Normal => layers::normal(size, &renderer.read_surface(&shot)?),
        LayerArg::Cascades => layers::tinted(size, &renderer.read_picture()?, indices, &CASCADE_COLORS),
        LayerArg::HrsmLevels => layers::tinted(size, &renderer.read_picture()?, indices, &LEVEL_COLORS),
        LayerArg::VoxelSize => layers::tinted(size, &renderer.read_picture()?, indices, &VOXEL_LEVEL_COLORS),
        LayerArg::Level => {
            let depths = renderer.read_surface(&shot)?.view_depth;
            let camera = Camera { height: shot.camera.height / samples, ..shot.camera };
            let levels = file.map(|file| levels_of(file, &camera, &depths)).unwrap_or_default();
            layers::tinted(size, &renderer.read_picture()?, levels, &LEVEL_COLORS)
        }
    };
    Ok(Drawn { layer: layer.smaller(samples), times, legend })
}

/// Returns the level of detail that suffices for each pixel: the coarsest whose texels are not larger than
/// the pixel at its surface. -1 without a surface.
fn levels_of(file: &ShadowFile, camera: &Camera, view_depths: &[f32]) -> Vec<f32> {
    let last = f64::from(file.level_count() - 1);
    let level = |depth: &f32| {
        if !depth.is_finite() {
            return -1.0;
        }
        let pixel_world = camera.projection.height_at(f64::from(*depth)) / f64::from(camera.height);
        let steps = (pixel_world / file.grid.voxel_size).ln() / f64::from(LEVEL_STEP).ln();
        steps.floor().clamp(0.0, last) as f32
    };
    view_depths.iter().map(level).collect()
}

/// A picture, and the figures that are reported with it.
struct Drawn {
    layer: Layer,
    times: FrameTimes,
    legend: Option<Legend>,
}

impl Drawn {
    fn write(&self, job: &Job<'_>, renderer: &Renderer, technique: &Prepared, output: &Path) -> Result<()> {
        layers::write(output, &self.layer)?;
        let device = renderer.gpu().name();
        let figures = figures(job, renderer, technique, self);
        job.report(output, self.layer.size, device, Figures::Gpu(Box::new(figures)));
        if let Some(legend) = self.legend.as_ref().filter(|_| !job.args.run.json) {
            legend.print();
        }
        Ok(())
    }
}

/// Figures of a picture that was drawn on the GPU. Milliseconds are those of the frame, including all samples
/// of `--antialias`.
#[derive(Serialize, JsonSchema)]
pub(super) struct GpuFigures {
    /// On the GPU: the technique, as it was given.
    technique: String,
    /// On the GPU: bytes on the GPU for the technique's shadows.
    bytes: u64,
    /// On the GPU: whether the times are wall times, because the device has no timestamps or is software.
    wall_time: bool,
    /// On the GPU: milliseconds of the G-buffer.
    gbuffer_ms: f64,
    /// On the GPU: milliseconds of the technique's depth passes.
    depth_ms: f64,
    /// On the GPU: milliseconds of what `hrsm` builds from depth. Close to 0 for other techniques.
    build_ms: f64,
    /// On the GPU: milliseconds of the look-up.
    lookup_ms: f64,
    /// On the GPU: milliseconds of the screen-space passes.
    screen_ms: f64,
    /// On the GPU: figures of the picture's ambient occlusion. Null without `--ao`.
    ambient: Option<AmbientFigures>,
    /// With `--layer voxel-size`: each level of the file that answers pixels, the finest first.
    #[serde(skip_serializing_if = "Option::is_none")]
    voxel_levels: Option<Vec<Row>>,
}

fn figures(job: &Job<'_>, renderer: &Renderer, technique: &Prepared, drawn: &Drawn) -> GpuFigures {
    let times = &drawn.times;
    GpuFigures {
        technique: technique.technique().name(),
        bytes: technique.technique().bytes(),
        wall_time: times.wall_time,
        gbuffer_ms: times.of(Stage::GBuffer),
        depth_ms: times.of(Stage::Depth),
        build_ms: times.of(Stage::Build),
        lookup_ms: times.of(Stage::Lookup),
        screen_ms: times.of(Stage::Screen),
        ambient: job.ambient.as_ref().map(|a| a.figures(renderer, times)),
        voxel_levels: drawn.legend.as_ref().map(Legend::rows),
    }
}
