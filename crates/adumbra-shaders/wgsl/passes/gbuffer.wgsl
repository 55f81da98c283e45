// Depth, normal and base colour of the scene; vertices are three a triangle, each with the triangle's own normal. Masked materials
// are cut by their alpha at full resolution, as the bake and the rays do it; colour is sampled with mip levels. The CPU's twin is
// adumbra::picture::BaseColors.

@group(0) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(0) var<uniform> material: MaterialParams;
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
    // sRGB, and linear alpha.
    @location(6) color: vec4f,
}

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
    f.p_relative = instance_relative(c.row_x, c.row_y, c.row_z, c.position);
    f.normal = instance_normal(c.row_x, c.row_y, c.row_z, c.normal);
    f.position = frame.clip_from_relative * vec4f(f.p_relative, 1.0);
    f.uv = c.uv;
    f.color = vec4f(srgb_decoded(c.color.rgb), c.color.a);
    return f;
}

// The mip level at which no texel is skipped between two pixels of the quad: OpenGL 4.6, section 8.14. Devices differ in how nearly they take
// the length and the logarithm when they find the level themselves.
fn color_level(uv: vec2f) -> f32 {
    let size = vec2f(textureDimensions(color_texture));
    let x = dpdxFine(uv) * size;
    let y = dpdyFine(uv) * size;
    return max(0.5 * log2(max(dot(x, x), dot(y, y))), 0.0);
}

fn targets(f: Fragment, alpha: f32) -> Targets {
    // From the viewer: the ray of an orthographic camera is the same everywhere.
    let to_viewer = frame.origin.xyz - f.p_relative;
    let orthographic = frame.depth_to_z.w == 0.0;
    let towards = select(to_viewer, -frame.forward.xyz, orthographic);
    let normal = normalize(f.normal);
    var t: Targets;
    t.normal = vec4f(select(normal, -normal, dot(normal, towards) < 0.0), 1.0);
    let texel = textureSampleLevel(color_texture, color_sampler, f.uv, color_level(f.uv)).rgb;
    t.color = vec4f(material.base_color.rgb * texel * f.color.rgb, alpha);
    return t;
}

@fragment
fn gbuffer_opaque(f: Fragment) -> Targets {
    return targets(f, 1.0);
}

@fragment
fn gbuffer_masked(f: Fragment) -> Targets {
    let t = targets(f, 1.0);
    let texel_alpha = textureSampleLevel(color_texture, color_sampler, f.uv, 0.0).a;
    let alpha = material.base_color.a * texel_alpha * vertex_alpha(f.color.a);
    if (alpha < material.alpha.x) {
        discard;
    }
    return t;
}
