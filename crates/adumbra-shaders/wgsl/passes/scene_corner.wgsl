// Shared by the passes that draw the scene from its corners: the vertex input, and the material that cuts
// masked surfaces.

@group(1) @binding(0) var<uniform> material: AdumbraMaterialParams;
@group(1) @binding(1) var color_texture: texture_2d<f32>;
@group(1) @binding(2) var color_sampler: sampler;

struct Corner {
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    // Rows of relative from mesh.
    @location(3) row_x: vec4f,
    @location(4) row_y: vec4f,
    @location(5) row_z: vec4f,
    // sRGB, with linear alpha.
    @location(6) color: vec4f,
}

// Whether a masked material is cut away here: tested with its alpha at full resolution, as in the bake and in
// ray tracing.
fn is_cut(uv: vec2f, interpolated_alpha: f32) -> bool {
    let texel_alpha = textureSampleLevel(color_texture, color_sampler, uv, 0.0).a;
    return material.alpha * texel_alpha * adumbra_vertex_alpha(interpolated_alpha) < material.alpha_cutoff;
}
