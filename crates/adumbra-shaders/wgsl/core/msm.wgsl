// Moment shadow maps: of all depth distributions with the given four moments, uses the one that shadows the
// receiver least. Source: Peters, Klein, Moment Shadow Mapping, 2015 (the Hamburger problem). Depth is from
// -1 to 1. That distribution has three depths: the receiver's, and the two roots of the polynomial that
// results from solving with the moments' Hankel matrix.

alias AdumbraMomentsOut = texture_storage_2d<rgba32float, write>;

fn adumbra_moments_of(depth: f32, exponents: vec2f) -> vec4f {
    let t = 2.0 * depth - 1.0;
    let t2 = t * t;
    return vec4f(t, t2, t2 * t, t2 * t2);
}

// Returns the weight of depth a in the distribution on a, b and c with these first two moments.
fn adumbra_msm_weight(m: vec2f, a: f32, b: f32, c: f32) -> f32 {
    return (m.y - m.x * (b + c) + b * c) / ((a - b) * (a - c));
}

fn adumbra_moments_visibility(m: vec4f, depth: f32, deviation: f32, params: AdumbraMomentParams) -> f32 {
    let t = 2.0 * depth - 1.0;
    // Rounding may have produced moments that no distribution has, so they are blended slightly towards those
    // of an even spread.
    let m1 = mix(m, vec4f(0.0, 0.375, 0.0, 0.375), ADUMBRA_MOMENT_BIAS);
    // Enforces the minimum variance by adding a normally distributed variable.
    let s = 4.0 * deviation * deviation;
    let b = m1 + vec4f(0.0, s, 3.0 * s * m1.x, 6.0 * s * m1.y + 3.0 * s * s);
    // Cholesky factors of the Hankel matrix (1, b1, b2; b1, b2, b3; b2, b3, b4): unit lower triangle and
    // diagonal.
    let d1 = b.y - b.x * b.x;
    let l21 = (b.z - b.x * b.y) / d1;
    let d2 = max(b.w - b.y * b.y - l21 * l21 * d1, 1e-12);
    // Solves H q = (1, t, t²).
    let y1 = t - b.x;
    let y2 = t * t - b.y - l21 * y1;
    let q2 = y2 / d2;
    let q1 = y1 / d1 - l21 * q2;
    let q0 = 1.0 - b.x * q1 - b.y * q2;
    // Roots of q0 + q1 z + q2 z².
    let p = q1 / q2;
    let root = sqrt(max(0.25 * p * p - q0 / q2, 0.0));
    let z1 = -0.5 * p - root;
    let z2 = -0.5 * p + root;
    var shadow = 0.0;
    if (z1 < t) {
        shadow += adumbra_msm_weight(b.xy, z1, t, z2);
    }
    if (z2 < t) {
        shadow += adumbra_msm_weight(b.xy, z2, t, z1);
    }
    return adumbra_moments_cut(1.0 - clamp(shadow, 0.0, 1.0), params.bleed);
}
