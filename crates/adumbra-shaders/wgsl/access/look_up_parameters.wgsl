// Header and parameters of the look-up texture, version 3. Source: spec/look-up-texture.md.
// `adumbra_header_word` of access/look_up_texture.wgsl returns the header's words. An engine that keeps the
// words elsewhere provides that function and `adumbra_voxel_word` itself.

// First word of the parameter block.
const ADUMBRA_TEXTURE_PARAMS: u32 = 16u;

// Returns three words of the parameter block.
fn adumbra_texture_params_row(word: u32) -> vec3u {
    let at = ADUMBRA_TEXTURE_PARAMS + word;
    return vec3u(adumbra_header_word(at), adumbra_header_word(at + 1u), adumbra_header_word(at + 2u));
}

fn adumbra_texture_params_u32(word: u32) -> u32 {
    return adumbra_header_word(ADUMBRA_TEXTURE_PARAMS + word);
}

fn adumbra_texture_params_f32(word: u32) -> f32 {
    return bitcast<f32>(adumbra_texture_params_u32(word));
}

// Returns the world position that AdumbraSurface::p_relative is measured from.
fn adumbra_texture_anchor() -> vec3f {
    return bitcast<vec3f>(vec3u(adumbra_header_word(4u), adumbra_header_word(5u), adumbra_header_word(6u)));
}

// Returns the unit vector towards the sun.
fn adumbra_texture_towards_sun() -> vec3f {
    return bitcast<vec3f>(vec3u(adumbra_header_word(8u), adumbra_header_word(9u), adumbra_header_word(10u)));
}

// Returns the parameter block: 73 texel fetches, the same for every pixel. An engine with a uniform buffer
// puts the block there instead.
fn adumbra_texture_params() -> AdumbraVoxelParams {
    var v: AdumbraVoxelParams;
    v.grid.axis_x = bitcast<vec3f>(adumbra_texture_params_row(0u));
    v.grid.axis_y = bitcast<vec3f>(adumbra_texture_params_row(4u));
    v.grid.axis_z = bitcast<vec3f>(adumbra_texture_params_row(8u));
    v.grid.edge_x = bitcast<vec3f>(adumbra_texture_params_row(12u));
    v.grid.edge_y = bitcast<vec3f>(adumbra_texture_params_row(16u));
    v.grid.edge_z = bitcast<vec3f>(adumbra_texture_params_row(20u));
    v.grid.step_x = bitcast<vec3i>(adumbra_texture_params_row(24u));
    v.grid.step_y = bitcast<vec3i>(adumbra_texture_params_row(28u));
    v.grid.step_z = bitcast<vec3i>(adumbra_texture_params_row(32u));
    v.grid.rest_x = bitcast<vec3f>(adumbra_texture_params_row(36u));
    v.grid.rest_y = bitcast<vec3f>(adumbra_texture_params_row(40u));
    v.grid.rest_z = bitcast<vec3f>(adumbra_texture_params_row(44u));
    v.grid.anchor_fixed = bitcast<vec3i>(adumbra_texture_params_row(48u));
    v.grid.anchor_remainder = bitcast<vec3f>(adumbra_texture_params_row(52u));
    v.grid.anchor_voxels = bitcast<vec3f>(adumbra_texture_params_row(56u));
    v.grid.size = bitcast<vec3i>(adumbra_texture_params_row(60u));
    v.grid.voxels_per_world = adumbra_texture_params_f32(63u);
    v.grid.step_world = adumbra_texture_params_f32(64u);
    v.grid.steps_per_world = adumbra_texture_params_f32(65u);
    v.root_count = adumbra_texture_params_row(68u);
    v.root_level = adumbra_texture_params_u32(71u);
    v.bias.constant_texels = adumbra_texture_params_f32(72u);
    v.bias.slope_texels = adumbra_texture_params_f32(73u);
    v.bias.normal_offset_texels = adumbra_texture_params_f32(74u);
    v.bias.width_factor = adumbra_texture_params_f32(75u);
    v.extra = adumbra_texture_params_row(76u);
    v.code_offset = adumbra_texture_params_u32(79u);
    v.filter_width = adumbra_texture_params_u32(80u);
    v.sun_cone = adumbra_texture_params_f32(81u);
    v.max_radius_texels = adumbra_texture_params_f32(82u);
    v.penumbra_x = vec2f(adumbra_texture_params_f32(84u), adumbra_texture_params_f32(85u));
    v.penumbra_y = vec2f(adumbra_texture_params_f32(86u), adumbra_texture_params_f32(87u));
    return v;
}
