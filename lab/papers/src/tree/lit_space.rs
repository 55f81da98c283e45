//! The space that a tree subdivides: cells are tested at their centre against the light's depth image, and a
//! min/max pyramid over the image decides whole cubes. Source: the paper's §2.2.3 and §3.1.3.
//!
//! A cell is shadowed if its centre is behind the first depth of its texel. It is free if its centre is
//! inside a solid, between entry into and exit from closed components in that column, at any depth and
//! regardless of the first depth. Positions along the axes of the light are integers, so that a cube and its
//! voxels cannot disagree:
//!
//! | axis | unit |
//! |---|---|
//! | u, v | 2^-32 texel |
//! | z | 2^-32 texel; its bits from 24 up are in 1/256 texel, like the depths of the image |

use crate::tree::build::{Classify, State};
use crate::tree::depth_image::{DepthImage, FRACTION, NO_SURFACE};
use crate::tree::pyramid::{Block, Pyramid};
use crate::tree::space::{RegionVoxels, Regions, TreeSpace};

/// Fractional bits of z beyond the 1/256 texel of the image.
const DEPTH_SHIFT: u32 = FRACTION - 8;
/// Width of the sun's disc of 0.533° at distance 1: 2 tan(0.2665°).
const SUN_WIDTH: f64 = 0.009_302_6;

/// The shadows of a scene over a cube.
pub(crate) struct LitSpace<'i> {
    depth: u32,
    base_depth: u32,
    /// Regions, deepest first.
    regions: Vec<RegionVoxels>,
    /// First the layer for the space outside all regions, then one for each region.
    layers: Vec<Layer<'i>>,
}

/// One depth image, with the mapping from tree positions to image positions.
struct Layer<'i> {
    image: &'i DepthImage,
    pyramid: Option<Pyramid>,
    /// u, v, z of the lowest corner of the cube.
    origin: [i64; 3],
    /// For each tree axis, the change of u, v, z per half voxel along it.
    half_steps: [[i64; 3]; 3],
    /// By level of a cube, then by child: the step in u, v, z from the centre of child 0 to that of the
    /// child.
    child_steps: Vec<[[i64; 3]; 8]>,
    texels_per_voxel: f64,
    /// A point at least this far before the depth of a column is before its first surface too.
    before_surface: i64,
}

impl<'i> LitSpace<'i> {
    /// `images` are those of [`crate::tree::layout::Layout::image_grids`]. Without `pyramids`, no cube is
    /// decided as a whole.
    pub(crate) fn new(
        images: &'i [DepthImage],
        space: &TreeSpace,
        regions: &Regions,
        pyramids: bool,
    ) -> Self {
        Self {
            depth: space.depth,
            base_depth: regions.base_depth,
            regions: regions.in_voxels(space),
            layers: images.iter().map(|image| Layer::new(image, space, pyramids)).collect(),
        }
    }

    /// Bytes of the pyramids.
    pub(crate) fn memory_bytes(&self) -> u64 {
        self.layers.iter().filter_map(|l| l.pyramid.as_ref()).map(Pyramid::memory_bytes).sum()
    }

    /// Returns the deepest region that a cube overlaps in plan.
    fn region_over(&self, xyz: [u32; 3], level: u32) -> Option<usize> {
        let side = 1 << level;
        self.regions.iter().position(|r| {
            xyz[0] < r.x[1] && xyz[0] + side > r.x[0] && xyz[2] < r.z[1] && xyz[2] + side > r.z[0]
        })
    }

    /// Returns the layer in which a cell is tested.
    fn layer_of(&self, xyz: [u32; 3], level: u32) -> &Layer<'i> {
        &self.layers[self.region_over(xyz, level).map_or(0, |r| r + 1)]
    }

    /// Returns the layer in which all cells of a cube are tested, or `None` if they are tested in different
    /// layers.
    fn layer_of_all(&self, xyz: [u32; 3], level: u32) -> Option<&Layer<'i>> {
        let Some(region) = self.region_over(xyz, level) else { return Some(&self.layers[0]) };
        let r = &self.regions[region];
        let side = 1 << level;
        let holds =
            r.x[0] <= xyz[0] && xyz[0] + side <= r.x[1] && r.z[0] <= xyz[2] && xyz[2] + side <= r.z[1];
        holds.then(|| &self.layers[region + 1])
    }

    /// Returns the width of the sun's penumbra at the centre of a cell, in eighths of a finest voxel, at
    /// most 255. The occluder distance is that of the nearest surface in nine columns: through the centre of
    /// the cell and around it, one cell width apart. 0 if no surface is before the centre.
    pub(crate) fn penumbra_eighths(&self, xyz: [u32; 3], level: u32) -> u8 {
        self.layer_of_all(xyz, level).unwrap_or(&self.layers[0]).penumbra_eighths(xyz, level)
    }

    /// Whether any of the cells at the eight corners of a cube is in this state rather than free. All defined
    /// cells of the cube are in this state.
    fn a_corner_is(&self, state: State, xyz: [u32; 3], level: u32) -> bool {
        (0..8_u32).any(|corner| {
            let mut xyz = xyz;
            let mut level = level;
            while !self.is_cell(xyz, level) {
                level -= 1;
                for (a, c) in xyz.iter_mut().enumerate() {
                    *c += (corner >> a & 1) << level;
                }
            }
            self.cell(xyz, level) == state
        })
    }
}

impl Classify for LitSpace<'_> {
    fn is_cell(&self, xyz: [u32; 3], level: u32) -> bool {
        let depth = self.depth - level;
        let needed = || self.region_over(xyz, level).map_or(self.base_depth, |r| self.regions[r].depth);
        level == 0 || depth >= self.base_depth && depth >= needed()
    }

    fn cell(&self, xyz: [u32; 3], level: u32) -> State {
        let layer = self.layer_of(xyz, level);
        layer.state(layer.at(center(xyz, level)))
    }

    fn eight(&self, xyz: [u32; 3], level: u32) -> [u8; 2] {
        let mut masks = [0; 2];
        let mut set = |c: usize, state| match state {
            State::Lit => masks[0] |= 1 << c,
            State::Free => masks[1] |= 1 << c,
            State::Shadowed => {}
        };
        match self.layer_of_all(xyz, level) {
            Some(layer) => {
                let first = layer.at(center(xyz, level - 1));
                for (c, steps) in layer.child_steps[level as usize].iter().enumerate() {
                    set(c, layer.state(std::array::from_fn(|axis| first[axis] + steps[axis])));
                }
            }
            None => {
                for c in 0..8 {
                    set(c, self.cell(crate::tree::morton::child_corner(xyz, level, c as u32), level - 1));
                }
            }
        }
        masks
    }

    fn cube(&self, xyz: [u32; 3], level: u32) -> Option<State> {
        let layer = self.layer_of_all(xyz, level)?;
        let Range { block, z } = layer.range(xyz, level)?;
        if i64::from(block.entries_first_max) <= z[0] && z[1] < i64::from(block.exits_first_min) {
            return Some(State::Free);
        }
        let state = if z[0] > i64::from(block.depth_max) {
            State::Shadowed
        } else if z[1] <= i64::from(block.depth_min) {
            State::Lit
        } else {
            return None;
        };
        let may_be_free = z[1] >= i64::from(block.entries_min) && z[0] < i64::from(block.exits_max);
        (!may_be_free || self.a_corner_is(state, xyz, level)).then_some(state)
    }
}

/// Returns the centre of a cube in half voxels.
fn center(xyz: [u32; 3], level: u32) -> [u32; 3] {
    xyz.map(|c| 2 * c + (1 << level))
}

/// The extent of a cube in an image.
struct Range {
    /// The values shared by the columns that the cube may touch.
    block: Block,
    /// First and last depth of the centres of its voxels.
    z: [i64; 2],
}

impl<'i> Layer<'i> {
    fn new(image: &'i DepthImage, space: &TreeSpace, pyramid: bool) -> Self {
        let fixed = |c: f64| (c * (1_i64 << FRACTION) as f64).round() as i64;
        let origin = image.grid.to_grid(space.p_min).map(fixed);
        let texels_per_half_voxel = 0.5 * space.voxel_size / image.grid.voxel_size;
        let half_steps: [[i64; 3]; 3] = std::array::from_fn(|a| {
            std::array::from_fn(|axis| fixed(image.grid.axes[axis][a] * texels_per_half_voxel))
        });
        let child_steps = (0..=space.depth).map(|level| {
            std::array::from_fn(|c| {
                let steps = crate::tree::morton::child_offset(c as u32).map(|step| i64::from(step) << level);
                std::array::from_fn(|axis| (0..3).map(|a| half_steps[a][axis] * steps[a]).sum())
            })
        });
        Self {
            image,
            pyramid: pyramid.then(|| Pyramid::of(image)),
            origin,
            half_steps,
            child_steps: child_steps.collect(),
            texels_per_voxel: 2.0 * texels_per_half_voxel,
            before_surface: i64::from(image.largest_bias),
        }
    }

    /// Returns u, v, z of a point given in half voxels.
    fn at(&self, half_voxels: [u32; 3]) -> [i64; 3] {
        std::array::from_fn(|axis| {
            (0..3)
                .fold(self.origin[axis], |sum, a| sum + self.half_steps[a][axis] * i64::from(half_voxels[a]))
        })
    }

    fn state(&self, [u, v, z]: [i64; 3]) -> State {
        let [width, height] = self.image.size();
        let [u, v] = [u >> FRACTION, v >> FRACTION];
        // Negative coordinates become large.
        if u as u64 >= u64::from(width) || v as u64 >= u64::from(height) {
            return State::Lit;
        }
        let z = z >> DEPTH_SHIFT;
        let first = self.image.depth(u as u32, v as u32);
        if z < i64::from(first) - self.before_surface {
            return State::Lit;
        }
        let insides = self.image.insides(u as u32, v as u32);
        if insides.iter().any(|&[from, to]| (i64::from(from)..i64::from(to)).contains(&z)) {
            return State::Free;
        }
        if z > i64::from(first) { State::Shadowed } else { State::Lit }
    }

    /// Returns `None` if there is no pyramid, or if its blocks are too coarse to decide.
    fn range(&self, xyz: [u32; 3], level: u32) -> Option<Range> {
        let center = self.at(center(xyz, level));
        // The centres of the voxels of the cube, and of any larger cells, are at most this far from its
        // centre.
        let half = (1_i64 << level) - 1;
        let reach: [i64; 3] =
            std::array::from_fn(|axis| (0..3).map(|a| self.half_steps[a][axis].abs() * half).sum());
        let [low, high] = [-1, 1].map(|sign| [center[0] + sign * reach[0], center[1] + sign * reach[1]]);
        let block = self.pyramid.as_ref()?.over(low, high)?;
        let z = [center[2] - reach[2], center[2] + reach[2]].map(|z| z >> DEPTH_SHIFT);
        Some(Range { block, z })
    }

    fn penumbra_eighths(&self, xyz: [u32; 3], level: u32) -> u8 {
        let [u, v, z] = self.at(center(xyz, level));
        let (z, cell) = (z >> DEPTH_SHIFT, f64::from(1_u32 << level));
        let step = (self.texels_per_voxel * cell).ceil() as i64;
        let [width, height] = self.image.size().map(i64::from);
        let mut nearest = NO_SURFACE;
        for (du, dv) in (-1..=1).flat_map(|du| (-1..=1).map(move |dv| (du, dv))) {
            let (u, v) = ((u >> FRACTION) + du * step, (v >> FRACTION) + dv * step);
            if (0..width).contains(&u) && (0..height).contains(&v) {
                nearest = nearest.min(self.image.depth(u as u32, v as u32));
            }
        }
        let distance_texels = (z - i64::from(nearest)).max(0) as f64 / 256.0;
        let width_voxels = SUN_WIDTH * distance_texels / self.texels_per_voxel;
        (8.0 * width_voxels).round().min(255.0) as u8
    }
}
