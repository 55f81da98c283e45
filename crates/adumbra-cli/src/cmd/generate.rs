//! `adumbra generate`: a scene from a seed.

use adumbra::scene::{generate, write_glb};

use crate::args::Generate;
use crate::exit::{Code, Outcome};

pub(crate) fn run(args: &Generate) -> Outcome {
    let scene = generate(args.kind.into(), args.seed);
    write_glb(&scene, &args.output)?;
    say!("{}: {} triangles", args.output.display(), scene.instanced_triangles());
    Ok(Code::Fine)
}
