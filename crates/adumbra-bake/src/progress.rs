//! Progress and statistics of a bake, and how a caller watches it.

use std::sync::atomic::AtomicBool;

/// Progress of a bake.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Finished units: root blocks of a bake, cubes of a tree, blocks of points.
    pub done: usize,
    /// Total number of units.
    pub total: usize,
    /// Texels per unit; voxels of a tree, and points.
    pub texels_per_unit: u64,
    /// Bytes of the result so far.
    pub result_bytes: u64,
}

/// Statistics of a finished bake. They vary from run to run and are never written into the file.
#[derive(Clone, Copy, Debug, Default)]
pub struct Report {
    /// Wall-clock time in seconds.
    pub seconds: f64,
    /// Number of root blocks.
    pub root_blocks: usize,
    /// Number of root blocks that were not baked, because entries of an earlier bake have them.
    pub reused_root_blocks: usize,
    /// Number of worker threads.
    pub threads: usize,
    /// Texels that were evaluated one by one.
    pub drawn_texels: u64,
    /// Largest sum of the bytes that the bake accounted for: scene, root blocks, tree.
    pub accounted_bytes: u64,
    /// Bytes that were written to disk because of the memory limit, counted each time they were written.
    pub spilled_bytes: u64,
}

impl Report {
    /// Returns the statistics of this work and of more, one after the other.
    pub(crate) fn with(&self, more: &Self) -> Self {
        Self {
            seconds: self.seconds + more.seconds,
            root_blocks: self.root_blocks + more.root_blocks,
            reused_root_blocks: self.reused_root_blocks + more.reused_root_blocks,
            threads: self.threads.max(more.threads),
            drawn_texels: self.drawn_texels + more.drawn_texels,
            accounted_bytes: self.accounted_bytes.max(more.accounted_bytes),
            spilled_bytes: self.spilled_bytes + more.spilled_bytes,
        }
    }
}

/// A caller's hooks into long-running work: progress reports and cancellation.
#[derive(Clone, Copy)]
pub struct Watch<'a, P = Progress> {
    /// Called from worker threads.
    pub progress: &'a (dyn Fn(P) + Sync),
    /// Set to true to end the work early with an error.
    pub cancel: &'a AtomicBool,
}

/// The flag of work that nothing interrupts.
pub(crate) static NEVER: AtomicBool = AtomicBool::new(false);

impl<P> Watch<'static, P> {
    /// Returns a watch without progress reports or cancellation.
    pub fn none() -> Self {
        Self { progress: &|_| {}, cancel: &NEVER }
    }
}

impl<'a, P> Watch<'a, P> {
    /// Creates a watch from a progress callback and a cancel flag.
    pub fn new(progress: &'a (dyn Fn(P) + Sync), cancel: &'a AtomicBool) -> Self {
        Self { progress, cancel }
    }
}
