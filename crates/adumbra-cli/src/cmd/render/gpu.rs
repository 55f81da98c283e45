//! Pictures on the GPU.

use std::borrow::Cow;

use adumbra::format::AnyFile;
use adumbra::scene::Scene;
use adumbra_render::{
    Answer, Baked, FrameTimes, Gpu, Prepared, RenderError, Renderer, SceneOptions, Shot, Stage,
    TechniqueSpec, build,
};
use serde_json::{Value, json};

use super::layers::{self, Layer};
use super::movers::numbered;
use super::{Job, cpu, output_of};
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
    for spec in &asked {
        let output = output_of(&args.output, spec, asked.len() > 1);
        if spec.name() == "truth" {
            cpu::draw(job, true, &output)?;
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
            let (layer, times) = draw_one(job, &mut renderer, &mut technique, &output, frame)?;
            layers::write(&output, &layer)?;
            job.report(&output, layer.size, figures(&renderer, &technique, &times));
        }
    }
    Ok(())
}

/// What a shadow file is looked up with where no technique is named.
fn file_technique(job: &Job<'_>) -> Result<TechniqueSpec, RenderError> {
    let filter = job.args.filter;
    match &job.file {
        Some(AnyFile::Tree(_)) => {
            format!("voxel-cubes:filter={filter}:weights={}", job.args.weights.name()).parse()
        }
        _ => format!("voxel:filter={filter}").parse(),
    }
}

fn baked(file: Option<&AnyFile>) -> Baked<'_> {
    match file {
        Some(AnyFile::Light(file)) => Baked { light: Some(file), ..Baked::default() },
        Some(AnyFile::Tree(file)) => Baked { tree: Some(file), ..Baked::default() },
        None => Baked::default(),
    }
}

fn draw_one(
    job: &Job<'_>,
    renderer: &mut Renderer,
    technique: &mut Prepared,
    output: &std::path::Path,
    number: u32,
) -> Result<(Layer, FrameTimes), Failure> {
    let mut camera = job.camera;
    // Raw values are not blended.
    let samples = if layers::is_exr(output) { 1 } else { job.args.antialias };
    camera.width *= samples;
    camera.height *= samples;
    let shot = Shot { camera, towards_sun: job.sun.towards(), number };
    let size = [camera.width, camera.height];
    let layer = job.args.layer;
    let cascades = if layer == LayerArg::Cascades {
        if technique.technique().sources(Answer::Cascade).is_none() {
            let name = technique.technique().name();
            return Err(Failure::Usage(format!("--layer cascades: {name} has no cascades")));
        }
        renderer.draw(&shot, technique, Answer::Cascade)?;
        Some(renderer.read_factor(technique)?)
    } else {
        None
    };
    let times = renderer.draw(&shot, technique, Answer::Visibility)?;
    let layer = match layer {
        LayerArg::Color => layers::color(size, &renderer.read_picture()?),
        LayerArg::Shadow => layers::shadow(size, renderer.read_factor(technique)?),
        LayerArg::Depth => layers::depth(size, renderer.read_surface(&shot)?.view_depth),
        LayerArg::Normal => layers::normal(size, &renderer.read_surface(&shot)?),
        LayerArg::Cascades => {
            layers::cascades(size, &renderer.read_picture()?, &cascades.unwrap_or_default())
        }
    };
    Ok((layer.smaller(samples), times))
}

fn figures(renderer: &Renderer, technique: &Prepared, times: &FrameTimes) -> Value {
    json!({
        "device": renderer.gpu().name(),
        "technique": technique.technique().name(),
        "bytes": technique.technique().bytes(),
        "wall_time": times.wall_time,
        "gbuffer_ms": times.of(Stage::GBuffer),
        "depth_ms": times.of(Stage::Depth),
        "lookup_ms": times.of(Stage::Lookup),
        "screen_ms": times.of(Stage::Screen),
    })
}
