// The technique `voxel`: a light-aligned file, filtered over K × K texels.

@group(1) @binding(0) var<uniform> voxel: VoxelParams;

fn shadow_factor(s: Surface) -> f32 {
    return voxel_factor(voxel, s);
}
