//! Faults of a shadow file, with the values found.

use std::borrow::Cow;

use crate::layout::depths::DepthsError;

/// A fault of a shadow file. The message names the fault and its location, and says what to do about it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FormatError {
    /// The file does not begin with the magic bytes of a shadow file.
    #[error("not a shadow file: {}", instead(found, expected))]
    Magic {
        /// The first bytes of the file, at most eight.
        found: Vec<u8>,
        /// The expected bytes, as shown in the message.
        expected: &'static str,
    },
    /// The file is one of this project's, but not of the kind that is needed.
    #[error("this is a {found}, but a {needed} is needed here; give such a file, or bake the scene into one")]
    OtherKind {
        /// The kind of the file.
        found: &'static str,
        /// The kind that is needed.
        needed: &'static str,
    },
    /// The file was written by a later version of the program.
    #[error(
        "format version {version}, but this program reads versions up to {supported}; update the program, or bake the scene again with this one"
    )]
    FutureVersion {
        /// The format version of the file.
        version: u32,
        /// The latest version that this program reads.
        supported: u32,
    },
    /// The file ends before its header or one of its sections does.
    #[error(
        "cut off in its {what}: {needed} bytes are needed, but the file has {have}; copy it again, or bake it again"
    )]
    Truncated {
        /// "header", or the section's name.
        what: Cow<'static, str>,
        /// Number of bytes that the file must have up to the end of this part.
        needed: u64,
        /// Number of bytes that the file has.
        have: u64,
    },
    /// The file continues after its last section.
    #[error("continues past its end at byte {end}; copy it again, or bake it again")]
    TrailingBytes {
        /// Offset in bytes at which the file should end.
        end: u64,
    },
    /// The header's checksum does not match.
    #[error(
        "the header is damaged: its checksum is {computed:#010x} instead of {stored:#010x}; copy the file again, or bake it again"
    )]
    HeaderChecksum {
        /// The stored checksum.
        stored: u32,
        /// The checksum of the bytes.
        computed: u32,
    },
    /// A section's checksum does not match.
    #[error(
        "the section {section} is damaged: its checksum is {computed:#010x} instead of {stored:#010x}; copy the file again, or bake it again"
    )]
    SectionChecksum {
        /// The section's name.
        section: Cow<'static, str>,
        /// The stored checksum.
        stored: u32,
        /// The checksum of the bytes.
        computed: u32,
    },
    /// A field of the header has a value that is not allowed.
    #[error("the header's {field} is {value}, but must be {expected}; bake it again")]
    HeaderField {
        /// The field's name in the specification.
        field: &'static str,
        /// The value found.
        value: String,
        /// The values that are allowed, as text.
        expected: String,
    },
    /// An entry of the section table contradicts the rest of the header.
    #[error("the section {section} has {field} {value}, but must have {expected}; bake it again")]
    SectionBounds {
        /// The section's name.
        section: Cow<'static, str>,
        /// "offset", "length" or "raw length".
        field: &'static str,
        /// The value found.
        value: u64,
        /// The value that is allowed, as text.
        expected: String,
    },
    /// A bundle of pages does not fit its entry in the table, or the grid.
    #[error("the {section} has {found}, but must have {expected}; bake it again")]
    Bundle {
        /// The bundle.
        section: String,
        /// What was found.
        found: String,
        /// What is required.
        expected: &'static str,
    },
    /// A coded part of a file cannot be decoded.
    #[error("the {section} cannot be decoded; copy the file again, or bake it again")]
    Coded {
        /// The common section or the bundle.
        section: String,
    },
    /// A part is not laid out as bakes lay it out, so a decoder would not restore it. No data is lost: it can
    /// be stored raw.
    #[error(
        "the {section} is not written as this program does, so it cannot be coded; keep it raw, or bake it again"
    )]
    Uncodable {
        /// The common section or the bundle.
        section: String,
    },
    /// The file may be valid, but takes more memory than is allowed.
    #[error(
        "it may take {needed_bytes} bytes in memory while it is read, but {limit_bytes} are allowed; allow more, or stream the file"
    )]
    TooLarge {
        /// The file's length if that alone is too much, else what
        /// [`ShadowFile::read_within`](crate::ShadowFile::read_within) would hold at most.
        needed_bytes: u64,
        /// The memory that is allowed.
        limit_bytes: u64,
    },
    /// The quadtree of depths cannot be looked up in.
    #[error("the quadtree of depths of level {level} is not valid: {fault}; bake it again")]
    Depths {
        /// The level, 0 = the finest.
        level: u32,
        /// The fault in the quadtree.
        fault: DepthsError,
    },
}

/// Describes a file that is not one of this project's, guessed from its first eight bytes, and says what to
/// do.
fn instead(found: &[u8], expected: &str) -> String {
    let text = found.trim_ascii_start().to_ascii_lowercase();
    if text.starts_with(b"<!doc") || text.starts_with(b"<html") {
        return "it is a web page, such as a server sends in place of a file that it does not have; check the address".to_owned();
    }
    if text.starts_with(b"version ") {
        return "it is a Git LFS pointer to one; run `git lfs pull`".to_owned();
    }
    let found = found.escape_ascii();
    format!(
        "it begins with \"{found}\" instead of {expected}; give a file that `bake` has written, and copy it as binary"
    )
}

impl FormatError {
    /// Returns the variant's name. It is stable across versions and is used by the test vectors.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Magic { .. } => "Magic",
            Self::OtherKind { .. } => "OtherKind",
            Self::FutureVersion { .. } => "FutureVersion",
            Self::Truncated { .. } => "Truncated",
            Self::TrailingBytes { .. } => "TrailingBytes",
            Self::HeaderChecksum { .. } => "HeaderChecksum",
            Self::SectionChecksum { .. } => "SectionChecksum",
            Self::HeaderField { .. } => "HeaderField",
            Self::SectionBounds { .. } => "SectionBounds",
            Self::Bundle { .. } => "Bundle",
            Self::Coded { .. } => "Coded",
            Self::Uncodable { .. } => "Uncodable",
            Self::TooLarge { .. } => "TooLarge",
            Self::Depths { .. } => "Depths",
        }
    }

    /// Returns the name of the fault in the voxels, if that is where the fault is. It is stable across
    /// versions and is used by the test vectors.
    pub fn fault(&self) -> Option<&'static str> {
        match self {
            Self::Depths { fault, .. } => Some(fault.kind()),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn magic_error_names_kind_of_foreign_file() {
        for (found, words) in [
            (&b"<!DOCTYP"[..], "it is a web page"),
            (b"\n<html>\n", "it is a web page"),
            (b"version ", "git lfs pull"),
            (b"glTF\x02\0\0\0", "it begins with \"glTF\\x02"),
            (b"", "copy it as binary"),
        ] {
            let error = FormatError::Magic { found: found.to_vec(), expected: "\"ADUMBRA\\n\"" };
            assert!(error.to_string().contains(words), "{error}");
        }
    }
}
