//! Adds a ground to models that have none.

use crate::generate::shapes::MeshBuilder;
use crate::generate::{Placement, Stage};

use crate::{Error, Result, Scene};

/// Height of the ground's top above the model's lowest point, as a fraction of its longest extent, so that no
/// light leaks below it.
const SINK_SHARE: f64 = 0.002;
/// Thickness of the ground as a fraction of its side.
const THICKNESS_SHARE: f64 = 1.0 / 64.0;

impl Scene {
    /// Adds a square ground below the middle of everything placed: a closed slab of 12 triangles, `factor`
    /// times as wide as the scene's longest extent along an axis. Its mesh, instance and material are called
    /// `ground`. The scene's lowest point is 1/500 of that extent below the slab's top. A scene without
    /// triangles is left unchanged. Cost: [`Scene::bounds`].
    ///
    /// # Errors
    /// Returns [`Error::GroundSize`] if `factor` is not from 1 to 1,000.
    pub fn stand_on_ground(&mut self, factor: f64) -> Result<()> {
        if !(1.0..=1000.0).contains(&factor) {
            return Err(Error::GroundSize { factor });
        }
        if self.instanced_triangles() == 0 {
            return Ok(());
        }
        let bounds = self.bounds();
        let extent = (0..3).map(|a| bounds.max[a] - bounds.min[a]).fold(0.0, f64::max);
        let side = extent * factor;
        let middle = |a: usize| (bounds.min[a] + bounds.max[a]) / 2.0;
        let mut stage = Stage { scene: std::mem::take(self) };
        let material = stage.material("ground", 0xB9B4AA);
        let mut slab = MeshBuilder::new("ground", material);
        slab.block([0.0, -side * THICKNESS_SHARE, 0.0], [side, side * THICKNESS_SHARE, side]);
        let slab = stage.mesh(slab.finish());
        let top = bounds.min[1] + extent * SINK_SHARE;
        stage.place(slab, "ground".to_owned(), Placement::at([middle(0), top, middle(2)]));
        *self = stage.finish();
        Ok(())
    }
}
