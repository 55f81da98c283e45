//! Penumbrae between the keys of a sun path, on the CPU. Twin of access/voxel_path_disc.wgsl.

use adumbra::ShadowFile;
use adumbra::query::{MarchSlope, Marched, SLOPE_BITS, march};
use adumbra_shaders::constants::POISSON_DISC;

use crate::maps::twin::{turn, turned};

/// Rays to points of the sun's disc, between two keys.
pub struct PathDiscTwin<'k> {
    keys: [Key<'k>; 2],
}

struct Key<'k> {
    file: &'k ShadowFile,
    slope: MarchSlope,
    /// From the disc across the light to the slopes of rays, texels per voxel.
    cone: [[f32; 2]; 2],
}

impl<'k> PathDiscTwin<'k> {
    /// Creates the look-up for a sun of `sun_degrees`. Rays march through the first key first. `None` if the
    /// march in either key cannot reach the sun.
    pub fn new(keys: [&'k ShadowFile; 2], towards_sun: [f64; 3], sun_degrees: f64) -> Option<Self> {
        let key = |file: &'k ShadowFile| {
            let growth = file.grid.cone_texels_per_voxel(sun_degrees) as f32;
            let cone = file.grid.circle_across_light().map(|row| row.map(|c| growth * c as f32));
            Some(Key { file, slope: MarchSlope::new(&file.grid, towards_sun)?, cone })
        };
        Some(Self { keys: [key(keys[0])?, key(keys[1])?] })
    }

    /// Visible share of the sun's disc at a point, 1 = all of it. `pixel` determines the rotation of the
    /// rays.
    pub fn visibility(&self, p_world: [f64; 3], normal: Option<[f64; 3]>, pixel: [u32; 2]) -> f32 {
        let turn = turn(pixel);
        let is_lit = |tap: &&[f32; 2]| {
            let on_disc = turned(**tap, turn);
            let marched = |key: usize| self.keys[key].march(p_world, normal, on_disc);
            marched(0).is_lit(|| marched(1), self.keys[0].file.settings.dark_after_voxels)
        };
        POISSON_DISC.iter().filter(is_lit).count() as f32 / POISSON_DISC.len() as f32
    }
}

impl Key<'_> {
    fn march(&self, p_world: [f64; 3], normal: Option<[f64; 3]>, on_disc: [f32; 2]) -> Marched {
        let aside = self.cone.map(|[x, y]| x * on_disc[0] + y * on_disc[1]);
        let one = (1 << SLOPE_BITS) as f32;
        let v_fixed = [0, 1].map(|a| self.slope.v_fixed[a] + (one * aside[a]).floor() as i32);
        let slope = MarchSlope { v_fixed };
        let start = slope.start(&self.file.grid, &self.file.settings.bias, p_world, normal);
        march(self.file.tree.words(), slope, start)
    }
}
