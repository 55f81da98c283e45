//! Changes one parameter of a technique and writes the result as the shortest text.

use super::{SpecReader, SpecText};
use crate::error::Result;

/// Returns a technique with one parameter changed, as read by `read`. Parameters that no longer apply or have
/// their default value are omitted.
///
/// # Errors
/// Returns the errors of `read`, and [`crate::RenderError::Technique`] for a parameter that is never read.
pub(crate) fn changed(
    spec: &SpecText,
    key: &str,
    value: &str,
    read: impl Fn(&mut SpecReader<'_>) -> Result<()>,
) -> Result<SpecText> {
    let asked = spec.with(key, Some(value));
    let mut reader = asked.reader();
    read(&mut reader)?;
    let is_said = |k: &&str| reader.asked().iter().any(|p| p.key == *k && !p.is_default());
    if reader.asked().iter().all(|p| p.key != key) {
        // There is no such parameter. The reader's error lists those that exist.
        reader.finish()?;
        return Ok(asked);
    }
    let dropped: Vec<&str> = asked.keys().filter(|k| !is_said(k)).collect();
    Ok(dropped.into_iter().fold(asked.clone(), |spec, key| spec.with(key, None)))
}
