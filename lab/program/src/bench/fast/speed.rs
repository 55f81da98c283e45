//! Look-ups per second on one core.

use std::path::Path;
use std::time::Instant;

use adumbra::{Filter, ShadowFile};
use adumbra_program::scene::load_scene;
use adumbra_scene::LoadOptions;
use adumbra_truth::trace::{Ray, TraceOptions, Tracer};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use adumbra_compare::Result;

const FILTER: Filter = Filter::Box9;
/// Points per row, and number of rows.
const POINTS: [u32; 2] = [2000, 1000];
/// Spacing of the points in texels.
const STEPS_TEXELS: [f64; 3] = [1.0, 4.0, 0.25];
/// Number of timed runs, of which the median counts.
const RUNS: usize = 3;

/// The results for rows of points at one spacing.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct Scan {
    /// Distance between neighbouring points in texels.
    pub(super) step_texels: f64,
    /// Number of points.
    pub(super) points: usize,
    /// Look-ups per second, the median of the runs.
    pub(super) points_per_second: f64,
    /// Mean visibility of the points.
    pub(super) mean_visibility: f64,
}

/// Times look-ups, with normals, at the surface points seen from straight above around the middle of the
/// scene.
///
/// The points are visited row by row.
pub(super) fn measure(file: &Path, scene: &Path) -> Result<Vec<Scan>> {
    let scene = load_scene(scene, &LoadOptions::default())?;
    let tracer = Tracer::build(&scene, TraceOptions { ignore_alpha: false });
    let bounds = scene.bounds();
    let file = ShadowFile::read(file)?;
    let sampler = file.sampler(FILTER);
    let middle = [0, 2].map(|a| 0.5 * (bounds.min[a] + bounds.max[a]));
    let scan = |step_texels: f64| -> Result<Scan> {
        let step = step_texels * file.grid.voxel_size;
        let place = |n: u32, of: u32| (f64::from(n) - 0.5 * f64::from(of)) * step;
        let [across, down] = POINTS;
        let seen = |at: u32| {
            let (x, z) = (place(at % across, across), place(at / across, down));
            let origin = [middle[0] + x, bounds.max[1] + 1.0, middle[1] + z];
            let ray = Ray { origin, direction: [0.0, -1.0, 0.0], t_min: 0.0, t_max: f64::INFINITY };
            let hit = tracer.nearest_surface(&ray)?;
            let normal = if hit.front { hit.normal } else { hit.normal.map(|c| -c) };
            Some(([origin[0], origin[1] - hit.t, origin[2]], normal))
        };
        let (points, normals): (Vec<_>, Vec<_>) = (0..across * down).into_par_iter().filter_map(seen).unzip();
        let mut visibilities = vec![0.0; points.len()];
        let mut seconds = Vec::with_capacity(RUNS);
        for _ in 0..RUNS {
            let start = Instant::now();
            sampler.visibilities(&points, Some(&normals), &mut visibilities)?;
            seconds.push(start.elapsed().as_secs_f64());
        }
        seconds.sort_unstable_by(f64::total_cmp);
        let count = points.len() as f64;
        Ok(Scan {
            step_texels,
            points: points.len(),
            points_per_second: count / seconds[RUNS / 2],
            mean_visibility: visibilities.into_iter().map(f64::from).sum::<f64>() / count,
        })
    };
    STEPS_TEXELS.into_iter().map(scan).collect()
}
