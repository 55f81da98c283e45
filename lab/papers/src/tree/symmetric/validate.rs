//! Validates untrusted bytes as a body that can be traversed: nodes are stored end to end, every pointer
//! leads to the start of a node, all nodes are reached, and no node is its own descendant or deeper than the
//! tree.

use crate::tree::error::SymmetricError;
use crate::tree::symmetric::encode::{BODY_HEADER_BYTES, MIRRORS};
use crate::tree::symmetric::node;
use crate::tree::symmetric::node::Child;
use crate::tree::word::MAX_DEPTH;
use crate::tree::word::{Node, Word};

/// State of each byte: no node begins there, a node that has not been visited, a node that the walk is
/// inside; else the height of the node.
const NOTHING: u8 = 0;
const UNVISITED: u8 = 1;
const OPEN: u8 = 255;

/// Position of a walk within a node.
struct WalkFrame {
    at: u32,
    next: u32,
    height: u8,
}

/// Checks a body and returns its number of nodes. Cost: linear; one byte of memory per byte.
pub(crate) fn check(depth: u32, bytes: &[u8]) -> Result<u64, SymmetricError> {
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
    let mut path: Vec<WalkFrame> = Vec::new();
    let mut enter = |at: u32, path: &mut Vec<WalkFrame>, known: &mut [u8]| {
        if path.len() as u32 + 1 >= depth {
            return Err(E::TooDeep { at, depth });
        }
        met += 1;
        known[at as usize] = OPEN;
        path.push(WalkFrame { at, next: 0, height: 0 });
        Ok(())
    };
    if let Node::Inner(at) = Word(root).node() {
        if known.get(at as usize) != Some(&UNVISITED) {
            return Err(E::Pointer { at: 0, target: at });
        }
        enter(at, &mut path, &mut known)?;
    }
    loop {
        let open = path.len() as u32;
        let Some(step) = path.last_mut() else { break };
        let WalkFrame { at, next, height } = *step;
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
                UNVISITED => enter(target, &mut path, &mut known)?,
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

/// Marks the starts of the nodes, which are stored end to end up to the padding, and counts them.
fn mark_nodes(bytes: &[u8], known: &mut [u8]) -> Result<u64, SymmetricError> {
    let mut at = BODY_HEADER_BYTES as u32;
    let mut nodes = 0;
    loop {
        let rest = &bytes[at as usize..];
        if rest.len() < 4 || rest.len() < 8 && rest.iter().all(|&b| b == 0) {
            break;
        }
        let header = node::header_at(bytes, at);
        // All eight children are of kind 0 or 1.
        if header & 0o6666_6666 == 0 {
            return Err(SymmetricError::NotMerged { at });
        }
        let size = node::HEADER_BYTES + node::children_bytes(header);
        if rest.len() < size as usize {
            return Err(SymmetricError::Cut { at });
        }
        known[at as usize] = UNVISITED;
        nodes += 1;
        at += size;
    }
    if bytes.len() - (at as usize) < 4 { Err(SymmetricError::Cut { at }) } else { Ok(nodes) }
}
