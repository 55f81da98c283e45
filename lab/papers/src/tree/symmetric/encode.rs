//! Encodes a mirrored graph to bytes: determines where nodes begin, and how wide each pointer is.
//!
//! Source: the SSVDAG paper sorts nodes by use count, so that frequently used ones have short addresses. Here
//! that applies to nodes that are used more than once. Most nodes are used once; such a node follows its
//! parent, subtrees with fewer bytes first, and its pointer is a distance of one byte or takes no bytes at
//! all.
//!
//! A wider pointer moves everything after it, which may widen other pointers. Widths start at the minimum and
//! only ever grow, so the iteration terminates, and at the end every pointer is as narrow as its distance or
//! address allows.

use crate::tree::error::{Error, Result};
use crate::tree::symmetric::mirror::{Image, Mirrored};
use crate::tree::symmetric::node;
use crate::tree::word::{Node, Word};

/// Bytes before the first node: flags and root.
pub(crate) const BODY_HEADER_BYTES: usize = 8;
/// Flag of a tree with mirrors.
pub(crate) const MIRRORS: u32 = 1;
/// Bits of an address: that of the root leaves bit 31 free.
const ADDRESS_BITS: u32 = 31;
/// Bits of an address if three bits of its four bytes are the mirror.
const MIRRORED_ADDRESS_BITS: u32 = 29;
/// Zero bytes at the end, so that four bytes can be read wherever one can.
const PADDING_BYTES: usize = 4;

/// Encodes the body. Nodes must be turned to their most used image, because the root pointer cannot store a
/// mirror.
///
/// # Errors
/// Returns [`adumbra_bake::Error::TooManyWords`] if the nodes exceed the range of addresses.
pub(crate) fn encode(graph: &Mirrored, mirrors: bool) -> Result<Vec<u8>> {
    let order = order(graph);
    let layout = Layout::of(graph, &order, mirrors)?;
    let root = match graph.root.node() {
        Node::Inner(index) => layout.starts[Image::of(index).node as usize],
        Node::Uniform(_) | Node::Mask(_) => graph.root.0,
    };
    let mut bytes = Vec::with_capacity(layout.end as usize + 2 * PADDING_BYTES);
    bytes.extend((u32::from(mirrors) * MIRRORS).to_le_bytes());
    bytes.extend(root.to_le_bytes());
    for &n in &order {
        let (block, widths) = (&graph.nodes[n as usize], &layout.widths[n as usize]);
        let kinds = std::array::from_fn(|i| match block[i].node() {
            Node::Uniform(false) => node::SHADOWED,
            Node::Uniform(true) => node::LIT,
            Node::Mask(_) => node::MASK,
            Node::Inner(_) if widths[i] == 0 => node::NEXT,
            Node::Inner(_) => node::NEAR + u32::from(widths[i]) - 1,
        });
        bytes.extend(&node::header(kinds).to_le_bytes()[..node::HEADER_BYTES as usize]);
        for (word, &width) in block.iter().zip(widths) {
            match word.node() {
                Node::Uniform(_) => {}
                Node::Mask(mask) => bytes.push(mask),
                Node::Inner(index) => {
                    let image = Image::of(index);
                    let target = layout.starts[image.node as usize];
                    let value = match width {
                        0 | 1 => target.wrapping_sub(bytes.len() as u32 + 1),
                        2 => target,
                        _ if mirrors => target << 3 | u32::from(image.mirror),
                        _ => target,
                    };
                    bytes.extend(&value.to_le_bytes()[..usize::from(width)]);
                }
            }
        }
    }
    bytes.resize((bytes.len() + PADDING_BYTES).next_multiple_of(PADDING_BYTES), 0);
    Ok(bytes)
}

fn images(block: &[Word; 8]) -> impl Iterator<Item = Image> {
    block.iter().filter_map(|w| match w.node() {
        Node::Inner(index) => Some(Image::of(index)),
        Node::Uniform(_) | Node::Mask(_) => None,
    })
}

/// Returns the nodes in file order: first the nodes used more than once, most used first, then the root, each
/// followed by all nodes below it that are used once.
fn order(graph: &Mirrored) -> Vec<u32> {
    let Node::Inner(root) = graph.root.node() else { return Vec::new() };
    let root = Image::of(root).node;
    let count = graph.nodes.len();
    let mut uses = vec![0_u32; count];
    for image in graph.nodes.iter().flat_map(images) {
        uses[image.node as usize] += 1;
    }
    // Bytes of a node and the nodes that follow it if all pointers were short. Children precede their
    // parents.
    let mut sizes = vec![0_u64; count];
    for (n, block) in graph.nodes.iter().enumerate() {
        let below = images(block).map(|i| i.node as usize).filter(|&c| uses[c] == 1);
        let masks = block.iter().filter(|w| matches!(w.node(), Node::Mask(_))).count();
        sizes[n] = 3 + masks as u64 + images(block).count() as u64 + below.map(|c| sizes[c]).sum::<u64>();
    }
    let mut heads: Vec<u32> = (0..count as u32).rev().filter(|&n| uses[n as usize] > 1).collect();
    heads.sort_by_key(|&n| std::cmp::Reverse(uses[n as usize]));
    heads.push(root);
    let mut order = Vec::with_capacity(count);
    let mut waiting = Vec::new();
    for head in heads {
        waiting.push(head);
        while let Some(n) = waiting.pop() {
            order.push(n);
            let first = waiting.len();
            waiting
                .extend(images(&graph.nodes[n as usize]).map(|i| i.node).filter(|&c| uses[c as usize] == 1));
            waiting[first..].sort_by_key(|&c| std::cmp::Reverse(sizes[c as usize]));
        }
    }
    order
}

/// The start of each node, and the number of bytes of each child pointer.
struct Layout {
    starts: Vec<u32>,
    widths: Vec<[u8; 8]>,
    end: u32,
}

impl Layout {
    fn of(graph: &Mirrored, order: &[u32], mirrors: bool) -> Result<Self> {
        let count = graph.nodes.len();
        let mut layout = Self { starts: vec![0; count], widths: vec![[0; 8]; count], end: 0 };
        loop {
            layout.place(graph, order, mirrors)?;
            let mut grown = false;
            for (k, &n) in order.iter().enumerate() {
                let next = order.get(k + 1).copied();
                grown |= layout.widen(&graph.nodes[n as usize], n, next, mirrors);
            }
            if !grown {
                return Ok(layout);
            }
        }
    }

    /// Computes the starts for the current widths.
    fn place(&mut self, graph: &Mirrored, order: &[u32], mirrors: bool) -> Result<()> {
        let limit_bytes = 1 << if mirrors { MIRRORED_ADDRESS_BITS } else { ADDRESS_BITS };
        let mut at = BODY_HEADER_BYTES as u64;
        for &n in order {
            self.starts[n as usize] = at as u32;
            let masks = graph.nodes[n as usize].iter().filter(|w| matches!(w.node(), Node::Mask(_))).count();
            let widths = self.widths[n as usize].iter().map(|&w| u64::from(w)).sum::<u64>();
            at += u64::from(node::HEADER_BYTES) + masks as u64 + widths;
            if at > limit_bytes {
                return Err(Error::too_many_words("the tree with its mirrored subtrees stored once"));
            }
        }
        self.end = at as u32;
        Ok(())
    }

    /// Widens the pointers of a node as far as the starts require.
    fn widen(&mut self, block: &[Word; 8], n: u32, next: Option<u32>, mirrors: bool) -> bool {
        let mut grown = false;
        let mut here = self.starts[n as usize] + node::HEADER_BYTES;
        for (word, width) in block.iter().zip(&mut self.widths[n as usize]) {
            match word.node() {
                Node::Uniform(_) => {}
                Node::Mask(_) => here += 1,
                Node::Inner(index) => {
                    let image = Image::of(index);
                    let target = self.starts[image.node as usize];
                    let value = if mirrors { target << 3 } else { target };
                    let plain = image.mirror == 0;
                    let need = if plain && next == Some(image.node) {
                        0
                    } else if plain && target > here && target - here <= 256 {
                        1
                    } else if plain && target < 1 << 16 {
                        2
                    } else if value < 1 << 24 {
                        3
                    } else {
                        4
                    };
                    here += u32::from(*width);
                    grown |= need > *width;
                    *width = need.max(*width);
                }
            }
        }
        grown
    }
}
