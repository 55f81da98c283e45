//! A smaller graph for a few changed voxels: blocks that stand in one place give way to similar blocks that are there
//! anyway. Source: van der Laan, Scandolo, Eisemann, *Lossy Geometry Compression for High Resolution Voxel Scenes*
//! (2020); the paper's §1.3.
//!
//! As there: only what is used once gives way, leaves of eight voxels are never made alike themselves, and many similar
//! blocks gather around one that stays. Departures: the cost of a merge is the number of voxels that it changes in the
//! world, so the whole change has a bound that the caller sets; similar blocks are found by sorting, not in a graph of
//! all pairs; what is cheap for the bytes that it saves goes first, over several rounds; and where the authors cluster by
//! a Markov process, the block that most others resemble is taken as the centre.
//!
//! | file | what |
//! |---|---|
//! | `count` | the change, counted exactly |
//! | `round` | one walk from the lowest blocks up, merging what costs little enough |
//! | `similar` | which blocks of one height resemble each other |
//! | `nearest` | the few that resemble a block most |
//! | `choose` | which of them give way, and to which |

mod choose;
mod count;
mod nearest;
mod round;
mod similar;

pub use count::changed_voxels;

use super::blocks::Blocks;
use super::settings::LossyChange;
use super::{VoxelTree, leaf_voxels};
use crate::error::{Error, Result};

/// What a lossy merge gives.
#[derive(Clone, Debug, PartialEq)]
pub struct Lossy {
    /// The smaller graph: reduced, and numbered as every other.
    pub tree: VoxelTree,
    /// What it was allowed and did.
    pub change: LossyChange,
    /// Blocks that gave way to a similar one. More may have gone: their parents, where those became equal.
    pub merged_blocks: u64,
}

/// Quarters of a voxel that a block may cost, one round each: cheap merges of all heights come before dear ones of any.
/// Below one voxel a block only subtrees of several blocks can give way.
const QUARTERS_PER_BLOCK: [u64; 10] = [2, 4, 8, 16, 32, 64, 128, 256, 512, 1024];

/// Merges similar blocks while at most `max_share` of the tree's leaf voxels change: never more than
/// `max_share` times [`leaf_voxels`] voxels, as [`changed_voxels`] counts them between `tree` and the result. A changed cell
/// above the lowest level counts as all the finest voxels in it, though it counts once among the leaf voxels: the bound
/// is the stricter for it. A share of 0 only reduces the tree.
///
/// The same tree and share give the same result, whatever the number of threads.
///
/// # Errors
/// [`Error::OptionRange`] where the share is not from 0 to 1.
pub fn merge_similar(tree: &VoxelTree, max_share: f64) -> Result<Lossy> {
    if !(0.0..=1.0).contains(&max_share) {
        let value = max_share.to_string();
        return Err(Error::OptionRange { option: "--lossy", value, range: "a share from 0 to 1" });
    }
    let leaf_voxels = leaf_voxels(tree);
    let budget = (max_share * leaf_voxels as f64) as u64;
    let reduced = round::merge(Blocks::of(tree), tree.depth(), 0, 0)?;
    let mut best = reduced.blocks.number(tree.depth());
    let (mut changed, mut merged_blocks) = (0, 0);
    for limit in QUARTERS_PER_BLOCK {
        // The last thousandth is not worth another round.
        if budget - changed <= budget / 1000 {
            break;
        }
        let round = round::merge(Blocks::of(&best), tree.depth(), limit, budget - changed)?;
        if round.merged == 0 {
            continue;
        }
        let next = round.blocks.number(tree.depth());
        drop(round.blocks);
        // What a round adds up is never less than this; this is what counts.
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
