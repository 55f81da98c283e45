// Depth, normal and base colour of the scene. There are three vertices per triangle, each with the triangle's
// own normal. Masked materials are cut by their alpha at full resolution, as in the bake and in ray tracing.
// Colour is sampled with mip levels. The CPU counterpart is adumbra_truth::picture::BaseColors.

@group(0) @binding(0) var<uniform> frame: AdumbraFrame;

struct Fragment {
    @builtin(position) position: vec4f,
    @location(0) p_relative: vec3f,
    @location(1) @interpolate(flat) normal: vec3f,
    @location(2) uv: vec2f,
    // Linear.
    @location(3) color: vec4f,
}

struct Targets {
    @location(0) normal: vec4f,
    @location(1) color: vec4f,
}

@vertex
fn gbuffer_vertex(c: Corner) -> Fragment {
    var f: Fragment;
    f.p_relative = adumbra_instance_relative(c.row_x, c.row_y, c.row_z, c.position);
    f.normal = adumbra_instance_normal(c.row_x, c.row_y, c.row_z, c.normal);
    f.position = frame.clip_from_relative * vec4f(f.p_relative, 1.0);
    f.uv = c.uv;
    f.color = vec4f(adumbra_srgb_decoded(c.color.rgb), c.color.a);
    return f;
}

// Returns the mip level at which no texel is skipped between two pixels of the quad (OpenGL 4.6, section
// 8.14). It is computed here because devices differ in how precisely they approximate the length and the
// logarithm.
fn color_level(uv: vec2f) -> f32 {
    let size = vec2f(textureDimensions(color_texture));
    let x = dpdxFine(uv) * size;
    let y = dpdyFine(uv) * size;
    return max(0.5 * log2(max(dot(x, x), dot(y, y))), 0.0);
}

fn targets(f: Fragment, alpha: f32) -> Targets {
    // Direction used to orient the normal: the rays of an orthographic camera are parallel.
    let to_viewer = frame.origin - f.p_relative;
    let orthographic = frame.depth_to_z.denominator_slope == 0.0;
    let towards = select(to_viewer, -frame.forward, orthographic);
    let normal = normalize(f.normal);
    var t: Targets;
    t.normal = vec4f(select(normal, -normal, dot(normal, towards) < 0.0), 1.0);
    let texel = textureSampleLevel(color_texture, color_sampler, f.uv, color_level(f.uv)).rgb;
    t.color = vec4f(material.base_color * texel * f.color.rgb, alpha);
    return t;
}

@fragment
fn gbuffer_opaque(f: Fragment) -> Targets {
    return targets(f, 1.0);
}

@fragment
fn gbuffer_masked(f: Fragment) -> Targets {
    let t = targets(f, 1.0);
    if (is_cut(f.uv, f.color.a)) {
        discard;
    }
    return t;
}
