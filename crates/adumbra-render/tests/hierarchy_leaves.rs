//! Slanted leaves of a hierarchy on the GPU against the specification, for every gradient that a file can store.

#[path = "../../adumbra/tests/hierarchy_support/mod.rs"]
mod hierarchy_support;
mod kit;

use adumbra::format::ShadowFile;
use adumbra::light::{LightGrid, Sun};
use adumbra::query::{FixedReceiver, Query};
use adumbra::settings::{Bias, Receivers, Settings};
use adumbra::verify::Random;
use adumbra_render::RenderError;
use adumbra_render::gpu::binding;
use adumbra_render::readback::read_buffer;
use adumbra_render::voxel::{HierarchyFilter, Voxel, VoxelHierarchy};
use adumbra_shaders::{assemble, source};
use hierarchy_support::{every_gradient, of_leaves};
use wgpu::{BufferUsages, ShaderStages};

/// Deeper than any column rises, so that every layer at which a column may switch is in the grid.
const BASE: u32 = 450;

/// One thread per gradient: a hash of the leaf's slabs at all layers up to its base.
const PASS: &str = "
@group(0) @binding(0) var<storage, read> words: array<u32>;
@group(0) @binding(1) var<storage, read_write> hashes: array<u32>;

fn voxel_word(index: u32) -> u32 {
    return words[index];
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    var v: VoxelParams;
    let leaf = hierarchy_leaf(v, HierarchyPlace(2u * id.x, BASE));
    var hash = 0u;
    for (var layer = 0u; layer <= BASE; layer++) {
        let slab = hierarchy_slab(v, leaf, layer);
        hash = ((hash ^ slab.x) * 16777619u ^ slab.y) * 16777619u;
    }
    hashes[id.x] = hash;
}
";

#[test]
fn slabs_on_the_gpu_are_the_specification_s_for_every_gradient() {
    let gpu = kit::gpu();
    let leaves = every_gradient();
    // A leaf of one depth is two half-words: that it is slanted, and its gradient.
    let words: Vec<u32> = (0..leaves.len() as u32).map(|gradient| 0x0200 | gradient << 16).collect();
    let given = gpu.buffer("test::words", bytemuck::cast_slice(&words), BufferUsages::STORAGE);
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
    let found = gpu.buffer("test::hashes", &vec![0; 4 * leaves.len()], usage);
    let layout = gpu.layout("test", ShaderStages::COMPUTE, &[binding::STORAGE, binding::STORAGE_OUT]);
    let text = assemble(&[source::SURFACE, source::GRID, source::VOXEL, source::HIERARCHY]);
    let text = format!("{text}const BASE = {BASE}u;\n{PASS}");
    let pipeline = gpu.compute("test", text, "main", &[Some(&layout)]);
    let group = gpu.bind("test", &layout, vec![given.as_entire_binding(), found.as_entire_binding()]);
    let mut encoder = gpu.encoder("test");
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.dispatch_workgroups(leaves.len() as u32 / 64, 1, 1);
    drop(pass);
    gpu.finish(encoder.finish()).unwrap();
    let found = read_buffer(&gpu, &found).unwrap();
    let found: &[u32] = bytemuck::cast_slice(&found);
    for (leaf, &found) in leaves.iter().zip(found) {
        // Columns that switch at each layer.
        let mut switches = [0_u64; BASE as usize + 1];
        for column in 0..64 {
            let depth = leaf.depth(BASE, column).expect("a depth");
            switches[depth as usize] |= 1 << column;
        }
        let mut lit = u64::MAX;
        let expected = switches.iter().fold(0_u32, |hash, switching| {
            lit &= !switching;
            let hash = (hash ^ lit as u32).wrapping_mul(16_777_619);
            (hash ^ (lit >> 32) as u32).wrapping_mul(16_777_619)
        });
        assert_eq!(lit, 0);
        assert_eq!(found, expected, "{:?}", leaf.slant);
    }
}

#[test]
fn filters_over_every_gradient_count_what_the_cpu_counts() {
    let gpu = kit::gpu();
    let leaves = every_gradient();
    let hierarchy = of_leaves(&leaves, 256, BASE, 512);
    let grid = unit_grid(hierarchy.size);
    let mut random = Random::new(3, 0);
    let receivers: Vec<FixedReceiver> = (0..leaves.len())
        .map(|at| {
            let column = (random.unit() * 64.0) as usize;
            let [x, y] = [at % 256 * 8 + column % 8, at / 256 * 8 + column / 8];
            let depth = leaves[at].depth(BASE, column).expect("a depth");
            // The last layer that is lit, or the first one that is not.
            let z = depth as i64 - (at as i64 & 1);
            FixedReceiver { p_fixed: [x as i64, y as i64, z].map(|c| c * 4096 + 2048), gradient: [0, 0] }
        })
        .collect();
    for filter in [1, 9] {
        let query = Query::new(&grid, &hierarchy, Bias::default(), filter).unwrap();
        let found =
            VoxelHierarchy::new(&gpu, &grid, &hierarchy, Bias::default(), HierarchyFilter::Taps(filter))
                .unwrap();
        for (at, (r, found)) in receivers.iter().zip(found.answers(&gpu, &receivers).unwrap()).enumerate() {
            assert_eq!(found.lit_taps, query.lit_taps(r), "filter {filter} {:?}: {r:?}", leaves[at].slant);
            if filter == 1 {
                assert_eq!(found.lit_taps, at as u32 & 1, "{:?}: {r:?}", leaves[at].slant);
            }
        }
    }
}

/// A file of few bytes may declare any length along the light; its graph could be of any size.
#[test]
fn hierarchy_of_a_grid_that_no_shader_takes_becomes_no_graph() {
    let gpu = kit::gpu();
    let hierarchy = of_leaves(&vec![every_gradient()[5].clone(); 16], 4, BASE, u32::MAX);
    let grid = unit_grid(hierarchy.size);
    let settings = Settings {
        resolution: 32,
        thickness_world: 0.0,
        assume_ground: true,
        closed_regions: true,
        ignore_alpha: false,
        receivers: Receivers::All,
        switch_within_voxels: 0,
        bounds: None,
        bias: Bias::default(),
        triangles: 1,
        instances: 1,
    };
    let file = ShadowFile::hierarchy(grid, settings, hierarchy);
    let refused = Voxel::of_file(&gpu, &file, Bias::default(), 1).map(|_| ());
    assert!(matches!(refused, Err(RenderError::VoxelLimit { value: 4_294_967_295, .. })), "{refused:?}");
}

/// Voxels of one unit under a sun overhead.
fn unit_grid(size: [u32; 3]) -> LightGrid {
    let sun = Sun::from_direction([0.0, 1.0, 0.0]).unwrap();
    let axes = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]];
    LightGrid { sun, voxel_size: 1.0, origin: [0.0; 3], axes, size }
}
