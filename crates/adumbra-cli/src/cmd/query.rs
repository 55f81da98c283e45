//! `adumbra query`: points in, visibilities out.

use std::path::Path;

use adumbra::Error;
use adumbra::files::{check_output, same_file};
use adumbra::format::{AnyFile, AttributeKind, TreeBody};
use adumbra::query::PenumbraQuery;
use rayon::prelude::*;
use serde_json::json;

use super::lookup::Asking;
use super::{print_json, with_threads};
use crate::args::Query;
use crate::exit::{Code, Failure, Outcome};
use crate::output::{Outputs, refuse_inputs};

/// Points that are answered one after the other: a look-up remembers where the last one was.
const BATCH: usize = 1 << 14;

pub(crate) fn run(args: &Query) -> Outcome {
    let points_path = args.points_path();
    for (option, output) in [("--output", Some(&args.output)), ("--penumbra", args.penumbra.as_ref())] {
        let Some(output) = output else { continue };
        let inputs = [("the shadow file itself", Some(&*args.file)), ("the points", Some(points_path))];
        let inputs = inputs.into_iter().chain([("the normals", args.normals.as_deref())]);
        refuse_inputs(option, output, inputs.filter_map(|(what, path)| Some((what, path?))))?;
    }
    if let Some(widths) = &args.penumbra
        && same_file(widths, &args.output)
    {
        return Err(Failure::Usage(format!(
            "--penumbra and --output are the same file {}; give one of them another path",
            args.output.display()
        )));
    }
    // Before hours of answers that have no place to go.
    args.penumbra.iter().chain([&args.output]).try_for_each(|output| check_output(output))?;
    let file = AnyFile::read(&args.file)?;
    let points = match &args.points_f64 {
        Some(path) => read_f64_triples(path)?,
        None => read_f32_triples(points_path)?,
    };
    let normals = args.normals.as_deref().map(read_f32_triples).transpose()?;
    if let Some(n) = &normals
        && n.len() != points.len()
    {
        return Err(Failure::BadInput(format!(
            "{} holds {} normals, but {} holds {} points; give one a point",
            args.normals.as_deref().unwrap_or(Path::new("")).display(),
            n.len(),
            points_path.display(),
            points.len()
        )));
    }
    let not_finite = NotFinite::of(&points, normals.as_deref());
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
    let mut outputs = Outputs::default();
    if let (Some(query), Some(path)) = (&penumbrae, &args.penumbra) {
        let width = |i: usize| query.width(points[i], normal(i)).map_or(f32::NAN, |w| w as f32);
        let widths: Vec<f32> =
            with_threads(args.work.threads, || Ok((0..points.len()).into_par_iter().map(width).collect()))?;
        outputs.add(path, &floats(&widths))?;
    }
    outputs.add(&args.output, &floats(&visibilities))?;
    outputs.place()?;
    let mean = visibilities.iter().fold(0.0, |sum, v| sum + f64::from(*v)) / visibilities.len().max(1) as f64;
    not_finite.say(points.len());
    if args.json {
        print_json(&json!({
            "points": points.len(),
            "points_not_finite": not_finite.points,
            "normals_not_finite": not_finite.normals,
            "mean_visibility": mean,
            "output": args.output.display().to_string(),
        }));
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

/// How many points and normals have a component that is infinite or not a number.
struct NotFinite {
    points: usize,
    normals: usize,
}

impl NotFinite {
    fn of(points: &[[f64; 3]], normals: Option<&[[f64; 3]]>) -> Self {
        let count = |all: &[[f64; 3]]| all.iter().filter(|p| !p.iter().all(|c| c.is_finite())).count();
        Self { points: count(points), normals: normals.map_or(0, count) }
    }

    /// One line on stderr, where there are any.
    fn say(&self, of: usize) {
        let Self { points, normals } = *self;
        let lit = format!("{points} of {of} points are not finite and called lit");
        let plain =
            format!("{normals} of {of} normals are not finite, and their points answered as without one");
        match (points, normals) {
            (0, 0) => {}
            (_, 0) => eprintln!("warning: {lit}"),
            (0, _) => eprintln!("warning: {plain}"),
            _ => eprintln!("warning: {lit}; {plain}"),
        }
    }
}

fn read_f32_triples(path: &Path) -> Result<Vec<[f64; 3]>, Failure> {
    let triples = read_triples::<4>(path, "float32")?;
    Ok(triples.into_iter().map(|t| t.map(|b| f64::from(f32::from_le_bytes(b)))).collect())
}

fn read_f64_triples(path: &Path) -> Result<Vec<[f64; 3]>, Failure> {
    Ok(read_triples::<8>(path, "float64")?.into_iter().map(|t| t.map(f64::from_le_bytes)).collect())
}

/// Triples of numbers that take `BYTES` bytes each.
fn read_triples<const BYTES: usize>(path: &Path, kind: &str) -> Result<Vec<[[u8; BYTES]; 3]>, Failure> {
    let bytes = std::fs::read(path).map_err(Error::io("read", path))?;
    if bytes.len() % (3 * BYTES) != 0 {
        return Err(Failure::BadInput(format!(
            "{}: {} bytes are not whole {kind} triples of {} bytes; write x, y, z as little-endian {kind}",
            path.display(),
            bytes.len(),
            3 * BYTES
        )));
    }
    Ok(bytes.as_chunks::<BYTES>().0.as_chunks::<3>().0.to_vec())
}
