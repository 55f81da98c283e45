//! Lists of corners, held one after another, with their memory counted before it is allocated.

use crate::Result;
use crate::budget::Budget;

/// Polygons or triangle strips with three or more corners.
#[derive(Debug, Default)]
pub(super) struct Polygons {
    /// The corners of all polygons, as vertex indices.
    pub(super) corners: Vec<u32>,
    /// The end of each polygon in `corners`.
    ends: Vec<usize>,
}

impl Polygons {
    /// Makes room for `more` corners.
    ///
    /// # Errors
    /// Returns [`Error::SceneMemory`](crate::Error::SceneMemory).
    pub(super) fn make_room(&mut self, more: usize, budget: &Budget<'_>) -> Result<()> {
        let corners = self.corners.len() + more;
        grow(&mut self.corners, more, budget, || format!("{corners} corners of faces"))
    }

    /// Ends the current polygon, and returns how many corners it has. A polygon with fewer than three corners
    /// is removed.
    ///
    /// # Errors
    /// Returns [`Error::SceneMemory`](crate::Error::SceneMemory).
    pub(super) fn end(&mut self, budget: &Budget<'_>) -> Result<usize> {
        let from = self.ends.last().copied().unwrap_or(0);
        let corners = self.corners.len() - from;
        if corners < 3 {
            self.corners.truncate(from);
            return Ok(corners);
        }
        let all = self.ends.len() + 1;
        grow(&mut self.ends, 1, budget, || format!("{all} faces"))?;
        self.ends.push(self.corners.len());
        Ok(corners)
    }

    pub(super) fn count(&self) -> u64 {
        self.ends.len() as u64
    }

    /// Number of triangles that the polygons are cut into, or that the strips state.
    pub(super) fn triangles(&self) -> usize {
        self.corners.len() - 2 * self.ends.len()
    }

    /// The largest number of corners of a polygon.
    pub(super) fn largest(&self) -> usize {
        self.iter().map(<[u32]>::len).max().unwrap_or(0)
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let starts = std::iter::once(&0).chain(&self.ends);
        starts.zip(&self.ends).map(|(&from, &end)| self.corners.get(from..end).unwrap_or_default())
    }
}

/// Makes room for `more` items of a list. Its capacity at least doubles, so that the time stays linear.
fn grow<T>(list: &mut Vec<T>, more: usize, budget: &Budget<'_>, what: impl FnOnce() -> String) -> Result<()> {
    let (length, capacity) = (list.len(), list.capacity());
    if capacity - length >= more {
        return Ok(());
    }
    let bytes = |items: usize| (items as u64).saturating_mul(size_of::<T>() as u64);
    let wanted = length.saturating_add(more).max(2 * capacity);
    budget.charge(bytes(wanted), what)?;
    list.reserve_exact(wanted - length);
    budget.release(bytes(capacity));
    Ok(())
}
