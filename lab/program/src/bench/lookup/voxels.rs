//! Counts the reads of look-ups in a baked file, by the shaders themselves, and the lengths of dependent
//! chains of reads.

use std::collections::HashSet;

use adumbra::Filter;
use adumbra::query::{FixedReceiver, receiver};
use adumbra_papers::dag::{DagBody, LeafMasks};
use adumbra_papers::techniques::{Graph, GraphSettings};
use adumbra_render::Gpu;
use adumbra_render::voxel::{BakedLight, Reads, VoxelSettings};

use super::pixels::Group;
use super::{Counts, SECTOR_WORDS};
use crate::light_file::LightFile;
use adumbra_compare::Result;

/// Looks up all points of a view.
pub(super) fn count(gpu: &Gpu, file: &LightFile, groups: &[Group], filter: Filter) -> Result<Counts> {
    let bias = file.settings().bias;
    let receivers: Vec<_> = groups
        .iter()
        .flatten()
        .map(|pixel| {
            let receiver = receiver(file.grid(), &bias, pixel.p_world, Some(pixel.normal));
            FixedReceiver::new(&receiver, file.grid().size)
        })
        .collect();
    let reads = match file {
        LightFile::Quadtree(file) => {
            BakedLight::from_file(gpu, file, VoxelSettings::taps(filter, bias))?.reads(gpu, &receivers)?
        }
        LightFile::Graph { graph, .. } => {
            let settings = GraphSettings { filter, bias };
            Graph::new(gpu, "voxel-dag".to_owned(), graph, settings)?.reads(gpu, &receivers)?
        }
    };
    let mut rest = receivers.iter().zip(&reads);
    let mut counts = Counts::default();
    for group in groups {
        let of_group: Vec<(&FixedReceiver, &Reads)> = rest.by_ref().take(group.len()).collect();
        let words = || of_group.iter().flat_map(|(_, reads)| &reads.words);
        counts.pixels += group.len();
        counts.reads += words().count();
        counts.sectors += words().map(|word| word / SECTOR_WORDS).collect::<HashSet<u32>>().len();
        counts.chains +=
            of_group.iter().map(|(r, _)| longest_chain(file, r, filter.width())).max().unwrap_or_default();
    }
    Ok(counts)
}

/// Returns the length of the longest dependent chain of reads in a look-up. In such a chain, the address of
/// each read comes from the read before.
fn longest_chain(file: &LightFile, r: &FixedReceiver, filter: u32) -> usize {
    let size = file.grid().size.map(i64::from);
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

/// Returns the length of the dependent chain of reads of one voxel. A rare pointer that does not fit its
/// field is stored elsewhere; its extra read is not counted.
fn chain(file: &LightFile, [i, j, k]: [u32; 3]) -> usize {
    let below = |root_level: u32, end: u32, levels: u32| (root_level - end.max(3)) / levels;
    // A node is read in two steps: which children it has, then the pointer to one of them.
    let reads = match file {
        // The root. In a leaf its head, then its planes and differences.
        LightFile::Quadtree(file) => {
            let end = file.tree.end_level(i, j, k);
            1 + 2 * below(file.tree.root_level(), end, 2) + if end == 0 { 2 } else { 0 }
        }
        LightFile::Graph { graph, .. } => {
            let end = graph.body.leaf_masks().end_level(i, j, k);
            let nodes = 2 * below(graph.body.root_level(), end, 1);
            match graph.body {
                // The column of roots and the root. In a cube its head, then the mask.
                DagBody::Packed(_) => 2 + nodes + if end == 0 { 2 } else { 0 },
                // The root. In a cube its head, the pointer, then the mask.
                DagBody::Plain(_) => 1 + nodes + if end == 0 { 3 } else { 0 },
            }
        }
    };
    reads as usize
}
