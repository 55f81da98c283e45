// Bindings shared by all passes of the screen-space blur: parameters, input factor and output factor.

@group(0) @binding(0) var<uniform> blur: AdumbraBlurParams;
@group(0) @binding(1) var factor_in: texture_2d<f32>;
@group(0) @binding(2) var factor_out: texture_storage_2d<r32float, write>;

// Reads a texel, or the nearest one of the picture if it is outside.
fn factor_within(texel: vec2i, size: vec2u) -> f32 {
    return textureLoad(factor_in, clamp(texel, vec2i(0), vec2i(size) - 1), 0).x;
}

// Returns an offset along the axis of a line pass.
fn along(distance: i32) -> vec2i {
    return select(vec2i(distance, 0), vec2i(0, distance), blur.axis == 1u);
}

fn write_factor(texel: vec2u, factor: f32) {
    textureStore(factor_out, texel, vec4f(factor, 0.0, 0.0, 0.0));
}
