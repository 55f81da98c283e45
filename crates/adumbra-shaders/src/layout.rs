//! Structures that Rust writes and WGSL reads: declared once here, as both.
//!
//! Fields stand so that no padding is needed: Rust writes them one behind the other, and `tests/validate.rs` holds size and
//! offsets against naga's. "Relative" positions are world positions less [`Frame::anchor_world`].

mod kinds;

use kinds::gpu_struct;
pub use kinds::{Array, GpuType};

gpu_struct! {
    /// A camera's frame, for every pass that draws or reads the scene.
    ///
    /// Depth convention of cameras: reversed, 1 at the near plane, 0 at infinity (perspective) or at the far plane
    /// (orthographic); 0 is also "nothing there". View depth z, along [`Frame::forward`], from a stored depth d:
    /// `z = (a + b·d) / (c + e·d)` with `depth_to_z = (a, b, c, e)`.
    ///
    /// The point behind pixel (x, y) at view depth z, with `ndc` from -1 to 1, y up:
    /// `p_relative = origin + ndc.x·origin_x + ndc.y·origin_y + z·(ray + ndc.x·ray_x + ndc.y·ray_y)`.
    pub struct Frame {
        /// Clip from relative position.
        pub clip_from_relative: [[f32; 4]; 4],
        /// Of all rays; zero for a perspective camera whose anchor is its eye.
        pub origin: [f32; 4],
        /// Of a ray, a half picture to the right; zero for perspective.
        pub origin_x: [f32; 4],
        /// Of a ray, a half picture up; zero for perspective.
        pub origin_y: [f32; 4],
        /// Direction of the middle ray: forward.
        pub ray: [f32; 4],
        /// What a half picture to the right adds to a ray's direction; zero for orthographic.
        pub ray_x: [f32; 4],
        /// What a half picture up adds; zero for orthographic.
        pub ray_y: [f32; 4],
        /// a, b, c, e of the depth convention above.
        pub depth_to_z: [f32; 4],
        /// World position that relative positions count from, usually the eye; w = 0.
        pub anchor_world: [f32; 4],
        /// Unit vector towards the sun; w = 0.
        pub towards_sun: [f32; 4],
        /// Unit vector that view depth counts along; w = 0.
        pub forward: [f32; 4],
        /// Width and height in pixels, number of the frame, 0.
        pub size: [u32; 4],
    }
}

gpu_struct! {
    /// One layer of a shadow map. Depth convention of the light: linear, 0 near the sun, 1 far.
    pub struct MapLayer {
        /// `u = xyz · p_relative + w`, 0…1 from left to right.
        pub u_from_relative: [f32; 4],
        /// `v = xyz · p_relative + w`, 0…1 from top to bottom.
        pub v_from_relative: [f32; 4],
        /// `depth = xyz · p_relative + w`, 0…1.
        pub depth_from_relative: [f32; 4],
        /// Edge of a texel in world units; world units from depth 0 to 1; view depth where the layer ends; where its blend into
        /// the next begins.
        pub scale: [f32; 4],
    }
}

gpu_struct! {
    /// A shadow map of up to [`crate::constants::MAX_LAYERS`] layers, and how it is filtered.
    pub struct MapParams {
        /// The layers, nearest to the camera first.
        pub layers: Array<MapLayer, 8>,
        /// Constant, slope and normal offset in texels (see `adumbra::settings::Bias`), and the factor that the filter's
        /// width puts on them.
        pub bias: [f32; 4],
        /// Layers in use, texels a side, width of the filter in texels, number of taps.
        pub counts: [u32; 4],
        /// View depth where shadows begin to fade to lit, and where they are gone; tangent of half the sun's angle; largest
        /// filter radius in texels.
        pub reach: [f32; 4],
        /// Least standard deviation of depth in texels, share of the tail cut off, positive and negative exponent.
        pub moments: [f32; 4],
        /// Edge of a pixel in world units at view depth 0, and what a unit of view depth adds; mip levels of moments; 0.
        pub pixel: [f32; 4],
    }
}

gpu_struct! {
    /// A pass that blurs moments of one layer.
    pub struct MomentBlurParams {
        /// Layer of the depth map, texels a side, taps beside the middle one on either side, 0.
        pub counts: [u32; 4],
        /// Positive and negative exponent; 0, 0.
        pub exponents: [f32; 4],
        /// Weights of the middle tap and those beside it, 4 by 4; they and their mirror images sum to one.
        pub weights: Array<[f32; 4], 4>,
    }
}

gpu_struct! {
    /// A baked light-aligned grid. Fixed-point numbers count [`crate::constants::FIXED_ONE`] to a voxel.
    pub struct VoxelParams {
        /// First row of grid from relative, in voxels; w = what [`VoxelParams::anchor_fixed`] leaves over, in voxels.
        pub grid_x_from_relative: [f32; 4],
        /// Second row.
        pub grid_y_from_relative: [f32; 4],
        /// Third row.
        pub grid_z_from_relative: [f32; 4],
        /// Grid position of the anchor, fixed point; w = 0.
        pub anchor_fixed: [i32; 4],
        /// Voxels along x, y, z; level of the roots.
        pub size: [i32; 4],
        /// Root cubes along x, y, z; width of the filter in texels.
        pub top_dims: [u32; 4],
        /// Index of the first word of nodes and of slabs, log2 of the words in a binding, 0.
        pub places: [u32; 4],
        /// Constant, slope and normal offset in texels; 0.
        pub bias: [f32; 4],
    }
}

gpu_struct! {
    /// A point to answer, in the pass that answers lists of points.
    pub struct PointQuery {
        /// Relative position; w = view depth.
        pub p_relative: [f32; 4],
        /// Unit normal, or zero; w = 0.
        pub normal: [f32; 4],
    }
}

gpu_struct! {
    /// A screen-space blur of the shadow factor. "Texels" are those of the picture that is blurred, which may be half the size of the
    /// frame's.
    pub struct BlurParams {
        /// Neighbours on either side; pixels of the frame a texel (1 or 2) along a side; axis of a line (0 along x, 1 along y);
        /// radius of the dilation in texels.
        pub counts: [u32; 4],
        /// Width and height in texels, width and height of the frame.
        pub size: [u32; 4],
        /// Sigma in texels; how far off a pixel's plane its surface may lie, in pixels; 0; 0.
        pub shape: [f32; 4],
        /// Pairs on either side, 0, 0, 0.
        pub pairs: [u32; 4],
        /// By distance i: weight of the texel i away, all of a line adding to 1; offset in texels and weight of pair i; 0.
        pub taps: Array<[f32; 4], 33>,
    }
}

gpu_struct! {
    /// What the composite makes of the G-buffer and the shadow factor. Colours are linear.
    pub struct CompositeParams {
        /// Sunlight.
        pub sun_color: [f32; 4],
        /// Light from above; also the sky behind the scene.
        pub sky_color: [f32; 4],
        /// Light from below.
        pub ground_color: [f32; 4],
    }
}

gpu_struct! {
    /// What a triangle is made of.
    pub struct MaterialParams {
        /// Linear colour and alpha factor.
        pub base_color: [f32; 4],
        /// Alpha at or above x is opaque; y = 1 where the texture is sampled nearest; 0; 0.
        pub alpha: [f32; 4],
    }
}

/// Every structure's WGSL declaration.
pub fn declarations() -> String {
    STRUCTS.iter().map(|s| (s.declare)()).collect()
}

/// A structure, as the test against naga sees it.
pub struct StructInfo {
    /// Its name in WGSL.
    pub name: &'static str,
    /// Bytes that Rust writes.
    pub size: usize,
    /// Each field's name and where Rust writes it.
    pub fields: fn() -> Vec<(&'static str, usize)>,
    /// Its WGSL text.
    pub declare: fn() -> String,
}

/// All structures, those that others hold first.
pub const STRUCTS: &[StructInfo] = &[
    Frame::INFO,
    MapLayer::INFO,
    MapParams::INFO,
    MomentBlurParams::INFO,
    VoxelParams::INFO,
    PointQuery::INFO,
    BlurParams::INFO,
    CompositeParams::INFO,
    MaterialParams::INFO,
];
