//! Every default that the help of `adumbra` states is the value that its verbs use.

use adumbra::stream::StreamOptions;
use adumbra::{Bias, Bounds, Sun};
use adumbra_bake::{FrameChoice, Size};
use adumbra_compare::args::{CacheArgs, DeviceArgs, ResolutionArgs};
use adumbra_compare::truth::Cache;
use adumbra_compare::verbs::compare::PATH_FRAMES;
use adumbra_compare::verbs::render::CameraArgs;
use adumbra_program::args::SunArgs;
use adumbra_program::lookup::LookupArgs;
use adumbra_program::output::format_bytes;
use adumbra_program::sun::{DEFAULT_SUN, SunSource};
use adumbra_scene::{Camera, FileSun, Scene, UpAxis};
use adumbra_testing::help::{assert_defaults, assert_listed, verbs};
use adumbra_truth::verify::Promises;
use clap::CommandFactory;

use super::*;

type Used = Vec<(&'static str, String)>;

fn size([width, height]: [u32; 2]) -> String {
    format!("{width}x{height}")
}

fn name(value: &impl ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

/// Checks that an option is absent, and returns `words`: the description of its default, or nothing if it has
/// none.
fn absent<T>(value: Option<&T>, words: &str) -> String {
    assert!(value.is_none());
    words.to_owned()
}

fn empty<T>(values: &[T], words: &str) -> String {
    assert!(values.is_empty());
    words.to_owned()
}

fn load(args: &SceneArgs) -> Used {
    let none = empty(&args.words(), "");
    let up = "the shadow file's, or y";
    let options = args.load_options().unwrap();
    assert!(options.up.is_none() && Scene::default().up == UpAxis::Y);
    vec![("--only", none.clone()), ("--exclude", none.clone()), ("--edit", none), ("--up", up.to_owned())]
}

fn run(args: &RunArgs) -> Used {
    let memory = "no limit, but for loading a scene 2 GiB plus 64 bytes for each byte of its files";
    vec![
        ("--threads", absent(args.threads.as_ref(), "all cores")),
        ("--max-memory", absent(args.max_memory.as_ref(), memory)),
    ]
}

fn sun(args: &SunArgs) -> Used {
    let path = std::path::Path::new("a.glb");
    let towards = [0.0, 1.0, 0.0];
    let lit = Scene { suns: vec![FileSun { name: "a".to_owned(), towards }], ..Scene::default() };
    let first = args.choose(&lit, path).unwrap();
    assert_eq!((first.sun.towards(), first.origin.source), (towards, SunSource::Light));
    let default = args.choose(&Scene::default(), path).unwrap();
    assert_eq!(default.sun, Sun::from_direction(DEFAULT_SUN).unwrap());
    let [x, y, z] = DEFAULT_SUN;
    let none = absent(args.given().unwrap().as_ref(), "");
    vec![
        ("--sun", format!("the scene's first directional light that shines, or {x},{y},{z}")),
        ("--azimuth", none.clone()),
        ("--elevation", none),
    ]
}

fn camera(args: &CameraArgs) -> Used {
    let bounds = Bounds { min: [0.0; 3], max: [1.0; 3] };
    let whole = Camera::overview(&bounds, args.fov);
    let found = args.camera(&bounds, None).unwrap();
    assert_eq!((found.eye, found.target), (whole.eye, whole.target));
    assert_eq!(whole.target, [0.5; 3]);
    vec![
        ("--eye", absent(args.eye.as_ref(), "obliquely above the scene")),
        ("--target", absent(args.target.as_ref(), "the scene's centre")),
        ("--fov", args.fov.to_string()),
        ("--ortho", absent(args.ortho.as_ref(), "")),
        ("--size", size(args.size)),
    ]
}

fn device(args: &DeviceArgs) -> Used {
    let adapter =
        absent(args.gpu_options().adapter.as_ref(), "the first real GPU, or else a software adapter");
    vec![("--device", name(&args.device)), ("--adapter", adapter), ("--without", empty(&args.words(), ""))]
}

fn cache(args: &CacheArgs) -> Used {
    let out = std::path::Path::new("OUT");
    let expected = Cache::in_folder(out.join("truth-cache"), Cache::DEFAULT_LIMIT_BYTES);
    assert_eq!(format!("{:?}", args.cache(out)), format!("{expected:?}"));
    let limit = format_bytes(Cache::DEFAULT_LIMIT_BYTES).replace(".0 ", "");
    vec![("--cache", "truth-cache in the output folder".to_owned()), ("--cache-limit", limit)]
}

fn resolutions(args: &ResolutionArgs) -> Used {
    vec![("--resolution", args.resolution.to_string())]
}

fn lookup(args: &LookupArgs) -> Used {
    let file = Bias { constant_texels: 0.25, slope_texels: 0.5, normal_offset_texels: 0.75 };
    assert_eq!(args.bias.over(file).unwrap(), file);
    vec![
        ("--filter", args.filter.to_string()),
        ("--bias-constant", "the file's".to_owned()),
        ("--bias-slope", "the file's".to_owned()),
        ("--bias-normal", "the file's".to_owned()),
    ]
}

fn settings(args: &bake::BakeSettings) -> Used {
    let up = Sun::from_direction([0.0, 1.0, 0.0]).unwrap();
    let options = args.options(up, false);
    let of = |more: &[&str]| {
        let words = ["adumbra", "bake", "a.glb"].iter().chain(more);
        let Verb::Bake(args) = Args::try_parse_from(words).unwrap().verb else { panic!("it is bake") };
        args.settings.options(up, false)
    };
    assert_eq!(options.frame, FrameChoice::Auto);
    assert_eq!(of(&["--frame", "oblique"]).frame, FrameChoice::Oblique);
    let presets = [("draft", 2048), ("low", 4096), ("medium", 8192), ("high", 16_384), ("ultra", 32_768)];
    for (preset, texels) in presets {
        assert_eq!(of(&["--preset", preset]).size, Size::Resolution(texels), "{preset}");
    }
    assert_eq!(options.size, Size::Resolution(8192));
    assert_eq!(options.thickness_world, 0.0);
    let lower = |text: String| text.to_lowercase();
    let own = vec![
        ("--resolution", String::new()),
        ("--voxel-size", String::new()),
        ("--preset", "medium".to_owned()),
        ("--thickness", "the bias at the surface's slope".to_owned()),
        ("--switch-within", options.switch_within_voxels.to_string()),
        ("--encoding", lower(format!("{:?}", options.encoding))),
        ("--levels", options.levels.to_string()),
        ("--assume-ground", lower(format!("{:?}", options.assume_ground))),
        ("--receivers", lower(format!("{:?}", options.receivers))),
        ("--bounds", absent(options.bounds.as_ref(), "")),
        ("--frame", name(&args.frame)),
        ("--yaw", "along most edges".to_owned()),
    ];
    [own, sun(&args.sun)].concat()
}

fn bake(args: &Bake) -> Used {
    let words = ["adumbra", "bake", "a.glb", "--regions"];
    let Verb::Bake(cut) = Args::try_parse_from(words).unwrap().verb else { panic!("it is bake") };
    assert_eq!((args.regions, cut.regions), (None, Some(adumbra_bake::RegionPlan::DEFAULT_TEXELS)));
    let own = vec![
        (
            "--output",
            absent(
                args.output.as_ref(),
                "the scene's path with the extension .adumbra; with --regions: .regions.json",
            ),
        ),
        ("--link-in", absent(args.link_in.as_ref(), "")),
        ("--cache", absent(args.cache.as_ref(), "")),
        ("--focus", absent(args.focus.as_ref(), "")),
        ("--regions", absent(args.regions.as_ref(), "")),
        ("--shard", absent(args.shard.as_ref(), "")),
        ("--sun-path", absent(args.path.sun_path.as_ref(), "")),
        ("--suns", absent(args.path.suns.as_ref(), "")),
        ("--path-error", args.path.path_error.to_string()),
        ("--lowest-sun", args.path.lowest_sun.to_string()),
        ("--progress", name(&args.progress)),
    ];
    [own, settings(&args.settings), load(&args.load), run(&args.run)].concat()
}

fn plan(args: &Plan) -> Used {
    let own = vec![
        ("--output", absent(args.output.as_ref(), "the scene's path with the extension .plan.json")),
        ("--export", absent(args.export.as_ref(), "")),
        ("--shards", args.shards.to_string()),
        ("--cache", absent(args.cache.as_ref(), "the plan's path with the extension .cache")),
        ("--shadow-file", absent(args.shadow_file.as_ref(), "the scene's path with the extension .adumbra")),
    ];
    [own, settings(&args.settings), load(&args.load), run(&args.run)].concat()
}

fn tile(args: &Tile) -> Used {
    let own = vec![
        ("--shard", absent(args.shard.as_ref(), "")),
        ("--ids", absent(args.ids.as_ref(), "")),
        ("--cache", absent(args.cache.as_ref(), "the plan's path with the extension .cache")),
        ("--scene", absent(args.scene.as_ref(), "")),
        ("--progress", name(&args.progress)),
    ];
    [own, run(&args.run)].concat()
}

fn render(args: &Render) -> Used {
    let own = vec![
        ("--shadow", empty(&args.shadow, "the shadow file's, or rays with --truth")),
        (
            "--shadow-file",
            absent(args.shadow_file.as_ref(), "if a technique of --shadow needs one, it is baked"),
        ),
        ("--sun-time", absent(args.sun_time.as_ref(), "")),
        ("--ao", args.ao.clone()),
        ("--layer", name(&args.layer)),
        ("--move", empty(&args.movers, "")),
        ("--time", args.time.to_string()),
        ("--frames", absent(args.frames.as_ref(), "")),
        ("--antialias", args.antialias.to_string()),
    ];
    let groups = [
        resolutions(&args.resolutions),
        device(&args.device),
        sun(&args.sun),
        camera(&args.camera),
        lookup(&args.lookup),
        load(&args.load),
        run(&args.run),
    ];
    [own, groups.concat()].concat()
}

fn compare(args: &Compare) -> Used {
    let own = vec![
        ("--camera", absent(args.camera.as_ref(), "--eye and --target, or overview")),
        ("--eye-height", args.eye_height.to_string()),
        ("--frames", args.frames.to_string()),
        ("--sun-degrees", args.sun_degrees.to_string()),
        ("--sun-samples", args.sun_samples.to_string()),
        ("--reference", name(&args.reference)),
        ("--shadow-file", empty(&args.shadow_file, "baked as needed")),
        ("--path", absent(args.path.as_ref(), "")),
        ("--sun-sweep", absent(args.sun_sweep.as_ref(), "")),
        ("--sweep-steps", args.sweep_steps.to_string()),
        ("--path-frames", absent(args.path_frames.as_ref(), &format!("the file's, or {PATH_FRAMES}"))),
    ];
    let groups = [
        camera(&args.view),
        sun(&args.sun),
        resolutions(&args.resolutions),
        cache(&args.cache),
        device(&args.device),
        load(&args.load),
        run(&args.run),
    ];
    [own, groups.concat()].concat()
}

fn view(args: &View) -> Used {
    let memory = "no limit for bakes; for loading 2 GiB plus 64 bytes for each byte of the scene's files";
    let own = vec![
        ("--shadow-file", absent(args.shadow_file.as_ref(), "baked in the background, coarse to fine")),
        ("--shadow", empty(&args.shadow, "voxel, and csm")),
        ("--ao", args.ao.clone()),
        ("--layer", name(&args.layer)),
        ("--split", absent(args.split.as_ref(), "")),
        ("--difference", absent(args.difference.as_ref(), "")),
        ("--camera", absent(args.camera.as_ref(), "")),
        ("--antialias", args.antialias.to_string()),
        ("--move", absent(args.mover.as_ref(), "")),
        ("--time", args.time.to_string()),
        ("--resolution", args.resolution.to_string()),
        ("--budget", (StreamOptions::default().budget_bytes >> 20).to_string()),
        ("--day", absent(args.day.as_ref(), "")),
        ("--day-length", args.day_length.to_string()),
        ("--day-near", absent(args.day_near.as_ref(), "")),
        ("--hour", absent(args.hour.as_ref(), "at its first sun")),
        ("--fade", args.fade.to_string()),
        ("--max-memory", absent(args.max_memory.as_ref(), memory)),
        ("--script", absent(args.script.as_ref(), "")),
    ];
    [own, sun(&args.sun), camera(&args.view), device(&args.device), load(&args.load)].concat()
}

fn verify(args: &Verify) -> Used {
    let [hard, filtered] = [Promises::LIGHT, Promises::LIGHT_FILTERED].map(|promises| promises.interior);
    let least = format!("{hard}, or {filtered} with a filter");
    let own = vec![
        ("--samples", args.samples.to_string()),
        ("--seed", args.seed.to_string()),
        ("--min-interior", absent(args.min_interior.as_ref(), &least)),
    ];
    [own, lookup(&args.lookup), load(&args.load), run(&args.run)].concat()
}

fn points(args: &PointArgs) -> Used {
    vec![
        ("--points", absent(args.places.points.as_ref(), "")),
        // One of the three must be given, and the test gives this one.
        ("--grid", String::new()),
        ("--surfaces", absent(args.places.surfaces.as_ref(), "")),
        ("--lift", args.lift.to_string()),
    ]
}

fn sun_hours(args: &SunHours) -> Used {
    let day = args.day.day().unwrap();
    assert_eq!(day.zone().name(), "+01:00");
    let zone = "the nautical zone, the whole hour nearest to the longitude";
    let own = vec![
        ("--tz", absent(args.day.tz.as_ref(), zone)),
        ("--compare", absent(args.compare.as_ref(), "")),
        ("--epsg", absent(args.epsg.as_ref(), "")),
        ("--origin", args.origin.map(|c| c.to_string()).join(",")),
        ("--progress", name(&args.progress)),
    ];
    [own, points(&args.points), load(&args.load), run(&args.run)].concat()
}

fn sky(args: &Sky) -> Used {
    let own = vec![("--patches", name(&args.patches)), ("--progress", name(&args.progress))];
    [own, points(&args.points), load(&args.load), run(&args.run)].concat()
}

fn level(args: &LevelArg) -> Used {
    vec![("--level", args.level.to_string())]
}

fn used(verb: &Verb) -> Used {
    match verb {
        Verb::Generate(args) => [vec![("--seed", args.seed.to_string())], run(&args.run)].concat(),
        Verb::Inspect(args) => [load(&args.load), run(&args.run)].concat(),
        Verb::Bake(args) => bake(args),
        Verb::Plan(args) => plan(args),
        Verb::Tile(args) => tile(args),
        Verb::Link(args) => {
            let cache = absent(args.cache.as_ref(), "the plan's path with the extension .cache");
            [vec![("--cache", cache)], run(&args.run)].concat()
        }
        Verb::Info(args) => {
            let level = ("--level", args.level.to_string());
            let own = vec![("--picture", String::new()), level, ("--snippet", String::new())];
            [own, run(&args.run)].concat()
        }
        Verb::Schema(_) => vec![("words", String::new())],
        Verb::Verify(args) => {
            let own = vec![
                ("--every", args.path.every.to_string()),
                ("--max-excess", args.path.max_excess.to_string()),
                ("--plot", absent(args.path.plot.as_ref(), "")),
            ];
            [own, verify(&args.verify), level(&args.level)].concat()
        }
        Verb::Query(QueryFile { query: args, level: of_level, time }) => {
            let own = vec![
                ("--time", absent(time.as_ref(), "")),
                ("--points", String::new()),
                ("--points-f64", absent(args.points_f64.as_ref(), "")),
                ("--normals", absent(args.normals.as_ref(), "")),
            ];
            [own, level(of_level), lookup(&args.lookup), run(&args.run)].concat()
        }
        Verb::SunHours(args) => sun_hours(args),
        Verb::Sky(args) => sky(args),
        Verb::Cache(_) => Vec::new(),
        Verb::Convert(args) => {
            let output = ("--output", absent(args.output.as_ref(), "the file itself"));
            [vec![output], run(&args.run)].concat()
        }
        Verb::Render(args) => render(args),
        Verb::View(args) => view(args),
        Verb::Compare(args) => compare(args),
        Verb::Demo(args) => {
            let own = vec![
                ("--out", args.out.display().to_string()),
                ("--resolution", args.resolution.to_string()),
            ];
            [own, run(&args.run)].concat()
        }
    }
}

/// Returns the required arguments of a verb.
fn required(verb: &str) -> &'static [&'static str] {
    match verb {
        "generate" => &["city", "-o", "a.glb"],
        "verify" => &["a.adumbra", "--scene", "a.glb"],
        "query" => &["a.adumbra", "--points", "p.f32", "-o", "v.f32"],
        "sun-hours" => &[
            "a.glb",
            "--grid",
            "1",
            "--lat",
            "48",
            "--lon",
            "11.6",
            "--date",
            "2026-06-21",
            "--from",
            "7",
            "--to",
            "19",
            "-o",
            "a.csv",
        ],
        "sky" => &["a.glb", "--grid", "1", "-o", "a.csv"],
        "render" => &["a.glb", "-o", "a.png"],
        "compare" => &["a.glb", "--shadow", "csm", "-o", "OUT"],
        "tile" => &["--plan", "a.plan.json"],
        "link" => &["--plan", "a.plan.json", "-o", "a.adumbra"],
        "convert" => &["a.adumbra", "--encoding", "raw"],
        "cache prune" => &["DIR", "--keep", "1GB"],
        "demo" => &[],
        _ => &["a.glb"],
    }
}

#[test]
fn help_states_the_defaults_that_verbs_use() {
    Args::command().debug_assert();
    for (name, command) in verbs(&Args::command()) {
        let words = ["adumbra"].into_iter().chain(name.split(' ')).chain(required(&name).iter().copied());
        let args = Args::try_parse_from(words).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_defaults(&name, &command, &used(&args.verb));
    }
}

#[test]
#[cfg(feature = "view")]
fn guide_lists_every_verb() {
    let guide = include_str!("../../../../docs/guides/the-programs.md");
    assert_listed(guide, "adumbra", &Args::command());
}

/// The derive macros of clap keep a default in a static variable, which all instances of a generic type
/// share.
#[test]
fn argument_types_are_not_generic() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let within = |folder: &str| {
        let entries: Vec<_> =
            std::fs::read_dir(root.join(folder)).unwrap().map(|e| e.unwrap().path()).collect();
        entries.into_iter()
    };
    let folders = ["src/args", "../../lab/program/src/args", "../adumbra-program/src/args"];
    let verbs = within("../adumbra-compare/src/verbs").filter(|path| path.is_dir());
    let files = ["src/args.rs", "../adumbra-compare/src/args.rs"].map(|file| root.join(file));
    let shared =
        ["lookup", "query", "verify"].map(|name| root.join(format!("../adumbra-program/src/{name}.rs")));
    let paths =
        folders.iter().flat_map(|folder| within(folder)).chain(verbs.map(|verb| verb.join("args.rs")));
    let mut types = 0;
    for path in paths.chain(files).chain(shared) {
        let text = std::fs::read_to_string(&path).unwrap();
        for line in text.lines().map(str::trim_start) {
            let Some((_, declared)) = line.split_once("struct ").filter(|(before, _)| !before.contains('/'))
            else {
                continue;
            };
            types += 1;
            assert!(!declared.contains('<') || declared.contains("<'"), "{}: {line}", path.display());
        }
    }
    assert!(types > 30, "{types}");
}

#[test]
fn short_help_of_bake_fits_sixty_lines_without_paper_options() {
    let program = Args::command();
    let (_, bake) = verbs(&program).into_iter().find(|(name, _)| name == "bake").expect("the verb");
    let help = bake.term_width(100).render_help().to_string();
    let lines = help.lines().count();
    assert!(lines <= 60, "{lines} lines:\n{help}");
    for word in ["World frame", "paper", "--builder", "--layout"] {
        assert!(!help.contains(word), "{word}:\n{help}");
    }
}
