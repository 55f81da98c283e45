//! Forecasts the cost of a bake from a few of its root blocks.

use std::io::Cursor;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use adumbra::file::HEADER_BYTES;
use adumbra::{Encoding, FileSettings, LightGrid};
use adumbra_scene::Scene;

use super::output::{file_writer, write_level};
use crate::choose::Choice;
use crate::error::{Error, Result};
use crate::fast::descent::{DescentBuffers, build_root};
use crate::options::BakeOptions;
use crate::plan::Plan;
use crate::sink::depths::DepthsSink;
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
/// Factors from the forecast bytes to the likely least and most bytes of a bake, see docs/figures.md for the
/// measurements.
const SPREAD_OF_BYTES: [f64; 2] = [0.4, 1.8];
/// Factors from the forecast seconds to the likely least and most.
const SPREAD_OF_SECONDS: [f64; 2] = [0.7, 1.8];
/// Least share of the blocks that are as full as the samples, for the memory.
const LEAST_SHARE_IN_MEMORY: f64 = 0.25;
/// Factor from the forecast memory to the likely most.
const MOST_MEMORY: f64 = 1.7;

/// Draws a few root blocks of each level of the bake for `options`, from the emptiest to the fullest, and
/// extrapolates.
///
/// # Errors
/// Returns the errors of [`Bake::in_memory`](crate::Bake::in_memory). The memory limit applies to the
/// forecast itself, not to the bake that it predicts.
pub(crate) fn estimate(scene: &Scene, options: &BakeOptions, cancel: &AtomicBool) -> Result<Estimate> {
    let start = Instant::now();
    let choice = Choice::new(scene, options, cancel)?;
    let mut sum = Estimate {
        root_blocks: 0,
        sampled_root_blocks: 0,
        seconds: [start.elapsed().as_secs_f64(); 2],
        file_bytes: [HEADER_BYTES as u64; 2],
        memory_bytes: [0; 2],
    };
    for level in 0..choice.levels.len() {
        let start = Instant::now();
        let plan = choice.plan(scene, level)?;
        let planning_seconds = start.elapsed().as_secs_f64();
        let of_level = forecast_level(&plan, options.encoding, cancel)?;
        sum = Estimate {
            root_blocks: sum.root_blocks + of_level.root_blocks,
            sampled_root_blocks: sum.sampled_root_blocks + of_level.sampled_root_blocks,
            seconds: [0, 1].map(|i| sum.seconds[i] + planning_seconds + of_level.seconds[i]),
            file_bytes: [0, 1].map(|i| sum.file_bytes[i] + of_level.file_bytes[i]),
            // One level is baked after the other.
            memory_bytes: [0, 1].map(|i| sum.memory_bytes[i].max(of_level.memory_bytes[i])),
        };
    }
    Ok(sum)
}

/// Forecasts one level: the bytes without the header of the file, the seconds without those of planning.
fn forecast_level(plan: &Plan<'_>, encoding: Encoding, cancel: &AtomicBool) -> Result<Estimate> {
    let (level, depth) = (plan.root_blocks.root_level, plan.root_blocks.grid.size[2]);
    let root_blocks = plan.root_blocks.count();
    let sampled = root_blocks.min(SAMPLES);
    let mut buffers = DescentBuffers::default();
    let mut build = |root_block: usize, sink: &DepthsSink| {
        build_root(&plan.root_blocks, root_block, sink, &mut buffers, cancel)
    };
    // The blocks side by side, as if they were a row of a grid without regions.
    let row = |blocks: usize| [(blocks as u32) << level, 1 << level, depth];
    let settings = FileSettings { region: None, ..plan.settings };
    let bytes = |sink: DepthsSink, blocks: usize| {
        let grid = LightGrid { size: row(blocks), ..plan.root_blocks.grid };
        let mut writer = file_writer(Cursor::new(Vec::new()), settings, &[grid], encoding)?;
        write_level(&mut writer, sink.into_pages(), grid.size, encoding, cancel)?;
        let bytes = writer.finish().map_err(Error::Output)?;
        Ok::<_, Error>((bytes - HEADER_BYTES as u64) as f64)
    };
    let all = DepthsSink::in_memory(row(sampled), level, true);
    // Half of the blocks, as full as all on average, to see how bytes grow with the number of blocks.
    let is_in_half = |number: usize| matches!(number % 4, 0 | 3);
    let in_half = (0..sampled).filter(|&number| is_in_half(number)).count();
    let half = DepthsSink::in_memory(row(in_half), level, true);
    let start = Instant::now();
    let fullness = |root_block| plan.root_blocks.casters.in_bin(root_block).len() as u64;
    let mut built_in_half = 0;
    for (number, root_block) in plan.root_blocks.sampled(sampled, fullness).enumerate() {
        all.taken(number, build(root_block, &all)?);
        if is_in_half(number) {
            half.taken(built_in_half, build(root_block, &half)?);
            built_in_half += 1;
        }
        let held_bytes: u64 =
            [&all, &half].map(|sink| sink.memory_bytes() + sink.result_bytes()).iter().sum();
        let working_bytes = plan.worker_bytes.max(all.finish_bytes());
        plan.check_memory("the forecast", plan.scene_bytes + working_bytes + held_bytes)?;
    }
    let building_seconds = start.elapsed().as_secs_f64() * sampled as f64 / (sampled + in_half) as f64;
    let scale = root_blocks as f64 / sampled as f64;
    let built_bytes = (all.memory_bytes() + all.result_bytes()) as f64;
    let finish_bytes = all.finish_bytes() as f64;
    let half_bytes = bytes(half, in_half)?;
    let start = Instant::now();
    let all_bytes = bytes(all, sampled)?;
    let seconds = scale * (building_seconds + start.elapsed().as_secs_f64()) / plan.workers as f64;
    // Some bytes do not grow with the number of blocks: twice the blocks have less than twice the bytes.
    let growth = (all_bytes - half_bytes) / (sampled - in_half).max(1) as f64;
    let fixed_bytes = (all_bytes - growth * sampled as f64).clamp(0.0, all_bytes);
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
        memory_bytes: [memory_bytes(LEAST_SHARE_IN_MEMORY * scale), MOST_MEMORY * memory_bytes(scale)]
            .map(|bytes| bytes as u64),
    })
}

#[cfg(test)]
mod tests {
    use adumbra::{Encoding, Sun};
    use adumbra_scene::{GeneratedKind, LoadOptions, Scene, generate, load};
    use adumbra_testing::{full, scene_file, shared};

    use crate::{Bake, BakeOptions, Size};

    /// Checks that a forecast contains what the bake takes, and prints both. Seconds are not checked, because
    /// they depend on what else the machine does.
    fn check(name: &str, scene: &Scene, options: &BakeOptions) {
        let bake = Bake::with_options(scene, options);
        let forecast = bake.estimate().expect("a good forecast");
        let (file, report) = bake.in_memory_with_report().expect("a good bake");
        let found =
            [file.to_bytes(options.encoding).expect("a good file").len() as u64, report.accounted_bytes];
        let case = format!("{name}, {:?}, {:?}", options.size, options.encoding);
        println!("{case}: {found:?} bytes, {:.2} s; {forecast:?}", report.seconds);
        assert_eq!(forecast.root_blocks, report.root_blocks, "{case}");
        assert!(forecast.sampled_root_blocks <= report.root_blocks / 4, "{case}");
        for (found, [least, most]) in found.into_iter().zip([forecast.file_bytes, forecast.memory_bytes]) {
            assert!((least..=most).contains(&found), "{case}: {found} in {forecast:?}");
            assert!(most / least < 7, "{case}: {forecast:?}");
        }
    }

    fn options(resolution: u64, encoding: Encoding) -> BakeOptions {
        let sun = Sun::from_angles(130.0, 40.0).expect("above the horizon");
        BakeOptions { encoding, ..BakeOptions::new(sun, Size::Resolution(resolution)) }
    }

    #[test]
    fn forecast_contains_what_the_bake_takes() {
        for kind in [GeneratedKind::SphereGrid, GeneratedKind::Wires] {
            for encoding in [Encoding::Coded, Encoding::Raw] {
                check(&format!("{kind:?}"), &generate(kind, 1), &options(1024, encoding));
            }
        }
    }

    #[test]
    #[ignore = "slow: bakes fourteen scenes several times"]
    fn forecasts_of_real_scenes_contain_what_bakes_take() {
        let Some(folder) = shared("scenes") else { return };
        let names = [
            "alpine-2",
            "auster",
            "delft",
            "dragon_202k",
            "jacksboro",
            "oak_medium",
            "street-1",
            "teapot",
            "zdm2",
        ];
        let real = names.map(|name| {
            (
                name.to_owned(),
                load(&scene_file(&folder, name), &LoadOptions::default()).expect("a good scene"),
            )
        });
        let kinds = [
            GeneratedKind::Ball,
            GeneratedKind::City,
            GeneratedKind::Landscape,
            GeneratedKind::Spheres,
            GeneratedKind::Wires,
        ];
        let generated = kinds.map(|kind| (format!("{kind:?}"), generate(kind, 1)));
        let resolutions: &[u64] = if full() { &[1024, 4096, 16_384] } else { &[1024, 4096] };
        for (name, scene) in real.iter().chain(&generated) {
            for &resolution in resolutions {
                for encoding in [Encoding::Coded, Encoding::Raw] {
                    check(name, scene, &options(resolution, encoding));
                }
            }
        }
    }
}
