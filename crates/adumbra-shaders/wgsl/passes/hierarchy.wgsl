// The technique `voxel` on a hierarchy, filtered over K × K texels.

@group(1) @binding(0) var<uniform> hierarchy: HierarchyParams;

fn shadow_factor(s: Surface) -> f32 {
    let width = hierarchy.voxel.places.z;
    return f32(hierarchy_lit_taps(hierarchy.voxel, voxel_receiver(hierarchy.voxel, s))) / f32(width * width);
}
