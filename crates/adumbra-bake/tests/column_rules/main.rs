//! What a look-up on a surface must find: shadow wherever something is before the point that its bias samples, light
//! where nothing is. Thin gaps, solids with uneven tops, low suns, masks and seams have each been a source of errors.

mod gaps;
mod low_sun;
mod masks;
mod model;
mod property;
mod seams;
mod solids;
