// Hybrid maps: the mean of comparisons over a square.

fn hybrid_filter(r: MapReceiver) -> f32 {
    return hybrid_box(hybrid_shape(hybrid), r, hybrid.counts.z);
}
