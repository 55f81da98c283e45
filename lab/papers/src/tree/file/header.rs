//! The 320 bytes before the sections. The offsets are in `spec/adumbra-tree.md`; the fields are in file
//! order.

use crate::kinds::{TREE, identify};
use crate::sections::check_sections;
use crate::tree::file::AttributeKind;
use crate::tree::file::body::{SYMMETRIC, WORDS};
use crate::tree::settings::{CaptureBias, LossyChange, TreeSettings};
use crate::tree::space::{MAX_REGIONS, TreeSpace};
use crate::tree::word::MAX_DEPTH;
use adumbra::file::fields::{Encoder, bounds, check_bounds, check_finite, check_voxel_size, field, sun};
use adumbra::file::sections::Section;
use adumbra::grid::{Bounds, Sun};
use adumbra::{Bias, FormatError};

/// The first eight bytes of a tree file.
pub const TREE_MAGIC: [u8; 8] = TREE.magic;
/// The version that is written, and the latest that is read.
pub const TREE_VERSION: u32 = TREE.version;
/// Size of the header in bytes.
pub const TREE_HEADER_BYTES: usize = 320;

/// Size of a region record in bytes.
pub(crate) const REGION_BYTES: u64 = 40;
/// Section names, in file order.
pub(crate) const SECTIONS: [&str; 3] = ["regions", "body", "attribute"];
pub(crate) const REGIONS: usize = 0;
pub(crate) const BODY: usize = 1;
pub(crate) const ATTRIBUTE: usize = 2;

const CLOSED_REGIONS: u32 = 1;
const IGNORE_ALPHA: u32 = 1 << 1;
const HAS_BOUNDS: u32 = 1 << 2;
const LOSSY: u32 = 1 << 3;
const ALL_FLAGS: u32 = (1 << 4) - 1;

const NO_ATTRIBUTE: u32 = 0;
const PENUMBRA: u32 = 1;

/// Maximum size in bytes of a body of words: more words than an index can address.
const MAX_WORD_BYTES: u64 = 4 << 31;

/// A header whose fields have all been checked.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Header {
    pub(crate) space: TreeSpace,
    pub(crate) base_depth: u32,
    pub(crate) region_count: u32,
    pub(crate) body_code: u32,
    pub(crate) attribute_kind: Option<AttributeKind>,
    pub(crate) sun: Sun,
    pub(crate) settings: TreeSettings,
    pub(crate) sections: [Section; 3],
}

impl Header {
    /// The exact size in bytes of a file with this header.
    pub(crate) fn file_bytes(&self) -> u64 {
        self.sections[ATTRIBUTE].end()
    }

    pub(crate) fn encode(&self) -> [u8; TREE_HEADER_BYTES] {
        let settings = &self.settings;
        let attribute = match self.attribute_kind {
            None => NO_ATTRIBUTE,
            Some(AttributeKind::Penumbra) => PENUMBRA,
        };
        let mut out = Encoder::new(&TREE);
        out.u32s(&[flags(settings), self.space.depth, self.base_depth, self.region_count]);
        out.u32s(&[self.body_code, attribute]);
        out.f64s(&self.space.p_min);
        out.f64s(&[self.space.voxel_size]);
        out.f64s(&self.sun.towards());
        out.bounds(settings.bounds);
        out.f64s(&[settings.capture_bias.constant_texels, settings.capture_bias.slope_texels]);
        let bias = settings.bias;
        out.f64s(&[bias.constant_texels, bias.slope_texels, bias.normal_offset_texels]);
        let none = LossyChange { max_share: 0.0, leaf_voxels: 0, changed_voxels: 0 };
        let lossy = settings.lossy.unwrap_or(none);
        out.f64s(&[lossy.max_share]);
        out.u64s(&[lossy.leaf_voxels, lossy.changed_voxels, settings.triangles, settings.instances]);
        out.sections(&self.sections);
        out.sealed()
    }

    /// Reads and checks the header at the front of `bytes`.
    pub(crate) fn parse(bytes: &[u8]) -> Result<Self, FormatError> {
        let mut fields = identify::<TREE_HEADER_BYTES>(bytes, &TREE)?;
        let [flags, depth, base_depth, region_count, body_code, attribute_code] = fields.u32s()?;
        let space = TreeSpace { p_min: fields.f64s()?, voxel_size: fields.f64()?, depth };
        let towards = fields.f64s()?;
        let box_given = Bounds { min: fields.f64s()?, max: fields.f64s()? };
        let [constant_texels, slope_texels] = fields.f64s()?;
        let capture_bias = CaptureBias { constant_texels, slope_texels };
        let [constant_texels, slope_texels, normal_offset_texels] = fields.f64s()?;
        let bias = Bias { constant_texels, slope_texels, normal_offset_texels };
        let change = LossyChange {
            max_share: fields.f64()?,
            leaf_voxels: fields.u64()?,
            changed_voxels: fields.u64()?,
        };
        let (triangles, instances) = (fields.u64()?, fields.u64()?);
        let sections = fields.sections()?;
        fields.end("reserved words 74 to 78")?;

        if flags & !ALL_FLAGS != 0 {
            return Err(field("flags", format!("{flags:#x}"), "limited to bits 0 to 3"));
        }
        let attribute_kind = match attribute_code {
            NO_ATTRIBUTE => None,
            PENUMBRA => Some(AttributeKind::Penumbra),
            other => return Err(field("attribute_kind", other.to_string(), "0 or 1")),
        };
        let settings = TreeSettings {
            closed_regions: flags & CLOSED_REGIONS != 0,
            ignore_alpha: flags & IGNORE_ALPHA != 0,
            bounds: bounds(flags & HAS_BOUNDS != 0, "2", box_given)?,
            capture_bias,
            bias,
            lossy: lossy(flags & LOSSY != 0, change)?,
            triangles,
            instances,
        };
        let sun = sun(towards)?;
        let header =
            Self { space, base_depth, region_count, body_code, attribute_kind, sun, settings, sections };
        header.check()?;
        Ok(header)
    }

    /// Checks every value. The writer calls it too, so that it never writes an unreadable file.
    pub(crate) fn check(&self) -> Result<(), FormatError> {
        check_space(&self.space)?;
        if !(1..=self.space.depth).contains(&self.base_depth) {
            let expected = format!("from 1 to the depth {}", self.space.depth);
            return Err(field("base_depth", self.base_depth.to_string(), expected));
        }
        if self.region_count as usize > MAX_REGIONS {
            return Err(field(
                "region_count",
                self.region_count.to_string(),
                format!("at most {MAX_REGIONS}"),
            ));
        }
        if ![WORDS, SYMMETRIC].contains(&self.body_code) {
            return Err(field("body_kind", self.body_code.to_string(), "1 (words) or 2 (symmetric)"));
        }
        if self.body_code == SYMMETRIC && self.attribute_kind.is_some() {
            return Err(field("attribute_kind", "1", "0, because a symmetric body has no attribute"));
        }
        sun(self.sun.towards())?;
        check_settings(&self.settings)?;
        self.check_sections()
    }

    fn check_sections(&self) -> Result<(), FormatError> {
        check_sections(TREE_HEADER_BYTES, &SECTIONS, &self.sections, |i, length| {
            let (fits, expected) = match i {
                REGIONS => {
                    let all = REGION_BYTES * u64::from(self.region_count);
                    (length == all, format!("{all}, {REGION_BYTES} per region"))
                }
                BODY if self.body_code == WORDS => (
                    length > 0 && length % 4 == 0 && length <= MAX_WORD_BYTES,
                    format!("a multiple of 4 from 4 to {MAX_WORD_BYTES}"),
                ),
                BODY => (length > 0, "at least 1".to_owned()),
                _ if self.attribute_kind.is_none() => {
                    (length == 0, "0, because attribute_kind is 0".to_owned())
                }
                _ => (length > 0, "at least 1, because attribute_kind is not 0".to_owned()),
            };
            (!fits).then_some(expected)
        })
    }
}

fn check_space(space: &TreeSpace) -> Result<(), FormatError> {
    if !(1..=MAX_DEPTH).contains(&space.depth) {
        return Err(field("depth", space.depth.to_string(), format!("from 1 to {MAX_DEPTH}")));
    }
    check_finite("p_min", &space.p_min, space.p_min)?;
    check_voxel_size(space.voxel_size)
}

fn check_settings(settings: &TreeSettings) -> Result<(), FormatError> {
    check_bounds(&settings.bounds)?;
    let capture = settings.capture_bias;
    check_finite("capture_bias", &[capture.constant_texels, capture.slope_texels], capture)?;
    let bias = settings.bias;
    check_finite("bias", &[bias.constant_texels, bias.slope_texels, bias.normal_offset_texels], bias)?;
    if let Some(change) = settings.lossy
        && !((0.0..=1.0).contains(&change.max_share) && change.changed_voxels <= change.leaf_voxels)
    {
        let expected = "a share from 0 to 1, with no more changed voxels than leaf voxels";
        return Err(field("lossy", format!("{change:?}"), expected));
    }
    Ok(())
}

/// Returns the change if its flag is set. If the flag is not set, all bits of the change must be zero.
fn lossy(there: bool, change: LossyChange) -> Result<Option<LossyChange>, FormatError> {
    let bits = change.max_share.to_bits() | change.leaf_voxels | change.changed_voxels;
    if !there && bits != 0 {
        return Err(field("lossy", format!("{change:?}"), "zero, because flag bit 3 is not set"));
    }
    Ok(there.then_some(change))
}

fn flags(settings: &TreeSettings) -> u32 {
    let bit = |set: bool, flag: u32| if set { flag } else { 0 };
    bit(settings.closed_regions, CLOSED_REGIONS)
        | bit(settings.ignore_alpha, IGNORE_ALPHA)
        | bit(settings.bounds.is_some(), HAS_BOUNDS)
        | bit(settings.lossy.is_some(), LOSSY)
}
