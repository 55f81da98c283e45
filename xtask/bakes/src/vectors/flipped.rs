//! Broken files with one flipped bit.

use super::Bytes;
use super::shadow_bytes::ShadowBytes;
use crate::broken::Broken;

/// A file whose bits can be flipped.
pub(super) trait Flip {
    /// Returns the bytes.
    fn bytes(&self) -> &[u8];

    /// Returns the file with a bit of a byte flipped, and correct checksums.
    fn flipped(&self, at: usize, bit: u32) -> Vec<u8>;

    /// Returns the first byte whose bits are flipped.
    fn first(&self) -> usize;
}

impl Flip for Bytes {
    fn bytes(&self) -> &[u8] {
        &self.0
    }

    fn flipped(&self, at: usize, bit: u32) -> Vec<u8> {
        self.clone().put(at, &[self.0[at] ^ 1 << bit]).sealed()
    }

    fn first(&self) -> usize {
        Self::HEADER_BYTES
    }
}

impl Flip for ShadowBytes {
    fn bytes(&self) -> &[u8] {
        &self.0
    }

    fn flipped(&self, at: usize, bit: u32) -> Vec<u8> {
        self.clone().put(at, &[self.0[at] ^ 1 << bit]).sealed()
    }

    fn first(&self) -> usize {
        self.common(0)
    }
}

/// Returns a broken file for each entry of `faults`: its name, its fault, and a name that the message must
/// contain. It is made from the first file of `valid` in which a flipped bit causes the fault. `fault_of`
/// reads a file and returns the fault in its voxels.
pub(super) fn flipped(
    error: &'static str,
    valid: &[impl Flip],
    fault_of: impl Fn(&[u8]) -> Option<&'static str>,
    faults: &[(&'static str, &'static str, &'static str)],
) -> Result<Vec<Broken>, String> {
    let broken = |&(name, fault, names)| {
        let bytes = valid.iter().find_map(|valid| with_bit_flipped(valid, |b| fault_of(b) == Some(fault)));
        let bytes = bytes.ok_or_else(|| format!("no bit flipped is {fault}"))?;
        Ok(Broken { name, error, fault: Some(fault), names, bytes })
    };
    faults.iter().map(broken).collect()
}

/// Returns the file with one bit of its sections flipped: the first bit for which `is_wanted` accepts the
/// file. `None` if there is no such bit.
fn with_bit_flipped(valid: &impl Flip, is_wanted: impl Fn(&[u8]) -> bool) -> Option<Vec<u8>> {
    let bits = (valid.first()..valid.bytes().len()).flat_map(|at| (0..8).map(move |bit| (at, bit)));
    bits.map(|(at, bit)| valid.flipped(at, bit)).find(|bytes| is_wanted(bytes))
}
