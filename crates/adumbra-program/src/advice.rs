//! The options that an error's advice refers to. Libraries name fields and have no options, but the programs' users
//! know only options.

use adumbra::RangeError;

/// Returns the options in parentheses, to follow a message. Empty if there are none.
pub(crate) fn shown(options: Option<&str>) -> String {
    options.map_or_else(String::new, |options| format!(" ({options})"))
}

fn options_of_range(error: &RangeError) -> Option<&'static str> {
    let known = [
        ("the sun's elevation", "--elevation"),
        ("the thickness", "--thickness"),
        ("the switch limit", "--switch-within"),
        ("the builder", "--builder"),
        ("the bounds", "--bounds"),
        ("the resolution", "--resolution"),
        ("the voxel size", "--voxel-size"),
        ("the filter's width", "--filter"),
        ("a term of the bias", "--bias-constant, --bias-slope, --bias-normal"),
        ("a term of the capture bias", "--capture-bias-constant, --capture-bias-slope"),
        ("the rings", "--rings"),
        ("a region", "--region"),
        ("the lossy share", "--lossy"),
    ];
    known.iter().find(|(name, _)| *name == error.name).map(|(_, options)| *options)
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
            EmptyReason::Filtered => Some("--only, --exclude"),
            _ => None,
        },
        E::Pattern { .. } => Some("--only, --exclude"),
        _ => None,
    }
}

pub(crate) fn options_of_bake(error: &adumbra_bake::Error) -> Option<&'static str> {
    use adumbra_bake::{Error as E, PackError};
    match error {
        E::Range(error) => options_of_range(error),
        E::Resolution { .. } => Some("--resolution"),
        E::MemoryLimit { .. } => Some("--max-memory, --resolution, --threads"),
        E::Spill(_) => Some("--max-memory"),
        E::TooManyWords { .. } => Some("--resolution, --bounds"),
        E::Pack(PackError::NotMonotone { .. } | PackError::TooLarge { .. }) => Some("--layout plain"),
        E::File(error) => options_of_reader(error),
        _ => None,
    }
}

pub(crate) fn options_of_tree(error: &adumbra_tree::Error) -> Option<&'static str> {
    use adumbra_tree::{Error as E, TextureError};
    match error {
        // A tree's largest resolution is below that of a light-aligned file.
        E::Range(error) if error.name == "the resolution" => Some("--resolution, --frame light"),
        E::Range(error) => options_of_range(error),
        E::Bake(error) => options_of_bake(error),
        E::Sun(error) => options_of_reader(error),
        E::WordTexture { source: TextureError::TooManyPages { .. }, .. } => Some("--max-side, --resolution"),
        _ => None,
    }
}
