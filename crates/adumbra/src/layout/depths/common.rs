//! The shapes of a common section. Its words alone do not say where a shape begins and of which level it is,
//! but the pages do.

use crate::layout::depths::code::Child;
use crate::layout::depths::page::PAGE_LEVEL;
use crate::layout::depths::{DepthTree, LEAF_LEVEL, NODE_LEVELS, UNIFORM};

/// Level and address of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ShapePlace {
    /// Address in the shape's part.
    pub at: u32,
    /// Level of the shape.
    pub level: u32,
}

impl DepthTree {
    /// Returns the shapes of the common section that pages use, by address.
    ///
    /// Cost: one visit per shape, and a byte of memory per half-word.
    pub fn common_shapes(&self) -> Vec<ShapePlace> {
        let code = self.shapes();
        let mut seen = vec![0_u8; 2 * self.code.len()];
        let [across, down] = self.page_dims;
        let roots = (0..down).flat_map(|y| (0..across).map(move |x| self.root([x, y])[0]));
        let root = |at| ShapePlace { at, level: PAGE_LEVEL };
        let mut open: Vec<ShapePlace> = roots.filter(|&at| at != UNIFORM).map(root).collect();
        let mut found = Vec::new();
        while let Some(place) = open.pop() {
            let ShapePlace { at, level } = place;
            let seen = &mut seen[at as usize];
            if *seen >> (level - LEAF_LEVEL) & 1 == 1 {
                continue;
            }
            *seen |= 1 << (level - LEAF_LEVEL);
            if (at as usize) < 2 * self.common_words {
                found.push(place);
            }
            if level > LEAF_LEVEL {
                open.extend(code.children(at).filter_map(|child| match child {
                    Child::Shape { at, .. } => Some(ShapePlace { at, level: level - NODE_LEVELS }),
                    Child::Never | Child::Uniform(_) => None,
                }));
            }
        }
        found.sort_unstable();
        found
    }
}
