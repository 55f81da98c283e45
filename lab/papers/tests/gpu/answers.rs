//! Filtered visibility from every store, in every filter.

use adumbra_papers::techniques::{CubesStore, PageTexture, PagesError, TECHNIQUES};
use adumbra_papers::tree::query::{KERNEL_SIDES, Weights};
use adumbra_papers::tree::{Detail, Region, texture};
use adumbra_render::{RenderError, Techniques, build};
use adumbra_scene::{GeneratedKind, generate};

use crate::baked_tree::{BakedTree, exact_cubes, float_cubes, try_cubes};
use crate::kit::{gpu, limited};

fn generated() -> [BakedTree; 3] {
    [GeneratedKind::Primitives, GeneratedKind::City, GeneratedKind::Landscape]
        .map(|kind| BakedTree::new(generate(kind, 3), 256))
}

const COUNT: usize = 100_000;

#[test]
fn tree_in_six_bindings_matches_cpu() {
    let baked = BakedTree::new(generate(GeneratedKind::Primitives, 3), 32);
    exact_cubes(&limited(4096), &baked, CubesStore::Words, (3, Weights::Mean), 20_000);
}

#[test]
#[ignore = "slow: draws on the GPU and counts on the CPU"]
fn tree_words_match_cpu_tap_counts() {
    let gpu = gpu();
    for baked in generated() {
        for side in KERNEL_SIDES {
            for weights in [Weights::Mean, Weights::Poisson] {
                exact_cubes(&gpu, &baked, CubesStore::Words, (side, weights), COUNT);
            }
        }
    }
}

#[test]
fn small_tree_texels_match_cpu_tap_counts() {
    let gpu = gpu();
    let baked = BakedTree::new(generate(GeneratedKind::Primitives, 3), 128);
    exact_cubes(&gpu, &baked, CubesStore::Texels, (3, Weights::Mean), 20_000);
    exact_cubes(&gpu, &baked, CubesStore::Decoded, (3, Weights::Poisson), 20_000);
}

#[test]
#[ignore = "slow: draws on the GPU and counts on the CPU"]
fn tree_texels_match_cpu_tap_counts() {
    let gpu = gpu();
    for baked in generated() {
        for side in KERNEL_SIDES {
            exact_cubes(&gpu, &baked, CubesStore::Texels, (side, Weights::Mean), COUNT);
        }
        exact_cubes(&gpu, &baked, CubesStore::Decoded, (3, Weights::Poisson), COUNT);
    }
}

#[test]
fn tree_with_regions_matches_cpu_and_rejects_too_many_regions() {
    let gpu = gpu();
    let rings = Detail::Rings { center_xz: [3.0, -5.0], radii: vec![8.0, 20.0, 40.0] };
    let mut baked = BakedTree::with_detail(generate(GeneratedKind::Landscape, 3), 128, rings);
    for side in KERNEL_SIDES {
        exact_cubes(&gpu, &baked, CubesStore::Words, (side, Weights::Mean), 30_000);
        float_cubes(&gpu, &baked, (side, Weights::Mean), 30_000);
    }
    let region = baked.tree.regions.list[0];
    // Seventeen disjoint regions, two voxels wide.
    let (space, size) = (baked.tree.space, baked.tree.space.voxel_size);
    let range = |axis: usize, i: u32| {
        let from = space.p_min[axis] + size * f64::from(2 + 6 * i);
        [from, from + 2.0 * size]
    };
    baked.tree.regions.list = (0..17).map(|i| Region { x: range(0, i), z: range(2, i), ..region }).collect();
    let error = try_cubes(&gpu, &baked, CubesStore::Words, (3, Weights::Mean)).err().unwrap();
    assert!(matches!(error, RenderError::VoxelLimit { value: 17, limit: 16, .. }), "{error}");
}

#[test]
#[ignore = "slow: many look-ups on the GPU"]
fn tree_answers_from_f32_positions_differ_only_on_faces() {
    let gpu = gpu();
    for baked in generated() {
        for side in KERNEL_SIDES {
            float_cubes(&gpu, &baked, (side, Weights::Mean), COUNT);
        }
    }
}

#[test]
fn texture_is_decoded_bit_for_bit() {
    let baked = BakedTree::new(generate(GeneratedKind::City, 3), 256);
    let words = baked.words();
    // Several pages, first with one binding, then with several.
    let pages = texture::encode(words, &[1, 2, 3], 64).unwrap();
    assert!(pages.len() > 2, "{}", pages.len());
    for bytes in [1 << 27, 4 * (words.len() as u64 / 4).next_power_of_two()] {
        let gpu = limited(bytes);
        let decoded = PageTexture::new(&gpu, &pages).unwrap().decode(&gpu, words.len() as u64).unwrap();
        let mut read = Vec::new();
        for buffer in decoded.buffers() {
            let bytes = adumbra_render::readback::read_buffer(&gpu, buffer).unwrap();
            read.extend(bytes.as_chunks::<4>().0.iter().map(|b| u32::from_le_bytes(*b)));
        }
        assert_eq!(&read[..words.len()], words);
    }
    let mut damaged = pages;
    damaged[0].rgba[5] ^= 1;
    let Err(RenderError::Other(error)) = PageTexture::new(&gpu(), &damaged) else { panic!("it is damaged") };
    assert!(error.is::<PagesError>(), "{error}");
}

#[test]
fn techniques_keep_requested_name_and_report_cell_size() {
    let gpu = gpu();
    let rings = Detail::Rings { center_xz: [3.0, -5.0], radii: vec![8.0, 20.0] };
    let baked = BakedTree::with_detail(generate(GeneratedKind::Landscape, 3), 128, rings);
    let levels = baked.tree.space.depth - baked.tree.regions.base_depth;
    assert_eq!(levels, 2);
    let cell = 4.0 * baked.tree.space.voxel_size;
    let files = baked.files();
    for name in ["voxel-cubes:normal=1", "voxel-texture:read=buffer"] {
        let spec = Techniques::product().with(TECHNIQUES).parse(name).unwrap();
        let technique = build(&gpu, &spec, files.baked()).unwrap();
        assert_eq!((technique.name().as_str(), technique.texel_world(10.0)), (name, Some(cell)));
        assert!(technique.bytes() >= 4 * baked.words().len() as u64);
    }
}
