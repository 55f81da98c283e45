// The level at which a look-up in a hierarchy ends; -1 beside the file.

@group(1) @binding(0) var<uniform> hierarchy: HierarchyParams;

fn shadow_factor(s: Surface) -> f32 {
    return f32(hierarchy_end_level(hierarchy.voxel, voxel_receiver(hierarchy.voxel, s)));
}
