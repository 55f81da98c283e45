//! The bake: scene and sun in, graph out. Light-aligned, tile by tile on all cores; the depth image is never whole.
//!
//! Source: Sintorn et al. 2014 for the light-aligned voxel DAG; the specification's §3 for what a column allows. The
//! result does not depend on the number of threads, the order of tiles or of triangles, or the memory limit.

pub(crate) mod capture;
pub(crate) mod casters;
pub(crate) mod columns;
mod estimate;
mod masked;
pub(crate) mod options;
pub(crate) mod project;
#[cfg(test)]
mod reference;
pub(crate) mod sink;
mod tile;

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Instant;

use capture::{CaptureBuffers, TileRect, capture};
use casters::{CasterOptions, Casters};
use columns::{ColumnRules, Columns};
pub use estimate::{Estimate, estimate};
pub use options::{MAX_RESOLUTION, MIN_RESOLUTION, Options, Preset, Size};

use crate::dag::Dag;
use crate::dag::store::{NodeState, NodeStore};
use crate::error::{Error, Result};
use crate::light::{LightExtent, LightGrid};
use crate::scene::Scene;
use crate::settings::Settings;

/// A finished bake.
#[derive(Debug)]
pub struct Baked {
    /// Where the grid lies.
    pub grid: LightGrid,
    /// What was asked for.
    pub settings: Settings,
    /// The answers.
    pub dag: Dag,
    /// How it went.
    pub report: Report,
}

/// How a bake went. Varies from run to run; never written into the file.
#[derive(Clone, Copy, Debug, Default)]
pub struct Report {
    /// Wall seconds.
    pub seconds: f64,
    /// Tiles drawn.
    pub tiles: usize,
    /// Threads that drew them.
    pub threads: usize,
    /// Largest sum of the bytes that the bake accounted for: scene, tiles, graph.
    pub accounted_bytes: u64,
}

/// Where a bake stands.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Tiles done.
    pub done_tiles: usize,
    /// Tiles in all.
    pub total_tiles: usize,
    /// Texels a tile.
    pub texels_per_tile: u64,
    /// Bytes of the graph so far.
    pub graph_bytes: u64,
}

/// Bakes `scene`.
///
/// `progress` is called from worker threads after each tile; `cancel` is looked at before each. Runs on the current
/// rayon pool. Cost: time grows with texels times layers; memory with the scene and the graph.
///
/// # Errors
/// An option out of range, a grid or graph that does not fit `max_memory_bytes`, or [`Error::Interrupted`].
pub fn bake(
    scene: &Scene,
    options: &Options,
    progress: &(dyn Fn(Progress) + Sync),
    cancel: &AtomicBool,
) -> Result<Baked> {
    let start = Instant::now();
    let plan = Plan::new(scene, options)?;
    let (tiles_x, tiles_y, roots_z) = (plan.top_dims[0], plan.top_dims[1], plan.top_dims[2]);
    let tile_count = (tiles_x * tiles_y) as usize;
    let shared = Mutex::new(Shared {
        store: NodeStore::default(),
        top: vec![NodeState::Lit; tile_count * roots_z as usize],
        done: 0,
        accounted: 0,
    });
    let next_tile = AtomicUsize::new(0);
    let failure = Mutex::new(None);
    rayon::scope(|scope| {
        for _ in 0..plan.workers {
            scope.spawn(|_| {
                let mut worker = Worker::default();
                loop {
                    let tile = next_tile.fetch_add(1, Ordering::Relaxed);
                    if tile >= tile_count {
                        break;
                    }
                    let outcome = if cancel.load(Ordering::Relaxed) {
                        Err(Error::Interrupted)
                    } else {
                        let roots = worker.bake_tile(&plan, tile);
                        plan.merge(&shared, &worker.store, tile, roots, progress)
                    };
                    if let Err(error) = outcome {
                        next_tile.store(tile_count, Ordering::Relaxed);
                        failure.lock().unwrap_or_else(|e| e.into_inner()).get_or_insert(error);
                        break;
                    }
                }
            });
        }
    });
    if let Some(error) = failure.into_inner().unwrap_or_else(|e| e.into_inner()) {
        return Err(error);
    }
    let Shared { store, top, accounted, .. } = shared.into_inner().unwrap_or_else(|e| e.into_inner());
    let numbering_bytes = 2 * store.graph_bytes();
    plan.check_memory("numbering the graph", plan.scene_bytes + store.memory_bytes() + numbering_bytes)?;
    let dag = store.finish(plan.grid.size, plan.root_level, plan.top_dims, &top);
    Ok(Baked {
        grid: plan.grid,
        settings: plan.settings,
        dag,
        report: Report {
            seconds: start.elapsed().as_secs_f64(),
            tiles: tile_count,
            threads: plan.workers,
            accounted_bytes: accounted.max(plan.scene_bytes + store.memory_bytes() + numbering_bytes),
        },
    })
}

/// What is settled before the first tile.
struct Plan<'s> {
    grid: LightGrid,
    settings: Settings,
    rules: ColumnRules,
    casters: Casters<'s>,
    root_level: u32,
    top_dims: [u32; 3],
    workers: usize,
    scene_bytes: u64,
    worker_bytes: u64,
    limit_bytes: Option<u64>,
}

struct Shared {
    store: NodeStore,
    top: Vec<NodeState>,
    done: usize,
    accounted: u64,
}

/// Smallest and largest level of the root cubes.
const ROOT_LEVELS: (u32, u32) = (5, 10);
/// Root cubes that the top grid aims at across the longer side, as a level.
const TOP_GRID_LEVEL: u32 = 5;

impl<'s> Plan<'s> {
    fn new(scene: &'s Scene, options: &Options) -> Result<Self> {
        options.check()?;
        let mut extent = LightExtent::empty(&options.sun);
        match &options.bounds {
            Some(bounds) => extent.add_box(bounds),
            None => add_casters(&mut extent, scene),
        }
        let (resolution, voxel_size) = options.size.resolve(extent.longest_side())?;
        let grid = LightGrid::covering(options.sun, &extent, voxel_size);
        if f64::from(grid.size[2]) > project::DEPTH_MAX_VOXELS {
            return Err(Error::OptionRange {
                option: "--resolution",
                value: format!("{resolution} ({} voxels along the light)", grid.size[2]),
                range: "coarse enough for at most 2097152 voxels along the light; lower it",
            });
        }
        let root_level =
            (resolution.ilog2().saturating_sub(TOP_GRID_LEVEL)).clamp(ROOT_LEVELS.0, ROOT_LEVELS.1);
        let top_dims = grid.size.map(|s| s.div_ceil(1 << root_level));
        let rules = ColumnRules {
            bias: options.bias,
            thickness_voxels: options.thickness_world / voxel_size,
            assume_ground: options.assume_ground,
            receivers: options.receivers,
            depth_voxels: grid.size[2],
        };
        let caster_options =
            CasterOptions { closed_regions: options.closed_regions, ignore_alpha: options.ignore_alpha };
        let reach = rules.reach_texels() + 1.0;
        let casters =
            Casters::new(scene, caster_options, &grid, 1 << root_level, [top_dims[0], top_dims[1]], reach);
        let settings = Settings {
            resolution,
            thickness_world: options.thickness_world,
            assume_ground: options.assume_ground,
            closed_regions: options.closed_regions,
            ignore_alpha: options.ignore_alpha,
            receivers: options.receivers,
            bounds: options.bounds,
            bias: options.bias,
            triangles: casters.instanced_triangles(),
            instances: scene.instances.iter().filter(|i| i.casts).count() as u64,
        };
        // A root's state while baking, and its word of the finished graph.
        let roots: u64 = top_dims.iter().map(|&n| u64::from(n)).product();
        let top_bytes = roots * (size_of::<NodeState>() as u64 + 4);
        let scene_bytes = scene.memory_bytes() + casters.memory_bytes() + top_bytes;
        let worker_bytes = capture::working_bytes(1 << (2 * root_level));
        let mut plan = Self {
            grid,
            settings,
            rules,
            casters,
            root_level,
            top_dims,
            workers: rayon::current_num_threads(),
            scene_bytes,
            worker_bytes,
            limit_bytes: options.max_memory_bytes,
        };
        if let Some(limit) = plan.limit_bytes {
            // Fewer workers rather than none; half of what is left is for the graph.
            let room = limit.saturating_sub(scene_bytes) / 2;
            plan.workers = plan.workers.min((room / worker_bytes) as usize).max(1);
        }
        plan.check_memory("the scene and one tile", scene_bytes + worker_bytes)?;
        Ok(plan)
    }

    fn check_memory(&self, what: &'static str, needed_bytes: u64) -> Result<()> {
        match self.limit_bytes {
            Some(limit_bytes) if needed_bytes > limit_bytes => {
                Err(Error::MemoryLimit { what, needed_bytes, limit_bytes })
            }
            _ => Ok(()),
        }
    }

    fn tile_rect(&self, tile: usize) -> TileRect {
        let side = 1 << self.root_level;
        let (tx, ty) = (tile as u32 % self.top_dims[0], tile as u32 / self.top_dims[0]);
        let (x, y) = (tx * side, ty * side);
        TileRect { x, y, width: side.min(self.grid.size[0] - x), height: side.min(self.grid.size[1] - y) }
    }

    /// Takes a tile's nodes into the shared store.
    fn merge(
        &self,
        shared: &Mutex<Shared>,
        tile_store: &NodeStore,
        tile: usize,
        mut roots: Vec<NodeState>,
        progress: &(dyn Fn(Progress) + Sync),
    ) -> Result<()> {
        let mut shared = shared.lock().unwrap_or_else(|e| e.into_inner());
        if !shared.store.has_room_for(tile_store) {
            let needed_bytes = 8 << 30;
            return Err(Error::MemoryLimit {
                what: "a graph of more than 2^31 words",
                needed_bytes,
                limit_bytes: needed_bytes,
            });
        }
        shared.store.absorb(tile_store, &mut roots);
        let layer = (self.top_dims[0] * self.top_dims[1]) as usize;
        for (k, root) in roots.into_iter().enumerate() {
            shared.top[k * layer + tile] = root;
        }
        shared.done += 1;
        let bytes = self.scene_bytes
            + self.workers as u64 * (self.worker_bytes + tile_store.memory_bytes())
            + shared.store.memory_bytes()
            // The renumbering of the tile just taken in.
            + tile_store.graph_bytes();
        shared.accounted = shared.accounted.max(bytes);
        self.check_memory("the graph so far", bytes)?;
        progress(Progress {
            done_tiles: shared.done,
            total_tiles: layer,
            texels_per_tile: 1 << (2 * self.root_level),
            graph_bytes: shared.store.graph_bytes(),
        });
        Ok(())
    }
}

/// What one thread reuses from tile to tile.
#[derive(Default)]
struct Worker {
    buffers: CaptureBuffers,
    columns: Columns,
    store: NodeStore,
}

impl Worker {
    /// The root cubes of a tile, nearest first, in this worker's own store.
    fn bake_tile(&mut self, plan: &Plan<'_>, tile: usize) -> Vec<NodeState> {
        self.store.clear();
        let rect = plan.tile_rect(tile);
        capture(&plan.casters, tile, &plan.grid, &plan.rules, rect, &mut self.buffers, &mut self.columns);
        tile::build_roots(&self.columns, plan.root_level, plan.top_dims[2], &mut self.store)
    }
}

fn add_casters(extent: &mut LightExtent, scene: &Scene) {
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh as usize];
        for &v in mesh.triangles.iter().flatten() {
            extent.add(instance.to_world(mesh.positions[v as usize]));
        }
    }
}
