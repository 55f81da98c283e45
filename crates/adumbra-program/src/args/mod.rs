//! Groups of options that several verbs share and that need only the core library.

mod values;

use std::path::{Path, PathBuf, absolute};

use adumbra::{IoError, Sun};
use adumbra_scene::{Edits, LoadOptions, MoverPolicy, NameFilter, Scene, UpAxis, is_gltf};
use clap::builder::{PossibleValuesParser, TypedValueParser};
pub use values::{numbers, parse_bounds, parse_bytes, parse_size, parse_triple};

use crate::exit::Failure;
use crate::memory::MemoryLimit;
use crate::sun::{ChosenSun, SunSource, sun_of_scene_with_warnings};

/// Options that give the direction of the sun.
#[derive(clap::Args)]
pub struct SunArgs {
    /// Direction towards the sun [default: the scene's first directional light that shines, or 0.5,0.8,0.35]
    ///
    /// In world space, of any length.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = parse_triple,
        conflicts_with_all = ["azimuth", "elevation"])]
    sun: Option<[f64; 3]>,
    /// Azimuth of the sun in degrees, clockwise from -Z
    ///
    /// As seen from above: 90 is +X.
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true, requires = "elevation")]
    azimuth: Option<f64>,
    /// Elevation of the sun in degrees above the horizon
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    elevation: Option<f64>,
}

impl SunArgs {
    /// Whether any of these options was given.
    pub fn is_given(&self) -> bool {
        self.sun.is_some() || self.elevation.is_some()
    }

    /// Returns the sun that was given.
    ///
    /// # Errors
    ///
    /// Returns [`Failure::Reader`] if the direction is not finite or has no length, or if the sun is below
    /// the horizon.
    pub fn given(&self) -> Result<Option<Sun>, Failure> {
        Ok(match (self.elevation, self.sun) {
            (Some(elevation), _) => Some(Sun::from_angles(self.azimuth.unwrap_or(0.0), elevation)?),
            (None, Some(towards)) => Some(Sun::from_direction(towards)?),
            (None, None) => None,
        })
    }

    /// Returns the sun that was given for a scene that is not loaded yet. Coordinates in which Z points up
    /// are a common reason for a sun below the horizon: the error says what would be right for them.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`SunArgs::given`].
    pub fn given_for(&self, scene: &Path, load: &SceneArgs) -> Result<Option<Sun>, Failure> {
        self.given().map_err(|failure| match (&failure, self.turned()) {
            (Failure::Reader(adumbra::Error::SunBelowHorizon { .. }), Some([x, y, z])) => {
                let advice = match load.up {
                    Some(UpAxis::Z) => {
                        format!("the world of --up z is Y up: there the direction is {x},{y},{z}")
                    }
                    None if !is_gltf(scene) => {
                        format!("if Z points up in the scene, give --up z --sun {x},{y},{z}")
                    }
                    _ => return failure,
                };
                Failure::Usage(format!("{failure}; {advice}"))
            }
            _ => failure,
        })
    }

    /// Returns the given direction, converted from coordinates in which Z points up; `None` if the result is
    /// not above the horizon either.
    fn turned(&self) -> Option<[f64; 3]> {
        let turned = UpAxis::Z.to_scene(self.sun?);
        Sun::from_direction(turned).ok().map(|_| turned)
    }

    /// Returns the sun that was given, or else that of the scene, which was loaded from `path`. A light of
    /// the scene that cannot be the sun is named on stderr.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`SunArgs::given`].
    pub fn choose(&self, scene: &Scene, path: &Path) -> Result<ChosenSun, Failure> {
        Ok(match (self.given()?, self.sun) {
            (Some(_), Some(towards)) => ChosenSun::from_direction(towards, SunSource::Option.into())?,
            (Some(sun), None) => ChosenSun::from_source(sun, SunSource::Option),
            (None, _) => sun_of_scene_with_warnings(scene, path)?,
        })
    }
}

/// Options that choose what is loaded from a scene.
#[derive(Clone, Debug, PartialEq, Eq, clap::Args, serde::Deserialize, serde::Serialize)]
#[serde(deny_unknown_fields)]
pub struct SceneArgs {
    /// Load only triangles of nodes, meshes or materials of this name
    ///
    /// A pattern; may be repeated.
    #[arg(long, value_name = "GLOB")]
    only: Vec<String>,
    /// Skip triangles of nodes, meshes or materials of this name
    ///
    /// A pattern; may be repeated.
    #[arg(long, value_name = "GLOB")]
    exclude: Vec<String>,
    /// Treat masked and blended materials as opaque
    #[arg(long)]
    pub ignore_alpha: bool,
    /// Load animated instances as static ones, in their first pose
    ///
    /// Without it they are skipped because they move, except that render and view animate them. Give it to
    /// verify if it was given to bake.
    #[arg(long)]
    include_animated: bool,
    /// Up axis of OBJ and PLY [default: the shadow file's, or y]
    ///
    /// With z the scene is turned, and all that is said of the world is said of the turned scene: its (x, y,
    /// z) is (x, z, -y) there. A shadow file says which it was. glTF is Y up by definition.
    #[arg(long, value_name = "y|z", hide_possible_values = true, value_parser = PossibleValuesParser::new(["y", "z"])
        .map(|axis| if axis == "z" { UpAxis::Z } else { UpAxis::Y }))]
    up: Option<UpAxis>,
    /// Also read files outside the scene's folder
    ///
    /// Buffers, images and material libraries. Only for scenes that you trust.
    #[arg(long)]
    allow_outside: bool,
    /// Move, add and remove instances of the scene first
    ///
    /// A JSON file, such as {"moved": [{"instance": "tree_7", "world_from_mesh": [[1,0,0,12], [0,1,0,0],
    /// [0,0,1,-3]]}], "added": [{"like": "tree_7", "world_from_mesh": ...}], "removed": ["bench", 41]}.
    /// Instances have names or numbers.
    #[arg(long, value_name = "FILE")]
    edit: Option<PathBuf>,
    /// Refuse a scene that holds anything the loader leaves out
    ///
    /// Such as lines, or extensions that it does not know.
    #[arg(long)]
    strict: bool,
}

impl SceneArgs {
    /// Returns the options that were given, as words of a command line.
    pub fn words(&self) -> Vec<String> {
        let named = |name: &str, list: &[String]| -> Vec<String> {
            list.iter().map(|glob| format!("{name} {}", quoted(glob))).collect()
        };
        let mut words = [named("--only", &self.only), named("--exclude", &self.exclude)].concat();
        let switches = [
            (self.ignore_alpha, "--ignore-alpha"),
            (self.include_animated, "--include-animated"),
            (self.allow_outside, "--allow-outside"),
            (self.strict, "--strict"),
        ];
        words.extend(self.up.map(|up| format!("--up {}", if up == UpAxis::Z { "z" } else { "y" })));
        words.extend(self.edit.iter().map(|path| format!("--edit {}", quoted(&path.to_string_lossy()))));
        words.extend(switches.iter().filter(|(on, _)| *on).map(|(_, name)| (*name).to_owned()));
        words
    }

    /// Returns the file of edits.
    pub fn edit(&self) -> Option<&PathBuf> {
        self.edit.as_ref()
    }

    /// Returns options that mean the same in any working folder.
    ///
    /// # Errors
    ///
    /// Returns [`Failure::Io`] if the current folder cannot be found.
    pub fn anywhere(&self) -> Result<Self, Failure> {
        let whole = |path: &PathBuf| absolute(path).map_err(IoError::at("find", path));
        Ok(Self { edit: self.edit.as_ref().map(whole).transpose()?, ..self.clone() })
    }

    /// Returns the options of the loader, without a limit on its memory.
    ///
    /// # Errors
    ///
    /// Returns [`Failure::Scene`] if a pattern is not a valid glob, or if the edits cannot be read.
    pub fn load_options(&self) -> Result<LoadOptions, Failure> {
        Ok(LoadOptions {
            filter: NameFilter::new(&self.only, &self.exclude)?,
            color_textures: false,
            ignore_alpha: self.ignore_alpha,
            movers: if self.include_animated { MoverPolicy::Freeze } else { MoverPolicy::Skip },
            up: self.up,
            allow_outside: self.allow_outside,
            max_memory_bytes: None,
            edits: self.edit.as_deref().map_or_else(|| Ok(Edits::default()), Edits::read)?,
            strict: self.strict,
        })
    }
}

/// Quotes a word for a shell.
pub fn quoted(word: &str) -> String {
    format!("'{}'", word.replace('\'', "'\\''"))
}

/// Options of a run: its threads, its memory and the form of what it prints.
#[derive(clap::Args)]
pub struct RunArgs {
    /// Number of threads [default: all cores]
    ///
    /// The result does not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Memory that the program may take, such as 800MiB or 2GiB
    ///
    /// A light-aligned bake that needs more continues with temporary files next to the output, and what
    /// cannot is refused [default: no limit, but for loading a scene 2 GiB plus 64 bytes for each byte of its
    /// files]
    #[arg(long, value_name = "SIZE", value_parser = parse_bytes)]
    pub max_memory: Option<u64>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

impl RunArgs {
    /// Returns the limit on the memory of the process.
    pub fn memory_limit(&self) -> MemoryLimit {
        MemoryLimit::new(self.max_memory)
    }

    /// Checks that `needed_bytes` fit into `--max-memory`, in addition to the memory that the program holds
    /// otherwise. `held_bytes` of them are held already.
    ///
    /// # Errors
    ///
    /// Returns [`Failure::Bake`] if they do not.
    pub fn check_memory(
        &self,
        what: &'static str,
        held_bytes: u64,
        needed_bytes: u64,
    ) -> Result<(), Failure> {
        self.memory_limit().share(held_bytes).check(what, needed_bytes)
    }
}
