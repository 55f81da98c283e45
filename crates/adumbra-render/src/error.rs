//! Whatever ends a drawing early.

/// Why the GPU could not be used, or drew nothing.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// No adapter: no GPU, no driver, and no software Vulkan either.
    #[error(
        "no GPU adapter was found ({reason}); install a Vulkan, Metal or DirectX 12 driver, or Mesa's software Vulkan (Debian: \
         apt-get install mesa-vulkan-drivers)"
    )]
    NoAdapter {
        /// What was asked and what came back.
        reason: String,
    },
    /// The adapter gave no device.
    #[error("the adapter {adapter} gives no device: {reason}")]
    NoDevice {
        /// Its name.
        adapter: String,
        /// What it said.
        reason: String,
    },
    /// The device went away or stopped answering; nothing that it held can be read any more.
    #[error(
        "the GPU device was lost: {reason}; run it again, with a smaller picture or map if it happens again"
    )]
    Lost {
        /// What was said.
        reason: String,
    },
    /// The device has no memory left for what was asked of it.
    #[error(
        "the GPU is out of memory: {reason}; make the picture or the maps smaller, or leave parts of the scene out"
    )]
    OutOfMemory {
        /// What was said.
        reason: String,
    },
    /// The device refused what was asked of it.
    #[error("the GPU refused a command: {reason}")]
    Refused {
        /// What was said.
        reason: String,
    },
    /// Something is larger than the device takes.
    #[error("{what} takes {bytes} bytes, and this device takes at most {limit}; {mend}")]
    TooLarge {
        /// The thing.
        what: String,
        /// Its size.
        bytes: u64,
        /// What the device takes.
        limit: u64,
        /// What to do.
        mend: &'static str,
    },
    /// A depth image that no shadow map holds.
    #[error("a depth image cannot be used: {what}")]
    DepthImage {
        /// What is wrong with it, and where.
        what: String,
    },
    /// Baked voxels that are more than the shaders take.
    #[error("{what} is {value}, and a look-up on this device takes at most {limit}; {mend}")]
    VoxelLimit {
        /// What is counted.
        what: &'static str,
        /// How much there is.
        value: u64,
        /// How much there may be.
        limit: u64,
        /// What to do.
        mend: &'static str,
    },
    /// Words that are not, or do not fit, the pages of a texture.
    #[error("the texture's pages: {source}")]
    Pages {
        /// What is wrong.
        source: adumbra::texture::TextureError,
    },
    /// A technique that does not exist, or a value that it does not take.
    #[error("technique {name}: {reason}")]
    Technique {
        /// As it was given.
        name: String,
        /// What is wrong, and what would do.
        reason: String,
    },
    /// Ambient visibility that was made elsewhere and does not fit.
    #[error("the ambient visibility given: {reason}")]
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
    /// A mover that does not exist, a value that it does not take, or no way for it.
    #[error("{name:?} cannot move: {reason}")]
    Mover {
        /// As it was given.
        name: String,
        /// What is wrong, and what would do.
        reason: String,
    },
    /// A file of another layout has no graph that could be drawn with.
    #[error("the shadow file's graph cannot be made: {0}")]
    Conversion(#[from] adumbra::dag::TooLarge),
    /// The library's own.
    #[error(transparent)]
    Library(#[from] adumbra::Error),
}

/// Short for results of this crate.
pub type Result<T> = std::result::Result<T, RenderError>;
