//! `adumbra-lab bench lookup`: counts the reads of look-ups in baked files, and of percentage-closer
//! filtering in cascades. The shaders of the files do the counting; a test of the renderer compares their
//! answers with the CPU's.
//!
//! A GPU runs 32 pixels at once, here 8 × 4, and fetches memory in sectors of 32 bytes. Sectors that several
//! of these pixels read are fetched once. So words per pixel bound the work of the arithmetic units, sectors
//! per group bound the work of the memory, and the longest chain of dependent reads bounds the time that a
//! group waits. The tables also have the milliseconds on the adapter in use.

mod cascades;
mod pixels;
mod voxels;

use std::fmt::Write as _;

use adumbra::{Filter, Frame};
use adumbra_bake::{BakeOptions, FrameChoice, Size};
use adumbra_program::exit::Code;
use adumbra_program::output::{make_folder, note_input};
use adumbra_program::scene::load_scene;
use adumbra_render::{
    Answer, FrameTimes, Gpu, Prepared, RenderError, Renderer, SceneOptions, Shot, Stage, TechniqueFiles,
    build,
};
use adumbra_scene::{Camera, LoadOptions};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use self::pixels::{Group, groups};
use super::peers::scene_file;
use crate::TECHNIQUES;
use crate::args::BenchLookup;
use crate::light_file::{Kind, LightFile};
use adumbra_compare::compare::{interleaved, median_time};
use adumbra_compare::truth::{StreetOptions, TruthTracer, street_camera, truth_camera};
use adumbra_compare::{Error, Result};

/// Words of a sector.
const SECTOR_WORDS: u32 = 8;
/// Widths of the cascades' filter.
const CASCADE_FILTERS: [u32; 3] = [3, 5, 7];
/// Height of a person's eyes in metres.
const EYE_HEIGHT: f64 = 1.7;

/// All results.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct LookUpResults {
    /// Texels along the longest side of the files.
    resolution: u64,
    /// Width and height of the pictures in pixels.
    size: [u32; 2],
    /// One group of 8 × 4 pixels of this many was counted.
    every: u32,
    /// Adapter that drew the frames whose milliseconds are given.
    adapter: String,
    /// Frames per technique and view, of whose milliseconds the median counts.
    frames: u32,
    /// Baked files: one row per scene, view, frame, layout and filter.
    rows: Vec<Row>,
    /// `csm:filter=K`: one row per scene, view and filter.
    cascades: Vec<CascadeRow>,
}

/// What the look-ups of one view read.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
struct Row {
    /// Name of the scene.
    scene: String,
    /// Name of the view.
    view: String,
    /// Frame of the file: `light` or `oblique`.
    frame: String,
    /// How the file stores its shadows: `packed`, a graph, or `depths`, the quadtree.
    layout: String,
    /// Texels along each side of the filter.
    filter: u32,
    /// What was counted, and the milliseconds of a look-up pass.
    #[serde(flatten)]
    figures: Figures,
}

/// What look-ups in cascades read in one view.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
struct CascadeRow {
    /// Name of the scene.
    scene: String,
    /// Name of the view.
    view: String,
    /// Width of the filter.
    filter: u32,
    /// What was counted, with texels for words, and the milliseconds of a look-up pass.
    #[serde(flatten)]
    figures: Figures,
}

/// The reads of one view.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
struct Figures {
    /// Number of pixels that were counted: those that face the sun.
    pixels: usize,
    /// Mean number of words read per pixel.
    words_per_pixel: f64,
    /// Mean number of different sectors of 32 bytes that a group of 8 × 4 pixels reads.
    sectors_per_group: f64,
    /// Mean over the groups of the largest number of reads of a pixel of which each needs the one before for
    /// its address.
    chain_per_group: f64,
    /// Milliseconds of the look-up pass over the picture.
    milliseconds: f64,
}

/// Sums over the groups of a view.
#[derive(Clone, Copy, Default)]
struct Counts {
    pixels: usize,
    reads: usize,
    sectors: usize,
    chains: usize,
}

impl Counts {
    fn figures(self, groups: usize, times: &[FrameTimes]) -> Figures {
        let groups = groups.max(1) as f64;
        Figures {
            pixels: self.pixels,
            words_per_pixel: self.reads as f64 / self.pixels.max(1) as f64,
            sectors_per_group: self.sectors as f64 / groups,
            chain_per_group: self.chains as f64 / groups,
            milliseconds: median_time(times, |times| times.of(Stage::Lookup)),
        }
    }
}

pub(super) fn run(args: &BenchLookup) -> Result<Code> {
    make_folder(&args.common.output)?;
    let gpu = Gpu::request(&args.common.device.gpu_options())?;
    let mut document = LookUpResults {
        resolution: args.common.resolutions.resolution,
        size: args.size,
        every: args.every,
        adapter: gpu.name(),
        frames: args.frames,
        rows: Vec::new(),
        cascades: Vec::new(),
    };
    for name in &args.names {
        measure(args, &gpu, name, &mut document)?;
        super::write(&args.common.output, "lookup", &markdown(&document), &document)?;
    }
    super::say_tables(&args.common.output, "lookup");
    Ok(Code::Fine)
}

/// A view of a scene.
struct SceneView {
    name: &'static str,
    shot: Shot,
    groups: Vec<Group>,
}

fn measure(args: &BenchLookup, gpu: &Gpu, name: &str, document: &mut LookUpResults) -> Result<()> {
    let truth = args.common.truth.join(format!("{name}.npz"));
    note_input("the truth file itself", &truth);
    let (camera, sun) = truth_camera(&truth)?;
    let scene = load_scene(&scene_file(&args.common.scenes, name)?, &LoadOptions::default())?;
    let tracer = TruthTracer::build(&scene, false);
    let [width, height] = args.size;
    let options = StreetOptions { eye_height_world: EYE_HEIGHT, fov_degrees: 60.0, width, height };
    let street = street_camera(&tracer, sun.towards(), &options)?;
    let views =
        [("truth camera", Camera { width, height, ..camera }), ("street", street)].map(|(name, camera)| {
            SceneView {
                name,
                shot: Shot { camera, towards_sun: sun.towards(), number: 0 },
                groups: groups(&tracer.surfaces(&camera), sun, args.every),
            }
        });
    let mut renderer = Renderer::new(gpu.clone(), &scene, SceneOptions::default())?;
    for filter in CASCADE_FILTERS {
        let mut technique = prepare(&renderer, &format!("csm:filter={filter}"), TechniqueFiles::default())?;
        for SceneView { name: view, shot, groups } in &views {
            let times = time(&mut renderer, shot, &mut technique, args.frames)?;
            let Some(map) = technique.technique().map() else { continue };
            let figures = cascades::count(map, shot.camera.eye, groups).figures(groups.len(), &times);
            say(name, view, &format!("csm:filter={filter}"), &figures);
            let [scene, view] = [name, *view].map(str::to_owned);
            document.cascades.push(CascadeRow { scene, view, filter, figures });
        }
    }
    for frame in [FrameChoice::Light, FrameChoice::Oblique] {
        for kind in Kind::ALL {
            let size = Size::Resolution(args.common.resolutions.resolution);
            let options = BakeOptions::new(sun, size).with(|o| o.frame = frame);
            let file = LightFile::bake(&scene, &options, kind)?;
            for &filter in &args.filter {
                let mut technique = prepare(&renderer, &file.technique(filter), file.baked())?;
                for SceneView { name: view, shot, groups } in &views {
                    let times = time(&mut renderer, shot, &mut technique, args.frames)?;
                    let counts = match voxels::count(gpu, &file, groups, Filter::try_from(filter)?) {
                        Err(Error::Render(error)) if matches!(*error, RenderError::VoxelLimit { .. }) => {
                            adumbra_program::note!(
                                "{name}, {view}, {}, {filter}: left out: {error}",
                                kind.name()
                            );
                            continue;
                        }
                        counts => counts?,
                    };
                    let figures = counts.figures(groups.len(), &times);
                    let (frame, layout) = (file.grid().frame.name(), kind.name());
                    say(name, view, &format!("{frame} {layout}, {filter}"), &figures);
                    let [scene, view, frame, layout] = [name, *view, frame, layout].map(str::to_owned);
                    document.rows.push(Row { scene, view, frame, layout, filter, figures });
                }
            }
        }
    }
    Ok(())
}

fn say(scene: &str, view: &str, what: &str, figures: &Figures) {
    let Figures { words_per_pixel, sectors_per_group, chain_per_group, milliseconds, .. } = figures;
    adumbra_program::note!(
        "{scene}, {view}, {what}: {words_per_pixel:.1} words, {sectors_per_group:.1} sectors, \
         chains of {chain_per_group:.1}, {milliseconds:.2} ms"
    );
}

fn prepare(renderer: &Renderer, technique: &str, baked: TechniqueFiles<'_>) -> Result<Prepared> {
    let spec = TECHNIQUES.parse(technique)?;
    Ok(renderer.prepare(build(renderer.gpu(), &spec, baked)?)?)
}

/// Draws one untimed frame, then `frames` timed frames.
fn time(
    renderer: &mut Renderer,
    shot: &Shot,
    technique: &mut Prepared,
    frames: u32,
) -> Result<Vec<FrameTimes>> {
    renderer.draw(shot, technique, Answer::Visibility)?;
    Ok(interleaved(renderer, shot, &mut [technique], frames)?.remove(0))
}

fn markdown(document: &LookUpResults) -> String {
    let LookUpResults { resolution, size: [width, height], every, adapter, frames, .. } = document;
    let of_frames =
        if *frames == 1 { "of one frame".to_owned() } else { format!("medians of {frames} frames") };
    let mut text = format!(
        "# What look-ups read\n\nFiles of {resolution} texels, pictures of {width} × {height} pixels, one group of \
         8 × 4 pixels of {every} counted. Per cell: words of 32 bits per pixel that faces the sun; different sectors of \
         32 bytes per group; the longest chain of reads of a group's pixels of which each needs the one before for its \
         address; milliseconds of the look-up pass, {of_frames} on {adapter}. The shaders of \
         `voxel:filter=K` count their own reads. For `csm:filter=K` the words are texels, of which a gather fetches \
         four and a sector holds 4 × 2. A cell is empty if some look-up reads more words than its log has room for.\n"
    );
    let mut filters: Vec<u32> = document.rows.iter().map(|row| row.filter).collect();
    filters.extend(document.cascades.iter().map(|row| row.filter));
    filters.sort_unstable();
    filters.dedup();
    let mut views: Vec<(&str, &str)> = Vec::new();
    for row in &document.rows {
        if !views.contains(&(&row.scene, &row.view)) {
            views.push((&row.scene, &row.view));
        }
    }
    let cell = |figures: Option<&Figures>| {
        figures.map_or_else(String::new, |f| {
            let Figures { words_per_pixel, sectors_per_group, chain_per_group, milliseconds, .. } = f;
            format!("{words_per_pixel:.1}; {sectors_per_group:.1}; {chain_per_group:.0}; {milliseconds:.2}")
        })
    };
    for (scene, view) in views {
        // Writing to a `String` never fails.
        let _ = write!(text, "\n## {scene}, {view}\n\n| |");
        filters.iter().for_each(|k| text.push_str(&format!(" {k} × {k} |")));
        let _ = write!(text, "\n|---|{}\n| csm |", "---|".repeat(filters.len()));
        for &filter in &filters {
            let of_filter = |r: &&CascadeRow| r.scene == scene && r.view == view && r.filter == filter;
            let _ = write!(text, " {} |", cell(document.cascades.iter().find(of_filter).map(|r| &r.figures)));
        }
        text.push('\n');
        for frame in [Frame::Light.name(), "oblique"] {
            for layout in Kind::ALL.map(Kind::name) {
                let _ = write!(text, "| {frame}, {layout} |");
                for &filter in &filters {
                    let of_file = |r: &&Row| {
                        (r.scene == scene && r.view == view)
                            && (r.frame == frame && r.layout == layout && r.filter == filter)
                    };
                    let _ =
                        write!(text, " {} |", cell(document.rows.iter().find(of_file).map(|r| &r.figures)));
                }
                text.push('\n');
            }
        }
    }
    text
}
