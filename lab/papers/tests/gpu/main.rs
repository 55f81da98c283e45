//! Look-ups in graphs and trees on the GPU against their CPU twins: equal counts for every fixed-point
//! receiver, and from f32 positions equal answers unless a point is on a voxel's face.

#![cfg(feature = "gpu")]

mod answers;
mod baked_tree;
mod graphs;
mod kit;
mod levels;
mod packed;
mod points;
mod shared;
