// Taps of a disc, rotated by an angle that varies per pixel. Source of the noise: Jimenez, Next Generation
// Post Processing in Call of Duty: Advanced Warfare, 2014 (interleaved gradient noise), here in integers, so
// that every machine computes the same angle.

// Returns a value from 0 to 1.
fn adumbra_interleaved_gradient_noise(pixel: vec2u) -> f32 {
    // The factors are 0.06711056 and 0.00583715 times 2^32; the product wraps, which takes the fraction.
    // 54255 is 52.9829189 times 2^10.
    let ramp = (pixel.x * 288237660u + pixel.y * 25070368u) >> 16u;
    return f32((ramp * 54255u) & 0x3ffffffu) / 67108864.0;
}

// Returns the cosine and sine of the pixel's rotation.
fn adumbra_disc_turn(pixel: vec2u) -> vec2f {
    let angle = 6.2831853 * adumbra_interleaved_gradient_noise(pixel);
    return vec2f(cos(angle), sin(angle));
}

// Returns a tap within the unit disc; `index` is 0 to 31.
fn adumbra_disc_tap(index: u32, turn: vec2f) -> vec2f {
    let p = ADUMBRA_POISSON_DISC[index];
    return vec2f(turn.x * p.x - turn.y * p.y, turn.y * p.x + turn.x * p.y);
}
