// The technique `voxel:soft`: penumbrae from the depths of a hierarchy.

@group(1) @binding(0) var<uniform> hierarchy: HierarchyParams;

fn shadow_factor(s: Surface) -> f32 {
    let sun = hierarchy.sun;
    let r = voxel_receiver(hierarchy.voxel, s);
    return hierarchy_soft(hierarchy.voxel, r, sun.x, sun.y, disc_turn(s.pixel));
}
