//! Bakes a world-aligned tree: takes a scene and a sun, produces a graph.
//!
//! Cube → depth images from the light → builder → reduction → numbered words. The depth images are rendered
//! on all threads. The reference builders use one thread, as in the paper.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use crate::tree::attribute::{AttributeIndex, gather};
use crate::tree::blocks::Blocks;
use crate::tree::depth_image::{DepthImage, DepthImageOptions, image_bytes};
use crate::tree::error::{Error, Result};
use crate::tree::graph::VoxelTree;
use crate::tree::layout::{Layout, lay_out};
use crate::tree::lit_space::LitSpace;
use crate::tree::options::{Reduction, TreeOptions};
use crate::tree::pyramid::Pyramid;
use crate::tree::reduce::tree_hash::TreeHashed;
use crate::tree::reduce::{Interned, Sink, sort};
use crate::tree::settings::TreeSettings;
use crate::tree::space::{Regions, TreeSpace};
use crate::tree::word::Word;
use adumbra::Sun;
use adumbra_bake::Watch;
use adumbra_bake::structure::layers::sorting_bytes;
use adumbra_scene::Scene;

/// A baked tree.
#[derive(Clone, Debug)]
pub struct BakedTree {
    /// The cube in the world.
    pub space: TreeSpace,
    /// The depth of the tree in each part of the plan.
    pub regions: Regions,
    /// The settings of the bake.
    pub settings: TreeSettings,
    /// The sun that casts the shadows.
    pub sun: Sun,
    /// The visibility of every voxel.
    pub tree: VoxelTree,
    /// Statistics of the bake.
    pub report: TreeReport,
}

/// Statistics of the bake of a tree. They vary from run to run and are never written into the file.
#[derive(Clone, Copy, Debug, Default, serde::Serialize)]
pub struct TreeReport {
    /// Total wall-clock time, seconds.
    pub seconds: f64,
    /// Seconds spent rendering the depth images and building their pyramids.
    pub image_seconds: f64,
    /// Seconds spent building, including the reduction if it runs during the build.
    pub build_seconds: f64,
    /// Seconds spent on the reduction after the build (sort) and on numbering.
    pub reduce_seconds: f64,
    /// Bytes of the depth images and their pyramids.
    pub image_bytes: u64,
    /// Peak bytes held by builder and reduction.
    pub held_bytes: u64,
    /// Number of blocks the builder produced: before the reduction if it sorts, after it if it hashes.
    pub built_blocks: u64,
    /// Number of comparisons of different subtrees with equal tree hashes.
    pub collisions: Option<u64>,
}

/// Progress of the bake of a tree.
#[derive(Clone, Copy, Debug)]
pub struct TreeProgress {
    /// Fraction of the cube that has been built.
    pub done_share: f64,
    /// Number of voxels in the cube.
    pub voxels: u64,
    /// Bytes held by builder and reduction.
    pub tree_bytes: u64,
}

/// A scene prepared for the builders: its cube, and its shadows as depth images from the light.
pub struct PreparedTree {
    space: TreeSpace,
    regions: Regions,
    settings: TreeSettings,
    sun: Sun,
    /// First the image for the space outside all regions, then one for each region.
    images: Vec<DepthImage>,
    scene_bytes: u64,
    image_seconds: f64,
}

impl PreparedTree {
    /// Determines the cube and renders the depth images: one for the base depth, and one for each region over
    /// its own part.
    ///
    /// # Errors
    /// Returns an error if an option is out of range or the images do not fit `max_memory_bytes`, or
    /// [`adumbra_bake::Error::Interrupted`].
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
        let sorting = sorting_bytes(scene, options.closed_regions, options.ignore_alpha);
        check_memory(options, "the scene and the light's depth images", scene_bytes + needed.max(sorting))?;
        let mut images = Vec::new();
        let mut triangles = 0;
        for grid in &image_grids {
            let held: u64 = scene_bytes + images.iter().map(DepthImage::memory_bytes).sum::<u64>();
            let room = options.max_memory_bytes.map(|limit| limit.saturating_sub(held));
            let (image, casting) = match DepthImage::capture(scene, grid, image_options, room, cancel) {
                Ok(captured) => captured,
                Err(bytes) => {
                    let limit = options.max_memory_bytes.unwrap_or_default();
                    return Err(Error::memory("the light's depth images", held + bytes, limit));
                }
            };
            if cancel.load(Ordering::Relaxed) {
                return Err(Error::interrupted());
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
        let prepared =
            Self { space, regions, settings, sun: options.sun, images, scene_bytes, image_seconds };
        check_memory(options, "the light's depth images", prepared.held_bytes())?;
        Ok(prepared)
    }

    /// Bytes of the scene and the images.
    fn held_bytes(&self) -> u64 {
        self.scene_bytes + self.images.iter().map(DepthImage::memory_bytes).sum::<u64>()
    }

    /// Builds and reduces the tree, reporting progress now and then. `options` must be those given to
    /// [`PreparedTree::new`], except for builder, reduction and pruning.
    ///
    /// # Errors
    /// Returns [`adumbra_bake::Error::Interrupted`], or an error if the graph does not fit.
    pub fn build(&self, options: &TreeOptions, watch: Watch<'_, TreeProgress>) -> Result<BakedTree> {
        let start = Instant::now();
        let pyramids = if options.prune { self.images.iter().map(Pyramid::bytes_of).sum() } else { 0 };
        check_memory(options, "the pyramids over the depth images", self.held_bytes() + pyramids)?;
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
        let step = |tree_bytes: u64, done_share: f64| {
            if watch.cancel.load(Ordering::Relaxed) {
                return Err(Error::interrupted());
            }
            (watch.progress)(TreeProgress { done_share, voxels, tree_bytes });
            check_memory(options, "the tree so far", held + tree_bytes)
        };
        let built = Instant::now();
        let blocks = match options.reduction {
            Reduction::Hash => {
                let mut sink = Interned::default();
                let root = builder.build(&space, depth, prune, &mut sink, &|s: &Interned, share| {
                    step(s.memory_bytes(), share)
                })?;
                report.held_bytes = sink.memory_bytes();
                sink.finish(root)
            }
            Reduction::TreeHash => {
                let mut sink = TreeHashed::default();
                let root = builder.build(&space, depth, prune, &mut sink, &|s: &TreeHashed, share| {
                    step(s.memory_bytes(), share)
                })?;
                report.held_bytes = sink.memory_bytes();
                report.collisions = Some(sink.collisions());
                sink.finish(root)
            }
            Reduction::Sort => {
                let mut blocks: Vec<[Word; 8]> = Vec::new();
                let root = builder.build(&space, depth, prune, &mut blocks, &|b: &Vec<_>, share| {
                    // Sorting needs one more key and two more numbers per block.
                    step(b.memory_bytes() * 5 / 2, share)
                })?;
                Blocks { root, blocks }
            }
        };
        (watch.progress)(TreeProgress { done_share: 1.0, voxels, tree_bytes: report.held_bytes });
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
        // The words, plus two numbers per block while the words are made.
        let numbering_bytes = blocks_bytes + blocks.blocks.len() as u64 * 40;
        check_memory(options, "numbering the tree", held + numbering_bytes)?;
        let tree = blocks.number(depth);
        report.reduce_seconds = reducing.elapsed().as_secs_f64();
        report.seconds = self.image_seconds + start.elapsed().as_secs_f64();
        Ok(BakedTree {
            space: self.space,
            regions: self.regions.clone(),
            settings: self.settings,
            sun: self.sun,
            tree,
            report,
        })
    }

    /// Returns the width of the penumbra at every leaf voxel of `tree`, in eighths of a voxel, in the order
    /// of [`crate::tree::attribute`].
    ///
    /// # Errors
    /// Returns an error if the number of leaf voxels exceeds 32 bits.
    pub fn penumbra(&self, tree: &VoxelTree) -> Result<Vec<u8>> {
        let space = LitSpace::new(&self.images, &self.space, &self.regions, false);
        let index = AttributeIndex::of(tree)?;
        Ok(gather(tree, &index, &|xyz, level| space.penumbra_eighths(xyz, level)))
    }
}

/// Bakes `scene` into a world-aligned tree.
///
/// # Errors
/// Returns the errors of [`PreparedTree::new`] and [`PreparedTree::build`].
pub fn bake_tree(scene: &Scene, options: &TreeOptions, watch: Watch<'_, TreeProgress>) -> Result<BakedTree> {
    PreparedTree::new(scene, options, watch.cancel)?.build(options, watch)
}

fn check_memory(options: &TreeOptions, what: &'static str, needed_bytes: u64) -> Result<()> {
    match options.max_memory_bytes {
        Some(limit_bytes) if needed_bytes > limit_bytes => {
            Err(Error::memory(what, needed_bytes, limit_bytes))
        }
        _ => Ok(()),
    }
}
