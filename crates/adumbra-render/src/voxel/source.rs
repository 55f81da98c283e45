//! The sources of a light-aligned file.

use std::sync::Arc;

use adumbra::{Bias, ShadowFile};

use super::{MovingLight, StreamedFile};

/// A light-aligned file: whole, or streamed.
#[derive(Clone, Copy)]
pub enum LightFile<'f> {
    /// A file that was read whole.
    Whole(&'f ShadowFile),
    /// A file whose parts are read when cameras need them.
    Streamed(&'f Arc<StreamedFile>),
    /// A moment of a sun path.
    Between {
        /// The files of the keys around it: the key that look-ups read first, then the other. Both may be the
        /// same file.
        keys: [&'f ShadowFile; 2],
        /// Unit vector towards the sun.
        towards_sun: [f64; 3],
    },
    /// A sun that moves from frame to frame.
    Moving(&'f Arc<MovingLight>),
}

impl LightFile<'_> {
    /// Whether it is a sun path, whose look-ups march rays through two keys.
    pub fn is_path(self) -> bool {
        matches!(self, Self::Between { .. } | Self::Moving(_))
    }

    /// The bias that the file was baked for.
    pub fn bias(self) -> Bias {
        match self {
            Self::Whole(file) | Self::Between { keys: [file, _], .. } => file.settings.bias,
            Self::Streamed(file) => file.settings().bias,
            Self::Moving(light) => light.first_key().settings.bias,
        }
    }
}
