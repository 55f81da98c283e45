// Penumbrae in a file that was uploaded whole. access/voxel_params.wgsl, core/disc.wgsl and
// core/depths_soft.wgsl must precede this file.

fn adumbra_file_soft(s: AdumbraSurface) -> f32 {
    let r = adumbra_voxel_receiver(adumbra_voxel_params, s);
    return adumbra_depths_soft(adumbra_voxel_params, r, adumbra_disc_turn(s.pixel));
}
