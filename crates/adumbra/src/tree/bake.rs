//! The bake of a world-aligned tree: scene and sun in, graph out.
//!
//! Cube → light's depth image → builder → reduction → numbered words. Drawing the image uses all threads; the
//! reference builders, as in the paper, one.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use super::attribute::{AttributeIndex, gather};
use super::blocks::Blocks;
use super::build::Builder;
use super::depth_image::{DepthImage, DepthImageOptions, image_bytes};
use super::lit_space::LitSpace;
use super::reduce::tree_hash::TreeHashed;
use super::reduce::{Interned, Sink, sort};
use super::settings::{CaptureBias, TreeSettings};
use super::space::{Region, Regions, TreeSpace};
use super::word::Word;
use super::{MAX_DEPTH, VoxelTree};
use crate::bake::Size;
use crate::error::{Error, Result};
use crate::light::{LightExtent, LightGrid, Sun};
use crate::scene::{Bounds, Scene};
use crate::settings::Bias;

/// How equal subtrees are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reduction {
    /// The whole tree first, then sorted height by height.
    Sort,
    /// While the tree is built, by a hash of a block's words.
    Hash,
    /// While the tree is built, by the paper's tree hash (3-5, 3-6).
    TreeHash,
}

/// Where the tree goes deeper than `--resolution` says.
#[derive(Clone, Debug, PartialEq)]
pub enum Detail {
    /// Nowhere.
    Uniform,
    /// In these regions; the size is that of the rest.
    Regions(Vec<Region>),
    /// In nested squares around a point: the size is that of the innermost, a level less in each next one.
    Rings {
        /// World x and z.
        center_xz: [f64; 2],
        /// Half sides, world units, innermost first.
        radii: Vec<f64>,
    },
}

/// Options of [`bake_tree`].
#[derive(Clone, Debug)]
pub struct TreeOptions {
    /// The sun.
    pub sun: Sun,
    /// Voxels a side of the cube, a power of two; or the voxel's edge.
    pub size: Size,
    /// Where it is finer.
    pub detail: Detail,
    /// Insides of closed components are free.
    pub closed_regions: bool,
    /// Take masked materials as opaque.
    pub ignore_alpha: bool,
    /// The cube is put around this box in place of the scene; casters outside it but sunward still cast into it.
    pub bounds: Option<Bounds>,
    /// How far depths are moved away from the light (4-1).
    pub capture_bias: CaptureBias,
    /// The look-up bias that the file asks for, in voxels.
    pub bias: Bias,
    /// Which builder.
    pub builder: Builder,
    /// Which reduction.
    pub reduction: Reduction,
    /// Whether cubes that the min/max pyramid decides are skipped. The tree is the same.
    pub prune: bool,
    /// Bytes that may be held; none = no limit.
    pub max_memory_bytes: Option<u64>,
}

impl TreeOptions {
    /// Defaults: recursive, by hash, pruned, closed regions used.
    pub fn new(sun: Sun, size: Size) -> Self {
        Self {
            sun,
            size,
            detail: Detail::Uniform,
            closed_regions: true,
            ignore_alpha: false,
            bounds: None,
            capture_bias: CaptureBias::default(),
            bias: TREE_BIAS,
            builder: Builder::Recursive,
            reduction: Reduction::Hash,
            prune: true,
            max_memory_bytes: None,
        }
    }
}

/// The look-up bias of a tree, in voxels: a voxel is tested at its centre, which lies up to half a diagonal off.
/// A centre above the plane through the receiver needs half of (|nx| + |ny| + |nz|) / n·l, at most 0.87 (1 + slope).
pub const TREE_BIAS: Bias = Bias { constant_texels: 1.0, slope_texels: 0.75, normal_offset_texels: 0.0 };

impl Default for CaptureBias {
    /// Half a texel's diagonal along the slope: the farthest that a depth of the same plane lies from its texel's centre.
    fn default() -> Self {
        Self { constant_texels: 0.0, slope_texels: 0.75 }
    }
}

/// A finished tree.
#[derive(Clone, Debug)]
pub struct BakedTree {
    /// Where the cube lies.
    pub space: TreeSpace,
    /// How deep the tree goes where.
    pub regions: Regions,
    /// What was asked for.
    pub settings: TreeSettings,
    /// The answers.
    pub tree: VoxelTree,
    /// How it went.
    pub report: TreeReport,
}

/// How the bake of a tree went. Varies from run to run; never written into the file.
#[derive(Clone, Copy, Debug, Default, serde::Serialize)]
pub struct TreeReport {
    /// Wall seconds in all.
    pub seconds: f64,
    /// Drawing the depth image and its pyramid.
    pub image_seconds: f64,
    /// Building, with the reduction where it works while building.
    pub build_seconds: f64,
    /// Reducing afterwards (sort) and numbering.
    pub reduce_seconds: f64,
    /// The depth image and its pyramid.
    pub image_bytes: u64,
    /// The most that builder and reduction held.
    pub tree_bytes: u64,
    /// Blocks that the builder made: before the reduction where it sorts, after it where it hashes.
    pub built_blocks: u64,
    /// Different subtrees with one tree hash that were compared.
    pub collisions: Option<u64>,
}

/// Where the bake of a tree stands.
#[derive(Clone, Copy, Debug)]
pub struct TreeProgress {
    /// Share of the cube that is built.
    pub done_share: f64,
    /// Voxels in the cube.
    pub voxels: u64,
    /// Bytes that builder and reduction hold.
    pub tree_bytes: u64,
}

/// Texels of the depth image along a voxel's edge: more than one where that image stays small.
fn texels_per_voxel(depth: u32) -> f64 {
    if depth <= 11 { 2.0 } else { 1.0 }
}

/// A scene made ready for builders: its cube, and its shadows as the light's depth image has them.
pub struct PreparedTree {
    space: TreeSpace,
    regions: Regions,
    settings: TreeSettings,
    image: DepthImage,
    image_seconds: f64,
}

impl PreparedTree {
    /// Settles the cube and draws the depth image.
    ///
    /// # Errors
    /// An option out of range, an image that does not fit `max_memory_bytes`, or [`Error::Interrupted`].
    pub fn new(scene: &Scene, options: &TreeOptions, cancel: &AtomicBool) -> Result<Self> {
        let start = Instant::now();
        let (space, regions) = lay_out(scene, options)?;
        let grid = image_grid(scene, options, &space);
        let bytes = image_bytes(&grid) + scene.memory_bytes();
        check_memory(options, "the scene and the light's depth image", bytes)?;
        let image_options = DepthImageOptions {
            closed_regions: options.closed_regions,
            ignore_alpha: options.ignore_alpha,
            capture_bias: options.capture_bias,
        };
        let (image, triangles) = DepthImage::capture(scene, &grid, image_options, cancel);
        if cancel.load(Ordering::Relaxed) {
            return Err(Error::Interrupted);
        }
        check_memory(options, "the light's depth image", image.memory_bytes() + scene.memory_bytes())?;
        let settings = TreeSettings {
            closed_regions: options.closed_regions,
            ignore_alpha: options.ignore_alpha,
            bounds: options.bounds,
            capture_bias: options.capture_bias,
            bias: options.bias,
            lossy: None,
            triangles,
            instances: scene.instances.iter().filter(|i| i.casts).count() as u64,
        };
        Ok(Self { space, regions, settings, image, image_seconds: start.elapsed().as_secs_f64() })
    }

    /// Builds and reduces, and says now and then how far it is. `options` must be those of [`PreparedTree::new`] but for builder, reduction and pruning.
    ///
    /// # Errors
    /// [`Error::Interrupted`], or a graph that does not fit.
    pub fn build(
        &self,
        options: &TreeOptions,
        progress: &dyn Fn(TreeProgress),
        cancel: &AtomicBool,
    ) -> Result<BakedTree> {
        let start = Instant::now();
        let space = LitSpace::new(&self.image, &self.space, &self.regions);
        let held = self.image.memory_bytes() + space.memory_bytes();
        let pyramid_seconds = start.elapsed().as_secs_f64();
        let mut report = TreeReport {
            image_seconds: self.image_seconds + pyramid_seconds,
            image_bytes: held,
            ..TreeReport::default()
        };
        let (depth, builder, prune) = (self.space.depth, options.builder, options.prune);
        let voxels = 1_u64 << (3 * depth);
        let watch = |tree_bytes: u64, done_share: f64| {
            if cancel.load(Ordering::Relaxed) {
                return Err(Error::Interrupted);
            }
            progress(TreeProgress { done_share, voxels, tree_bytes });
            check_memory(options, "the tree so far", held + tree_bytes)
        };
        let built = Instant::now();
        let blocks = match options.reduction {
            Reduction::Hash => {
                let mut sink = Interned::default();
                let root = builder.build(&space, depth, prune, &mut sink, &|s: &Interned, share| {
                    watch(s.memory_bytes(), share)
                })?;
                report.tree_bytes = sink.memory_bytes();
                sink.finish(root)
            }
            Reduction::TreeHash => {
                let mut sink = TreeHashed::default();
                let root = builder.build(&space, depth, prune, &mut sink, &|s: &TreeHashed, share| {
                    watch(s.memory_bytes(), share)
                })?;
                report.tree_bytes = sink.memory_bytes();
                report.collisions = Some(sink.collisions());
                sink.finish(root)
            }
            Reduction::Sort => {
                let mut blocks: Vec<[Word; 8]> = Vec::new();
                let root = builder.build(&space, depth, prune, &mut blocks, &|b: &Vec<_>, share| {
                    // Sorting takes a key and two numbers a block more.
                    watch(b.memory_bytes() * 5 / 2, share)
                })?;
                Blocks { root, blocks }
            }
        };
        progress(TreeProgress { done_share: 1.0, voxels, tree_bytes: report.tree_bytes });
        report.build_seconds = built.elapsed().as_secs_f64();
        report.built_blocks = blocks.blocks.len() as u64;
        let reducing = Instant::now();
        let blocks = match options.reduction {
            Reduction::Sort => {
                let (sorted, bytes) = sort(blocks);
                report.tree_bytes = bytes;
                sorted
            }
            Reduction::Hash | Reduction::TreeHash => blocks,
        };
        let tree = blocks.number(depth);
        report.reduce_seconds = reducing.elapsed().as_secs_f64();
        report.seconds = self.image_seconds + start.elapsed().as_secs_f64();
        Ok(BakedTree {
            space: self.space,
            regions: self.regions.clone(),
            settings: self.settings,
            tree,
            report,
        })
    }

    /// The penumbra's width at every leaf voxel of `tree`, in eighths of a voxel, in the order of
    /// [`super::attribute`].
    ///
    /// # Errors
    /// More leaf voxels than 32 bits count.
    pub fn penumbra(&self, tree: &VoxelTree) -> Result<Vec<u8>> {
        let space = LitSpace::new(&self.image, &self.space, &self.regions);
        let index = AttributeIndex::of(tree)?;
        Ok(gather(tree, &index, &|xyz, level| space.penumbra_eighths(xyz, level)))
    }
}

/// Bakes `scene` into a world-aligned tree.
///
/// # Errors
/// As [`PreparedTree::new`] and [`PreparedTree::build`].
pub fn bake_tree(
    scene: &Scene,
    options: &TreeOptions,
    progress: &dyn Fn(TreeProgress),
    cancel: &AtomicBool,
) -> Result<BakedTree> {
    PreparedTree::new(scene, options, cancel)?.build(options, progress, cancel)
}

fn check_memory(options: &TreeOptions, what: &'static str, needed_bytes: u64) -> Result<()> {
    match options.max_memory_bytes {
        Some(limit_bytes) if needed_bytes > limit_bytes => {
            Err(Error::MemoryLimit { what, needed_bytes, limit_bytes })
        }
        _ => Ok(()),
    }
}

/// The cube and how deep it is divided where.
fn lay_out(scene: &Scene, options: &TreeOptions) -> Result<(TreeSpace, Regions)> {
    let bounds = options.bounds.unwrap_or_else(|| scene.bounds());
    let side = (0..3).map(|a| bounds.max[a] - bounds.min[a]).fold(0.0, f64::max);
    // Checks that are the light-aligned bake's too.
    let shared = crate::bake::Options {
        bounds: options.bounds,
        ..crate::bake::Options::new(options.sun, options.size)
    };
    let (resolution, voxel_size) = shared.checked_resolution(side)?;
    let depth = resolution.ilog2();
    options.bias.check()?;
    let regions = match &options.detail {
        Detail::Uniform => Regions::uniform(depth),
        Detail::Regions(list) => Regions { base_depth: depth, list: list.clone() },
        Detail::Rings { center_xz, radii } => {
            if radii.len() as u32 >= depth || radii.windows(2).any(|w| w[0] >= w[1]) {
                return Err(Error::OptionRange {
                    option: "--rings",
                    value: format!("{radii:?}"),
                    range: "radii that grow, fewer than the tree has levels",
                });
            }
            Regions::rings(*center_xz, radii, depth)
        }
    };
    if depth > MAX_DEPTH {
        return Err(Error::OptionRange {
            option: "--resolution",
            value: resolution.to_string(),
            range: "at most 32768 for --frame world; --frame light goes further",
        });
    }
    regions.check()?;
    let depth_in_all = regions.depth();
    let mut space = TreeSpace::around(&bounds, depth);
    if let Size::VoxelSize(_) = options.size {
        // The cube grows to whole levels around the same centre.
        let grown = voxel_size * f64::from(1_u32 << depth);
        space.p_min = std::array::from_fn(|a| space.p_min[a] - 0.5 * (grown - side));
        space.voxel_size = voxel_size;
    }
    space.voxel_size /= f64::from(1_u32 << (depth_in_all - depth));
    space.depth = depth_in_all;
    Ok((space, regions))
}

/// The columns of the depth image: the part of the light's plane that the cube and the casters have in common.
fn image_grid(scene: &Scene, options: &TreeOptions, space: &TreeSpace) -> LightGrid {
    let mut casters = LightExtent::empty(&options.sun);
    for instance in scene.instances.iter().filter(|i| i.casts) {
        let mesh = &scene.meshes[instance.mesh as usize];
        for &v in mesh.triangles.iter().flatten() {
            casters.add(instance.to_world(mesh.positions[v as usize]));
        }
    }
    let mut cube = LightExtent::empty(&options.sun);
    let top = space.to_world([f64::from(space.side_voxels()); 3]);
    cube.add_box(&Bounds { min: space.p_min, max: top });
    let texel = space.voxel_size / texels_per_voxel(space.depth);
    let mut common = casters;
    for a in 0..2 {
        // Where they miss each other one texel is left, with nothing in it.
        common.min[a] = casters.min[a].max(cube.min[a]).min(cube.max[a]);
        common.max[a] = casters.max[a].min(cube.max[a]).max(common.min[a] + texel);
    }
    LightGrid::covering(options.sun, &common, texel)
}
