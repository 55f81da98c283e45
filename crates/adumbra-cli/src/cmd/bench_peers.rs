//! `adumbra bench peers`: every technique's two figures on the truth cameras, beside what today's engines get.

use std::path::{Path, PathBuf};

use adumbra::scene::LoadOptions;
use adumbra_lab::peers::{self, PeerRow, RowSource, SCENES};
use adumbra_lab::truth::TruthView;
use adumbra_render::{Answer, Gpu, Renderer, SceneOptions, Shot, TECHNIQUES, TechniqueSpec, build};
use serde_json::json;

use super::baked::{BakeOnTheWay, BakedFiles};
use super::compare::parse;
use super::load_scene;
use crate::args::BenchPeers;
use crate::exit::{Code, Failure, Outcome};
use crate::output::{make_folder, note_input, write_whole};

/// Techniques beside every name with its defaults.
const VARIANTS: [&str; 5] =
    ["voxel:filter=1", "voxel:filter=3", "voxel:filter=5", "voxel-cubes:filter=1", "csm:size=4096"];

pub(super) fn run(args: &BenchPeers) -> Outcome {
    let specs = match args.shadow.as_slice() {
        [] => every_technique()?,
        names => parse(names)?,
    };
    make_folder(&args.output)?;
    let mut rows: Vec<PeerRow> = specs
        .iter()
        .map(|s| PeerRow { name: s.to_string(), source: RowSource::Here, scenes: [None; 4] })
        .collect();
    let mut adapter = String::new();
    for (column, scene) in SCENES.into_iter().enumerate() {
        adapter = measure(args, scene, &specs, &mut rows, column)?;
    }
    rows.extend(peers::engines());
    rows.push(peers::aim());
    let text = format!(
        "# Sun shadows on the truth cameras, beside today's engines\n\n320 x 240, no anti-aliasing, masks ignored, pixels with n·l > 0.1 against \
        another renderer's truth. First figure: share of pixels on the wrong side of 0.5; in brackets: mean |shadow factor - truth|; both in \
        %. Drawn by {adapter}; voxel files of {} (light-aligned) and {} (world-aligned) voxels. Rows marked elsewhere were measured with those \
        engines on the same cameras.\n\n{}",
        args.resolution,
        args.cube_resolution,
        peers::markdown(&rows)
    );
    let document = json!({
        "adapter": adapter, "resolution": args.resolution, "cube_resolution": args.cube_resolution,
        "scenes": SCENES, "rows": rows,
    });
    write_whole(&args.output.join("peers.md"), text.as_bytes())?;
    write_whole(&args.output.join("peers.json"), format!("{document:#}\n").as_bytes())?;
    say!("{}", args.output.join("peers.md").display());
    Ok(Code::Fine)
}

/// Every name with its defaults, and what of the variants exists.
fn every_technique() -> Result<Vec<TechniqueSpec>, Failure> {
    let names = || TECHNIQUES.iter().map(|(name, _)| *name).filter(|n| !matches!(*n, "none" | "truth"));
    let exists = |variant: &&str| names().any(|n| Some(n) == variant.split(':').next());
    let all: Vec<String> = names().chain(VARIANTS.into_iter().filter(exists)).map(str::to_owned).collect();
    parse(&all)
}

/// Fills one scene's column; gives the adapter's name.
fn measure(
    args: &BenchPeers,
    name: &str,
    specs: &[TechniqueSpec],
    rows: &mut [PeerRow],
    column: usize,
) -> Result<String, Failure> {
    let truth = args.truth.join(format!("{name}.npz"));
    note_input("the truth file itself", &truth);
    let view = TruthView::read(&truth)?;
    let options = LoadOptions { ignore_alpha: true, ..LoadOptions::default() };
    let scene = load_scene(&scene_file(&args.scenes, name)?, &options)?;
    let gpu = Gpu::request(&args.device.gpu_options())?;
    let mut renderer = Renderer::new(gpu, &scene, SceneOptions { ignore_alpha: true })?;
    let mut files = BakedFiles::default();
    files.complete(
        specs,
        &BakeOnTheWay {
            scene: &scene,
            sun: view.sun,
            ignore_alpha: true,
            resolution: args.resolution,
            cube_resolution: args.cube_resolution,
            max_memory_bytes: None,
        },
    )?;
    let shot = Shot { camera: view.camera, towards_sun: view.sun.towards(), number: 0 };
    for (spec, row) in specs.iter().zip(rows) {
        let mut technique = renderer.prepare(build(renderer.gpu(), spec, files.baked())?)?;
        renderer.draw(&shot, &mut technique, Answer::Visibility)?;
        let figures = peers::figures(&renderer.read_factor(&technique)?, &view)?;
        if let Some(figures) = &figures {
            eprintln!("{name} {spec}: {:.2} ({:.1})", figures.wrong_percent, figures.mean_percent);
        }
        row.scenes[column] = figures;
    }
    Ok(renderer.gpu().name())
}

/// The scene of that name, whatever its ending.
pub(super) fn scene_file(folder: &Path, name: &str) -> Result<PathBuf, Failure> {
    let candidates = ["glb", "gltf", "obj", "ply"].map(|e| folder.join(format!("{name}.{e}")));
    let missing = || Failure::BadInput(format!("{}: holds no scene {name}", folder.display()));
    candidates.into_iter().find(|p| p.exists()).ok_or_else(missing)
}
