//! Every default that the help of `adumbra-lab` states is the value that its verbs use.

use std::path::Path;

use adumbra::Sun;
use adumbra_bake::{FrameChoice, Size};
use adumbra_compare::args::{CacheArgs, DeviceArgs};
use adumbra_compare::truth::Cache;
use adumbra_compare::verbs;
use adumbra_papers::dag::build::DagOptions;
use adumbra_papers::tree::{Detail, TREE_PROMISES};
use adumbra_program::args::{RunArgs, SceneArgs, SunArgs};
use adumbra_program::output::format_bytes;
use adumbra_program::query::Query;
use adumbra_program::verify::Verify;
use adumbra_testing::help::{assert_defaults, assert_listed, stated_defaults, verbs as verbs_of};
use clap::{Command, CommandFactory, Parser, ValueEnum};

use super::*;

#[derive(Parser)]
#[command(name = "adumbra-lab")]
struct Program {
    #[command(subcommand)]
    verb: Verb,
}

type Used = Vec<(&'static str, String)>;

fn listed<T: ToString>(values: &[T]) -> String {
    values.iter().map(ToString::to_string).collect::<Vec<_>>().join(",")
}

fn size([width, height]: [u32; 2]) -> String {
    format!("{width}x{height}")
}

fn name(value: &impl ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

/// Returns the text of an option without a default.
fn nothing<T>(value: Option<&T>) -> String {
    assert!(value.is_none());
    String::new()
}

fn empty<T>(values: &[T]) -> String {
    assert!(values.is_empty());
    String::new()
}

fn device(args: &DeviceArgs) -> Used {
    let any = args.gpu_options().adapter.is_none();
    vec![
        ("--device", name(&args.device)),
        ("--adapter", if any { "the first real GPU, or else a software adapter" } else { "" }.to_owned()),
        ("--without", empty(&args.without)),
    ]
}

fn cache(args: &CacheArgs) -> Used {
    let (name, limit) = ("truth-cache", Cache::DEFAULT_LIMIT_BYTES);
    let expected = Cache::in_folder(Path::new("OUT").join(name), limit);
    assert_eq!(format!("{:?}", args.cache(Path::new("OUT"))), format!("{expected:?}"));
    let limit = format_bytes(limit).replace(".0 ", "");
    vec![("--cache", format!("{name} in the output folder")), ("--cache-limit", limit)]
}

/// Returns the defaults of arguments that `adumbra` also accepts. The tests of `adumbra` compare these
/// defaults with the values that are used.
fn of_adumbra<A: clap::Args>() -> Used {
    let stated = stated_defaults(&A::augment_args(Command::new("adumbra")));
    stated.into_iter().map(|(option, text)| (&*option.leak(), text.unwrap_or_default())).collect()
}

fn cube(args: &CubeArgs) -> Used {
    vec![("--cube-resolution", args.cube_resolution.to_string())]
}

fn truth_bench(args: &bench::TruthBench) -> Used {
    let resolution = vec![("--resolution", args.resolutions.resolution.to_string())];
    [resolution, cube(&args.cube), device(&args.device)].concat()
}

fn tree_bake(args: &TreeBake) -> Used {
    let up = Sun::from_direction([0.0, 1.0, 0.0]).unwrap();
    let options = args.options(up, None);
    let Size::Resolution(resolution) = options.size else { panic!("{:?}", options.size) };
    assert_eq!(options.detail, Detail::Uniform);
    let lower = |text: String| text.to_lowercase();
    let own = vec![
        ("--resolution", resolution.to_string()),
        ("--voxel-size", String::new()),
        ("--bounds", nothing(options.bounds.as_ref())),
        ("--region", String::new()),
        ("--rings", String::new()),
        ("--lossy", nothing(args.lossy.as_ref())),
        ("--attribute", nothing(args.attribute.as_ref())),
        ("--builder", lower(format!("{:?}", options.builder))),
        ("--reduction", lower(format!("{:?}", options.reduction))),
        ("--capture-bias-constant", options.capture_bias.constant_texels.to_string()),
        ("--capture-bias-slope", options.capture_bias.slope_texels.to_string()),
        ("--output", nothing(args.output.as_ref()) + "the scene's path with the extension .adumtree"),
        ("--progress", name(&args.progress)),
    ];
    [own, of_adumbra::<SunArgs>(), of_adumbra::<SceneArgs>(), of_adumbra::<RunArgs>()].concat()
}

fn dag_bake(args: &DagBake) -> Used {
    let up = Sun::from_direction([0.0, 1.0, 0.0]).unwrap();
    let DagOptions { bake: options, layout } = args.options(up, None);
    let Size::Resolution(resolution) = options.size else { panic!("{:?}", options.size) };
    assert_eq!(options.frame, FrameChoice::Auto);
    let own = vec![
        ("--resolution", resolution.to_string()),
        ("--layout", layout.name().to_owned()),
        ("--frame", "auto".to_owned()),
        ("--builder", format!("{:?}", options.builder).to_lowercase()),
        ("--bounds", nothing(options.bounds.as_ref())),
        ("--output", nothing(args.output.as_ref()) + "the scene's path with the extension .adumdag"),
        ("--progress", name(&args.progress)),
    ];
    [own, of_adumbra::<SunArgs>(), of_adumbra::<SceneArgs>(), of_adumbra::<RunArgs>()].concat()
}

fn dag(verb: &DagVerb) -> Used {
    match verb {
        DagVerb::Bake(args) => dag_bake(args),
        DagVerb::Info(_) => Vec::new(),
        DagVerb::Verify(_) => of_adumbra::<Verify>(),
        DagVerb::Query(_) => of_adumbra::<Query>(),
    }
}

fn tree(verb: &TreeVerb) -> Used {
    match verb {
        TreeVerb::Bake(args) => tree_bake(args),
        TreeVerb::Info(_) => Vec::new(),
        TreeVerb::Verify(args) => {
            let least = nothing(args.verify.min_interior.as_ref()) + &TREE_PROMISES.interior.to_string();
            let own = vec![("--weights", name(&args.weights)), ("--min-interior", least)];
            [of_adumbra::<Verify>(), own].concat()
        }
        TreeVerb::Query(args) => {
            let own =
                vec![("--weights", name(&args.weights)), ("--penumbra", nothing(args.penumbra.as_ref()))];
            [of_adumbra::<Query>(), own].concat()
        }
        TreeVerb::Export(args) => {
            [vec![("--max-side", args.max_side.to_string())], of_adumbra::<RunArgs>()].concat()
        }
        TreeVerb::Import(_) => of_adumbra::<RunArgs>(),
    }
}

fn picture_bench(args: &bench::PictureBench) -> Used {
    let own = vec![("--frames", args.frames.to_string()), ("--size", size(args.size))];
    [own, device(&args.device), cache(&args.cache)].concat()
}

fn used(verb: &Verb) -> Used {
    let bench = match verb {
        Verb::Bench { what } => what,
        Verb::Report(args) => {
            // Without --full a report is quick.
            let quick = if args.full { "not the default" } else { "" };
            return vec![
                ("--quick", quick.to_owned()),
                ("--scenes", nothing(args.scenes.as_ref())),
                ("--truth", nothing(args.truth.as_ref())),
                ("--only", empty(&args.only)),
                ("--size", size(args.size)),
            ];
        }
        Verb::TuneAo(args) => {
            let own = vec![
                ("--budget", args.budget.to_string()),
                ("--only", empty(&args.only)),
                ("--variant", empty(&args.variant)),
                ("--record", args.record.display().to_string()),
                ("--table", args.table.display().to_string()),
            ];
            return [own, device(&args.device)].concat();
        }
        Verb::Schema(_) => return vec![("words", String::new())],
        Verb::Dag { what } => return dag(what),
        Verb::Tree { what } => return tree(what),
        Verb::Compare(args) => {
            return [of_adumbra::<verbs::compare::Compare>(), cube(&args.cube)].concat();
        }
        Verb::Render(args) => return [of_adumbra::<verbs::render::Render>(), cube(&args.cube)].concat(),
    };
    match bench {
        BenchVerb::Bake(args) => vec![
            ("--suite", name(&args.suite)),
            ("--names", listed(&args.names)),
            ("--resolutions", listed(&args.resolutions)),
            ("--variant-resolution", args.variant_resolution.to_string()),
            ("--only", empty(&args.only)),
            ("--max-n", nothing(args.max_n.as_ref())),
            ("--samples", args.samples.to_string()),
        ],
        BenchVerb::Verify(args) => vec![
            ("--names", listed(&args.names)),
            ("--resolution", args.resolution.to_string()),
            ("--samples", args.samples.to_string()),
            ("--filter", listed(&args.filter)),
        ],
        BenchVerb::Tree(args) => vec![
            ("--names", listed(&args.names)),
            ("--depths", listed(&args.depths)),
            ("--runs", args.runs.to_string()),
            ("--samples", args.samples.to_string()),
            ("--only", empty(&args.only)),
        ],
        BenchVerb::Blur(args) => {
            let own = vec![
                ("--samples", listed(&args.samples)),
                ("--runs", args.runs.to_string()),
                ("--size", size(args.size)),
            ];
            [own, device(&args.device)].concat()
        }
        BenchVerb::Shadows(args) => {
            let own = vec![
                ("--names", listed(&args.names)),
                ("--shadow", listed(&args.shadow)),
                ("--cost-scene", args.cost_scene.clone()),
                ("--cost-shadow", listed(&args.cost_shadow)),
                ("--frames", args.frames.to_string()),
                ("--path-frames", args.path_frames.to_string()),
                ("--size", size(args.size)),
            ];
            [own, cache(&args.cache), truth_bench(&args.common)].concat()
        }
        BenchVerb::Lookup(args) => {
            let own = vec![
                ("--names", listed(&args.names)),
                ("--filter", listed(&args.filter)),
                ("--size", size(args.size)),
                ("--frames", args.frames.to_string()),
                ("--every", args.every.to_string()),
            ];
            [own, truth_bench(&args.common)].concat()
        }
        BenchVerb::Stream(args) => vec![
            ("--budget", args.budget.to_string()),
            ("--upload", args.upload.to_string()),
            ("--latency", args.latency.to_string()),
            ("--frames", args.frames.to_string()),
            ("--speed", args.speed.to_string()),
            ("--size", size(args.size)),
        ],
        BenchVerb::Gpu(args) => {
            let own = vec![
                ("--size", size(args.size)),
                ("--frames", args.frames.to_string()),
                ("--seconds", args.seconds.to_string()),
                ("--resolution", args.resolution.to_string()),
                ("--resolutions", listed(&args.resolutions)),
                ("--tiles", args.tiles.to_string()),
            ];
            [own, device(&args.device)].concat()
        }
        BenchVerb::Peers(args) => {
            let shadow =
                empty(&args.shadow) + "every technique, plus several voxel filters and finer cascades";
            [vec![("--shadow", shadow)], truth_bench(&args.common)].concat()
        }
        BenchVerb::Hrsm(args) => {
            let own = vec![("--starts", listed(&args.starts)), ("--only", empty(&args.only))];
            [own, picture_bench(&args.common)].concat()
        }
        BenchVerb::Ao(args) => {
            let own = vec![
                ("--truth", nothing(args.truth.as_ref()) + "skip that table"),
                ("--only", empty(&args.only)),
                ("--rays", args.rays.to_string()),
            ];
            [own, picture_bench(&args.common)].concat()
        }
    }
}

/// Returns the required arguments of a verb.
fn required(verb: &str) -> &'static [&'static str] {
    match verb {
        "report" => &["-o", "OUT"],
        "tune-ao" => &["--scenes", "SCENES"],
        "bench blur" | "bench gpu" => &["-o", "OUT"],
        "dag bake" | "tree bake" => &["a.glb"],
        "dag info" | "tree info" => &["a.file"],
        "dag verify" | "tree verify" => &["a.file", "--scene", "a.glb"],
        "dag query" | "tree query" => &["a.file", "--points", "p.f32", "-o", "v.f32"],
        "tree export" => &["a.adumtree", "--texture", "a.png"],
        "tree import" => &["a.png", "-o", "a.adumtree"],
        "compare" => &["a.glb", "--shadow", "csm", "-o", "OUT"],
        "render" => &["a.glb", "-o", "a.png"],
        "bench shadows" | "bench lookup" | "bench peers" => {
            &["--scenes", "SCENES", "--truth", "TRUTH", "-o", "OUT"]
        }
        "bench stream" => &["--scene", "SCENE", "--file", "FILE", "-o", "OUT"],
        "schema" => &[],
        _ => &["--scenes", "SCENES", "-o", "OUT"],
    }
}

#[test]
fn guide_lists_every_verb() {
    let guide = include_str!("../../../../docs/guides/the-programs.md");
    assert_listed(guide, "adumbra-lab", &Program::command());
}

#[test]
fn defaults_in_help_match_used_values() {
    Program::command().debug_assert();
    for (name, command) in verbs_of(&Program::command()) {
        let words = ["adumbra-lab"].into_iter().chain(name.split(' ')).chain(required(&name).iter().copied());
        let program = Program::try_parse_from(words).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_defaults(&name, &command, &used(&program.verb));
    }
}
