//! A shadow file's space as a wireframe.

use adumbra::LightGrid;
use adumbra_render::layers::WorldLine;

/// Display-encoded colour of the lines.
const COLOR: [f32; 3] = [1.0, 0.85, 0.2];

/// Returns the twelve edges of a box, given a corner and its three edge vectors.
fn edges(corner: [f64; 3], edges: [[f64; 3]; 3]) -> impl Iterator<Item = WorldLine> {
    (0..3).flat_map(move |along| {
        (0..4_usize).map(move |which| {
            let others = [(along + 1) % 3, (along + 2) % 3];
            let from: [f64; 3] = std::array::from_fn(|a| {
                (0..2).fold(corner[a], |p, i| p + if which >> i & 1 == 1 { edges[others[i]][a] } else { 0.0 })
            });
            let to = std::array::from_fn(|a| from[a] + edges[along][a]);
            WorldLine { ends_world: [from, to], color: COLOR }
        })
    })
}

/// Returns the edges of a grid's space.
pub(crate) fn of_grid(grid: &LightGrid) -> Vec<WorldLine> {
    let sides = std::array::from_fn(|a| grid.edges[a].map(|c| c * grid.voxel_size * f64::from(grid.size[a])));
    edges(grid.origin(), sides).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn box_has_twelve_different_edges_of_its_lengths() {
        let lines: Vec<_> =
            edges([1.0, 2.0, 3.0], [[2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 4.0]]).collect();
        assert_eq!(lines.len(), 12);
        let mut lengths: Vec<f64> = lines
            .iter()
            .map(|l| (0..3).map(|a| (l.ends_world[1][a] - l.ends_world[0][a]).abs()).sum())
            .collect();
        lengths.sort_by(f64::total_cmp);
        assert_eq!(lengths, [[2.0; 4], [3.0; 4], [4.0; 4]].concat());
        for (i, a) in lines.iter().enumerate() {
            assert!(lines[..i].iter().all(|b| a.ends_world != b.ends_world));
        }
    }
}
