//! Decides whether a bake assumes a ground, and describes the decision.

use std::fmt;

use adumbra_bake::{AssumeGround, BakeOptions, Ground};
use adumbra_scene::Scene;

/// Whether shadows below the last surface are left out, and why.
pub(super) struct DecidedGround {
    pub(super) is_assumed: bool,
    /// The measurements; `None` if the options decide.
    measured: Option<Ground>,
}

impl DecidedGround {
    /// Decides for the bake of `scene`, and writes the decision to its options. Cost: that of [`Ground::of`]
    /// at most.
    pub(super) fn of(scene: &Scene, options: &mut BakeOptions) -> Self {
        let measured = (options.assume_ground == AssumeGround::Auto).then(|| Ground::of(scene));
        let is_assumed = match &measured {
            Some(ground) => ground.is_there(),
            None => options.assume_ground == AssumeGround::Yes,
        };
        options.assume_ground = is_assumed.into();
        Self { is_assumed, measured }
    }
}

impl fmt::Display for DecidedGround {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let done = if self.is_assumed { "left out" } else { "kept" };
        let why = match (&self.measured, self.is_assumed) {
            (None, _) => "as asked",
            (Some(_), true) => "the scene has a ground",
            (Some(_), false) => "the scene has no ground of its own; --assume-ground yes leaves them out",
        };
        write!(f, "shadows below the last surface are {done}: {why}")
    }
}
