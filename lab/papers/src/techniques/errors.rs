//! The errors of trees and graphs as errors of the renderer, of a comparison and of a program.

use adumbra_program::exit::{Code, Failure};
use adumbra_render::RenderError;

use crate::dag;
use crate::tree::{Error, TextureError, TreeOption};

impl From<Error> for RenderError {
    fn from(error: Error) -> Self {
        match error {
            Error::Range(error) => error.into(),
            error => Self::Other(Box::new(error)),
        }
    }
}

impl From<Error> for adumbra_compare::Error {
    fn from(error: Error) -> Self {
        Failure::from(error).into()
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        match error {
            Error::Range(error) => error.into(),
            Error::Option(error) => Self::Usage(format!("{error} ({})", option_of(error.option))),
            Error::Bake(error) => error.into(),
            Error::Reader(error) => (*error).into(),
            Error::Io(error) => error.into(),
            Error::WordTexture { source: TextureError::TooManyPages { .. }, .. } => {
                Self::BadInput(format!("{error} (--max-side, --resolution)"))
            }
            error => Self::Other { code: Code::BadInput, message: error.to_string() },
        }
    }
}

impl From<dag::Error> for RenderError {
    fn from(error: dag::Error) -> Self {
        match error {
            dag::Error::Reader(error) => Self::Library(*error),
            error => Self::Other(Box::new(error)),
        }
    }
}

impl From<dag::Error> for adumbra_compare::Error {
    fn from(error: dag::Error) -> Self {
        Failure::from(error).into()
    }
}

impl From<dag::Error> for Failure {
    fn from(error: dag::Error) -> Self {
        match error {
            dag::Error::Bake(error) => error.into(),
            dag::Error::Reader(error) => (*error).into(),
            dag::Error::Io(error) => error.into(),
            error => Self::Other { code: Code::BadInput, message: error.to_string() },
        }
    }
}

fn option_of(option: TreeOption) -> &'static str {
    match option {
        TreeOption::CaptureBiasTerm => "--capture-bias-constant, --capture-bias-slope",
        TreeOption::Rings => "--rings",
        TreeOption::Region => "--region",
        TreeOption::LossyShare => "--lossy",
    }
}
