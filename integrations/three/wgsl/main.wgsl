// Keeps the look-up in the generated text, which ends before this function.
@fragment
fn main(@location(0) p_world: vec3f, @location(1) normal: vec3f, @builtin(position) at: vec4f) -> @location(0) vec4f {
    return vec4f(adumbra_visibility(p_world, normal, at.xy));
}
