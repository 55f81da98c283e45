//! `export` and `import`: the same file comes back, and pictures that were changed in between are refused.

use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::Command;

use adumbra_testing::{Folder, adumbra, json, program, stderr};
use image::{DynamicImage, ImageFormat, ImageReader, RgbaImage};

/// Bakes a small city and returns the file's path.
fn bake(folder: &Folder) -> String {
    let scene = folder.generate("city");
    let file = folder.path("city.adumbra");
    let (code, error) = adumbra(&[
        "bake",
        &scene,
        "--layout",
        "packed",
        "--resolution",
        "256",
        "--progress",
        "none",
        "-o",
        &file,
    ]);
    assert_eq!(code, 0, "{error}");
    file
}

fn export(folder: &Folder, file: &str) -> String {
    let page = folder.path("city.png");
    let (code, error) = adumbra(&["export", file, "--texture", &page]);
    assert_eq!(code, 0, "{error}");
    page
}

fn open(path: &str) -> RgbaImage {
    ImageReader::open(path).unwrap().decode().unwrap().to_rgba8()
}

#[test]
fn export_and_import_give_the_same_bytes() {
    let folder = Folder::new();
    let file = bake(&folder);
    let page = folder.path("city.png");
    let exported = json(&["export", &file, "--texture", &page, "--json"]);
    assert_eq!(exported["pages"], 1);
    assert_eq!(exported["kind"], "light-aligned");
    assert!(exported["depth"].as_u64().unwrap() >= 8);
    assert_eq!(exported["file_bytes"].as_u64(), Some(fs::metadata(&file).unwrap().len()));
    assert_eq!(exported["texture_bytes"].as_u64(), Some(fs::metadata(&page).unwrap().len()));
    let back = folder.path("back.adumbra");
    let imported = json(&["import", &page, "-o", &back, "--json"]);
    assert_eq!(imported["words"], exported["words"]);
    assert_eq!(imported["file_bytes"], exported["file_bytes"]);
    assert!(fs::read(&back).unwrap() == fs::read(&file).unwrap());
    assert!(folder.no_temporary_files());
}

#[test]
fn export_of_several_pages_comes_back() {
    let folder = Folder::new();
    let file = bake(&folder);
    let page = folder.path("city.png");
    let exported = json(&["export", &file, "--texture", &page, "--max-side", "64", "--json"]);
    let pages = exported["pages"].as_u64().unwrap();
    assert!(pages > 2 && exported["width"] == 64, "{exported}");
    let last = format!("city.{}.png", pages - 1);
    assert!(folder.exists("city.1.png") && folder.exists(&last));
    let back = folder.path("back.adumbra");
    assert_eq!(adumbra(&["import", &page, "-o", &back]).0, 0);
    assert!(fs::read(&back).unwrap() == fs::read(&file).unwrap());

    fs::remove_file(folder.path(&last)).unwrap();
    let (code, error) = adumbra(&["import", &page, "-o", &folder.path("none.adumbra")]);
    assert_eq!(code, 3, "{error}");
    assert!(error.contains("is missing") && error.contains(&last), "{error}");
    assert!(!folder.exists("none.adumbra"));
}

#[test]
fn import_refuses_changed_pictures_and_leaves_the_output_alone() {
    let folder = Folder::new();
    let page = export(&folder, &bake(&folder));
    let output = folder.write("kept.adumbra", b"kept");
    let rgba = DynamicImage::ImageRgba8(open(&page));
    let (w, h) = (rgba.width(), rgba.height());
    let save = |name: &str, picture: &DynamicImage| {
        let path = folder.path(name);
        picture.save_with_format(&path, ImageFormat::from_path(Path::new(name)).unwrap()).unwrap();
        path
    };
    let jpeg = save("photo.jpg", &DynamicImage::ImageRgb8(rgba.to_rgb8()));
    let through_jpeg = DynamicImage::ImageRgba8(open(&jpeg));
    let palette = folder.path("palette.png");
    write_palette(&palette, w, h);
    let nearest = image::imageops::FilterType::Nearest;
    let cases = [
        (jpeg, "a JPEG"),
        (save("jpeg.png", &through_jpeg), "re-encoded with loss"),
        (save("cropped.png", &rgba.crop_imm(0, 0, w - 16, h)), "cropped"),
        (save("topless.png", &rgba.crop_imm(0, 16, w, h - 16)), "cropped"),
        (save("bottomless.png", &rgba.crop_imm(0, 0, w, h - 1)), "cropped"),
        (save("half.png", &rgba.resize_exact(w / 2, h / 2, nearest)), "resized"),
        (save("double.png", &rgba.resize_exact(w * 2, h * 2, nearest)), "resized"),
        (palette, "palette"),
        (save("deep.png", &DynamicImage::ImageRgba16(rgba.to_rgba16())), "16 bits"),
        (save("rgb.png", &DynamicImage::ImageRgb8(rgba.to_rgb8())), "without alpha"),
        (save("grey.png", &DynamicImage::ImageLuma8(rgba.to_luma8())), "grey"),
        (folder.write("other.png", b"no picture"), "not a PNG"),
        (folder.path("absent.png"), "check the name"),
    ];
    for (picture, reason) in &cases {
        let (code, error) = adumbra(&["import", picture, "-o", &output]);
        assert_eq!(code, 3, "{picture}: {error}");
        assert!(error.contains(reason) && error.contains(picture.as_str()), "{picture}: {error}");
        assert_eq!(fs::read(&output).unwrap(), b"kept", "{picture}");
    }
    // The same pixels written by another program are the same words.
    let resaved = save("resaved.png", &rgba);
    assert_eq!(adumbra(&["import", &resaved, "-o", &output]).0, 0);
    assert!(folder.no_temporary_files());
}

fn write_palette(path: &str, width: u32, height: u32) {
    let mut encoder = png::Encoder::new(fs::File::create(path).unwrap(), width, height);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_palette((0..=255).flat_map(|c| [c, c, c]).collect::<Vec<u8>>());
    let pixels = vec![7; (width * height) as usize];
    encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
}

#[test]
fn export_faults_have_their_exit_codes() {
    let folder = Folder::new();
    let file = bake(&folder);
    let page = export(&folder, &file);
    let kept = folder.write("kept.png", b"kept");
    let broken = folder.write("broken.adumbra", &fs::read(&file).unwrap()[..1000]);
    let cases: &[(&[&str], i32, &str)] = &[
        (&["export", &file], 2, "--texture"),
        (&["export", &file, "--texture", &kept, "--max-side", "63"], 2, "63"),
        (&["export", &file, "--texture", &kept, "--max-side", "8193"], 2, "8193"),
        (&["import", &kept], 2, "--output"),
        (&["export", &broken, "--texture", &kept], 3, "cut off"),
        (&["export", &kept, "--texture", &page], 3, "not a shadow file"),
        (&["export", &file, "--texture", &file], 2, "the shadow file itself"),
        (&["import", &page, "-o", &page], 2, "the picture itself"),
        (&["export", &file, "--texture", &folder.path("no/where.png")], 3, "does not exist"),
    ];
    for (arguments, code, words) in cases {
        let (found, error) = adumbra(arguments);
        assert_eq!(found, *code, "{arguments:?}: {error}");
        assert!(error.contains(words), "{arguments:?}: {error}");
        assert_eq!(fs::read(&kept).unwrap(), b"kept");
    }
    assert_eq!(adumbra(&["import", &page, "-o", &kept]).0, 0);
    assert!(fs::read(&kept).unwrap() == fs::read(&file).unwrap(), "neither input was touched");
}

#[test]
fn export_for_a_web_page_writes_the_file_and_its_compressed_copy() {
    let folder = Folder::new();
    let file = bake(&folder);
    let web = folder.path("web.adumbra");
    let exported = json(&["export", &file, "--web", &web, "--json"]);
    assert_eq!(exported["layout"], "packed");
    let bytes = fs::read(&file).unwrap();
    assert!(fs::read(&web).unwrap() == bytes);
    let compressed = fs::read(format!("{web}.br")).unwrap();
    assert_eq!(exported["compressed_bytes"].as_u64(), Some(compressed.len() as u64));
    assert!(compressed.len() < bytes.len(), "{} {}", compressed.len(), bytes.len());
    let mut back = Vec::new();
    brotli::Decompressor::new(&*compressed, 4096).read_to_end(&mut back).unwrap();
    assert!(back == bytes);
    // Again: the same bytes, and the file itself may be the copy.
    let printed = Command::new(program()).args(["export", &web, "--web", &web]).output().unwrap();
    let text = String::from_utf8_lossy(&printed.stdout);
    assert!(printed.status.success(), "{}", stderr(&printed));
    assert!(text.contains("lookUp") && text.contains("loadAsync('web.adumbra')"), "{text}");
    assert!(fs::read(format!("{web}.br")).unwrap() == compressed);
    assert!(folder.no_temporary_files());
}

#[test]
fn export_for_a_web_page_refuses_what_it_cannot_write() {
    let folder = Folder::new();
    let file = bake(&folder);
    let (code, error) = adumbra(&["export", &file]);
    assert!(code == 2 && error.contains("--web"), "{error}");
    let (code, error) = adumbra(&["export", &file, "--web", &folder.path("no/such/web.adumbra")]);
    assert!(code != 0 && error.contains("no/such"), "{error}");
    let tree = folder.path("tree.adumbra");
    let scene = folder.path("city.glb");
    let (code, error) = adumbra(&[
        "bake",
        &scene,
        "--frame",
        "world",
        "--resolution",
        "64",
        "--progress",
        "none",
        "-o",
        &tree,
    ]);
    assert_eq!(code, 0, "{error}");
    let (code, error) = adumbra(&["export", &tree, "--web", &folder.path("web.adumbra")]);
    assert!(code != 0 && error.contains("world-aligned"), "{error}");
    assert!(!Path::new(&folder.path("web.adumbra.br")).exists());
}
