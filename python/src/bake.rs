//! Bakes.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use adumbra::{Receivers, Sun};
use adumbra_bake::{AssumeGround, Bake, BakeOptions, DiskCache, FrameChoice, Size};
use adumbra_files::{check_output, folder_of, same_file};
use pyo3::prelude::*;

use crate::axes::world_bounds;
use crate::errors::Failure;
use crate::file::{File, encoding};
use crate::pool::pool;
use crate::scene::Scene;
use crate::watch::watched;

/// The options of a bake, as Python gives them.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Options {
    to_sun: [f64; 3],
    resolution: u64,
    voxel_size: Option<f64>,
    thickness: f64,
    switch_within: u32,
    levels: u32,
    assume_ground: Option<bool>,
    closed_regions: bool,
    receivers: String,
    bounds: Option<([f64; 3], [f64; 3])>,
    frame: String,
    yaw: Option<f64>,
    encoding: String,
    max_memory: Option<u64>,
}

impl Options {
    /// Returns the options of a bake of a scene.
    pub(crate) fn for_bake(&self, scene: &Scene) -> Result<BakeOptions, Failure> {
        let size = self.voxel_size.map_or(Size::Resolution(self.resolution), Size::VoxelSize);
        let frame = match (&*self.frame, self.yaw) {
            ("auto", None) => FrameChoice::Auto,
            ("light", None) => FrameChoice::Light,
            ("oblique", None) => FrameChoice::Oblique,
            ("oblique", Some(degrees)) => FrameChoice::ObliqueAt(degrees.to_radians()),
            ("auto" | "light", Some(_)) => {
                let what = format!("yaw does not apply to frame={:?}; give frame=\"oblique\"", self.frame);
                return Err(Failure::Value(what));
            }
            (other, _) => {
                let what = format!("frame: {other:?} must be \"auto\", \"light\" or \"oblique\"");
                return Err(Failure::Value(what));
            }
        };
        let receivers = match &*self.receivers {
            "all" => Receivers::All,
            "static" => Receivers::Static,
            other => {
                return Err(Failure::Value(format!("receivers: {other:?} must be \"all\" or \"static\"")));
            }
        };
        let encoding = encoding(&self.encoding)?;
        Ok(BakeOptions::new(Sun::from_direction(scene.up().to_scene(self.to_sun))?, size).with(|o| {
            o.frame = frame;
            o.thickness_world = self.thickness;
            o.switch_within_voxels = self.switch_within;
            o.levels = self.levels;
            o.encoding = encoding;
            o.assume_ground = self.assume_ground.map_or(AssumeGround::Auto, AssumeGround::from);
            o.closed_regions = self.closed_regions;
            o.ignore_alpha = scene.ignore_alpha;
            o.receivers = receivers;
            o.bounds = self.bounds.map(|bounds| world_bounds(scene.up(), bounds));
            o.max_memory_bytes = self.max_memory;
        }))
    }
}

/// Bakes a scene, into a file if there is an `output`. `report` is called with the number of finished root
/// blocks and the total.
#[pyfunction]
pub(crate) fn bake(
    py: Python<'_>,
    scene: &Scene,
    options: Options,
    output: Option<PathBuf>,
    cache: Option<PathBuf>,
    threads: Option<usize>,
    report: Option<Py<PyAny>>,
) -> PyResult<File> {
    let options = options.for_bake(scene)?;
    watched(py, report, |watch| {
        if let Some(output) = &output {
            check(scene, output)?;
        }
        let mut bake = Bake::with_options(&scene.scene, &options).watch(watch);
        if let Some(cache) = cache {
            bake = bake.cache(DiskCache::create(cache)?);
        }
        pool(threads)?.install(|| match &output {
            Some(output) => {
                bake.save(output)?;
                File::read_back(output)
            }
            None => {
                let mut bytes = Cursor::new(Vec::new());
                bake.write_to(&mut bytes)?;
                Ok(File::decode(&bytes.into_inner())?)
            }
        })
    })
}

/// Refuses an output that cannot be written.
#[pyfunction]
pub(crate) fn check_path(py: Python<'_>, scene: &Scene, output: PathBuf) -> PyResult<()> {
    watched(py, None, |_| check(scene, &output))
}

/// Refuses an output that cannot be written, and one that would replace the scene or a file that it names.
fn check(scene: &Scene, output: &Path) -> Result<(), Failure> {
    refuse_scene(scene, output)?;
    Ok(check_output(output)?)
}

fn refuse_scene(scene: &Scene, output: &Path) -> Result<(), Failure> {
    let Some(path) = &scene.path else { return Ok(()) };
    let folder = folder_of(path);
    let named = scene.scene.notes.named_files.iter().map(|name| folder.join(name));
    match std::iter::once(path.clone()).chain(named).find(|input| same_file(input, output)) {
        Some(input) => Err(Failure::Value(format!(
            "output {:?} would overwrite {:?}, which is part of the scene; give another path",
            output.display(),
            input.display()
        ))),
        None => Ok(()),
    }
}
