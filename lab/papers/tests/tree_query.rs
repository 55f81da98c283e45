//! Compares voxel PCF with its definition, on trees small enough to count by hand or voxel by voxel.

use adumbra::{Bias, Sun};
use adumbra_papers::tree::query::{TreeQuery, Weights};
use adumbra_papers::tree::{Classify, Regions, State, TreeBuilder, TreeSpace, VoxelTree};

const DEPTH: u32 = 4;
const SIDE: i64 = 16;
const NO_BIAS: Bias = Bias { constant_texels: 0.0, slope_texels: 0.0, normal_offset_texels: 0.0 };

struct Space<F>(F);

impl<F: Fn([u32; 3]) -> bool> Classify for Space<F> {
    fn cell(&self, xyz: [u32; 3], _: u32) -> State {
        if (self.0)(xyz) { State::Lit } else { State::Shadowed }
    }

    fn cube(&self, _: [u32; 3], _: u32) -> Option<State> {
        None
    }
}

fn tree(lit: impl Fn([u32; 3]) -> bool) -> VoxelTree {
    TreeBuilder::Pooled.tree(&Space(lit), DEPTH, false).unwrap().number(DEPTH)
}

fn space() -> TreeSpace {
    TreeSpace { p_min: [10.0, -2.0, 5.0], voxel_size: 0.5, depth: DEPTH }
}

fn query(
    tree: &VoxelTree,
    towards: [f64; 3],
    bias: Bias,
    side: u32,
    weights: Weights,
) -> TreeQuery<'_, VoxelTree> {
    let sun = Sun::from_direction(towards).unwrap();
    TreeQuery::new(&space(), &Regions::uniform(DEPTH), &sun, tree, bias, side, weights).unwrap()
}

const UP: [f64; 3] = [0.0, 1.0, 0.0];

#[test]
fn tree_query_worked_values_over_a_floor() {
    // Shadowed below y = 8 voxels, lit from there up; the point is in the lowest lit layer.
    let tree = tree(|[_, y, _]| y >= 8);
    let p_world = space().to_world([6.3, 8.4, 9.1]);
    let at = |side, weights, normal| {
        f64::from(query(&tree, UP, NO_BIAS, side, weights).visibility(p_world, normal))
    };
    for (side, weights, expected) in [
        (1, Weights::Mean, 1.0),
        (3, Weights::Mean, 2.0 / 3.0),
        (5, Weights::Mean, 3.0 / 5.0),
        (3, Weights::Poisson, 12.0 / 16.0),
        (5, Weights::Poisson, 13.0 / 18.0),
    ] {
        assert!((at(side, weights, None) - expected).abs() < 1e-6, "{side} {weights:?}");
        // If the normal is known, taps behind the floor are skipped.
        assert_eq!(at(side, weights, Some(UP)), 1.0);
    }
}

#[test]
fn tree_query_moves_the_point_towards_the_sun() {
    let tree = tree(|[_, y, _]| y >= 8);
    let slanted = [1.0, 1.0, 0.0];
    let p_world = space().to_world([4.0, 7.2, 4.0]);
    let lit = |constant_texels, slope_texels, normal| {
        let bias = Bias { constant_texels, slope_texels, normal_offset_texels: 0.0 };
        query(&tree, slanted, bias, 1, Weights::Mean).visibility(p_world, normal) == 1.0
    };
    // To rise by 0.8 voxels takes 0.8 · √2 along the light.
    assert!(!lit(1.1, 0.0, None));
    assert!(lit(1.2, 0.0, None));
    // At 45 degrees the slope is 1.
    assert!(!lit(0.6, 0.5, Some(UP)));
    assert!(lit(0.6, 0.6, Some(UP)));
    assert!(!lit(0.6, 0.6, None));
    let normal_offset = Bias { constant_texels: 0.0, slope_texels: 0.0, normal_offset_texels: 0.9 };
    assert_eq!(query(&tree, slanted, normal_offset, 1, Weights::Mean).visibility(p_world, Some(UP)), 1.0);
}

#[test]
fn tree_query_outside_the_cube() {
    let tree = tree(|[x, _, _]| x >= 8);
    let at = |towards, p_tree| {
        query(&tree, towards, NO_BIAS, 1, Weights::Mean).visibility(space().to_world(p_tree), None)
    };
    // Sunward of the cube and beside it: lit.
    assert_eq!(at(UP, [3.0, 20.0, 3.0]), 1.0);
    assert_eq!(at(UP, [-1.0, 3.0, 3.0]), 1.0);
    // Behind the cube: the first voxel that its sun ray enters.
    assert_eq!(at(UP, [3.0, -5.0, 3.0]), 0.0);
    assert_eq!(at(UP, [12.0, -5.0, 3.0]), 1.0);
    assert_eq!(at([1.0, 1.0, 0.0], [-4.0, -4.0, 3.0]), 0.0);
    assert_eq!(at([1.0, 1.0, 0.0], [5.0, -5.0, 3.0]), 1.0);
    assert_eq!(at([1.0, 1.0, 0.0], [20.0, -1.0, 3.0]), 1.0);
    assert_eq!(at(UP, [f64::NAN, 1.0, 1.0]), 1.0);
}

#[test]
fn tree_query_ignores_normal_that_is_not_finite() {
    let tree = tree(|[_, y, _]| y >= 8);
    let bias = Bias { normal_offset_texels: 0.5, ..Bias::default() };
    let query = query(&tree, UP, bias, 3, Weights::Mean);
    for y in [3.0, 6.6, 7.5, 9.0] {
        let p_world = space().to_world([6.3, y, 9.1]);
        for bad in [f64::NAN, f64::INFINITY] {
            for normal in [[bad; 3], [0.0, 1.0, bad]] {
                assert_eq!(query.visibility(p_world, Some(normal)), query.visibility(p_world, None), "{y}");
                assert_eq!(query.voxel_size_at(p_world, Some(normal)), 0.5);
            }
        }
    }
}

#[test]
fn tree_query_matches_definition_for_every_tap() {
    // A pattern without symmetry.
    let lit = |[x, y, z]: [u32; 3]| (x * 7 + y * y * 3 + z * 5 + x * z) % 11 < 6;
    let tree = tree(lit);
    let factors = |weights, side: u32| -> Vec<f64> {
        match (weights, side) {
            (Weights::Mean, n) => vec![1.0; n as usize],
            (Weights::Poisson, 1) => vec![8.0],
            (Weights::Poisson, 3) => vec![4.0, 8.0, 4.0],
            (Weights::Poisson, _) => vec![1.0, 4.0, 8.0, 4.0, 1.0],
        }
    };
    let normals = [None, Some([0.6, 0.8, 0.0]), Some([0.0, 0.6, -0.8])];
    for p_tree in [[0.2_f64, 15.9, 7.5], [8.5, 8.5, 8.5], [3.1, 4.9, 12.0], [15.5, 0.5, 0.1]] {
        for normal in normals {
            for weights in [Weights::Mean, Weights::Poisson] {
                for side in [1, 3, 5_u32] {
                    let axis = factors(weights, side);
                    let (mut sum, mut all) = (0.0, 0.0);
                    for i in 0..side.pow(3) {
                        let tap = [i / side / side, i / side % side, i % side];
                        let voxel: [i64; 3] = std::array::from_fn(|a| {
                            p_tree[a].floor() as i64 + i64::from(tap[a]) - i64::from(side / 2)
                        });
                        let ahead = normal.is_none_or(|n| {
                            (0..3).map(|a| n[a] * (voxel[a] as f64 + 0.5 - p_tree[a])).sum::<f64>() >= 0.0
                        });
                        if ahead || tap == [side / 2; 3] {
                            let weight =
                                axis[tap[0] as usize] * axis[tap[1] as usize] * axis[tap[2] as usize];
                            all += weight;
                            let nearest = voxel.map(|c| c.clamp(0, SIDE - 1) as u32);
                            sum += if lit(nearest) { weight } else { 0.0 };
                        }
                    }
                    let answer =
                        query(&tree, UP, NO_BIAS, side, weights).visibility(space().to_world(p_tree), normal);
                    assert!((f64::from(answer) - sum / all).abs() < 1e-6, "{p_tree:?} {normal:?} {side}");
                }
            }
        }
    }
}

#[test]
fn tree_query_refuses_other_kernels() {
    let tree = tree(|_| true);
    let sun = Sun::from_direction(UP).unwrap();
    for side in [0, 2, 4, 7, 9] {
        let made =
            TreeQuery::new(&space(), &Regions::uniform(DEPTH), &sun, &tree, NO_BIAS, side, Weights::Mean);
        assert!(made.unwrap_err().to_string().contains("1, 3 or 5"));
    }
}
