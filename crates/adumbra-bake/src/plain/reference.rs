//! Compares the bake with the most direct implementation of §3 of the specification: every triangle at every
//! column, dense voxels.

use std::collections::BTreeMap;

use proptest::prelude::*;

use crate::choose::{self, Choice};
use crate::columns::rules::{ColumnRules, FREE_TO_END};
use crate::options::{AssumeGround, BakeOptions, ColumnBuilder, FrameChoice, Size};
use crate::plan::{Placement, Plan};
use crate::progress::NEVER;
use crate::test_bakes::for_each_column_of;
use crate::triangles::depth::{FixedDepth, SUBTEXEL, fixed_depth, floor_fixed_depth};
use crate::triangles::project::{Projected, SEAM_MARGIN};
use adumbra::grid::{Bounds, Sun};
use adumbra::{Filter, MAX_PLANE_SLOPE, Receivers, ShadowFile};
use adumbra_scene::{Instance, Material, Mesh, Scene, topology};

/// One column of the dense grid, straight from the text of §3.
struct DenseColumn {
    e: u32,
    x: u32,
}

struct GridTriangle {
    projected: Projected,
    solid: bool,
    component: u32,
}

fn grid_triangles(scene: &Scene, plan: &Plan<'_>, closed_regions: bool) -> Vec<GridTriangle> {
    let mut all = Vec::new();
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh as usize];
        let shape = topology::analyse(mesh, &scene.materials);
        for (t, corners) in mesh.triangles.iter().enumerate() {
            let corners =
                corners.map(|v| plan.root_blocks.grid.to_grid(instance.to_world(mesh.positions[v as usize])));
            let projected = Projected::new(corners, instance.determinant() < 0.0);
            all.push(GridTriangle {
                projected,
                solid: closed_regions && shape.is_solid(t),
                component: shape.component_of_triangle[t],
            });
        }
    }
    all
}

/// Computes one column directly from the specification; depths in 1/256 voxel.
fn dense_column(triangles: &[GridTriangle], rules: &ColumnRules, i: i64, j: i64) -> DenseColumn {
    let n = rules.depth_voxels;
    let (x, y) = (i as f64 + 0.5, j as f64 + 0.5);
    let center = [x, y];
    // Open surfaces are grown by the seam width. A solid's sunward side is grown where another solid's meets
    // it.
    let mut hits: Vec<(FixedDepth, bool, &GridTriangle)> = Vec::new();
    let mut seams: Vec<(FixedDepth, FixedDepth, u32)> = Vec::new();
    for t in triangles {
        let Some(plane) = t.projected.plane else { continue };
        let covers = |margin: i64| {
            let (first, last) = t.projected.span(j, margin);
            let (top, bottom) = t.projected.rows(margin);
            (first..=last).contains(&i) && (top..=bottom).contains(&j)
        };
        let depth = t.projected.depth_at(&plane, x, y);
        if covers(if t.solid { 0 } else { SEAM_MARGIN }) {
            hits.push((depth, !t.projected.faces_sun, t));
        } else if t.projected.faces_sun && covers(SEAM_MARGIN) {
            seams.push((depth, rules.bias_fixed(t.projected.slope), t.component));
        }
    }
    let covers_exactly =
        |component: u32| hits.iter().any(|(_, leaves, t)| t.solid && !leaves && t.component == component);
    seams.retain(|s| !covers_exactly(s.2));
    seams.sort_unstable();
    let seam = seams.iter().find(|s| s.2 != seams[0].2).copied();
    let sampled = hits.iter().map(|h| h.0).min();
    let Some(entry) = [sampled, seam.map(|s| s.0)].into_iter().flatten().min() else {
        return DenseColumn { e: n, x: FREE_TO_END };
    };
    let at_entry = || hits.iter().filter(|h| h.0 == entry);
    let solid_first = at_entry().any(|h| h.2.solid);
    let biases = at_entry()
        .filter(|h| h.2.solid == solid_first)
        .map(|h| rules.bias_fixed(h.2.projected.slope))
        .chain(seam.filter(|s| s.0 == entry && !solid_first).map(|s| s.1));
    let bias = biases.min().unwrap_or_default();
    // Signed winding; entries sort before exits at equal depth.
    let mut crossings: Vec<_> = hits.iter().filter(|h| h.2.solid).map(|h| (h.0, h.1)).collect();
    crossings.sort_unstable();
    let mut winding = 0;
    let mut end = None;
    for (depth, leaves) in crossings {
        winding += if leaves { -1 } else { 1 };
        if leaves && winding <= 0 {
            end = Some(depth);
            break;
        }
    }
    let solid_end = if solid_first { end } else { None };
    let base = solid_end.unwrap_or(entry);
    // The nearest lifted point, behind the first surface, of a receiver in the footprint whose plane is
    // behind the base.
    let mut next: Option<FixedDepth> = None;
    for t in triangles.iter().filter(|t| !t.solid || t.projected.faces_sun) {
        let Some(plane) = t.projected.true_plane().filter(|p| p.slope() <= MAX_PLANE_SLOPE) else { continue };
        if !is_near(&t.projected, FOOTPRINT_HALF, x, y) {
            continue;
        }
        let z = plane.at(x, y);
        let rounding = 1.0 / 256.0 + (plane.gradient_sum() + 1.0) / 4096.0;
        let lifted = floor_fixed_depth(z - rules.bias.along_light(plane.slope()) - rounding);
        // Excludes the foot of a wall that stands on the first surface: some of the receiver must be behind,
        // at the centre or beside it.
        let sinks = if solid_end.is_some() { 0 } else { bias };
        let (first, last) = t.projected.span(j, 0);
        let (top, bottom) = t.projected.rows(0);
        let covers = (first..=last).contains(&i) && (top..=bottom).contains(&j);
        let part = fixed_depth(t.projected.deepest_within(&plane, [x, y], FOOTPRINT_HALF));
        if fixed_depth(z) > base && lifted > entry && (covers || part > base + sinks) {
            next = Some(next.map_or(lifted, |n| n.min(lifted)));
        }
    }
    // Unless a ground is assumed, level ground right behind a solid's end is such a receiver, and so are
    // points that sample an open surface's shadow.
    if let Some(lift) = rules.level_lift {
        let open_exit = entry + rules.thickness.max(bias);
        let below = solid_end.map_or(open_exit, |end| end - lift).max(entry + SUBTEXEL as FixedDepth);
        next = Some(next.map_or(below, |n| n.min(below)));
    }
    let voxel = |depth: FixedDepth| {
        let voxels = f64::from(depth) / SUBTEXEL as f64;
        (voxels - 0.5).ceil().clamp(0.0, f64::from(n)) as u32
    };
    let exit = match (solid_end, next) {
        (_, None) if entry >= 0 => None,
        (Some(end), _) => Some(end),
        (None, _) => Some(entry + rules.thickness.max(bias)),
    };
    let e = voxel(entry);
    let x = exit.map_or(FREE_TO_END, |exit| voxel(exit).max(e));
    let x = if x >= n { FREE_TO_END } else { x };
    let [e, x] = match next {
        None => [e, x],
        Some(next) => {
            let asked = (next.div_euclid(SUBTEXEL as FixedDepth).max(0) as u32).min(n - 1);
            // Look-ups from the first surface, or from points before it, sample at least the constant bias
            // before it.
            let before = f64::from(entry) / SUBTEXEL as f64 - rules.bias.constant_texels;
            let asked = asked.max((before.floor() + 1.0).clamp(0.0, f64::from(n)) as u32);
            [e.min(asked), x.min(asked)]
        }
    };
    DenseColumn { e, x: filtered_end(triangles, rules, [e, x], center) }
}

/// Returns x, or the nearest voxel in which a filter around a receiver near the column's centre must find
/// shadow.
fn filtered_end(triangles: &[GridTriangle], rules: &ColumnRules, [e, x]: [u32; 2], center: [f64; 2]) -> u32 {
    let mut end = x;
    for t in triangles.iter().filter(|t| !t.solid || t.projected.faces_sun) {
        let Some(plane) = t.projected.true_plane().filter(|p| p.slope() <= MAX_PLANE_SLOPE) else { continue };
        // Taps are up to four texels from the point; rounding moves their depth by half a step of the
        // gradient each.
        let rounding = 4.5 / 256.0 + 1.0 / 256.0 + (plane.gradient_sum() + 1.0) / 4096.0;
        let lifted = plane.at(center[0], center[1]) - rules.bias.along_light(plane.slope()) - rounding;
        let voxel = (lifted - 0.5 / SUBTEXEL as f64).clamp(0.0, f64::from(rules.depth_voxels) - 1.0) as u32;
        for (reach, behind) in [(0.5, 2), (2.0, 6), (4.0, 24)] {
            // The builder grows snapped triangles.
            if voxel >= e + behind && is_near(&t.projected, 0.5 + reach - 1.0 / 128.0, center[0], center[1]) {
                end = end.min(voxel + u32::from(voxel < rules.depth_voxels - 1 && fract_is_close(lifted)));
            }
        }
    }
    end
}

/// Whether a depth is so close to a voxel's end that fixed point may take it for the next.
fn fract_is_close(voxels: f64) -> bool {
    (voxels - voxels.round()).abs() < 2.0 / SUBTEXEL as f64
}

/// Half a texel, and 1/256 for snapping.
const FOOTPRINT_HALF: f64 = 0.5 + 1.0 / 256.0;

/// Whether a triangle touches a texel's footprint.
fn is_near(t: &Projected, half: f64, x: f64, y: f64) -> bool {
    t.x_range_in_band(y, half).is_some_and(|[low, high]| low <= x + half && high >= x - half)
}

fn add_box(mesh: &mut Mesh, low: [f32; 3], high: [f32; 3]) {
    let first = mesh.positions.len() as u32;
    for corner in 0..8_usize {
        let pick = |a: usize| if corner >> a & 1 == 0 { low[a] } else { high[a] };
        mesh.positions.push([pick(0), pick(1), pick(2)]);
    }
    let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    for [a, b, c, d] in faces {
        mesh.triangles.push([first + a, first + b, first + c]);
        mesh.triangles.push([first + a, first + c, first + d]);
    }
}

fn scene_of(mesh: Mesh, mirrored: bool) -> Scene {
    let x = if mirrored { -1.0 } else { 1.0 };
    let count = mesh.triangles.len();
    Scene {
        meshes: vec![Mesh { triangle_materials: vec![0; count], ..mesh }],
        instances: vec![Instance {
            name: String::new(),
            mesh: 0,
            world_from_mesh: [[x, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
            casts: true,
        }],
        materials: vec![Material::opaque("grey", [0.5, 0.5, 0.5, 1.0])],
        ..Scene::default()
    }
}

prop_compose! {
    fn any_box()(low in prop::array::uniform3(-8.0_f32..8.0), size in prop::array::uniform3(0.1_f32..6.0)) -> ([f32; 3], [f32; 3]) {
        (low, [low[0] + size[0], low[1] + size[1], low[2] + size[2]])
    }
}

prop_compose! {
    fn any_scene()(
        boxes in prop::collection::vec(any_box(), 0..5),
        loose in prop::collection::vec(prop::array::uniform3(prop::array::uniform3(-9.0_f32..9.0)), 1..6),
        woven in prop::collection::vec(prop::array::uniform3((0..4_u8, 0..4_u8, 0..4_u8)), 0..24),
        needles in prop::collection::vec((prop::array::uniform3(-9.0_f32..9.0), prop::array::uniform3(-9.0_f32..9.0)), 0..4),
        ground in any::<bool>(),
        mirrored in any::<bool>(),
    ) -> Scene {
        let mut mesh = Mesh::default();
        // Triangles with few vertices share edges in every way: open, closed, folded, more than two at an
        // edge.
        for corners in woven.iter().filter(|c| c[0] != c[1] && c[1] != c[2] && c[2] != c[0]) {
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(corners.map(|(x, y, z)| [x, y, z].map(|c| f32::from(c) * 3.0 - 4.5)));
            mesh.triangles.push([first, first + 1, first + 2]);
        }
        for (from, to) in needles {
            let first = mesh.positions.len() as u32;
            mesh.positions.extend([from, to, to.map(|c| c + 1e-3)]);
            mesh.triangles.push([first, first + 1, first + 2]);
        }
        for (low, high) in boxes {
            add_box(&mut mesh, low, high);
        }
        for corners in loose {
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(corners);
            mesh.triangles.push([first, first + 1, first + 2]);
        }
        if ground {
            let first = mesh.positions.len() as u32;
            mesh.positions.extend([[-10.0, -8.5, -10.0], [-10.0, -8.5, 10.0], [10.0, -8.5, 10.0], [10.0, -8.5, -10.0]]);
            mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
        scene_of(mesh, mirrored)
    }
}

prop_compose! {
    fn any_options(most_level: u32)(
        sun in (-1.0_f64..1.0, 0.02_f64..1.0, -1.0_f64..1.0),
        level in 3_u32..=most_level,
        thickness_world in prop_oneof![Just(0.0), 0.0_f64..4.0],
        assume_ground in any::<bool>(),
        closed_regions in any::<bool>(),
        switch_within_voxels in prop_oneof![Just(0), 0_u32..12],
        bounds in prop::option::of(any_box()),
        fast in any::<bool>(),
        frame in prop_oneof![
            Just(FrameChoice::Light),
            Just(FrameChoice::Oblique),
            (-3.0_f64..3.0).prop_map(FrameChoice::ObliqueAt),
            Just(FrameChoice::Auto),
        ],
    ) -> BakeOptions {
        let sun = Sun::from_direction([sun.0, sun.1, sun.2]).expect("a sun above the horizon");
        BakeOptions {
            thickness_world,
            assume_ground: assume_ground.into(),
            closed_regions,
            switch_within_voxels,
            bounds: bounds.map(|(min, max)| Bounds { min: min.map(f64::from), max: max.map(f64::from) }),
            builder: if fast { ColumnBuilder::Fast } else { ColumnBuilder::Plain },
            frame,
            ..BakeOptions::new(sun, Size::Resolution(1 << level))
        }
    }
}

fn bake_quietly(scene: &Scene, options: &BakeOptions) -> ShadowFile {
    crate::Bake::with_options(scene, options).in_memory().expect("a small bake fits")
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    #[ignore = "slow: compares every voxel"]
    fn file_equals_dense_grid_on_every_defined_voxel(scene in any_scene(), options in any_options(8)) {
        equals_dense_grid(&scene, &options)?;
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 8, ..ProptestConfig::default() })]

    #[test]
    fn small_file_equals_dense_grid_on_every_defined_voxel(scene in any_scene(), options in any_options(6)) {
        equals_dense_grid(&scene, &options)?;
    }
}

fn equals_dense_grid(scene: &Scene, options: &BakeOptions) -> Result<(), TestCaseError> {
    let baked = bake_quietly(scene, options);
    let plan = choose::plan(scene, options).expect("the bake had one");
    let triangles = grid_triangles(scene, &plan, options.closed_regions);
    let [nx, ny, nz] = baked.tree.size();
    for j in 0..ny {
        for i in 0..nx {
            let column = dense_column(&triangles, &plan.root_blocks.rules, i.into(), j.into());
            for k in 0..nz {
                let lit = baked.tree.voxel(i, j, k);
                prop_assert!(k >= column.e || lit, "({i}, {j}, {k}) is defined lit, e = {}", column.e);
                prop_assert!(k < column.x || !lit, "({i}, {j}, {k}) is defined shadowed, x = {}", column.x);
            }
        }
    }
    Ok(())
}

#[test]
fn bake_does_not_depend_on_threads_or_triangle_order() {
    let mut mesh = Mesh::default();
    for n in 0..12_u8 {
        let at = f32::from(n);
        add_box(
            &mut mesh,
            [at * 1.3 - 8.0, -1.0, at * 0.7 - 4.0],
            [at * 1.3 - 7.1, at * 0.4, at * 0.7 - 2.9],
        );
    }
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).expect("above the horizon");
    let options = BakeOptions::new(sun, Size::Resolution(256));
    let reference = bake_quietly(&scene_of(mesh.clone(), false), &options).tree;
    let mut reversed = mesh.clone();
    reversed.triangles.reverse();
    assert_eq!(reference, bake_quietly(&scene_of(reversed, false), &options).tree);
    let mut rotated = mesh.clone();
    for t in &mut rotated.triangles {
        t.rotate_left(1);
    }
    assert_eq!(reference, bake_quietly(&scene_of(rotated, false), &options).tree);
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a small pool");
        assert_eq!(reference, pool.install(|| bake_quietly(&scene_of(mesh.clone(), false), &options).tree));
    }
    let tight = BakeOptions { max_memory_bytes: Some(80 << 20), ..options };
    assert_eq!(reference, bake_quietly(&scene_of(mesh, false), &tight).tree);
}

/// Uses two low boxes beside two high ones, which meet where four root blocks do. Filters around the tops of
/// the low ones read columns of the high ones, across the borders.
#[test]
fn columns_do_not_depend_on_where_root_blocks_begin() {
    let mut mesh = Mesh::default();
    add_box(&mut mesh, [0.03125, 0.0, 0.03125], [2.0, 1.0, 2.0]);
    let mut scene = scene_of(mesh, false);
    let place = |x: f64, height: f64, z: f64| Instance {
        world_from_mesh: [[x, 0.0, 0.0, 0.0], [0.0, height, 0.0, 0.0], [0.0, 0.0, z, 0.0]],
        ..scene.instances[0].clone()
    };
    scene.instances =
        vec![place(-1.0, 2.0, -1.0), place(1.0, 0.5, -1.0), place(-1.0, 0.5, 1.0), place(1.0, 2.0, 1.0)];
    let sun = Sun::from_angles(0.0, 90.0).expect("overhead");
    let options = BakeOptions {
        frame: FrameChoice::ObliqueAt(0.0),
        bounds: Some(Bounds { min: [-4.0, -1.0, -4.0], max: [4.0, 3.0, 4.0] }),
        builder: ColumnBuilder::Plain,
        ..BakeOptions::new(sun, Size::VoxelSize(0.125))
    };
    let Choice { clusters, levels, .. } = Choice::new(&scene, &options, &NEVER).expect("a small bake");
    let [four, one] = [5, 6].map(|root_level| {
        let placement = Placement { root_level, ..levels[0] };
        let root_blocks =
            Plan::placed(&scene, &options, placement, &clusters, None).expect("a small plan").root_blocks;
        let mut columns = BTreeMap::new();
        for_each_column_of(&root_blocks, |i, j, column| _ = columns.insert([i, j], column));
        (root_blocks.count(), columns)
    });
    assert_eq!((four.0, one.0), (4, 1));
    assert!(four.1 == one.1);
}

#[test]
fn closed_box_leaves_its_inside_free_and_its_shadow_defined() {
    let mut mesh = Mesh::default();
    add_box(&mut mesh, [-1.0, 0.0, -1.0], [1.0, 2.0, 1.0]);
    let scene = scene_of(mesh, false);
    let sun = Sun::from_angles(0.0, 90.0).expect("overhead");
    let options =
        BakeOptions { assume_ground: AssumeGround::No, ..BakeOptions::new(sun, Size::Resolution(16)) };
    let plan = choose::plan(&scene, &options).expect("a small plan");
    let triangles = grid_triangles(&scene, &plan, true);
    // 16 texels over 2 m. The roof is 16 voxels above the world's origin, and the page before it begins
    // at 24. Look-ups from level ground right below the box sample one voxel before it, and may round
    // down.
    let column = dense_column(&triangles, &plan.root_blocks.rules, 8, 8);
    assert_eq!((column.e, column.x), (8, 22));
    let tree = bake_quietly(&scene, &options).tree;
    assert!(tree.voxel(8, 8, 7));
    assert!(!tree.voxel(8, 8, 22));
}

#[test]
fn surfaces_that_do_not_cast_still_receive() {
    let mut roof = Mesh::default();
    add_box(&mut roof, [-2.0, 4.0, -2.0], [2.0, 4.2, 2.0]);
    let mut scene = scene_of(roof, false);
    let ground = Mesh {
        positions: vec![[-10.0, 0.0, -10.0], [-10.0, 0.0, 10.0], [10.0, 0.0, 10.0], [10.0, 0.0, -10.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        triangle_materials: vec![0; 2],
        ..Mesh::default()
    };
    scene.meshes.push(ground);
    let under = Instance { mesh: 1, casts: false, ..scene.instances[0].clone() };
    scene.instances.push(under);
    let sun = Sun::from_direction([0.3, 0.9, 0.2]).expect("above the horizon");
    for receivers in [Receivers::All, Receivers::Static] {
        let baked =
            bake_quietly(&scene, &BakeOptions { receivers, ..BakeOptions::new(sun, Size::Resolution(256)) });
        let sampler = baked.sampler(Filter::Nearest);
        let mut shadowed = 0;
        for i in 0..200 {
            for j in 0..200 {
                let p = [f64::from(i) * 0.1 - 9.95, 0.0, f64::from(j) * 0.1 - 9.95];
                // Where the sun ray crosses the roof's height, away from its rim.
                let across = [p[0] + 4.1 / 0.9 * 0.3, p[2] + 4.1 / 0.9 * 0.2];
                let answer = sampler.visibility(p, Some([0.0, 1.0, 0.0]));
                if across.iter().all(|c| c.abs() < 1.6) {
                    assert_eq!(answer, 0.0, "{receivers:?} {p:?}");
                    shadowed += 1;
                } else if across.iter().any(|c| c.abs() > 2.4) {
                    assert_eq!(answer, 1.0, "{receivers:?} {p:?}");
                }
            }
        }
        assert!(shadowed > 500);
    }
}

#[test]
#[ignore = "slow: takes over eight seconds"]
fn many_thin_layers_in_one_row_are_captured() {
    let mut mesh = Mesh::default();
    for layer in 0..20_000_u16 {
        let y = f32::from(layer) * 0.01;
        add_box(&mut mesh, [-10.0, y, -10.0], [10.0, y + 0.005, 10.0]);
    }
    let sun = Sun::from_angles(0.0, 90.0).expect("overhead");
    let baked = bake_quietly(&scene_of(mesh, false), &BakeOptions::new(sun, Size::Resolution(64)));
    assert!(baked.tree.voxel(32, 32, 0));
}
