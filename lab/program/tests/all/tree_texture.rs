//! `tree export` and `tree import`: the same file comes back, and pictures that were changed in between are
//! refused.

use std::fs;
use std::path::Path;

use adumbra_testing::{Folder, lab, lab_json};
use image::{DynamicImage, ImageFormat, ImageReader, RgbaImage};

/// Bakes a small city and returns the file's path.
fn bake(folder: &Folder) -> String {
    let scene = folder.generate("city");
    let file = folder.path("city.adumtree");
    let bake = ["tree", "bake", &scene, "--resolution", "256", "--progress", "none", "-o", &file];
    let (code, error) = lab(&bake);
    assert_eq!(code, 0, "{error}");
    file
}

fn export(folder: &Folder, file: &str) -> String {
    let page = folder.path("city.png");
    let (code, error) = lab(&["tree", "export", file, "--texture", &page]);
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
    let exported = lab_json(&["tree", "export", &file, "--texture", &page, "--json"]);
    assert_eq!(exported["pages"], 1);
    assert_eq!(exported["depth"], 8);
    assert_eq!(exported["file_bytes"].as_u64(), Some(fs::metadata(&file).unwrap().len()));
    assert_eq!(exported["texture_bytes"].as_u64(), Some(fs::metadata(&page).unwrap().len()));
    let back = folder.path("back.adumtree");
    let imported = lab_json(&["tree", "import", &page, "-o", &back, "--json"]);
    assert_eq!(imported["words"], exported["words"]);
    assert_eq!(imported["file_bytes"], exported["file_bytes"]);
    assert!(fs::read(&back).unwrap() == fs::read(&file).unwrap());
    assert!(folder.no_temporary_files());
}

#[test]
fn export_of_several_pages_round_trips() {
    let folder = Folder::new();
    let file = bake(&folder);
    let page = folder.path("city.png");
    let exported = lab_json(&["tree", "export", &file, "--texture", &page, "--max-side", "64", "--json"]);
    let pages = exported["pages"].as_u64().unwrap();
    assert!(pages > 2 && exported["width"] == 64, "{exported}");
    let last = format!("city.{}.png", pages - 1);
    assert!(folder.exists("city.1.png") && folder.exists(&last));
    let back = folder.path("back.adumtree");
    assert_eq!(lab(&["tree", "import", &page, "-o", &back]).0, 0);
    assert!(fs::read(&back).unwrap() == fs::read(&file).unwrap());

    fs::remove_file(folder.path(&last)).unwrap();
    let (code, error) = lab(&["tree", "import", &page, "-o", &folder.path("none.adumtree")]);
    assert_eq!(code, 3, "{error}");
    assert!(error.contains("is missing") && error.contains(&last), "{error}");
    assert!(!folder.exists("none.adumtree"));
}

#[test]
fn import_rejects_changed_pictures_and_keeps_output() {
    let folder = Folder::new();
    let page = export(&folder, &bake(&folder));
    let output = folder.write("kept.adumtree", b"kept");
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
        let (code, error) = lab(&["tree", "import", picture, "-o", &output]);
        assert_eq!(code, 3, "{picture}: {error}");
        assert!(error.contains(reason) && error.contains(picture.as_str()), "{picture}: {error}");
        assert_eq!(fs::read(&output).unwrap(), b"kept", "{picture}");
    }
    // The same pixels written by another program are the same words.
    let resaved = save("resaved.png", &rgba);
    assert_eq!(lab(&["tree", "import", &resaved, "-o", &output]).0, 0);
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
fn export_errors_have_expected_exit_codes() {
    let folder = Folder::new();
    let file = bake(&folder);
    let page = export(&folder, &file);
    let kept = folder.write("kept.png", b"kept");
    let broken = folder.write("broken.adumtree", &fs::read(&file).unwrap()[..1000]);
    let cases: &[(&[&str], i32, &str)] = &[
        (&["tree", "export", &file], 2, "--texture"),
        (&["tree", "export", &file, "--texture", &kept, "--max-side", "63"], 2, "63"),
        (&["tree", "export", &file, "--texture", &kept, "--max-side", "8193"], 2, "8193"),
        (&["tree", "import", &kept], 2, "--output"),
        (&["tree", "export", &broken, "--texture", &kept], 3, "cut off"),
        (&["tree", "export", &kept, "--texture", &page], 3, "not a shadow file"),
        (&["tree", "export", &file, "--texture", &file], 2, "the shadow file itself"),
        (&["tree", "import", &page, "-o", &page], 2, "the picture itself"),
        (&["tree", "export", &file, "--texture", &folder.path("no/where.png")], 3, "does not exist"),
    ];
    for (arguments, code, words) in cases {
        let (found, error) = lab(arguments);
        assert_eq!(found, *code, "{arguments:?}: {error}");
        assert!(error.contains(words), "{arguments:?}: {error}");
        assert_eq!(fs::read(&kept).unwrap(), b"kept");
    }
    assert_eq!(lab(&["tree", "import", &page, "-o", &kept]).0, 0);
    assert!(fs::read(&kept).unwrap() == fs::read(&file).unwrap(), "neither input was touched");
}
