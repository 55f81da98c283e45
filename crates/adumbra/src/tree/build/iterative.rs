//! The tree with an explicit stack: every push makes a frame on the heap, every pop gives it back (the paper's §3.1.4).

use super::{Built, Classify, Work};
use crate::error::Result;
use crate::tree::morton::child_corner;
use crate::tree::reduce::Sink;

/// A node that waits for its children.
pub(super) struct Frame {
    pub(super) xyz: [u32; 3],
    pub(super) level: u32,
    /// How far it has got: children before this one are known.
    pub(super) progress: u32,
    pub(super) children: [Built; 8],
}

impl Frame {
    pub(super) fn new(xyz: [u32; 3], level: u32) -> Self {
        Self { xyz, level, progress: 0, children: [None; 8] }
    }
}

/// Where frames come from and go to.
pub(super) trait Frames {
    fn take(&mut self, xyz: [u32; 3], level: u32) -> Box<Frame>;
    fn give_back(&mut self, frame: Box<Frame>);
}

/// The heap itself.
struct Heap;

impl Frames for Heap {
    fn take(&mut self, xyz: [u32; 3], level: u32) -> Box<Frame> {
        Box::new(Frame::new(xyz, level))
    }

    fn give_back(&mut self, frame: Box<Frame>) {
        drop(frame);
    }
}

pub(super) fn build<C: Classify, S: Sink>(work: &mut Work<'_, C, S>, depth: u32) -> Result<Built> {
    walk(work, depth, &mut Heap)
}

/// One step a turn: go down into the next child, or finish the node and hand it to the one above.
pub(super) fn walk<C: Classify, S: Sink>(
    work: &mut Work<'_, C, S>,
    depth: u32,
    frames: &mut impl Frames,
) -> Result<Built> {
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
