//! Code shared by the tests of several crates: folders next to the repository, hand-made files, depths and
//! solids, placements, runs of the programs, runs with the least memory, JSON and its schemas, test vectors,
//! and truth files.

mod by_hand;
mod described;
mod earlier;
mod end_level;
mod fuzz;
mod glb;
pub mod help;
mod leaves;
mod left_out;
mod limits;
mod parts;
mod placements;
mod ply;
mod programs;
mod shared_folder;
mod solids;
mod teeth;
mod truth_files;
mod vectors;

pub use by_hand::{overhead_grid, settings_for};
pub use described::{assert_described, undescribed_fields};
pub use earlier::EarlierFile;
pub use end_level::end_level;
pub use fuzz::fuzz_time;
pub use glb::glb;
pub use leaves::{BASES, Leaf, every_gradient, from_leaves, random_leaves};
pub use left_out::left_out;
pub use limits::{assert_keeps_to_limits, run_with_the_memory_it_asks_for};
pub use parts::{PageParts, TreeParts};
pub use placements::placements;
pub use ply::{PLY_FORMATS, Ply, PlyElement};
pub use programs::{
    Folder, MASKED_GLTF, REQUIRING_GLTF, adumbra, json, lab, lab_json, lab_program, program, read_f32, stderr,
};
pub use shared_folder::{full, scene_file, shared};
pub use solids::{add_box, add_quad, cuboid, scene_of};
pub use teeth::toothed_bar;
pub use truth_files::{npz_array, npz_camera};
pub use vectors::{
    ExpectedPoint, FaultyVector, SpecifiedExample, assert_faults_found, count_faults, expected_points,
    f64_at, faulty_vectors, named_vectors, specified_example, u32_at, u64_at, vector_answers, vectors,
};

// Makes sure that the Rust code in the guide compiles.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/guides/use-the-file-in-my-engine.md")]
mod guide {}
