//! Builds the tree with an explicit stack: each push allocates a frame on the heap and each pop frees it (the
//! paper's §3.1.4).

use crate::tree::build::{BuiltNode, Classify, Work};
use crate::tree::error::Result;
use crate::tree::morton::child_corner;
use crate::tree::reduce::Sink;

/// A node waiting for its children.
pub(crate) struct Frame {
    pub(crate) xyz: [u32; 3],
    pub(crate) level: u32,
    /// Number of children that are already known; they precede this one.
    pub(crate) progress: u32,
    pub(crate) children: [BuiltNode; 8],
}

impl Frame {
    pub(crate) fn new(xyz: [u32; 3], level: u32) -> Self {
        Self { xyz, level, progress: 0, children: [None; 8] }
    }
}

/// Allocates and releases frames.
pub(crate) trait Frames {
    fn take(&mut self, xyz: [u32; 3], level: u32) -> Box<Frame>;
    fn give_back(&mut self, frame: Box<Frame>);
}

/// The plain heap.
struct Heap;

impl Frames for Heap {
    fn take(&mut self, xyz: [u32; 3], level: u32) -> Box<Frame> {
        Box::new(Frame::new(xyz, level))
    }

    fn give_back(&mut self, frame: Box<Frame>) {
        drop(frame);
    }
}

pub(crate) fn build<C: Classify, S: Sink>(work: &mut Work<'_, C, S>, depth: u32) -> Result<BuiltNode> {
    walk(work, depth, &mut Heap)
}

/// Takes one step per iteration: descends into the next child, or finishes the node and hands it to its
/// parent.
pub(crate) fn walk<C: Classify, S: Sink>(
    work: &mut Work<'_, C, S>,
    depth: u32,
    frames: &mut impl Frames,
) -> Result<BuiltNode> {
    if let Some(decided) = work.decide([0; 3], depth) {
        return Ok(decided);
    }
    let mut stack = vec![frames.take([0; 3], depth)];
    loop {
        let Some(frame) = stack.last_mut() else { unreachable!("the root leaves by the return below") };
        if frame.progress < 8 {
            let (xyz, level) = (child_corner(frame.xyz, frame.level, frame.progress), frame.level - 1);
            match work.decide(xyz, level) {
                Some(decided) => {
                    frame.children[frame.progress as usize] = decided;
                    frame.progress += 1;
                }
                None => stack.push(frames.take(xyz, level)),
            }
            continue;
        }
        let joined = work.join(frame.xyz, &frame.children)?;
        if let Some(done) = stack.pop() {
            frames.give_back(done);
        }
        let Some(above) = stack.last_mut() else { return Ok(joined) };
        above.children[above.progress as usize] = joined;
        above.progress += 1;
    }
}
