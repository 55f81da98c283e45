//! Look-ups a second of one core.

use std::path::Path;
use std::time::Instant;

use adumbra::format::ShadowFile;
use adumbra::query::{Cursor, Query};
use adumbra::scene::LoadOptions;
use adumbra::trace::{Ray, TraceOptions, Tracer};
use rayon::prelude::*;
use serde::Serialize;

use crate::cmd::load_scene;
use crate::exit::Failure;

const FILTER: u32 = 9;
/// Points of a row, and rows.
const POINTS: [u32; 2] = [2000, 1000];
/// Texels from point to point.
const STEPS_TEXELS: [f64; 3] = [1.0, 4.0, 0.25];
/// Of which the middle one counts.
const RUNS: usize = 3;

/// Points in rows, so far from each other.
#[derive(Serialize)]
pub(super) struct Scan {
    pub(super) step_texels: f64,
    pub(super) points: usize,
    pub(super) points_per_second: f64,
    pub(super) mean_visibility: f64,
}

/// Answers what is seen from straight above round the middle of the scene, row after row, with its normals.
pub(super) fn measure(file: &Path, scene: &Path) -> Result<Vec<Scan>, Failure> {
    let scene = load_scene(scene, &LoadOptions::default())?;
    let tracer = Tracer::build(&scene, TraceOptions { ignore_alpha: false });
    let bounds = scene.bounds();
    let file = ShadowFile::read(file)?;
    let query = Query::new(&file.grid, file.slabs(), file.settings.bias, FILTER)?;
    let middle = [0, 2].map(|a| 0.5 * (bounds.min[a] + bounds.max[a]));
    let scan = |step_texels: f64| {
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
        let points: Vec<_> = (0..across * down).into_par_iter().filter_map(seen).collect();
        let mut seconds = Vec::with_capacity(RUNS);
        let mut sum = 0.0;
        for _ in 0..RUNS {
            let start = Instant::now();
            let mut cursor = Cursor::new(query);
            sum = points.iter().map(|&(p, normal)| f64::from(cursor.visibility(p, Some(normal)))).sum();
            seconds.push(start.elapsed().as_secs_f64());
        }
        seconds.sort_unstable_by(f64::total_cmp);
        let count = points.len() as f64;
        Scan {
            step_texels,
            points: points.len(),
            points_per_second: count / seconds[RUNS / 2],
            mean_visibility: sum / count,
        }
    };
    Ok(STEPS_TEXELS.map(scan).into())
}
