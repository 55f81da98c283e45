//! Look-ups in all regions of a world.

use std::collections::HashMap;
use std::path::Path;

use super::Regions;
use crate::error::{Error, Result};
use crate::grid::{LightGrid, Region};
use crate::query::{Filter, PointVisibility, Sampler};
use crate::settings::{Bias, FileSettings};

/// Looks up the visibility of points of a world in the files of its regions. The answers are those of one
/// file of the whole world, except where a file may answer either way. Filters can read beyond the sides of
/// a region, because its file extends beyond them.
pub struct RegionSampler {
    regions: Regions,
    samplers: HashMap<Region, Sampler>,
    settings: Option<FileSettings>,
    /// A grid of all regions, in the world.
    grid: LightGrid,
}

impl RegionSampler {
    pub(super) fn new(regions: &Regions, manifest: &Path, filter: Filter) -> Result<Self> {
        let mut samplers = HashMap::new();
        let mut settings = None;
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for (region, name) in regions.iter() {
            let file = regions.file(manifest, region)?;
            let grid = region.in_world(file.grid, 1);
            let own = FileSettings { triangles: 0, region: None, ..file.settings };
            if *settings.get_or_insert(own) != own {
                let what =
                    format!("{name} has other settings than the files before it; bake the regions again");
                return Err(Error::Manifest { path: manifest.to_owned(), what });
            }
            let first = region.first_texel();
            for a in 0..3 {
                let (from, side) = match first.get(a) {
                    Some(first) => (*first, f64::from(regions.texels)),
                    None => (grid.corner[a], f64::from(grid.size[a])),
                };
                low[a] = low[a].min(from);
                high[a] = high[a].max(from + side);
            }
            samplers.insert(region, file.sampler(filter));
        }
        let size = std::array::from_fn(|a| (high[a] - low[a]).clamp(1.0, f64::from(u32::MAX)) as u32);
        let corner = low.map(|low| if low.is_finite() { low } else { 0.0 });
        let grid = LightGrid { corner, size, ..regions.grid };
        Ok(Self { regions: regions.clone(), samplers, settings, grid })
    }

    /// Returns look-ups with another bias.
    ///
    /// # Errors
    /// Returns [`Error::Range`] if a term is out of its range.
    pub fn with_bias(mut self, bias: Bias) -> Result<Self> {
        for sampler in self.samplers.values_mut() {
            *sampler = sampler.clone().with_bias(bias)?;
        }
        Ok(self)
    }

    /// Returns the smallest grid of the world that has all regions.
    pub fn grid(&self) -> &LightGrid {
        &self.grid
    }

    /// Returns the settings that all files share. Triangles are not counted. `None` if the world has no
    /// regions.
    pub fn settings(&self) -> Option<&FileSettings> {
        self.settings.as_ref()
    }

    /// Returns the region of a point with its look-ups, and the point relative to its origin.
    fn place(&self, p_world: [f64; 3]) -> Option<(Region, &Sampler, [f64; 3])> {
        let region = Region::containing(&self.regions.grid, self.regions.texels, p_world);
        let sampler = self.samplers.get(&region)?;
        let origin = self.regions.origin(region);
        Some((region, sampler, std::array::from_fn(|a| p_world[a] - origin[a])))
    }
}

impl PointVisibility for RegionSampler {
    fn visibility(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> f32 {
        self.place(p_world).map_or(1.0, |(_, sampler, p)| sampler.visibility(p, normal))
    }

    fn visibilities(&self, points_world: &[[f64; 3]], normals: Option<&[[f64; 3]]>) -> Vec<f32> {
        let mut out = vec![1.0; points_world.len()];
        // Successive points in one region are looked up together.
        let placed: Vec<_> = points_world.iter().map(|&p| self.place(p)).collect();
        let mut at = 0;
        for run in placed.chunk_by(|a, b| a.map(|(region, ..)| region) == b.map(|(region, ..)| region)) {
            let range = at..at + run.len();
            at = range.end;
            if let Some((_, sampler, _)) = run[0] {
                let points: Vec<[f64; 3]> = run.iter().flatten().map(|&(.., p)| p).collect();
                let normals = normals.map(|n| &n[range.clone()]);
                out[range].copy_from_slice(&PointVisibility::visibilities(sampler, &points, normals));
            }
        }
        out
    }
}
