//! A triangle as the bake uses it: its projected shape and its properties.

use crate::triangles::casters::Casters;
use crate::triangles::cluster::ClusterTriangle;
use crate::triangles::project::Projected;
use adumbra::grid::LightGrid;
use adumbra_scene::{Instance, Scene};

/// A triangle of an instance, projected.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface {
    pub(crate) shape: Projected,
    pub(crate) instance: u32,
    /// Index into the mesh's triangles.
    pub(crate) triangle: u32,
    /// Connected component of the mesh.
    pub(crate) component: u32,
    /// Whether it casts. A surface that does not cast still receives.
    pub(crate) casts: bool,
    /// Whether it bounds a solid.
    pub(crate) solid: bool,
    /// Whether its material has holes.
    pub(crate) masked: bool,
}

/// Surfaces that can be iterated more than once.
pub(crate) trait Surfaces {
    fn scene(&self) -> &Scene;
    fn grid(&self) -> &LightGrid;
    fn for_each(&self, visit: impl FnMut(&Surface));
}

/// The surfaces that may touch a bin, projected again at every iteration.
pub(crate) struct BinSurfaces<'a> {
    pub(crate) casters: &'a Casters<'a>,
    pub(crate) bin: usize,
    pub(crate) grid: &'a LightGrid,
}

impl Surfaces for BinSurfaces<'_> {
    fn scene(&self) -> &Scene {
        self.casters.scene
    }

    fn grid(&self) -> &LightGrid {
        self.grid
    }

    fn for_each(&self, mut visit: impl FnMut(&Surface)) {
        for &placed in self.casters.in_bin(self.bin) {
            let instance = &self.casters.scene.instances[placed.instance as usize];
            let mesh = &self.casters.scene.meshes[instance.mesh as usize];
            let flipped = instance.determinant() < 0.0;
            for c in self.casters.triangles(placed) {
                let corners = mesh.triangles[c.triangle as usize]
                    .map(|v| self.grid.to_grid(instance.to_world(mesh.positions[v as usize])));
                visit(&surface_of(c, placed.instance, instance, Projected::new(corners, flipped)));
            }
        }
    }
}

/// Combines a triangle of an instance with its projected shape.
pub(crate) fn surface_of(
    c: &ClusterTriangle,
    instance_number: u32,
    instance: &Instance,
    shape: Projected,
) -> Surface {
    Surface {
        shape,
        instance: instance_number,
        triangle: c.triangle,
        component: c.component,
        casts: c.casts && instance.casts,
        solid: c.solid,
        masked: c.masked,
    }
}
