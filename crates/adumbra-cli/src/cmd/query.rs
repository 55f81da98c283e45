//! `adumbra query`: points in, visibilities out.

use std::path::Path;

use adumbra::Error;
use adumbra::format::AnyFile;
use rayon::prelude::*;
use serde_json::json;

use super::lookup::Asking;
use super::{print_json, with_threads};
use crate::args::Query;
use crate::exit::{Code, Failure, Outcome};
use crate::output::write_whole;

pub(crate) fn run(args: &Query) -> Outcome {
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
    // A point, its normal, its answer and the answer's bytes.
    args.work.check_memory("the points", points.len() as u64 * (24 + 24 + 4 + 4) + file.encoded_len())?;
    let asking = Asking { bias: &args.bias, filter: args.filter, weights: args.weights.into() };
    let lookup = asking.lookup(&file)?;
    let visibilities: Vec<f32> = with_threads(args.work.threads, || {
        Ok((0..points.len())
            .into_par_iter()
            .map(|i| lookup.visibility(points[i], normals.as_ref().map(|n| n[i])))
            .collect())
    })?;
    let bytes: Vec<u8> = visibilities.iter().flat_map(|v| v.to_le_bytes()).collect();
    write_whole(&args.output, &bytes)?;
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
