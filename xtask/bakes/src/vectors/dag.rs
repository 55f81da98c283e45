//! The test vectors of the graph file. Each exists in the plain layout and, if its columns are monotone, also
//! in the packed one.

use std::error::Error;

use adumbra_papers::dag::build::convert::body_in;
use adumbra_papers::dag::plain::LIT;
use adumbra_papers::dag::{DagFile, DagLayout};

use super::flipped::flipped;
use super::headers::Files;
use super::{Bytes, Known, LEAF_MASKS, NODES, TOP, Vector, bytes_of};
use crate::broken::Broken;

/// Returns the vectors in both layouts.
pub(super) fn valid(known: &[Known]) -> Result<Vec<Vector>, Box<dyn Error>> {
    let made = |Known { grid, dag }: &Known, suffix: &str, layout| {
        let body = body_in(layout, dag.clone())?;
        let mut bytes = Vec::new();
        DagFile { grid: grid.grid, settings: grid.settings, body }.write_to(&mut bytes)?;
        Ok(Vector { name: format!("{}{suffix}", grid.name), bytes, answers: grid.answers() })
    };
    let plain = known.iter().map(|known| made(known, "", DagLayout::Plain));
    let monotone = known.iter().filter(|known| known.is_monotone());
    plain.chain(monotone.map(|known| made(known, "_packed", DagLayout::Packed))).collect()
}

impl Bytes {
    fn put_node(self, word: usize, value: u32) -> Self {
        let at = self.section(NODES) + 4 * word;
        self.put_word(at, value)
    }
}

/// Returns files with one fault each.
pub(super) fn broken(valid: &[Vector], quadtrees: &[Vector]) -> Result<Vec<Broken>, Box<dyn Error>> {
    // One level-3 node (header and pointer) and one leaf mask.
    let small = bytes_of("example_8", valid)?;
    // Roots of level 4, several levels of nodes.
    let deep = bytes_of("odd_sizes", valid)?;
    let files = Files { magic: "ADUMDAG", later: "version 2", small: small.clone(), full: deep.clone() };
    let mut all = files.broken();
    let (s, d) = (|| small.clone(), || deep.clone());
    let mut add = |name, error, names, bytes| all.push(Broken { name, error, fault: None, names, bytes });
    add("shadow_file", "OtherKind", "a graph file", bytes_of("example_8_depths", quadtrees)?.0);
    add("layout_depths", "HeaderField", "layout", s().put_word(52, 2).sealed());
    add("layout_of_another", "SectionBounds", "top", s().put_word(52, 1).sealed());

    let mut graph = |name, fault, names, bytes| {
        all.push(Broken { name, error: "Graph", fault: Some(fault), names, bytes });
    };
    let root = small.section(TOP);
    let header = small.word(small.section(NODES));
    graph("root_past_end", "PointerRange", "top grid entry 0", s().put_word(root, 2).sealed());
    graph("root_not_first", "Order", "top grid entry 0", s().put_word(root, 1).sealed());
    graph("header_upper_bits", "HeaderBits", "node word 0", s().put_node(0, header | 1 << 16).sealed());
    graph("child_state_3", "ChildState", "child 2", s().put_node(0, header | 1 << 4).sealed());
    graph("node_all_lit", "Uniform", "node word 0", s().put_node(0, 0x5555).sealed());
    graph("node_all_shadowed", "Uniform", "node word 0", s().put_node(0, 0).sealed());
    graph("node_past_end", "NodeEnd", "2 pointers", s().put_node(0, header | 2 << 6).sealed());
    graph("pointer_unreached", "Unreachable", "node word 1", s().put_node(0, 0x0005).sealed());
    graph("leaf_mask_past_end", "PointerRange", "leaf mask 1", s().put_node(1, 1).sealed());
    let leaf_mask = |byte: u8| s().put(small.section(LEAF_MASKS), &[byte; 8]).sealed();
    graph("leaf_mask_all_lit", "Uniform", "leaf mask 0", leaf_mask(255));
    graph("leaf_mask_all_shadowed", "Uniform", "leaf mask 0", leaf_mask(0));
    graph("roots_all_lit", "Unreachable", "node word 0", s().put_word(root, LIT).sealed());
    graph("cycle", "TwoLevels", "node word 1", d().put_node(1, 0).sealed());
    graph("into_a_node", "NotAHeader", "node word 1", d().put_node(1, 1).sealed());
    let next = deep.word(deep.section(NODES) + 4) + 1;
    graph("node_out_of_order", "Order", "node word 1", d().put_node(1, next).sealed());
    graph("node_past_all", "PointerRange", "node word 1", d().put_node(1, 0x7FFF_FFFF).sealed());
    all.extend(flipped(
        "Packed",
        &[bytes_of("example_8_packed", valid)?, bytes_of("sphere_packed", valid)?],
        |bytes| DagFile::from_bytes(bytes).err()?.fault(),
        &[
            ("packed_top_length", "TopLength", "top of"),
            ("packed_pools", "Pools", "pool begins"),
            ("packed_filler", "Filler", "is padding"),
            ("packed_column", "Column", "column of"),
            ("packed_node_bits", "NodeBits", "invalid bits"),
            ("packed_node_end", "NodeEnd", "past the end of its pool"),
            ("packed_leaf_mask_range", "LeafMaskRange", "refers to leaf mask"),
            ("packed_leaf_masks", "LeafMasks", "proper subset"),
            ("packed_pointer", "Pointer", "no node begins"),
            ("packed_order", "Order", "after its slots"),
            ("packed_unreached", "Unreached", "not reachable"),
        ],
    )?);
    Ok(all)
}
