//! The crate's one error type: every variant carries what was wrong and (in its message) the mend.

use std::path::PathBuf;

use adumbra::picture::Picture;

/// Everything that can go wrong in this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The library could not do its part.
    #[error(transparent)]
    Library(#[from] adumbra::Error),
    /// The renderer could not do its part.
    #[error(transparent)]
    Render(#[from] adumbra_render::RenderError),
    /// Two things that belong together differ in size.
    #[error("{what} differ in size: {left} and {right}")]
    Sizes {
        /// Which two.
        what: &'static str,
        /// Values of the first.
        left: usize,
        /// Values of the second.
        right: usize,
    },
    /// A picture is smaller than a metric's window.
    #[error("the picture has {width} x {height} pixels; structural similarity needs {least} a side")]
    PictureTooSmall {
        /// Pixels.
        width: u32,
        /// Pixels.
        height: u32,
        /// Fewest a side.
        least: u32,
    },
    /// A truth file does not hold what it must.
    #[error("{path:?}: not a truth file: {what}; it must be a NumPy .npz with the arrays pos, normal, ndotl, sun, ao, valid and camera", path = path.display())]
    TruthFile {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// A camera path does not hold what it must.
    #[error("{path:?}: not a camera path: {what}", path = path.display())]
    CameraPath {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// A camera file does not hold what it must.
    #[error("{path:?}: not a camera: {what}", path = path.display())]
    CameraFile {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// No place on the ground suits a street-level camera.
    #[error(
        "no street-level camera was found: no place on the ground has open sky above and a view; give --eye and --target"
    )]
    NoStreet,
    /// Bytes are not a picture.
    #[error("not a picture: {what}")]
    Picture {
        /// What the decoder said.
        what: String,
    },
    /// A picture cannot be encoded.
    #[error("cannot encode a picture of {width} x {height} pixels: {what}")]
    Encode {
        /// Pixels.
        width: u32,
        /// Pixels.
        height: u32,
        /// What the encoder said.
        what: String,
    },
}

/// Shorthand used across the crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    pub(crate) fn check_sizes(what: &'static str, left: usize, right: usize) -> Result<()> {
        if left == right { Ok(()) } else { Err(Self::Sizes { what, left, right }) }
    }

    pub(crate) fn check_pictures(a: &Picture, b: &Picture) -> Result<()> {
        Self::check_sizes("the pictures' widths", a.width as usize, b.width as usize)?;
        Self::check_sizes("the pictures' heights", a.height as usize, b.height as usize)?;
        Self::check_sizes("the pictures' bytes", a.rgb.len(), b.rgb.len())
    }
}
