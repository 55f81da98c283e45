//! The 384 bytes before the sections. They are those of a shadow file, but for the magic and the layout. The fields are read and written here
//! in file order.

use std::f64::consts::PI;

use adumbra::file::fields::{
    Encoder, Kind, UNIT_TOLERANCE, bounds, check_bounds, check_finite, check_voxel_size, field, identify, sun,
};
use adumbra::file::sections::{Section, check_sections};
use adumbra::grid::vec3::{cross, dot};
use adumbra::grid::{Bounds, Frame, LightGrid};
use adumbra::layout::{LEAF_NODE_LEVEL, MAX_ROOT_LEVEL, top_dims};
use adumbra::{Bias, FileSettings, FormatError, Receivers};

use crate::dag::layout::DagLayout;
use crate::dag::packed::POOL_WORDS;

/// A file with a graph of the 2014 paper. The line break reveals files that were copied in text mode.
const KIND: Kind =
    Kind { magic: *b"ADUMDAG\n", shown: "\"ADUMDAG\\n\"", name: "graph file", version: 1, oldest: 1 };
/// The first eight bytes.
pub const DAG_MAGIC: [u8; 8] = KIND.magic;
/// Size of the header in bytes.
pub const DAG_HEADER_BYTES: usize = 384;

const ASSUME_GROUND: u32 = 1;
const CLOSED_REGIONS: u32 = 1 << 1;
const IGNORE_ALPHA: u32 = 1 << 2;
const STATIC_RECEIVERS: u32 = 1 << 3;
const HAS_BOUNDS: u32 = 1 << 4;
/// Values of the field `frame`.
const LIGHT_FRAME: u32 = 0;
const OBLIQUE_FRAME: u32 = 1;
const ALL_FLAGS: u32 = (1 << 5) - 1;

/// Section names, in file order.
pub(super) const SECTIONS: [&str; 3] = ["top", "nodes", "leaf_masks"];

/// The header of a file, which can be read without its voxels. Every field has been checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    /// Placement of the voxels in the world.
    pub grid: LightGrid,
    /// Settings of the bake.
    pub settings: FileSettings,
    /// A root cube spans 2^root_level voxels along each side.
    pub root_level: u32,
    /// Number of root cubes along x, y, z.
    pub top_dims: [u32; 3],
    /// Layout of the voxels.
    pub layout: DagLayout,
    /// Section table: top, nodes and leaf masks.
    pub sections: [Section; 3],
}

impl Header {
    /// Returns the exact length in bytes of a file with this header.
    pub fn file_bytes(&self) -> u64 {
        self.sections[2].end()
    }

    /// Encodes the header.
    pub fn encode(&self) -> [u8; DAG_HEADER_BYTES] {
        let (grid, settings) = (&self.grid, &self.settings);
        let mut out = Encoder::new(&KIND);
        out.u32s(&[flags(settings), settings.resolution]);
        out.u32s(&grid.size);
        out.u32s(&[self.root_level]);
        out.u32s(&self.top_dims);
        out.u32s(&[self.layout.number()]);
        out.f64s(&[grid.voxel_size]);
        out.f64s(&grid.sun.towards());
        out.f64s(&grid.corner);
        out.f64s(grid.axes.as_flattened());
        out.f64s(&[settings.thickness_world]);
        let bias = settings.bias;
        out.f64s(&[bias.constant_texels, bias.slope_texels, bias.normal_offset_texels]);
        out.bounds(settings.bounds);
        out.u64s(&[settings.triangles, settings.instances]);
        out.sections(&self.sections);
        let (frame, yaw_radians) = match grid.frame {
            Frame::Light => (LIGHT_FRAME, 0.0),
            Frame::Oblique { yaw_radians } => (OBLIQUE_FRAME, yaw_radians),
        };
        out.u32s(&[settings.switch_within_voxels, frame]);
        out.f64s(&[yaw_radians]);
        out.sealed()
    }

    /// Reads and checks the header at the start of `bytes`, which may continue after it.
    ///
    /// # Errors
    /// Returns the fault with the values found.
    pub fn parse(bytes: &[u8]) -> Result<Self, FormatError> {
        let (_, mut fields) = identify::<DAG_HEADER_BYTES>(bytes, &KIND)?;
        let flags = fields.u32()?;
        let resolution = fields.u32()?;
        let size = fields.u32s()?;
        let root_level = fields.u32()?;
        let top_dims = fields.u32s()?;
        let layout = fields.u32()?;
        let voxel_size = fields.f64()?;
        let towards = fields.f64s()?;
        let place = fields.f64s()?;
        let axes = [fields.f64s()?, fields.f64s()?, fields.f64s()?];
        let thickness_world = fields.f64()?;
        let [constant_texels, slope_texels, normal_offset_texels] = fields.f64s()?;
        let box_given = Bounds { min: fields.f64s()?, max: fields.f64s()? };
        let (triangles, instances) = (fields.u64()?, fields.u64()?);
        let sections = fields.sections()?;
        let switch_within_voxels = fields.u32()?;
        let frame_number = fields.u32()?;
        let [yaw_radians] = fields.f64s()?;
        fields.end("reserved words 92 to 94")?;

        let Some(layout) = DagLayout::from_number(layout) else {
            return Err(field("layout", layout.to_string(), "0 (plain) or 1 (packed)"));
        };
        if flags & !ALL_FLAGS != 0 {
            return Err(field("flags", format!("{flags:#x}"), "limited to bits 0 to 4"));
        }
        let bounds = bounds(flags & HAS_BOUNDS != 0, "4", box_given)?;
        let sun = sun(towards)?;
        let frame = frame(frame_number, yaw_radians)?;
        let edges = frame.edges(&sun, &axes);
        let grid = LightGrid { sun, frame, voxel_size, corner: place, axes, edges, size };
        let settings = FileSettings {
            resolution,
            thickness_world,
            assume_ground: flags & ASSUME_GROUND != 0,
            closed_regions: flags & CLOSED_REGIONS != 0,
            ignore_alpha: flags & IGNORE_ALPHA != 0,
            receivers: if flags & STATIC_RECEIVERS != 0 { Receivers::Static } else { Receivers::All },
            switch_within_voxels,
            bounds,
            bias: Bias { constant_texels, slope_texels, normal_offset_texels },
            triangles,
            instances,
        };
        let header = Self { grid, settings, root_level, top_dims, layout, sections };
        header.check()?;
        Ok(header)
    }

    /// Checks every value. The writer calls it too, so that nothing is written that cannot be read.
    pub(super) fn check(&self) -> Result<(), FormatError> {
        check_settings(&self.settings)?;
        check_grid(&self.grid)?;
        let level = self.root_level;
        if !(LEAF_NODE_LEVEL..=MAX_ROOT_LEVEL).contains(&level) {
            return Err(field("root_level", level.to_string(), "from 3 to 20"));
        }
        let dims = top_dims(self.grid.size, level);
        if self.top_dims != dims {
            let expected =
                format!("{dims:?}, as follows from size {:?} and root_level {level}", self.grid.size);
            return Err(field("top_dims", format!("{:?}", self.top_dims), expected));
        }
        self.check_sections()
    }

    fn check_sections(&self) -> Result<(), FormatError> {
        let product = |dims: &[u32]| dims.iter().try_fold(4_u64, |n, &d| n.checked_mul(u64::from(d)));
        let too_much = || "more than a file can hold".to_owned();
        check_sections(DAG_HEADER_BYTES, &SECTIONS, &self.sections, |i, length| {
            let (element, limit) = self.layout.elements()[i];
            match (i, self.layout) {
                (0, DagLayout::Plain) => {
                    let roots = product(&self.top_dims);
                    return (Some(length) != roots).then(|| roots.map_or_else(too_much, |r| r.to_string()));
                }
                (0, DagLayout::Packed) => {
                    // Pools, columns and roots. The number of roots is stored in the section itself.
                    let columns = product(&self.top_dims[..2]).and_then(|c| c.checked_mul(2));
                    let least = columns.and_then(|c| c.checked_add(4 * (POOL_WORDS as u64 + 1)));
                    let good = length % 4 == 0 && least.is_some_and(|least| length >= least);
                    let at_least = |l| format!("a multiple of 4, at least {l}");
                    return (!good).then(|| least.map_or_else(too_much, at_least));
                }
                _ => {}
            }
            let fits = length % element == 0 && length <= limit;
            (!fits).then(|| format!("a multiple of {element} up to {limit}"))
        })
    }
}

fn check_settings(settings: &FileSettings) -> Result<(), FormatError> {
    if settings.resolution == 0 {
        return Err(field("resolution", "0", "at least 1"));
    }
    let thickness = settings.thickness_world;
    if !(thickness.is_finite() && thickness >= 0.0) {
        return Err(field("thickness", thickness.to_string(), "a finite number, zero or more"));
    }
    let bias = settings.bias;
    check_finite("bias", &[bias.constant_texels, bias.slope_texels, bias.normal_offset_texels], bias)?;
    check_bounds(&settings.bounds)
}

fn check_grid(grid: &LightGrid) -> Result<(), FormatError> {
    if grid.size.contains(&0) {
        return Err(field("size", format!("{:?}", grid.size), "at least 1 along each axis"));
    }
    check_voxel_size(grid.voxel_size)?;
    check_finite("corner", &grid.corner, grid.corner)?;
    let expected = match grid.frame {
        Frame::Light if !is_along_light(grid) => "orthonormal and right-handed, the third away from the sun",
        Frame::Oblique { .. } if !is_upright(grid) => "those of the oblique frame for this sun and yaw",
        _ => return Ok(()),
    };
    Err(field("axes", format!("{:?}", grid.axes), expected))
}

// Both are written so that a NaN anywhere fails.

fn is_along_light(grid: &LightGrid) -> bool {
    let [x, y, z] = grid.axes;
    let to_sun = grid.sun.towards();
    let unit = [x, y, z].iter().all(|a| (dot(*a, *a) - 1.0).abs() <= UNIT_TOLERANCE);
    let square = [dot(x, y), dot(y, z), dot(z, x)].iter().all(|d| d.abs() <= UNIT_TOLERANCE);
    let right_handed = dot(cross(x, y), z) > 0.0;
    unit && square && right_handed && (0..3).all(|a| (z[a] + to_sun[a]).abs() <= UNIT_TOLERANCE)
}

fn is_upright(grid: &LightGrid) -> bool {
    let expected = grid.frame.axes(&grid.sun);
    let pairs = grid.axes.as_flattened().iter().zip(expected.as_flattened());
    // Under a low sun the shear is large.
    pairs.into_iter().all(|(a, b)| (a - b).abs() <= UNIT_TOLERANCE * (1.0 + b.abs()))
}

/// Returns the frame of a header.
fn frame(number: u32, yaw_radians: f64) -> Result<Frame, FormatError> {
    match number {
        LIGHT_FRAME if yaw_radians.to_bits() == 0 => Ok(Frame::Light),
        LIGHT_FRAME => {
            Err(field("yaw", yaw_radians.to_string(), "zero, because the frame is that of the light"))
        }
        OBLIQUE_FRAME if (-PI..=PI).contains(&yaw_radians) => Ok(Frame::Oblique { yaw_radians }),
        OBLIQUE_FRAME => Err(field("yaw", yaw_radians.to_string(), "from -pi to pi")),
        _ => Err(field("frame", number.to_string(), "0 (light) or 1 (oblique)")),
    }
}

fn flags(settings: &FileSettings) -> u32 {
    let bit = |set: bool, flag: u32| if set { flag } else { 0 };
    bit(settings.assume_ground, ASSUME_GROUND)
        | bit(settings.closed_regions, CLOSED_REGIONS)
        | bit(settings.ignore_alpha, IGNORE_ALPHA)
        | bit(settings.receivers == Receivers::Static, STATIC_RECEIVERS)
        | bit(settings.bounds.is_some(), HAS_BOUNDS)
}
