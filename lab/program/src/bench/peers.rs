//! `adumbra-lab bench peers`: every technique's two errors on the truth cameras, next to those of current
//! engines.

use std::path::{Path, PathBuf};

use adumbra_program::exit::{Code, Failure};
use adumbra_program::output::{make_folder, note_input};
use adumbra_program::scene::load_scene;
use adumbra_render::{Answer, Gpu, Renderer, SceneOptions, Shot, TechniqueSpec, build};

use crate::TECHNIQUES;
use adumbra_scene::LoadOptions;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::args::BenchPeers;
use crate::peers::{self, PeerRow, RowSource, SCENES};
use adumbra_compare::Result;
use adumbra_compare::baked::BakeOnDemand;
use adumbra_compare::contenders::parse;
use adumbra_compare::truth::TruthView;

/// All results.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct PeerResults {
    /// Adapter that drew, with its driver.
    adapter: String,
    /// Texels along the longest side of the light-aligned files.
    resolution: u64,
    /// Voxels along each side of the world-aligned files.
    cube_resolution: u64,
    /// Scene of each column of the rows.
    scenes: Vec<String>,
    /// One row per measurement.
    rows: Vec<PeerRow>,
}

/// Variants measured in addition to every technique with its defaults.
const VARIANTS: [&str; 5] =
    ["voxel:filter=1", "voxel:filter=3", "voxel:filter=9", "voxel-cubes:filter=1", "csm:size=4096"];

pub(super) fn run(args: &BenchPeers) -> Result<Code> {
    let specs = match args.shadow.as_slice() {
        [] => every_technique()?,
        names => parse(TECHNIQUES, names)?,
    };
    make_folder(&args.common.output)?;
    let mut rows: Vec<PeerRow> = specs
        .iter()
        .map(|s| PeerRow { name: s.to_string(), source: RowSource::Here, scenes: [None; 4] })
        .collect();
    let mut adapter = String::new();
    for (column, scene) in SCENES.into_iter().enumerate() {
        adapter = measure(args, scene, &specs, &mut rows, column)?;
    }
    rows.extend(peers::engines());
    let text = format!(
        "# Sun shadows on the truth cameras, compared with current engines\n\n320 x 240, no anti-aliasing, alpha \
        masks ignored. Pixels with n·l > 0.1 are compared with another renderer's truth. First figure: share of \
        pixels on the wrong side of 0.5; in brackets: mean |shadow factor - truth|; both in %. Drawn by \
        {adapter}; voxel files of {} (light-aligned) and {} (world-aligned) voxels per side. Rows marked \
        *elsewhere* were measured with those engines on the same cameras.\n\n{}",
        args.common.resolutions.resolution,
        args.common.cube.cube_resolution,
        peers::markdown(&rows)
    );
    let document = PeerResults {
        adapter,
        resolution: args.common.resolutions.resolution,
        cube_resolution: args.common.cube.cube_resolution,
        scenes: SCENES.map(str::to_owned).into(),
        rows,
    };
    super::write(&args.common.output, "peers", &text, &document)?;
    super::say_tables(&args.common.output, "peers");
    Ok(Code::Fine)
}

/// Returns every technique with its defaults, and those of [`VARIANTS`] whose technique exists.
fn every_technique() -> Result<Vec<TechniqueSpec>> {
    let names = || TECHNIQUES.iter().filter(|t| !t.is_reference()).map(|t| t.name);
    let exists = |variant: &&str| names().any(|n| Some(n) == variant.split(':').next());
    let all: Vec<String> = names().chain(VARIANTS.into_iter().filter(exists)).map(str::to_owned).collect();
    parse(TECHNIQUES, &all)
}

/// Fills one scene's column. Returns the adapter's name.
fn measure(
    args: &BenchPeers,
    name: &str,
    specs: &[TechniqueSpec],
    rows: &mut [PeerRow],
    column: usize,
) -> Result<String> {
    let truth = args.common.truth.join(format!("{name}.npz"));
    note_input("the truth file itself", &truth);
    let view = TruthView::read(&truth)?;
    let options = LoadOptions { ignore_alpha: true, ..LoadOptions::default() };
    let scene = load_scene(&scene_file(&args.common.scenes, name)?, &options)?;
    let gpu = Gpu::request(&args.common.device.gpu_options())?;
    let mut renderer = Renderer::new(gpu, &scene, SceneOptions { ignore_alpha: true })?;
    let mut files = args.common.cube.files();
    files.complete(
        specs,
        &BakeOnDemand {
            scene: &scene,
            sun: view.sun,
            ignore_alpha: true,
            resolution: args.common.resolutions.resolution,
            max_memory_bytes: None,
        },
    )?;
    let shot = Shot { camera: view.camera, towards_sun: view.sun.towards(), number: 0 };
    for (spec, row) in specs.iter().zip(rows) {
        let mut technique = renderer.prepare(build(renderer.gpu(), spec, files.baked())?)?;
        renderer.draw(&shot, &mut technique, Answer::Visibility)?;
        let figures = peers::figures(&renderer.read_factor(&technique)?, &view)?;
        if let Some(figures) = &figures {
            adumbra_program::note!(
                "{name} {spec}: {:.2} ({:.1})",
                figures.wrong_percent,
                figures.mean_percent
            );
        }
        row.scenes[column] = figures;
    }
    Ok(renderer.gpu().name())
}

/// Returns the path of the scene `name`, with any supported file extension.
pub(super) fn scene_file(folder: &Path, name: &str) -> Result<PathBuf> {
    let candidates = ["glb", "gltf", "obj", "ply"].map(|e| folder.join(format!("{name}.{e}")));
    let missing =
        || Failure::BadInput(format!("{}: has no {name}.glb, .gltf, .obj or .ply", folder.display()));
    Ok(candidates.into_iter().find(|p| p.exists()).ok_or_else(missing)?)
}
