//! Displays a frame: its layers as pictures on the device, one or two of them in a window, lines over them.
//!
//! [`LayerPass`] turns a layer into a display-encoded picture, antialiased by averaging samples.
//! [`PresentPass`] shows one or two such pictures. [`LinePass`] draws lines over one. The CPU twin of the
//! layers' arithmetic is in the command-line program (`adumbra render --layer`).

mod lines;
mod pass;
mod present;

pub use lines::{LinePass, WorldLine};
pub use pass::{LayerPass, SHOWN_FORMAT, ShownPicture};
pub use present::{PresentKind, PresentPass};

use crate::technique::Answer;
use crate::voxel::VOXEL_LEVEL_COLORS;

/// The part of a frame that is displayed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Layer {
    /// The finished picture.
    #[default]
    Color,
    /// The shadow factor: white = lit.
    Shadow,
    /// Ambient visibility: white = unoccluded.
    Ambient,
    /// World normals.
    Normal,
    /// View depth: the nearest is white.
    Depth,
    /// The picture, tinted by cascade.
    Cascades,
    /// The picture, tinted by the level of a hybrid map at which the look-up ends.
    HybridLevels,
    /// The picture, tinted by the size of the block of a baked file in which the look-up ends.
    VoxelSize,
    /// The picture, tinted by the level of detail of a streamed file that answers.
    ResidentLevel,
}

/// Colours of cascades, linear, nearest first.
pub const CASCADE_COLORS: [[f32; 3]; 8] = [
    [0.90, 0.25, 0.20],
    [0.95, 0.65, 0.15],
    [0.40, 0.75, 0.20],
    [0.15, 0.65, 0.65],
    [0.20, 0.40, 0.90],
    [0.55, 0.30, 0.80],
    [0.85, 0.35, 0.65],
    [0.60, 0.60, 0.60],
];

/// Colours of the levels of a hybrid map or of a file, linear, finest first. Levels beyond the last have its
/// colour.
pub const LEVEL_COLORS: [[f32; 3]; 4] =
    [[0.90, 0.22, 0.18], [0.95, 0.65, 0.15], [0.40, 0.75, 0.20], [0.20, 0.40, 0.90]];

impl Layer {
    /// Every layer.
    pub const ALL: [Self; 9] = [
        Self::Color,
        Self::Shadow,
        Self::Ambient,
        Self::Normal,
        Self::Depth,
        Self::Cascades,
        Self::HybridLevels,
        Self::VoxelSize,
        Self::ResidentLevel,
    ];

    /// The layer's name, as used by `adumbra render --layer`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Color => "color",
            Self::Shadow => "shadow",
            Self::Ambient => "ao",
            Self::Normal => "normal",
            Self::Depth => "depth",
            Self::Cascades => "cascades",
            Self::HybridLevels => "hrsm-levels",
            Self::VoxelSize => "voxel-size",
            Self::ResidentLevel => "level",
        }
    }

    /// The answer that this layer needs from a technique besides visibility, and the colours of its values.
    /// `None` if visibility is enough.
    pub fn tint(self) -> Option<(Answer, &'static [[f32; 3]])> {
        match self {
            Self::Cascades => Some((Answer::Cascade, &CASCADE_COLORS)),
            Self::HybridLevels => Some((Answer::Level, &LEVEL_COLORS)),
            Self::VoxelSize => Some((Answer::Voxel, &VOXEL_LEVEL_COLORS)),
            Self::ResidentLevel => Some((Answer::Resident, &LEVEL_COLORS)),
            _ => None,
        }
    }
}
