//! stub
/// What is wrong with a shadow file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FormatError {
    /// Not a shadow file.
    #[error("not an adumbra file: it does not begin with ADUMBRA and a line break")]
    Magic,
}
