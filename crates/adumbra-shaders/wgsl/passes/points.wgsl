// Evaluates a technique for each point of a list, one thread per point. Surfaces that face away from the sun
// are evaluated like all others.

@group(0) @binding(0) var<uniform> frame: AdumbraFrame;
@group(0) @binding(1) var<storage, read> points: array<AdumbraPointQuery>;
@group(0) @binding(2) var<storage, read_write> factors: array<f32>;

@compute @workgroup_size(ADUMBRA_LIST_GROUP)
fn answer_points(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= arrayLength(&points)) {
        return;
    }
    let p = points[id.x];
    var s: AdumbraSurface;
    s.p_relative = p.p_relative;
    s.normal = p.normal;
    s.towards_sun = frame.towards_sun;
    s.view_depth = p.view_depth;
    s.pixel = p.pixel;
    factors[id.x] = adumbra_shadow_factor(s);
}
