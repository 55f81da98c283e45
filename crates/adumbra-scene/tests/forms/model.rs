//! The generated scenes.

use adumbra_scene::random::Random;

/// Meshes and their placements.
pub(crate) struct Model {
    pub(crate) meshes: Vec<Mesh>,
    pub(crate) placements: Vec<Placement>,
}

/// Faces of three or four corners. Those of four are rectangles.
pub(crate) struct Mesh {
    pub(crate) positions: Vec<[f64; 3]>,
    pub(crate) faces: Vec<Vec<usize>>,
}

/// A mesh in the world: scaled, then moved.
pub(crate) struct Placement {
    pub(crate) mesh: usize,
    pub(crate) scale: f64,
    pub(crate) offset: [f64; 3],
}

/// The expected content of every form of a model.
#[derive(PartialEq)]
pub(crate) struct World {
    /// The triangles with an area, in the order of [`canonical`].
    pub(crate) triangles: Vec<[[u64; 3]; 3]>,
    /// Whether there are triangles without an area.
    pub(crate) flat: bool,
}

impl Model {
    pub(crate) fn new(seed: u64) -> Self {
        let mut dice = Dice(Random::new(seed, 36));
        let meshes: Vec<Mesh> = (0..1 + dice.below(3)).map(|_| Mesh::new(&mut dice)).collect();
        let placements = (0..meshes.len() + dice.below(4)).map(|i| Placement {
            mesh: i % meshes.len(),
            scale: [0.5, 1.0, 2.0, 4.0][dice.below(4)],
            offset: std::array::from_fn(|_| dice.quarters(100)),
        });
        let placements = placements.collect();
        Self { meshes, placements }
    }

    /// The mesh of all placements in world space.
    pub(crate) fn flattened(&self) -> Mesh {
        let mut all = Mesh { positions: Vec::new(), faces: Vec::new() };
        for placement in &self.placements {
            let (mesh, base) = (&self.meshes[placement.mesh], all.positions.len());
            all.positions.extend(mesh.positions.iter().map(|p| placement.apply(*p)));
            all.faces.extend(mesh.faces.iter().map(|f| f.iter().map(|c| c + base).collect::<Vec<_>>()));
        }
        all
    }

    pub(crate) fn world(&self) -> World {
        let all = self.flattened();
        let corners = all.triangles().into_iter().map(|t| t.map(|i| all.positions[i]));
        let (solid, flat): (Vec<_>, Vec<_>) = corners.partition(|&t| has_area(t));
        World { triangles: canonical(solid.into_iter()), flat: !flat.is_empty() }
    }
}

impl Mesh {
    fn new(dice: &mut Dice) -> Self {
        let mut mesh = Self { positions: Vec::new(), faces: Vec::new() };
        for _ in 0..2 + dice.below(12) {
            let base = mesh.positions.len();
            if dice.below(2) == 0 {
                mesh.positions.extend((0..3).map(|_| std::array::from_fn(|_| dice.quarters(60))));
                mesh.faces.push((base..base + 3).collect());
            } else {
                // Add a rectangle perpendicular to one axis.
                let axis = dice.below(3);
                let low: [f64; 3] = std::array::from_fn(|_| dice.quarters(60));
                let (u, v) = (0.25 + dice.quarters(30).abs(), 0.25 + dice.quarters(30).abs());
                for (s, t) in [(0.0, 0.0), (u, 0.0), (u, v), (0.0, v)] {
                    let mut p = low;
                    p[(axis + 1) % 3] += s;
                    p[(axis + 2) % 3] += t;
                    mesh.positions.push(p);
                }
                mesh.faces.push((base..base + 4).collect());
            }
            // Add faces that share vertices, some of them without an area.
            if dice.below(3) == 0 {
                let corner = |dice: &mut Dice| dice.below(mesh.positions.len());
                let face = vec![corner(dice), corner(dice), corner(dice)];
                mesh.faces.push(face);
            }
        }
        mesh
    }

    /// The triangles of the fan from each face's first corner.
    pub(crate) fn triangles(&self) -> Vec<[usize; 3]> {
        let fans = self.faces.iter().flat_map(|f| (2..f.len()).map(|i| [f[0], f[i - 1], f[i]]));
        fans.collect()
    }
}

impl Placement {
    pub(crate) fn apply(&self, p: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|a| p[a] * self.scale + self.offset[a])
    }
}

/// Random choices of a model.
struct Dice(Random);

impl Dice {
    fn below(&mut self, count: usize) -> usize {
        (self.0.unit() * count as f64) as usize
    }

    /// A multiple of 1/4 between -`most` and `most`.
    fn quarters(&mut self, most: i32) -> f64 {
        f64::from(self.below(8 * most as usize + 1) as i32 - 4 * most) / 4.0
    }
}

fn has_area([a, b, c]: [[f64; 3]; 3]) -> bool {
    let edge = |p: [f64; 3]| -> [f64; 3] { std::array::from_fn(|i| p[i] - a[i]) };
    let (u, v) = (edge(b), edge(c));
    (0..3).any(|i| u[i] * v[(i + 1) % 3] != u[(i + 1) % 3] * v[i])
}

/// Triangles in a canonical order, each starting at its smallest corner, so that the winding matters.
pub(crate) fn canonical(triangles: impl Iterator<Item = [[f64; 3]; 3]>) -> Vec<[[u64; 3]; 3]> {
    // Adding 0 turns -0 into 0.
    let turned = triangles.map(|t| {
        let mut t = t.map(|p| p.map(|c| (c + 0.0).to_bits()));
        let least = (0..3).min_by_key(|&i| t[i]).unwrap_or(0);
        t.rotate_left(least);
        t
    });
    let mut sorted: Vec<_> = turned.collect();
    sorted.sort_unstable();
    sorted
}
