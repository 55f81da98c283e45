// A technique's answer for each point of a list; one thread a point. Surfaces turned away are asked like the others.

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> points: array<PointQuery>;
@group(0) @binding(2) var<storage, read_write> factors: array<f32>;

@compute @workgroup_size(LIST_GROUP)
fn answer_points(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= arrayLength(&points)) {
        return;
    }
    let p = points[id.x];
    var s: Surface;
    s.p_relative = p.p_relative.xyz;
    s.normal = p.normal.xyz;
    s.towards_sun = frame.towards_sun.xyz;
    s.view_depth = p.p_relative.w;
    s.pixel = p.pixel.xy;
    factors[id.x] = shadow_factor(s);
}
