//! Errors from loading, generating or writing a scene.

use std::path::PathBuf;

use adumbra::IoError;

use crate::Omission;
use crate::one_line::one_line;
use crate::unmatched::UnmatchedPattern;

/// Any error of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refused to read or write something.
    #[error(transparent)]
    Io(#[from] IoError),
    /// The ground that is to be added is too small or too large.
    #[error(
        "the size of the ground: {factor:?} is out of range; it must be from 1 to 1000 times the scene's extent"
    )]
    GroundSize {
        /// How many times as wide as the scene it was to be.
        factor: f64,
    },
    /// The file extension is not one of the supported ones.
    #[error("{path:?}: unknown scene format; give a .glb, .gltf, .obj or .ply file", path = path.display())]
    UnknownSceneFormat {
        /// The scene file.
        path: PathBuf,
    },
    /// The caller asked for an up axis other than Y for a glTF file.
    #[error("{path:?}: glTF files are Y up by definition; leave the up axis out", path = path.display())]
    GltfIsYUp {
        /// The scene file.
        path: PathBuf,
    },
    /// A scene cannot be edited as requested.
    #[error("cannot edit the scene: {what}")]
    Edits {
        /// Which edit, and why.
        what: String,
    },
    /// The scene file does not parse.
    #[error("{path:?}: not a valid {format} file: {what}; export it again or check that it is complete", path = path.display(), what = one_line(what))]
    SceneParse {
        /// The scene file.
        path: PathBuf,
        /// "glTF", "OBJ" or "PLY".
        format: &'static str,
        /// What the parser found.
        what: String,
    },
    /// The glTF file requires an extension that is not supported.
    #[error("{path:?}: requires the glTF extension {extension}, which is not supported; export the scene without it", path = path.display(), extension = one_line(extension))]
    RequiredExtension {
        /// The scene file.
        path: PathBuf,
        /// The extension's name.
        extension: String,
    },
    /// The file is a glTF version other than 2.0, or requires one.
    #[error("{path:?}: glTF {version}; convert it to 2.0", path = path.display(), version = one_line(version))]
    GltfVersion {
        /// The scene file.
        path: PathBuf,
        /// The version.
        version: String,
    },
    /// The scene needs a decoder that this crate was built without.
    #[error(
        "{path:?}: is compressed with {what}, and this program was built without the feature {feature} that decodes it; build it with that feature, or export the scene uncompressed",
        path = path.display()
    )]
    MissingFeature {
        /// The scene file.
        path: PathBuf,
        /// The form of compression: a glTF extension's name, or a file format.
        what: &'static str,
        /// The feature of this crate, and of the programs, that decodes it.
        feature: &'static str,
    },
    /// A texture that decides where a material is opaque cannot be read.
    #[error("{path:?}: material {material:?} needs the texture {texture}: {what}; provide a readable image, or load the scene with its alpha ignored", path = path.display(), texture = one_line(texture), what = one_line(what))]
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
    /// The scene references a file outside its own folder.
    #[error(
        "{path:?}: {place} references {named:?}, which is outside the scene's folder; copy it into that folder and reference it there, or allow files outside it if you trust the scene",
        path = path.display(), place = one_line(place)
    )]
    OutsideScene {
        /// The scene file.
        path: PathBuf,
        /// The part of the scene that references it, such as "buffer 0".
        place: String,
        /// The file name as written in the scene.
        named: String,
    },
    /// A device, a pipe or a socket was found where a scene file was expected.
    #[error(
        "{path:?} ({place}): not a regular file but a device, a pipe or a socket; copy the data into a file",
        path = path.display(), place = one_line(place)
    )]
    NotRegularFile {
        /// The file.
        path: PathBuf,
        /// What references it: the scene itself, or a part of a scene.
        place: String,
    },
    /// Loading the scene would hold more memory than is allowed.
    #[error(
        "{path:?}: loading needs about {} MiB with {}, but {} MiB are allowed; raise the memory limit if you trust the scene, or make it smaller",
        needed_bytes.div_ceil(1 << 20), one_line(what), limit_bytes >> 20, path = path.display()
    )]
    SceneMemory {
        /// The scene file.
        path: PathBuf,
        /// What was about to be allocated: a texture, a mesh …
        what: String,
        /// Bytes that would be held, including everything so far.
        needed_bytes: u64,
        /// The limit in force.
        limit_bytes: u64,
    },
    /// The scene holds no triangle that could cast a shadow.
    #[error("{path:?}: contains no triangles{reason}", path = path.display())]
    NoTriangles {
        /// The scene file.
        path: PathBuf,
        /// Why there are none.
        reason: EmptyReason,
    },
    /// A raster of heights is faulty.
    #[error("{name}: the raster has {what}")]
    Raster {
        /// The raster.
        name: String,
        /// What is wrong.
        what: String,
    },
    /// The transmissivities of triangles are faulty.
    #[error("{name}: wrong transmissivities: {what}")]
    Transmissivities {
        /// The triangles' name.
        name: String,
        /// What is wrong.
        what: String,
    },
    /// A vertex or a node transform is NaN or infinite.
    #[error("{path:?}: {what} is NaN or infinite; repair the mesh in the program that made it", path = path.display(), what = one_line(what))]
    NotFinite {
        /// The scene file.
        path: PathBuf,
        /// Which mesh and vertex, or which node.
        what: String,
    },
    /// All vertices are at one point.
    #[error("{path:?}: the scene has zero extent: all its vertices are at one point; check the export's scale", path = path.display())]
    ZeroExtent {
        /// The scene file.
        path: PathBuf,
    },
    /// A triangle references a vertex that does not exist.
    #[error("{path:?}: mesh {mesh:?} uses vertex {index}, but has only {vertices}; export it again", path = path.display())]
    IndexOutOfRange {
        /// The scene file.
        path: PathBuf,
        /// The mesh's name.
        mesh: String,
        /// The requested vertex.
        index: u64,
        /// Number of vertices.
        vertices: u64,
    },
    /// The loader leaves out part of the file, and [`LoadOptions::strict`](crate::LoadOptions::strict)
    /// forbids that.
    #[error("{path:?}: not all of it can be loaded: {}; export it without these, or load it without strict", list(omissions), path = path.display())]
    Omitted {
        /// The scene file.
        path: PathBuf,
        /// What was left out.
        omissions: Vec<Omission>,
    },
    /// Patterns match no name in the scene, and [`LoadOptions::strict`](crate::LoadOptions::strict) forbids
    /// that.
    #[error("{path:?}: {}; correct the patterns, or load it without strict", list(patterns), path = path.display())]
    Unmatched {
        /// The scene file.
        path: PathBuf,
        /// The patterns.
        patterns: Vec<UnmatchedPattern>,
    },
    /// A name filter is not a valid glob.
    #[error("the pattern {pattern:?} is not a valid glob: {what}")]
    Pattern {
        /// The pattern.
        pattern: String,
        /// What is wrong with it.
        what: String,
    },
}

fn list(things: &[impl ToString]) -> String {
    things.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

/// The patterns that match nothing, as text to append to a message.
fn among(unmatched: &[UnmatchedPattern]) -> String {
    if unmatched.is_empty() { String::new() } else { format!(": {}", list(unmatched)) }
}

/// Why a scene holds no triangle that could cast a shadow. Its text continues the sentence "contains no
/// triangles".
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum EmptyReason {
    /// Everything is animated, and the policy is [`MoverPolicy::Skip`](crate::MoverPolicy::Skip).
    #[error(" that are static: all {instances} instances are animated; load them frozen in their first pose")]
    AllAnimated {
        /// Number of animated instances.
        instances: u64,
    },
    /// All triangles are degenerate.
    #[error(" with an area: all {triangles} have zero area")]
    ZeroArea {
        /// Number of degenerate triangles.
        triangles: u64,
    },
    /// The name filter keeps no triangles.
    #[error(" after the name filter; check its patterns against the names in the scene{}", among(.unmatched))]
    Filtered {
        /// The patterns that match nothing.
        unmatched: Vec<UnmatchedPattern>,
    },
    /// Extras of nodes, meshes or materials mark everything as not casting.
    #[error(" that cast a shadow: all are marked as not casting in their extras")]
    NoneCasts,
    /// The default scene of a glTF file is empty.
    #[error(": its default scene has no nodes; choose another scene as the default where it was exported")]
    EmptyScene,
    /// The file holds only points.
    #[error("; a point cloud casts no shadow: give a file with faces")]
    PointCloud,
    /// The loader leaves out everything in the file.
    #[error("; it holds only {}", list(.omissions))]
    OnlyOmitted {
        /// What was left out.
        omissions: Vec<Omission>,
    },
    /// The file holds no triangles.
    #[error("; check what was exported")]
    NoneStored,
}

/// Result type used throughout the crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;
