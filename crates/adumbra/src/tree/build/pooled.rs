//! The tree with an explicit stack whose frames are kept and used again (the paper's §3.1.4).

use super::iterative::{Frame, Frames, walk};
use super::{Built, Classify, Work};
use crate::error::Result;
use crate::tree::reduce::Sink;

/// Frames that nobody uses now.
#[derive(Default)]
#[expect(clippy::vec_box, reason = "a frame that waits keeps the place on the heap that it was pushed to")]
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

pub(super) fn build<C: Classify, S: Sink>(work: &mut Work<'_, C, S>, depth: u32) -> Result<Built> {
    walk(work, depth, &mut Pool::default())
}
