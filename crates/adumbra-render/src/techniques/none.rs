//! The technique `none`.

use adumbra_shaders::{Source, source};

use crate::error::Result;
use crate::technique::{Answer, FrameInput, Technique};

/// No shadows: every surface that faces the sun is lit.
pub(super) struct NoShadows;

impl Technique for NoShadows {
    fn name(&self) -> String {
        "none".to_owned()
    }

    fn prepare(&mut self, _input: &FrameInput<'_>) -> Result<()> {
        Ok(())
    }

    fn sources(&self, answer: Answer) -> Option<Vec<Source>> {
        (answer == Answer::Visibility).then(|| vec![source::NONE])
    }
}
