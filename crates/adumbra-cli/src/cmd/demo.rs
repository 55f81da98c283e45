//! `adumbra demo`: the whole workflow on a generated city.

use std::path::{Path, PathBuf};
use std::time::Instant;

use adumbra::{Encoding, Filter, IoError, ShadowFile, Sun};
use adumbra_bake::Bake;
use adumbra_files::replace_file;
use adumbra_html::page::{Body, Embedded, Page, Pair, PictureEncoding, Table};
use adumbra_program::exit::{Code, Failure, Outcome};
use adumbra_program::memory::Guard;
use adumbra_program::output::{format_bytes, make_folder, print_json, refuse_same, write_png, write_whole};
use adumbra_program::progress::{Reporter, Style, Units};
use adumbra_program::say;
use adumbra_program::scene::load_scene_within;
use adumbra_program::sun::DEFAULT_SUN;
use adumbra_program::threads::with_threads;
use adumbra_scene::{Camera, GeneratedKind, LoadOptions, Scene, generate, write_glb};
use adumbra_truth::picture;
use adumbra_truth::picture::{BaseColors, Shadows};
use adumbra_truth::trace::{TraceOptions, Tracer};
use adumbra_truth::verify::{
    LightAnswers, Sampler, Solids, SurfaceSampler, Verification, Verifier, VerifyOptions,
};
use schemars::JsonSchema;
use serde::Serialize;

use super::bits_per_texel;
use crate::args::Demo;

const SEED: u64 = 1;
/// Names of the cameras, which begin the pictures' names.
const VIEWS: [&str; 2] = ["city", "street"];
const LAYERS: [&str; 3] = ["", "-truth", "-difference"];
const SAMPLES: u64 = 200_000;
/// Largest width of the page's pictures, pixels.
const WIDEST: u32 = 1280;

/// The results of the demo.
#[derive(Serialize, JsonSchema)]
pub(super) struct Shown {
    /// The generated scene.
    scene: String,
    /// The shadow file.
    file: String,
    /// The pictures.
    pictures: Vec<String>,
    /// The page that shows them.
    report: String,
    /// Voxels on the longest side of the scene.
    resolution: u64,
    /// Triangles of the instances. A mesh counts as often as it is placed.
    triangles: u64,
    /// Wall time of baking and writing the file.
    bake_seconds: f64,
    /// Length of the shadow file, in bytes.
    file_bytes: u64,
    /// Bits of the shadow file per texel of its grid.
    bits_per_texel: f64,
    /// Number of points that were compared with rays.
    samples: u64,
    /// Share of the points where file and rays agree.
    agreement: f64,
    /// Share of the interior points where file and rays agree. An interior point is not near an edge of a
    /// shadow.
    interior_agreement: f64,
}

pub(crate) fn run(args: &Demo) -> Outcome {
    with_threads(args.run.threads, || demo(args))?
}

fn demo(args: &Demo) -> Outcome {
    // With --json, everything is printed once, at the end.
    let tell = |line: &str| {
        if !args.run.json {
            say!("{line}");
        }
    };
    let outputs = Outputs::new(&args.out)?;
    let scene = make_scene(args, &outputs.scene)?;
    tell(&format!("scene     {} ({} triangles)", outputs.scene.display(), scene.instanced_triangles()));

    let baked = bake(args, &scene, &outputs.file)?;
    let bytes = format_bytes(baked.bytes);
    tell(&format!("file      {} ({bytes}, {:.1} s)", outputs.file.display(), baked.seconds));

    let tracer = Tracer::build(&scene, TraceOptions { ignore_alpha: false });
    let held = scene.memory_bytes() + tracer.memory_bytes() + BaseColors::bytes_of(&scene);
    args.run.check_memory("the scene, its acceleration structure and its mip levels", held, held)?;
    let verification = verify(&scene, &tracer, &baked.file);
    tell(&format!("verified  interior agreement {:.4} %", 100.0 * verification.interior_agreement));

    draw(&scene, &tracer, &baked.file, &outputs.pictures, &tell)?;
    write_report(&outputs.report, args.resolution, &baked, &verification)?;
    if args.run.json {
        print_json(&Shown {
            scene: outputs.scene.display().to_string(),
            file: outputs.file.display().to_string(),
            pictures: outputs.pictures.as_flattened().iter().map(|p| p.display().to_string()).collect(),
            report: outputs.report.display().to_string(),
            resolution: args.resolution,
            triangles: scene.instanced_triangles(),
            bake_seconds: baked.seconds,
            file_bytes: baked.bytes,
            bits_per_texel: bits_per_texel(&baked.file.grid, baked.bytes),
            samples: verification.samples,
            agreement: verification.agreement,
            interior_agreement: verification.interior_agreement,
        })?;
    }
    tell(&format!("report    {}", outputs.report.display()));
    Ok(if verification.holds() { Code::Fine } else { Code::CheckFailed })
}

type Pictures = [[PathBuf; LAYERS.len()]; VIEWS.len()];

/// The files that the demo writes.
struct Outputs {
    scene: PathBuf,
    file: PathBuf,
    report: PathBuf,
    /// By view and layer.
    pictures: Pictures,
}

impl Outputs {
    /// Makes the folder, and refuses names that lead to the same file.
    fn new(folder: &Path) -> Result<Self, Failure> {
        make_folder(folder)?;
        let outputs = Self {
            scene: folder.join("city.glb"),
            file: folder.join("city.adumbra"),
            report: folder.join("report.html"),
            pictures: VIEWS.map(|view| LAYERS.map(|layer| folder.join(format!("{view}{layer}.png")))),
        };
        let all = [&outputs.scene, &outputs.file, &outputs.report];
        refuse_same(all.into_iter().chain(outputs.pictures.as_flattened()).map(|path| &**path))?;
        Ok(outputs)
    }
}

/// Generates the city, and loads it from its file as any other scene.
fn make_scene(args: &Demo, path: &Path) -> Result<Scene, Failure> {
    write_glb(&generate(GeneratedKind::City, SEED), path)?;
    let load = LoadOptions { color_textures: true, ..LoadOptions::default() };
    load_scene_within(args.run.memory_limit(), path, &load)
}

/// A file that was baked and written.
struct BakedFile {
    file: ShadowFile,
    bytes: u64,
    /// Wall time of baking and writing.
    seconds: f64,
}

fn bake(args: &Demo, scene: &Scene, path: &Path) -> Result<BakedFile, Failure> {
    let start = Instant::now();
    let limit = args.run.memory_limit();
    let share = limit.share(scene.memory_bytes());
    let reporter = Reporter::new(if args.run.json { Style::None } else { Style::Auto }, Units::TEXELS);
    let guard = Guard::new(limit);
    let bake = Bake::new(scene, Sun::from_direction(DEFAULT_SUN)?)
        .resolution(args.resolution)
        .with(|options| options.max_memory_bytes = share.bytes())
        .on_progress(|progress| {
            guard.look();
            reporter.update(progress);
        })
        .cancel(guard.cancel());
    let file = guard.end("the bake", &share, bake.in_memory())?;
    let bytes = replace_file(path, |out| file.write_to(out, Encoding::default()))?;
    Ok(BakedFile { file, bytes, seconds: start.elapsed().as_secs_f64() })
}

/// Compares the file with rays at points of the scene's surfaces.
fn verify(scene: &Scene, tracer: &Tracer<'_>, file: &ShadowFile) -> Verification {
    let solids = Solids::of(scene);
    let sampler = Sampler::Surface(SurfaceSampler::new(scene, &solids, file.grid.sun.towards(), false));
    let answers = LightAnswers::of(file, file.sampler(Filter::Nearest));
    let options = VerifyOptions { samples: SAMPLES, seed: 1 };
    Verifier::new(&answers, tracer, &solids).run(&sampler, &options)
}

/// Draws the whole city and a street: with the file, with rays, and where both differ.
fn draw(
    scene: &Scene,
    tracer: &Tracer<'_>,
    file: &ShadowFile,
    pictures: &Pictures,
    tell: &impl Fn(&str),
) -> Result<(), Failure> {
    let (exact, filtered) = (file.sampler(Filter::Nearest), file.sampler(Filter::Box5));
    let whole = Camera::overview(&scene.bounds(), 40.0);
    let street = Camera { eye: [-150.0, 38.0, 175.0], target: [-75.0, 4.0, 75.0], ..whole };
    for (camera, paths) in [whole, street].into_iter().zip(pictures) {
        for (suffix, path) in LAYERS.into_iter().zip(paths) {
            let shadows = match suffix {
                "" => Shadows::File(&filtered),
                "-truth" => Shadows::Truth,
                _ => Shadows::Difference(&exact),
            };
            let picture = picture::draw(scene, tracer, &camera, file.grid.sun.towards(), &shadows, 2);
            write_png(path, &picture)?;
            tell(&format!("picture   {}", path.display()));
        }
    }
    Ok(())
}

fn write_report(
    path: &Path,
    resolution: u64,
    BakedFile { file, bytes, seconds }: &BakedFile,
    v: &Verification,
) -> Result<(), Failure> {
    let rows = [
        ("triangles", file.settings.triangles.to_string()),
        (
            "grid",
            format!("{resolution}: {:?} voxels of {:.3} world units", file.grid.size, file.grid.voxel_size),
        ),
        ("bake", format!("{seconds:.1} s on {} threads", rayon::current_num_threads())),
        (
            "file",
            format!("{}, {:.3} bits per texel", format_bytes(*bytes), bits_per_texel(&file.grid, *bytes)),
        ),
        ("points compared with rays", v.samples.to_string()),
        ("interior agreement", format!("{:.4} %", 100.0 * v.interior_agreement)),
        ("agreement, including edges", format!("{:.3} %", 100.0 * v.agreement)),
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
            let bytes = std::fs::read(&path).map_err(IoError::at("read", &path))?;
            Embedded::from_png(&bytes, None, WIDEST, PictureEncoding::Lossless)
        };
        let (file, truth, difference) = (picture("")?, picture("-truth")?, picture("-difference")?);
        let names = ("the file, 5 × 5 texels", "rays");
        opening.pair(&Pair { left: (&file, names.0), right: (&truth, names.1), caption: what });
        let caption = format!(
            "{what}: where the unfiltered file differs from rays; red: lit called shadowed, blue: shadowed called lit"
        );
        opening.picture(&difference, &caption, &caption);
    }
    let title = "A generated city with its shadows in one file".to_owned();
    let page = Page { description: title.clone(), title, opening, sections: Vec::new() };
    write_whole(path, page.html().as_bytes())
}
