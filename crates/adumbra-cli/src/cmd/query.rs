//! `adumbra query`: points in, visibilities out.

use adumbra::IoError;
use std::path::Path;

use adumbra_files::{check_output, same_file};
use adumbra_program::exit::{Code, Failure, Outcome};
use adumbra_program::output::{Outputs, print_json, refuse_inputs};
use adumbra_program::say;
use adumbra_program::threads::with_threads;
use adumbra_tree::query::PenumbraQuery;
use adumbra_tree::{AnyFile, AttributeKind, TreeBody};
use rayon::prelude::*;
use serde::Serialize;

use super::lookup::LookupOptions;
use crate::args::Query;

/// The result of a query.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct Answered {
    /// Number of points that were looked up.
    points: usize,
    /// Number of points with a component that is infinite or not a number. They count as lit.
    points_not_finite: usize,
    /// Number of normals with a component that is infinite or not a number. Their points are looked up as if without a
    /// normal.
    normals_not_finite: usize,
    /// Mean of the answers, 0 to 1. 1 is lit.
    mean_visibility: f64,
    /// The file that the answers were written to.
    output: String,
}

/// Number of points that are looked up one after the other. A look-up remembers the position of the last point.
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
    // Checked before hours of look-ups whose results could not be written.
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
            "{} holds {} normals, but {} holds {} points; give one normal per point",
            args.normals.as_deref().unwrap_or(Path::new("")).display(),
            n.len(),
            points_path.display(),
            points.len()
        )));
    }
    let not_finite = NotFinite::of(&points, normals.as_deref());
    // Bytes per point: the point (24), its normal (24), its answer in its batch (4) and in the whole (4), and the
    // answer's bytes (4).
    let (count, file_bytes) = (points.len() as u64, file.encoded_len());
    let held = count * if normals.is_some() { 24 + 24 } else { 24 } + file_bytes;
    args.run.check_memory("the points", held, count * (24 + 24 + 4 + 4 + 4) + file_bytes)?;
    let asking = LookupOptions::from(&args.lookup);
    let lookup = asking.lookup(&file)?;
    let penumbrae = args.penumbra.as_ref().map(|_| penumbra_query(args, &asking, &file)).transpose()?;
    let normal = |i: usize| normals.as_ref().map(|n| n[i]);
    let visibilities: Vec<f32> = with_threads(args.run.threads, || {
        let batches = points.par_chunks(BATCH).enumerate();
        let answers = batches.map(|(b, batch)| {
            let normals = normals.as_ref().map(|n| &n[b * BATCH..][..batch.len()]);
            lookup.visibilities(batch, normals)
        });
        answers.collect::<Vec<_>>().concat()
    })?;
    let floats = |values: &[f32]| -> Vec<u8> { values.iter().flat_map(|v| v.to_le_bytes()).collect() };
    let mut outputs = Outputs::default();
    if let (Some(query), Some(path)) = (&penumbrae, &args.penumbra) {
        let width = |i: usize| query.width(points[i], normal(i)).map_or(f32::NAN, |w| w as f32);
        let widths: Vec<f32> =
            with_threads(args.run.threads, || (0..points.len()).into_par_iter().map(width).collect())?;
        outputs.add(path, &floats(&widths))?;
    }
    outputs.add(&args.output, &floats(&visibilities))?;
    outputs.place()?;
    let mean = visibilities.iter().fold(0.0, |sum, v| sum + f64::from(*v)) / visibilities.len().max(1) as f64;
    not_finite.say(points.len());
    if args.run.json {
        print_json(&Answered {
            points: points.len(),
            points_not_finite: not_finite.points,
            normals_not_finite: not_finite.normals,
            mean_visibility: mean,
            output: args.output.display().to_string(),
        })?;
    } else {
        say!("{}: {} points, mean visibility {mean:.4}", args.output.display(), points.len());
    }
    Ok(Code::Fine)
}

fn penumbra_query<'f>(
    args: &Query,
    asking: &LookupOptions<'_>,
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

/// Numbers of points and normals with a component that is infinite or not a number.
struct NotFinite {
    points: usize,
    normals: usize,
}

impl NotFinite {
    fn of(points: &[[f64; 3]], normals: Option<&[[f64; 3]]>) -> Self {
        let count = |all: &[[f64; 3]]| all.iter().filter(|p| !p.iter().all(|c| c.is_finite())).count();
        Self { points: count(points), normals: normals.map_or(0, count) }
    }

    /// Prints one line on stderr if there are any.
    fn say(&self, of: usize) {
        let Self { points, normals } = *self;
        let lit = format!("{points} of {of} points are not finite and count as lit");
        let plain =
            format!("{normals} of {of} normals are not finite, so their points are looked up without one");
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

/// Reads triples of numbers that take `BYTES` bytes each.
fn read_triples<const BYTES: usize>(path: &Path, kind: &str) -> Result<Vec<[[u8; BYTES]; 3]>, Failure> {
    let bytes = std::fs::read(path).map_err(IoError::at("read", path))?;
    if bytes.len() % (3 * BYTES) != 0 {
        return Err(Failure::BadInput(format!(
            "{}: {} bytes are not a whole number of {kind} triples of {} bytes; write x, y, z as little-endian {kind}",
            path.display(),
            bytes.len(),
            3 * BYTES
        )));
    }
    Ok(bytes.as_chunks::<BYTES>().0.as_chunks::<3>().0.to_vec())
}
