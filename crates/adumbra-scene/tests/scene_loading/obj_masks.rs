//! Opacity maps of MTL files: their channels, options and colours.

use adumbra_scene::{AlphaMode, Error, LoadOptions, Pixels, Scene, Texture, Wrap, load};
use image::{ExtendedColorType, ImageFormat};

use crate::kit::png;
use crate::obj::Folder;

/// A quad with texture coordinates from the bottom left to the top right.
const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";

fn quad() -> String {
    format!("mtllib a.mtl\n{QUAD}usemtl leaf\nf 1/1 2/2 3/3 4/4\n")
}

fn colors() -> LoadOptions {
    LoadOptions { color_textures: true, ..LoadOptions::default() }
}

/// An image of these texels; `kind` is their colour type.
fn image(texels: &[u8], width: u32, kind: ExtendedColorType, format: ImageFormat) -> Vec<u8> {
    let channels = u32::from(kind.channel_count());
    let height = texels.len() as u32 / (width * channels);
    let mut out = std::io::Cursor::new(Vec::new());
    image::write_buffer_with_format(&mut out, texels, width, height, kind, format).expect("encodes");
    out.into_inner()
}

/// The scene's only mask: width, height and values.
fn mask(scene: &Scene) -> (u32, u32, Vec<u8>) {
    let [Texture { width, height, pixels, .. }] = scene.textures.as_slice() else {
        panic!("{} textures", scene.textures.len())
    };
    let values = match pixels {
        Pixels::Alpha(values) => values.clone(),
        Pixels::Rgba(rgba) => rgba.chunks_exact(4).map(|texel| texel[3]).collect(),
    };
    (*width, *height, values)
}

#[test]
fn masks_are_read_from_all_channels_and_formats() {
    use ExtendedColorType::{L8, La8, Rgb8, Rgba8};
    let grey = image(&[0, 100, 255], 3, L8, ImageFormat::Png);
    let rgba = image(&[10, 20, 30, 40, 50, 60, 70, 80], 2, Rgba8, ImageFormat::Png);
    let opaque = image(&[10, 20, 30, 255, 200, 200, 200, 255], 2, Rgba8, ImageFormat::Png);
    let rgb = image(&[255, 0, 0, 0, 255, 0, 0, 0, 255], 3, Rgb8, ImageFormat::Png);
    let tga = image(&[0, 128, 255], 3, L8, ImageFormat::Tga);
    let jpeg = image(&[0; 64], 8, L8, ImageFormat::Jpeg);
    let la = image(&[9, 0, 9, 7], 2, La8, ImageFormat::Png);
    let rows: [(&str, &str, &[u8], &[u8]); 14] = [
        ("grey", "map_d a.png", &grey, &[0, 100, 255]),
        ("grey TGA", "map_d a.tga", &tga, &[0, 128, 255]),
        ("grey JPEG", "map_d a.jpg", &jpeg, &[0; 64]),
        ("alpha", "map_d a.png", &rgba, &[40, 80]),
        ("grey and alpha", "map_d a.png", &la, &[0, 7]),
        ("opaque alpha: luminance", "map_d a.png", &opaque, &[19, 200]),
        ("colour: luminance", "map_d a.png", &rgb, &[54, 182, 19]),
        ("red", "map_d -imfchan r a.png", &rgba, &[10, 50]),
        ("green", "map_d -imfchan G a.png", &rgba, &[20, 60]),
        ("blue", "map_d -imfchan b a.png", &rgba, &[30, 70]),
        ("matte", "map_d -imfchan m a.png", &rgba, &[40, 80]),
        ("luminance", "map_d -imfchan l a.png", &rgba, &[19, 59]),
        ("base and gain", "map_d -mm 1 -1 a.png", &grey, &[255, 155, 0]),
        ("gain out of range", "Map_D -mm 0 3 a.png", &grey, &[0, 255, 255]),
    ];
    for (name, statement, bytes, expected) in rows {
        let file = statement.rsplit_once(' ').expect("a file").1;
        let folder =
            Folder::new(quad()).with("a.mtl", format!("newmtl leaf\n{statement}\n")).with(file, bytes);
        let scene = folder.load().expect(name);
        assert_eq!(scene.materials[0].alpha, AlphaMode::Mask { cutoff: 0.5 }, "{name}");
        assert_eq!(scene.notes.blended_materials, 0, "{name}");
        assert!(scene.notes.omissions.is_empty() && scene.notes.warnings.is_empty(), "{name}");
        if name == "luminance" || name.starts_with("colour") || name.starts_with("opaque") {
            let near = mask(&scene).2.iter().zip(expected).all(|(a, b)| a.abs_diff(*b) <= 1);
            assert!(near, "{name}: {:?}", mask(&scene).2);
        } else {
            assert_eq!(mask(&scene).2, expected, "{name}");
        }
        // Opacity does not depend on whether colours are loaded.
        assert_eq!(mask(&folder.load_with(&colors()).expect(name)).2, mask(&scene).2, "{name}");
        let ignoring = LoadOptions { ignore_alpha: true, ..LoadOptions::default() };
        let solid = folder.load_with(&ignoring).expect(name);
        assert!(solid.textures.is_empty() && solid.meshes[0].uvs.is_empty(), "{name}");
        assert_eq!(solid.materials[0].alpha, AlphaMode::Opaque, "{name}");
    }
}

#[test]
fn masks_are_upright_and_follow_placement_options() {
    // Only the top left texel is opaque.
    let texels = image(&[255, 0, 0, 0], 2, ExtendedColorType::L8, ImageFormat::Png);
    // Statement, and the coordinates in OBJ's convention that are opaque.
    let rows = [
        ("map_d m.png", [0.25, 0.75], Wrap::Repeat),
        ("map_d -o 0.5 m.png", [0.75, 0.75], Wrap::Repeat),
        ("map_d -o 0 0.5 0 m.png", [0.25, 0.25], Wrap::Repeat),
        ("map_d -s 0.5 0.5 1 m.png", [0.5, 1.5], Wrap::Repeat),
        ("map_d -s 2 m.png", [0.125, 0.75], Wrap::Repeat),
        ("map_d -clamp on m.png", [0.25, 0.75], Wrap::Clamp),
        (
            "map_d -clamp off -blendu off -cc on -texres 4 -boost 2 -type sphere m.png",
            [0.25, 0.75],
            Wrap::Repeat,
        ),
    ];
    for (statement, [u, v], wrap) in rows {
        let obj = format!(
            "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt {u} {v}\nvt {u} {v}\nvt {u} {v}\nusemtl leaf\nf 1/1 2/2 3/3\n"
        );
        let folder =
            Folder::new(obj).with("a.mtl", format!("newmtl leaf\n{statement}\n")).with("m.png", &texels);
        let scene = folder.load().expect(statement);
        assert_eq!(scene.textures[0].wrap, [wrap; 2], "{statement}");
        assert_eq!(scene.alpha(0, scene.meshes[0].corner_uvs(0)[0], 1.0), 1.0, "{statement}");
    }
}

#[test]
fn only_masked_faces_keep_their_texture_coordinates() {
    // Each corner has a different texture coordinate in each face.
    let faces = "usemtl wall\nf 1/1 2/2 3/3\nf 1/4 3/1 4/2\nusemtl leaf\nf 1/1 2/2 3/3\nf 1/4 3/1 4/2\nusemtl wall\nf 1 2 3\n";
    let folder = Folder::new(format!("mtllib a.mtl\n{QUAD}{faces}"))
        .with("a.mtl", "newmtl wall\nmap_Kd no.png\nnewmtl leaf\nmap_d m.png\n")
        .with("m.png", png(&[0, 255]));
    let scene = folder.load().expect("loads");
    let mesh = &scene.meshes[0];
    // The wall shares four vertices, the leaf has six, and the second wall three.
    assert_eq!((mesh.positions.len(), mesh.uvs.len()), (13, 13));
    assert_eq!(mesh.uvs[..4], [[0.0; 2]; 4]);
    assert_eq!(mesh.uvs[4..7], [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0]]);
    let bare = folder.with("a.mtl", "newmtl wall\nnewmtl leaf\n").load().expect("loads");
    assert!(bare.meshes[0].uvs.is_empty());
    assert_eq!(bare.meshes[0].positions.len(), 4 + 4 + 3);
}

#[test]
fn faces_without_texture_coordinates_are_warned_about() {
    let folder =
        Folder::new(format!("mtllib a.mtl\n{QUAD}usemtl leaf\nf 1 2 3\nf 1/1 2/2 3/9\nf 1/1 2/2 3/3\n"))
            .with("a.mtl", "newmtl leaf\nmap_d m.png\n")
            .with("m.png", png(&[0, 255]));
    let warnings = folder.load().expect("loads").notes.warnings;
    assert!(warnings.len() == 1 && warnings[0].starts_with("2 faces"), "{warnings:?}");
}

#[test]
fn dissolve_multiplies_the_mask() {
    let with = |mtl: &str| {
        Folder::new(quad())
            .with("a.mtl", mtl)
            .with("m.png", image(&[255, 0], 2, ExtendedColorType::L8, ImageFormat::Png))
            .load()
            .expect("loads")
    };
    let scene = with("newmtl leaf\nd 0.75\nmap_d m.png\n");
    assert_eq!((scene.alpha(0, [0.25, 0.5], 1.0), scene.alpha(0, [0.75, 0.5], 1.0)), (0.75, 0.0));
    assert_eq!(scene.notes.blended_materials, 1);
    // A mask without holes is not loaded as a texture.
    let white = image(&[255], 1, ExtendedColorType::L8, ImageFormat::Png);
    let scene = Folder::new(quad()).with("a.mtl", "newmtl leaf\nmap_d m.png\n").with("m.png", white);
    assert_eq!(mask_or_none(&scene.load().expect("loads")), None);
}

fn mask_or_none(scene: &Scene) -> Option<Vec<u8>> {
    if scene.textures.is_empty() { None } else { Some(mask(scene).2) }
}

#[test]
fn colours_and_masks_are_merged_into_one_texture() {
    use ExtendedColorType::{L8, Rgb8};
    let color = image(&[255, 0, 0, 0, 255, 0, 0, 0, 255, 9, 9, 9], 2, Rgb8, ImageFormat::Png);
    let same = image(&[0, 255, 255, 0], 2, L8, ImageFormat::Png);
    let larger = image(&[0, 255, 255, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12], 4, L8, ImageFormat::Png);
    for (name, mask_bytes) in [("same size", &same), ("larger", &larger)] {
        let folder = Folder::new(quad())
            .with("a.mtl", "newmtl leaf\nmap_Kd c.png\nmap_d m.png\n")
            .with("c.png", &color)
            .with("m.png", mask_bytes);
        let scene = folder.load_with(&colors()).expect(name);
        let Pixels::Rgba(rgba) = &scene.textures[0].pixels else { panic!("{name}: four channels") };
        assert_eq!(rgba[..3], [255, 0, 0], "{name}");
        assert_eq!(rgba[rgba.len() - 4..rgba.len() - 1], [9, 9, 9], "{name}");
        assert_eq!(mask(&scene), mask(&folder.load().expect(name)), "{name}");
    }
    // If the colours are placed differently, only the mask is loaded.
    let folder = Folder::new(quad())
        .with("a.mtl", "newmtl leaf\nmap_Kd -s 2 2 c.png\nmap_d m.png\n")
        .with("c.png", &color)
        .with("m.png", &same);
    let scene = folder.load_with(&colors()).expect("loads");
    assert!(matches!(scene.textures[0].pixels, Pixels::Alpha(_)));
    assert!(scene.notes.warnings[0].contains("placed differently"), "{:?}", scene.notes.warnings);
    // A missing colour texture does not affect opacity.
    let folder = folder.with("a.mtl", "newmtl leaf\nmap_Kd no.png\nmap_d m.png\n");
    let scene = folder.load_with(&colors()).expect("loads");
    assert_eq!(mask(&scene).2, [0, 255, 255, 0]);
    assert!(scene.notes.warnings[0].contains("no.png"), "{:?}", scene.notes.warnings);
}

#[test]
fn image_used_as_colour_and_mask_masks_by_its_alpha() {
    use ExtendedColorType::{Rgb8, Rgba8};
    let mtl = "newmtl leaf\nmap_Kd c.png\nmap_d C.png\n";
    let dark = image(&[9, 9, 9, 200, 9, 9], 2, Rgb8, ImageFormat::Png);
    let folder = Folder::new(quad()).with("a.mtl", mtl).with("c.png", dark);
    assert_eq!(mask_or_none(&folder.load().expect("loads")), None);
    let leaf = image(&[9, 9, 9, 0, 200, 9, 9, 255], 2, Rgba8, ImageFormat::Png);
    let folder = folder.with("c.png", leaf);
    assert_eq!(mask(&folder.load().expect("loads")).2, [0, 255]);
    assert_eq!(mask(&folder.load_with(&colors()).expect("loads")).2, [0, 255]);
    // Without map_d, the alpha of a colour texture is ignored.
    let folder = folder.with("a.mtl", "newmtl leaf\nmap_Kd c.png\n");
    let scene = folder.load_with(&colors()).expect("loads");
    assert_eq!((scene.materials[0].alpha, mask(&scene).2), (AlphaMode::Opaque, vec![255, 255]));
}

#[test]
fn masks_are_shared_by_materials() {
    let uses: String = (0..4).map(|i| format!("usemtl m{i}\nf 1/1 2/2 3/3\n")).collect();
    let mtl: String = (0..4).map(|i| format!("newmtl m{i}\nmap_d {}m.png\n", "./".repeat(i % 2))).collect();
    let folder = Folder::new(format!("mtllib a.mtl\n{QUAD}{uses}"));
    let folder =
        folder.with("a.mtl", mtl + "newmtl m3\nmap_d -clamp on m.png\n").with("m.png", png(&[0, 255]));
    let scene = folder.load().expect("loads");
    assert_eq!(scene.textures.len(), 2);
    assert_eq!(scene.materials[0].texture, scene.materials[2].texture);
    assert_eq!(scene.textures[1].wrap, [Wrap::Clamp; 2]);
}

#[test]
fn masks_that_cannot_be_read_are_errors() {
    let error = |statement: &str| {
        let folder = Folder::new(quad())
            .with("a.mtl", format!("newmtl leaf\n{statement}\n"))
            .with("broken.png", "no image")
            .with("m.png", png(&[0, 255]));
        folder.load().expect_err(statement)
    };
    for (statement, part) in [
        ("map_d no.png", "no.png"),
        ("map_d broken.png", "no PNG image"),
        ("map_d -imfchan z m.png", "depth channel"),
    ] {
        let error = error(statement);
        assert!(matches!(&error, Error::Texture { material, .. } if material == "leaf"), "{error}");
        assert!(error.to_string().contains(part), "{error}");
    }
    let outside = error("map_d ../m.png");
    assert!(matches!(&outside, Error::OutsideScene { named, .. } if named == "../m.png"), "{outside}");
    let folder =
        Folder::new(quad()).with("a.mtl", "newmtl leaf\nmap_d -t 1 1 1 m.png\n").with("m.png", png(&[0, 9]));
    let omissions = folder.load().expect("loads").notes.omissions;
    assert_eq!(omissions[0].to_string(), "1 turbulences of opacity maps (-t)");
}

#[test]
fn masks_are_counted_before_they_are_decoded() {
    let side = 512_u32;
    let texels = u64::from(side * side);
    let bytes = image(&vec![0; texels as usize], side, ExtendedColorType::L8, ImageFormat::Png);
    let folder = Folder::new(quad()).with("a.mtl", "newmtl leaf\nmap_d m.png\n").with("m.png", bytes);
    let within =
        |max: u64| folder.load_with(&LoadOptions { max_memory_bytes: Some(max), ..LoadOptions::default() });
    let error = within(4 * texels).expect_err("too large");
    assert!(error.to_string().contains("512 x 512"), "{error}");
    within(6 * texels).expect("fits");
}

/// Map files are found by the same rules as libraries.
#[test]
fn mask_files_are_found_by_the_names_that_programs_write() {
    for (named, file) in [
        ("my leaf.png", "my leaf.png"),
        ("\"my leaf.png\"", "my leaf.png"),
        ("LEAF.PNG", "leaf.png"),
        ("leaf #2.png", "leaf #2.png"),
        ("leaf.png # of the oak", "leaf.png"),
        (".\\leaf.png", "leaf.png"),
        ("-s 1 1 1 my leaf.png", "my leaf.png"),
        ("-unknown 1 leaf.png", "leaf.png"),
    ] {
        let folder = Folder::new(quad())
            .with("a.mtl", format!("newmtl leaf\nmap_d {named}\n"))
            .with(file, png(&[0, 255]));
        assert_eq!(mask(&folder.load().expect(named)).2, [0, 255], "{named}");
    }
}

/// Writes a glTF scene as OBJ, MTL and PNG, in world space and with absolute indices.
fn as_obj(scene: &Scene) -> Folder {
    let (mut obj, mut mtl) = ("mtllib a.mtl\n".to_owned(), String::new());
    for (index, material) in scene.materials.iter().enumerate() {
        mtl += &format!("newmtl m{index}\n");
        if let (Some(texture), AlphaMode::Mask { .. }) = (material.texture, material.alpha) {
            mtl += &format!("map_d t{texture}.png\n");
        }
    }
    let mut vertices = 0;
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh as usize];
        for (index, &p) in mesh.positions.iter().enumerate() {
            let [x, y, z] = instance.to_world(p);
            let [u, v] = mesh.uvs.get(index).copied().unwrap_or_default();
            obj += &format!("v {x} {y} {z}\nvt {u} {}\n", 1.0 - f64::from(v));
        }
        for (t, m) in mesh.triangles.iter().zip(&mesh.triangle_materials) {
            let [a, b, c] = t.map(|i| i + vertices + 1);
            obj += &format!("usemtl m{m}\nf {a}/{a} {b}/{b} {c}/{c}\n");
        }
        vertices += mesh.positions.len() as u32;
    }
    let mut folder = Folder::new(obj).with("a.mtl", mtl);
    for (index, texture) in scene.textures.iter().enumerate() {
        let alpha: Vec<u8> = texture.rgba().chunks_exact(4).map(|texel| texel[3]).collect();
        let bytes = image(&alpha, texture.width, ExtendedColorType::L8, ImageFormat::Png);
        folder = folder.with(&format!("t{index}.png"), bytes);
    }
    folder
}

#[test]
fn tree_has_the_same_opacity_in_obj_as_in_gltf() {
    let Some(scenes) = adumbra_testing::shared("scenes") else { return };
    let gltf = load(&scenes.join("oak_medium.glb"), &LoadOptions::default()).expect("loads");
    let obj = as_obj(&gltf).load().expect("loads");
    assert_eq!(obj.instanced_triangles(), gltf.instanced_triangles());
    let of = |scene: &Scene| {
        let mut out = Vec::new();
        for instance in &scene.instances {
            let mesh = &scene.meshes[instance.mesh as usize];
            for (t, &m) in (0..).zip(&mesh.triangle_materials) {
                let uvs = mesh.corner_uvs(t);
                // Points in the triangle by their barycentric weights, in 16ths.
                for [a, b] in [[5, 5], [1, 2], [12, 3], [8, 7]] {
                    let weights = [a, b, 16 - a - b].map(|w| w as f32 / 16.0);
                    let uv = [0, 1].map(|c| (0..3).map(|i| weights[i] * uvs[i][c]).sum::<f32>());
                    out.push(scene.alpha(m, uv, 1.0));
                }
            }
        }
        out
    };
    let (from_gltf, from_obj) = (of(&gltf), of(&obj));
    assert_eq!(from_gltf.len(), from_obj.len());
    let holes = from_gltf.iter().filter(|&&a| a < 0.5).count();
    assert!(holes * 10 > from_gltf.len(), "only {holes} of {} samples are holes", from_gltf.len());
    for (a, b) in from_gltf.iter().zip(&from_obj) {
        assert!((a - b).abs() < 0.02, "{a} {b}");
    }
}
