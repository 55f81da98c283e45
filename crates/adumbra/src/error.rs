//! The crate's one error type: every variant carries what was wrong, where, and (in its message) the mend.

use std::path::PathBuf;

use crate::dag::packed::PackError;
use crate::format::{FormatError, WordsError};
use crate::texture::TextureError;

/// Everything that can go wrong in this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refused to read or write something.
    #[error("cannot {action} {path:?}: {source}", path = path.display())]
    Io {
        /// What was attempted: "read", "create", "write" …
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A graph has no packed form.
    #[error(transparent)]
    Pack(#[from] PackError),
    /// The file's ending is none of the supported ones.
    #[error("{path:?}: unknown scene format; give a .glb, .gltf, .obj or .ply file", path = path.display())]
    UnknownSceneFormat {
        /// The scene file.
        path: PathBuf,
    },
    /// The scene file does not parse.
    #[error("{path:?}: not a valid {format} file: {what}; export it again or check that it is complete", path = path.display())]
    SceneParse {
        /// The scene file.
        path: PathBuf,
        /// "glTF", "OBJ" or "PLY".
        format: &'static str,
        /// What the parser found.
        what: String,
    },
    /// The glTF file requires an extension that is not supported.
    #[error("{path:?}: requires the glTF extension {extension}, which is not supported; export the scene without it", path = path.display())]
    RequiredExtension {
        /// The scene file.
        path: PathBuf,
        /// The extension's name.
        extension: String,
    },
    /// A texture that decides where a material is opaque cannot be read.
    #[error("{path:?}: material {material:?} needs the texture {texture}: {what}; put an image there that can be read, or use --ignore-alpha", path = path.display())]
    Texture {
        /// The scene file.
        path: PathBuf,
        /// The material that uses it.
        material: String,
        /// The texture's file or index.
        texture: String,
        /// What went wrong.
        what: String,
    },
    /// The scene names a file outside its own folder.
    #[error(
        "{path:?}: {place} names {named:?}, which lies outside the scene's folder; copy it into that folder and name it from there, or use --allow-outside if you trust the scene",
        path = path.display()
    )]
    OutsideScene {
        /// The scene file.
        path: PathBuf,
        /// What in the scene names it, such as "buffer 0".
        place: String,
        /// The file as the scene names it.
        named: String,
    },
    /// A device, a pipe or a socket stands where a file of a scene is expected.
    #[error(
        "{path:?} ({place}): not a regular file but a device, a pipe or a socket; copy the data into a file",
        path = path.display()
    )]
    NotRegularFile {
        /// The file.
        path: PathBuf,
        /// What names it: the scene itself, or a part of a scene.
        place: String,
    },
    /// Loading the scene would hold more memory than is allowed.
    #[error(
        "{path:?}: loading needs about {} MiB with {what}, but {} MiB are allowed; raise --max-memory if you trust the scene, or make it smaller",
        needed_bytes.div_ceil(1 << 20), limit_bytes >> 20, path = path.display()
    )]
    SceneMemory {
        /// The scene file.
        path: PathBuf,
        /// What was about to be made: a texture, a mesh …
        what: String,
        /// Bytes that would be held, with everything before.
        needed_bytes: u64,
        /// The limit in force.
        limit_bytes: u64,
    },
    /// The scene holds no triangle that could cast a shadow.
    #[error("{path:?}: holds no triangles{hint}", path = path.display())]
    NoTriangles {
        /// The scene file.
        path: PathBuf,
        /// A continuation of the sentence, for instance that a filter took all of them.
        hint: String,
    },
    /// A vertex or a node transform is NaN or infinite.
    #[error("{path:?}: {what} is NaN or infinite; repair the mesh in the program that made it", path = path.display())]
    NotFinite {
        /// The scene file.
        path: PathBuf,
        /// Which mesh and vertex, or which node.
        what: String,
    },
    /// All vertices lie in one point.
    #[error("{path:?}: the scene has zero extent: all its vertices lie in one point; check the export's scale", path = path.display())]
    ZeroExtent {
        /// The scene file.
        path: PathBuf,
    },
    /// A triangle names a vertex that does not exist.
    #[error("{path:?}: mesh {mesh:?} uses vertex {index}, but has only {vertices}; export it again", path = path.display())]
    IndexOutOfRange {
        /// The scene file.
        path: PathBuf,
        /// The mesh's name.
        mesh: String,
        /// The vertex asked for.
        index: u64,
        /// How many there are.
        vertices: u64,
    },
    /// A name filter is not a valid glob.
    #[error("the pattern {pattern:?} is not a valid glob: {what}")]
    Pattern {
        /// The pattern.
        pattern: String,
        /// What is wrong with it.
        what: String,
    },
    /// The sun's direction has zero length or is not finite.
    #[error("the sun's direction ({0}, {1}, {2}) has no direction; give three finite numbers that are not all zero, towards the sun", direction[0], direction[1], direction[2])]
    SunDirection {
        /// The direction given.
        direction: [f64; 3],
    },
    /// The sun is at or below the horizon.
    #[error(
        "the sun is {elevation_degrees:.3}° above the horizon; it casts no shadows from below: give a direction with positive y, or an elevation above 0"
    )]
    SunBelowHorizon {
        /// Elevation in degrees, zero or negative.
        elevation_degrees: f64,
    },
    /// The resolution is not a power of two in range.
    #[error("resolution {resolution} is not a power of two from {min} to {max}; try {suggestion}")]
    Resolution {
        /// The resolution given.
        resolution: u64,
        /// Smallest allowed.
        min: u32,
        /// Largest allowed.
        max: u32,
        /// The next allowed one.
        suggestion: u32,
    },
    /// An option's value is out of its range.
    #[error("{option}: {value} is out of range; it must be {range}")]
    OptionRange {
        /// The option's name.
        option: &'static str,
        /// The value given.
        value: String,
        /// What is allowed.
        range: &'static str,
    },
    /// What is built has more words than its pointers can tell apart.
    #[error(
        "{what} has more words than its pointers can tell apart; lower --resolution, or bake parts with --bounds"
    )]
    TooManyWords {
        /// What is built.
        what: &'static str,
    },
    /// The work does not fit the memory allowed.
    #[error("{what} needs about {} MiB, but {} MiB are allowed; raise --max-memory, lower --resolution or use fewer --threads", needed_bytes >> 20, limit_bytes >> 20)]
    MemoryLimit {
        /// What was being done.
        what: &'static str,
        /// Estimate of the bytes needed.
        needed_bytes: u64,
        /// The limit in force.
        limit_bytes: u64,
    },
    /// A shadow file is not valid.
    #[error("{path:?}: {source}", path = path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: FormatError,
    },
    /// A picture of words is not what an export wrote, or words do not fit pictures.
    #[error("{path:?}: {source}", path = path.display())]
    WordTexture {
        /// The page's file.
        path: PathBuf,
        /// What is wrong with it.
        source: TextureError,
    },
    /// A file has no form as words, or words no file.
    #[error("{path:?}: {source}", path = path.display())]
    Words {
        /// The file, or the first page of the words.
        path: PathBuf,
        /// What is wrong with it.
        source: WordsError,
    },
    /// The caller asked to stop.
    #[error("interrupted; nothing was written")]
    Interrupted,
}

/// Shorthand used across the crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// An [`Error::Io`] for `path`; meant for `map_err`.
    pub fn io(action: &'static str, path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.into();
        move |source| {
            let source = if action == "read" { with_reading_mend(source) } else { source };
            Self::Io { action, path, source }
        }
    }
}

/// Adds to what the system says what can be done about it; the kind stays.
fn with_reading_mend(error: std::io::Error) -> std::io::Error {
    use std::io::ErrorKind;
    let mend = match error.kind() {
        ErrorKind::NotFound => "check the name and the folder it is in",
        ErrorKind::IsADirectory => "it is a folder; name a file in it",
        ErrorKind::NotADirectory => "a part of the path is a file, not a folder; check the path",
        ErrorKind::PermissionDenied => "change its permissions, or choose another file",
        _ => return error,
    };
    std::io::Error::new(error.kind(), format!("{error}; {mend}"))
}
