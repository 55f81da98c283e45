//! Words in PNG pages: either exactly the input comes back, or an error describes what happened to the
//! picture.

use std::fs;
use std::io::Cursor;

use adumbra::IoError;
use adumbra_papers::tree::texture::{Layout, Page, decode, encode, page_path};
use adumbra_papers::tree::{
    Classify, Error, State, TextureError, TreeBody, TreeBuilder, TreeFile, VoxelTree, texture,
};
use image::{DynamicImage, ImageFormat, RgbaImage};
use proptest::prelude::*;

/// Stafford's mixing function, as a cheap source of random bits.
fn random(i: u64) -> u64 {
    let v = i.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let v = (v ^ v >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    v ^ v >> 29
}

/// Words like those of trees: mostly inner nodes with small and large indices, some leaves. All byte values
/// occur, alpha 0 included.
fn words(count: usize) -> Vec<u32> {
    (0..count as u64)
        .map(|i| {
            let r = random(i);
            match r >> 60 {
                0 => 0x8000_0000 | r as u32 & 1,
                1..=3 => 0xc000_0000 | r as u32 & 255,
                _ => (r >> 8) as u32 % (count as u32 / 8 + 1) * 8 + 1,
            }
        })
        .collect()
}

fn png_of(page: &Page) -> Vec<u8> {
    let mut bytes = Vec::new();
    page.write_png(&mut bytes).unwrap();
    bytes
}

fn picture(page: &Page) -> RgbaImage {
    RgbaImage::from_raw(page.width, page.height, page.rgba.clone()).unwrap()
}

fn encoded(picture: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

fn page_of(picture: RgbaImage) -> Page {
    Page { width: picture.width(), height: picture.height(), rgba: picture.into_raw() }
}

fn decode_one(picture: RgbaImage) -> TextureError {
    decode(&[page_of(picture)]).unwrap_err()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn texture_round_trip_of_any_words(
        words in prop::collection::vec(any::<u32>(), 0..9000),
        rest in prop::collection::vec(any::<u8>(), 0..500),
        max_side in 64_u32..200,
    ) {
        let pages = encode(&words, &rest, max_side).unwrap();
        let read: Vec<Page> = pages.iter().map(|p| Page::from_png(&png_of(p)).unwrap()).collect();
        prop_assert_eq!(&read, &pages);
        prop_assert_eq!(decode(&read), Ok((words, rest)));
    }
}

#[test]
fn texture_round_trip_with_rest_at_page_end() {
    for count in [0, 1, 4031, 4032, 4033, 8060, 8063, 8064] {
        for rest_bytes in [0, 1, 3, 4, 5, 384, 4 * 4032 + 1] {
            let (words, rest) = (words(count), vec![0xa5; rest_bytes]);
            let pages = encode(&words, &rest, 64).unwrap();
            assert_eq!(decode(&pages), Ok((words, rest)), "{count} words, {rest_bytes} bytes");
        }
    }
}

#[test]
fn texture_words_are_at_pixels_given_by_layout() {
    let words = words(10_000);
    let rest = [1, 2, 3];
    for max_side in [64, 100, 128, 8192] {
        let layout = Layout::new(words.len(), rest.len(), max_side).unwrap();
        let pages = encode(&words, &rest, max_side).unwrap();
        assert_eq!(pages.len(), layout.pages as usize);
        let pictures: Vec<RgbaImage> = pages.iter().map(picture).collect();
        for (i, word) in words.iter().enumerate() {
            let [page, x, y] = layout.locate(i as u64).map(|v| v as u32);
            let pixel = pictures[page as usize].get_pixel(x, y).0;
            let channels = [word & 255, word >> 8 & 255, word >> 16 & 255, word >> 24].map(|c| c as u8);
            assert_eq!(pixel, channels, "word {i} at side {max_side}");
        }
        for page in &pages[..pages.len() - 1] {
            assert_eq!([page.width, page.height], [pages[0].width, pages[0].height]);
        }
    }
}

#[test]
fn texture_png_has_no_colour_management_chunk() {
    let png = png_of(&encode(&words(300_000), b"rest", 8192).unwrap()[0]);
    assert_eq!(&png[..8], b"\x89PNG\r\n\x1a\n");
    let (mut at, mut kinds) = (8, Vec::new());
    while at < png.len() {
        let length = u32::from_be_bytes(png[at..at + 4].try_into().unwrap()) as usize;
        kinds.push(String::from_utf8(png[at + 4..at + 8].to_vec()).unwrap());
        if kinds.len() == 1 {
            // 8 bits, RGBA, not interlaced.
            assert_eq!(png[at + 16..at + 21], [8, 6, 0, 0, 0]);
        }
        at += 12 + length;
    }
    kinds.dedup();
    assert_eq!(kinds, ["IHDR", "IDAT", "IEND"]);
}

#[test]
fn texture_rejects_files_other_than_rgba8_png() {
    let page = &encode(&words(200), b"", 64).unwrap()[0];
    let rgba = DynamicImage::ImageRgba8(picture(page));
    let rgb = DynamicImage::ImageRgb8(rgba.to_rgb8());
    let refusal = |bytes: &[u8]| {
        let error = Page::from_png(bytes).unwrap_err();
        (error.to_string(), error)
    };
    for (format, name) in
        [(ImageFormat::Jpeg, "JPEG"), (ImageFormat::WebP, "WebP"), (ImageFormat::Bmp, "BMP")]
    {
        let (text, error) = refusal(&encoded(&rgb, format));
        assert!(matches!(&error, TextureError::NotPng { found } if found.contains(name)), "{text}");
    }
    assert!(matches!(refusal(b"").1, TextureError::NotPng { .. }));
    assert!(refusal(b"ADUMBRA\n....").0.contains("a shadow file itself"));
    assert!(refusal(b"\x89PNG\r\n\x1a\n").0.contains("IHDR"));
    let png = |picture: DynamicImage| encoded(&picture, ImageFormat::Png);
    assert_eq!(refusal(&png(rgb)).1, TextureError::NoAlpha);
    assert_eq!(refusal(&png(DynamicImage::ImageLuma8(rgba.to_luma8()))).1, TextureError::Grey);
    assert_eq!(refusal(&png(DynamicImage::ImageLumaA8(rgba.to_luma_alpha8()))).1, TextureError::Grey);
    assert_eq!(refusal(&png(DynamicImage::ImageLuma16(rgba.to_luma16()))).1, TextureError::Grey);
    assert_eq!(refusal(&png(DynamicImage::ImageRgba16(rgba.to_rgba16()))).1, TextureError::SixteenBits);
    assert_eq!(refusal(&png(DynamicImage::ImageRgb16(rgba.to_rgb16()))).1, TextureError::SixteenBits);
    assert_eq!(refusal(&palette_png()).1, TextureError::Palette);
    for hint in ["palette", "optimisation"] {
        assert!(refusal(&palette_png()).0.contains(hint));
    }
}

fn palette_png() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2, 2);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_palette(vec![0, 1, 2, 250, 251, 252]);
    encoder.write_header().unwrap().write_image_data(&[0, 1, 1, 0]).unwrap();
    bytes
}

/// A PNG header that declares this size, with no data.
fn lying_png(width: u32, height: u32) -> Vec<u8> {
    let mut chunk = b"IHDR".to_vec();
    chunk.extend(width.to_be_bytes());
    chunk.extend(height.to_be_bytes());
    chunk.extend([8, 6, 0, 0, 0]);
    let checksum = crc32fast::hash(&chunk).to_be_bytes();
    [b"\x89PNG\r\n\x1a\n\0\0\0\x0d", &chunk[..], &checksum].concat()
}

#[test]
fn texture_rejects_png_header_with_false_size() {
    let large = Page::from_png(&lying_png(8193, 1));
    assert_eq!(large, Err(TextureError::TooLarge { width: 8193, height: 1 }));
    let huge = Page::from_png(&lying_png(u32::MAX, u32::MAX));
    assert_eq!(huge, Err(TextureError::TooLarge { width: u32::MAX, height: u32::MAX }));
    for (width, height) in [(8192, 8192), (0, 5), (1, 1)] {
        let error = Page::from_png(&lying_png(width, height)).unwrap_err();
        assert!(matches!(error, TextureError::Damaged { .. }), "{error}");
    }
}

#[test]
fn texture_rejects_truncated_and_changed_pngs() {
    let page = &encode(&words(600), b"rest", 64).unwrap()[0];
    let png = png_of(page);
    for length in 0..png.len() {
        assert!(Page::from_png(&png[..length]).is_err(), "{length} of {} bytes", png.len());
    }
    for i in 0..4000_u64 {
        let mut changed = png.clone();
        let at = random(i) as usize % png.len();
        changed[at] ^= 1 << (i % 8);
        // A changed header byte that has no meaning here may leave the pixels unchanged.
        if let Ok(read) = Page::from_png(&changed) {
            assert!(read == *page || decode(&[read]).is_err(), "byte {at}");
        }
    }
}

#[test]
fn texture_rejects_every_changed_byte_of_a_page() {
    let page = &encode(&words(150), b"rest!", 64).unwrap()[0];
    for at in 0..page.rgba.len() {
        for bit in 0..8 {
            let mut changed = page.clone();
            changed.rgba[at] ^= 1 << bit;
            assert!(decode(&[changed]).is_err(), "byte {at}, bit {bit}");
        }
    }
    let short = Page { rgba: page.rgba[4..].to_vec(), ..page.clone() };
    assert!(matches!(decode(&[short]), Err(TextureError::PageBytes { .. })));
    let empty = Page { width: 0, height: 0, rgba: Vec::new() };
    assert!(matches!(decode(&[empty]), Err(TextureError::PageBytes { .. })));
    assert_eq!(decode(&[]), Err(TextureError::NoPages));
}

#[test]
fn texture_errors_name_how_picture_was_altered() {
    let page = &encode(&words(40_000), b"rest", 8192).unwrap()[0];
    let whole = picture(page);
    let [w, h] = [page.width, page.height];
    let crop = |x, y, width, height| image::imageops::crop_imm(&whole, x, y, width, height).to_image();

    let error = decode_one(crop(0, 0, w - 40, h));
    assert_eq!(error, TextureError::WrongSize { found: [w - 40, h], expected: [w, h] });
    assert!(error.to_string().contains("cropped or resized"));
    assert!(matches!(decode_one(crop(0, 0, 7, h)), TextureError::WrongSize { .. }));
    assert!(decode_one(crop(0, 0, 4, h)).to_string().contains("cropped"));
    let error = decode_one(crop(0, 9, w, h - 9));
    assert_eq!(error, TextureError::WrongSize { found: [w, h - 9], expected: [w, h] });
    let error = decode_one(crop(0, 0, w, h - 1));
    assert_eq!(error, TextureError::NoSignature { width: w, height: h - 1 });
    assert!(decode_one(crop(20, 0, w - 20, h)).to_string().contains("no signature: cropped"));

    let mut extended = RgbaImage::new(w, h + 3);
    image::imageops::replace(&mut extended, &whole, 0, 0);
    assert_eq!(decode_one(extended), TextureError::SignatureMoved { row: h - 1, last: h + 2 });
    let flipped = image::imageops::flip_vertical(&whole);
    assert_eq!(decode_one(flipped), TextureError::SignatureMoved { row: 0, last: h - 1 });

    for filter in [image::imageops::FilterType::Nearest, image::imageops::FilterType::Triangle] {
        for [width, height] in [[w * 2, h * 2], [w / 2, h / 2], [w + 1, h]] {
            let error = decode_one(image::imageops::resize(&whole, width, height, filter));
            assert!(error.to_string().contains("resized"), "{error}");
        }
    }

    let jpeg = encoded(
        &DynamicImage::ImageRgb8(DynamicImage::ImageRgba8(whole.clone()).to_rgb8()),
        ImageFormat::Jpeg,
    );
    let mut through_jpeg = image::load_from_memory(&jpeg).unwrap().to_rgba8();
    let error = decode_one(through_jpeg.clone());
    assert!(error.to_string().contains("re-encoded with loss"), "{error}");
    // If the signature row happens to be intact, its checksum of the pixels reveals the change.
    image::imageops::replace(&mut through_jpeg, &crop(0, h - 1, w, 1), 0, i64::from(h) - 1);
    let error = decode_one(through_jpeg);
    assert!(matches!(error, TextureError::PageChecksum { .. }), "{error}");

    let mut premultiplied = whole.clone();
    for pixel in premultiplied.pixels_mut().take((w * (h - 1)) as usize) {
        let [r, g, b, a] = pixel.0;
        pixel.0 = [r, g, b]
            .map(|c| (u32::from(c) * u32::from(a) / 255) as u8)
            .into_iter()
            .chain([a])
            .collect::<Vec<_>>()
            .try_into()
            .unwrap();
    }
    let error = decode_one(premultiplied);
    assert!(error.to_string().contains("premultiplied"), "{error}");
}

#[test]
fn texture_rejects_pages_of_different_exports() {
    let words_a = words(9000);
    let mut words_b = words_a.clone();
    words_b[8999] ^= 1;
    let [a, b] = [&words_a, &words_b].map(|w| encode(w, b"rest", 64).unwrap());
    assert_eq!(a.len(), 3);
    let take = |pages: &[&Page]| decode(&pages.iter().map(|&p| p.clone()).collect::<Vec<_>>());
    assert_eq!(take(&[&a[0], &a[1]]), Err(TextureError::MissingPage { page: 2, pages: 3 }));
    assert_eq!(take(&[&a[0]]), Err(TextureError::MissingPage { page: 1, pages: 3 }));
    assert_eq!(take(&[&a[0], &b[1], &a[2]]), Err(TextureError::MixedExports { page: 1 }));
    assert_eq!(take(&[&a[0], &a[2], &a[1]]), Err(TextureError::MisplacedPage { found: 2, expected: 1 }));
    assert_eq!(take(&[&a[1], &a[0], &a[2]]), Err(TextureError::MisplacedPage { found: 1, expected: 0 }));
    assert_eq!(take(&[&a[0], &a[1], &a[2], &a[2]]), Err(TextureError::ExtraPages { given: 4, pages: 3 }));
    let other_size = encode(&words_a, b"rest", 70).unwrap();
    assert_eq!(take(&[&a[0], &other_size[1], &a[2]]), Err(TextureError::MixedExports { page: 1 }));
}

#[test]
fn texture_pages_are_numbered_files_in_one_folder() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("city.day.png");
    let words = words(9000);
    let written = texture::write(&path, &words, b"rest", 64).unwrap();
    let names: Vec<String> =
        (0..3).map(|p| page_path(&path, p).file_name().unwrap().to_string_lossy().into_owned()).collect();
    assert_eq!(names, ["city.day.png", "city.day.1.png", "city.day.2.png"]);
    let bytes: u64 = (0..3).map(|p| fs::metadata(page_path(&path, p)).unwrap().len()).sum();
    assert_eq!((written.layout.pages, written.bytes), (3, bytes));
    assert_eq!(texture::read(&path).unwrap(), (words.clone(), b"rest".to_vec()));

    // A one-page export to the same path leaves the later pages, which are not read.
    texture::write(&path, &words[..100], b"", 64).unwrap();
    assert_eq!(texture::read(&path).unwrap().0, words[..100]);

    texture::write(&path, &words, b"rest", 64).unwrap();
    fs::remove_file(page_path(&path, 1)).unwrap();
    let error = texture::read(&path).unwrap_err();
    assert!(error.to_string().contains("city.day.1.png"), "{error}");
    assert!(
        matches!(error, Error::WordTexture { source: TextureError::MissingPage { page: 1, pages: 3 }, .. }),
        "{error}"
    );
    assert!(matches!(
        texture::read(&folder.path().join("none.png")),
        Err(Error::Io(IoError { action: "read", .. }))
    ));
}

#[test]
fn texture_write_checks_all_paths_before_writing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.png");
    texture::write(&path, &words(50), b"", 64).unwrap();
    let before = fs::read(&path).unwrap();
    fs::create_dir(page_path(&path, 1)).unwrap();
    assert!(matches!(texture::write(&path, &words(9000), b"", 64), Err(Error::Io(_))));
    assert_eq!(fs::read(&path).unwrap(), before);
    assert!(!page_path(&path, 2).exists());
}

#[test]
fn texture_reads_interlaced_pngs() {
    // Adam7 with a single pixel is just that pixel; the flag alone must not cause a refusal.
    let mut bytes = lying_png(1, 1);
    bytes[28] = 1;
    let checksum = crc32fast::hash(&bytes[12..29]).to_be_bytes();
    bytes[29..33].copy_from_slice(&checksum);
    let data = [0x78, 0x01, 0x01, 5, 0, 0xfa, 0xff, 0, 9, 8, 7, 6];
    let adler = [0, 9, 8, 7, 6].iter().fold((1_u32, 0_u32), |(a, b), &v| (a + v, b + a + v));
    let zlib = [&data[..], &(adler.1 << 16 | adler.0).to_be_bytes()].concat();
    for (kind, body) in [(b"IDAT", &zlib[..]), (b"IEND", &[])] {
        let chunk = [&kind[..], body].concat();
        bytes.extend((body.len() as u32).to_be_bytes());
        bytes.extend(&chunk);
        bytes.extend(crc32fast::hash(&chunk).to_be_bytes());
    }
    assert_eq!(Page::from_png(&bytes), Ok(Page { width: 1, height: 1, rgba: vec![9, 8, 7, 6] }));
}

/// Noise below a height, lit above: almost no two blocks are equal, so its tree is large.
struct Noise {
    height: u32,
}

impl Noise {
    /// The mask of the eight voxels from `xyz` up.
    fn mask(&self, xyz: [u32; 3]) -> u8 {
        let [x, y, z] = xyz.map(|c| u64::from(c >> 1));
        if xyz[1] >= self.height { 255 } else { (random(x << 42 | y << 21 | z) >> 32) as u8 }
    }
}

impl Classify for Noise {
    fn cell(&self, xyz: [u32; 3], _: u32) -> State {
        let child = (xyz[0] & 1) << 2 | (xyz[1] & 1) << 1 | xyz[2] & 1;
        if self.mask(xyz) >> child & 1 == 1 { State::Lit } else { State::Shadowed }
    }

    fn eight(&self, xyz: [u32; 3], _: u32) -> [u8; 2] {
        [self.mask(xyz), 0]
    }

    fn cube(&self, xyz: [u32; 3], _: u32) -> Option<State> {
        (xyz[1] >= self.height).then_some(State::Lit)
    }
}

#[test]
#[ignore = "slow: takes over eight seconds"]
fn texture_round_trip_of_a_tree_of_a_hundred_megabytes() {
    let depth = 10;
    let tree = TreeBuilder::Pooled.tree(&Noise { height: 176 }, depth, true).unwrap().number(depth);
    let words = tree.into_words();
    assert!(words.len() >= 25_000_000, "{} words", words.len());
    let tree = VoxelTree::from_words(depth, words).unwrap();

    let vector = adumbra_testing::vectors("tree/valid/example_8.adumbra");
    let mut file = TreeFile::read(vector).unwrap();
    (file.space.depth, file.regions.base_depth) = (depth, depth);
    file.body = TreeBody::Words(tree);
    file.check().unwrap();

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("large.png");
    let rest = file.without_words().unwrap();
    let TreeBody::Words(tree) = &file.body else { panic!("no words") };
    let written = texture::write(&path, tree.words(), &rest, 3000).unwrap();
    assert_eq!((written.layout.width, written.layout.pages), (2048, 5));
    let (words, rest) = texture::read(&path).unwrap();
    let read = TreeFile::with_words(&rest, &words).unwrap();
    assert!(read.encode() == file.encode());
}
