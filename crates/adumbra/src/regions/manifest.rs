//! The manifest as JSON. It has the axes and origins, which engines need for a look-up. They must agree with
//! the sun, the frame and the voxel size, from which they follow.

use std::path::{Component, Path};

use serde::{Deserialize, Serialize};

use super::Regions;
use crate::file::fields::sun as stored_sun;
use crate::file::placement::check_grid;
use crate::grid::{Frame, Region};

const FORMAT: &str = "adumbra regions 1";
/// Tolerance for numbers that follow from others, relative to their size or to 1.
const TOLERANCE: f64 = 1e-9;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Manifest {
    format: String,
    sun: [f64; 3],
    frame: Frame,
    voxel_size: f64,
    region_texels: u32,
    axes: [[f64; 3]; 2],
    regions: Vec<Entry>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    x: i32,
    y: i32,
    file: String,
    origin: [f64; 3],
}

impl Regions {
    /// Returns the manifest as JSON. The same manifest gives the same text.
    pub fn to_json(&self) -> String {
        let entry = |(&region, file): (&Region, &String)| Entry {
            x: region.x,
            y: region.y,
            file: file.clone(),
            origin: region.origin(&self.grid),
        };
        let [x, y, _] = self.grid.axes;
        let manifest = Manifest {
            format: FORMAT.to_owned(),
            sun: self.grid.sun.towards(),
            frame: self.grid.frame,
            voxel_size: self.grid.voxel_size,
            region_texels: self.texels,
            axes: [x, y],
            regions: self.files.iter().map(entry).collect(),
        };
        let mut text = serde_json::to_string_pretty(&manifest).unwrap_or_default();
        text.push('\n');
        text
    }

    /// Reads a manifest.
    ///
    /// # Errors
    /// Returns what is wrong, as a clause.
    pub fn from_json(bytes: &[u8]) -> Result<Self, String> {
        let manifest: Manifest = serde_json::from_slice(bytes).map_err(|e| e.to_string())?;
        let Manifest { format, sun, frame, voxel_size, region_texels, axes, regions } = manifest;
        if format != FORMAT {
            return Err(format!("its format is \"{format}\", not \"{FORMAT}\""));
        }
        let sun = stored_sun(sun).map_err(|fault| fault.to_string())?;
        let files = regions.iter().map(|&Entry { x, y, ref file, .. }| {
            let region = Region { x, y, texels: region_texels };
            (region, file.clone())
        });
        let read = Self::new(sun, frame, voxel_size, region_texels, files)?;
        let fits = |found: &[f64], expected: &[f64]| {
            let near = |(a, b): (&f64, &f64)| (a - b).abs() <= TOLERANCE * (1.0 + b.abs());
            found.iter().zip(expected).all(near)
        };
        if !fits(axes.as_flattened(), read.grid.axes[..2].as_flattened()) {
            return Err("its axes are not those of its sun and frame".to_owned());
        }
        for Entry { x, y, origin, .. } in &regions {
            let region = Region { x: *x, y: *y, texels: region_texels };
            if !fits(origin, &region.origin(&read.grid)) {
                return Err(format!("the origin of region ({x}, {y}) is not where the region is"));
            }
        }
        Ok(read)
    }

    /// Checks everything that does not depend on the JSON text.
    pub(super) fn check(&self) -> Result<(), String> {
        let Self { grid, texels, files } = self;
        check_grid(grid).map_err(|fault| fault.to_string())?;
        Region::check_texels(*texels).map_err(|error| error.to_string())?;
        let plain = |file: &&String| {
            let mut parts = Path::new(file).components();
            !file.contains('\\') && !file.is_empty() && parts.all(|part| matches!(part, Component::Normal(_)))
        };
        match files.values().find(|file| !plain(file)) {
            Some(file) => Err(format!("the file \"{file}\" is not in the manifest's folder or below")),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Sun;

    fn world() -> Regions {
        let sun = Sun::from_angles(200.0, 30.0).unwrap();
        let frame = Frame::Oblique { yaw_radians: 0.3 };
        let region = |x, y| (Region { x, y, texels: 4096 }, format!("w/{x}_{y}.adumbra"));
        Regions::new(sun, frame, 0.01, 4096, [region(2, -1), region(-3, 0), region(0, -1)]).unwrap()
    }

    #[test]
    fn manifests_round_trip() {
        let world = world();
        let text = world.to_json();
        assert_eq!(Regions::from_json(text.as_bytes()).unwrap(), world);
        let rows: Vec<_> = world.iter().map(|(region, _)| (region.x, region.y)).collect();
        assert_eq!(rows, [(0, -1), (2, -1), (-3, 0)]);
        let light = Regions::new(world.sun(), Frame::Light, 0.5, 1024, []).unwrap();
        assert_eq!(Regions::from_json(light.to_json().as_bytes()).unwrap(), light);
    }

    #[test]
    fn rejects_invalid_manifests_with_reason() {
        let text = world().to_json();
        for (from, to, what) in [
            ("regions 1", "regions 2", "its format"),
            ("\"region_texels\": 4096", "\"region_texels\": 3000", "the side of a region: 3000"),
            ("\"region_texels\": 4096", "\"region_texels\": 2048", "the origin of region (0, -1)"),
            ("\"voxel_size\": 0.01", "\"voxel_size\": 0", "voxel_size"),
            ("\"yaw_radians\": 0.3", "\"yaw_radians\": 0.4", "its axes"),
            ("\"x\": 2", "\"x\": 0", "twice"),
            ("w/2_-1", "../2_-1", "not in the manifest's folder"),
            ("w/2_-1", "/2_-1", "not in the manifest's folder"),
            ("w/2_-1.adumbra", "", "not in the manifest's folder"),
            ("\"regions\"", "\"more\": 1, \"regions\"", "unknown field"),
        ] {
            let wrong = text.replacen(from, to, 1);
            assert_ne!(wrong, text, "{from}");
            let error = Regions::from_json(wrong.as_bytes()).unwrap_err();
            assert!(error.contains(what), "{from} -> {to}: {error}");
        }
        for end in 0..text.trim_end().len() {
            assert!(Regions::from_json(&text.as_bytes()[..end]).is_err(), "{end}");
        }
    }

    #[test]
    fn rejects_manifest_above_size_limit() {
        let folder = adumbra_testing::Folder::new();
        let path = folder.write("world.json", world().to_json().as_bytes());
        assert_eq!(Regions::read(&path).unwrap(), world());
        std::fs::File::options().write(true).open(&path).unwrap().set_len((64 << 20) + 1).unwrap();
        let error = Regions::read(&path).unwrap_err().to_string();
        assert!(error.contains("more than 67108864 bytes"), "{error}");
    }
}
