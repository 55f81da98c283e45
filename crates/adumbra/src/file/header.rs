//! The first 256 bytes of a file: the fields that apply to all of its grids. The offsets are in
//! `spec/adumbra-file.md`. The fields are read and written here in file order.

use crate::error::FormatError;
use crate::file::fields::{Encoder, LIGHT, field, identify};
use crate::file::placement::{check_settings, flags, with_flags};
use crate::grid::{Bounds, Region};
use crate::settings::{Bias, Encoding, FileSettings};

/// The first eight bytes. The line break reveals files that were copied in text mode.
pub const MAGIC: [u8; 8] = LIGHT.magic;
/// The version that is written and read.
pub const VERSION: u32 = LIGHT.version;
/// Size of the header in bytes.
pub const HEADER_BYTES: usize = 256;
/// Size of an entry of the directory, which follows the header, in bytes.
pub const GRID_BYTES: usize = 256;
/// Largest number of levels of a file: each is four times as coarse as the one before it.
pub const MAX_LEVELS: u32 = 8;

/// The header of a file. Every field has been checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Header {
    /// Settings of the bake.
    pub settings: FileSettings,
    /// How common sections and bundles are stored.
    pub encoding: Encoding,
    /// Number of grids in the directory.
    pub grids: u32,
    /// CRC-32 of the directory.
    pub directory_checksum: u32,
    /// Length of the file in bytes.
    pub file_bytes: u64,
}

impl Header {
    /// Encodes the header.
    pub fn encode(&self) -> [u8; HEADER_BYTES] {
        let settings = &self.settings;
        let mut out = Encoder::new(&LIGHT);
        let encoding = if self.encoding == Encoding::Raw { RAW } else { CODED };
        out.u32s(&[flags(settings), settings.resolution, self.grids, encoding]);
        out.f64s(&[settings.thickness_world]);
        let bias = settings.bias;
        out.f64s(&[bias.constant_texels, bias.slope_texels, bias.normal_offset_texels]);
        out.bounds(settings.bounds);
        out.u64s(&[settings.triangles, settings.instances]);
        out.u32s(&[settings.switch_within_voxels, self.directory_checksum]);
        out.u64s(&[self.file_bytes]);
        out.u32s(&region_fields(settings.region));
        out.u32s(&[settings.dark_after_voxels]);
        out.sealed()
    }

    /// Reads and checks the header at the start of `bytes`, which may continue after it.
    ///
    /// # Errors
    /// Returns the fault with the values found.
    pub fn parse(bytes: &[u8]) -> Result<Self, FormatError> {
        let mut fields = identify::<HEADER_BYTES>(bytes, &LIGHT)?;
        let [flags, resolution, grids, encoding] = fields.u32s()?;
        let thickness_world = fields.f64()?;
        let [constant_texels, slope_texels, normal_offset_texels] = fields.f64s()?;
        let box_given = Bounds { min: fields.f64s()?, max: fields.f64s()? };
        let (triangles, instances) = (fields.u64()?, fields.u64()?);
        let [switch_within_voxels, directory_checksum] = fields.u32s()?;
        let file_bytes = fields.u64()?;
        let region = fields.u32s()?;
        let dark_after_voxels = fields.u32()?;
        fields.end("reserved words 40 to 62")?;

        let encoding = match encoding {
            RAW => Encoding::Raw,
            CODED => Encoding::Coded,
            _ => return Err(field("encoding", encoding.to_string(), "0 (raw) or 1 (coded)")),
        };
        let settings = FileSettings {
            resolution,
            thickness_world,
            switch_within_voxels,
            dark_after_voxels,
            bias: Bias { constant_texels, slope_texels, normal_offset_texels },
            triangles,
            instances,
            region: region_of(region)?,
            ..FileSettings::default()
        };
        let settings = with_flags(settings, flags, box_given)?;
        let header = Self { settings, encoding, grids, directory_checksum, file_bytes };
        header.check()?;
        let front = (HEADER_BYTES + directory_bytes(grids)) as u64;
        if file_bytes < front {
            return Err(field("file_bytes", file_bytes.to_string(), format!("at least {front}")));
        }
        Ok(header)
    }

    /// Checks every value. The writer calls it too, so that nothing is written that cannot be read.
    pub(super) fn check(&self) -> Result<(), FormatError> {
        check_settings(&self.settings)?;
        region_of(region_fields(self.settings.region))?;
        if !(1..=MAX_LEVELS).contains(&self.grids) {
            return Err(field("grids", self.grids.to_string(), format!("from 1 to {MAX_LEVELS}")));
        }
        Ok(())
    }
}

/// Returns the fields of a region: its side and its numbers along x and y, or zeros.
fn region_fields(region: Option<Region>) -> [u32; 3] {
    region.map_or([0; 3], |Region { x, y, texels }| [texels, x.cast_unsigned(), y.cast_unsigned()])
}

/// Returns the region of these fields.
///
/// # Errors
/// Returns [`FormatError::HeaderField`] if there is no such region.
fn region_of([texels, x, y]: [u32; 3]) -> Result<Option<Region>, FormatError> {
    let [x, y] = [x, y].map(u32::cast_signed);
    match texels {
        0 if [x, y] == [0, 0] => Ok(None),
        _ if texels.is_power_of_two() && REGION_TEXELS.contains(&texels) => Ok(Some(Region { y, x, texels })),
        _ => {
            let value = format!("({x}, {y}) of {texels} texels");
            Err(field("region", value, "zeros, or a side that is a power of two from 16 to 131072"))
        }
    }
}

/// Texels a side of a region.
const REGION_TEXELS: std::ops::RangeInclusive<u32> = 1 << 4..=1 << 17;

/// Returns the length in bytes of a directory of this many grids.
pub(super) fn directory_bytes(grids: u32) -> usize {
    grids as usize * GRID_BYTES
}

/// Values of the field `encoding`.
const RAW: u32 = 0;
const CODED: u32 = 1;
