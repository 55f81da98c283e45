//! The crate's single error type. Every message says what is wrong and, if there is a remedy, how to fix it.

use std::path::PathBuf;

use adumbra_program::exit::{Code, Failure};
use adumbra_render::{Fix, RenderError};
use adumbra_truth::picture::Picture;

/// Errors of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The renderer failed.
    #[error(transparent)]
    Render(Box<RenderError>),
    /// A core crate failed, or the request to a benchmark was invalid.
    #[error(transparent)]
    Program(Box<Failure>),
    /// Two inputs that belong together differ in size.
    #[error("{what} differ in size: {left} and {right}")]
    Sizes {
        /// Description of both.
        what: &'static str,
        /// Size of the first.
        left: usize,
        /// Size of the second.
        right: usize,
    },
    /// A picture is smaller than a metric's window.
    #[error(
        "the picture has {width} x {height} pixels; structural similarity needs at least {least} per side"
    )]
    PictureTooSmall {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
        /// Required width and height in pixels.
        least: u32,
    },
    /// The contents of a truth file are invalid.
    #[error("{path:?}: not a truth file: {what}; it must be a NumPy .npz with the arrays pos, normal, ndotl, sun, ao, valid and camera", path = path.display())]
    TruthFile {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// The contents of a camera path are invalid.
    #[error("{path:?}: not a camera path: {what}", path = path.display())]
    CameraPath {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// The contents of a camera file are invalid.
    #[error("{path:?}: not a camera: {what}", path = path.display())]
    CameraFile {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// No point on the ground suits a street-level camera.
    #[error(
        "no street-level camera found: no place on the ground has open sky and a clear view; give the camera's eye and target"
    )]
    NoStreet,
}

/// The crate's result type.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// Checks that two inputs that belong together have one size. `what` names both, as a plural.
    ///
    /// # Errors
    /// Returns [`Error::Sizes`].
    pub fn check_sizes(what: &'static str, left: usize, right: usize) -> Result<()> {
        if left == right { Ok(()) } else { Err(Self::Sizes { what, left, right }) }
    }

    pub(crate) fn check_pictures(a: &Picture, b: &Picture) -> Result<()> {
        Self::check_sizes("the pictures' widths", a.width as usize, b.width as usize)?;
        Self::check_sizes("the pictures' heights", a.height as usize, b.height as usize)?;
        Self::check_sizes("the pictures' bytes", a.rgb.len(), b.rgb.len())
    }
}

impl From<RenderError> for Error {
    fn from(error: RenderError) -> Self {
        Self::Render(Box::new(error))
    }
}

/// Converts errors of the core crates by way of [`Failure`].
macro_rules! from_core {
    ($($error:ty),*) => {
        $(impl From<$error> for Error {
            fn from(error: $error) -> Self {
                Failure::from(error).into()
            }
        })*
    };
}

from_core!(
    adumbra::Error,
    adumbra::IoError,
    adumbra::RangeError,
    adumbra_bake::Error,
    adumbra_path::Error,
    adumbra_scene::Error,
    adumbra_truth::movers::MoverError
);

impl From<Failure> for Error {
    fn from(failure: Failure) -> Self {
        Self::Program(Box::new(failure))
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        match error {
            Error::Program(failure) => *failure,
            Error::Render(error) => match *error {
                RenderError::Library(error) => error.into(),
                error => {
                    let options =
                        options_of(&error).map_or_else(String::new, |options| format!(" ({options})"));
                    Self::Other { code: code_of(&error), message: format!("{error}{options}") }
                }
            },
            error @ Error::NoStreet => Self::BadInput(format!("{error} (--eye, --target)")),
            other => Self::BadInput(other.to_string()),
        }
    }
}

/// Returns the command-line options that an error's advice refers to. Libraries do not name options in their
/// messages.
fn options_of(error: &RenderError) -> Option<&'static str> {
    let (RenderError::TooLarge { fix, .. } | RenderError::VoxelLimit { fix, .. }) = error else {
        return None;
    };
    Some(match fix {
        Fix::SmallerPicture => "--size, --antialias",
        Fix::SmallerScene => "--only, --exclude",
        Fix::LowerResolution => "--resolution",
        Fix::Other(_) => return None,
    })
}

fn code_of(error: &RenderError) -> Code {
    match error {
        RenderError::Technique { .. } | RenderError::Camera { .. } => Code::Usage,
        RenderError::TooLarge { .. } | RenderError::OutOfMemory { .. } => Code::OutOfRoom,
        RenderError::Lost { .. } => Code::DeviceLost,
        _ => Code::BadInput,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_the_renderer_have_their_codes() {
        let lost = RenderError::Lost { reason: "gone".to_owned() };
        let unknown = RenderError::Technique { name: "cvs".to_owned(), reason: "no such".to_owned() };
        let code = |error: RenderError| Failure::from(Error::from(error)).code() as u8;
        assert_eq!(code(lost), 5);
        assert_eq!(code(unknown), 2);
    }

    #[test]
    fn errors_of_the_renderer_have_their_options() {
        let fixes = [
            (Fix::SmallerPicture, Some("(--size, --antialias)")),
            (Fix::LowerResolution, Some("(--resolution)")),
            (Fix::Other("make it smaller"), None),
        ];
        for (fix, options) in fixes {
            let error = RenderError::TooLarge { what: "a thing".to_owned(), bytes: 2, limit: 1, fix };
            assert!(!error.to_string().contains("--"), "{error}");
            let failure = Failure::from(Error::from(error)).to_string();
            assert!(options.is_none_or(|o| failure.ends_with(o)), "{failure}");
        }
        let street = Failure::from(Error::NoStreet).to_string();
        assert!(street.ends_with("(--eye, --target)"), "{street}");
    }
}
