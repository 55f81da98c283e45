//! Trades a few changed voxels for a smaller graph: blocks that occur once are replaced by similar blocks
//! that exist anyway. Source: van der Laan, Scandolo, Eisemann, *Lossy Geometry Compression for High
//! Resolution Voxel Scenes* (2020); the paper's §1.3.
//!
//! As in the source, only blocks that occur once are replaced, leaves of eight voxels are not merged with
//! similar leaves, and many similar blocks are replaced by one that stays. Departures: the cost of a merge is
//! the number of voxels that it changes in the world, so the caller can set a bound on the total change.
//! Similar blocks are found by sorting, not in a graph of all pairs. Merges with the lowest cost per byte
//! saved are made first, over several rounds. The authors cluster by a Markov process; here the block that
//! most others resemble is the centre of a cluster.
//!
//! | file | content |
//! |---|---|
//! | `count` | the exact number of changed voxels |
//! | `round` | one bottom-up walk that merges blocks at low enough cost |
//! | `similar` | which blocks of one height resemble each other |
//! | `nearest` | the few blocks most similar to a block |
//! | `choose` | which of them are replaced, and by which |

mod candidate;
mod choose;
mod count;
mod facts;
mod nearest;
mod round;
mod similar;

pub use count::changed_voxels;

use crate::tree::blocks::Blocks;
use crate::tree::error::Result;
use crate::tree::error::{OptionError, TreeOption};
use crate::tree::graph::VoxelTree;
use crate::tree::leaf_voxels::leaf_voxels;
use crate::tree::settings::LossyChange;

/// The result of a lossy merge.
#[derive(Clone, Debug, PartialEq)]
pub struct Lossy {
    /// The smaller graph, reduced and numbered like any other.
    pub tree: VoxelTree,
    /// The change allowed and the change made.
    pub change: LossyChange,
    /// Number of blocks replaced by a similar one. The graph may have lost more blocks: parents that became
    /// equal.
    pub merged_blocks: u64,
}

/// Limits on the cost per block saved, in quarters of a voxel, one round each, so that cheap merges at all
/// heights precede expensive ones at any height. Below one voxel per block only subtrees of several blocks
/// can be replaced.
const QUARTERS_PER_BLOCK: [u64; 10] = [2, 4, 8, 16, 32, 64, 128, 256, 512, 1024];

/// Merges similar blocks as long as at most `max_share` of the tree's leaf voxels change: never more than
/// `max_share` times [`leaf_voxels`] voxels, as [`changed_voxels`] counts them between `tree` and the result.
/// A changed cell above the lowest level counts as all the finest voxels in it, though it counts once among
/// the leaf voxels, which makes the bound stricter. A share of 0 only reduces the tree.
///
/// The result depends on the tree and the share alone, not on the number of threads.
///
/// # Errors
/// Returns [`Error::Range`](crate::tree::Error::Range) if the share is not from 0 to 1.
pub fn merge_similar(tree: &VoxelTree, max_share: f64) -> Result<Lossy> {
    if !(0.0..=1.0).contains(&max_share) {
        return Err(OptionError::new(TreeOption::LossyShare, max_share, "from 0 to 1").into());
    }
    let leaf_voxels = leaf_voxels(tree);
    let budget = (max_share * leaf_voxels as f64) as u64;
    let reduced = round::merge(Blocks::of(tree), tree.depth(), 0, 0)?;
    let mut best = reduced.blocks.number(tree.depth());
    let (mut changed, mut merged_blocks) = (0, 0);
    for limit in QUARTERS_PER_BLOCK {
        // The last thousandth of the budget is not worth another round.
        if budget - changed <= budget / 1000 {
            break;
        }
        let round = round::merge(Blocks::of(&best), tree.depth(), limit, budget - changed)?;
        if round.merged == 0 {
            continue;
        }
        let next = round.blocks.number(tree.depth());
        drop(round.blocks);
        // The sum of a round is an upper bound of this exact count, which is the one that is used.
        let exact = changed_voxels(tree, &next);
        if exact > budget {
            break;
        }
        (best, changed) = (next, exact);
        merged_blocks += round.merged;
    }
    let change = LossyChange { max_share, leaf_voxels, changed_voxels: changed };
    Ok(Lossy { tree: best, change, merged_blocks })
}

#[cfg(test)]
mod tests;
