//! A grid of hours as GeoTIFF: OGC 19-008r4, *OGC GeoTIFF Standard*, 1.1.

use std::io::Cursor;

use tiff::TiffError;
use tiff::encoder::{Compression, TiffEncoder, colortype::Gray32Float};
use tiff::tags::Tag;

use super::traced::Traced;

/// Where the raster is in the world of maps.
#[derive(Clone, Copy)]
pub(super) struct MapPlace {
    /// EPSG number of a projected coordinate system. `None` is a local one.
    pub(super) epsg: Option<u16>,
    /// Easting and northing of the scene's origin.
    pub(super) origin: [f64; 2],
}

/// Key directory: version 1, revision 1.1, and the number of keys.
const DIRECTORY_HEAD: [u16; 3] = [1, 1, 1];
const MODEL_TYPE: u16 = 1024;
const RASTER_TYPE: u16 = 1025;
const CITATION: u16 = 1026;
const PROJECTED_SYSTEM: u16 = 3072;
/// Model type of projected coordinates.
const PROJECTED: u16 = 1;
/// Model type of other coordinates.
const USER_DEFINED: u16 = 32767;
/// Raster type: a pixel is an area.
const PIXEL_IS_AREA: u16 = 1;
const LOCAL_NAME: &str = "local coordinates|";

/// Returns the file: one band of 32-bit floats, hours; cells without ground are not a number. `None` without
/// a grid.
pub(super) fn hours(traced: &Traced, place: MapPlace) -> Option<Result<Vec<u8>, TiffError>> {
    let (grid, cells) = traced.cells()?;
    let values: Vec<f32> = cells.iter().map(|hours| hours.map_or(f32::NAN, |hours| hours as f32)).collect();
    let [west, north] = grid.corner_world;
    // North is -Z.
    let corner = [place.origin[0] + west, place.origin[1] - north];
    Some(encode(&values, grid.size, grid.spacing_world, corner, place.epsg))
}

fn encode(
    values: &[f32],
    [width, height]: [u32; 2],
    spacing: f64,
    [easting, northing]: [f64; 2],
    epsg: Option<u16>,
) -> Result<Vec<u8>, TiffError> {
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder =
        TiffEncoder::new(&mut bytes)?.with_compression(Compression::Deflate(Default::default()));
    let mut image = encoder.new_image::<Gray32Float>(width, height)?;
    let tags = image.encoder();
    tags.write_tag(Tag::ModelPixelScaleTag, &[spacing, spacing, 0.0][..])?;
    tags.write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, easting, northing, 0.0][..])?;
    let system = match epsg {
        Some(epsg) => [
            [MODEL_TYPE, 0, 1, PROJECTED],
            [RASTER_TYPE, 0, 1, PIXEL_IS_AREA],
            [PROJECTED_SYSTEM, 0, 1, epsg],
        ],
        None => [
            [MODEL_TYPE, 0, 1, USER_DEFINED],
            [RASTER_TYPE, 0, 1, PIXEL_IS_AREA],
            [CITATION, Tag::GeoAsciiParamsTag.to_u16(), LOCAL_NAME.len() as u16, 0],
        ],
    };
    let keys: Vec<u16> =
        DIRECTORY_HEAD.into_iter().chain([system.len() as u16]).chain(system.into_iter().flatten()).collect();
    tags.write_tag(Tag::GeoKeyDirectoryTag, &keys[..])?;
    if epsg.is_none() {
        tags.write_tag(Tag::GeoAsciiParamsTag, LOCAL_NAME)?;
    }
    tags.write_tag(Tag::GdalNodata, "nan")?;
    image.write_data(values)?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    use tiff::decoder::{Decoder, DecodingResult};

    use super::*;

    #[test]
    fn tags_place_the_raster_in_map_coordinates() {
        for epsg in [Some(25832), None] {
            let bytes =
                encode(&[1.0, f32::NAN, 3.5, 4.0, 5.0, 6.0], [3, 2], 0.5, [691_000.0, 5_334_000.0], epsg)
                    .unwrap();
            let mut file = Decoder::new(Cursor::new(bytes)).unwrap();
            assert_eq!(file.dimensions().unwrap(), (3, 2));
            let numbers = |file: &mut Decoder<_>, tag| file.get_tag_f64_vec(tag).unwrap();
            assert_eq!(numbers(&mut file, Tag::ModelPixelScaleTag), [0.5, 0.5, 0.0]);
            assert_eq!(
                numbers(&mut file, Tag::ModelTiepointTag),
                [0.0, 0.0, 0.0, 691_000.0, 5_334_000.0, 0.0]
            );
            let keys = file.get_tag_u16_vec(Tag::GeoKeyDirectoryTag).unwrap();
            assert_eq!(keys[..4], [1, 1, 1, 3]);
            let last = epsg.map_or([1026, 34737, 18, 0], |epsg| [3072, 0, 1, epsg]);
            assert_eq!(keys[12..], last);
            assert_eq!(file.get_tag_ascii_string(Tag::GdalNodata).unwrap(), "nan");
            let DecodingResult::F32(values) = file.read_image().unwrap() else { panic!("floats") };
            assert!(values[1].is_nan());
            assert_eq!((values[0], values[2], values[5]), (1.0, 3.5, 6.0));
        }
    }
}
