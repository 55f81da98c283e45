//! Uploads an arbitrary depth image as the shadow map that a hybrid map is built from.

use wgpu::TextureView;

use super::twin::DepthImage;
use crate::depth_image::DepthImagePass;
use crate::error::{RenderError, Result};
use crate::gpu::Gpu;
use crate::maps::DepthPrecision;
use crate::maps::depth_pass::DepthPassOptions;
use crate::maps::textures::DepthTextures;
use crate::readback::read_depth;

/// A square texture of light depth on the GPU: 0 nearest the sun, 1 farthest or no caster.
pub struct StartDepth {
    depth: DepthTextures,
    pass: DepthImagePass,
}

impl StartDepth {
    /// Creates a texture of `side` texels per side, a power of two, for images of that size. Pass its
    /// [`StartDepth::view`] to [`HybridMapBuilder::new`](super::build::HybridMapBuilder::new).
    ///
    /// # Errors
    /// Returns [`RenderError::TooLarge`] if the device does not support this side, and any other error that
    /// it reports.
    pub fn new(gpu: &Gpu, side: u32, precision: DepthPrecision) -> Result<Self> {
        let options = DepthPassOptions { format: precision.format(), normals: false };
        let depth = DepthTextures::new(gpu, "hybrid::start", side, 1, options)?;
        let pass = DepthImagePass::new(gpu, options.format);
        gpu.check()?;
        Ok(Self { depth, pass })
    }

    /// Replaces the whole texture. 32-bit depths are kept bit for bit; 16-bit ones round to the nearest of
    /// 65,536 values.
    ///
    /// # Errors
    /// Returns [`RenderError::DepthImage`] if the image has another size, and any error that the device
    /// reports.
    pub fn write(&self, gpu: &Gpu, image: &DepthImage) -> Result<()> {
        let side = self.depth.all.texture.width();
        if image.side() as u64 != u64::from(side) {
            let what = format!("{0} x {0} texels for a map of {side} x {side}", image.side());
            return Err(RenderError::DepthImage { what });
        }
        self.pass.draw(gpu, self.depth.target(0).depth, [side; 2], image.texels())
    }

    /// The texture as a `texture_depth_2d_array` of one layer.
    pub fn view(&self) -> &TextureView {
        &self.depth.all.view
    }

    /// Reads the texture back. Waits for the device.
    ///
    /// # Errors
    /// Returns any error that the device reports.
    pub fn read(&self, gpu: &Gpu) -> Result<DepthImage> {
        let side = self.depth.all.texture.width() as usize;
        DepthImage::new(side, read_depth(gpu, &self.depth.all.texture, 0)?)
    }
}
