// The technique `voxel+csm`: static casters from a light-aligned file, movers from cascades in which nothing else is drawn; the darker
// of the two. Receivers may stand still or move.

@group(1) @binding(0) var<uniform> voxel: VoxelParams;

fn shadow_factor(s: Surface) -> f32 {
    let still = voxel_factor(voxel, s);
    if (still == 0.0) {
        return 0.0;
    }
    return min(still, map_visibility(s));
}
