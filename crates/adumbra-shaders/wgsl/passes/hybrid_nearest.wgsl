// Hybrid maps: the texel that a point lies in, compared.

fn hybrid_filter(r: MapReceiver) -> f32 {
    return hybrid_nearest(hybrid_shape(hybrid), r);
}
