//! What a bake counts on its way: tiles, texels, seconds, bytes.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::Instant;

use super::plan::Plan;
use super::{Progress, Report};
use crate::error::Result;

pub(super) struct Tally<'a, 's> {
    plan: &'a Plan<'s>,
    progress: &'a (dyn Fn(Progress) + Sync),
    start: Instant,
    done_tiles: AtomicUsize,
    drawn_texels: AtomicU64,
    accounted_bytes: AtomicU64,
}

impl<'a, 's> Tally<'a, 's> {
    pub(super) fn new(plan: &'a Plan<'s>, start: Instant, progress: &'a (dyn Fn(Progress) + Sync)) -> Self {
        let (done_tiles, drawn_texels, accounted_bytes) = Default::default();
        Self { plan, progress, start, done_tiles, drawn_texels, accounted_bytes }
    }

    /// Texels were looked at one by one.
    pub(super) fn drew(&self, texels: u64) {
        self.drawn_texels.fetch_add(texels, Ordering::Relaxed);
    }

    /// A tile is done; what has been built takes `held_bytes` beside its pages, and `result_bytes` are the result so far.
    ///
    /// # Errors
    /// [`Error::MemoryLimit`](crate::Error::MemoryLimit); [`Error::Io`](crate::Error::Io) where pages could not be written or read.
    pub(super) fn finished_tile(&self, what: &'static str, held_bytes: u64, result_bytes: u64) -> Result<()> {
        let plan = self.plan;
        let held = plan.baking_bytes() + held_bytes + plan.paged_bytes()?;
        self.accounted_bytes.fetch_max(held, Ordering::Relaxed);
        plan.check_memory(what, held)?;
        (self.progress)(Progress {
            done_tiles: self.done_tiles.fetch_add(1, Ordering::Relaxed) + 1,
            total_tiles: plan.tiles(),
            texels_per_tile: 1 << (2 * plan.root_level),
            graph_bytes: result_bytes,
        });
        Ok(())
    }

    /// After the last tile `held_bytes` are needed beside the scene and pages, which make room for them.
    ///
    /// # Errors
    /// As [`Tally::finished_tile`].
    pub(super) fn check_end(&self, what: &'static str, held_bytes: u64) -> Result<()> {
        self.plan.make_room(held_bytes);
        let held = self.plan.scene_bytes + held_bytes + self.plan.paged_bytes()?;
        self.accounted_bytes.fetch_max(held, Ordering::Relaxed);
        self.plan.check_memory(what, held)
    }

    /// How it went, up to now.
    pub(super) fn report(&self) -> Report {
        Report {
            seconds: self.start.elapsed().as_secs_f64(),
            tiles: self.plan.tiles(),
            threads: self.plan.workers,
            drawn_texels: self.drawn_texels.load(Ordering::Relaxed),
            accounted_bytes: self.accounted_bytes.load(Ordering::Relaxed),
            spilled_bytes: self.plan.spill.as_ref().map_or(0, |spill| spill.spilled_bytes()),
        }
    }
}
