// The parameters of a file that was uploaded whole, and the look-up in it. core/voxel.wgsl must precede this
// file.

@group(1) @binding(0) var<uniform> adumbra_voxel_params: AdumbraVoxelParams;

fn adumbra_file_factor(s: AdumbraSurface) -> f32 {
    return adumbra_voxel_factor(adumbra_voxel_params, s);
}
