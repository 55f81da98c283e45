//! The spans of time in which points are lit.

/// The times at which each point of a list sees the sun.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hours {
    /// For each point in turn, its spans in order: begin and end, seconds after 1970.
    spans: Vec<[f64; 2]>,
    /// End of each point's spans.
    ends: Vec<usize>,
}

/// Spans that are closer together are one, and shorter ones are none: surfaces that touch leave such gaps by
/// rounding.
const LEAST_SECONDS: f64 = 0.002;

impl Hours {
    /// Adds a point that is lit in `spans`, which are in order, and may touch.
    pub(super) fn push(&mut self, spans: impl IntoIterator<Item = [f64; 2]>) {
        let first = self.spans.len();
        for [begin, end] in spans {
            match self.spans[first..].last_mut() {
                Some(last) if begin - last[1] < LEAST_SECONDS => last[1] = end,
                _ => self.spans.push([begin, end]),
            }
        }
        let mut kept = first;
        for at in first..self.spans.len() {
            let [begin, end] = self.spans[at];
            if end - begin >= LEAST_SECONDS {
                self.spans[kept] = [begin, end];
                kept += 1;
            }
        }
        self.spans.truncate(kept);
        self.ends.push(kept);
    }

    /// Adds the points of others.
    pub(super) fn append(&mut self, others: &Self) {
        let first = self.spans.len();
        self.spans.extend_from_slice(&others.spans);
        self.ends.extend(others.ends.iter().map(|end| first + end));
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Bytes of the spans.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&*self.spans) + size_of_val(&*self.ends)) as u64
    }

    /// The spans in which a point is lit, in order, seconds after 1970. Empty for a point that does not
    /// exist.
    pub fn spans(&self, point: usize) -> &[[f64; 2]] {
        let begin = point.checked_sub(1).and_then(|before| self.ends.get(before)).copied().unwrap_or(0);
        let end = self.ends.get(point).copied().unwrap_or(begin);
        &self.spans[begin..end]
    }

    /// Time for which a point is lit, in seconds.
    pub fn seconds(&self, point: usize) -> f64 {
        self.spans(point).iter().fold(0.0, |sum, [begin, end]| sum + (end - begin))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_are_joined_and_counted_by_point() {
        let mut hours = Hours::default();
        hours.push([[60.0, 180.0], [180.001, 240.0], [300.0, 300.001], [360.0, 420.0]]);
        hours.push([]);
        let mut more = Hours::default();
        more.push([[240.0, 360.0]]);
        hours.append(&more);
        assert_eq!(hours.len(), 3);
        assert_eq!(hours.spans(0), [[60.0, 240.0], [360.0, 420.0]]);
        assert!(hours.spans(1).is_empty() && hours.spans(3).is_empty());
        assert_eq!(hours.spans(2), [[240.0, 360.0]]);
        assert_eq!([0, 1, 2].map(|point| hours.seconds(point)), [240.0, 0.0, 120.0]);
        assert!(hours.seconds(1).is_sign_positive(), "it would be shown as -0");
    }
}
