//! Structures that Rust writes and WGSL reads, declared here once for both languages.
//!
//! Their WGSL names begin with `Adumbra`. Every field has one meaning. Rust writes the padding between
//! fields, and `tests/validate.rs` checks sizes and offsets against naga's. "Relative" positions are world
//! positions minus the frame's anchor.

mod baked;
mod blur;
mod frame;
mod hybrid;
pub mod kinds;
mod maps;
mod occlusion;
mod picture;

pub use baked::{GridTransform, VoxelParams, VoxelQuery};
pub use blur::{BlurParams, BlurTap};
pub use frame::{DepthToZ, Frame, MaterialParams, PointQuery, ReceiverBias};
pub use hybrid::{HybridLevel, HybridParams};
pub use kinds::{Array, GpuType};
pub use maps::{MapLayer, MapParams, MomentBlurParams, MomentParams};
pub use occlusion::{
    OcclusionFilterParams, OcclusionHistoryParams, OcclusionParams, OcclusionShape, OcclusionTaps,
    OcclusionView,
};
pub use picture::{CompositeParams, LayerParams, PresentParams};

/// A structure's WGSL declaration, and the offsets at which Rust writes its fields.
pub struct StructInfo {
    /// Its name in WGSL.
    pub name: &'static str,
    /// Number of bytes that Rust writes.
    pub size: usize,
    /// Each field's name, and the offset at which Rust writes it.
    pub fields: fn() -> Vec<(&'static str, usize)>,
    /// Its WGSL text.
    pub declare: fn() -> String,
}

/// All structures, each listed after the ones it contains.
pub const STRUCTS: &[StructInfo] = &[
    DepthToZ::INFO,
    Frame::INFO,
    ReceiverBias::INFO,
    MapLayer::INFO,
    MomentParams::INFO,
    MapParams::INFO,
    HybridParams::INFO,
    HybridLevel::INFO,
    MomentBlurParams::INFO,
    GridTransform::INFO,
    VoxelParams::INFO,
    VoxelQuery::INFO,
    PointQuery::INFO,
    BlurTap::INFO,
    BlurParams::INFO,
    OcclusionView::INFO,
    OcclusionShape::INFO,
    OcclusionParams::INFO,
    OcclusionTaps::INFO,
    OcclusionFilterParams::INFO,
    OcclusionHistoryParams::INFO,
    CompositeParams::INFO,
    LayerParams::INFO,
    PresentParams::INFO,
    MaterialParams::INFO,
];
