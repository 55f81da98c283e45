//! Errors of a bake.

use std::fmt;

use adumbra::layout::depths::write::OutOfReach;
use adumbra::{IoError, RangeError};

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refused to read or write something.
    #[error(transparent)]
    Io(#[from] IoError),
    /// The file could not be written.
    #[error("cannot write the file: {0}")]
    Output(#[source] std::io::Error),
    /// Data that does not fit the memory limit cannot be kept on disk.
    #[error("{0}; the bake stores there what exceeds its memory limit")]
    Spill(#[source] IoError),
    /// An option is out of its range.
    #[error(transparent)]
    Range(#[from] RangeError<BakeField>),
    /// The scene cannot be edited.
    #[error(transparent)]
    Scene(#[from] adumbra_scene::Error),
    /// The sun, a term of the bias or the size of a region is not valid.
    #[error(transparent)]
    File(#[from] adumbra::Error),
    /// The resolution is not a power of two within its range.
    #[error("resolution {resolution} is not a power of two from {min} to {max}; try {suggestion}")]
    Resolution {
        /// The given resolution.
        resolution: u64,
        /// Smallest allowed resolution.
        min: u32,
        /// Largest allowed resolution.
        max: u32,
        /// The next allowed resolution.
        suggestion: u32,
    },
    /// The result has more words than its pointers can address.
    #[error(
        "{what} has more words than its pointers can address; lower the resolution, or bake parts of the scene with bounds"
    )]
    TooManyWords {
        /// What was being built.
        what: &'static str,
    },
    /// The work does not fit into the allowed memory.
    #[error("{what} would take at least {} MiB, but {} MiB are allowed; raise the memory limit, lower the resolution or use fewer threads", needed_bytes.div_ceil(1 << 20), limit_bytes >> 20)]
    MemoryLimit {
        /// What was being done.
        what: &'static str,
        /// Estimated number of bytes needed.
        needed_bytes: u64,
        /// The limit in force.
        limit_bytes: u64,
    },
    /// A plan was not written by [`BakePlan`](crate::BakePlan), or was damaged.
    #[error("the plan is not valid: {0}; plan the bake again")]
    Plan(String),
    /// A scene is not the one that was planned.
    #[error("{0}; plan the bake again, or give the scene that was planned")]
    SceneChanged(&'static str),
    /// Parts of a plan have not been baked.
    #[error(
        "{missing} parts of level {level} are not baked, such as part {first}; bake them, then link again"
    )]
    MissingParts {
        /// Number of parts whose entries are missing or damaged.
        missing: usize,
        /// The coarsest level with such parts.
        level: usize,
        /// The id of a missing part.
        first: usize,
    },
    /// A plan has no such part.
    #[error("the plan has the parts 0 to {last}, not part {id}")]
    NoPart {
        /// The id that was asked for.
        id: usize,
        /// The last id of the plan.
        last: usize,
    },
    /// The caller asked to stop.
    #[error("interrupted; nothing was written")]
    Interrupted,
}

impl From<RangeError> for Error {
    fn from(error: RangeError) -> Self {
        Self::File(error.into())
    }
}

impl From<OutOfReach> for Error {
    fn from(_: OutOfReach) -> Self {
        Self::TooManyWords { what: "a page of the quadtree of depths" }
    }
}

/// An option of a bake that has a range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BakeField {
    /// Thickness of open surfaces.
    Thickness,
    /// How far behind a surface a column may switch.
    SwitchLimit,
    /// Number of levels of detail.
    Levels,
    /// The bounds of the bake.
    Bounds,
    /// Texels on the longest side.
    Resolution,
    /// Edge of a voxel.
    VoxelSize,
    /// Turn of the grid about the vertical.
    Yaw,
}

/// The name in messages.
impl fmt::Display for BakeField {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Thickness => "the thickness",
            Self::SwitchLimit => "the switch limit",
            Self::Levels => "the number of levels",
            Self::Bounds => "the bounds",
            Self::Resolution => "the resolution",
            Self::VoxelSize => "the voxel size",
            Self::Yaw => "the yaw",
        })
    }
}

/// Shorthand used across the crate.
pub(crate) type Result<T, E = Error> = std::result::Result<T, E>;
