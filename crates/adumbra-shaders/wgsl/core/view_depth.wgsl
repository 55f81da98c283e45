// Converts stored depth to distance along the camera's forward direction. AdumbraFrame documents the depth
// convention.

fn adumbra_stored_view_depth(k: AdumbraDepthToZ, depth: f32) -> f32 {
    return (k.numerator + k.numerator_slope * depth) / (k.denominator + k.denominator_slope * depth);
}
