//! The times at which points see the sun, step by step of a day.
//!
//! A day of 600 minutes would take 600 rays a point. Instead rays are traced to *key suns* a few degrees
//! apart. Where two neighbouring keys differ, bisection finds the step at which the light changes. Where they
//! are alike, nothing is traced between them, so a shadow or gap that passes faster than the keys follow each
//! other may be missed. Steps whose sun is below the horizon or behind the surface take no ray.

mod day;
mod spans;

pub use day::{DayOptions, SunDay};
pub use spans::Hours;
