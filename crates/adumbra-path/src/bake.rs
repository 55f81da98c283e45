//! The bake of a path.

use std::io::Cursor;

use adumbra::SunStep;
use adumbra::{Frame, ShadowFile, Sun};
use adumbra_bake::{Bake, BakeOptions, FrameChoice, Size, Watch};
use adumbra_scene::Scene;
use adumbra_truth::trace::{TraceOptions, Tracer};

use crate::error::{Error, Result};
use crate::hidden::dark_after;
use crate::options::PathOptions;
use crate::place::{Candidate, GapError, Placer, Probe};
use crate::visible::{VisiblePoint, seen, visible_points};

/// A key that was baked.
#[derive(Clone, Debug)]
pub struct BakedKey {
    /// Its step, by index.
    pub step: usize,
    /// Its moment.
    pub seconds: f64,
    /// Its shadow file.
    pub bytes: Vec<u8>,
    /// Bytes of the file's words in memory.
    pub raw_bytes: u64,
    /// The error half way between the key before and this one; `None` for the first key of a run, and where
    /// no step is between them.
    pub gap: Option<GapError>,
}

/// A path that was baked.
#[derive(Clone, Debug)]
pub struct BakedPath {
    /// The keys, in the order of time.
    pub keys: Vec<BakedKey>,
    /// Edge of the finest voxels, world units.
    pub voxel_size: f64,
    /// A ray that is hidden from both keys for this many voxels counts as blocked; 0 = never.
    pub dark_after_voxels: u32,
}

/// Bakes keys, all with the same voxels, and compares them with rays.
struct Keys<'a> {
    scene: &'a Scene,
    options: BakeOptions,
    watch: Watch<'a>,
    tracer: Tracer<'a>,
    points: Vec<VisiblePoint>,
    dark_after_voxels: u32,
}

impl Probe for Keys<'_> {
    fn bake(&self, towards_sun: [f64; 3]) -> Result<ShadowFile> {
        let sun = Sun::from_direction(towards_sun)?;
        let options = self.options.clone().with(|o| o.sun = sun);
        let bake = Bake::with_options(self.scene, &options);
        let mut file = bake.watch(self.watch).in_memory()?;
        file.settings.dark_after_voxels = self.dark_after_voxels;
        Ok(file)
    }

    fn seen(&self, towards_sun: [f64; 3]) -> Vec<(VisiblePoint, bool)> {
        seen(&self.tracer, &self.points, towards_sun)
    }
}

/// Bakes a path. Calls `on_key` with each key once it is placed.
///
/// Cost: about two bakes per key, and up to twelve before the first.
///
/// # Errors
/// Returns an error if the sun is never high enough, or a bake fails or is cancelled.
pub fn bake_path(
    scene: &Scene,
    steps: &[SunStep],
    options: &PathOptions,
    watch: Watch<'_>,
    mut on_key: impl FnMut(&BakedKey),
) -> Result<BakedPath> {
    let runs = runs(steps, options.lowest_degrees);
    let highest = runs.iter().flat_map(|&[first, last]| &steps[first..=last]);
    let highest = highest.max_by(|a, b| a.towards_sun[1].total_cmp(&b.towards_sun[1]));
    let Some(highest) = highest else {
        return Err(Error::NoSun { lowest_degrees: options.lowest_degrees });
    };
    let bake_options = on_one_lattice(scene, options, highest.towards_sun, watch)?;
    let voxel_size = match bake_options.size {
        Size::VoxelSize(size) => size,
        Size::Resolution(_) => 0.0,
    };
    let tracer = Tracer::build(scene, TraceOptions { ignore_alpha: options.bake.ignore_alpha });
    let points = visible_points(&tracer, options.points, 1);
    let mut probe = Keys { scene, options: bake_options, watch, tracer, points, dark_after_voxels: 0 };
    probe.dark_after_voxels = dark_after(&probe, steps, &runs)?;
    let placer = Placer { probe: &probe, steps, options };
    let mut keys: Vec<BakedKey> = Vec::new();
    for run in runs {
        placer.place(run, |Candidate { step, file, .. }, gap| {
            let mut bytes = Cursor::new(Vec::new());
            file.write_to(&mut bytes, options.bake.encoding)?;
            let seconds = steps[*step].seconds;
            let raw_bytes = file.encoded_len();
            let key = BakedKey { step: *step, seconds, bytes: bytes.into_inner(), raw_bytes, gap };
            on_key(&key);
            keys.push(key);
            Ok(())
        })?;
    }
    Ok(BakedPath { keys, voxel_size, dark_after_voxels: probe.dark_after_voxels })
}

/// Returns the options of all keys: the voxel size of a bake with this sun, the yaw of the oblique frame, and
/// one level, because marches do not read coarser ones.
fn on_one_lattice(
    scene: &Scene,
    options: &PathOptions,
    towards_sun: [f64; 3],
    watch: Watch<'_>,
) -> Result<BakeOptions> {
    let sun = Sun::from_direction(towards_sun)?;
    let probe = options.bake.clone().with(|o| {
        o.sun = sun;
        o.frame = FrameChoice::Oblique;
        o.levels = 1;
    });
    let bake = Bake::with_options(scene, &probe).watch(watch);
    let grid = bake.in_memory()?.grid;
    let yaw_radians = match grid.frame {
        Frame::Oblique { yaw_radians } => yaw_radians,
        Frame::Light => 0.0,
    };
    let frame = FrameChoice::ObliqueAt(yaw_radians);
    Ok(probe.with(|o| {
        o.frame = frame;
        o.size = Size::VoxelSize(grid.voxel_size);
    }))
}

/// Returns the runs of steps, first and last, in which the sun is high enough.
fn runs(steps: &[SunStep], lowest_degrees: f64) -> Vec<[usize; 2]> {
    let least = lowest_degrees.to_radians().sin();
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for (i, _) in steps.iter().enumerate().filter(|(_, step)| step.towards_sun[1] >= least) {
        match runs.last_mut() {
            Some([_, last]) if *last + 1 == i => *last = i,
            _ => runs.push([i, i]),
        }
    }
    runs
}
