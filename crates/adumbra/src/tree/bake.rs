//! The bake of a world-aligned tree: scene and sun in, graph out.
//!
//! Cube → the light's depth images → builder → reduction → numbered words. Drawing the images uses all threads; the
//! reference builders, as in the paper, one.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use super::VoxelTree;
use super::attribute::{AttributeIndex, gather};
use super::blocks::Blocks;
use super::depth_image::{DepthImage, DepthImageOptions, image_bytes};
use super::layout::{Layout, lay_out};
use super::lit_space::LitSpace;
use super::options::{Reduction, TreeOptions};
use super::reduce::tree_hash::TreeHashed;
use super::reduce::{Interned, Sink, sort};
use super::settings::TreeSettings;
use super::space::{Regions, TreeSpace};
use super::word::Word;
use crate::error::{Error, Result};
use crate::scene::Scene;

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
    pub held_bytes: u64,
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

/// A scene made ready for builders: its cube, and its shadows as the light's depth images have them.
pub struct PreparedTree {
    space: TreeSpace,
    regions: Regions,
    settings: TreeSettings,
    /// For the space outside all regions, then for each region.
    images: Vec<DepthImage>,
    scene_bytes: u64,
    image_seconds: f64,
}

impl PreparedTree {
    /// Settles the cube and draws the depth images: one for the base depth, and one for each region over its own part.
    ///
    /// # Errors
    /// An option out of range, images that do not fit `max_memory_bytes`, or [`Error::Interrupted`].
    pub fn new(scene: &Scene, options: &TreeOptions, cancel: &AtomicBool) -> Result<Self> {
        let start = Instant::now();
        let Layout { space, regions, image_grids } = lay_out(scene, options)?;
        let image_options = DepthImageOptions {
            closed_regions: options.closed_regions,
            ignore_alpha: options.ignore_alpha,
            capture_bias: options.capture_bias,
        };
        let scene_bytes = scene.memory_bytes();
        let needed: u64 = image_grids.iter().map(|grid| image_bytes(grid, options.closed_regions)).sum();
        check_memory(options, "the scene and the light's depth images", scene_bytes + needed)?;
        let mut images = Vec::new();
        let mut triangles = 0;
        for grid in &image_grids {
            let (image, casting) = DepthImage::capture(scene, grid, image_options, cancel);
            if cancel.load(Ordering::Relaxed) {
                return Err(Error::Interrupted);
            }
            images.push(image);
            triangles = casting;
        }
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
        let image_seconds = start.elapsed().as_secs_f64();
        let prepared = Self { space, regions, settings, images, scene_bytes, image_seconds };
        check_memory(options, "the light's depth images", prepared.held_bytes())?;
        Ok(prepared)
    }

    /// Bytes of the scene and the images.
    fn held_bytes(&self) -> u64 {
        self.scene_bytes + self.images.iter().map(DepthImage::memory_bytes).sum::<u64>()
    }

    /// Builds and reduces, and says now and then how far it is. `options` must be those of [`PreparedTree::new`] but for
    /// builder, reduction and pruning.
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
        let space = LitSpace::new(&self.images, &self.space, &self.regions, options.prune);
        let held = self.held_bytes() + space.memory_bytes();
        let pyramid_seconds = start.elapsed().as_secs_f64();
        let mut report = TreeReport {
            image_seconds: self.image_seconds + pyramid_seconds,
            image_bytes: held - self.scene_bytes,
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
                report.held_bytes = sink.memory_bytes();
                sink.finish(root)
            }
            Reduction::TreeHash => {
                let mut sink = TreeHashed::default();
                let root = builder.build(&space, depth, prune, &mut sink, &|s: &TreeHashed, share| {
                    watch(s.memory_bytes(), share)
                })?;
                report.held_bytes = sink.memory_bytes();
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
        progress(TreeProgress { done_share: 1.0, voxels, tree_bytes: report.held_bytes });
        report.build_seconds = built.elapsed().as_secs_f64();
        report.built_blocks = blocks.blocks.len() as u64;
        let reducing = Instant::now();
        let blocks = match options.reduction {
            Reduction::Sort => {
                let (sorted, bytes) = sort(blocks);
                report.held_bytes = bytes;
                sorted
            }
            Reduction::Hash | Reduction::TreeHash => blocks,
        };
        let blocks_bytes = (blocks.blocks.capacity() * size_of::<[Word; 8]>()) as u64;
        // The words, and two numbers a block while they are made.
        let numbering_bytes = blocks_bytes + blocks.blocks.len() as u64 * 40;
        check_memory(options, "numbering the tree", held + numbering_bytes)?;
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
        let space = LitSpace::new(&self.images, &self.space, &self.regions, false);
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
