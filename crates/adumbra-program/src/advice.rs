//! The options that an error's advice refers to. Libraries name fields and have no options, but the programs' users
//! know only options.

use adumbra::RangeError;

/// Returns the options in parentheses, to follow a message. Empty if there are none.
pub(crate) fn shown(options: Option<&str>) -> String {
    options.map_or_else(String::new, |options| format!(" ({options})"))
}

/// The fields that options set, as errors name them, and those options.
const FIELDS: [(&str, &str); 14] = [
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
    ("the yaw", "--yaw"),
];

fn options_of_range(error: &RangeError) -> Option<&'static str> {
    FIELDS.iter().find(|(name, _)| *name == error.name).map(|(_, options)| *options)
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
        E::Omitted { .. } => Some("--strict"),
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

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::path::{Path, PathBuf};

    use super::*;

    /// Fields that no option sets: parameters of techniques, which say themselves what they take, and values that only
    /// callers of the libraries give.
    const WITHOUT_OPTION: [&str; 6] = [
        "the file's size in words",
        "the grid's longest side",
        "the largest radius",
        "the layout",
        "the size of the ground",
        "the sun's angle",
    ];

    fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                sources(&path, found);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                found.push(path);
            }
        }
    }

    /// The names of fields in the range errors of all libraries.
    fn names_of_fields() -> BTreeSet<String> {
        let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        let mut files = Vec::new();
        for name in ["adumbra", "adumbra-scene", "adumbra-bake", "adumbra-tree", "adumbra-truth"] {
            sources(&crates.join(name).join("src"), &mut files);
        }
        let mut names = BTreeSet::new();
        for file in files {
            let text = std::fs::read_to_string(file).unwrap();
            for call in text.split("RangeError::new(").skip(1) {
                if let Some(name) =
                    call.trim_start().strip_prefix('"').and_then(|rest| rest.split('"').next())
                {
                    names.insert(name.replace('\\', ""));
                }
            }
        }
        names
    }

    #[test]
    fn every_range_error_names_the_option_that_sets_its_field() {
        let names = names_of_fields();
        for name in &names {
            let option = FIELDS.iter().any(|(field, _)| field == name);
            let none = WITHOUT_OPTION.contains(&name.as_str());
            assert!(option != none, "{name}: has it an option? It must be in one of both lists");
        }
        let listed = FIELDS.iter().map(|(field, _)| *field).chain(WITHOUT_OPTION);
        let gone: Vec<_> = listed.filter(|field| !names.contains(*field)).collect();
        assert!(gone.is_empty(), "no error names these fields: {gone:?}");
        for (field, options) in FIELDS {
            let failure = crate::exit::Failure::from(RangeError::new(field, "x", "y"));
            assert!(failure.to_string().ends_with(&format!("({options})")), "{failure}");
        }
    }
}
