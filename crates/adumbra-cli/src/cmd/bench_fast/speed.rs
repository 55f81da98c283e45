//! Look-ups a second of one core.

use std::path::Path;
use std::time::Instant;

use adumbra::format::ShadowFile;
use adumbra::query::{Cursor, Query};
use adumbra::scene::LoadOptions;
use serde::Serialize;

use crate::cmd::load_scene;
use crate::exit::Failure;

const FILTER: u32 = 9;
/// Points of a row, and rows.
const POINTS: [u32; 2] = [2000, 1000];
/// Metres above the lowest point of the scene, and texels from point to point.
const LEVELS: [(f64, f64); 4] = [(0.0, 1.0), (6.0, 1.0), (0.0, 4.0), (0.0, 0.25)];
/// Of which the middle one counts.
const RUNS: usize = 3;

/// Points of one level in rows.
#[derive(Serialize)]
pub(super) struct Level {
    pub(super) height_world: f64,
    pub(super) step_texels: f64,
    pub(super) points_per_second: f64,
    pub(super) mean_visibility: f64,
}

/// Answers points on levels round the middle of the scene, row after row, normals up.
pub(super) fn measure(file: &Path, scene: &Path) -> Result<Vec<Level>, Failure> {
    let bounds = load_scene(scene, &LoadOptions::default())?.bounds();
    let file = ShadowFile::read(file)?;
    let query = Query::new(&file.grid, file.slabs(), file.settings.bias, FILTER)?;
    let middle = [0, 2].map(|a| 0.5 * (bounds.min[a] + bounds.max[a]));
    let level = |(height_world, step_texels): (f64, f64)| {
        let step = step_texels * file.grid.voxel_size;
        let place = |n: u32, of: u32| (f64::from(n) - 0.5 * f64::from(of)) * step;
        let [across, down] = POINTS;
        let mut points = Vec::with_capacity((across * down) as usize);
        for row in 0..down {
            let z = middle[1] + place(row, down);
            points
                .extend((0..across).map(|n| [middle[0] + place(n, across), bounds.min[1] + height_world, z]));
        }
        let mut seconds = Vec::with_capacity(RUNS);
        let mut sum = 0.0;
        for _ in 0..RUNS {
            let start = Instant::now();
            let mut cursor = Cursor::new(query);
            sum = points.iter().map(|&p| f64::from(cursor.visibility(p, Some([0.0, 1.0, 0.0])))).sum();
            seconds.push(start.elapsed().as_secs_f64());
        }
        seconds.sort_unstable_by(f64::total_cmp);
        let count = points.len() as f64;
        Level {
            height_world,
            step_texels,
            points_per_second: count / seconds[RUNS / 2],
            mean_visibility: sum / count,
        }
    };
    Ok(LEVELS.map(level).into())
}
