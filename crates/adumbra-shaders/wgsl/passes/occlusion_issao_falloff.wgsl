// A term of issao's sum in the second reading of φ, where φ shapes the falloff.
fn issao_term(w_n: f32, ww: f32, bias: f32) -> f32 {
    return max(w_n - bias, 0.0) / (ww + occlusion.shape.epsilon) * pow(1.0 - ww, occlusion.shape.falloff_exponent);
}
