//! What is shown of a frame: its layers as pictures on the device, two of them on a window, lines over them.
//!
//! [`LayerPass`] turns a layer into a display-encoded picture, with antialiasing by the mean of samples; [`PresentPass`] shows one or two
//! such pictures; [`LinePass`] draws boxes over one. The CPU twin of a layer's arithmetic is the program's own (`adumbra render --layer`).

mod lines;
mod pass;
mod present;

pub use lines::{LinePass, WorldLine};
pub use pass::{LayerPass, SHOWN_FORMAT, ShownPicture};
pub use present::{PresentKind, PresentPass};

use crate::technique::Answer;
use crate::voxel::VOXEL_LEVEL_COLORS;

/// What of a frame is shown.
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
    /// Distance along the view: the nearest is white.
    Depth,
    /// The picture, coloured by cascade.
    Cascades,
    /// The picture, coloured by the level of a hybrid map that answers.
    HybridLevels,
    /// The picture, coloured by the block of a baked file in which the look-up ends.
    VoxelSize,
}

/// Linear colours of cascades, the nearest first.
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

/// Linear colours of a hybrid map's levels, the finest first.
pub const LEVEL_COLORS: [[f32; 3]; 4] =
    [[0.90, 0.22, 0.18], [0.95, 0.65, 0.15], [0.40, 0.75, 0.20], [0.20, 0.40, 0.90]];

impl Layer {
    /// Every layer.
    pub const ALL: [Self; 8] = [
        Self::Color,
        Self::Shadow,
        Self::Ambient,
        Self::Normal,
        Self::Depth,
        Self::Cascades,
        Self::HybridLevels,
        Self::VoxelSize,
    ];

    /// As `adumbra render --layer` calls it.
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
        }
    }

    /// What a technique must answer for it besides visibility, and the colours that its answers stand for.
    pub fn tint(self) -> Option<(Answer, &'static [[f32; 3]])> {
        match self {
            Self::Cascades => Some((Answer::Cascade, &CASCADE_COLORS)),
            Self::HybridLevels => Some((Answer::Level, &LEVEL_COLORS)),
            Self::VoxelSize => Some((Answer::Voxel, &VOXEL_LEVEL_COLORS)),
            _ => None,
        }
    }
}
