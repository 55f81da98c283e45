//! Polygons of OBJ and PLY files: their triangles must cover exactly the polygon.

use adumbra::{Filter, Sun};
use adumbra_bake::{Bake, BakeOptions, Size};
use adumbra_scene::{LoadOptions, Scene, topology};

use crate::kit::load_bytes;

type Flat = [f64; 2];
type Ring = Vec<Flat>;

fn ring(corners: &[[i32; 2]]) -> Ring {
    corners.iter().map(|c| c.map(f64::from)).collect()
}

/// An L-shaped polygon.
fn l_shape() -> Ring {
    ring(&[[0, 0], [10, 0], [10, 4], [4, 4], [4, 10], [0, 10]])
}

/// A square with a square window, as a single polygon: an edge leads to the window and back.
fn keyhole() -> Ring {
    ring(&[[0, 0], [3, 3], [3, 7], [7, 7], [7, 3], [3, 3], [0, 0], [10, 0], [10, 10], [0, 10]])
}

/// A square with two windows, each at the end of its own edge.
fn two_windows() -> Ring {
    let left = [[0, 0], [1, 1], [1, 3], [3, 3], [3, 1], [1, 1], [0, 0]];
    let right = [[10, 0], [9, 1], [7, 1], [7, 3], [9, 3], [9, 1], [10, 0]];
    ring(&[&left[..], &right, &[[10, 10], [0, 10]]].concat())
}

/// A comb with this many teeth.
fn comb(teeth: i32) -> Ring {
    let mut corners = vec![[0, 0], [2 * teeth, 0]];
    for tooth in (0..teeth).rev() {
        corners.extend([[2 * tooth + 2, 10], [2 * tooth + 1, 10], [2 * tooth + 1, 1], [2 * tooth, 1]]);
    }
    // The last step down ends on the left side, where the ring closes.
    ring(&corners)
}

fn spiral() -> Ring {
    ring(&[
        [0, 0],
        [12, 0],
        [12, 12],
        [2, 12],
        [2, 4],
        [8, 4],
        [8, 8],
        [6, 8],
        [6, 6],
        [4, 6],
        [4, 10],
        [10, 10],
        [10, 2],
        [0, 2],
    ])
}

/// A slit that is far narrower than the polygon.
fn slit() -> Ring {
    let width = 1.0 / 65_536.0;
    vec![[0.0, 0.0], [8.0, 0.0], [8.0, 8.0], [4.0 + width, 8.0], [4.0, 1.0], [4.0 - width, 8.0], [0.0, 8.0]]
}

/// An L with corners in the middle of its edges.
fn l_with_corners_on_edges() -> Ring {
    ring(&[
        [0, 0],
        [5, 0],
        [7, 0],
        [10, 0],
        [10, 1],
        [10, 4],
        [6, 4],
        [4, 4],
        [4, 6],
        [4, 10],
        [0, 10],
        [0, 4],
    ])
}

fn arrow() -> Ring {
    ring(&[[0, 0], [4, 2], [0, 4], [1, 2]])
}

fn cases() -> Vec<(&'static str, Ring)> {
    vec![
        ("L", l_shape()),
        ("keyhole", keyhole()),
        ("two windows", two_windows()),
        ("comb", comb(20)),
        ("spiral", spiral()),
        ("slit", slit()),
        ("corners on edges", l_with_corners_on_edges()),
        ("arrow", arrow()),
    ]
}

fn doubled_area(ring: &[Flat]) -> f64 {
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).map(|(p, q)| p[0] * q[1] - p[1] * q[0]).sum()
}

fn is_inside(ring: &[Flat], p: Flat) -> bool {
    let next = ring.iter().cycle().skip(1);
    let crossed = ring.iter().zip(next).filter(|(a, b)| {
        (a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
    });
    crossed.count() % 2 == 1
}

/// A plane in space: the slopes that give the third coordinate, and the assignment of the axes.
#[derive(Clone, Copy)]
struct Plane {
    slopes: Flat,
    axis: usize,
}

impl Plane {
    const ALL: [Self; 6] = [
        Self { slopes: [0.0, 0.0], axis: 0 },
        Self { slopes: [0.5, -0.25], axis: 0 },
        Self { slopes: [0.0, 0.0], axis: 1 },
        Self { slopes: [-2.0, 0.5], axis: 1 },
        Self { slopes: [0.5, 0.5], axis: 2 },
        Self { slopes: [1.0, 4.0], axis: 2 },
    ];

    fn place(self, p: Flat) -> [f32; 3] {
        let mut out = [0.0; 3];
        out[self.axis] = (3.0 + p[0] * self.slopes[0] + p[1] * self.slopes[1]) as f32;
        out[(self.axis + 1) % 3] = p[0] as f32;
        out[(self.axis + 2) % 3] = p[1] as f32;
        out
    }

    fn flat(self, p: [f32; 3]) -> Flat {
        [p[(self.axis + 1) % 3], p[(self.axis + 2) % 3]].map(f64::from)
    }
}

fn obj(polygons: &[Vec<[f32; 3]>]) -> Scene {
    let (mut text, mut faces, mut next) = (String::new(), String::new(), 1);
    for polygon in polygons {
        polygon.iter().for_each(|p| text += &format!("v {} {} {}\n", p[0], p[1], p[2]));
        faces += "f";
        (next..next + polygon.len()).for_each(|i| faces += &format!(" {i}"));
        faces += "\n";
        next += polygon.len();
    }
    load_bytes("scene.obj", (text + &faces).as_bytes(), &LoadOptions::default()).expect("loads")
}

fn ply(polygons: &[Vec<[f32; 3]>]) -> Scene {
    let corners: Vec<[f32; 3]> = polygons.concat();
    let mut out = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list ushort int vertex_indices\nend_header\n",
        corners.len(),
        polygons.len()
    )
    .into_bytes();
    out.extend(corners.iter().flatten().flat_map(|c| c.to_le_bytes()));
    let mut next = 0_i32;
    for polygon in polygons {
        out.extend((polygon.len() as u16).to_le_bytes());
        let end = next + polygon.len() as i32;
        out.extend((next..end).flat_map(i32::to_le_bytes));
        next = end;
    }
    load_bytes("scene.ply", &out, &LoadOptions::default()).expect("loads")
}

type Load = fn(&[Vec<[f32; 3]>]) -> Scene;
const LOADERS: [(&str, Load); 2] = [("OBJ", obj), ("PLY", ply)];

fn triangles(scene: &Scene, plane: Plane) -> Vec<[Flat; 3]> {
    let mesh = &scene.meshes[0];
    mesh.triangles.iter().map(|t| t.map(|i| plane.flat(mesh.positions[i as usize]))).collect()
}

/// Checks that every triangle has the ring's winding, that the areas of the triangles sum to the ring's, and
/// that each point of a grid is in one triangle if it is inside the ring, else in none.
fn assert_covers(name: &str, ring: &[Flat], triangles: &[[Flat; 3]]) {
    let whole = doubled_area(ring);
    let areas: Vec<f64> = triangles.iter().map(|t| doubled_area(t)).collect();
    assert!(areas.iter().all(|a| a * whole > 0.0), "{name}: a triangle is turned over");
    let sum: f64 = areas.iter().sum();
    assert!((sum - whole).abs() <= 1e-6 * whole.abs(), "{name}: area {sum}, not {whole}");
    let side = ring.iter().flatten().fold(0.0_f64, |a, &b| a.max(b));
    for i in 0..40 {
        for j in 0..40 {
            let p = [f64::from(i) + 0.317_231, f64::from(j) + 0.713_907].map(|c| c * side / 40.0);
            let hits = triangles.iter().filter(|t| is_inside(&t[..], p)).count();
            assert_eq!(hits, usize::from(is_inside(ring, p)), "{name} at {p:?}");
        }
    }
}

#[test]
fn polygons_are_covered_from_every_corner_in_both_windings() {
    for (name, ring) in cases() {
        for (start, plane) in (0..ring.len()).zip(Plane::ALL.into_iter().cycle()) {
            for reversed in [false, true] {
                let mut turned = ring.clone();
                turned.rotate_left(start);
                if reversed {
                    turned.reverse();
                }
                let polygon: Vec<[f32; 3]> = turned.iter().map(|&p| plane.place(p)).collect();
                for (format, load) in LOADERS {
                    let scene = load(std::slice::from_ref(&polygon));
                    let name = format!("{format} {name} from corner {start}, reversed: {reversed}");
                    assert_covers(&name, &turned, &triangles(&scene, plane));
                    assert_eq!(scene.notes.untriangulated_polygons, 0, "{name}");
                }
            }
        }
    }
}

#[test]
fn polygons_of_many_shapes_are_covered() {
    // Corners around a centre at random distances: simple polygons that are as concave as possible.
    let mut state = 0x9e37_79b9_u64;
    let mut random = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / f64::from(1 << 24)
    };
    for round in 0..60 {
        let corners = 4 + (random() * 40.0) as usize;
        let plane = Plane::ALL[round % 6];
        let ring: Ring = (0..corners)
            .map(|i| {
                let angle = std::f64::consts::TAU * (i as f64 + 0.8 * random()) / corners as f64;
                let far = 1.0 + 9.0 * random();
                [10.0 + far * angle.cos(), 10.0 + far * angle.sin()].map(|c| (c * 64.0).round() / 64.0)
            })
            .collect();
        let polygon: Vec<[f32; 3]> = ring.iter().map(|&p| plane.place(p)).collect();
        let scene = obj(&[polygon]);
        assert_covers(&format!("round {round}, {corners} corners"), &ring, &triangles(&scene, plane));
    }
}

#[test]
fn polygons_keep_the_corners_on_their_edges() {
    // A prism is closed only if each edge of its floor and roof matches an edge of the walls.
    let square = ring(&[[0, 0], [2, 0], [4, 0], [4, 4], [2, 4], [0, 4], [0, 1]]);
    for ring in [l_with_corners_on_edges(), l_shape(), comb(5), square] {
        for start in 0..ring.len() {
            let mut turned = ring.clone();
            turned.rotate_left(start);
            let at = |height: f64| move |p: &Flat| [p[0], height, p[1]].map(|c| c as f32);
            let (floor, roof) = (at(0.0), at(5.0));
            let next = turned.iter().cycle().skip(1);
            let mut faces: Vec<Vec<[f32; 3]>> =
                turned.iter().zip(next).map(|(a, b)| vec![floor(a), roof(a), roof(b), floor(b)]).collect();
            faces.push(turned.iter().map(floor).collect());
            faces.push(turned.iter().rev().map(roof).collect());
            let scene = obj(&faces);
            let shape = topology::analyse(&scene.meshes[0], &scene.materials);
            let closed = shape.components.iter().filter(|c| c.closed).count();
            assert_eq!((closed, shape.components.len()), (1, 1), "from corner {start} of {}", ring.len());
        }
    }
}

#[test]
fn polygons_that_a_fan_covers_keep_their_fan() {
    let flat = Plane::ALL[0];
    let fans = [
        ring(&[[0, 0], [4, 0], [0, 4]]),
        ring(&[[0, 0], [4, 0], [5, 3], [0, 4]]),
        ring(&[[0, 0], [3, 0], [5, 2], [5, 4], [2, 5], [0, 3]]),
        // Concave, but entirely visible from the first corner.
        ring(&[[1, 2], [0, 0], [4, 2], [0, 4]]),
    ];
    for ring in fans {
        for (format, load) in LOADERS {
            let scene = load(&[ring.iter().map(|&p| flat.place(p)).collect()]);
            let fan: Vec<[u32; 3]> = (2..ring.len() as u32).map(|i| [0, i - 1, i]).collect();
            assert_eq!(scene.meshes[0].triangles, fan, "{format}");
            assert_eq!(scene.notes.untriangulated_polygons, 0, "{format}");
        }
    }
}

#[test]
fn self_intersecting_polygons_are_counted() {
    let flat = Plane::ALL[0];
    let bow_tie = ring(&[[0, 0], [4, 4], [4, 0], [0, 4]]);
    let star = ring(&[[0, 4], [10, 4], [2, 10], [5, 0], [8, 10]]);
    for ring in [bow_tie, star] {
        for (format, load) in LOADERS {
            let polygon: Vec<[f32; 3]> = ring.iter().map(|&p| flat.place(p)).collect();
            let scene = load(&[polygon.clone(), l_shape().iter().map(|&p| flat.place(p)).collect(), polygon]);
            assert_eq!(scene.notes.untriangulated_polygons, 2, "{format}");
            assert_eq!(scene.stored_triangles() as usize, 2 * (ring.len() - 2) + 4, "{format}");
        }
    }
}

#[test]
fn polygons_without_area_are_degenerate_triangles() {
    let line = vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]];
    for (format, load) in LOADERS {
        let scene = load(&[line.clone(), vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]]);
        let notes = &scene.notes;
        assert_eq!((notes.degenerate_triangles, notes.untriangulated_polygons), (2, 0), "{format}");
    }
}

#[test]
fn polygons_cast_their_own_shadow() {
    let ground = vec![[-5.0, 0.0, -5.0], [-5.0, 0.0, 15.0], [15.0, 0.0, 15.0], [15.0, 0.0, -5.0]];
    let sun = Sun::from_direction([0.0, 1.0, 0.0]).expect("a sun");
    for (ring, name) in [(l_shape(), "L"), (keyhole(), "keyhole")] {
        let roof: Vec<[f32; 3]> = ring.iter().map(|p| [p[0] as f32, 3.0, p[1] as f32]).collect();
        for (format, load) in LOADERS {
            let scene = load(&[ground.clone(), roof.clone()]);
            let options = BakeOptions::new(sun, Size::Resolution(256));
            let file = Bake::with_options(&scene, &options).in_memory().expect("bakes");
            let sampler = file.sampler(Filter::Nearest);
            for i in 0..20 {
                for j in 0..20 {
                    let p = [i, j].map(|i| 0.25 + 0.5 * f64::from(i));
                    let visibility = sampler.visibility([p[0], 0.0, p[1]], Some([0.0, 1.0, 0.0]));
                    let expected = if is_inside(&ring, p) { 0.0 } else { 1.0 };
                    assert_eq!(visibility, expected, "{format} {name} at {p:?}");
                }
            }
        }
    }
}
