// A term of issao's sum without attenuation: v is normalised, and there is no bias (equation 3; Fig. 4).
fn issao_term(w_n: f32, ww: f32, bias: f32) -> f32 {
    return max(w_n, 0.0) * inverseSqrt(max(ww, 1e-12));
}
