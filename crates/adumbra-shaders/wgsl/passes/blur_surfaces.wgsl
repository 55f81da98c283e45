// Bindings of the edge-aware blur passes in addition to those of passes/blur_factor.wgsl.

@group(0) @binding(3) var<uniform> frame: AdumbraFrame;
@group(0) @binding(4) var gbuffer_depth: texture_depth_2d;
@group(0) @binding(5) var gbuffer_normal: texture_2d<f32>;

// Returns the surface of a pixel that is not sky.
fn surface_at(pixel: vec2u, depth: f32) -> AdumbraSurface {
    return adumbra_frame_surface(frame, pixel, depth, textureLoad(gbuffer_normal, pixel, 0).xyz);
}
