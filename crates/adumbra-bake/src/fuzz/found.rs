//! Regression tests for fuzzer findings, reduced to the smallest scenes that show them. The sun is overhead
//! and a voxel is 1 m, so grid point (x, y, z) is world point (x, -z, y).

use crate::choose;
use crate::options::{AssumeGround, BakeOptions, Size};
use crate::plain::agreement::{BothBuffers, for_each_column};
use adumbra::Bias;
use adumbra::grid::Sun;
use adumbra_scene::{Instance, Material, Mesh, Scene};

/// Builds a scene of triangles given in grid coordinates, instanced `times` times.
fn scene(triangles: &[[[f32; 3]; 3]], times: usize) -> Scene {
    let mesh = Mesh {
        positions: triangles.iter().flatten().map(|&[x, y, z]| [x, -z, y]).collect(),
        triangles: (0..triangles.len() as u32).map(|t| [0, 1, 2].map(|corner| 3 * t + corner)).collect(),
        triangle_materials: vec![0; triangles.len()],
        ..Mesh::default()
    };
    let world_from_mesh = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let instance = Instance { name: String::new(), mesh: 0, world_from_mesh, casts: true };
    Scene {
        meshes: vec![mesh],
        instances: vec![instance; times],
        materials: vec![Material::opaque("grey", [0.5; 4])],
        ..Scene::default()
    }
}

fn assert_builders_agree(scene: &Scene, bias: Bias) {
    let sun = Sun::from_direction([0.0, 1.0, 0.0]).expect("overhead");
    let assume_ground = AssumeGround::Yes;
    let options = BakeOptions { bias, assume_ground, ..BakeOptions::new(sun, Size::VoxelSize(1.0)) };
    let plan = choose::plan(scene, &options).expect("small");
    let (mut buffers, mut undrawn) = (BothBuffers::default(), 0);
    for root_block in 0..plan.root_blocks.count() {
        for_each_column(&plan, root_block, &mut buffers, |column| {
            undrawn += usize::from(!column.drawn);
            assert!(column.agrees(), "{column:?}");
        });
    }
    assert!(undrawn > 0, "blocks that are not drawn are what this is about");
}

/// A normal offset makes look-ups sample columns more than half a texel away, even across a crease.
#[test]
fn builders_agree_on_a_crease_within_the_normal_offset() {
    let crease = [[54.3, 64.0, 26.6], [0.0, 0.0, 39.4]];
    let triangles = [[crease[0], [0.0, 38.4, 1.0], crease[1]], [crease[0], crease[1], [54.3, 0.0, 39.4]]];
    assert_builders_agree(&scene(&triangles, 1), Bias { normal_offset_texels: 0.66, ..Bias::default() });
}

/// Two copies of one solid: the ridge is an edge between two sunward sides, not a seam between solids.
#[test]
fn ridges_of_coincident_solids_are_not_seams() {
    // Just beside the texels' centres, on either side: after snapping, the ridge passes through them.
    for ridge in [31.5 - 0.0015, 31.5 + 0.0015] {
        let [a, b] = [[0.0, ridge, 1.0], [64.0, ridge, 40.0]];
        let [c, d, e, f] = [[0.0, 0.0], [64.0, 0.0], [0.0, 63.0], [64.0, 63.0]].map(|[x, y]| [x, y, 400.0]);
        let [g, h, i] = [[0.0, 0.0], [64.0, 0.0], [64.0, 63.0]].map(|[x, y]| [x, y, 500.0]);
        // Two sides, the gables and the bottom; then a receiver far below.
        let roof = [
            [a, b, d],
            [a, d, c],
            [a, e, f],
            [a, f, b],
            [a, c, e],
            [b, f, d],
            [c, d, f],
            [c, f, e],
            [g, i, h],
        ];
        assert_builders_agree(&scene(&roof, 2), Bias::default());
    }
}

/// Two ramps as one surface, one twice as steep, with a wall between them that does not face the sun. The
/// first ends beside a block, where the offset look-ups of the second reach into it.
#[test]
fn layer_ending_beside_a_block_is_not_smooth_over_it() {
    let ramp = |[y0, y1]: [f32; 2], steepness: f32| {
        let at = |x: f32, y: f32| [x, y, 1.0 + steepness * (x - 40.0)];
        [[at(40.0, y0), at(90.0, y0), at(90.0, y1)], [at(40.0, y0), at(90.0, y1), at(40.0, y1)]]
    };
    let ends = 64.64;
    let wall = [[40.0, ends, 1.0], [90.0, ends, 51.0], [90.0, ends, 101.0]];
    let triangles = [ramp([8.0, ends], 1.0).as_slice(), &[wall], &ramp([ends, 120.0], 2.0)].concat();
    assert_builders_agree(&scene(&triangles, 1), Bias { normal_offset_texels: 0.69, ..Bias::default() });
}
