//! A solid that casts a jagged shadow.

/// Returns the faces of a closed bar along x whose top is a row of teeth, as quads. The first tooth begins at
/// `x`; each is `pitch` wide. `y` has the heights of the bottom, the valleys and the tips.
pub fn toothed_bar(x: f64, teeth: usize, pitch: f64, y: [f64; 3], z: [f64; 2]) -> Vec<[[f64; 3]; 4]> {
    let last = 2 * teeth;
    let column = |n: usize| {
        let (across, top) = (x + 0.5 * pitch * n as f64, y[1 + n % 2]);
        [[across, top, z[0]], [across, top, z[1]], [across, y[0], z[0]], [across, y[0], z[1]]]
    };
    let mut faces = Vec::new();
    for n in 0..last {
        let ([a, b, c, d], [e, f, g, h]) = (column(n), column(n + 1));
        faces.extend([[a, b, f, e], [c, g, h, d], [a, e, g, c], [b, d, h, f]]);
    }
    let ([a, b, c, d], [e, f, g, h]) = (column(0), column(last));
    faces.extend([[a, c, d, b], [e, f, h, g]]);
    faces
}
