//! `adumbra query`: points in, visibilities out.

use std::path::{Path, PathBuf};

use adumbra::Error;
use adumbra::format::{AnyFile, AttributeKind, TreeBody};
use adumbra::query::PenumbraQuery;
use rayon::prelude::*;
use serde_json::json;

use super::lookup::Asking;
use super::{print_json, with_threads};
use crate::args::Query;
use crate::exit::{Code, Failure, Outcome};
use crate::output::{same_file, write_whole};

/// Points that are answered one after the other: a look-up remembers where the last one was.
const BATCH: usize = 1 << 14;

pub(crate) fn run(args: &Query) -> Outcome {
    if let Some(widths) = &args.penumbra
        && (same_file(widths, &args.output) || absolute(widths) == absolute(&args.output))
    {
        return Err(Failure::Usage(format!(
            "--penumbra and --output are the same file {}; give one of them another path",
            args.output.display()
        )));
    }
    let file = AnyFile::read(&args.file)?;
    let points = read_triples(&args.points)?;
    let normals = args.normals.as_deref().map(read_triples).transpose()?;
    if let Some(n) = &normals
        && n.len() != points.len()
    {
        return Err(Failure::BadInput(format!(
            "{} holds {} normals, but {} holds {} points; give one a point",
            args.normals.as_deref().unwrap_or(Path::new("")).display(),
            n.len(),
            args.points.display(),
            points.len()
        )));
    }
    // A point, its normal, its answer, in its batch and behind the others, and the answer's bytes.
    args.work.check_memory("the points", points.len() as u64 * (24 + 24 + 4 + 4 + 4) + file.encoded_len())?;
    let asking = Asking { bias: &args.bias, filter: args.filter, weights: args.weights.into() };
    let lookup = asking.lookup(&file)?;
    let penumbrae = args.penumbra.as_ref().map(|_| penumbra_query(args, &asking, &file)).transpose()?;
    let normal = |i: usize| normals.as_ref().map(|n| n[i]);
    let visibilities: Vec<f32> = with_threads(args.work.threads, || {
        let batches = points.par_chunks(BATCH).enumerate();
        let answers = batches.map(|(b, batch)| {
            let normals = normals.as_ref().map(|n| &n[b * BATCH..][..batch.len()]);
            lookup.visibilities(batch, normals)
        });
        Ok(answers.collect::<Vec<_>>().concat())
    })?;
    let floats = |values: &[f32]| -> Vec<u8> { values.iter().flat_map(|v| v.to_le_bytes()).collect() };
    if let (Some(query), Some(path)) = (&penumbrae, &args.penumbra) {
        let width = |i: usize| query.width(points[i], normal(i)).map_or(f32::NAN, |w| w as f32);
        let widths: Vec<f32> =
            with_threads(args.work.threads, || Ok((0..points.len()).into_par_iter().map(width).collect()))?;
        write_whole(path, &floats(&widths))?;
    }
    write_whole(&args.output, &floats(&visibilities))?;
    let mean = visibilities.iter().map(|v| f64::from(*v)).sum::<f64>() / visibilities.len().max(1) as f64;
    if args.json {
        print_json(
            &json!({"points": points.len(), "mean_visibility": mean, "output": args.output.display().to_string()}),
        );
    } else {
        say!("{}: {} points, mean visibility {mean:.4}", args.output.display(), points.len());
    }
    Ok(Code::Fine)
}

fn penumbra_query<'f>(
    args: &Query,
    asking: &Asking<'_>,
    file: &'f AnyFile,
) -> Result<PenumbraQuery<'f>, Failure> {
    if let AnyFile::Tree(file) = file
        && let TreeBody::Words(tree) = &file.body
        && file.attribute_kind == Some(AttributeKind::Penumbra)
    {
        return Ok(PenumbraQuery::new(asking.tree(file, tree)?, tree, &file.attribute)?);
    }
    Err(Failure::BadInput(format!(
        "{}: holds no penumbra widths; bake it with --frame world --attribute penumbra",
        args.file.display()
    )))
}

/// A path from the root, for files that need not exist.
fn absolute(path: &Path) -> Option<PathBuf> {
    std::path::absolute(path).ok()
}

fn read_triples(path: &Path) -> Result<Vec<[f64; 3]>, Failure> {
    let bytes = std::fs::read(path).map_err(Error::io("read", path))?;
    if bytes.len() % 12 != 0 {
        return Err(Failure::BadInput(format!(
            "{}: {} bytes are not whole float32 triples of 12 bytes; write x, y, z as little-endian float32",
            path.display(),
            bytes.len()
        )));
    }
    let number = |b: &[u8]| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    Ok(bytes
        .as_chunks::<12>()
        .0
        .iter()
        .map(|t| [number(&t[..4]), number(&t[4..8]), number(&t[8..])])
        .collect())
}
