// Transforms a mesh instance by its rows of relative from mesh. Their translation is already relative to the
// anchor.

// Returns the world position minus the anchor.
fn adumbra_instance_relative(row_x: vec4f, row_y: vec4f, row_z: vec4f, position: vec3f) -> vec3f {
    let translation = vec3f(row_x.w, row_y.w, row_z.w);
    return vec3f(dot(row_x.xyz, position), dot(row_y.xyz, position), dot(row_z.xyz, position)) + translation;
}

// Returns the interpolated vertex alpha; exactly 1 if it is 1 at all corners, despite rounding.
fn adumbra_vertex_alpha(interpolated: f32) -> f32 {
    return select(interpolated, 1.0, interpolated > 0.99999);
}

// Transforms a normal by the cofactor matrix; the result is not normalised. If the rows contain a mirroring,
// the sign is flipped.
fn adumbra_instance_normal(row_x: vec4f, row_y: vec4f, row_z: vec4f, normal: vec3f) -> vec3f {
    let x = vec3f(row_x.x, row_y.x, row_z.x);
    let y = vec3f(row_x.y, row_y.y, row_z.y);
    let z = vec3f(row_x.z, row_y.z, row_z.z);
    return cross(y, z) * normal.x + cross(z, x) * normal.y + cross(x, y) * normal.z;
}
