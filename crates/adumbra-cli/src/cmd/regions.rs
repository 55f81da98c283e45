//! Manifests of regions in place of shadow files: in `query`, `verify` and `info`.

use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

use adumbra::regions::{RegionSampler, Regions};
use adumbra::{Filter, Frame, IoError, Region};
use adumbra_program::exit::Failure;
use adumbra_program::lookup::LookupArgs;
use adumbra_program::output::format_bytes;
use adumbra_program::{mirrors, say};
use schemars::JsonSchema;
use serde::Serialize;

/// Reads the manifest at `path`. `None` if the file is not one: JSON begins with a brace, shadow files do
/// not.
pub(super) fn manifest(path: &Path) -> Result<Option<Regions>, Failure> {
    let mut first = [0];
    let read = File::open(path).and_then(|mut file| file.read(&mut first));
    if read.map_err(IoError::at("read", path))? == 0 || first != *b"{" {
        return Ok(None);
    }
    Ok(Some(Regions::read(path)?))
}

/// Returns the look-ups of a world. Only the finest level has them.
pub(super) fn sampler(
    regions: &Regions,
    path: &Path,
    lookup: &LookupArgs,
    level: u32,
) -> Result<RegionSampler, Failure> {
    if level != 0 {
        return Err(Failure::Usage(format!(
            "--level {level}: {} is a manifest, and look-ups in regions are of level 0; give a region's file",
            path.display()
        )));
    }
    let sampler = regions.sampler(path, Filter::try_from(lookup.filter)?)?;
    match sampler.settings().map(|settings| settings.bias) {
        Some(own) => Ok(sampler.with_bias(lookup.bias.over(own)?)?),
        None => Ok(sampler),
    }
}

/// Returns the bytes of all files.
fn file_bytes(regions: &Regions, path: &Path) -> u64 {
    let folder = adumbra_files::folder_of(path);
    let bytes = |(_, name): (Region, &str)| fs::metadata(folder.join(name)).map_or(0, |file| file.len());
    regions.iter().map(bytes).sum()
}

/// What a manifest contains.
#[derive(Serialize, JsonSchema)]
pub(super) struct ManifestInfo {
    /// The manifest.
    file: String,
    /// Length of all regions' files, in bytes.
    file_bytes: u64,
    /// How the grids lie in the world.
    #[schemars(with = "mirrors::Frame")]
    frame: Frame,
    /// Unit vector towards the sun.
    sun: [f64; 3],
    /// Edge of a voxel, world units.
    voxel_size: f64,
    /// Texels a side of a region.
    region_texels: u32,
    /// The regions, in rows.
    regions: Vec<RegionInfo>,
}

/// A region of a world.
#[derive(Serialize, JsonSchema)]
pub(super) struct RegionInfo {
    /// Number along the grid's x.
    x: i32,
    /// Number along the grid's y.
    y: i32,
    /// Its shadow file, from the manifest's folder.
    file: String,
    /// World position of its origin, to which positions in its file are relative.
    origin: [f64; 3],
    /// Length of its file, in bytes. Null if it is not there.
    file_bytes: Option<u64>,
}

impl ManifestInfo {
    /// Describes the manifest at `path`.
    pub(super) fn of(regions: &Regions, path: &Path) -> Self {
        let folder = adumbra_files::folder_of(path);
        let region = |(region, name): (Region, &str)| RegionInfo {
            x: region.x,
            y: region.y,
            file: name.to_owned(),
            origin: regions.origin(region),
            file_bytes: fs::metadata(folder.join(name)).ok().map(|file| file.len()),
        };
        Self {
            file: path.display().to_string(),
            file_bytes: file_bytes(regions, path),
            frame: regions.frame(),
            sun: regions.sun().towards(),
            voxel_size: regions.voxel_size(),
            region_texels: regions.texels(),
            regions: regions.iter().map(region).collect(),
        }
    }

    /// Prints the description.
    pub(super) fn print(&self) {
        let [x, y, z] = self.sun;
        say!("{}: {} regions, {}", self.file, self.regions.len(), format_bytes(self.file_bytes));
        say!("  sun towards     {x:.6}, {y:.6}, {z:.6}");
        say!("  frame           {}", self.frame.name());
        say!("  regions         {} texels of {} a side", self.region_texels, self.voxel_size);
        for RegionInfo { x, y, file, origin: [ox, oy, oz], file_bytes } in &self.regions {
            let size = file_bytes.map_or_else(|| "not there".to_owned(), format_bytes);
            say!("  ({x}, {y})  {file}: {size}, origin {ox:.3}, {oy:.3}, {oz:.3}");
        }
    }
}
