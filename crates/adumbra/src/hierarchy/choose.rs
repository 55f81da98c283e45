//! Which depth a block's columns share, and which need their own: intervals `[e, x]` in, intervals out.

/// The x of what nobody asks.
pub(super) use crate::bake::columns::BESIDE_GRID;
/// The least x of an interval without an end.
pub(super) use crate::bake::columns::FREE_TO_END;

/// What several intervals have in common.
pub(super) fn intersection(intervals: impl IntoIterator<Item = [u32; 2]>) -> [u32; 2] {
    intervals.into_iter().fold([0, u32::MAX], |[e, x], i| [e.max(i[0]), x.min(i[1])])
}

/// Whether any depth lies in an interval.
pub(super) fn holds_any([e, x]: [u32; 2]) -> bool {
    e <= x
}

/// A depth that lies in as many of the intervals as one can, widened to all that lie in the same ones: the nearest where several do.
/// Intervals without an end do not count. None where there are no others.
pub(super) fn most_shared(intervals: &[[u32; 2]]) -> Option<[u32; 2]> {
    let finite = || intervals.iter().filter(|i| i[1] < FREE_TO_END);
    let shared = |depth: u32| finite().filter(move |i| i[0] <= depth && depth <= i[1]);
    // The most is reached where one of them begins.
    let best = finite().map(|i| i[0]).max_by_key(|&e| (shared(e).count(), std::cmp::Reverse(e)))?;
    Some(intersection(shared(best).copied()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choose_takes_the_depth_that_most_intervals_hold() {
        assert_eq!(most_shared(&[[5, 9], [7, 12], [20, 30]]), Some([7, 9]));
        assert_eq!(most_shared(&[[20, 30], [5, 9]]), Some([5, 9]));
        assert_eq!(most_shared(&[[3, FREE_TO_END], [8, 8]]), Some([8, 8]));
        assert_eq!(most_shared(&[[3, FREE_TO_END]]), None);
    }
}
