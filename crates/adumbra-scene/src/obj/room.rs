//! Vectors that grow within the memory budget: their memory is counted before it is allocated.

use crate::Result;
use crate::budget::Budget;

/// Makes room for `more` elements: doubles the capacity if it is too small. `what` describes the elements in
/// the error.
///
/// # Errors
/// Returns [`crate::Error::SceneMemory`] if the vector and its larger copy exceed the budget.
pub(super) fn make_room<T>(
    budget: &Budget<'_>,
    list: &mut Vec<T>,
    more: usize,
    what: impl FnOnce() -> String,
) -> Result<()> {
    let needed = list.len().saturating_add(more);
    let before = list.capacity();
    if needed <= before {
        return Ok(());
    }
    let capacity = needed.max(before.saturating_mul(2));
    budget.charge((capacity as u64).saturating_mul(size_of::<T>() as u64), what)?;
    list.reserve_exact(capacity - list.len());
    budget.release(held(before, size_of::<T>()));
    Ok(())
}

/// Frees unused capacity.
pub(super) fn shrink<T>(budget: &Budget<'_>, list: &mut Vec<T>) {
    let before = list.capacity();
    list.shrink_to_fit();
    budget.release(held(before.saturating_sub(list.capacity()), size_of::<T>()));
}

/// Frees a vector.
pub(super) fn free<T>(budget: &Budget<'_>, list: Vec<T>) {
    budget.release(held(list.capacity(), size_of::<T>()));
    drop(list);
}

fn held(elements: usize, each: usize) -> u64 {
    (elements as u64).saturating_mul(each as u64)
}
