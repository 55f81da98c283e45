//! Builds the tree with an explicit stack whose frames are kept and reused (the paper's §3.1.4).

use crate::tree::build::iterative::{Frame, Frames, walk};
use crate::tree::build::{BuiltNode, Classify, Work};
use crate::tree::error::Result;
use crate::tree::reduce::Sink;

/// Frames that are not in use.
#[derive(Default)]
#[expect(clippy::vec_box, reason = "a waiting frame keeps its address on the heap")]
struct Pool {
    free: Vec<Box<Frame>>,
}

impl Frames for Pool {
    fn take(&mut self, xyz: [u32; 3], level: u32) -> Box<Frame> {
        match self.free.pop() {
            Some(mut frame) => {
                *frame = Frame::new(xyz, level);
                frame
            }
            None => Box::new(Frame::new(xyz, level)),
        }
    }

    fn give_back(&mut self, frame: Box<Frame>) {
        self.free.push(frame);
    }
}

pub(crate) fn build<C: Classify, S: Sink>(work: &mut Work<'_, C, S>, depth: u32) -> Result<BuiltNode> {
    walk(work, depth, &mut Pool::default())
}
