//! Structures that Rust writes and WGSL reads: declared once here, as both.
//!
//! Fields stand so that no padding is needed: Rust writes them one behind the other, and `tests/validate.rs` holds size and
//! offsets against naga's. "Relative" positions are world positions less the frame's anchor.

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
        /// World position that relative positions count from, usually the eye, rounded to floats; w = 0. No shader needs it: all that
        /// is relative was made so in doubles.
        pub anchor_world: [f32; 4],
        /// What that rounding left over; w = 0.
        pub anchor_rest: [f32; 4],
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
        /// Edge of a pixel in world units at view depth 0, and what a unit of view depth adds; mip levels of moments;
        /// least bias along the light, as a share of the layer's depth: a step of 16-bit depth, some units in the last place with 32 bits.
        pub pixel: [f32; 4],
    }
}

gpu_struct! {
    /// A hybrid-resolution shadow map, as look-ups take it.
    pub struct HybridParams {
        /// Where it lies; texels are those of the finest level.
        pub layer: MapLayer,
        /// As in [`MapParams`].
        pub bias: [f32; 4],
        /// Finest texels a side, merges, width of the filter in texels, 1 where finest depths are 16 bits.
        pub counts: [u32; 4],
        /// Depth of a plane's slope code 1, with [`crate::constants::HYBRID_SLOPE_BITS`] behind the point, in steps of 1 / [`crate::constants::HYBRID_ONE`] a texel; 0, 0, 0.
        pub slope: [i32; 4],
        /// Least bias along the light, a share of the layer's depth: a step of stored depth; 0, 0, 0.
        pub least_bias: [f32; 4],
    }
}

gpu_struct! {
    /// A pass that merges texels of one level of a hybrid map into the next coarser one.
    pub struct HybridLevel {
        /// Finest texels a side, the level made (1 the first), texels a side of it, merges in all.
        pub counts: [u32; 4],
        /// First word of the level before and of this one among the levels, words that four children take, 1 where finest depths are 16
        /// bits.
        pub places: [u32; 4],
        /// Slope as in [`HybridParams`]; twice the depth that a plane may lie behind its texels; 0, 0.
        pub plane: [i32; 4],
        /// Places that the map has room for; the word of a texel without a caster; 0, 0.
        pub room: [u32; 4],
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
    /// From relative positions to a grid of voxels, to better than 1e-5 voxels however large the grid. A position is cut into whole
    /// steps of about 8 voxels, whose part is exact in whole numbers, and what is left over; core/grid.wgsl puts them together.
    /// Fixed-point numbers count [`crate::constants::FIXED_ONE`] to a voxel, and wrap.
    pub struct GridTransform {
        /// The grid's x axis in the world, unit; w = what [`GridTransform::anchor_fixed`] leaves over along it, in voxels.
        pub axis_x: [f32; 4],
        /// The y axis, likewise.
        pub axis_y: [f32; 4],
        /// The z axis, likewise.
        pub axis_z: [f32; 4],
        /// What a step along the world's x adds to the grid position, fixed point; w = 0.
        pub step_x: [i32; 4],
        /// A step along y.
        pub step_y: [i32; 4],
        /// A step along z.
        pub step_z: [i32; 4],
        /// What [`GridTransform::step_x`] leaves over, in voxels; w = 0.
        pub rest_x: [f32; 4],
        /// Likewise.
        pub rest_y: [f32; 4],
        /// Likewise.
        pub rest_z: [f32; 4],
        /// Grid position of the anchor, fixed point; w = 0.
        pub anchor_fixed: [i32; 4],
        /// The same in voxels, rounded; w = 0.
        pub anchor_voxels: [f32; 4],
        /// Voxels a world unit; world units a step; its inverse; 0.
        pub scale: [f32; 4],
        /// Voxels along x, y, z; 0.
        pub size: [i32; 4],
    }
}

gpu_struct! {
    /// A baked light-aligned grid.
    pub struct VoxelParams {
        /// Where it lies.
        pub grid: GridTransform,
        /// Root cubes along x, y, z; level of the roots.
        pub top_dims: [u32; 4],
        /// Index of the first word of nodes (of units, where they are packed) and of slabs, width of the filter in texels, 1 where
        /// a block's taps share a layer.
        pub places: [u32; 4],
        /// Constant, slope and normal offset in texels; 0.
        pub bias: [f32; 4],
    }
}

gpu_struct! {
    /// A baked light-aligned hierarchy.
    pub struct HierarchyParams {
        /// Where it lies: `top_dims` as for a graph, but z = 1; first word of wide entries and of code in `places`.
        pub voxel: VoxelParams,
        /// Texels that the sun's cone widens by a voxel of depth; most texels of a penumbra's radius; 0; 0.
        pub sun: [f32; 4],
    }
}

gpu_struct! {
    /// A baked world-aligned tree.
    pub struct CubesParams {
        /// Where its cube lies; the axes are the world's.
        pub grid: GridTransform,
        /// Unit vector towards the sun of the bake; w = 0.
        pub towards_sun: [f32; 4],
        /// Constant, slope and normal offset in cells; 0.
        pub bias: [f32; 4],
        /// Levels; level of the cells outside all regions; voxels from the kernel's middle to its end; weights of taps at
        /// distances 0, 1, 2 along an axis, four bits each.
        pub kernel: [u32; 4],
        /// 1 where taps behind the receiver's plane count too; 0, 0, 0.
        pub taps: [u32; 4],
    }
}

gpu_struct! {
    /// How coarse a tree is where, in plan: `adumbra::query::PlanLevels`.
    pub struct CubesPlan {
        /// Edges along x, along z: at most twice [`crate::constants::MAX_PLAN_REGIONS`]; 0, 0.
        pub counts: [u32; 4],
        /// Voxels, ascending, four an element.
        pub edges_x: Array<[i32; 4], 8>,
        /// Likewise.
        pub edges_z: Array<[i32; 4], 8>,
        /// A level a rectangle, x fastest, four bits each from the lowest up, eight a word.
        pub levels: Array<[u32; 4], 35>,
    }
}

gpu_struct! {
    /// The uniform of a look-up in a tree.
    pub struct CubesUniform {
        /// The tree.
        pub params: CubesParams,
        /// Its regions.
        pub plan: CubesPlan,
    }
}

gpu_struct! {
    /// A receiver in fixed point, for the pass that answers lists of them: `adumbra::query::FixedReceiver`.
    pub struct VoxelQuery {
        /// Grid position; w = 0.
        pub p_fixed: [i32; 4],
        /// Gradient along x and y; 0, 0.
        pub gradient: [i32; 4],
    }
}

gpu_struct! {
    /// The same for a tree: `adumbra::query::TreeReceiver`.
    pub struct CubesQuery {
        /// Position; w = level of the cells.
        pub p_fixed: [i32; 4],
        /// Normal; w = height.
        pub normal: [i32; 4],
    }
}

gpu_struct! {
    /// A point to answer, in the pass that answers lists of points.
    pub struct PointQuery {
        /// Relative position; w = view depth.
        pub p_relative: [f32; 4],
        /// Unit normal, or zero; w = 0.
        pub normal: [f32; 4],
        /// Pixel at which it appears, x and y, for what differs from pixel to pixel; 0, 0.
        pub pixel: [u32; 4],
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
    /// Ambient occlusion on the screen. "Texels" are those of the picture that holds it, which may be half the size of the frame's; view
    /// space is x right, y up, z along [`Frame::forward`], world units, from the eye.
    pub struct OcclusionParams {
        /// Width and height in texels; pixels of the frame a texel along a side (1 or 2); the same of the normals.
        pub size: [u32; 4],
        /// Taps; steps of a march; what is added to a texel's place in the tile of noise; parts of the taps that are left at a distance, of 4.
        pub counts: [u32; 4],
        /// Radius in world units; texels that it may take on the screen; edge of a texel in world units at view depth 0, and what a
        /// unit of view depth adds.
        pub region: [f32; 4],
        /// Of a texel's centre: `ndc = xy · texel + zw`.
        pub ndc_from_texel: [f32; 4],
        /// Half of what is seen along x and y at view depth 0, and what a unit of view depth adds.
        pub half_view: [f32; 4],
        /// As in [`Frame`].
        pub depth_to_z: [f32; 4],
        /// Unit axes of view space in the world; w = 0.
        pub right: [f32; 4],
        /// Likewise.
        pub up: [f32; 4],
        /// Likewise.
        pub forward: [f32; 4],
        /// The estimator's own parameters; its file says which.
        pub shape: [f32; 4],
        /// More of them.
        pub shape_more: [f32; 4],
    }
}

gpu_struct! {
    /// The random texture of ambient occlusion: [`crate::constants::OCCLUSION_MAX_TAPS`] taps for each of the tile's 16 places; the
    /// estimator's file says what they are.
    pub struct OcclusionTaps {
        /// By place, then by tap.
        pub taps: Array<[f32; 4], 1024>,
    }
}

gpu_struct! {
    /// A pass that filters ambient visibility.
    pub struct OcclusionFilterParams {
        /// Width and height in texels; neighbours on either side; axis of a line (0 along x, 1 along y).
        pub counts: [u32; 4],
        /// 1 / (√2 sigma of view depth) per world unit; 1 where the filter follows planes in perspective, and where it does in an
        /// orthographic picture; difference of visibility that the edge test passes over, negative without it.
        pub shape: [f32; 4],
        /// 1 / (2 sigma²) of the distance in texels; 0; 0; 0.
        pub near: [f32; 4],
    }
}

gpu_struct! {
    /// Where the frame before saw what this one sees, in view space as in [`OcclusionParams`].
    pub struct OcclusionHistoryParams {
        /// `x = xyz · p + w` of a point in the frame before.
        pub before_x: [f32; 4],
        /// Its y, likewise.
        pub before_y: [f32; 4],
        /// Its view depth, likewise.
        pub before_z: [f32; 4],
        /// The frame before's own, as in [`OcclusionParams`].
        pub ndc_from_texel: [f32; 4],
        /// Likewise.
        pub half_view: [f32; 4],
        /// Likewise.
        pub right: [f32; 4],
        /// Likewise.
        pub up: [f32; 4],
        /// Likewise.
        pub forward: [f32; 4],
        /// How far off a point's plane its own surface may have been, in world units at view depth 0, and what a unit of view depth
        /// adds; most frames that count; 1 where there was a frame before.
        pub limits: [f32; 4],
    }
}

gpu_struct! {
    /// What the composite makes of the G-buffer and the shadow factor. Colours are linear.
    pub struct CompositeParams {
        /// Sunlight, linear red, green and blue.
        pub sun_color: [f32; 4],
        /// Light from above, linear; also the sky behind the scene.
        pub sky_color: [f32; 4],
        /// Light from below, linear.
        pub ground_color: [f32; 4],
    }
}

gpu_struct! {
    /// What of a frame is shown.
    pub struct LayerParams {
        /// Width and height shown, pixels of the frame a pixel shown along a side, and which layer (`LAYER_...`).
        pub shape: [u32; 4],
        /// Colours of the palette that count; 0; 0; 0.
        pub counts: [u32; 4],
        /// Linear colours of what a tint stands for, by number.
        pub palette: Array<[f32; 4], 16>,
    }
}

gpu_struct! {
    /// One or two pictures on a window.
    pub struct PresentParams {
        /// How (`PRESENT_...`), the divider's column, 1 where the window encodes what it is given, 0.
        pub shape: [u32; 4],
        /// Colour where the second is darker; w: how much a difference in brightness counts.
        pub too_dark: [f32; 4],
        /// Colour where the second is brighter; w = 0.
        pub too_bright: [f32; 4],
    }
}

gpu_struct! {
    /// What a triangle is made of.
    pub struct MaterialParams {
        /// Linear colour and alpha factor, 0 to 1.
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
    HybridParams::INFO,
    HybridLevel::INFO,
    MomentBlurParams::INFO,
    GridTransform::INFO,
    VoxelParams::INFO,
    HierarchyParams::INFO,
    CubesParams::INFO,
    CubesPlan::INFO,
    CubesUniform::INFO,
    VoxelQuery::INFO,
    CubesQuery::INFO,
    PointQuery::INFO,
    BlurParams::INFO,
    OcclusionParams::INFO,
    OcclusionTaps::INFO,
    OcclusionFilterParams::INFO,
    OcclusionHistoryParams::INFO,
    CompositeParams::INFO,
    LayerParams::INFO,
    PresentParams::INFO,
    MaterialParams::INFO,
];
