//! The verb `query`: points in, visibilities out.

use std::path::{Path, PathBuf};

use adumbra::PointVisibility;
use adumbra_files::{check_output, read_whole, same_file};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::RunArgs;
use crate::exit::{Code, Failure, Outcome};
use crate::lookup::LookupArgs;
use crate::output::{Outputs, print_json, refuse_inputs};
use crate::say;
use crate::threads::with_threads;

/// The arguments of `query`.
#[derive(clap::Args)]
pub struct Query {
    /// Shadow file
    pub file: PathBuf,
    /// World-space points as little-endian float32 triples
    #[arg(long, value_name = "FILE", required_unless_present = "points_f64", conflicts_with = "points_f64")]
    points: Option<PathBuf>,
    /// World-space points as little-endian float64 triples: far from the origin float32 would round them to
    /// whole voxels
    #[arg(long, value_name = "FILE")]
    pub points_f64: Option<PathBuf>,
    /// Unit normals as little-endian float32 triples, one per point; the slope bias and the filter's plane
    /// need them
    #[arg(long, value_name = "FILE")]
    pub normals: Option<PathBuf>,
    /// Look-up.
    #[command(flatten)]
    pub lookup: LookupArgs,
    /// The file for the visibilities: one little-endian float32 per point
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Run.
    #[command(flatten)]
    pub run: RunArgs,
}

/// The result of a query.
#[derive(Serialize, JsonSchema)]
pub struct Answered {
    /// Number of points that were looked up.
    points: usize,
    /// Number of points with a component that is infinite or not a number. They count as lit.
    points_not_finite: usize,
    /// Number of normals with a component that is infinite or not a number. Their points are looked up as if
    /// without a normal.
    normals_not_finite: usize,
    /// Mean of the answers, 0 to 1. 1 is lit.
    mean_visibility: f64,
    /// The file that the answers were written to.
    output: String,
}

/// Number of points that are looked up one after the other. A look-up remembers the position of the last
/// point.
const BATCH: usize = 1 << 14;

/// A second value of each point, which is written to its own file.
pub struct More<'a> {
    /// The option that names the file.
    pub option: &'static str,
    /// The file.
    pub path: &'a Path,
    /// The value at a point with a normal or without one.
    pub value: &'a (dyn Fn([f64; 3], Option<[f64; 3]>) -> f32 + Sync),
}

/// While points are read, memory holds their bytes, a copy of these, and their numbers. For float32 that is
/// four times their bytes.
const READING_RATIO: u64 = 4;

/// Points and normals that were read.
pub struct Points {
    points: Vec<[f64; 3]>,
    normals: Option<Vec<[f64; 3]>>,
}

impl Query {
    /// Returns the file of points, whichever format was given.
    fn points_path(&self) -> &Path {
        self.points_f64.as_deref().or(self.points.as_deref()).unwrap_or(Path::new(""))
    }

    /// Refuses outputs that cannot be written or would replace an input. `more` is a further output, with its
    /// option. Call it before hours of look-ups, so that their results can be written.
    ///
    /// # Errors
    ///
    /// Returns [`Failure`] for the first output that is refused.
    pub fn check_outputs(&self, more: Option<(&'static str, &Path)>) -> Result<(), Failure> {
        for (option, output) in [("--output", &*self.output)].into_iter().chain(more) {
            let inputs = [("the shadow file itself", &*self.file), ("the points", self.points_path())];
            let inputs = inputs.into_iter().chain(self.normals.as_deref().map(|path| ("the normals", path)));
            refuse_inputs(option, output, inputs)?;
            check_output(output)?;
        }
        match more {
            Some((option, path)) if same_file(path, &self.output) => Err(Failure::Usage(format!(
                "{option} and --output are the same file {}; give one of them another path",
                self.output.display()
            ))),
            _ => Ok(()),
        }
    }

    /// Reads the points.
    ///
    /// # Errors
    ///
    /// Returns [`Failure`] if a file cannot be read, if there is not one normal per point, or if memory is
    /// not enough.
    pub fn read(&self) -> Result<Points, Failure> {
        let paths = [Some(self.points_path()), self.normals.as_deref()];
        let bytes: u64 = paths.into_iter().flatten().filter_map(|p| Some(p.metadata().ok()?.len())).sum();
        self.run.check_memory("the points", 0, READING_RATIO * bytes)?;
        // The length of a pipe is not known in advance.
        let most_bytes = self.run.max_memory.map_or(u64::MAX, |limit| limit / READING_RATIO);
        let points = match &self.points_f64 {
            Some(path) => read_f64_triples(path, most_bytes)?,
            None => read_f32_triples(self.points_path(), most_bytes)?,
        };
        let normals = self.normals.as_deref().map(|path| read_f32_triples(path, most_bytes)).transpose()?;
        if let (Some(n), Some(path)) = (&normals, &self.normals)
            && n.len() != points.len()
        {
            return Err(Failure::BadInput(format!(
                "{} holds {} normals, but {} holds {} points; give one normal per point",
                path.display(),
                n.len(),
                self.points_path().display(),
                points.len()
            )));
        }
        // Bytes per point: the point (24), its normal (24), its answer in its batch (4) and in the whole (4),
        // and the answer's bytes (4).
        let count = points.len() as u64;
        let held = count * if normals.is_some() { 24 + 24 } else { 24 };
        self.run.check_memory("the points", held, count * (24 + 24 + 4 + 4 + 4))?;
        Ok(Points { points, normals })
    }

    /// Looks up the points, writes the answers and reports them.
    ///
    /// # Errors
    ///
    /// Returns [`Failure`] if an output cannot be written.
    pub fn answer(&self, given: &Points, lookup: &dyn PointVisibility, more: Option<&More<'_>>) -> Outcome {
        let Points { points, normals } = given;
        let visibilities: Vec<f32> = with_threads(self.run.threads, || {
            let batches = points.par_chunks(BATCH).enumerate();
            let answers = batches.map(|(b, batch)| {
                let normals = normals.as_ref().map(|n| &n[b * BATCH..][..batch.len()]);
                lookup.visibilities(batch, normals)
            });
            answers.collect::<Vec<_>>().concat()
        })?;
        let floats = |values: &[f32]| -> Vec<u8> { values.iter().flat_map(|v| v.to_le_bytes()).collect() };
        let mut outputs = Outputs::default();
        if let Some(more) = more {
            let value = |i: usize| (more.value)(points[i], normals.as_ref().map(|n| n[i]));
            let values: Vec<f32> =
                with_threads(self.run.threads, || (0..points.len()).into_par_iter().map(value).collect())?;
            outputs.add(more.path, &floats(&values))?;
        }
        outputs.add(&self.output, &floats(&visibilities))?;
        outputs.place()?;
        let mean =
            visibilities.iter().fold(0.0, |sum, v| sum + f64::from(*v)) / visibilities.len().max(1) as f64;
        let not_finite = NotFinite::of(points, normals.as_deref());
        not_finite.say(points.len());
        if self.run.json {
            print_json(&Answered {
                points: points.len(),
                points_not_finite: not_finite.points,
                normals_not_finite: not_finite.normals,
                mean_visibility: mean,
                output: self.output.display().to_string(),
            })?;
        } else {
            say!("{}: {} points, mean visibility {mean:.4}", self.output.display(), points.len());
        }
        Ok(Code::Fine)
    }
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
            (_, 0) => crate::note!("warning: {lit}"),
            (0, _) => crate::note!("warning: {plain}"),
            _ => crate::note!("warning: {lit}; {plain}"),
        }
    }
}

fn read_f32_triples(path: &Path, most_bytes: u64) -> Result<Vec<[f64; 3]>, Failure> {
    let triples = read_triples::<4>(path, most_bytes, "float32")?;
    Ok(triples.into_iter().map(|t| t.map(|b| f64::from(f32::from_le_bytes(b)))).collect())
}

fn read_f64_triples(path: &Path, most_bytes: u64) -> Result<Vec<[f64; 3]>, Failure> {
    Ok(read_triples::<8>(path, most_bytes, "float64")?
        .into_iter()
        .map(|t| t.map(f64::from_le_bytes))
        .collect())
}

/// Reads triples of numbers that take `BYTES` bytes each.
fn read_triples<const BYTES: usize>(
    path: &Path,
    most_bytes: u64,
    kind: &str,
) -> Result<Vec<[[u8; BYTES]; 3]>, Failure> {
    let bytes = read_whole(path, most_bytes)?;
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
