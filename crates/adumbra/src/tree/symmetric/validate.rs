//! Proves that bytes from anywhere are a body that can be walked: nodes stand end to end, every pointer leads to the start
//! of one, all are reached, none lies below itself or deeper than the tree.

use super::encode::{BODY_HEADER_BYTES, MIRRORS};
use super::node::{self, Child};
use crate::tree::MAX_DEPTH;
use crate::tree::word::{Node, Word};

/// Why bytes are not a symmetric tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SymmetricError {
    /// The depth is out of range.
    #[error("a depth of {depth} is not from 1 to {MAX_DEPTH}")]
    Depth {
        /// The depth given.
        depth: u32,
    },
    /// Too short or too long for a body, or not whole words.
    #[error("{bytes} bytes are not a header, nodes and padding")]
    Length {
        /// Bytes given.
        bytes: usize,
    },
    /// A flag that is not known.
    #[error("the flags are {flags:#010x}; only bit 0 is known")]
    Flags {
        /// The flags.
        flags: u32,
    },
    /// The root is a leaf that cannot be.
    #[error("the root is {root:#010x}, which is no node")]
    Root {
        /// The root.
        root: u32,
    },
    /// A node is cut off, or the padding is not four to seven zeros.
    #[error("the bytes from {at} on are neither a whole node nor the padding")]
    Cut {
        /// Where.
        at: u32,
    },
    /// Eight uniform children: the parent should be a leaf.
    #[error("the node at {at} holds eight uniform children; its parent should be a leaf")]
    NotMerged {
        /// Where it begins.
        at: u32,
    },
    /// A mask of eight equal bits.
    #[error("the node at {at} holds the mask {mask:#04x}, which should be a uniform child")]
    Mask {
        /// Where it begins.
        at: u32,
        /// The mask.
        mask: u8,
    },
    /// A pointer to where no node begins.
    #[error("the node at {at} points to {target}, where no node begins")]
    Pointer {
        /// Where it begins; 0 = the root's pointer.
        at: u32,
        /// Where it points.
        target: u32,
    },
    /// A node has more levels below it than the depth allows, or lies below itself.
    #[error("the node at {at} lies deeper than {depth} levels")]
    TooDeep {
        /// Where it begins.
        at: u32,
        /// The tree's depth.
        depth: u32,
    },
    /// Nodes that nothing points to.
    #[error("{nodes} nodes are never reached")]
    Unreached {
        /// How many.
        nodes: u64,
    },
}

/// What is known of each byte: no node begins there, one that is not met yet, one that the walk is in; else its height.
const NOTHING: u8 = 0;
const UNMET: u8 = 1;
const OPEN: u8 = 255;

/// Where a walk stands in a node.
struct Step {
    at: u32,
    next: u32,
    height: u8,
}

/// Checks a body; gives how many nodes it has. Cost: linear, one byte a byte.
pub(super) fn check(depth: u32, bytes: &[u8]) -> Result<u64, SymmetricError> {
    use SymmetricError as E;
    if !(1..=MAX_DEPTH).contains(&depth) {
        return Err(E::Depth { depth });
    }
    if bytes.len() < BODY_HEADER_BYTES + 4 || !bytes.len().is_multiple_of(4) || bytes.len() > 1 << 31 {
        return Err(E::Length { bytes: bytes.len() });
    }
    let flags = node::word_at(bytes, 0);
    if flags & !MIRRORS != 0 {
        return Err(E::Flags { flags });
    }
    let mirrors = flags & MIRRORS != 0;
    let mut known = vec![NOTHING; bytes.len()];
    let nodes = mark_nodes(bytes, &mut known)?;
    let root = node::word_at(bytes, 4);
    if !Word(root).is_valid() {
        return Err(E::Root { root });
    }
    let mut met = 0;
    let mut path: Vec<Step> = Vec::new();
    let mut enter = |at: u32, path: &mut Vec<Step>, known: &mut [u8]| {
        if path.len() as u32 + 1 >= depth {
            return Err(E::TooDeep { at, depth });
        }
        met += 1;
        known[at as usize] = OPEN;
        path.push(Step { at, next: 0, height: 0 });
        Ok(())
    };
    if let Node::Inner(at) = Word(root).node() {
        if known.get(at as usize) != Some(&UNMET) {
            return Err(E::Pointer { at: 0, target: at });
        }
        enter(at, &mut path, &mut known)?;
    }
    loop {
        let open = path.len() as u32;
        let Some(step) = path.last_mut() else { break };
        let Step { at, next, height } = *step;
        if next == 8 {
            path.pop();
            known[at as usize] = height + 1;
            if let Some(above) = path.last_mut() {
                above.height = above.height.max(height + 1);
            }
            continue;
        }
        step.next += 1;
        match node::child_at(bytes, mirrors, at, next) {
            Child::Uniform(_) => {}
            Child::Mask(mask @ (0 | 255)) => return Err(E::Mask { at, mask }),
            Child::Mask(_) => step.height = step.height.max(1),
            Child::Node { at: target, .. } => match known.get(target as usize).copied().unwrap_or(NOTHING) {
                NOTHING => return Err(E::Pointer { at, target }),
                UNMET => enter(target, &mut path, &mut known)?,
                below => {
                    if below == OPEN || open + u32::from(below) > depth {
                        return Err(E::TooDeep { at: target, depth });
                    }
                    step.height = step.height.max(below);
                }
            },
        }
    }
    if met == nodes { Ok(nodes) } else { Err(E::Unreached { nodes: nodes - met }) }
}

/// Marks where nodes begin, end to end up to the padding, and counts them.
fn mark_nodes(bytes: &[u8], known: &mut [u8]) -> Result<u64, SymmetricError> {
    let mut at = BODY_HEADER_BYTES as u32;
    let mut nodes = 0;
    loop {
        let rest = &bytes[at as usize..];
        if rest.len() < 4 || rest.len() < 8 && rest.iter().all(|&b| b == 0) {
            break;
        }
        let header = node::header_at(bytes, at);
        // Eight children of kinds 0 and 1.
        if header & 0o6666_6666 == 0 {
            return Err(SymmetricError::NotMerged { at });
        }
        let size = node::HEADER_BYTES + node::children_bytes(header);
        if rest.len() < size as usize {
            return Err(SymmetricError::Cut { at });
        }
        known[at as usize] = UNMET;
        nodes += 1;
        at += size;
    }
    if bytes.len() - (at as usize) < 4 { Err(SymmetricError::Cut { at }) } else { Ok(nodes) }
}
