//! Tests of the comparison, the benchmarks and the report.

mod bench_ao;
mod bench_bakes;
mod bench_fast;
mod bench_gpu;
mod bench_hrsm;
mod bench_lookup;
mod bench_peers;
mod bench_tree;
mod browser;
mod compared;
mod comparison;
mod flip_reference;
mod golden;
mod map_truth;
mod moved;
mod occlusion_analytic;
mod occlusion_peers;
mod occlusion_tune;
mod report;
mod report_inputs;
mod scale;
mod soft_truth;
mod truth;
