//! The shapes of a quadtree, and those of its common section. The section's words alone do not say where a
//! shape begins and of which level it is, but the pages do.

use crate::layout::depths::child::{Child, ShapePlace};
use crate::layout::depths::page::PAGE_LEVEL;
use crate::layout::depths::{DepthTree, LEAF_LEVEL, NODE_LEVELS, UNIFORM};

impl DepthTree {
    /// Returns the shapes of the common section that pages use, by address.
    ///
    /// Cost: one visit per shape, and a byte of memory per half-word.
    pub fn common_shapes(&self) -> Vec<ShapePlace> {
        let mut found = Vec::new();
        self.for_each_shape(|place| {
            if (place.at as usize) < 2 * self.common_words {
                found.push(place);
            }
        });
        found.sort_unstable();
        found
    }

    /// Visits every shape once. Addresses count from the beginning of the code.
    pub(super) fn for_each_shape(&self, mut visit: impl FnMut(ShapePlace)) {
        let code = self.shapes();
        // The levels at which an address has been visited, a bit each.
        let mut seen = vec![0_u8; 2 * self.code.len()];
        let [across, down] = self.page_dims;
        let roots = (0..down).flat_map(|y| (0..across).map(move |x| self.root([x, y])[0]));
        let root = |at| ShapePlace { at, level: PAGE_LEVEL };
        let mut open: Vec<ShapePlace> = roots.filter(|&at| at != UNIFORM).map(root).collect();
        while let Some(place) = open.pop() {
            let ShapePlace { at, level } = place;
            let bit = 1 << ((level - LEAF_LEVEL) / NODE_LEVELS);
            let levels = &mut seen[at as usize];
            if *levels & bit != 0 {
                continue;
            }
            *levels |= bit;
            visit(place);
            if level > LEAF_LEVEL {
                open.extend(code.children(at).filter_map(|child| match child {
                    Child::Shape { shape, .. } => {
                        Some(ShapePlace { at: shape.at(), level: level - NODE_LEVELS })
                    }
                    Child::Never | Child::Uniform(_) => None,
                }));
            }
        }
    }
}
