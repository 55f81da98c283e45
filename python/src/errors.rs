//! Converts errors of the crates to Python exceptions: `OSError` and its subclasses for errors of the
//! operating system, `ValueError` for values out of range, `adumbra.FormatError` for files that are not
//! valid, `adumbra.AdumbraError` for all others.

use std::io::{self, ErrorKind};

use adumbra::{IoError, RangeError};
use pyo3::PyErr;
use pyo3::exceptions::{PyIndexError, PyOSError, PyValueError};

pyo3::import_exception!(adumbra._errors, AdumbraError);
pyo3::import_exception!(adumbra._errors, FormatError);
pyo3::import_exception!(adumbra._errors, MemoryLimitError);
pyo3::import_exception!(adumbra._errors, MissingPartsError);

/// An error of a crate.
pub(crate) enum Failure {
    Io(IoError),
    Reader(adumbra::Error),
    Scene(adumbra_scene::Error),
    Bake(adumbra_bake::Error),
    /// Bytes of a shadow file that have no path.
    Bytes(adumbra::FormatError),
    /// A file that is not a plan, as a message.
    Plan(String),
    /// A wrong value, as a message.
    Value(String),
    /// An internal error, as a message.
    Internal(String),
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Io(error) => from_io(&error),
            Failure::Reader(error) => from_reader(error),
            Failure::Scene(error) => from_scene(error),
            Failure::Bake(error) => from_bake(error),
            Failure::Bytes(error) => FormatError::new_err(error.to_string()),
            Failure::Plan(what) => FormatError::new_err(what),
            Failure::Value(what) => PyValueError::new_err(what),
            Failure::Internal(what) => AdumbraError::new_err(format!(
                "{what}; this is a fault of adumbra itself: please report it with the input"
            )),
        }
    }
}

fn from_reader(error: adumbra::Error) -> PyErr {
    use adumbra::Error as E;
    match error {
        E::Io(error) => from_io(&error),
        E::Format { .. } => FormatError::new_err(error.to_string()),
        E::SunDirection { .. } | E::SunBelowHorizon { .. } | E::Range(_) => {
            PyValueError::new_err(error.to_string())
        }
        _ => AdumbraError::new_err(error.to_string()),
    }
}

fn from_scene(error: adumbra_scene::Error) -> PyErr {
    use adumbra_scene::Error as E;
    match error {
        E::Io(error) => from_io(&error),
        E::GroundSize { .. } | E::Pattern { .. } | E::UnknownSceneFormat { .. } => {
            PyValueError::new_err(error.to_string())
        }
        E::SceneParse { .. }
        | E::GltfVersion { .. }
        | E::Texture { .. }
        | E::NoTriangles { .. }
        | E::NotFinite { .. }
        | E::ZeroExtent { .. }
        | E::IndexOutOfRange { .. } => FormatError::new_err(error.to_string()),
        E::SceneMemory { .. } => MemoryLimitError::new_err(error.to_string()),
        _ => AdumbraError::new_err(error.to_string()),
    }
}

fn from_bake(error: adumbra_bake::Error) -> PyErr {
    use adumbra_bake::Error as E;
    match error {
        E::Io(error) | E::Spill(error) => from_io(&error),
        E::Output(error) => from_write(error),
        E::Range(_) | E::Resolution { .. } => PyValueError::new_err(error.to_string()),
        E::NoPart { .. } => PyIndexError::new_err(error.to_string()),
        E::File(error) => from_reader(error),
        E::MissingParts { .. } => MissingPartsError::new_err(error.to_string()),
        E::MemoryLimit { .. } | E::TooManyWords { .. } => MemoryLimitError::new_err(error.to_string()),
        _ => AdumbraError::new_err(error.to_string()),
    }
}

/// Returns the Python exception for an error of the operating system. Python chooses its class by the error
/// number.
fn from_io(error: &IoError) -> PyErr {
    let what = format!("cannot {}: {}", error.action, error.source);
    PyOSError::new_err((number(&error.source), what, error.path.display().to_string()))
}

fn from_write(error: io::Error) -> PyErr {
    match error.downcast::<adumbra::FormatError>() {
        Ok(fault) => FormatError::new_err(fault.to_string()),
        Err(error) => PyOSError::new_err((number(&error), format!("cannot write the file: {error}"))),
    }
}

/// Returns the POSIX number of an error. The crates' hints keep an error's kind, but not its number.
fn number(error: &io::Error) -> i32 {
    match error.kind() {
        ErrorKind::NotFound => 2,
        ErrorKind::PermissionDenied => 13,
        ErrorKind::AlreadyExists => 17,
        ErrorKind::NotADirectory => 20,
        ErrorKind::IsADirectory => 21,
        ErrorKind::InvalidInput => 22,
        ErrorKind::StorageFull => 28,
        _ => error.raw_os_error().filter(|_| cfg!(unix)).unwrap_or(5),
    }
}

impl From<IoError> for Failure {
    fn from(error: IoError) -> Self {
        Self::Io(error)
    }
}

impl From<RangeError> for Failure {
    fn from(error: RangeError) -> Self {
        Self::Reader(error.into())
    }
}

impl From<adumbra::Error> for Failure {
    fn from(error: adumbra::Error) -> Self {
        Self::Reader(error)
    }
}

impl From<adumbra_scene::Error> for Failure {
    fn from(error: adumbra_scene::Error) -> Self {
        Self::Scene(error)
    }
}

impl From<adumbra_bake::Error> for Failure {
    fn from(error: adumbra_bake::Error) -> Self {
        Self::Bake(error)
    }
}

impl From<adumbra::FormatError> for Failure {
    fn from(error: adumbra::FormatError) -> Self {
        Self::Bytes(error)
    }
}

impl From<adumbra_solar::Error> for Failure {
    fn from(error: adumbra_solar::Error) -> Self {
        Self::Value(error.to_string())
    }
}

impl From<adumbra_sunlight::Error> for Failure {
    fn from(error: adumbra_sunlight::Error) -> Self {
        Self::Value(error.to_string())
    }
}

impl From<adumbra_path::Error> for Failure {
    fn from(error: adumbra_path::Error) -> Self {
        use adumbra_path::Error as E;
        match error {
            E::Bake(error) => error.into(),
            E::Library(error) => error.into(),
            other => Self::Value(other.to_string()),
        }
    }
}
