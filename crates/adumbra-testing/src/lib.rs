//! Code shared by the tests of several crates: folders next to the repository, bakes by layout, hand-made depths, runs
//! of the programs, scenes made by hand, test vectors, and truth files.

mod bakes;
mod leaves;
mod programs;
mod shared_folder;
mod solids;
mod truth_files;
mod vectors;

pub use bakes::{BakedGraph, bake_depths, bake_file, bake_graph};
pub use leaves::{Leaf, every_gradient, from_leaves};
pub use programs::{
    Folder, MASKED_GLTF, REQUIRING_GLTF, adumbra, json, lab, lab_program, program, read_f32, stderr,
};
pub use shared_folder::{full, scene_file, shared};
pub use solids::{add_box, add_quad, cuboid, scene_of};
pub use truth_files::{npz_array, npz_camera};
pub use vectors::{
    ExpectedPoint, FaultyVector, SpecifiedExample, assert_faults_found, expected_points, f64_at,
    faulty_vectors, named_vectors, specified_example, u32_at, u64_at, vector_answers, vectors,
};

// Makes sure that the Rust code in the guide compiles.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/guides/use-the-file-in-my-engine.md")]
mod guide {}
