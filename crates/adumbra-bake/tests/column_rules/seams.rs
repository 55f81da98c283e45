//! Ceilings of many parts: no light passes where the parts meet, although snapping moves corners off a neighbour's
//! edge.

use adumbra::Sun;
use adumbra_bake::{BakeOptions, Size};
use adumbra_scene::random::Random;

use super::model::{Model, Point, bake_quietly, box_corners, lit_on_ground, scene};

const CEILING: f64 = 3.0;
const SIDE: f64 = 20.0;
const OBLIQUE: Point = [0.5, 0.8, 0.35];
const OVERHEAD: Point = [0.0, 1.0, 0.0];

/// Moves a point of a ceiling to where it is in the scene.
type Place = fn(Point) -> Point;
/// A ceiling, and the lines along which its parts meet.
type Ceiling = (Model, Vec<[Point; 2]>);

/// Rotates a ceiling about its centre and tilts it.
fn turned([x, y, z]: Point) -> Point {
    let (sine, cosine) = 0.37_f64.sin_cos();
    let [u, v] = [x - SIDE / 2.0, z - SIDE / 2.0];
    [cosine * u - sine * v + SIDE / 2.0, y + 0.05 * u, sine * u + cosine * v + SIDE / 2.0]
}

/// Checks that no floor point within a texel of a seam's shadow is lit. `seams` are lines of the ceiling.
fn assert_no_pinholes(mut model: Model, seams: &[[Point; 2]], sun: Point, what: &str) {
    model.quad([[-2.0, 0.0, -2.0], [-2.0, 0.0, 22.0], [22.0, 0.0, 22.0], [22.0, 0.0, -2.0]]);
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
fn assert_ceilings_have_no_pinholes(build: fn(Place) -> Ceiling, parts: &str) {
    let (model, seams) = build(|p| p);
    assert_no_pinholes(model, &seams, OBLIQUE, &format!("{parts} along an axis"));
    let (model, seams) = build(turned);
    assert_no_pinholes(model.clone(), &seams, OBLIQUE, &format!("turned {parts}"));
    assert_no_pinholes(model, &seams, OVERHEAD, &format!("turned {parts} under an overhead sun"));
}

/// Builds strips cut at random positions: corners of one are on the next one's edge.
fn strips(place: Place) -> Ceiling {
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

/// Builds solid boxes that touch, with every course offset from the one before.
fn bricks(place: Place) -> Ceiling {
    const COURSES: u32 = 40;
    const LENGTH: f64 = 1.3;
    let (mut model, mut seams) = (Model::default(), Vec::new());
    for course in 0..COURSES {
        let [x0, x1] = [course, course + 1].map(|n| SIDE * f64::from(n) / f64::from(COURSES));
        let shift = LENGTH * (f64::from(course) * 0.382).fract();
        for n in -1..16 {
            let [z0, z1] = [n, n + 1].map(|n| f64::from(n) * LENGTH + shift);
            model.hexahedron(box_corners([x0, CEILING, z0], [x1, CEILING + 0.4, z1]).map(place));
            seams.push([[x0, CEILING, z1], [x1, CEILING, z1]].map(place));
        }
        seams.push([[x1, CEILING, 0.0], [x1, CEILING, SIDE]].map(place));
    }
    (model, seams)
}

#[test]
fn abutting_boxes_have_no_pinholes() {
    assert_ceilings_have_no_pinholes(bricks, "bricks");
}
