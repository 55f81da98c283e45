// Taps of a disc, turned by an angle that differs from pixel to pixel.
// Source of the noise: Jimenez, Next Generation Post Processing in Call of Duty: Advanced Warfare, 2014 (interleaved gradient noise),
// here in whole numbers, so that every machine gets the same angle.

// 0 to 1.
fn interleaved_gradient_noise(pixel: vec2u) -> f32 {
    // 0.06711056 and 0.00583715 of 2^32, whose product's wrap is the fraction; 52.9829189 of 2^10.
    let ramp = (pixel.x * 288237660u + pixel.y * 25070368u) >> 16u;
    return f32((ramp * 54255u) & 0x3ffffffu) / 67108864.0;
}

// Cosine and sine of the pixel's turn.
fn disc_turn(pixel: vec2u) -> vec2f {
    let angle = 6.2831853 * interleaved_gradient_noise(pixel);
    return vec2f(cos(angle), sin(angle));
}

// A tap within the unit disc; 0 to 31.
fn disc_tap(index: u32, turn: vec2f) -> vec2f {
    let p = POISSON_DISC[index];
    return vec2f(turn.x * p.x - turn.y * p.y, turn.y * p.x + turn.x * p.y);
}
