//! Scenes made of boxes.

use adumbra_scene::{Instance, Material, Mesh, Scene};

/// Builds a scene of closed boxes, each given by its least and greatest corner.
pub(crate) fn boxes(corners: &[([f32; 3], [f32; 3])]) -> Scene {
    let mut mesh = Mesh { name: "boxes".to_owned(), ..Default::default() };
    for (min, max) in corners {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend((0..8_usize).map(|corner| {
            std::array::from_fn::<f32, 3, _>(|a| if corner >> a & 1 == 0 { min[a] } else { max[a] })
        }));
        // Corners of each face, counter-clockwise from outside; bit 0 of a corner is x, bit 1 y, bit 2 z.
        for [a, b, c, d] in
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
        {
            mesh.triangles.extend([[a, b, c], [a, c, d]].map(|t| t.map(|i: u32| first + i)));
        }
    }
    mesh.triangle_materials = vec![0; mesh.triangles.len()];
    Scene {
        meshes: vec![mesh],
        instances: vec![Instance {
            name: "boxes".to_owned(),
            mesh: 0,
            world_from_mesh: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
            casts: true,
        }],
        materials: vec![Material::opaque("white", [1.0; 4])],
        ..Default::default()
    }
}
