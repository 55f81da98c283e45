//! Octree paths and the coordinates of voxels. Source: equations (3-1) to (3-3) and tables 3-1 and 3-2 of
//! *The Optimization and realization of Compact Precomputed Voxelized Shadows Algorithm* (2021), Morton
//! (1966).
//!
//! Child number: `(x_bit << 2) | (y_bit << 1) | z_bit`. Worked value: voxel (5, 3, 5) of a tree of depth 3
//! has the path 5, 2, 7, because x = 101, y = 011 and z = 101, read from the highest bit down, give 101,
//! 010, 111.

/// Returns the number of the child that contains voxel (x, y, z), in a node whose children have sides of
/// 2^`child_level` voxels.
pub fn child(xyz: [u32; 3], child_level: u32) -> u32 {
    let [x, y, z] = xyz.map(|c| c >> child_level & 1);
    x << 2 | y << 1 | z
}

/// Returns the bits of a child number: which half of its parent the child occupies along x, y and z.
pub(crate) fn child_offset(child: u32) -> [u32; 3] {
    [child >> 2 & 1, child >> 1 & 1, child & 1]
}

/// Returns the lowest voxel of a child of the cube at `corner`, whose sides are 2^`level` voxels, at least
/// two.
pub(crate) fn child_corner(corner: [u32; 3], level: u32, child: u32) -> [u32; 3] {
    let offset = child_offset(child);
    std::array::from_fn(|a| corner[a] + (offset[a] << (level - 1)))
}

/// Returns the child numbers from the root down to voxel (x, y, z) of a tree of `depth` levels.
pub fn path(xyz: [u32; 3], depth: u32) -> Vec<u32> {
    (0..depth).rev().map(|level| child(xyz, level)).collect()
}

/// Returns the voxel at the end of a path: equations (3-1), (3-2), (3-3), with n = the length of the path.
pub fn voxel(path: &[u32]) -> [u32; 3] {
    let n = path.len();
    let sum =
        |bit: u32| path.iter().enumerate().map(|(i, a)| (a >> bit & 1) << (n - i - 1)).fold(0, |s, v| s | v);
    [sum(2), sum(1), sum(0)]
}

/// Returns the share of the voxels of a tree that precede voxel (x, y, z) in Morton order.
pub(crate) fn share_before(xyz: [u32; 3], depth: u32) -> f64 {
    path(xyz, depth).iter().rev().fold(0.0, |share, &child| (share + f64::from(child)) / 8.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn morton_worked_example_of_table_3_2() {
        assert_eq!(path([5, 3, 5], 3), [5, 2, 7]);
        assert_eq!(voxel(&[5, 2, 7]), [5, 3, 5]);
    }

    #[test]
    fn morton_worked_example_of_table_3_1() {
        // In 2D the number is (x_bit << 1) | y_bit: that of the octree without its z bit.
        let flat: Vec<u32> = path([5, 3, 0], 3).iter().map(|a| a >> 1).collect();
        assert_eq!(flat, [2, 1, 3]);
    }

    #[test]
    fn morton_share_before_is_fraction_of_preceding_voxels() {
        assert_eq!(share_before([0, 0, 0], 3), 0.0);
        assert_eq!(share_before([4, 0, 0], 3), 0.5);
        assert_eq!(share_before([7, 7, 7], 3), 511.0 / 512.0);
    }

    #[test]
    fn morton_paths_and_voxels_are_inverse() {
        for x in 0..16 {
            for y in 0..16 {
                for z in 0..16 {
                    assert_eq!(voxel(&path([x, y, z], 4)), [x, y, z]);
                }
            }
        }
    }
}
