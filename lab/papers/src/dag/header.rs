//! The 384 bytes before the sections. Only the magic and the layout differ from the header of a shadow file.
//! The fields are read and written here in file order.

use adumbra::file::fields::{Encoder, field, sun};
use adumbra::file::placement::{check_grid, check_settings, flags, frame, frame_fields, with_flags};
use adumbra::file::sections::Section;
use adumbra::grid::{Bounds, LightGrid};
use adumbra::{Bias, FileSettings, FormatError};

use crate::dag::layout::DagLayout;
use crate::dag::packed::POOL_WORDS;
use crate::dag::roots::{LEAF_NODE_LEVEL, MAX_ROOT_LEVEL, top_dims};
use crate::kinds::{GRAPH, identify};
use crate::sections::check_sections;

/// The first eight bytes.
pub const DAG_MAGIC: [u8; 8] = GRAPH.magic;
/// Size of the header in bytes.
pub const DAG_HEADER_BYTES: usize = 384;

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
        let mut out = Encoder::new(&GRAPH);
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
        let (frame, yaw_radians) = frame_fields(grid.frame);
        out.u32s(&[settings.switch_within_voxels, frame]);
        out.f64s(&[yaw_radians]);
        out.sealed()
    }

    /// Reads and checks the header at the start of `bytes`, which may continue after it.
    ///
    /// # Errors
    /// Returns the fault with the values found.
    pub fn parse(bytes: &[u8]) -> Result<Self, FormatError> {
        let mut fields = identify::<DAG_HEADER_BYTES>(bytes, &GRAPH)?;
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
        let settings = FileSettings {
            resolution,
            thickness_world,
            switch_within_voxels,
            bias: Bias { constant_texels, slope_texels, normal_offset_texels },
            triangles,
            instances,
            ..FileSettings::default()
        };
        let settings = with_flags(settings, flags, box_given)?;
        let sun = sun(towards)?;
        let frame = frame(frame_number, yaw_radians)?;
        let edges = frame.edges(&sun, &axes);
        let grid = LightGrid { sun, frame, voxel_size, corner: place, axes, edges, size };
        let header = Self { grid, settings, root_level, top_dims, layout, sections };
        header.check()?;
        Ok(header)
    }

    /// Checks every value. The writer calls it too, so that it never writes an unreadable file.
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
