//! Files the program writes beside the shadow file: whole or not at all.

use std::io::Write;
use std::path::Path;

use adumbra::Error;
use adumbra::files::replace_file;
use adumbra::picture::Picture;
use image::ImageEncoder;

use crate::exit::Failure;

/// Writes `bytes` at `path`.
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    replace_file(path, |file| file.write_all(bytes).map(|()| bytes.len() as u64))?;
    Ok(())
}

/// Writes a picture as PNG.
pub(crate) fn write_png(path: &Path, picture: &Picture) -> Result<(), Failure> {
    let mut bytes = Vec::new();
    image::codecs::png::PngEncoder::new(&mut bytes)
        .write_image(&picture.rgb, picture.width, picture.height, image::ExtendedColorType::Rgb8)
        .map_err(|e| Failure::BadInput(format!("{}: cannot encode the picture: {e}", path.display())))?;
    write_whole(path, &bytes)
}

/// Writes named channels of 32-bit floats as OpenEXR, without loss.
pub(crate) fn write_exr(path: &Path, size: [u32; 2], channels: &[(&str, Vec<f32>)]) -> Result<(), Failure> {
    use exr::prelude::*;
    let list = channels
        .iter()
        .map(|(name, values)| AnyChannel::new(*name, FlatSamples::F32(values.clone())))
        .collect();
    let image = Image::from_layer(Layer::new(
        (size[0] as usize, size[1] as usize),
        LayerAttributes::default(),
        Encoding::SMALL_FAST_LOSSLESS,
        AnyChannels::sort(list),
    ));
    let mut bytes = std::io::Cursor::new(Vec::new());
    image
        .write()
        .to_buffered(&mut bytes)
        .map_err(|e| Failure::BadInput(format!("{}: cannot encode the picture: {e}", path.display())))?;
    write_whole(path, bytes.get_ref())
}

/// Whether two paths lead to one file that exists.
pub(crate) fn same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// Makes a folder and its parents.
pub(crate) fn make_folder(path: &Path) -> Result<(), Failure> {
    Ok(std::fs::create_dir_all(path).map_err(Error::io("create", path))?)
}

/// 12,345,678 as "11.8 MiB".
pub(crate) fn bytes_words(bytes: u64) -> String {
    let units = ["B", "KiB", "MiB", "GiB", "TiB"];
    let mut value = bytes as f64;
    let mut unit = 0;
    while value >= 1024.0 && unit + 1 < units.len() {
        value /= 1024.0;
        unit += 1;
    }
    if unit == 0 { format!("{bytes} B") } else { format!("{value:.1} {}", units[unit]) }
}
