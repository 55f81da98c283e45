//! Chooses which depth a block's columns share and which columns need their own, as intervals `[e, x]`.

use crate::columns::rules::FREE_TO_END;

/// Returns the intersection of several intervals.
pub(crate) fn intersection(intervals: impl IntoIterator<Item = [u32; 2]>) -> [u32; 2] {
    intervals.into_iter().fold([0, u32::MAX], |[e, x], i| [e.max(i[0]), x.min(i[1])])
}

/// Whether an interval contains any depth.
pub(crate) fn holds_any([e, x]: [u32; 2]) -> bool {
    e <= x
}

/// Finds a depth that as many intervals as possible contain, and widens it to all depths in the same
/// intervals. The nearest is chosen if several qualify. Intervals without an end are ignored. Returns `None`
/// if there are no others.
pub(crate) fn most_shared(intervals: &[[u32; 2]]) -> Option<[u32; 2]> {
    let finite = || intervals.iter().filter(|i| i[1] < FREE_TO_END);
    let shared = |depth: u32| finite().filter(move |i| i[0] <= depth && depth <= i[1]);
    // The maximum is reached where one of the intervals begins.
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
