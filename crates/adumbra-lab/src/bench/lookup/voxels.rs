//! What look-ups in a baked file read, as counted by the shaders themselves, and how long their chains are.

use std::collections::HashSet;

use adumbra::query::{FixedReceiver, receiver};
use adumbra::{Layout, ShadowFile};
use adumbra_render::Gpu;
use adumbra_render::voxel::{BakedLight, Reads};

use super::pixels::Group;
use super::{Counts, SECTOR_WORDS};
use adumbra_compare::Result;

/// Looks up all points of a view.
pub(super) fn count(
    gpu: &Gpu,
    light: &BakedLight,
    file: &ShadowFile,
    groups: &[Group],
    filter: u32,
) -> Result<Counts> {
    let receivers: Vec<_> = groups
        .iter()
        .flatten()
        .map(|pixel| {
            let receiver = receiver(&file.grid, &file.settings.bias, pixel.p_world, Some(pixel.normal));
            FixedReceiver::new(&receiver, file.grid.size)
        })
        .collect();
    let reads = light.reads(gpu, &receivers)?;
    let mut rest = receivers.iter().zip(&reads);
    let mut counts = Counts::default();
    for group in groups {
        let of_group: Vec<(&FixedReceiver, &Reads)> = rest.by_ref().take(group.len()).collect();
        let words = || of_group.iter().flat_map(|(_, reads)| &reads.words);
        counts.pixels += group.len();
        counts.reads += words().count();
        counts.sectors += words().map(|word| word / SECTOR_WORDS).collect::<HashSet<u32>>().len();
        counts.chains +=
            of_group.iter().map(|(r, _)| longest_chain(file, r, filter)).max().unwrap_or_default();
    }
    Ok(counts)
}

/// Returns the largest number of reads of a look-up of which each needs the one before for its address.
fn longest_chain(file: &ShadowFile, r: &FixedReceiver, filter: u32) -> usize {
    let size = file.grid.size.map(i64::from);
    let reach = i64::from(filter / 2);
    let texel = r.texel();
    let mut longest = 0;
    // One tap of every block of 8 × 8 columns.
    let taps = |axis: usize| {
        let [low, high] = [texel[axis] - reach, texel[axis] + reach];
        (low..=high).filter(move |t| *t == low || t & 7 == 0).filter(move |t| (0..size[axis]).contains(t))
    };
    for x in taps(0) {
        for y in taps(1) {
            let z = r.layer([x, y]).min(size[2] - 1);
            if z >= 0 {
                longest = longest.max(chain(file, [x, y, z].map(|c| c as u32)));
            }
        }
    }
    longest
}

/// Returns the reads of one voxel of which each needs the one before for its address. Rare pointers that are spelled out
/// elsewhere, because they do not fit their place, add one that is not counted.
fn chain(file: &ShadowFile, [i, j, k]: [u32; 3]) -> usize {
    let voxels = file.leaf_masks();
    let end = voxels.end_level(i, j, k);
    let below = |levels: u32| (file.body.root_level() - end.max(3)) / levels;
    let in_leaf = end == 0;
    // A node is read in two steps: which children it has, then the pointer to one of them.
    let reads = match file.body.layout() {
        // The root. In a leaf its head, then its planes and differences.
        Layout::Depths => 1 + 2 * below(2) + if in_leaf { 2 } else { 0 },
        // The column of roots and the root. In a cube its head, then the mask.
        Layout::Packed => 2 + 2 * below(1) + if in_leaf { 2 } else { 0 },
        // The root. In a cube its head, the pointer, then the mask.
        Layout::Plain => 1 + 2 * below(1) + if in_leaf { 3 } else { 0 },
    };
    reads as usize
}
