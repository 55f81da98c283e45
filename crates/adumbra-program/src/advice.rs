//! The options that an error's advice refers to. Libraries name fields and have no options, but the programs'
//! users know only options.

use adumbra::{RangeError, RangeField};

/// Returns the options in parentheses, to follow a message. Empty if there are none.
pub(crate) fn shown(options: Option<&str>) -> String {
    options.map_or_else(String::new, |options| format!(" ({options})"))
}

/// The options that set a field. `None` for parameters of techniques, whose messages name their values, and
/// for values that only callers of the libraries give.
fn options_of_range(error: &RangeError) -> Option<&'static str> {
    Some(match error.field {
        RangeField::SunElevation => "--elevation",
        RangeField::Thickness => "--thickness",
        RangeField::SwitchLimit => "--switch-within",
        RangeField::Levels => "--levels",
        RangeField::Bounds => "--bounds",
        RangeField::Resolution => "--resolution",
        RangeField::VoxelSize => "--voxel-size",
        RangeField::RegionTexels => "--regions",
        RangeField::FilterWidth => "--filter",
        RangeField::BiasTerm => "--bias-constant, --bias-slope, --bias-normal",
        RangeField::Yaw => "--yaw",
        RangeField::TextureWords
        | RangeField::LongestSide
        | RangeField::PenumbraRadius
        | RangeField::PointCount
        | RangeField::GroundSize
        | RangeField::SunDegrees
        | RangeField::Placement => return None,
    })
}

pub(crate) fn options_of_reader(error: &adumbra::Error) -> Option<&'static str> {
    use adumbra::Error as E;
    match error {
        E::Range(error) => options_of_range(error),
        E::SunDirection { .. } => Some("--sun"),
        E::SunBelowHorizon { .. } => Some("--sun, --elevation"),
        _ => None,
    }
}

pub(crate) fn options_of_scene(error: &adumbra_scene::Error) -> Option<&'static str> {
    use adumbra_scene::{EmptyReason, Error as E};
    match error {
        E::Range(error) => options_of_range(error),
        E::Texture { .. } => Some("--ignore-alpha"),
        E::OutsideScene { .. } => Some("--allow-outside"),
        E::SceneMemory { .. } => Some("--max-memory"),
        E::NoTriangles { reason, .. } => match reason {
            EmptyReason::AllAnimated { .. } => Some("--include-animated"),
            EmptyReason::Filtered { .. } => Some("--only, --exclude"),
            _ => None,
        },
        E::GltfIsYUp { .. } => Some("--up"),
        E::Omitted { .. } => Some("--strict"),
        E::Pattern { .. } => Some("--only, --exclude"),
        E::Unmatched { .. } => Some("--strict"),
        _ => None,
    }
}

pub(crate) fn options_of_bake(error: &adumbra_bake::Error) -> Option<&'static str> {
    use adumbra_bake::Error as E;
    match error {
        E::Range(error) => options_of_range(error),
        E::Resolution { .. } => Some("--resolution"),
        E::MemoryLimit { .. } => Some("--max-memory, --resolution, --threads"),
        E::Spill(_) => Some("--max-memory"),
        E::TooManyWords { .. } => Some("--resolution, --bounds"),
        E::File(error) => options_of_reader(error),
        _ => None,
    }
}
