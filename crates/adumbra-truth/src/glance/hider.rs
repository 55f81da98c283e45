//! Finds parts of a scene that hide the sun from nearly everything else, such as a sky dome.

use std::collections::{BTreeMap, BTreeSet};

use adumbra::grid::vec3::{cross, dot};
use adumbra_scene::Scene;
use adumbra_scene::random::Random;

use crate::glance::pencil::{Pencil, corners};

/// Number of points to sample on surfaces.
const POINTS: usize = 256;
/// Minimum share of the points that must be on other parts. With fewer points, the hidden share means
/// nothing.
const LEAST_OTHERS: f64 = 0.1;
/// Minimum share of the points on other parts that must be hidden.
const NEARLY_ALL: f64 = 0.95;
/// Maximum number of parts that make up a sky, and the minimum share that each must add to what they hide
/// together.
const MOST_PARTS: usize = 5;
const LEAST_ADDED: f64 = 0.03;
const SEED: u64 = 1;
/// Number of random triangles, of which the largest is taken for a point by area.
const CANDIDATES: usize = 8;

/// The parts of a scene that hide the sun from nearly everything else.
#[derive(Clone, Debug, PartialEq)]
pub struct Hider {
    /// The names of the nodes, meshes or materials, in the form that name patterns match.
    pub names: Vec<String>,
    /// Share of the points on other parts that are hidden, 0 to 1.
    pub share: f64,
}

/// A set of points, one bit for each.
type Points = [u64; POINTS / 64];

/// The points that the parts with one name hide, and the points on these parts.
#[derive(Clone, Copy, Default)]
struct Group {
    hidden: Points,
    own: Points,
}

impl Group {
    /// The share of the points on other parts that is hidden; 0 if there are too few of them.
    fn share(&self, points: usize) -> f64 {
        let others = points - count(&self.own);
        let hidden: usize =
            self.hidden.iter().zip(&self.own).map(|(h, o)| (h & !o).count_ones() as usize).sum();
        if (others as f64) < LEAST_OTHERS * points as f64 { 0.0 } else { hidden as f64 / others as f64 }
    }

    fn with(&self, other: &Self) -> Self {
        let or = |a: Points, b: Points| std::array::from_fn(|i| a[i] | b[i]);
        Self { hidden: or(self.hidden, other.hidden), own: or(self.own, other.own) }
    }
}

fn count(points: &Points) -> usize {
    points.iter().map(|word| word.count_ones() as usize).sum()
}

fn set(points: &mut Points, point: usize) {
    points[point / 64] |= 1 << (point % 64);
}

/// A point on a surface, with its instance and material.
struct OnSurface {
    p_world: [f64; 3],
    on: (u32, u32),
}

impl Hider {
    /// Casts rays from points on surfaces to the sun. Cost: one pass over all triangles.
    pub(super) fn of(scene: &Scene, towards_sun: [f64; 3], ignore_alpha: bool, lift: f64) -> Option<Self> {
        let points = points(scene);
        let places: Vec<[f64; 3]> = points.iter().map(|point| point.p_world).collect();
        // Pairs of a point and a part that hides the sun from it: an instance and one of its materials.
        let hiding = Pencil::new(&places, towards_sun).fold(
            scene,
            BTreeSet::new,
            |pairs: &mut BTreeSet<(usize, u32, u32)>, crossing| {
                if crossing.distance > lift && crossing.casts(scene) {
                    let pair = (crossing.point, crossing.instance, crossing.material(scene));
                    if !pairs.contains(&pair) && crossing.is_opaque(scene, ignore_alpha) {
                        pairs.insert(pair);
                    }
                }
            },
            |mut one, other| {
                one.extend(other);
                one
            },
        );
        // A part has the names of its node, its mesh and its material. Try them in this order.
        (0..3).find_map(|kind| {
            let mut groups: BTreeMap<&str, Group> = BTreeMap::new();
            for &(point, instance, material) in &hiding {
                let group = groups.entry(name(scene, (instance, material), kind)).or_default();
                set(&mut group.hidden, point);
            }
            for (point, thing) in points.iter().map(|point| point.on).enumerate() {
                if let Some(group) = groups.get_mut(name(scene, thing, kind)) {
                    set(&mut group.own, point);
                }
            }
            Self::among(&groups, points.len())
        })
    }

    /// Finds the fewest groups that hide nearly everything else.
    fn among(groups: &BTreeMap<&str, Group>, points: usize) -> Option<Self> {
        let mut names = Vec::new();
        let mut all = Group::default();
        for _ in 0..MOST_PARTS {
            let share = all.share(points);
            let more = groups.iter().map(|(&name, group)| (all.with(group), name));
            let (next, name) = more.max_by(|(a, _), (b, _)| a.share(points).total_cmp(&b.share(points)))?;
            if next.share(points) < share + LEAST_ADDED {
                return None;
            }
            all = next;
            names.push(name.to_owned());
            if all.share(points) >= NEARLY_ALL {
                return Some(Self { names, share: all.share(points) });
            }
        }
        None
    }
}

/// The name of a part's node, mesh or material.
fn name(scene: &Scene, (instance, material): (u32, u32), kind: usize) -> &str {
    let instance = &scene.instances[instance as usize];
    match kind {
        0 => &instance.name,
        1 => &scene.meshes[instance.mesh as usize].name,
        _ => &scene.materials[material as usize].name,
    }
}

/// Draws points on the surfaces of casters: one third by instance, one third by triangle, one third by area,
/// so that neither large parts nor finely tessellated ones dominate.
fn points(scene: &Scene) -> Vec<OnSurface> {
    // The instances that cast, each with the running total of triangles including its own.
    let mut total = 0;
    let triangles: Vec<(u32, u64)> = (0..)
        .zip(&scene.instances)
        .filter(|(_, i)| i.casts && !scene.meshes[i.mesh as usize].triangles.is_empty())
        .map(|(number, instance)| {
            total += scene.meshes[instance.mesh as usize].triangles.len() as u64;
            (number, total)
        })
        .collect();
    if total == 0 {
        return Vec::new();
    }
    let mut random = Random::new(SEED, 0);
    let by_triangle = |random: &mut Random| {
        let at = (random.unit() * total as f64) as u64;
        let i = triangles.partition_point(|&(_, sum)| sum <= at).min(triangles.len() - 1);
        let before = if i == 0 { 0 } else { triangles[i - 1].1 };
        (triangles[i].0, (at - before) as u32)
    };
    (0..POINTS)
        .map(|i| {
            let (number, triangle) = match i % 3 {
                0 => {
                    let number =
                        triangles[(random.unit() * triangles.len() as f64) as usize % triangles.len()].0;
                    let mesh = &scene.meshes[scene.instances[number as usize].mesh as usize];
                    (number, (random.unit() * mesh.triangles.len() as f64) as u32)
                }
                1 => by_triangle(&mut random),
                _ => {
                    let some: Vec<(u32, u32)> = (0..CANDIDATES).map(|_| by_triangle(&mut random)).collect();
                    let area = |&(number, triangle): &(u32, u32)| {
                        double_area(corners(scene, &scene.instances[number as usize], triangle))
                    };
                    some.into_iter().max_by(|a, b| area(a).total_cmp(&area(b))).unwrap_or_default()
                }
            };
            let instance = &scene.instances[number as usize];
            let [a, b, c] = corners(scene, instance, triangle);
            let (mut s, mut t) = (random.unit(), random.unit());
            if s + t > 1.0 {
                (s, t) = (1.0 - s, 1.0 - t);
            }
            let p_world = std::array::from_fn(|i| a[i] + s * (b[i] - a[i]) + t * (c[i] - a[i]));
            let material = scene.meshes[instance.mesh as usize].triangle_materials[triangle as usize];
            OnSurface { p_world, on: (number, material) }
        })
        .collect()
}

fn double_area([a, b, c]: [[f64; 3]; 3]) -> f64 {
    let edge = |p: [f64; 3]| std::array::from_fn(|i| p[i] - a[i]);
    let normal = cross(edge(b), edge(c));
    dot(normal, normal)
}
