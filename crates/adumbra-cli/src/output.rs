//! Files the program writes beside the shadow file: whole or not at all.

use std::io::Write;
use std::path::Path;

use adumbra::Error;
use adumbra::picture::Picture;
use image::ImageEncoder;

use crate::exit::Failure;

/// Writes `bytes` to a temporary file beside `path` and renames it.
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let folder = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(folder).map_err(Error::io("create", path))?;
    file.write_all(bytes).and_then(|()| file.flush()).map_err(Error::io("write", path))?;
    file.persist(path).map_err(|e| Error::io("write", path)(e.error))?;
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
