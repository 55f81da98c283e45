// Draws world-space lines over a picture; parts behind a surface are faint.

@group(0) @binding(0) var<uniform> frame: AdumbraFrame;
@group(0) @binding(1) var lines_depth: texture_depth_2d;
@group(0) @binding(2) var<uniform> layer: AdumbraLayerParams;

struct LinePoint {
    @builtin(position) position: vec4f,
    @location(0) color: vec3f,
}

@vertex
fn lines_vertex(@location(0) p_relative: vec4f, @location(1) color: vec4f) -> LinePoint {
    var point: LinePoint;
    point.position = frame.clip_from_relative * vec4f(p_relative.xyz, 1.0);
    point.color = color.rgb;
    return point;
}

@fragment
fn lines_fragment(point: LinePoint) -> @location(0) vec4f {
    let pixel = min(vec2u(point.position.xy) * layer.samples, textureDimensions(lines_depth) - 1u);
    let behind = point.position.z < textureLoad(lines_depth, pixel, 0);
    return vec4f(point.color, select(0.9, 0.2, behind));
}
