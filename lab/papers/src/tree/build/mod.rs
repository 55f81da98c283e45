//! Three ways to build the same tree, top down. Source: the paper's §3.1.2 to §3.1.4.
//!
//! Each cube is tested with a [`Classify`]. A cube that it cannot decide is subdivided, down to cells that
//! are tested at their centre. Eight children that agree, ignoring free ones, collapse into their parent, all
//! the way up (§3.1.2, §3.1.3). The three builders differ only in where they keep pending nodes:
//! [`TreeBuilder::Recursive`] on the call stack, [`TreeBuilder::Iterative`] in one heap frame per push
//! (§3.1.4), [`TreeBuilder::Pooled`] in frames that are reused. Departure: the paper pushes a frame for each
//! voxel too; here all three builders test the eight voxels below a node within its frame.

mod iterative;
mod pooled;
mod recursive;

use crate::tree::blocks::Blocks;
use crate::tree::error::Result;
use crate::tree::morton;
use crate::tree::morton::child_corner;
use crate::tree::reduce::Sink;
use crate::tree::word::{Node, Word};

/// The state shared by all defined voxels of a cube.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// All lit.
    Lit,
    /// All shadowed.
    Shadowed,
    /// No voxel is defined: either answer is correct.
    Free,
}

/// Classifies the space that a tree is built over. Cubes are given by their lowest voxel and their level; a
/// cube has sides of 2^level voxels.
pub trait Classify {
    /// Whether the cube is a cell, that is, tested at its centre and never subdivided. Every voxel (level 0)
    /// is a cell.
    fn is_cell(&self, xyz: [u32; 3], level: u32) -> bool {
        let _ = xyz;
        level == 0
    }

    /// Returns the state at the centre of a cell.
    fn cell(&self, xyz: [u32; 3], level: u32) -> State;

    /// Returns the states of the eight children, all of them cells, of a cube of this level. Bit i of the
    /// first mask: child i is lit; of the second: child i is free.
    fn eight(&self, xyz: [u32; 3], level: u32) -> [u8; 2] {
        let mut masks = [0; 2];
        for c in 0..8 {
            match self.cell(child_corner(xyz, level, c), level - 1) {
                State::Lit => masks[0] |= 1 << c,
                State::Free => masks[1] |= 1 << c,
                State::Shadowed => {}
            }
        }
        masks
    }

    /// Returns the state of a whole cube if it can be decided without its voxels. It must equal the state
    /// that the voxels would give.
    fn cube(&self, xyz: [u32; 3], level: u32) -> Option<State>;
}

/// The builder to use.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum TreeBuilder {
    /// A recursive function.
    Recursive,
    /// An explicit stack, one heap frame per push.
    Iterative,
    /// An explicit stack of frames that are reused.
    Pooled,
}

impl TreeBuilder {
    /// All three, in the order of the paper.
    pub const ALL: [Self; 3] = [Self::Recursive, Self::Iterative, Self::Pooled];

    /// Builds the tree of `depth` levels into `sink` and returns its root. With `prune`, [`Classify::cube`]
    /// is called for every cube that is not a cell. `watch` is called now and then, with the sink and the
    /// fraction of the space that is done.
    ///
    /// # Errors
    /// Returns the errors of `watch`, and [`adumbra_bake::Error::TooManyWords`] if the sink is full.
    pub fn build<S: Sink>(
        self,
        space: &impl Classify,
        depth: u32,
        prune: bool,
        sink: &mut S,
        watch: &dyn Fn(&S, f64) -> Result<()>,
    ) -> Result<Word> {
        let mut work = Work { space, depth, prune, sink, watch, until_watch: NODES_BETWEEN_WATCHES };
        let root = match self {
            Self::Recursive => recursive::build(&mut work, depth)?,
            Self::Iterative => iterative::build(&mut work, depth)?,
            Self::Pooled => pooled::build(&mut work, depth)?,
        };
        // `None`: no voxel of the space is defined.
        Ok(root.unwrap_or(Word::SHADOWED))
    }

    /// Builds the whole tree, without sharing subtrees.
    ///
    /// # Errors
    /// Returns the errors of [`TreeBuilder::build`].
    pub fn tree(self, space: &impl Classify, depth: u32, prune: bool) -> Result<Blocks> {
        let mut blocks = Vec::new();
        let root = self.build(space, depth, prune, &mut blocks, &|_, _| Ok(()))?;
        Ok(Blocks { root, blocks })
    }
}

/// Number of inner nodes between two calls of `watch`.
const NODES_BETWEEN_WATCHES: u32 = 1 << 16;

/// A built node; `None` if all of it is free.
type BuiltNode = Option<Word>;

/// The part that the three builders share: classifying cubes, and joining eight children.
struct Work<'w, C, S> {
    space: &'w C,
    depth: u32,
    prune: bool,
    sink: &'w mut S,
    watch: &'w dyn Fn(&S, f64) -> Result<()>,
    until_watch: u32,
}

impl<C: Classify, S: Sink> Work<'_, C, S> {
    /// Returns the node if it needs no subdivision, else `None`.
    fn decide(&self, xyz: [u32; 3], level: u32) -> Option<BuiltNode> {
        if self.space.is_cell(xyz, level) {
            return Some(built(self.space.cell(xyz, level)));
        }
        if self.prune
            && let Some(state) = self.space.cube(xyz, level)
        {
            return Some(built(state));
        }
        let children_are_cells =
            level == 1 || (0..8).all(|c| self.space.is_cell(child_corner(xyz, level, c), level - 1));
        children_are_cells.then(|| {
            let [lit, free] = self.space.eight(xyz, level);
            match (lit & !free, !lit & !free) {
                (0, 0) => None,
                (_, 0) => Some(Word::LIT),
                (lit, _) => Some(Word::leaf(lit)),
            }
        })
    }

    /// Returns the node at `xyz` with these children: merged upward if possible, else a new block.
    fn join(&mut self, xyz: [u32; 3], children: &[BuiltNode; 8]) -> Result<BuiltNode> {
        self.until_watch -= 1;
        if self.until_watch == 0 {
            self.until_watch = NODES_BETWEEN_WATCHES;
            (self.watch)(self.sink, morton::share_before(xyz, self.depth))?;
        }
        let mut defined = children.iter().flatten();
        let Some(&first) = defined.next() else { return Ok(None) };
        if matches!(first.node(), Node::Uniform(_)) && defined.all(|w| *w == first) {
            return Ok(Some(first));
        }
        // A free child whose siblings differ is inside a solid, and so in its shadow.
        let words = children.map(|c| c.unwrap_or(Word::SHADOWED));
        let mut mask = 0;
        for (c, word) in words.iter().enumerate() {
            match word.node() {
                Node::Uniform(lit) => mask |= u8::from(lit) << c,
                Node::Inner(_) | Node::Mask(_) => {
                    return self.sink.block(&words).map(Some);
                }
            }
        }
        Ok(Some(Word::leaf(mask)))
    }
}

fn built(state: State) -> BuiltNode {
    match state {
        State::Lit => Some(Word::LIT),
        State::Shadowed => Some(Word::SHADOWED),
        State::Free => None,
    }
}

#[cfg(test)]
mod tests;
