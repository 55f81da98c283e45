//! A shadow file's space as a wireframe.

use adumbra_render::layers::WorldLine;
use adumbra_tree::AnyFile;

/// Display-encoded colours of a file's whole space and of its regions.
const SPACE_COLOR: [f32; 3] = [1.0, 0.85, 0.2];
const REGION_COLOR: [f32; 3] = [0.3, 0.9, 1.0];

/// Returns the twelve edges of a box, given a corner and its three edge vectors.
fn edges(corner: [f64; 3], edges: [[f64; 3]; 3], color: [f32; 3]) -> impl Iterator<Item = WorldLine> {
    (0..3).flat_map(move |along| {
        (0..4_usize).map(move |which| {
            let others = [(along + 1) % 3, (along + 2) % 3];
            let from: [f64; 3] = std::array::from_fn(|a| {
                (0..2).fold(corner[a], |p, i| p + if which >> i & 1 == 1 { edges[others[i]][a] } else { 0.0 })
            });
            let to = std::array::from_fn(|a| from[a] + edges[along][a]);
            WorldLine { ends_world: [from, to], color }
        })
    })
}

/// Returns the edges of a file's space: the box of a light-aligned grid, or the cube of a tree and the columns of its
/// regions.
pub(crate) fn of_file(file: &AnyFile) -> Vec<WorldLine> {
    match file {
        AnyFile::Light(file) => {
            let grid = &file.grid;
            let sides: [[f64; 3]; 3] =
                std::array::from_fn(|a| grid.edges[a].map(|c| c * grid.voxel_size * f64::from(grid.size[a])));
            edges(grid.origin(), sides, SPACE_COLOR).collect()
        }
        AnyFile::Tree(file) => {
            let (low, side) = (file.space.p_min, file.space.voxel_size * f64::from(file.space.side_voxels()));
            let sides = |x: f64, z: f64| [[x, 0.0, 0.0], [0.0, side, 0.0], [0.0, 0.0, z]];
            let regions = file.regions.list.iter().flat_map(|r| {
                let corner = [r.x[0], low[1], r.z[0]];
                edges(corner, sides(r.x[1] - r.x[0], r.z[1] - r.z[0]), REGION_COLOR)
            });
            edges(low, sides(side, side), SPACE_COLOR).chain(regions).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn box_has_twelve_different_edges_of_its_lengths() {
        let lines: Vec<_> =
            edges([1.0, 2.0, 3.0], [[2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 4.0]], SPACE_COLOR)
                .collect();
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
