// A term of issao's sum. w_n is w·n; ww is w·w, at most 1.
fn issao_term(w_n: f32, ww: f32, bias: f32) -> f32 {
    return max(w_n - bias, 0.0) / (ww + occlusion.shape.epsilon);
}
