//! `adumbra-lab tree query` and `tree verify`: look-ups in a tree file.

use adumbra::PointVisibility;
use adumbra_papers::tree::query::{PenumbraQuery, TreeQuery as Lookup, Weights};
use adumbra_papers::tree::{AttributeKind, TreeAnswers, TreeBody, TreeFile, Voxels, volume_of};
use adumbra_program::exit::{Failure, Outcome};
use adumbra_program::lookup::LookupArgs;
use adumbra_program::query::More;
use adumbra_program::verify::Verified;
use adumbra_scene::{Casters, LoadedAs};

use crate::args::{TreeQuery, TreeVerify};

fn lookup<'f, T: Voxels>(
    args: &LookupArgs,
    weights: Weights,
    file: &TreeFile,
    tree: &'f T,
) -> Result<Lookup<'f, T>, Failure> {
    let bias = args.bias.over(file.settings.bias)?;
    Ok(Lookup::new(&file.space, &file.regions, &file.sun, tree, bias, args.filter, weights)?)
}

pub(super) fn query(args: &TreeQuery) -> Outcome {
    let TreeQuery { query, weights, penumbra } = args;
    query.check_outputs(penumbra.as_deref().map(|path| ("--penumbra", path)))?;
    query.run.memory_limit().check_plain_file(&query.file)?;
    let file = TreeFile::read(&query.file)?;
    let points = query.read()?;
    let weights = Weights::from(*weights);
    let lookup: Box<dyn PointVisibility + '_> = match &file.body {
        TreeBody::Words(tree) => Box::new(lookup(&query.lookup, weights, &file, tree)?),
        TreeBody::Symmetric(tree) => Box::new(lookup(&query.lookup, weights, &file, tree)?),
    };
    let Some(path) = penumbra else { return query.answer(&points, &*lookup, None) };
    let widths = penumbrae(args, weights, &file)?;
    let value = |p, normal| widths.width(p, normal).map_or(f32::NAN, |width| width as f32);
    query.answer(&points, &*lookup, Some(&More { option: "--penumbra", path, value: &value }))
}

fn penumbrae<'f>(
    args: &TreeQuery,
    weights: Weights,
    file: &'f TreeFile,
) -> Result<PenumbraQuery<'f>, Failure> {
    if let TreeBody::Words(tree) = &file.body
        && file.attribute_kind == Some(AttributeKind::Penumbra)
    {
        let lookup = lookup(&args.query.lookup, weights, file, tree)?;
        return Ok(PenumbraQuery::new(lookup, tree, &file.attribute)?);
    }
    Err(Failure::BadInput(format!(
        "{}: holds no penumbra widths; bake it with --attribute penumbra",
        args.query.file.display()
    )))
}

pub(super) fn verify(args: &TreeVerify) -> Outcome {
    let TreeVerify { verify, weights } = args;
    verify.run.memory_limit().check_plain_file(&verify.file)?;
    let file = TreeFile::read(&verify.file)?;
    let weights = Weights::from(*weights);
    let verified = Verified {
        sun: file.sun,
        voxel_size: file.space.voxel_size,
        is_finest: true,
        scene: LoadedAs { ignore_alpha: file.ignores_alpha(), ..LoadedAs::default() },
        assumes_ground: false,
        casters: Some(Casters { triangles: file.settings.triangles, instances: file.settings.instances }),
        volume: volume_of(&file.space),
    };
    match &file.body {
        TreeBody::Words(tree) => {
            let lookup = lookup(&verify.lookup, weights, &file, tree)?;
            verify.compare(verified, &TreeAnswers::new(&file.settings, file.sun, lookup))
        }
        TreeBody::Symmetric(tree) => {
            let lookup = lookup(&verify.lookup, weights, &file, tree)?;
            verify.compare(verified, &TreeAnswers::new(&file.settings, file.sun, lookup))
        }
    }
}
