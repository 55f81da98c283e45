//! Forecasts the cost of a bake from a few of its root blocks.

use std::io::Cursor;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use adumbra::file::HEADER_BYTES;
use adumbra::{Encoding, LightGrid};
use adumbra_scene::Scene;

use super::output::{file_writer, write_level};
use crate::choose::Choice;
use crate::error::{Error, Result};
use crate::fast::descent::{DescentBuffers, build_root};
use crate::options::BakeOptions;
use crate::plan::Plan;
use crate::sink::depths::DepthsSink;
use crate::sink::limit::LimitSink;
use crate::sink::{BlockSink, Structure};

/// A forecast of a bake. Ranges are `[likely low, likely high]`.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    /// Number of root blocks of all levels.
    pub root_blocks: usize,
    /// Number of root blocks that were drawn for the forecast.
    pub sampled_root_blocks: usize,
    /// Wall-clock seconds on the current thread pool.
    pub seconds: [f64; 2],
    /// Size of the file in bytes.
    pub file_bytes: [u64; 2],
    /// Peak of the bytes that the bake would account for.
    pub memory_bytes: [u64; 2],
}

/// Number of root blocks drawn for a forecast, of each level.
const SAMPLES: usize = 48;
/// Factors from the forecast bytes to the likely least and most bytes of a bake. Measured: 0.43 to 1.61, see
/// docs/figures.md.
const SPREAD_OF_BYTES: [f64; 2] = [0.4, 1.7];
/// Factors from the forecast seconds to the likely least and most. Measured: 0.76 to 1.73.
const SPREAD_OF_SECONDS: [f64; 2] = [0.7, 1.8];
/// Least share of the blocks whose bytes are in memory at the peak, if equal pages are kept once.
const LEAST_SHARE_IN_MEMORY: f64 = 0.25;
/// Factor from the forecast memory to the likely most.
const MEMORY_MARGIN: f64 = 1.1;

/// Draws a few root blocks of each level of the bake for `options`, from the emptiest to the fullest, and
/// extrapolates.
///
/// # Errors
/// Returns the errors of [`Bake::in_memory`](crate::Bake::in_memory). The memory limit applies to the
/// forecast itself, not to the bake that it predicts.
pub(crate) fn estimate(scene: &Scene, options: &BakeOptions, cancel: &AtomicBool) -> Result<Estimate> {
    let start = Instant::now();
    let choice = Choice::new(scene, options, cancel)?;
    let planning_seconds = start.elapsed().as_secs_f64();
    let mut sum = Estimate {
        root_blocks: 0,
        sampled_root_blocks: 0,
        seconds: [planning_seconds; 2],
        file_bytes: [HEADER_BYTES as u64; 2],
        memory_bytes: [0; 2],
    };
    for level in 0..choice.levels.len() {
        let of_level = forecast_level(&choice.plan(scene, level)?, options.encoding, cancel)?;
        sum = Estimate {
            root_blocks: sum.root_blocks + of_level.root_blocks,
            sampled_root_blocks: sum.sampled_root_blocks + of_level.sampled_root_blocks,
            seconds: [0, 1].map(|i| sum.seconds[i] + of_level.seconds[i]),
            file_bytes: [0, 1].map(|i| sum.file_bytes[i] + of_level.file_bytes[i]),
            // One level is baked after the other.
            memory_bytes: [0, 1].map(|i| sum.memory_bytes[i].max(of_level.memory_bytes[i])),
        };
    }
    Ok(sum)
}

/// Forecasts one level: the bytes without the header of the file, the seconds without those of the choice of
/// grids.
fn forecast_level(plan: &Plan<'_>, encoding: Encoding, cancel: &AtomicBool) -> Result<Estimate> {
    let (level, depth) = (plan.root_blocks.root_level, plan.root_blocks.grid.size[2]);
    let root_blocks = plan.root_blocks.count();
    let sampled = root_blocks.min(SAMPLES);
    let mut buffers = DescentBuffers::default();
    let mut build = |root_block: usize, sink: &DepthsSink| {
        let sink = LimitSink { limit: plan.switch_limit(), sink };
        build_root(&plan.root_blocks, root_block, &sink, &mut buffers, cancel)
    };
    // The blocks side by side, as if they were a row of the grid.
    let row = |blocks: usize| [(blocks as u32) << level, 1 << level, depth];
    let bytes = |sink: DepthsSink, blocks: usize| {
        let grid = LightGrid { size: row(blocks), ..plan.root_blocks.grid };
        let mut writer = file_writer(Cursor::new(Vec::new()), plan.settings, &[grid], encoding)?;
        write_level(&mut writer, sink.into_pages(), grid.size, encoding, cancel)?;
        let bytes = writer.finish().map_err(Error::Output)?;
        Ok::<_, Error>((bytes - HEADER_BYTES as u64) as f64)
    };
    let all = DepthsSink::in_memory(row(sampled), level, true);
    // Every other block, to see how bytes grow with the number of blocks.
    let half = sampled.div_ceil(2);
    let every_other = DepthsSink::in_memory(row(half), level, true);
    let start = Instant::now();
    let fullness = |root_block| plan.root_blocks.casters.in_bin(root_block).len() as u64;
    for (number, root_block) in plan.root_blocks.sampled(sampled, fullness).enumerate() {
        all.taken(number, build(root_block, &all)?);
        if number % 2 == 0 {
            every_other.taken(number / 2, build(root_block, &every_other)?);
        }
        let held_bytes =
            plan.scene_bytes + plan.worker_bytes + all.memory_bytes() + every_other.memory_bytes();
        plan.check_memory("the forecast", held_bytes)?;
    }
    let built = (sampled + half) as f64;
    let seconds = start.elapsed().as_secs_f64() / built * root_blocks as f64 / plan.workers as f64;
    let scale = root_blocks as f64 / sampled as f64;
    let [built_bytes, finish_bytes] = [all.memory_bytes(), all.finish_bytes()].map(|bytes| bytes as f64);
    let half_bytes = bytes(every_other, half)?;
    let all_bytes = bytes(all, sampled)?;
    // Some bytes do not grow with the number of blocks: twice the blocks have less than twice the bytes.
    let fixed_bytes = (2.0 * half_bytes - all_bytes).max(0.0);
    let file_bytes = fixed_bytes + scale * (all_bytes - fixed_bytes);
    // The peak is either while root blocks are built, or after the last one.
    let memory_bytes = |scale: f64| {
        let building = plan.baking_bytes() as f64 + scale * built_bytes;
        building.max(plan.scene_bytes as f64 + scale * (built_bytes + finish_bytes))
    };
    Ok(Estimate {
        root_blocks,
        sampled_root_blocks: sampled,
        seconds: SPREAD_OF_SECONDS.map(|spread| spread * seconds),
        file_bytes: SPREAD_OF_BYTES.map(|spread| (spread * file_bytes) as u64),
        memory_bytes: [memory_bytes(LEAST_SHARE_IN_MEMORY * scale), MEMORY_MARGIN * memory_bytes(scale)]
            .map(|bytes| bytes as u64),
    })
}

#[cfg(test)]
mod tests {
    use adumbra::{Encoding, Sun};
    use adumbra_scene::{GeneratedKind, generate};

    use crate::{Bake, BakeOptions, Size};

    #[test]
    fn forecast_contains_what_the_bake_takes() {
        let sun = Sun::from_direction([-0.45, 0.75, -0.35]).unwrap();
        for kind in [GeneratedKind::Primitives, GeneratedKind::Wires] {
            let scene = generate(kind, 1);
            for encoding in [Encoding::Coded, Encoding::Raw] {
                let options = BakeOptions { encoding, ..BakeOptions::new(sun, Size::Resolution(1024)) };
                let bake = Bake::with_options(&scene, &options);
                let forecast = bake.estimate().unwrap();
                let (file, report) = bake.in_memory_with_report().unwrap();
                assert!(file.level_count() > 1);
                assert_eq!(forecast.root_blocks, report.root_blocks);
                assert!(forecast.sampled_root_blocks <= report.root_blocks / 4);
                let bytes = file.to_bytes(encoding).unwrap().len() as u64;
                for (what, found, [least, most]) in [
                    ("file", bytes, forecast.file_bytes),
                    ("memory", report.accounted_bytes, forecast.memory_bytes),
                ] {
                    assert!(
                        (least..=most).contains(&found),
                        "{kind:?}, {encoding:?}, {what}: {found} {forecast:?}"
                    );
                    assert!(most / least < 6, "{kind:?}, {encoding:?}, {what}: {forecast:?}");
                }
            }
        }
    }
}
