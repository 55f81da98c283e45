//! Checks GLB files with an independent reader.

use adumbra_scene::{
    AlphaMode, GeneratedKind, Instance, Material, Mesh, Pixels, Scene, Texture, Wrap, generate, to_glb,
    write_glb,
};

#[test]
fn glb_reads_back_with_another_reader() {
    for kind in
        [GeneratedKind::Spheres, GeneratedKind::Primitives, GeneratedKind::Landscape, GeneratedKind::City]
    {
        let mut scene = generate(kind, 3);
        scene.instances[1].casts = false;
        scene.materials[2].casts = false;
        let (document, buffers, _) = gltf::import_slice(to_glb(&scene)).unwrap();
        assert_eq!(document.as_json().asset.generator.as_deref(), Some("adumbra"));
        assert_eq!(document.nodes().len(), scene.instances.len());
        assert_eq!(document.meshes().len(), scene.meshes.len());
        for (read, mesh) in document.meshes().zip(&scene.meshes) {
            assert_eq!(read.name(), Some(mesh.name.as_str()));
            let mut found: Vec<_> = read.primitives().flat_map(|p| triangles(&p, &buffers)).collect();
            let corner = |v: u32| mesh.positions[v as usize].map(f32::to_bits);
            let mut expected: Vec<_> = mesh
                .triangles
                .iter()
                .zip(&mesh.triangle_materials)
                .map(|(t, &m)| (m, t.map(corner)))
                .collect();
            found.sort_unstable();
            expected.sort_unstable();
            assert!(found == expected, "{kind:?}: {}", mesh.name);
        }
        for (node, instance) in document.nodes().zip(&scene.instances) {
            assert_eq!(node.mesh().map(|m| m.index()), Some(instance.mesh as usize));
            assert_eq!(node.name(), Some(instance.name.as_str()));
            let columns = node.transform().matrix();
            for (r, row) in instance.world_from_mesh.iter().enumerate() {
                for (c, &m) in row.iter().enumerate() {
                    assert_eq!(f64::from(columns[c][r]), m);
                }
            }
            let extras = node.extras().as_ref().map(|e| e.get());
            assert_eq!(extras, (!instance.casts).then_some(r#"{"adumbra":{"cast":false}}"#));
        }
        for (read, material) in document.materials().zip(&scene.materials) {
            assert_eq!(read.name(), Some(material.name.as_str()));
            assert_eq!(read.pbr_metallic_roughness().base_color_factor(), material.base_color);
            assert_eq!(read.extras().is_none(), material.casts);
        }
    }
}

/// Returns the material and corners of each triangle, and checks the stated bounds of the positions.
fn triangles(primitive: &gltf::Primitive<'_>, buffers: &[gltf::buffer::Data]) -> Vec<(u32, [[u32; 3]; 3])> {
    let reader = primitive.reader(|buffer| Some(&buffers[buffer.index()]));
    let positions: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
    let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
    let bounds = primitive.bounding_box();
    for a in 0..3 {
        let low = positions.iter().fold(f32::INFINITY, |m, p| m.min(p[a]));
        let high = positions.iter().fold(f32::NEG_INFINITY, |m, p| m.max(p[a]));
        assert_eq!((bounds.min[a], bounds.max[a]), (low, high));
    }
    let material = primitive.material().index().unwrap() as u32;
    let corner = |v: u32| positions[v as usize].map(f32::to_bits);
    indices.chunks(3).map(|t| (material, [corner(t[0]), corner(t[1]), corner(t[2])])).collect()
}

#[test]
fn textures_and_masks_read_back_with_another_reader() {
    let mut scene = generate(GeneratedKind::Forest, 3);
    let alphas = [0, 90, 255, 7, 8, 200];
    scene.textures.push(Texture {
        name: "alpha".into(),
        width: 3,
        height: 2,
        pixels: Pixels::Alpha(alphas.to_vec()),
        wrap: [Wrap::Mirror, Wrap::Repeat],
        nearest: true,
    });
    let blended = Material {
        alpha: AlphaMode::Mask { cutoff: 0.5 },
        blended: true,
        texture: Some(1),
        ..Material::opaque("blended", [1.0, 0.5, 0.25, 0.75])
    };
    scene.materials.push(blended);
    let (document, buffers, images) = gltf::import_slice(to_glb(&scene)).unwrap();

    let [leaves, blended] = [2, 3].map(|m| document.materials().nth(m).unwrap());
    let texture = |m: &gltf::Material<'_>| {
        m.pbr_metallic_roughness().base_color_texture().map(|info| info.texture().index())
    };
    assert_eq!((texture(&leaves), texture(&blended)), (Some(0), Some(1)));
    assert_eq!((leaves.alpha_mode(), leaves.alpha_cutoff()), (gltf::material::AlphaMode::Mask, Some(0.5)));
    assert_eq!((blended.alpha_mode(), blended.alpha_cutoff()), (gltf::material::AlphaMode::Blend, None));
    assert_eq!(document.materials().next().unwrap().alpha_mode(), gltf::material::AlphaMode::Opaque);

    let Pixels::Rgba(texels) = &scene.textures[0].pixels else { panic!("colours") };
    assert_eq!((images[0].width, images[0].height), (256, 256));
    assert!(images[0].pixels == *texels);
    assert_eq!((images[1].width, images[1].height), (3, 2));
    assert_eq!(images[1].pixels, alphas.map(|alpha| [255, alpha]).concat());
    use gltf::texture::{MagFilter, WrappingMode};
    let sampler = |n: usize| {
        let sampler = document.textures().nth(n).unwrap().sampler();
        (sampler.mag_filter().unwrap(), sampler.wrap_s(), sampler.wrap_t())
    };
    assert_eq!(sampler(0), (MagFilter::Linear, WrappingMode::ClampToEdge, WrappingMode::ClampToEdge));
    assert_eq!(sampler(1), (MagFilter::Nearest, WrappingMode::MirroredRepeat, WrappingMode::Repeat));

    let mesh = &scene.meshes[1];
    let tree = document.meshes().nth(1).unwrap();
    let bits = |(p, uv): ([f32; 3], [f32; 2])| (p.map(f32::to_bits), uv.map(f32::to_bits));
    let mut found = Vec::new();
    for primitive in tree.primitives() {
        let reader = primitive.reader(|buffer| Some(&buffers[buffer.index()]));
        let positions = reader.read_positions().unwrap();
        found.extend(positions.zip(reader.read_tex_coords(0).unwrap().into_f32()).map(bits));
    }
    let vertices = mesh.positions.iter().copied().zip(mesh.uvs.iter().copied());
    let mut expected: Vec<_> = vertices.map(bits).collect();
    found.sort_unstable();
    expected.sort_unstable();
    assert!(found == expected);
}

#[test]
fn glb_of_an_empty_scene_or_mesh_is_valid() {
    let mut scene = Scene::default();
    assert_eq!(gltf::Gltf::from_slice(&to_glb(&scene)).unwrap().nodes().len(), 0);
    scene.meshes.push(Mesh::default());
    let world_from_mesh = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    scene.instances.push(Instance { name: "empty".into(), mesh: 0, world_from_mesh, casts: true });
    let document = gltf::Gltf::from_slice(&to_glb(&scene)).unwrap();
    assert_eq!((document.nodes().len(), document.meshes().len()), (0, 0));
}

#[test]
fn meshes_of_over_65535_vertices_get_32_bit_indices() {
    let mut scene = generate(GeneratedKind::Primitives, 0);
    let mesh = &mut scene.meshes[1];
    let (positions, triangles) = (mesh.positions.clone(), mesh.triangles.clone());
    while mesh.positions.len() <= 70_000 {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend_from_slice(&positions);
        mesh.triangles.extend(triangles.iter().map(|t| t.map(|v| v + first)));
    }
    mesh.triangle_materials = vec![0; mesh.triangles.len()];
    let highest = mesh.positions.len() as u32 - 1;
    let (document, buffers, _) = gltf::import_slice(to_glb(&scene)).unwrap();
    let found = document.meshes().nth(1).unwrap().primitives().filter_map(|p| {
        let reader = p.reader(|buffer| Some(&buffers[buffer.index()]));
        reader.read_indices()?.into_u32().max()
    });
    assert_eq!(found.max(), Some(highest));
}

#[test]
fn write_glb_replaces_the_file_and_leaves_no_temporary() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.glb");
    let scene = generate(GeneratedKind::Primitives, 1);
    std::fs::write(&path, "earlier").unwrap();
    write_glb(&scene, &path).unwrap();
    assert!(std::fs::read(&path).unwrap() == to_glb(&scene));

    let taken = folder.path().join("taken");
    std::fs::create_dir(&taken).unwrap();
    for bad in [path.join("below.glb"), taken] {
        let message = write_glb(&scene, &bad).unwrap_err().to_string();
        assert!(message.contains(&bad.display().to_string()), "{message}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
}
