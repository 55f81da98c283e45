// From a mesh to the world by an instance's rows of relative from mesh: the translation is already less the anchor.

// World position less the anchor.
fn instance_relative(row_x: vec4f, row_y: vec4f, row_z: vec4f, position: vec3f) -> vec3f {
    let translation = vec3f(row_x.w, row_y.w, row_z.w);
    return vec3f(dot(row_x.xyz, position), dot(row_y.xyz, position), dot(row_z.xyz, position)) + translation;
}

// Interpolated alpha of vertex colours: where all corners are 1, rounding leaves it 1.
fn vertex_alpha(interpolated: f32) -> f32 {
    return select(interpolated, 1.0, interpolated > 0.99999);
}

// A normal, of no particular length. The cofactor matrix turns normals; where the rows mirror, its sign is the other one.
fn instance_normal(row_x: vec4f, row_y: vec4f, row_z: vec4f, normal: vec3f) -> vec3f {
    let x = vec3f(row_x.x, row_y.x, row_z.x);
    let y = vec3f(row_x.y, row_y.y, row_z.y);
    let z = vec3f(row_x.z, row_y.z, row_z.z);
    return cross(y, z) * normal.x + cross(z, x) * normal.y + cross(x, y) * normal.z;
}
