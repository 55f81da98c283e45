//! Exit codes, and the code of each error.

use std::io::ErrorKind;
use std::process::ExitCode;

use adumbra::{FormatError, IoError, RangeError};

use crate::advice::{options_of_bake, options_of_reader, options_of_scene, shown};

/// Exit code of a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Code {
    /// Success.
    Fine = 0,
    /// A check failed: a measured value does not meet its requirement.
    CheckFailed = 1,
    /// The arguments ask for something that does not exist, or they contradict each other.
    Usage = 2,
    /// A file cannot be read, or does not contain what was expected.
    BadInput = 3,
    /// Memory, disk space or device memory is insufficient.
    OutOfRoom = 4,
    /// The GPU was lost.
    DeviceLost = 5,
    /// Something is missing now, or unreachable: the same command may succeed later.
    TryAgain = 75,
    /// A signal ended the program.
    Interrupted = 130,
}

impl From<Code> for ExitCode {
    fn from(code: Code) -> Self {
        Self::from(code as u8)
    }
}

/// An error that ends a verb early.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Failure {
    /// Wrong arguments. The text says which, and what to give instead.
    #[error("{0}")]
    Usage(String),
    /// A wrong input. The text says which, and what it should be.
    #[error("{0}")]
    BadInput(String),
    /// An error of the operating system while reading or writing.
    #[error(transparent)]
    Io(#[from] IoError),
    /// An error of a shadow file, a look-up or a sun.
    #[error("{0}{options}", options = shown(options_of_reader(.0)))]
    Reader(#[from] adumbra::Error),
    /// An error of a scene.
    #[error("{0}{options}", options = shown(options_of_scene(.0)))]
    Scene(#[from] adumbra_scene::Error),
    /// An error of a bake.
    #[error("{0}{options}", options = shown(options_of_bake(.0)))]
    Bake(#[from] adumbra_bake::Error),
    /// A file that takes more memory than the limit allows.
    #[error(
        "{what} may take {} MiB, but {} MiB are allowed; allow more (--max-memory)",
        needed_bytes.div_ceil(1 << 20),
        limit_bytes >> 20
    )]
    FileMemory {
        /// The file, or the part of it that is read.
        what: &'static str,
        /// The memory that it may need.
        needed_bytes: u64,
        /// The limit.
        limit_bytes: u64,
    },
    /// An error of a library that this crate does not depend on, with the exit code that the caller assigns
    /// to it.
    #[error("{message}")]
    Other {
        /// The program's exit code.
        code: Code,
        /// The error message.
        message: String,
    },
}

impl From<adumbra_truth::movers::MoverError> for Failure {
    fn from(error: adumbra_truth::movers::MoverError) -> Self {
        Self::Usage(error.to_string())
    }
}

impl From<adumbra_path::Error> for Failure {
    fn from(error: adumbra_path::Error) -> Self {
        match error {
            adumbra_path::Error::Bake(error) => error.into(),
            adumbra_path::Error::Library(error) => error.into(),
            other => Self::BadInput(other.to_string()),
        }
    }
}

impl From<RangeError> for Failure {
    fn from(error: RangeError) -> Self {
        Self::Reader(error.into())
    }
}

impl Failure {
    /// Returns the error that `what` needs more memory than the limit allows.
    pub fn memory(what: &'static str, needed_bytes: u64, limit_bytes: u64) -> Self {
        adumbra_bake::Error::MemoryLimit { what, needed_bytes, limit_bytes }.into()
    }

    /// Returns the program's exit code for this error.
    pub fn code(&self) -> Code {
        match self {
            Self::Usage(_) => Code::Usage,
            Self::BadInput(_) => Code::BadInput,
            Self::Io(error) => code_of_io(error),
            Self::Reader(error) => code_of_reader(error),
            Self::Scene(error) => code_of_scene(error),
            Self::Bake(error) => code_of_bake(error),
            Self::FileMemory { .. } => Code::OutOfRoom,
            Self::Other { code, .. } => *code,
        }
    }
}

fn code_of_io(error: &IoError) -> Code {
    match error.source.kind() {
        ErrorKind::StorageFull
        | ErrorKind::QuotaExceeded
        | ErrorKind::FileTooLarge
        | ErrorKind::OutOfMemory => Code::OutOfRoom,
        ErrorKind::ConnectionRefused
        | ErrorKind::ConnectionReset
        | ErrorKind::HostUnreachable
        | ErrorKind::NetworkUnreachable
        | ErrorKind::NetworkDown
        | ErrorKind::ResourceBusy
        | ErrorKind::StaleNetworkFileHandle
        | ErrorKind::TimedOut => Code::TryAgain,
        _ => Code::BadInput,
    }
}

fn code_of_reader(error: &adumbra::Error) -> Code {
    use adumbra::Error as E;
    match error {
        E::Range(_) | E::SunDirection { .. } | E::SunBelowHorizon { .. } => Code::Usage,
        E::Io(error) => code_of_io(error),
        E::Format { source, .. } if matches!(**source, FormatError::TooLarge { .. }) => Code::OutOfRoom,
        _ => Code::BadInput,
    }
}

fn code_of_scene(error: &adumbra_scene::Error) -> Code {
    use adumbra_scene::Error as E;
    match error {
        E::GroundSize { .. } | E::Pattern { .. } | E::GltfIsYUp { .. } => Code::Usage,
        E::SceneMemory { .. } => Code::OutOfRoom,
        E::Io(error) => code_of_io(error),
        _ => Code::BadInput,
    }
}

fn code_of_bake(error: &adumbra_bake::Error) -> Code {
    use adumbra_bake::Error as E;
    match error {
        E::Range(_) | E::Resolution { .. } | E::NoPart { .. } => Code::Usage,
        E::MissingParts { .. } => Code::TryAgain,
        E::MemoryLimit { .. } | E::TooManyWords { .. } => Code::OutOfRoom,
        E::Interrupted => Code::Interrupted,
        E::Io(error) | E::Spill(error) => code_of_io(error),
        E::File(error) => code_of_reader(error),
        E::Scene(error) => code_of_scene(error),
        _ => Code::BadInput,
    }
}

/// Result of a verb.
pub type Outcome = Result<Code, Failure>;

#[cfg(test)]
mod tests {
    use adumbra::RangeField;
    use adumbra_bake::BakeField;
    use adumbra_scene::EmptyReason;

    use super::*;

    #[test]
    fn errors_map_to_exit_codes_and_name_options() {
        let range = |field| Failure::from(RangeError::new(field, "x", "y"));
        let bake_range = |field| Failure::from(adumbra_bake::Error::from(RangeError::new(field, "x", "y")));
        let memory = Failure::memory("the bake", 2, 1);
        let resolution: Failure =
            adumbra_bake::Error::Resolution { resolution: 1000, min: 8, max: 16, suggestion: 16 }.into();
        let interrupted: Failure = adumbra_bake::Error::Interrupted.into();
        let empty =
            |reason| -> Failure { adumbra_scene::Error::NoTriangles { path: "a.glb".into(), reason }.into() };
        let full = std::io::Error::from(ErrorKind::StorageFull);
        let missing: Failure = adumbra_bake::Error::MissingParts { missing: 2, level: 0, first: 7 }.into();
        let away: Failure = IoError::at("read", "store")(ErrorKind::TimedOut.into()).into();
        let spill: Failure = adumbra_bake::Error::Spill(IoError::at("write", "/tmp")(full)).into();
        for (failure, code, options) in [
            (bake_range(BakeField::Thickness), Code::Usage, "(--thickness)"),
            (range(RangeField::FilterWidth), Code::Usage, "(--filter)"),
            (range(RangeField::LongestSide), Code::Usage, "must be y"),
            (memory, Code::OutOfRoom, "(--max-memory, --resolution, --threads)"),
            (resolution, Code::Usage, "(--resolution)"),
            (interrupted, Code::Interrupted, "nothing was written"),
            (empty(EmptyReason::AllAnimated { instances: 1 }), Code::BadInput, "(--include-animated)"),
            (empty(EmptyReason::Filtered { unmatched: Vec::new() }), Code::BadInput, "(--only, --exclude)"),
            (spill, Code::OutOfRoom, "(--max-memory)"),
            (Failure::Usage("no".to_owned()), Code::Usage, "no"),
            (missing, Code::TryAgain, "link again"),
            (away, Code::TryAgain, "timed out"),
        ] {
            assert_eq!(failure.code(), code, "{failure}");
            assert!(failure.to_string().ends_with(options), "{failure}");
        }
    }
}
