//! Filters of light-aligned files.

/// The filter of a light-aligned file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum VoxelFilter {
    /// The mean over K × K texels, with K one of [`adumbra::query::FILTER_WIDTHS`].
    Taps(u32),
    /// Penumbrae of a sun. Only for files in the layout `depths`.
    Soft {
        /// Full angle of the sun, in [`adumbra::gpu::PENUMBRA_ANGLES_DEGREES`].
        angle_degrees: f64,
        /// Largest radius of a penumbra, in [`adumbra::gpu::PENUMBRA_RADII_TEXELS`].
        max_radius_texels: f64,
    },
}
