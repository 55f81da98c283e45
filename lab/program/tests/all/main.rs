//! Tests of the benchmarks, the report, the trees of the 2021 paper, and the techniques' pictures.

mod bench_ao;
mod bench_bakes;
mod bench_fast;
mod bench_gpu;
mod bench_hrsm;
mod bench_lookup;
mod bench_peers;
mod bench_tree;
mod browser;
mod golden;
mod occlusion_analytic;
mod occlusion_peers;
mod occlusion_tune;
mod report;
mod report_inputs;
mod tree;
mod tree_files;
mod tree_memory;
mod tree_options;
mod tree_texture;
mod truth;
