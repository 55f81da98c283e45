//! Counters of a running bake: root blocks, texels, seconds, bytes.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::Instant;

use crate::error::Result;
use crate::plan::Plan;
use crate::progress::{Progress, Report};

pub(crate) struct Tally<'a, 's> {
    plan: &'a Plan<'s>,
    progress: &'a (dyn Fn(Progress) + Sync),
    start: Instant,
    total: usize,
    done: AtomicUsize,
    drawn_texels: AtomicU64,
    accounted_bytes: AtomicU64,
}

impl<'a, 's> Tally<'a, 's> {
    pub(crate) fn new(
        plan: &'a Plan<'s>,
        total: usize,
        start: Instant,
        progress: &'a (dyn Fn(Progress) + Sync),
    ) -> Self {
        let (done, drawn_texels, accounted_bytes) = Default::default();
        Self { plan, progress, start, total, done, drawn_texels, accounted_bytes }
    }

    /// Adds texels that were evaluated one by one.
    pub(crate) fn drew(&self, texels: u64) {
        self.drawn_texels.fetch_add(texels, Ordering::Relaxed);
    }

    /// Records a finished root block. `held_bytes` is the size of the structure so far, apart from its pages;
    /// `result_bytes` is the size of the result so far.
    ///
    /// # Errors
    /// Returns [`Error::MemoryLimit`](crate::Error::MemoryLimit) if the limit is exceeded, and
    /// [`Error::Spill`](crate::Error::Spill) if pages could not be written or read.
    pub(crate) fn finished_root_block(
        &self,
        what: &'static str,
        held_bytes: u64,
        result_bytes: u64,
    ) -> Result<()> {
        let plan = self.plan;
        let held = plan.baking_bytes() + held_bytes + plan.paged_bytes()?;
        self.accounted_bytes.fetch_max(held, Ordering::Relaxed);
        plan.check_memory(what, held)?;
        (self.progress)(Progress {
            done: self.done.fetch_add(1, Ordering::Relaxed) + 1,
            total: self.total,
            texels_per_unit: 1 << (2 * plan.root_blocks.root_level),
            result_bytes,
        });
        Ok(())
    }

    /// Checks the memory after the last root block, when `held_bytes` are needed besides the scene and the
    /// pages.
    ///
    /// # Errors
    /// Returns the errors of [`Tally::finished_root_block`].
    pub(crate) fn check_end(&self, what: &'static str, held_bytes: u64) -> Result<()> {
        let held = self.plan.scene_bytes + held_bytes + self.plan.paged_bytes()?;
        self.accounted_bytes.fetch_max(held, Ordering::Relaxed);
        self.plan.check_memory(what, held)
    }

    /// Returns the statistics up to now.
    pub(crate) fn report(&self) -> Report {
        Report {
            seconds: self.start.elapsed().as_secs_f64(),
            root_blocks: self.total,
            reused_root_blocks: 0,
            threads: self.plan.workers,
            drawn_texels: self.drawn_texels.load(Ordering::Relaxed),
            accounted_bytes: self.accounted_bytes.load(Ordering::Relaxed),
            spilled_bytes: self.plan.spill.spilled_bytes(),
        }
    }
}
