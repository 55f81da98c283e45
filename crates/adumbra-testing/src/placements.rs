//! Placements that an app may give a file's world.

use adumbra::Placement;

/// Returns ten named placements: translated, rotated about any axis, scaled by 0.01 to 100, and combinations
/// of these.
pub fn placements() -> [(&'static str, Placement); 10] {
    let at = |name, turn: [f64; 4], scale: f64, origin: [f64; 3]| {
        let placement = Placement::from_matrix(matrix(turn, scale, origin));
        (name, placement.expect("a turn, a scale and a place"))
    };
    let still = [0.0, 0.0, 0.0, 1.0];
    let about_y = |degrees: f64| {
        let (sine, cosine) = (0.5 * degrees.to_radians()).sin_cos();
        [0.0, sine, 0.0, cosine]
    };
    [
        at("moved", still, 1.0, [12.5, -3.0, 40.25]),
        at("moved far", still, 1.0, [250_000.0, 10.0, -480_000.0]),
        at("turned a quarter", about_y(90.0), 1.0, [0.0; 3]),
        at("turned", about_y(-37.0), 1.0, [3.0, 0.0, 1.0]),
        at("tilted", [0.3, 0.1, -0.2, 0.9], 1.0, [0.0, 7.0, 0.0]),
        at("upside down", [1.0, 0.0, 0.0, 0.0], 1.0, [0.0; 3]),
        at("a model on a table", still, 0.01, [0.4, 0.7, -0.3]),
        at("in centimetres", still, 100.0, [0.0; 3]),
        at("smaller and turned", about_y(123.0), 0.37, [-20.0, 2.0, 9.0]),
        at("larger, tilted and moved", [-0.5, 0.4, 0.1, 0.7], 8.5, [100.0, -40.0, 15.0]),
    ]
}

/// Returns the column-major matrix of a quaternion of any length, a scale and a translation.
fn matrix(turn: [f64; 4], scale: f64, origin: [f64; 3]) -> [[f64; 4]; 4] {
    let length = turn.iter().map(|c| c * c).sum::<f64>().sqrt();
    let [x, y, z, w] = turn.map(|c| c / length);
    let columns = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
        [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)],
        [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)],
    ];
    let [x, y, z] = columns.map(|[x, y, z]| [scale * x, scale * y, scale * z, 0.0]);
    [x, y, z, [origin[0], origin[1], origin[2], 1.0]]
}
