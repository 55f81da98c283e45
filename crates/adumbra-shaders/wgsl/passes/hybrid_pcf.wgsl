// Hybrid maps: the mean of comparisons over a square.

fn hybrid_filter(r: AdumbraMapReceiver) -> f32 {
    return adumbra_hybrid_box(adumbra_hybrid_shape(hybrid), r, hybrid.filter_width);
}
