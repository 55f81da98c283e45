//! Worlds that are too wide for one file: a lattice of regions with a file each, and a manifest that names
//! them. `spec/adumbra-regions.md` specifies the manifest for readers in other languages.

mod manifest;
mod sampler;

pub use sampler::RegionSampler;

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::error::{Error, IoError, Result};
use crate::file::{FileMemory, ShadowFile};
use crate::grid::{Frame, LightGrid, Region, Sun};
use crate::query::Filter;

/// Most bytes of a manifest. A region takes a hundred.
const MOST_BYTES: u64 = 64 << 20;

/// A manifest: the regions of a world, and the path of each region's file.
#[derive(Clone, Debug, PartialEq)]
pub struct Regions {
    /// A grid of one voxel at the world's origin, with the axes and the voxel size of all regions.
    grid: LightGrid,
    texels: u32,
    /// Path of each region's file, from the manifest's folder.
    files: BTreeMap<Region, String>,
}

impl Regions {
    /// Creates the manifest of a world. Each region has the path of its file from the manifest's folder, with
    /// slashes; no region may be given twice, and all must have the same side.
    ///
    /// # Errors
    /// Returns what is wrong as a clause.
    pub fn new(
        sun: Sun,
        frame: Frame,
        voxel_size: f64,
        texels: u32,
        regions: impl IntoIterator<Item = (Region, String)>,
    ) -> Result<Self, String> {
        let grid = LightGrid::new(sun, frame, voxel_size, [0.0; 3], [1; 3]);
        let mut files = BTreeMap::new();
        for (region, file) in regions {
            let Region { x, y, .. } = region;
            if region.texels != texels {
                return Err(format!("region ({x}, {y}) has {} texels a side, not {texels}", region.texels));
            }
            if files.insert(region, file).is_some() {
                return Err(format!("region ({x}, {y}) is there twice"));
            }
        }
        let regions = Self { grid, texels, files };
        regions.check()?;
        Ok(regions)
    }

    /// Reads the manifest at `path`.
    ///
    /// # Errors
    /// Returns [`Error::Io`] if the file cannot be read, and [`Error::Manifest`] if it is not a manifest, or
    /// has more than 64 MiB.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let mut bytes = Vec::new();
        File::open(path)
            .and_then(|file| file.take(MOST_BYTES + 1).read_to_end(&mut bytes))
            .map_err(IoError::at("read", path))?;
        let regions = match bytes.len() as u64 {
            0..=MOST_BYTES => Self::from_json(&bytes),
            _ => Err(format!("it has more than {MOST_BYTES} bytes")),
        };
        regions.map_err(|what| Error::Manifest { path: path.to_owned(), what })
    }

    /// Returns the sun.
    pub fn sun(&self) -> Sun {
        self.grid.sun
    }

    /// Returns the orientation of the grid in the world.
    pub fn frame(&self) -> Frame {
        self.grid.frame
    }

    /// Returns the edge of a voxel of the finest level, in world units.
    pub fn voxel_size(&self) -> f64 {
        self.grid.voxel_size
    }

    /// Returns the texels on a side of each region, at the finest level.
    pub fn texels(&self) -> u32 {
        self.texels
    }

    /// Returns the regions and the paths of their files, from the manifest's folder. They are in rows.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (Region, &str)> {
        self.files.iter().map(|(region, file)| (*region, file.as_str()))
    }

    /// Returns the region of a point, and the path of its file. `None` where there is no region; everything
    /// is lit there.
    pub fn at(&self, p_world: [f64; 3]) -> Option<(Region, &str)> {
        let region = Region::containing(&self.grid, self.texels, p_world);
        self.files.get(&region).map(|file| (region, file.as_str()))
    }

    /// Returns the world position of a region's origin. The region's file has positions relative to it.
    pub fn origin(&self, region: Region) -> [f64; 3] {
        region.origin(&self.grid)
    }

    /// Returns the memory that the files of all regions take together. `manifest` is the path that the
    /// manifest was read from.
    ///
    /// # Errors
    /// Returns the errors of [`ShadowFile::memory`].
    #[doc(hidden)]
    pub fn memory(&self, manifest: impl AsRef<Path>) -> Result<FileMemory> {
        let manifest = manifest.as_ref();
        let memory = |name: &String| ShadowFile::memory(path_of(manifest, name));
        self.files.values().map(memory).try_fold(FileMemory::default(), |all, file| Ok(all.then(file?)))
    }

    /// Reads the files of all regions, and returns look-ups in them. `manifest` is the path that the manifest
    /// was read from.
    ///
    /// Cost: the memory of all files. An engine opens only the files near its camera instead.
    ///
    /// # Errors
    /// Returns the errors of [`ShadowFile::read`], and [`Error::Manifest`] for a file that belongs to another
    /// region.
    pub fn sampler(&self, manifest: impl AsRef<Path>, filter: Filter) -> Result<RegionSampler> {
        RegionSampler::new(self, manifest.as_ref(), filter)
    }

    /// Reads the file of a region. `manifest` is the path that the manifest was read from.
    ///
    /// # Errors
    /// Returns the errors of [`ShadowFile::read`], and [`Error::Manifest`] for a file that belongs to another
    /// region.
    pub fn file(&self, manifest: impl AsRef<Path>, region: Region) -> Result<ShadowFile> {
        let manifest = manifest.as_ref();
        let refuse = |what: String| Error::Manifest { path: manifest.to_owned(), what };
        let Some(name) = self.files.get(&region) else {
            return Err(refuse(format!("it has no region ({}, {})", region.x, region.y)));
        };
        let file = ShadowFile::read(path_of(manifest, name))?;
        let in_world = file.clone().in_world().grid;
        let first = region.first_texel();
        let covers = (0..2).all(|a| {
            let end = first[a] + f64::from(self.texels);
            in_world.corner[a] <= first[a] && end <= in_world.corner[a] + f64::from(in_world.size[a])
        });
        let grid = LightGrid { corner: in_world.corner, size: in_world.size, ..self.grid };
        if file.settings.region != Some(region) || in_world != grid || !covers {
            let of = file.settings.region.map_or_else(
                || "no region".to_owned(),
                |Region { x, y, texels }| format!("region ({x}, {y}) of {texels} texels"),
            );
            let (sun, voxel) = (in_world.sun.towards(), in_world.voxel_size);
            return Err(refuse(format!(
                "{name} is not the file of region ({}, {}): it is of {of}, the sun {sun:?} and voxels of {voxel}; bake the regions again",
                region.x, region.y
            )));
        }
        Ok(file)
    }
}

/// Returns the path of a region's file from its name in a manifest.
fn path_of(manifest: &Path, name: &str) -> PathBuf {
    manifest.parent().map_or_else(|| PathBuf::from(name), |folder| folder.join(name))
}
