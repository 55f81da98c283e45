//! The settings and the placement of a grid, as headers hold them: those of shadow files and those of graph
//! files, which `adumbra-papers` defines.

use std::f64::consts::PI;

use crate::error::FormatError;
use crate::file::fields::{UNIT_TOLERANCE, bounds, check_bounds, check_finite, check_voxel_size, field};
use crate::grid::vec3::{cross, dot};
use crate::grid::{Bounds, Frame, LightGrid};
use crate::settings::{FileSettings, Receivers};

const ASSUME_GROUND: u32 = 1;
const CLOSED_REGIONS: u32 = 1 << 1;
const IGNORE_ALPHA: u32 = 1 << 2;
const STATIC_RECEIVERS: u32 = 1 << 3;
const HAS_BOUNDS: u32 = 1 << 4;
const SCENE_IS_Z_UP: u32 = 1 << 5;
const ALL_FLAGS: u32 = (1 << 6) - 1;

/// Values of the field `frame`.
const LIGHT_FRAME: u32 = 0;
const OBLIQUE_FRAME: u32 = 1;

/// Returns the field `flags` of these settings.
pub fn flags(settings: &FileSettings) -> u32 {
    let bit = |set: bool, flag: u32| if set { flag } else { 0 };
    bit(settings.assume_ground, ASSUME_GROUND)
        | bit(settings.closed_regions, CLOSED_REGIONS)
        | bit(settings.ignore_alpha, IGNORE_ALPHA)
        | bit(settings.receivers == Receivers::Static, STATIC_RECEIVERS)
        | bit(settings.bounds.is_some(), HAS_BOUNDS)
        | bit(settings.scene_is_z_up, SCENE_IS_Z_UP)
}

/// Returns settings with the values of the field `flags`. `box_given` is the field `bounds`.
///
/// # Errors
/// Returns [`FormatError::HeaderField`] for unknown flags, and for bounds that the flags do not announce.
pub fn with_flags(
    settings: FileSettings,
    flags: u32,
    box_given: Bounds,
) -> Result<FileSettings, FormatError> {
    if flags & !ALL_FLAGS != 0 {
        return Err(field("flags", format!("{flags:#x}"), "limited to bits 0 to 5"));
    }
    Ok(FileSettings {
        assume_ground: flags & ASSUME_GROUND != 0,
        closed_regions: flags & CLOSED_REGIONS != 0,
        ignore_alpha: flags & IGNORE_ALPHA != 0,
        scene_is_z_up: flags & SCENE_IS_Z_UP != 0,
        receivers: if flags & STATIC_RECEIVERS != 0 { Receivers::Static } else { Receivers::All },
        bounds: bounds(flags & HAS_BOUNDS != 0, "4", box_given)?,
        ..settings
    })
}

/// Checks settings.
///
/// # Errors
/// Returns [`FormatError::HeaderField`] with the field that is not valid.
pub fn check_settings(settings: &FileSettings) -> Result<(), FormatError> {
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

/// Returns the fields `frame` and `yaw` of a frame.
pub fn frame_fields(frame: Frame) -> (u32, f64) {
    match frame {
        Frame::Light => (LIGHT_FRAME, 0.0),
        Frame::Oblique { yaw_radians } => (OBLIQUE_FRAME, yaw_radians),
    }
}

/// Checks the placement of a grid.
///
/// # Errors
/// Returns [`FormatError::HeaderField`] with the field that is not valid.
pub fn check_grid(grid: &LightGrid) -> Result<(), FormatError> {
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

// Both checks fail if any component is NaN.

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

/// Returns the frame of a grid.
///
/// # Errors
/// Returns [`FormatError::HeaderField`] if there is no such frame, or it has no such angle.
pub fn frame(number: u32, yaw_radians: f64) -> Result<Frame, FormatError> {
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
