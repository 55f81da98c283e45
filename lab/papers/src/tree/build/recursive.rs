//! Builds the tree with a recursive function. The recursion is as deep as the tree has levels.

use crate::tree::build::{BuiltNode, Classify, Work};
use crate::tree::error::Result;
use crate::tree::morton::child_corner;
use crate::tree::reduce::Sink;

pub(crate) fn build<C: Classify, S: Sink>(work: &mut Work<'_, C, S>, depth: u32) -> Result<BuiltNode> {
    node(work, [0; 3], depth)
}

fn node<C: Classify, S: Sink>(work: &mut Work<'_, C, S>, xyz: [u32; 3], level: u32) -> Result<BuiltNode> {
    if let Some(decided) = work.decide(xyz, level) {
        return Ok(decided);
    }
    let mut children = [None; 8];
    for (c, child) in (0..).zip(&mut children) {
        *child = node(work, child_corner(xyz, level, c), level - 1)?;
    }
    work.join(xyz, &children)
}
