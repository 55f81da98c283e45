//! Ceilings of many parts: no light passes where the parts meet, although snapping moves corners off a
//! neighbour's edge.

use adumbra::Sun;
use adumbra_bake::{BakeOptions, FrameChoice, Size};
use adumbra_scene::Instance;
use adumbra_scene::random::Random;

use super::model::{Model, Point, bake_quietly, box_corners, lit_on_ground, scene};

const CEILING: f64 = 3.0;
const SIDE: f64 = 20.0;
const OBLIQUE: Point = [0.5, 0.8, 0.35];
const OVERHEAD: Point = [0.0, 1.0, 0.0];

/// Moves a point of a ceiling to where it is in the scene.
type Placement = fn(Point) -> Point;
/// A ceiling, and the lines along which its parts meet.
type Ceiling = (Model, Vec<[Point; 2]>);

/// Rotates a ceiling about its centre and tilts it.
fn turned([x, y, z]: Point) -> Point {
    let (sine, cosine) = 0.37_f64.sin_cos();
    let [u, v] = [x - SIDE / 2.0, z - SIDE / 2.0];
    [cosine * u - sine * v + SIDE / 2.0, y + 0.05 * u, sine * u + cosine * v + SIDE / 2.0]
}

/// The floor below a ceiling.
const FLOOR: [Point; 4] = [[-2.0, 0.0, -2.0], [-2.0, 0.0, 22.0], [22.0, 0.0, 22.0], [22.0, 0.0, -2.0]];

/// Checks that no floor point within a texel of a seam's shadow is lit. `seams` are lines of the ceiling.
fn assert_no_pinholes(mut model: Model, seams: &[[Point; 2]], sun: Point, what: &str) {
    model.quad(FLOOR);
    let scene = scene(&[model]);
    let sun = Sun::from_direction(sun).unwrap();
    let towards = sun.towards();
    let mut random = Random::for_batch(5, 0);
    for resolution in [512, 2048] {
        let baked = bake_quietly(&scene, &BakeOptions::new(sun, Size::Resolution(resolution)));
        let mut points = Vec::new();
        for [from, to] in seams {
            for _ in 0..200 {
                let along = random.unit();
                let p: Point = std::array::from_fn(|a| from[a] + along * (to[a] - from[a]));
                let mut beside = || 2.0 * baked.grid.voxel_size * (random.unit() - 0.5);
                let [dx, dz] = [beside(), beside()];
                let down = p[1] / towards[1];
                points.push([p[0] - down * towards[0] + dx, 0.0, p[2] - down * towards[2] + dz]);
            }
        }
        // Well away from the ceiling's border.
        points.retain(|[x, _, z]| (4.0..14.0).contains(x) && (4.0..14.0).contains(z));
        assert!(points.len() > 1000, "{what}: {} points", points.len());
        let lit = lit_on_ground(&baked, &points);
        assert_eq!(lit, 0, "{what}, {resolution}: of {} points", points.len());
    }
}

/// Checks ceilings of `parts` along an axis and turned.
fn assert_ceilings_have_no_pinholes(build: fn(Placement) -> Ceiling, parts: &str) {
    let (model, seams) = build(|p| p);
    assert_no_pinholes(model, &seams, OBLIQUE, &format!("{parts} along an axis"));
    let (model, seams) = build(turned);
    assert_no_pinholes(model.clone(), &seams, OBLIQUE, &format!("turned {parts}"));
    assert_no_pinholes(model, &seams, OVERHEAD, &format!("turned {parts} under an overhead sun"));
}

/// Builds strips cut at random positions: corners of one are on the next one's edge.
fn strips(place: Placement) -> Ceiling {
    const STRIPS: u32 = 80;
    let mut random = Random::for_batch(4, 0);
    let (mut model, mut seams) = (Model::default(), Vec::new());
    for strip in 0..STRIPS {
        let [x0, x1] = [strip, strip + 1].map(|n| SIDE * f64::from(n) / f64::from(STRIPS));
        let mut cuts = vec![0.0, SIDE];
        cuts.extend((0..1 + strip % 7).map(|_| SIDE * random.unit()));
        cuts.sort_by(f64::total_cmp);
        for cut in cuts.windows(2) {
            let (a, b) = (cut[0], cut[1]);
            model.quad([[x0, CEILING, a], [x0, CEILING, b], [x1, CEILING, b], [x1, CEILING, a]].map(place));
        }
        seams.push([[x1, CEILING, 0.0], [x1, CEILING, SIDE]].map(place));
    }
    (model, seams)
}

#[test]
fn ceilings_with_t_junctions_have_no_pinholes() {
    assert_ceilings_have_no_pinholes(strips, "strips");
}

/// Returns the least and the largest corner of each brick of a course. Bricks touch, and a course is offset
/// from the one before.
fn course(number: u32, courses: u32, length: f64) -> impl Iterator<Item = [Point; 2]> {
    let [x0, x1] = [number, number + 1].map(|n| SIDE * f64::from(n) / f64::from(courses));
    let shift = length * (f64::from(number) * 0.382).fract();
    (-1..=(SIDE / length) as i32).map(move |n| {
        let [z0, z1] = [n, n + 1].map(|n| f64::from(n) * length + shift);
        [[x0, CEILING, z0], [x1, CEILING + 0.4, z1]]
    })
}

/// Builds solid boxes that touch.
fn bricks(place: Placement) -> Ceiling {
    const COURSES: u32 = 40;
    let (mut model, mut seams) = (Model::default(), Vec::new());
    for number in 0..COURSES {
        for [low, high] in course(number, COURSES, 1.3) {
            model.hexahedron(box_corners(low, high).map(place));
            seams.push([[low[0], CEILING, high[2]], [high[0], CEILING, high[2]]].map(place));
        }
        let x1 = SIDE * f64::from(number + 1) / f64::from(COURSES);
        seams.push([[x1, CEILING, 0.0], [x1, CEILING, SIDE]].map(place));
    }
    (model, seams)
}

#[test]
fn abutting_boxes_have_no_pinholes() {
    assert_ceilings_have_no_pinholes(bricks, "bricks");
}

/// Instances of one mesh have the same components. If no seam were closed, about 20 columns would be lit.
#[test]
fn abutting_instances_have_no_pinholes() {
    const COURSES: u32 = 160;
    let (mut floor, mut cube) = (Model::default(), Model::default());
    floor.quad(FLOOR);
    cube.cuboid([0.0; 3], [1.0; 3]);
    let mut scene = scene(&[floor, cube]);
    let cube = scene.instances.remove(1);
    for [low, high] in (0..COURSES).flat_map(|number| course(number, COURSES, 3.1)) {
        let corners = box_corners(low, high).map(turned);
        let world_from_mesh = std::array::from_fn(|r| {
            let [x, y, z] = [1, 2, 4].map(|corner: usize| corners[corner][r] - corners[0][r]);
            [x, y, z, corners[0][r]]
        });
        scene.instances.push(Instance { world_from_mesh, ..cube.clone() });
    }
    let sun = Sun::from_direction(OVERHEAD).unwrap();
    let frame = FrameChoice::ObliqueAt(0.0);
    let options = BakeOptions::new(sun, Size::Resolution(1024)).with(|o| o.frame = frame);
    let baked = bake_quietly(&scene, &options);
    // The middle of every column well away from the ceiling's border.
    let [nx, ny, _] = baked.grid.size;
    let columns = (0..ny).flat_map(|j| (0..nx).map(move |i| [i, j].map(|c| f64::from(c) + 0.5)));
    let on_floor = columns.map(|[x, y]| {
        let [x, _, z] = baked.grid.to_world([x, y, 0.0]);
        [x, 0.0, z]
    });
    let points: Vec<Point> =
        on_floor.filter(|[x, _, z]| (3.0..17.0).contains(x) && (3.0..17.0).contains(z)).collect();
    assert!(points.len() > 80_000, "{} points", points.len());
    assert_eq!(lit_on_ground(&baked, &points), 0);
}
