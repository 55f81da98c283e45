//! Reads the settings of a blur and the technique that it blurs from text, and checks that this technique can be
//! blurred.

use crate::error::Result;
use crate::screen_blur::{BlurName, BlurSettings};
use crate::technique::{SpecReader, TechniqueSpec};

impl BlurSettings {
    /// Reads `samples`, `sigma`, `passes`, `weights`, `pairs` and `half`, as well as `radius` for `blur-dilate` and
    /// `tolerance` for `blur-bilateral`. Also reads the technique to blur, `base`, with `/` between its parameters
    /// (`base=pcf/filter=3`).
    ///
    /// # Errors
    /// Returns [`crate::RenderError::Technique`] for invalid values or combinations, and for a technique that cannot be
    /// blurred.
    pub fn read(spec: &TechniqueSpec) -> Result<(Self, TechniqueSpec)> {
        spec.read(|reader| read_blur(reader, spec.blur().unwrap_or(BlurName::Plain)))
    }
}

/// Reads a blur with [`BlurSettings::from_reader`] and checks that its base can be blurred.
///
/// # Errors
/// Returns the errors of [`BlurSettings::read`].
pub(super) fn read_blur(
    reader: &mut SpecReader<'_>,
    name: BlurName,
) -> Result<(BlurSettings, TechniqueSpec)> {
    let (settings, base) = BlurSettings::from_reader(reader, name)?;
    if base.entry().is_some_and(|entry| !entry.can_be_blurred()) {
        return Err(reader.spec().wrong(format!("base: {} cannot be blurred", base.name())));
    }
    Ok((settings, base))
}
