//! Tests on a device. One program, which links once, and whose files share a kit.

mod blur;
mod colors;
mod depths;
mod depths_leaves;
mod device;
mod engine_wgsl;
mod frame;
mod frame_again;
mod hybrid;
mod hybrid_frames;
mod hybrid_paper;
mod kit;
mod look_up_texture;
mod maps;
mod maps_moving;
mod maps_soft;
mod movers;
mod occlusion;
mod occlusion_buffers;
mod occlusion_cap;
mod occlusion_filter;
mod occlusion_frame;
mod occlusion_reuse;
mod octahedral;
mod path;
#[path = "../../examples/look_up_texture/shade.rs"]
mod shade;
mod streamed;
mod voxel;
mod voxel_levels;
mod voxel_points;
mod voxel_shared;
