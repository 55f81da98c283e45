//! What can be wrong with a page, or with pages taken together.

use super::{MAX_PAGES, MAX_SIDE, MIN_SIDE};

/// What is wrong with pages of words: what, where, and what to do about it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TextureError {
    /// The largest side asked for is out of range.
    #[error("a largest side of {max_side} pixels is not from {MIN_SIDE} to {MAX_SIDE}")]
    Side {
        /// The side given.
        max_side: u32,
    },
    /// The words do not fit.
    #[error(
        "{words} words need {pages} pages of this size, but at most {MAX_PAGES} pages and 2^32 words are written; raise --max-side, or bake at a lower --resolution"
    )]
    TooManyPages {
        /// Words, with those of the rest.
        words: u64,
        /// Pages that they need.
        pages: u64,
    },
    /// The file is not a PNG.
    #[error("it is {found}, not a PNG; give the PNG that `export` has written, not a conversion of it")]
    NotPng {
        /// What it looks like.
        found: String,
    },
    /// Colours of a table.
    #[error(
        "it is a palette PNG, whose pixels are numbers of colours and not the words; take the PNG that `export` has written, and switch off PNG optimisation and colour reduction on its way"
    )]
    Palette,
    /// Grey levels, with or without alpha.
    #[error(
        "it is a grey PNG, but the words need RGBA; take the PNG that `export` has written, and switch off colour conversion on its way"
    )]
    Grey,
    /// No alpha channel.
    #[error(
        "it is an RGB PNG without alpha, so each word's upper 8 bits are lost; take the PNG that `export` has written, and keep the alpha channel on its way"
    )]
    NoAlpha,
    /// More than 8 bits a channel.
    #[error(
        "it has 16 bits a channel, but the words need 8; take the PNG that `export` has written, and switch off conversion to 16 bits on its way"
    )]
    SixteenBits,
    /// Larger than a page may be.
    #[error(
        "it is {width} x {height} pixels, but a page has at most {MAX_SIDE} a side; give the PNG that `export` has written"
    )]
    TooLarge {
        /// Pixels a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// A PNG whose bytes do not decode.
    #[error("a damaged PNG: {what}; copy it again, or export it again")]
    Damaged {
        /// What the decoder found.
        what: String,
    },
    /// A page in memory whose bytes are not its pixels.
    #[error("a page of {width} x {height} pixels with {bytes} bytes; it must have four a pixel")]
    PageBytes {
        /// Pixels a row.
        width: u32,
        /// Rows.
        height: u32,
        /// Bytes given.
        bytes: usize,
    },
    /// No row begins with the signature's magic.
    #[error(
        "its {width} x {height} pixels hold no signature: cropped, resized, re-encoded with loss, or not written by adumbra; give the PNG that `export` has written, unchanged"
    )]
    NoSignature {
        /// Pixels a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// Another row than the last begins with the signature's magic.
    #[error(
        "its signature stands in row {row} and not in the last, {last}: cropped, flipped or extended; give the PNG that `export` has written, unchanged"
    )]
    SignatureMoved {
        /// Where it stands.
        row: u32,
        /// Where it should stand.
        last: u32,
    },
    /// The signature is damaged.
    #[error(
        "its signature is damaged (checksum {computed:#010x} instead of {stored:#010x}): cropped, resized or re-encoded with loss; give the PNG that `export` has written, unchanged"
    )]
    SignatureChecksum {
        /// As stored.
        stored: u32,
        /// As computed.
        computed: u32,
    },
    /// Written by a later program.
    #[error("version {version} of the pages, but this program reads version {supported}; update the program")]
    Version {
        /// The page's version.
        version: u32,
        /// The version that is read.
        supported: u32,
    },
    /// A field of the signature has a value that no export gives it.
    #[error("its signature's {field} is {value}, but must be {expected}; export it again")]
    SignatureField {
        /// The field's name.
        field: &'static str,
        /// The value found.
        value: u64,
        /// What is allowed.
        expected: String,
    },
    /// The picture has not the size that it was written with.
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
    /// Pixels have changed.
    #[error(
        "its pixels have changed (checksum {computed:#010x} instead of {stored:#010x}): converted through a lossy format, colour-managed or premultiplied by alpha; give the PNG that `export` has written, unchanged"
    )]
    PageChecksum {
        /// As stored.
        stored: u32,
        /// As computed.
        computed: u32,
    },
    /// No page was given.
    #[error("no page was given; give all of one export, page 0 first")]
    NoPages,
    /// A page of the export is absent.
    #[error(
        "page {page} of {pages} is missing; put all pages of one export in one folder, under the names that `export` gave them"
    )]
    MissingPage {
        /// Its number.
        page: u32,
        /// Pages in all.
        pages: u32,
    },
    /// A page stands in another's place.
    #[error(
        "it is page {found}, but stands in the place of page {expected}; give the pages the names that `export` gave them"
    )]
    MisplacedPage {
        /// Its number.
        found: u32,
        /// The number of the page that belongs there.
        expected: u32,
    },
    /// A page of another export.
    #[error(
        "page {page} is of another export than page 0; put all pages of one export in one folder, or export again"
    )]
    MixedExports {
        /// Its number.
        page: u32,
    },
    /// More pages than the export has.
    #[error("{given} pages were given, but the export has {pages}; give each once")]
    ExtraPages {
        /// Pages given.
        given: usize,
        /// Pages in all.
        pages: u32,
    },
    /// All pages are good, but not all of one whole.
    #[error("the pages together have the checksum {computed:#010x} instead of {stored:#010x}; export again")]
    StreamChecksum {
        /// As stored.
        stored: u32,
        /// As computed.
        computed: u32,
    },
}
