//! Broken files of which one bit is flipped.

use super::Bytes;
use crate::broken::Broken;

/// Returns a broken file per entry of `faults`, which has its name, its fault and what the message names. Each is the
/// first file of `valid` in which a flipped bit causes the fault. `fault_of` returns the fault in the voxels that
/// reading a file gives.
pub(super) fn flipped(
    error: &'static str,
    valid: &[Bytes],
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

/// Returns the file with one bit of its sections flipped, the first with which it is the one that is wanted. `None` if
/// there is no such bit.
fn with_bit_flipped(valid: &Bytes, is_wanted: impl Fn(&[u8]) -> bool) -> Option<Vec<u8>> {
    let bits = (Bytes::HEADER_BYTES..valid.0.len()).flat_map(|at| (0..8).map(move |bit| (at, bit)));
    bits.map(|(at, bit)| valid.clone().put(at, &[valid.0[at] ^ 1 << bit]).sealed())
        .find(|bytes| is_wanted(bytes))
}
