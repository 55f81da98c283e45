//! Numbers that Rust and WGSL share, each declared here once.

macro_rules! shared {
    ($($(#[$doc:meta])* $name:ident: $kind:ident = $value:expr;)*) => {
        $($(#[$doc])* pub const $name: $kind = $value;)*

        /// Every constant as WGSL.
        pub fn declarations() -> String {
            let mut text = String::new();
            $(text += &format!("const {}: {} = {:?};\n", stringify!($name), stringify!($kind), $name);)*
            let points: Vec<_> = POISSON_DISC.iter().map(|[x, y]| format!("vec2f({x:?}, {y:?})")).collect();
            text += &format!("const POISSON_DISC = array<vec2f, {}>({});\n", points.len(), points.join(", "));
            text + "\n"
        }
    };
}

shared! {
    /// Threads of a workgroup over pixels or texels, along each side.
    PIXEL_GROUP: u32 = 8;
    /// Threads of a workgroup over a list.
    LIST_GROUP: u32 = 64;
    /// `LayerParams::shape.w`: the picture.
    LAYER_COLOR: u32 = 0;
    /// One value a pixel, as grey.
    LAYER_VALUE: u32 = 1;
    /// Distance along the view.
    LAYER_DEPTH: u32 = 2;
    /// World normals.
    LAYER_NORMAL: u32 = 3;
    /// The picture, in the colours of a value a pixel.
    LAYER_TINT: u32 = 4;
    /// Most colours of a tint; the length of `LayerParams::palette`.
    MAX_TINTS: u32 = 16;
    /// `PresentParams::shape.x`: the first picture.
    PRESENT_FIRST: u32 = 0;
    /// Two pictures beside a divider.
    PRESENT_SPLIT: u32 = 1;
    /// Where the second differs from the first.
    PRESENT_DIFFERENCE: u32 = 2;
    /// Most layers of a shadow map.
    MAX_LAYERS: u32 = 8;
    /// Most neighbours on either side of a screen-space blur; one less than the length of `BlurParams::taps`.
    MAX_BLUR_SIDE: u32 = 32;
    /// Most taps of an estimator of ambient occlusion; a 16th of the length of `OcclusionTaps::taps`.
    OCCLUSION_MAX_TAPS: u32 = 64;
    /// Most neighbours on either side of the filter of ambient occlusion.
    OCCLUSION_MAX_SIDE: u32 = 16;
    /// A bias counts steeper slopes as this one (`adumbra::settings::MAX_SLOPE`).
    MAX_SLOPE: f32 = 9.95;
    /// Steepest plane that a look-up of baked voxels follows (`adumbra::settings::MAX_PLANE_SLOPE`).
    MAX_PLANE_SLOPE: f32 = 120.0;
    /// A voxel in the fixed-point numbers of grid positions.
    FIXED_ONE: i32 = 4096;
    /// Bits behind the point of a grid position.
    FIXED_BITS: u32 = 12;
    /// Slope 1 in the fixed-point numbers of a receiver's gradient.
    GRADIENT_ONE: i32 = 256;
    /// Bits behind the point of a gradient.
    GRADIENT_BITS: u32 = 8;
    /// Largest number of a receiver's gradient (`MAX_PLANE_SLOPE` in them).
    MAX_GRADIENT: i32 = 30720;
    /// Voxels beyond a grid that positions are clamped to.
    MARGIN_VOXELS: i32 = 4096;
    /// 1 in the fixed-point numbers of a tree receiver's normal and height.
    NORMAL_ONE: i32 = 1024;
    /// Heights over a receiver's plane are clamped to this many cells.
    MAX_HEIGHT_CELLS: i32 = 8;
    /// Most regions of several depths that a tree's look-up takes.
    MAX_PLAN_REGIONS: u32 = 16;
    /// Top-grid entry: the whole root cube is lit (`adumbra::dag::LIT`).
    TOP_LIT: u32 = u32::MAX;
    /// Top-grid entry: the whole root cube is shadowed (`adumbra::dag::SHADOWED`).
    TOP_SHADOWED: u32 = u32::MAX - 1;
    /// Words before the columns in a packed graph's top (`adumbra::dag::packed::POOL_WORDS`).
    PACKED_POOL_WORDS: u32 = 19;
    /// Slots of a packed graph below this count from the end of their node's slots (`adumbra::dag::packed::NEAR_UNITS`).
    PACKED_NEAR_UNITS: u32 = 1024;
    /// In place of a shape's address: all of it switches at the base (`adumbra::hierarchy::UNIFORM`).
    HIERARCHY_UNIFORM: u32 = u32::MAX;
    /// Depth of a column that is lit to its end (`adumbra::hierarchy::NEVER`).
    HIERARCHY_NEVER: u32 = u32::MAX;
    /// Most texels of a penumbra's radius in a hierarchy: with more, depths of the receiver's plane would not fit 32 bits.
    HIERARCHY_MAX_RADIUS: f32 = 64.0;
    /// How far from the receiver, in texels, the sampler's own 2 × 2 comparison takes the receiver's plane.
    HARDWARE_REACH: f32 = 0.75;
    /// Blocks of a row whose ranks are counted together when a hybrid map is built.
    HYBRID_SECTION: u32 = 64;
    /// Words before the sections in the counts of a hybrid map.
    HYBRID_FIRST_SECTION: u32 = 4;
    /// Bits behind the point of a plane's slope of code 1.
    HYBRID_SLOPE_BITS: u32 = 12;
    /// A word of a hybrid map with this bit holds where its four finer texels are; one without it is a depth.
    HYBRID_INDEX: u32 = 0x80000000;
    /// The end of a list of links.
    HYBRID_NO_LINK: u32 = 0xffffffff;
    /// Depth 1 in the whole numbers that planes of a hybrid map are fitted in.
    HYBRID_ONE: f32 = 16777216.0;
    /// Largest code of a plane's depth.
    HYBRID_LAST_DEPTH: i32 = 131071;
    /// Whole-number depth from one code to the next.
    HYBRID_DEPTH_STEP: i32 = 128;
    /// Largest code of a plane's slope.
    HYBRID_LAST_SLOPE: i32 = 63;
    /// From one depth of 16 bits to the next.
    DEPTH_16_STEP: f32 = 1.0 / 65535.0;
    /// Threshold e0 of the relative test (Li, Yang, Zhao, Chen 2016, equation 1).
    HYBRID_E0: f32 = 0.25;
    /// Share that four moments of depth move towards those of an even spread: what their rounding needs in 32-bit floats.
    MOMENT_BIAS: f32 = 0.000003;
}

/// Points in the unit disc, far from each other from the first few on; their mean is the middle. Made once by best candidates
/// (Mitchell, *Spectrally Optimal Sampling for Distribution Ray Tracing*, 1991).
pub const POISSON_DISC: [[f32; 2]; 32] = [
    [-0.052, -0.009],
    [0.661, 0.478],
    [0.684, -0.426],
    [-0.150, 0.820],
    [-0.186, -0.824],
    [-0.809, 0.308],
    [-0.777, -0.414],
    [0.346, -0.830],
    [0.450, 0.020],
    [0.164, 0.436],
    [-0.338, 0.386],
    [0.086, -0.449],
    [-0.512, -0.030],
    [-0.583, 0.746],
    [0.288, 0.854],
    [0.877, 0.005],
    [-0.342, -0.424],
    [-0.973, -0.064],
    [-0.581, -0.769],
    [0.368, -0.299],
    [0.073, -0.954],
    [0.187, 0.147],
    [0.609, -0.712],
    [0.425, 0.314],
    [0.408, 0.600],
    [0.864, 0.284],
    [-0.064, 0.274],
    [-0.811, 0.586],
    [-0.097, 0.555],
    [-0.276, -0.161],
    [-0.290, 0.115],
    [0.345, -0.565],
];
