//! The spans of time in which points are lit.

/// The times at which each point of a list sees the sun.
#[derive(Clone, Debug, PartialEq)]
pub struct Hours {
    /// Times of the steps, and of the end of the last, seconds after 1970.
    times: Vec<f64>,
    /// For each point in turn, pairs of steps: the step at which light begins, and the step before which it
    /// ends.
    edges: Vec<u32>,
    /// End of each point's edges.
    ends: Vec<usize>,
    rays: u64,
}

/// The spans of some points.
#[derive(Default)]
pub(super) struct Block {
    pub(super) edges: Vec<u32>,
    /// Number of edges of each point.
    pub(super) counts: Vec<u32>,
    pub(super) rays: u64,
}

impl Block {
    /// Adds a lit span to the point that began at edge `first`, joined with the last span if there is no gap.
    pub(super) fn push(&mut self, first: usize, [begin, end]: [u32; 2]) {
        match self.edges[first..].last_mut() {
            Some(last) if *last == begin => *last = end,
            _ => self.edges.extend([begin, end]),
        }
    }
}

impl Hours {
    pub(super) fn new(times: Vec<f64>, blocks: &[Block]) -> Self {
        let edges = blocks.iter().flat_map(|block| &block.edges).copied().collect();
        let counts = blocks.iter().flat_map(|block| &block.counts);
        let ends = counts.scan(0, |end, &count| {
            *end += count as usize;
            Some(*end)
        });
        Self { times, edges, ends: ends.collect(), rays: blocks.iter().map(|block| block.rays).sum() }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Number of rays that were traced.
    pub fn rays(&self) -> u64 {
        self.rays
    }

    /// Times of the steps, and of the end of the last, seconds after 1970.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// The spans of steps in which a point is lit, in order: first step, and the step after the last. Empty
    /// for a point that does not exist.
    pub fn steps(&self, point: usize) -> &[[u32; 2]] {
        let begin = point.checked_sub(1).and_then(|before| self.ends.get(before)).copied().unwrap_or(0);
        let end = self.ends.get(point).copied().unwrap_or(begin);
        self.edges[begin..end].as_chunks().0
    }

    /// The spans in which a point is lit, in order, seconds after 1970.
    pub fn spans(&self, point: usize) -> impl Iterator<Item = [f64; 2]> {
        self.steps(point).iter().map(|span| span.map(|step| self.times[step as usize]))
    }

    /// Time for which a point is lit, in seconds.
    pub fn seconds(&self, point: usize) -> f64 {
        self.spans(point).fold(0.0, |sum, [begin, end]| sum + (end - begin))
    }

    /// Returns the share of time in which two results for the same points and steps differ. `None` if the
    /// points or steps are different.
    pub fn difference(&self, other: &Self) -> Option<f64> {
        if self.times != other.times || self.len() != other.len() {
            return None;
        }
        let steps = self.times.len().saturating_sub(1);
        let mut differing = 0_u64;
        for point in 0..self.len() {
            let lit = |hours: &Self| {
                let mut lit = vec![false; steps];
                hours.steps(point).iter().for_each(|&[a, b]| lit[a as usize..b as usize].fill(true));
                lit
            };
            differing += lit(self).iter().zip(lit(other)).filter(|&(&a, b)| a != b).count() as u64;
        }
        Some(differing as f64 / (steps * self.len()).max(1) as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_are_joined_and_counted_by_point() {
        let mut block = Block::default();
        block.push(0, [1, 3]);
        block.push(0, [3, 4]);
        block.push(0, [6, 7]);
        block.counts = vec![4, 0];
        let mut next = Block { rays: 5, ..Block::default() };
        next.push(0, [4, 6]);
        next.counts = vec![2];
        let times = (0..8).map(|i| f64::from(i) * 60.0).collect();
        let hours = Hours::new(times, &[block, next]);
        assert_eq!((hours.len(), hours.rays()), (3, 5));
        assert_eq!(hours.steps(0), [[1, 4], [6, 7]]);
        assert!(hours.steps(1).is_empty() && hours.steps(3).is_empty());
        assert_eq!(hours.steps(2), [[4, 6]]);
        assert_eq!([0, 1, 2].map(|point| hours.seconds(point)), [240.0, 0.0, 120.0]);
        assert!(hours.seconds(1).is_sign_positive(), "it would be shown as -0");
        assert_eq!(hours.spans(2).collect::<Vec<_>>(), [[240.0, 360.0]]);
    }

    #[test]
    fn difference_is_the_share_of_differing_steps() {
        let of = |spans: &[[u32; 2]]| {
            let mut block = Block::default();
            spans.iter().for_each(|&span| block.push(0, span));
            block.counts = vec![block.edges.len() as u32];
            Hours::new((0..=10).map(f64::from).collect(), &[block])
        };
        assert_eq!(of(&[[0, 5]]).difference(&of(&[[1, 6]])), Some(0.2));
        assert_eq!(of(&[[0, 5]]).difference(&of(&[[0, 5]])), Some(0.0));
        assert_eq!(of(&[[0, 10]]).difference(&Hours::new(vec![0.0, 1.0], &[])), None);
    }
}
