//! Constants shared by Rust and WGSL, each declared here once. Their WGSL names begin with `ADUMBRA_`.

macro_rules! shared {
    ($($(#[$doc:meta])* $name:ident: $kind:ident = $value:expr;)*) => {
        $($(#[$doc])* pub const $name: $kind = $value;)*

        /// Every constant's WGSL name and WGSL declaration.
        pub fn declarations() -> Vec<(&'static str, String)> {
            let mut all = Vec::new();
            $(
                let name = concat!("ADUMBRA_", stringify!($name));
                all.push((name, format!("const {name}: {} = {:?};\n", stringify!($kind), $name)));
            )*
            let points: Vec<_> = POISSON_DISC.iter().map(|[x, y]| format!("vec2f({x:?}, {y:?})")).collect();
            let name = "ADUMBRA_POISSON_DISC";
            let disc = format!("const {name} = array<vec2f, {}>({});\n", points.len(), points.join(", "));
            all.push((name, disc));
            all
        }
    };
}

shared! {
    /// Workgroup size along each side for passes over pixels or texels, in threads.
    PIXEL_GROUP: u32 = 8;
    /// Workgroup size for passes over a list, in threads.
    LIST_GROUP: u32 = 64;
    /// Number of words per look-up that passes/voxel_reads.wgsl can store.
    MAX_READS: u32 = 8190;
    /// `LayerParams::kind`: the rendered picture.
    LAYER_COLOR: u32 = 0;
    /// `LayerParams::kind`: one value per pixel, as a shade of grey.
    LAYER_VALUE: u32 = 1;
    /// `LayerParams::kind`: view depth.
    LAYER_DEPTH: u32 = 2;
    /// `LayerParams::kind`: world-space normals.
    LAYER_NORMAL: u32 = 3;
    /// `LayerParams::kind`: the rendered picture, tinted by one value per pixel.
    LAYER_TINT: u32 = 4;
    /// Largest number of tint colours; the length of `LayerParams::palette`.
    MAX_TINTS: u32 = 16;
    /// `PresentParams::kind`: the first picture alone.
    PRESENT_FIRST: u32 = 0;
    /// `PresentParams::kind`: both pictures, side by side at a divider.
    PRESENT_SPLIT: u32 = 1;
    /// `PresentParams::kind`: the difference of the two pictures.
    PRESENT_DIFFERENCE: u32 = 2;
    /// Largest number of layers in a shadow map.
    MAX_LAYERS: u32 = 8;
    /// Largest number of taps on either side of a screen-space blur; one less than the length of
    /// `BlurParams::taps`.
    MAX_BLUR_SIDE: u32 = 32;
    /// Largest number of taps of an ambient occlusion estimator; a 16th of the length of
    /// `OcclusionTaps::taps`.
    OCCLUSION_MAX_TAPS: u32 = 64;
    /// Largest number of taps on either side of the ambient occlusion filter.
    OCCLUSION_MAX_SIDE: u32 = 16;
    /// Slope at which the slope-scaled bias is clamped (`adumbra::MAX_SLOPE`).
    MAX_SLOPE: f32 = 9.95;
    /// Slope of the steepest receiver plane that a look-up in baked voxels follows
    /// (`adumbra::MAX_PLANE_SLOPE`).
    MAX_PLANE_SLOPE: f32 = 120.0;
    /// One voxel in fixed-point grid positions.
    FIXED_ONE: i32 = 4096;
    /// Fraction bits of a grid position.
    FIXED_BITS: u32 = 12;
    /// Slope 1 in a receiver's fixed-point gradient.
    GRADIENT_ONE: i32 = 256;
    /// Fraction bits of a gradient.
    GRADIENT_BITS: u32 = 8;
    /// Largest component of a receiver's gradient (`MAX_PLANE_SLOPE` in fixed point).
    MAX_GRADIENT: i32 = 30720;
    /// Distance beyond a grid at which positions are clamped, in voxels.
    MARGIN_VOXELS: i32 = 4096;
    /// Replaces a shape's address if the whole block switches at its base
    /// (`adumbra::layout::depths::UNIFORM`).
    DEPTHS_UNIFORM: u32 = u32::MAX;
    /// Stored in place of an address if the page is not resident (`adumbra::stream`).
    DEPTHS_ABSENT: u32 = u32::MAX - 1;
    /// Level of a page: it spans 2^9 columns a side (`adumbra::layout::depths::PAGE_LEVEL`).
    PAGE_LEVEL: u32 = 9;
    /// Weight of a page whose answers are not mixed with those of the next coarser level (`adumbra::stream`).
    WHOLE_PAGE: u32 = 256;
    /// Stored in the third of a quadtree's extra words if the weights of its pages follow the table of
    /// blocks.
    PAGES_FADE: u32 = 2;
    /// Largest number of levels of a file (`adumbra::file::MAX_LEVELS`).
    MAX_LEVELS: u32 = 8;
    /// A ray that leaves a column's shadow within this many voxels of its surface has passed through the
    /// surface's edge (`adumbra::query::EDGE_VOXELS`).
    MARCH_EDGE_VOXELS: u32 = 2;
    /// Number of lit taps that means that a page is not resident. No filter has as many taps.
    TAPS_ABSENT: u32 = 1 << 16;
    /// Switch depth of a column that is lit to its end (`adumbra::layout::depths::NEVER`).
    DEPTHS_NEVER: u32 = u32::MAX;
    /// Distance along the receiver's plane, in texels, by which hardware 2 × 2 comparisons move the compared
    /// depth towards the sun.
    HARDWARE_REACH: f32 = 0.75;
    /// Number of blocks in a row that are ranked together when a hybrid map is built.
    HYBRID_SECTION: u32 = 64;
    /// Number of words before the sections in the counts of a hybrid map.
    HYBRID_FIRST_SECTION: u32 = 4;
    /// Fraction bits of a plane's slope with code 1.
    HYBRID_SLOPE_BITS: u32 = 12;
    /// A word of a hybrid map with this bit set holds the index of its four finer texels. Without it, the
    /// word is a depth.
    HYBRID_INDEX: u32 = 0x80000000;
    /// End of a linked list.
    HYBRID_NO_LINK: u32 = 0xffffffff;
    /// Depth 1 in the integers to which the planes of a hybrid map are fitted.
    HYBRID_ONE: f32 = 16777216.0;
    /// Largest depth code of a plane.
    HYBRID_LAST_DEPTH: i32 = 131071;
    /// Step of integer depth between consecutive depth codes.
    HYBRID_DEPTH_STEP: i32 = 128;
    /// Largest slope code of a plane.
    HYBRID_LAST_SLOPE: i32 = 63;
    /// Step between consecutive 16-bit depths.
    DEPTH_16_STEP: f32 = 1.0 / 65535.0;
    /// Threshold e0 of the relative test (Li, Yang, Zhao, Chen 2016, equation 1).
    HYBRID_E0: f32 = 0.25;
    /// Weight with which the four moments of depth are blended towards those of an even spread, to compensate
    /// their rounding in 32-bit floats.
    MOMENT_BIAS: f32 = 0.000003;
}

/// Points in the unit disc in progressive order: the first few are already far apart. Their mean is the
/// centre. Generated once by best-candidate sampling (Mitchell, *Spectrally Optimal Sampling for Distribution
/// Ray Tracing*, 1991).
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
