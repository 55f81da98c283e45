//! The errors of this crate.

use std::fmt;

/// How to fix something that is larger than the device allows. A program with matching options may name them
/// instead.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fix {
    /// A picture of fewer pixels, or with fewer samples per pixel.
    SmallerPicture,
    /// A scene with fewer parts.
    SmallerScene,
    /// A bake at a lower resolution.
    LowerResolution,
    /// Anything else: a fix that no program has an option for, or a parameter of the technique.
    Other(&'static str),
}

impl fmt::Display for Fix {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::SmallerPicture => "draw fewer pixels, or fewer samples per pixel",
            Self::SmallerScene => "leave parts of the scene out, or split it",
            Self::LowerResolution => "bake at a lower resolution",
            Self::Other(what) => what,
        })
    }
}

/// Why the GPU could not be used, or could not draw.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// No adapter: no GPU, no driver, and no software Vulkan either.
    #[error(
        "no GPU adapter was found ({reason}); install a Vulkan, Metal or DirectX 12 driver, or Mesa's software Vulkan (Debian: \
         apt-get install mesa-vulkan-drivers)"
    )]
    NoAdapter {
        /// The adapter requested and the adapters found.
        reason: String,
    },
    /// The adapter gave no device.
    #[error("the adapter {adapter} provides no device: {reason}")]
    NoDevice {
        /// The adapter's name.
        adapter: String,
        /// The error that it reported.
        reason: String,
    },
    /// A file that is streamed cannot be opened.
    #[error("the shadow file cannot be streamed: {what}")]
    Stream {
        /// Why.
        what: String,
    },
    /// The sun is too far from the suns of the path's keys.
    #[error(
        "the sun towards ({0}, {1}, {2}) is too far from the sun path's keys around it; choose another moment",
        towards_sun[0], towards_sun[1], towards_sun[2]
    )]
    SunTooFar {
        /// Unit vector towards the sun.
        towards_sun: [f64; 3],
    },
    /// The device was lost or stopped responding. Nothing that it held can be read any more.
    #[error(
        "the GPU device was lost: {reason}; run it again, with a smaller picture or map if it happens again"
    )]
    Lost {
        /// The reported reason.
        reason: String,
    },
    /// The device is out of memory.
    #[error(
        "the GPU is out of memory: {reason}; make the picture or the maps smaller, or leave parts of the scene out"
    )]
    OutOfMemory {
        /// The reported reason.
        reason: String,
    },
    /// The device refused a command.
    #[error("the GPU refused a command: {reason}")]
    Refused {
        /// The reported reason.
        reason: String,
    },
    /// Something is larger than the device allows.
    #[error("{what} takes {bytes} bytes, but this device allows at most {limit}; {fix}")]
    TooLarge {
        /// What is too large.
        what: String,
        /// Its size, bytes.
        bytes: u64,
        /// The device's limit, bytes.
        limit: u64,
        /// What to do about it.
        fix: Fix,
    },
    /// A depth image that no shadow map can hold.
    #[error("a depth image cannot be used: {what}")]
    DepthImage {
        /// What is wrong with it, and where.
        what: String,
    },
    /// Baked voxels that exceed a limit of the shaders.
    #[error("{what} is {value}, but look-ups on this device support at most {limit}; {fix}")]
    VoxelLimit {
        /// The quantity that is limited.
        what: &'static str,
        /// Its value.
        value: u64,
        /// The largest value allowed.
        limit: u64,
        /// What to do about it.
        fix: Fix,
    },
    /// A technique that does not exist, or a parameter value that it does not accept.
    #[error("technique {name}: {reason}")]
    Technique {
        /// The technique as it was given.
        name: String,
        /// What is wrong, and what would be accepted.
        reason: String,
    },
    /// Ambient visibility that was supplied from outside and does not fit.
    #[error("the given ambient visibility: {reason}")]
    Ambient {
        /// What is wrong.
        reason: String,
    },
    /// A camera from which nothing can be drawn.
    #[error("the camera: {reason}")]
    Camera {
        /// What is wrong.
        reason: &'static str,
    },
    /// An error of [`adumbra`].
    #[error(transparent)]
    Library(#[from] adumbra::Error),
    /// An error of a technique that a dependent crate adds.
    #[error(transparent)]
    Other(Box<dyn std::error::Error + Send + Sync>),
}

/// The result type of this crate.
pub type Result<T> = std::result::Result<T, RenderError>;

impl From<adumbra::RangeError> for RenderError {
    fn from(error: adumbra::RangeError) -> Self {
        Self::Library(error.into())
    }
}
