//! The classes of a verification: what each is, and what a file promises of it.
//!
//! Every compared point belongs to one class, and rays alone decide which, so a wrong answer cannot move its point into a more
//! lenient class.

use serde::Serialize;

/// What rays say about the neighbourhood of a compared point. The first that fits is the point's class.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// The surface is all but edge-on to the sun, steeper than look-ups follow ([`crate::settings::MAX_PLANE_SLOPE`]): n·l is below
    /// 0.0084, so the sun gives it less than a hundredth of its light, and nothing is promised.
    #[serde(rename = "edge-on")]
    EdgeOn,
    /// A blocker lies within the point's bias. It cannot be told from the surface itself, so nothing is promised.
    Thin,
    /// Neighbours on opposite sides of the point disagree with it, or one does that lies between the point and an outer one that
    /// agrees: light or shadow is narrower than four texels there.
    Narrow,
    /// Some neighbour disagrees with the point: an edge is near.
    Edge,
    /// All neighbours agree, but the sun grazes the surface: n·l is at most [`super::MIN_N_DOT_L`].
    Grazing,
    /// All neighbours agree.
    Interior,
}

impl Class {
    /// All classes, in the order of tables.
    pub const ALL: [Self; 6] =
        [Self::Interior, Self::Grazing, Self::Edge, Self::Narrow, Self::Thin, Self::EdgeOn];

    /// Its name in tables and JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Interior => "interior",
            Self::Grazing => "grazing",
            Self::Edge => "edge",
            Self::Narrow => "narrow",
            Self::Thin => "thin",
            Self::EdgeOn => "edge-on",
        }
    }
}

/// What is promised of each class: the least agreement, and the largest share of points that are wrong by more than their texel.
/// None where nothing is promised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Promises {
    /// [`ClassResult::agreement`] of [`Class::Interior`].
    pub interior: f64,
    /// [`ClassResult::agreement`] of [`Class::Grazing`].
    pub grazing: Option<f64>,
    /// [`ClassResult::agreement`] of [`Class::Edge`].
    pub edge: Option<f64>,
    /// [`ClassResult::misplaced_share`] of [`Class::Edge`].
    pub edge_misplaced: Option<f64>,
    /// [`ClassResult::agreement`] of [`Class::Narrow`].
    pub narrow: Option<f64>,
    /// [`ClassResult::misplaced_share`] of [`Class::Narrow`], where holes of masks are judged by area and may be finer than a texel.
    pub narrow_misplaced: Option<f64>,
}

impl Promises {
    /// Of a light-aligned file that is looked up without a filter.
    pub const LIGHT: Self = Self {
        interior: 0.999,
        grazing: Some(0.99),
        edge: None,
        edge_misplaced: Some(0.005),
        narrow: None,
        narrow_misplaced: Some(0.03),
    };
    /// Of a light-aligned file whose look-ups are filtered, against the rays' own mean.
    pub const LIGHT_FILTERED: Self = Self {
        interior: 0.995,
        grazing: Some(0.99),
        edge: Some(0.9),
        edge_misplaced: None,
        narrow: Some(0.85),
        narrow_misplaced: None,
    };
    /// Of a world-aligned tree. Its voxels do not follow the light, so edges are not held to a texel.
    pub const TREE: Self = Self {
        interior: 0.999,
        grazing: None,
        edge: None,
        edge_misplaced: None,
        narrow: None,
        narrow_misplaced: None,
    };
}

/// How a file's answers compare with rays in one class.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ClassResult {
    /// Which points.
    pub class: Class,
    /// How many.
    pub points: u64,
    /// One less the mean difference from the rays' value; without a filter the share of right answers. 1 where there are no points.
    pub agreement: f64,
    /// Points answered darker than half way from the rays' value; without a filter, lit ones called shadowed.
    pub acne: u64,
    /// Points answered lighter than half way from the rays' value; without a filter, shadowed ones called lit.
    pub leak: u64,
    /// Wrong answers that the point's texel does not give either, neither at its centre nor in half of its area.
    pub misplaced: u64,
    /// The least agreement promised; none where none is.
    pub promised_agreement: Option<f64>,
    /// The largest promised share of points that are misplaced; none where none is.
    pub promised_misplaced: Option<f64>,
    /// Whether something is promised, and at least [`MIN_JUDGED_POINTS`] points say whether it is kept.
    pub judged: bool,
    /// Whether it keeps what is promised; true where it is not judged.
    pub holds: bool,
}

impl ClassResult {
    /// Wrong answers: acne and leak.
    pub fn wrong(&self) -> u64 {
        self.acne + self.leak
    }

    /// Share of the points that are answered wrong, 0 to 1; 0 where there are none.
    pub fn wrong_share(&self) -> f64 {
        share(self.wrong(), self.points)
    }

    /// Share of the points that are misplaced, 0 to 1; 0 where there are none.
    pub fn misplaced_share(&self) -> f64 {
        share(self.misplaced, self.points)
    }
}

fn share(part: u64, whole: u64) -> f64 {
    if whole == 0 { 0.0 } else { part as f64 / whole as f64 }
}

/// Sums over the points of a class.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ClassCounts {
    pub(super) points: u64,
    /// Of the differences from the rays' values, in [`DIFFERENCE_STEPS`]: whole numbers, so that the order of the sum does not matter.
    pub(super) difference_steps: u64,
    pub(super) acne: u64,
    pub(super) leak: u64,
    pub(super) misplaced: u64,
}

/// With fewer points, a share near a hundredth is too uncertain to judge a class by.
pub const MIN_JUDGED_POINTS: u64 = 300;

/// Steps of a difference of 1: a multiple of 1, 9, 25, 81 and 289, the taps of every filter.
pub(super) const DIFFERENCE_STEPS: f64 = (81 * 25 * 289) as f64;

impl ClassCounts {
    pub(super) fn add(&mut self, o: &Self) {
        self.points += o.points;
        self.difference_steps += o.difference_steps;
        self.acne += o.acne;
        self.leak += o.leak;
        self.misplaced += o.misplaced;
    }

    pub(super) fn finish(&self, class: Class, promises: &Promises) -> ClassResult {
        let (promised_agreement, promised_misplaced) = match class {
            Class::Interior => (Some(promises.interior), None),
            Class::Grazing => (promises.grazing, None),
            Class::Edge => (promises.edge, promises.edge_misplaced),
            Class::Narrow => (promises.narrow, promises.narrow_misplaced),
            Class::Thin | Class::EdgeOn => (None, None),
        };
        let points = self.points;
        let differences = self.difference_steps as f64 / DIFFERENCE_STEPS;
        let agreement = if points == 0 { 1.0 } else { 1.0 - differences / points as f64 };
        let misplaced = share(self.misplaced, points);
        let judged =
            (promised_agreement.is_some() || promised_misplaced.is_some()) && points >= MIN_JUDGED_POINTS;
        let keeps = promised_agreement.is_none_or(|least| agreement >= least)
            && promised_misplaced.is_none_or(|most| misplaced <= most);
        ClassResult {
            class,
            points,
            agreement,
            acne: self.acne,
            leak: self.leak,
            misplaced: self.misplaced,
            promised_agreement,
            promised_misplaced,
            judged,
            holds: keeps || !judged,
        }
    }
}
