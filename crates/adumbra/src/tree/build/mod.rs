//! Three ways to build one tree, top down. Source: the paper's §3.1.2 to §3.1.4.
//!
//! A cube is asked of a [`Classify`]; what is not decided is halved, down to cells that are tested at their centre.
//! Eight children that agree, but for free ones, collapse into their parent, all the way up (§3.1.2, §3.1.3). The three
//! differ only in where they keep what waits: [`Builder::Recursive`] on the stack, [`Builder::Iterative`] in a heap
//! frame a push (§3.1.4), [`Builder::Pooled`] in frames that are used again. Departure: the paper pushes a frame for a
//! voxel too; here the eight voxels below a node are tested within its frame, in all three.

mod iterative;
mod pooled;
mod recursive;

use super::blocks::Blocks;
use super::morton::{self, child_corner};
use super::reduce::Sink;
use super::word::{Node, Word};
use crate::error::Result;

/// What the defined voxels of a cube are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// All lit.
    Lit,
    /// All shadowed.
    Shadowed,
    /// There are none: the answer may be either.
    Free,
}

/// Knows the space that a tree is built over. Cubes are given by their lowest voxel and their level: 2^level voxels a
/// side.
pub trait Classify {
    /// Whether the cube is a cell: tested at its centre, never halved. Every voxel (level 0) is.
    fn is_cell(&self, xyz: [u32; 3], level: u32) -> bool {
        let _ = xyz;
        level == 0
    }

    /// The state at a cell's centre.
    fn cell(&self, xyz: [u32; 3], level: u32) -> State;

    /// The eight children, cells all, of a cube of this level: bit i of the first = child i is lit, of the second =
    /// child i is free.
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

    /// The state of a whole cube where it can be told without its voxels; it must be what they would give.
    fn cube(&self, xyz: [u32; 3], level: u32) -> Option<State>;
}

/// Which builder.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Builder {
    /// One function that calls itself.
    Recursive,
    /// An explicit stack, one heap frame a push.
    Iterative,
    /// An explicit stack of frames that are used again.
    Pooled,
}

impl Builder {
    /// All three, in the paper's order.
    pub const ALL: [Self; 3] = [Self::Recursive, Self::Iterative, Self::Pooled];

    /// Builds the tree of `depth` levels into `sink` and gives its root; `prune` asks [`Classify::cube`] of every cube
    /// that is not a cell. `watch` is called now and then, with the sink and the share of the space that is done.
    ///
    /// # Errors
    /// What `watch` says, or [`crate::Error::MemoryLimit`] of a sink that is full.
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
        // A space that is nowhere defined.
        Ok(root.unwrap_or(Word::SHADOWED))
    }

    /// The whole tree, no subtree shared.
    ///
    /// # Errors
    /// As [`Builder::build`].
    pub fn tree(self, space: &impl Classify, depth: u32, prune: bool) -> Result<Blocks> {
        let mut blocks = Vec::new();
        let root = self.build(space, depth, prune, &mut blocks, &|_, _| Ok(()))?;
        Ok(Blocks { root, blocks })
    }
}

/// Inner nodes between two calls of `watch`.
const NODES_BETWEEN_WATCHES: u32 = 1 << 16;

/// A built node; none where all of it is free.
type Built = Option<Word>;

/// What the three builders share: the questions, and what becomes of eight children.
struct Work<'w, C, S> {
    space: &'w C,
    depth: u32,
    prune: bool,
    sink: &'w mut S,
    watch: &'w dyn Fn(&S, f64) -> Result<()>,
    until_watch: u32,
}

impl<C: Classify, S: Sink> Work<'_, C, S> {
    /// The node where it needs no halving; none where it does.
    fn decide(&self, xyz: [u32; 3], level: u32) -> Option<Built> {
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

    /// What the node at `xyz` with these children is: upward merging, else a block.
    fn join(&mut self, xyz: [u32; 3], children: &[Built; 8]) -> Result<Built> {
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
        // A free child beside others that differ: inside a solid, so in its shadow.
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

fn built(state: State) -> Built {
    match state {
        State::Lit => Some(Word::LIT),
        State::Shadowed => Some(Word::SHADOWED),
        State::Free => None,
    }
}

#[cfg(test)]
mod tests;
