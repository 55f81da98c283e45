//! Tests the answers of look-ups on surfaces: shadow wherever something is before the point that the bias
//! samples, and light elsewhere. Thin gaps, solids with uneven tops, low suns, masks and seams have each been
//! a source of errors.

mod gaps;
mod low_sun;
mod masks;
mod model;
mod property;
mod seams;
mod solids;
