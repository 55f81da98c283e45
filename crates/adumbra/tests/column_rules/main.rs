//! What a look-up on a surface finds: shadow wherever something lies before the point that its bias samples, light where nothing
//! does. Thin gaps, solids with uneven tops, low suns and seams each broke this once.

mod gaps;
mod low_sun;
mod model;
mod property;
mod seams;
mod solids;
