//! The options that an error's advice refers to. Libraries name fields and have no options, but the programs'
//! users know only options.

use adumbra::RangeField;
use adumbra_bake::BakeField;

/// Returns the options in parentheses, to follow a message. Empty if there are none.
pub(crate) fn shown(options: Option<&str>) -> String {
    options.map_or_else(String::new, |options| format!(" ({options})"))
}

/// The options that set a field. `None` for parameters of techniques, whose messages name their values, and
/// for values that only callers of the libraries give.
fn options_of_field(field: RangeField) -> Option<&'static str> {
    Some(match field {
        RangeField::SunElevation => "--elevation",
        RangeField::RegionTexels => "--regions",
        RangeField::FilterWidth => "--filter",
        RangeField::BiasTerm => "--bias-constant, --bias-slope, --bias-normal",
        _ => return None,
    })
}

fn options_of_bake_field(field: BakeField) -> Option<&'static str> {
    Some(match field {
        BakeField::Thickness => "--thickness",
        BakeField::SwitchLimit => "--switch-within",
        BakeField::Levels => "--levels",
        BakeField::Bounds => "--bounds",
        BakeField::Resolution => "--resolution",
        BakeField::VoxelSize => "--voxel-size",
        BakeField::Yaw => "--yaw",
        _ => return None,
    })
}

pub(crate) fn options_of_reader(error: &adumbra::Error) -> Option<&'static str> {
    use adumbra::Error as E;
    match error {
        E::Range(error) => options_of_field(error.field),
        E::SunDirection { .. } => Some("--sun"),
        E::SunBelowHorizon { .. } => Some("--sun, --elevation"),
        _ => None,
    }
}

pub(crate) fn options_of_scene(error: &adumbra_scene::Error) -> Option<&'static str> {
    use adumbra_scene::{EmptyReason, Error as E};
    match error {
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
        E::Range(error) => options_of_bake_field(error.field),
        E::Resolution { .. } => Some("--resolution"),
        E::MemoryLimit { .. } => Some("--max-memory, --resolution, --threads"),
        E::Spill(_) => Some("--max-memory"),
        E::TooManyWords { .. } => Some("--resolution, --bounds"),
        E::File(error) => options_of_reader(error),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_option_of_a_bake_with_a_range_has_its_name() {
        let options = [
            (BakeField::Thickness, "--thickness"),
            (BakeField::SwitchLimit, "--switch-within"),
            (BakeField::Levels, "--levels"),
            (BakeField::Bounds, "--bounds"),
            (BakeField::Resolution, "--resolution"),
            (BakeField::VoxelSize, "--voxel-size"),
            (BakeField::Yaw, "--yaw"),
        ];
        for (field, option) in options {
            assert_eq!(options_of_bake_field(field), Some(option), "{field}");
        }
        assert_eq!(options_of_field(RangeField::RegionTexels), Some("--regions"));
        assert_eq!(options_of_field(RangeField::SunElevation), Some("--elevation"));
        assert_eq!(options_of_field(RangeField::PointCount), None);
    }
}
