//! Errors of baking a path.

/// Any error of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A bake of a key failed.
    #[error(transparent)]
    Bake(#[from] adumbra_bake::Error),
    /// The library refused a sun or a setting.
    #[error(transparent)]
    Library(#[from] adumbra::Error),
    /// A file could not be encoded.
    #[error(transparent)]
    Write(#[from] std::io::Error),
    /// No sun of the path is high enough.
    #[error(
        "the sun is never {lowest_degrees}° above the horizon on this path; choose another date or hours, or allow a lower sun"
    )]
    NoSun {
        /// The lowest elevation that keys have.
        lowest_degrees: f64,
    },
}

/// Result type of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;
