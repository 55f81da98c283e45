// The level at which a look-up in a light-aligned graph ends; -1 beside the file.

@group(1) @binding(0) var<uniform> voxel: VoxelParams;

fn shadow_factor(s: Surface) -> f32 {
    return f32(voxel_end_level(voxel, voxel_receiver(voxel, s)));
}
