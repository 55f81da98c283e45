//! Slanted leaves on the GPU against the specification, for every gradient that a file can
//! store.

use adumbra::layout::depths::DepthTree;
use adumbra::query::FixedReceiver;
use adumbra::{Bias, Error, Filter, ShadowFile};
use adumbra_render::RenderError;
use adumbra_render::voxel::{BakedLight, VoxelSettings};
use adumbra_scene::random::Random;
use adumbra_shaders::{Source, source};
use adumbra_testing::{every_gradient, from_leaves, overhead_grid, settings_for};

use crate::kit;

/// Base depth of the leaves. It exceeds the rise of any column, so every layer at which a column may switch
/// is in the grid.
const BASE: u32 = 450;

/// Computes, with one thread per gradient, a hash of the depths of the leaf's columns.
const PASS: &str = "
const BASE = 450u;

@group(0) @binding(0) var<storage, read> words: array<u32>;
@group(0) @binding(1) var<storage, read_write> hashes: array<u32>;

fn adumbra_voxel_word(index: u32) -> u32 {
    return words[index];
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    var v: AdumbraVoxelParams;
    let leaf = adumbra_depths_leaf(v, AdumbraDepthsNode(2u * id.x, BASE));
    var hash = 0u;
    for (var column = 0u; column < 64u; column++) {
        let depth = adumbra_depths_leaf_value(v, leaf, vec2u(column & 7u, column >> 3u));
        hash = (hash ^ depth) * 16777619u;
    }
    hashes[id.x] = hash;
}
";

#[test]
fn gpu_leaves_match_the_specification_for_every_gradient() {
    let gpu = kit::gpu();
    let leaves = every_gradient();
    // A leaf of one depth is two half-words: the flag that it is slanted, and its gradient.
    let words: Vec<u32> = (0..leaves.len() as u32).map(|gradient| 0x0200 | gradient << 16).collect();
    let test = Source { name: "test", text: PASS };
    let texts = [source::SURFACE, source::GRID, source::VOXEL, source::DEPTHS, source::DEPTHS_LEAF, test];
    let found = kit::lists::run(&gpu, &texts, bytemuck::cast_slice(&words), leaves.len() as u32, 4);
    let found: &[u32] = bytemuck::cast_slice(&found);
    for (leaf, &found) in leaves.iter().zip(found) {
        let expected = (0..64).fold(0_u32, |hash, column| {
            (hash ^ leaf.depth(BASE, column).expect("a depth")).wrapping_mul(16_777_619)
        });
        assert_eq!(found, expected, "{:?}", leaf.slant);
    }
}

fn file_of(tree: DepthTree) -> ShadowFile {
    let grid = overhead_grid([0.0; 3], tree.size());
    ShadowFile::new(grid, settings_for(&grid), tree)
}

#[test]
fn gpu_filters_match_cpu_for_every_gradient() {
    let gpu = kit::gpu();
    let leaves = every_gradient();
    let file = file_of(from_leaves(&leaves, 256, BASE, 512).unwrap());
    let mut random = Random::for_batch(3, 0);
    let receivers: Vec<FixedReceiver> = (0..leaves.len())
        .map(|at| {
            let column = (random.unit() * 64.0) as usize;
            let [x, y] = [at % 256 * 8 + column % 8, at / 256 * 8 + column / 8];
            let depth = leaves[at].depth(BASE, column).expect("a depth");
            // Alternately the last lit layer and the first shadowed one.
            let z = depth as i64 - (at as i64 & 1);
            // Level, nearly along the leaf's own planes, or anything up to 1.5.
            let [gx, gy] = leaves[at].slant.unwrap_or_default().map(|g| 64 * i32::from(g));
            let mut near = |g: i32| (f64::from(g) + 40.0 * (random.unit() - 0.5)) as i32;
            let gradient = match at % 6 {
                0 | 1 => [0, 0],
                2 | 3 => [near(gx), near(gy)],
                _ => [0; 2].map(|_| (768.0 * (random.unit() - 0.5)) as i32),
            };
            FixedReceiver { p_fixed: [x as i64, y as i64, z].map(|c| c * 4096 + 2048), gradient }
        })
        .collect();
    for filter in [Filter::Nearest, Filter::Box9] {
        let sampler = file.sampler(filter);
        let settings = VoxelSettings::taps(filter, Bias::default());
        let light = BakedLight::from_file(&gpu, &file, settings).unwrap();
        for (at, (r, found)) in receivers.iter().zip(light.lit_taps(&gpu, &receivers).unwrap()).enumerate() {
            assert_eq!(found, sampler.lit_taps(r), "{filter:?} {:?}: {r:?}", leaves[at].slant);
            if filter == Filter::Nearest {
                assert_eq!(found, at as u32 & 1, "{:?}: {r:?}", leaves[at].slant);
            }
        }
    }
}

/// Even a tiny file may declare any grid size along the light.
#[test]
fn rejects_files_whose_grid_no_shader_supports() {
    let gpu = kit::gpu();
    let leaves = vec![every_gradient()[5].clone(); 16];
    let file = file_of(from_leaves(&leaves, 4, BASE, u32::MAX).unwrap());
    let refused =
        BakedLight::from_file(&gpu, &file, VoxelSettings::taps(Filter::Nearest, Bias::default())).map(|_| ());
    let Err(RenderError::Library(Error::Range(range))) = refused else { panic!("{refused:?}") };
    assert!(range.value == "4294967295" && range.range.contains("516096"), "{range}");
}
