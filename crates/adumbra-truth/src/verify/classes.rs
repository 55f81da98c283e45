//! The classes of a verification and what a file promises for each.
//!
//! Every compared point belongs to exactly one class. The class depends on rays alone, so a wrong answer
//! cannot move its point into a more lenient class.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Describes the neighbourhood of a compared point, according to rays. The first variant that applies is the
/// point's class.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// The surface is almost edge-on to the sun, steeper than look-ups follow ([`adumbra::MAX_PLANE_SLOPE`]).
    /// n·l is below 0.0084, so the surface receives less than a hundredth of the sun's light, and nothing is
    /// promised.
    #[serde(rename = "edge-on")]
    EdgeOn,
    /// A blocker is within the point's bias, so that it cannot be distinguished from the surface itself. Or
    /// one is within rounding of where the look-up ends. Nothing is promised.
    Thin,
    /// Neighbours on opposite sides of the point disagree with it, or an inner neighbour disagrees while the
    /// outer one in the same direction agrees. Or only the centre of the point's texel disagrees, where
    /// look-ups sample. Light or shadow is narrower than four texels there.
    Narrow,
    /// Some neighbour disagrees with the point: an edge is nearby.
    Edge,
    /// All neighbours and the texel's centre agree, but the sun is grazing: n·l is at most
    /// [`crate::verify::MIN_N_DOT_L`].
    Grazing,
    /// A point just below the scene, on level ground that the scene does not have: all neighbours agree.
    Ground,
    /// All neighbours agree.
    Interior,
}

impl Class {
    /// All classes, in the order of tables.
    pub const ALL: [Self; 7] =
        [Self::Interior, Self::Grazing, Self::Ground, Self::Edge, Self::Narrow, Self::Thin, Self::EdgeOn];

    /// The class's name in tables and JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Interior => "interior",
            Self::Ground => "ground",
            Self::Grazing => "grazing",
            Self::Edge => "edge",
            Self::Narrow => "narrow",
            Self::Thin => "thin",
            Self::EdgeOn => "edge-on",
        }
    }
}

/// The promises for each class: the least agreement, and the largest share of points whose error is more than
/// their texel explains. `None` if nothing is promised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Promises {
    /// [`ClassResult::agreement`] of [`Class::Interior`].
    pub interior: f64,
    /// [`ClassResult::agreement`] of [`Class::Grazing`].
    pub grazing: Option<f64>,
    /// [`ClassResult::agreement`] of [`Class::Ground`].
    pub ground: Option<f64>,
    /// [`ClassResult::agreement`] of [`Class::Edge`].
    pub edge: Option<f64>,
    /// [`ClassResult::misplaced_share`] of [`Class::Edge`].
    pub edge_misplaced: Option<f64>,
    /// [`ClassResult::agreement`] of [`Class::Narrow`].
    pub narrow: Option<f64>,
    /// [`ClassResult::misplaced_share`] of [`Class::Narrow`].
    pub narrow_misplaced: Option<f64>,
}

impl Promises {
    /// Promises of a light-aligned file that is looked up without a filter.
    pub const LIGHT: Self = Self {
        interior: 0.999,
        grazing: Some(0.995),
        ground: Some(0.999),
        edge: None,
        edge_misplaced: Some(0.005),
        narrow: None,
        narrow_misplaced: Some(0.005),
    };
    /// Promises of a light-aligned file whose look-ups are filtered, compared with the mean of the rays.
    pub const LIGHT_FILTERED: Self = Self {
        interior: 0.995,
        grazing: Some(0.99),
        ground: Some(0.99),
        edge: Some(0.9),
        edge_misplaced: None,
        narrow: Some(0.9),
        narrow_misplaced: None,
    };
}

/// The comparison of a file's answers with rays in one class.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ClassResult {
    /// The class.
    pub class: Class,
    /// Number of points in the class.
    pub points: u64,
    /// One minus the mean difference from the rays' value; without a filter, the share of correct answers. 1
    /// if there are no points.
    pub agreement: f64,
    /// Number of points whose answer is darker than the rays' value by more than half; without a filter, lit
    /// points answered as shadowed.
    pub acne: u64,
    /// Number of points whose answer is lighter than the rays' value by more than half; without a filter,
    /// shadowed points answered as lit.
    pub leak: u64,
    /// Number of wrong answers that rays do not give at the centre of the point's texel either.
    pub misplaced: u64,
    /// The least agreement promised, if any.
    pub promised_agreement: Option<f64>,
    /// The largest promised share of misplaced points, if any.
    pub promised_misplaced: Option<f64>,
    /// Whether something is promised, and there are at least [`MIN_CHECKED_POINTS`] points to check it.
    pub checked: bool,
    /// Whether the promises are kept; true if the class is not checked.
    pub holds: bool,
}

impl ClassResult {
    /// Number of wrong answers: acne and leak.
    pub fn wrong(&self) -> u64 {
        self.acne + self.leak
    }

    /// Share of the points that are misplaced, 0 to 1; 0 if there are no points.
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
    /// Sum of the differences from the rays' values, in units of 1 / [`DIFFERENCE_STEPS`]. Integers, so that
    /// the order of summation does not matter.
    pub(super) difference_steps: u64,
    pub(super) acne: u64,
    pub(super) leak: u64,
    pub(super) misplaced: u64,
}

/// Minimum number of points to check a class. With fewer, a share near a hundredth is too uncertain.
pub const MIN_CHECKED_POINTS: u64 = 300;

/// Number of steps in a difference of 1: a multiple of 1, 9, 25, 81 and 289, the tap counts of all filters.
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
            Class::Ground => (promises.ground, None),
            Class::Edge => (promises.edge, promises.edge_misplaced),
            Class::Narrow => (promises.narrow, promises.narrow_misplaced),
            Class::Thin | Class::EdgeOn => (None, None),
        };
        let points = self.points;
        let differences = self.difference_steps as f64 / DIFFERENCE_STEPS;
        let agreement = if points == 0 { 1.0 } else { 1.0 - differences / points as f64 };
        let misplaced = share(self.misplaced, points);
        let checked =
            (promised_agreement.is_some() || promised_misplaced.is_some()) && points >= MIN_CHECKED_POINTS;
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
            checked,
            holds: keeps || !checked,
        }
    }
}
