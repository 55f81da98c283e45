//! Errors found in a page, or in a set of pages.

use crate::tree::page_limits::{MAX_PAGES, MAX_SIDE, MIN_SIDE};

/// A fault of pages of words: what is wrong, where, and what to do about it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TextureError {
    /// The requested largest side is out of range.
    #[error("the largest side is {max_side} pixels, but must be from {MIN_SIDE} to {MAX_SIDE}")]
    Side {
        /// The side given.
        max_side: u32,
    },
    /// The words do not fit.
    #[error(
        "{words} words need {pages} pages of this size, but an export has at most {MAX_PAGES} pages and 2^32 words; allow larger pages, or bake at a lower resolution"
    )]
    TooManyPages {
        /// Number of words, including those of `rest`.
        words: u64,
        /// Number of pages that they need.
        pages: u64,
    },
    /// The file is not a PNG.
    #[error("it is {found}, not a PNG; give the PNG that `export` has written, not a conversion of it")]
    NotPng {
        /// The kind of file it appears to be.
        found: String,
    },
    /// The PNG has a palette.
    #[error(
        "it is a palette PNG, whose pixels are palette indices and not the words; give the PNG that `export` has written, and switch off PNG optimisation and colour reduction in the tools that it passes through"
    )]
    Palette,
    /// The PNG is greyscale, with or without alpha.
    #[error(
        "it is a greyscale PNG, but the words need RGBA; give the PNG that `export` has written, and switch off colour conversion in the tools that it passes through"
    )]
    Grey,
    /// The PNG has no alpha channel.
    #[error(
        "it is an RGB PNG without alpha, so each word's upper 8 bits are lost; give the PNG that `export` has written, and keep the alpha channel in the tools that it passes through"
    )]
    NoAlpha,
    /// The PNG has more than 8 bits per channel.
    #[error(
        "it has 16 bits per channel, but the words need 8; give the PNG that `export` has written, and switch off conversion to 16 bits in the tools that it passes through"
    )]
    SixteenBits,
    /// The PNG is larger than a page may be.
    #[error(
        "it is {width} x {height} pixels, but a page has at most {MAX_SIDE} pixels per side; give the PNG that `export` has written"
    )]
    TooLarge {
        /// Pixels per row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// A PNG whose bytes do not decode.
    #[error("a damaged PNG: {what}; copy it again, or export it again")]
    Damaged {
        /// The error of the decoder.
        what: String,
    },
    /// A page in memory whose byte count does not match its size in pixels.
    #[error("a page of {width} x {height} pixels with {bytes} bytes; it must have four bytes per pixel")]
    PageBytes {
        /// Pixels per row.
        width: u32,
        /// Rows.
        height: u32,
        /// Number of bytes given.
        bytes: usize,
    },
    /// No row begins with the magic of the signature.
    #[error(
        "its {width} x {height} pixels hold no signature: cropped, resized, re-encoded with loss, or not written by adumbra; give the PNG that `export` has written, unchanged"
    )]
    NoSignature {
        /// Pixels per row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// A row other than the last begins with the magic of the signature.
    #[error(
        "its signature is in row {row} and not in the last row, {last}: cropped, flipped or extended; give the PNG that `export` has written, unchanged"
    )]
    SignatureMoved {
        /// The row where it was found.
        row: u32,
        /// The row where it should be.
        last: u32,
    },
    /// The signature is damaged.
    #[error(
        "its signature is damaged (checksum {computed:#010x} instead of {stored:#010x}): cropped, resized or re-encoded with loss; give the PNG that `export` has written, unchanged"
    )]
    SignatureChecksum {
        /// The stored checksum.
        stored: u32,
        /// The computed checksum.
        computed: u32,
    },
    /// The page was written by a later version of the program.
    #[error("page version {version}, but this program reads version {supported}; update the program")]
    Version {
        /// The version of the page.
        version: u32,
        /// The supported version.
        supported: u32,
    },
    /// A field of the signature has a value that no export writes.
    #[error("its signature's {field} is {value}, but must be {expected}; export it again")]
    SignatureField {
        /// The name of the field.
        field: &'static str,
        /// The value found.
        value: u64,
        /// The values allowed.
        expected: String,
    },
    /// The picture does not have the size that it was written with.
    #[error(
        "it is {} x {} pixels, but was written with {} x {}: cropped or resized; give the PNG that `export` has written, unchanged",
        found[0], found[1], expected[0], expected[1]
    )]
    WrongSize {
        /// Width and height of the picture.
        found: [u32; 2],
        /// Width and height in the signature.
        expected: [u32; 2],
    },
    /// The pixels have changed.
    #[error(
        "its pixels have changed (checksum {computed:#010x} instead of {stored:#010x}): converted through a lossy format, colour-managed or premultiplied by alpha; give the PNG that `export` has written, unchanged"
    )]
    PageChecksum {
        /// The stored checksum.
        stored: u32,
        /// The computed checksum.
        computed: u32,
    },
    /// No page was given.
    #[error("no page was given; give all pages of one export, page 0 first")]
    NoPages,
    /// A page of the export is missing.
    #[error(
        "page {page} of {pages} is missing; put all pages of one export in one folder, under the names that `export` gave them"
    )]
    MissingPage {
        /// The number of the page.
        page: u32,
        /// Number of pages of the export.
        pages: u32,
    },
    /// A page is in the position of another one.
    #[error(
        "it is page {found}, but page {expected} is expected here; give the pages the names that `export` gave them"
    )]
    MisplacedPage {
        /// The number of the page.
        found: u32,
        /// The number of the page that belongs there.
        expected: u32,
    },
    /// A page belongs to another export.
    #[error(
        "page {page} is from a different export than page 0; put all pages of one export in one folder, or export again"
    )]
    MixedExports {
        /// The number of the page.
        page: u32,
    },
    /// More pages were given than the export has.
    #[error("{given} pages were given, but the export has {pages}; give each page once")]
    ExtraPages {
        /// Number of pages given.
        given: usize,
        /// Number of pages of the export.
        pages: u32,
    },
    /// Each page is valid, but together they are not one export.
    #[error("the pages together have the checksum {computed:#010x} instead of {stored:#010x}; export again")]
    StreamChecksum {
        /// The stored checksum.
        stored: u32,
        /// The computed checksum.
        computed: u32,
    },
}
