// Hybrid maps: compares the texel that contains the point.

fn hybrid_filter(r: AdumbraMapReceiver) -> f32 {
    return adumbra_hybrid_nearest(adumbra_hybrid_shape(hybrid), r);
}
