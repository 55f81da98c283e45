//! `adumbra generate`: writes a scene generated from a seed.

use adumbra_program::exit::{Code, Outcome};
use adumbra_program::output::print_json;
use adumbra_program::say;
use adumbra_program::threads::with_threads;
use adumbra_scene::{generate, write_glb};
use clap::ValueEnum;
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::Generate;

/// A generated scene.
#[derive(Serialize, JsonSchema)]
pub(super) struct Generated {
    /// The scene's file.
    output: String,
    /// The kind of scene, as the command line names it.
    kind: Option<String>,
    /// The seed that the scene was made from.
    seed: u64,
    /// Number of triangles of the instances. A mesh counts as often as it is placed.
    triangles: u64,
}

pub(crate) fn run(args: &Generate) -> Outcome {
    let scene = with_threads(args.run.threads, || generate(args.kind.0, args.seed))?;
    // The scene, and about as many bytes for the file.
    args.run.check_memory("the scene", scene.memory_bytes(), 2 * scene.memory_bytes())?;
    write_glb(&scene, &args.output)?;
    let triangles = scene.instanced_triangles();
    if args.run.json {
        let kind = args.kind.to_possible_value().map(|v| v.get_name().to_owned());
        print_json(&Generated {
            output: args.output.display().to_string(),
            kind,
            seed: args.seed,
            triangles,
        })?;
    } else {
        say!("{}: {triangles} triangles", args.output.display());
    }
    Ok(Code::Fine)
}
