//! Numbers that Rust and WGSL share, each declared here once.

macro_rules! shared {
    ($($(#[$doc:meta])* $name:ident: $kind:ident = $value:expr;)*) => {
        $($(#[$doc])* pub const $name: $kind = $value;)*

        /// Every constant as WGSL.
        pub fn declarations() -> String {
            let mut text = String::new();
            $(text += &format!("const {}: {} = {:?};\n", stringify!($name), stringify!($kind), $name);)*
            text + "\n"
        }
    };
}

shared! {
    /// Most layers of a shadow map.
    MAX_LAYERS: u32 = 8;
    /// Slopes above this count as this (`adumbra::settings::MAX_SLOPE`).
    MAX_SLOPE: f32 = 9.95;
    /// A voxel in the fixed-point numbers of grid positions.
    FIXED_ONE: i32 = 4096;
    /// Bits behind the point of a grid position.
    FIXED_BITS: u32 = 12;
    /// Slope 1 in the fixed-point numbers of a receiver's gradient.
    GRADIENT_ONE: i32 = 256;
    /// Bits behind the point of a gradient.
    GRADIENT_BITS: u32 = 8;
    /// Largest number of a receiver's gradient (`MAX_SLOPE` in them).
    MAX_GRADIENT: i32 = 2547;
    /// Voxels beyond a grid that positions are clamped to.
    MARGIN_VOXELS: i32 = 1024;
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
}
