//! Tests of the comparison.

mod compared;
mod comparison;
mod flip_reference;
mod map_truth;
mod moved;
mod scale;
mod soft_truth;
