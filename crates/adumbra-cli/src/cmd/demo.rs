//! `adumbra demo`: the main job from end to end on a generated city.

use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Instant;

use adumbra::Error;
use adumbra::bake::{self, Options, Size};
use adumbra::camera::Camera;
use adumbra::format::{Layout, ShadowFile};
use adumbra::light::Sun;
use adumbra::picture::{self, Shadows};
use adumbra::query::Query;
use adumbra::scene::{GeneratedKind, LoadOptions, generate, write_glb};
use adumbra::trace::{TraceOptions, Tracer};
use adumbra::verify::{LightAnswers, Sampler, Solids, SurfaceSampler, Verification, Verifier, VerifyOptions};
use adumbra_lab::page::{Body, Embedded, Encoding, Page, Pair, Table};

use super::{GraphFigures, load_scene};
use crate::args::Demo;
use crate::exit::{Code, Failure, Outcome};
use crate::output::{bytes_words, make_folder, refuse_same, write_png, write_whole};
use crate::progress::{Reporter, Style, Units};
use crate::signals;

const SEED: u64 = 1;
/// Cameras, and what each of them shows: parts of the pictures' names.
const VIEWS: [&str; 2] = ["city", "street"];
const LAYERS: [&str; 3] = ["", "-truth", "-difference"];
const SAMPLES: u64 = 200_000;
/// Of the page's pictures, pixels.
const WIDEST: u32 = 1280;

pub(crate) fn run(args: &Demo) -> Outcome {
    let cancel = signals::install();
    make_folder(&args.out)?;
    let scene_path = args.out.join("city.glb");
    let file_path = args.out.join("city.adumbra");
    let report = args.out.join("report.html");
    let pictures = VIEWS.map(|view| LAYERS.map(|layer| args.out.join(format!("{view}{layer}.png"))));
    let outputs = [&scene_path, &file_path, &report].into_iter().chain(pictures.as_flattened());
    refuse_same(outputs.map(|path| &**path))?;
    write_glb(&generate(GeneratedKind::City, SEED), &scene_path)?;
    let scene = load_scene(&scene_path, &LoadOptions { color_textures: true, ..LoadOptions::default() })?;
    say!("scene     {} ({} triangles)", scene_path.display(), scene.instanced_triangles());

    let start = Instant::now();
    let sun = Sun::from_direction([0.5, 0.8, 0.35])?;
    let options = Options::new(sun, Size::Resolution(args.resolution));
    let reporter = Reporter::new(Style::Auto, Units::TEXELS);
    let baked = bake::bake(&scene, &options, &|p| reporter.update(p), &cancel)?;
    let file =
        ShadowFile::of_dag(baked.grid, baked.settings, baked.dag, Layout::default()).map_err(Error::from)?;
    let file_bytes = file.write(&file_path)?;
    let bake_seconds = start.elapsed().as_secs_f64();
    let figures = GraphFigures::of(&file, file_bytes)?;
    say!("file      {} ({}, {bake_seconds:.1} s)", file_path.display(), bytes_words(figures.file_bytes));

    let go_on = || if cancel.load(Ordering::Relaxed) { Err(Error::Interrupted) } else { Ok(()) };
    go_on()?;
    let tracer = Tracer::build(&scene, TraceOptions { ignore_alpha: false });
    let solids = Solids::of(&scene);
    let sampler = Sampler::Surface(SurfaceSampler::new(&scene, &solids, sun.towards(), false));
    let exact = Query::new(&file.grid, file.slabs(), file.settings.bias, 1)?;
    let answers = LightAnswers::new(&file.grid, &file.settings, exact);
    let check = VerifyOptions { samples: SAMPLES, seed: 1 };
    let verification = Verifier::new(&answers, &tracer, &solids).run(&sampler, &check);
    say!("verified  interior agreement {:.4} %", 100.0 * verification.interior_agreement);

    let whole = Camera::overview(&scene.bounds(), 40.0);
    let street = Camera { eye: [-150.0, 38.0, 175.0], target: [-75.0, 4.0, 75.0], ..whole };
    for (camera, paths) in [whole, street].into_iter().zip(&pictures) {
        for (suffix, path) in LAYERS.into_iter().zip(paths) {
            go_on()?;
            let query = Query::new(&file.grid, file.slabs(), file.settings.bias, 5)?;
            let shadows = match suffix {
                "" => Shadows::File(&query),
                "-truth" => Shadows::Truth,
                _ => Shadows::Difference(&exact),
            };
            let picture = picture::draw(&scene, &tracer, &camera, sun.towards(), &shadows, 2);
            write_png(path, &picture)?;
            say!("picture   {}", path.display());
        }
    }
    write_report(&report, args.resolution, &file, &figures, bake_seconds, &verification)?;
    say!("report    {}", report.display());
    Ok(if verification.holds() { Code::Fine } else { Code::CheckFailed })
}

fn write_report(
    path: &Path,
    resolution: u64,
    file: &ShadowFile,
    figures: &GraphFigures,
    bake_seconds: f64,
    v: &Verification,
) -> Result<(), Failure> {
    let rows = [
        ("triangles", file.settings.triangles.to_string()),
        ("grid", format!("{resolution}: {:?} voxels of {:.3} m", file.grid.size, file.grid.voxel_size)),
        ("bake", format!("{bake_seconds:.1} s on {} threads", rayon::current_num_threads())),
        ("file", format!("{}, {:.3} bits a texel", bytes_words(figures.file_bytes), figures.bits_per_texel)),
        ("nodes, slabs", format!("{}, {}", figures.composition.nodes, figures.composition.slabs)),
        ("points compared with rays", v.samples.to_string()),
        ("interior agreement", format!("{:.4} %", 100.0 * v.interior_agreement)),
        ("agreement, edges too", format!("{:.3} %", 100.0 * v.agreement)),
        ("acne, leak", format!("{:.3} %, {:.3} %", 100.0 * v.acne, 100.0 * v.leak)),
    ];
    let mut table = Table::new("", &["", ""]);
    for (name, value) in rows {
        table.row([name.to_owned(), value]);
    }
    let mut opening = Body::default();
    opening.table(&table);
    for (name, what) in [("street", "A street of the city"), ("city", "The whole city")] {
        let picture = |suffix: &str| -> Result<Embedded, Failure> {
            let path = path.with_file_name(format!("{name}{suffix}.png"));
            let bytes = std::fs::read(&path).map_err(Error::io("read", &path))?;
            Ok(Embedded::of_png(&bytes, None, WIDEST, Encoding::Lossless)?)
        };
        let (file, truth, difference) = (picture("")?, picture("-truth")?, picture("-difference")?);
        let names = ("the file, 5 × 5 texels", "rays");
        opening.pair(&Pair { left: (&file, names.0), right: (&truth, names.1), caption: what });
        let caption = format!(
            "{what}: where one texel of the file differs from rays; red: lit called shadowed, blue: shadowed called lit"
        );
        opening.picture(&difference, &caption, &caption);
    }
    let title = "A generated city, its shadows in one file".to_owned();
    let page = Page { description: title.clone(), title, opening, sections: Vec::new() };
    write_whole(path, page.html().as_bytes())
}
