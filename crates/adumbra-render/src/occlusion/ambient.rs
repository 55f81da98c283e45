//! The source of a frame's ambient visibility: screen-space passes, or a given picture such as ray-traced
//! truth.

use super::passes::OcclusionPasses;
use crate::error::{RenderError, Result};
use crate::frame::Target;
use crate::gpu::Gpu;
use crate::readback::read_floats;

/// Ambient visibility of frames, 1 = unoccluded.
pub enum AmbientSource {
    /// Estimated in screen space, in every frame.
    Estimated(Box<OcclusionPasses>),
    /// A given picture, for frames of one size.
    Given(GivenAmbient),
}

impl From<OcclusionPasses> for AmbientSource {
    fn from(passes: OcclusionPasses) -> Self {
        Self::Estimated(Box::new(passes))
    }
}

impl From<GivenAmbient> for AmbientSource {
    fn from(given: GivenAmbient) -> Self {
        Self::Given(given)
    }
}

impl AmbientSource {
    /// Discards the history of previous frames. A given picture stays.
    pub fn forget(&mut self) {
        if let Self::Estimated(passes) = self {
            passes.forget();
        }
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        match self {
            Self::Estimated(passes) => passes.bytes(),
            Self::Given(given) => 4 * u64::from(given.size[0]) * u64::from(given.size[1]),
        }
    }

    /// Reads back the ambient visibility, row 0 at the top. 1 = unoccluded, and also where there is no
    /// surface. Passes return the last frame's, which is empty before the first frame.
    ///
    /// # Errors
    /// Returns any error that the device reports.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<f32>> {
        match self {
            Self::Estimated(passes) => passes.read(gpu),
            Self::Given(given) => read_floats(gpu, &given.target.texture, 0, 0),
        }
    }

    /// The texture whose first channel the composite reads. `None` before the first frame.
    pub(crate) fn target(&self) -> Option<&Target> {
        match self {
            Self::Estimated(passes) => passes.result(),
            Self::Given(given) => Some(&given.target),
        }
    }

    /// Checks that this source supports frames of `size`.
    pub(crate) fn check(&self, size: [u32; 2]) -> Result<()> {
        match self {
            Self::Given(given) if given.size != size => Err(RenderError::Ambient {
                reason: format!("it was made for {:?} pixels, not {size:?}", given.size),
            }),
            _ => Ok(()),
        }
    }
}

/// One visibility per pixel, for frames of its own size only.
pub struct GivenAmbient {
    size: [u32; 2],
    target: Target,
}

impl GivenAmbient {
    /// Uploads `visibility`, row 0 at the top; 1 = unoccluded.
    ///
    /// # Errors
    /// Returns [`RenderError::Ambient`] if the length of `visibility` is not the number of pixels, and any
    /// error that the device reports.
    pub fn new(gpu: &Gpu, size: [u32; 2], visibility: &[f32]) -> Result<Self> {
        let [width, height] = size;
        if visibility.is_empty() || visibility.len() as u64 != u64::from(width) * u64::from(height) {
            let reason = format!("{} visibilities for {width} x {height} pixels", visibility.len());
            return Err(RenderError::Ambient { reason });
        }
        let texture = gpu.float_texture("given::ambient", size, visibility);
        gpu.check()?;
        Ok(Self { size, target: Target { view: texture.create_view(&Default::default()), texture } })
    }
}
