//! Exit codes, and which error gives which.

use std::io::ErrorKind;
use std::process::ExitCode;

use adumbra_render::RenderError;
use adumbra_view::ViewError;

/// What the program tells its caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Code {
    Fine = 0,
    CheckFailed = 1,
    Usage = 2,
    BadInput = 3,
    OutOfRoom = 4,
    DeviceLost = 5,
    Interrupted = 130,
}

impl From<Code> for ExitCode {
    fn from(code: Code) -> Self {
        Self::from(code as u8)
    }
}

/// Whatever ends a verb early.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error("{0}")]
    Usage(String),
    #[error("{0}")]
    BadInput(String),
    #[error(transparent)]
    Library(#[from] adumbra::Error),
    #[error(transparent)]
    Render(RenderError),
}

impl From<RenderError> for Failure {
    fn from(error: RenderError) -> Self {
        match error {
            RenderError::Library(error) => Self::Library(error),
            other => Self::Render(other),
        }
    }
}

impl From<adumbra_lab::Error> for Failure {
    fn from(error: adumbra_lab::Error) -> Self {
        match error {
            adumbra_lab::Error::Library(error) => Self::Library(error),
            adumbra_lab::Error::Render(error) => error.into(),
            other => Self::BadInput(other.to_string()),
        }
    }
}

impl From<ViewError> for Failure {
    fn from(error: ViewError) -> Self {
        match error {
            ViewError::Library(error) => Self::Library(error),
            ViewError::Render(error) => error.into(),
            ViewError::Options { what } => Self::Usage(what),
            other => Self::BadInput(other.to_string()),
        }
    }
}

impl Failure {
    pub(crate) fn code(&self) -> Code {
        use adumbra::Error as E;
        match self {
            Self::Usage(_)
            | Self::Library(
                E::OptionRange { .. }
                | E::Pattern { .. }
                | E::SunDirection { .. }
                | E::SunBelowHorizon { .. }
                | E::Resolution { .. },
            ) => Code::Usage,
            Self::Library(E::MemoryLimit { .. } | E::SceneMemory { .. } | E::TooManyWords { .. }) => {
                Code::OutOfRoom
            }
            Self::Library(E::Interrupted) => Code::Interrupted,
            Self::Library(E::Io { source, .. }) => match source.kind() {
                ErrorKind::StorageFull
                | ErrorKind::QuotaExceeded
                | ErrorKind::FileTooLarge
                | ErrorKind::OutOfMemory => Code::OutOfRoom,
                _ => Code::BadInput,
            },
            Self::Render(
                RenderError::Technique { .. } | RenderError::Mover { .. } | RenderError::Camera { .. },
            ) => Code::Usage,
            Self::Render(RenderError::TooLarge { .. } | RenderError::OutOfMemory { .. }) => Code::OutOfRoom,
            Self::Render(RenderError::Lost { .. }) => Code::DeviceLost,
            Self::BadInput(_) | Self::Library(_) | Self::Render(_) => Code::BadInput,
        }
    }
}

pub(crate) type Outcome = Result<Code, Failure>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_the_renderer_have_their_codes() {
        let lost = RenderError::Lost { reason: "gone".to_owned() };
        let unknown = RenderError::Technique { name: "cvs".to_owned(), reason: "no such".to_owned() };
        assert_eq!(Failure::from(lost).code() as u8, 5);
        assert_eq!(Failure::from(unknown).code() as u8, 2);
    }
}
