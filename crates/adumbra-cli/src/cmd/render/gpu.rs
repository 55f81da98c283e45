//! Pictures on the GPU.

use std::borrow::Cow;
use std::path::Path;

use adumbra::format::AnyFile;
use adumbra::scene::Scene;
use adumbra_lab::truth::{SunShape, TruthTracer};
use adumbra_render::layers::{CASCADE_COLORS, LEVEL_COLORS};
use adumbra_render::voxel::VOXEL_LEVEL_COLORS;
use adumbra_render::{
    Answer, Baked, FrameTimes, Given, Gpu, Prepared, RenderError, Renderer, SceneOptions, Shot, Stage,
    TechniqueSpec, build,
};
use serde_json::{Value, json};

use super::layers::{self, Layer};
use super::legend::Legend;
use super::movers::numbered;
use super::{Job, output_of};
use crate::args::LayerArg;
use crate::exit::Failure;

pub(super) fn draw(job: &Job<'_>, gpu: Gpu, specs: &[TechniqueSpec]) -> Result<(), Failure> {
    let args = job.args;
    for note in gpu.left_out() {
        eprintln!("note: {}: {note}", gpu.name());
    }
    let asked = if specs.is_empty() { vec![file_technique(job)?] } else { specs.to_vec() };
    let options = SceneOptions { ignore_alpha: job.ignore_alpha };
    let mut still = Cow::Borrowed(&job.scene);
    let mut moving = Scene::default();
    if !job.scene.movers.is_empty() {
        moving = still.to_mut().take_movers();
    }
    let mut renderer = Renderer::new(gpu, &still, options)?;
    drop(still);
    if !moving.movers.is_empty() {
        renderer.set_movers(&moving, options)?;
    }
    let baked = baked(job.file.as_ref());
    let mut traced = None;
    for spec in &asked {
        if let Some(ambient) = &job.ambient {
            ambient.begin(&mut renderer)?;
        }
        let output = output_of(&args.output, spec, asked.len() > 1);
        if spec.name() == "truth" {
            spec.reader().finish()?;
            draw_truth(job, &mut renderer, &mut moving, &output, &mut traced)?;
            continue;
        }
        let mut technique = renderer.prepare(build(renderer.gpu(), spec, baked)?)?;
        for note in technique.technique().notes() {
            eprintln!("note: {spec}: {note}");
        }
        if !moving.movers.is_empty() && spec.name().starts_with("voxel") && !spec.name().contains('+') {
            eprintln!("note: {spec}: movers take its shadows but cast none; voxel+csm draws theirs too");
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

/// Frames of traced shadows, composited as a technique's are.
fn draw_truth(
    job: &Job<'_>,
    renderer: &mut Renderer,
    moving: &mut Scene,
    output: &Path,
    traced: &mut Option<u32>,
) -> Result<(), Failure> {
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
        job.args.work.check_memory("the scene and its rays' trees", held)?;
        let factors = truth.factors(&truth.surfaces(&shot.camera), shot.towards_sun, SunShape::Hard);
        let size = [shot.camera.width, shot.camera.height];
        let given = Given::new(renderer.gpu(), "truth", size, &factors)?;
        let mut technique = renderer.prepare(Box::new(given))?;
        let drawn = draw_one(job, renderer, &mut technique, &output, frame)?;
        drawn.write(job, renderer, &technique, &output)?;
    }
    Ok(())
}

/// What a shadow file is looked up with where no technique is named.
fn file_technique(job: &Job<'_>) -> Result<TechniqueSpec, RenderError> {
    let (filter, bias) = (job.args.filter, job.args.bias.parameters());
    match &job.file {
        Some(AnyFile::Tree(_)) => {
            format!("voxel-cubes:filter={filter}:weights={}{bias}", job.args.weights.name()).parse()
        }
        _ => format!("voxel:filter={filter}{bias}").parse(),
    }
}

fn baked(file: Option<&AnyFile>) -> Baked<'_> {
    match file {
        Some(AnyFile::Light(file)) => Baked { light: Some(file), ..Baked::default() },
        Some(AnyFile::Tree(file)) => Baked { tree: Some(file), ..Baked::default() },
        None => Baked::default(),
    }
}

/// A frame with all its samples as pixels, and how many of them a pixel has along each side.
fn shot(job: &Job<'_>, output: &Path, number: u32) -> (Shot, u32) {
    let mut camera = job.camera;
    // Raw values are not blended.
    let samples = if layers::is_exr(output) { 1 } else { job.args.antialias };
    camera.width *= samples;
    camera.height *= samples;
    (Shot { camera, towards_sun: job.sun.towards(), number }, samples)
}

fn draw_one(
    job: &Job<'_>,
    renderer: &mut Renderer,
    technique: &mut Prepared,
    output: &Path,
    number: u32,
) -> Result<Drawn, Failure> {
    let (shot, samples) = shot(job, output, number);
    let size = [shot.camera.width, shot.camera.height];
    let layer = job.args.layer;
    let asked = match layer {
        LayerArg::Cascades => Some((Answer::Cascade, "cascades", "no cascades")),
        LayerArg::HrsmLevels => Some((Answer::Level, "hrsm-levels", "no levels; hrsm has them")),
        LayerArg::VoxelSize => Some((Answer::Voxel, "voxel-size", "no voxels; baked files have them")),
        _ => None,
    };
    let mut indices = Vec::new();
    if let Some((answer, layer, missing)) = asked {
        if technique.technique().sources(answer).is_none() {
            let name = technique.technique().name();
            return Err(Failure::Usage(format!("--layer {layer}: {name} has {missing}")));
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
    };
    Ok(Drawn { layer: layer.smaller(samples), times, legend })
}

/// A picture, and what is said of it.
struct Drawn {
    layer: Layer,
    times: FrameTimes,
    legend: Option<Legend>,
}

impl Drawn {
    fn write(
        &self,
        job: &Job<'_>,
        renderer: &Renderer,
        technique: &Prepared,
        output: &Path,
    ) -> Result<(), Failure> {
        layers::write(output, &self.layer)?;
        let mut more = figures(job, renderer, technique, &self.times);
        if let Some(legend) = &self.legend {
            more["voxel_levels"] = legend.json();
        }
        job.report(output, self.layer.size, more);
        if let Some(legend) = self.legend.as_ref().filter(|_| !job.args.json) {
            legend.print();
        }
        Ok(())
    }
}

fn figures(job: &Job<'_>, renderer: &Renderer, technique: &Prepared, times: &FrameTimes) -> Value {
    json!({
        "device": renderer.gpu().name(),
        "technique": technique.technique().name(),
        "bytes": technique.technique().bytes(),
        "wall_time": times.wall_time,
        "gbuffer_ms": times.of(Stage::GBuffer),
        "depth_ms": times.of(Stage::Depth),
        "build_ms": times.of(Stage::Build),
        "lookup_ms": times.of(Stage::Lookup),
        "screen_ms": times.of(Stage::Screen),
        "ambient": job.ambient.as_ref().map(|a| a.figures(renderer, times)),
    })
}
