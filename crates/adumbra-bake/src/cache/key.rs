//! The name of an entry.

use std::fmt;
use std::str::FromStr;

use blake3::Hash;

/// Names an entry: a BLAKE3 hash.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CacheKey([u8; 32]);

impl CacheKey {
    /// Wraps a hash of everything that the entry depends on.
    pub(crate) fn new(hash: [u8; 32]) -> Self {
        Self(hash)
    }

    /// Returns the bytes.
    pub fn as_bytes(&self) -> &[u8; 32] {
        &self.0
    }
}

impl FromStr for CacheKey {
    type Err = ();

    /// Reads 64 lower-case hexadecimal digits.
    fn from_str(text: &str) -> Result<Self, ()> {
        let hash = Hash::from_hex(text).map_err(drop)?;
        // `from_hex` reads upper-case digits too.
        if *hash.to_hex() == *text { Ok(Self(hash.into())) } else { Err(()) }
    }
}

impl fmt::Display for CacheKey {
    /// Writes 64 hexadecimal digits.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}
