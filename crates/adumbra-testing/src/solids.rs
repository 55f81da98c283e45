//! Small scenes made by hand, of quads and boxes.

use adumbra_scene::{Instance, Material, Mesh, Scene};

/// Corners of the faces of a box, counter-clockwise from outside. Bit 0 of a corner's number is x, bit 1 y,
/// bit 2 z.
const BOX_FACES: [[u32; 4]; 6] =
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// Adds a quad as two triangles of the first material. Its corners are counter-clockwise seen from its front.
pub fn add_quad(mesh: &mut Mesh, corners: [[f32; 3]; 4]) {
    add_faces(mesh, &corners, &[[0, 1, 2, 3]]);
}

/// Adds a closed box between its lower and its upper corner, of the first material.
pub fn add_box(mesh: &mut Mesh, min: [f32; 3], max: [f32; 3]) {
    let corner = |i: usize| [0, 1, 2].map(|a| if i >> a & 1 == 0 { min[a] } else { max[a] });
    add_faces(mesh, &std::array::from_fn::<_, 8, _>(corner), &BOX_FACES);
}

fn add_faces(mesh: &mut Mesh, corners: &[[f32; 3]], faces: &[[u32; 4]]) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(corners);
    for [a, b, c, d] in faces.iter().map(|face| face.map(|corner| first + corner)) {
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
        mesh.triangle_materials.extend([0; 2]);
    }
}

/// Returns a closed box between its lower and its upper corner.
pub fn cuboid(min: [f32; 3], max: [f32; 3]) -> Mesh {
    let mut mesh = Mesh::default();
    add_box(&mut mesh, min, max);
    mesh
}

/// Returns a grey scene of these meshes, each placed once, without a transform.
pub fn scene_of(meshes: Vec<Mesh>) -> Scene {
    let place = |mesh| Instance {
        name: String::new(),
        mesh,
        world_from_mesh: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
        casts: true,
    };
    Scene {
        instances: (0..meshes.len() as u32).map(place).collect(),
        meshes,
        materials: vec![Material::opaque("grey", [0.5, 0.5, 0.5, 1.0])],
        ..Scene::default()
    }
}
