//! Arrays that Python has written.

use std::path::Path;

/// Reads little-endian float64 triples.
pub(crate) fn triples(path: &Path) -> std::io::Result<Vec<[f64; 3]>> {
    let bytes = std::fs::read(path)?;
    let triples = bytes.as_chunks::<8>().0.as_chunks::<3>().0.iter();
    Ok(triples.map(|triple| triple.map(f64::from_le_bytes)).collect())
}
