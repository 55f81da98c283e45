//! Baking as an asset step: a `.shadow.ron` beside a glTF scene is loaded as the scene's shadow file.
//!
//! ```ron
//! (
//!     scene: "city.glb",
//!     towards_sun: (0.5, 0.8, 0.35),
//!     resolution: 16384,
//! )
//! ```
//!
//! With Bevy's asset processor the bake runs once, and again when the scene or these settings change; the app
//! ships the baked file. Without the processor every load bakes.

use std::ffi::OsStr;
use std::path::PathBuf;
use std::{fs, io};

use adumbra::{Encoding, Error, ShadowFile, Sun};
use adumbra_bake::{Bake, BakeOptions, Size};
use adumbra_scene::LoadOptions;
use bevy::asset::io::{Reader, Writer};
use bevy::asset::processor::LoadTransformAndSave;
use bevy::asset::saver::{AssetSaver, SavedAsset};
use bevy::asset::transformer::IdentityAssetTransformer;
use bevy::asset::{
    AssetLoader, AssetPath, AsyncWriteExt, LoadContext, ParseAssetPathError, ReadAssetBytesError,
};
use bevy::reflect::TypePath;
use serde::Deserialize;
use tempfile::TempDir;

use crate::threads::pool;
use crate::{BakedShadowFile, DeviceLimits, ShadowFileLoader, ShadowFileSettings};

/// The contents of a `.shadow.ron` file: the scene to bake, and how.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AssetBake {
    /// The scene, a `.glb` or `.gltf`; its path is relative to the folder of this file.
    pub scene: String,
    /// Direction towards the sun in the world, of any length.
    pub towards_sun: [f64; 3],
    /// Texels on the longest side of the world as the sun sees it, a power of two from 8 to 262,144.
    #[serde(default = "usual_resolution")]
    pub resolution: u64,
    /// How far below an open surface its shadow may begin, world units. More makes smaller files.
    #[serde(default)]
    pub thickness_world: f64,
}

fn usual_resolution() -> u64 {
    8192
}

/// The processor of `.shadow.ron` files.
pub(crate) type AssetBakeProcess =
    LoadTransformAndSave<AssetBakeLoader, IdentityAssetTransformer<BakedShadowFile>, ShadowFileSaver>;

/// Loads `.shadow.ron` files: reads the scene that they name and bakes it on separate threads.
#[derive(TypePath, Clone, Debug)]
pub struct AssetBakeLoader {
    limits: DeviceLimits,
}

impl AssetBakeLoader {
    pub(crate) const EXTENSIONS: [&str; 1] = ["shadow.ron"];

    pub(crate) fn new(limits: DeviceLimits) -> Self {
        Self { limits }
    }
}

/// An error of loading a `.shadow.ron` file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AssetBakeError {
    /// The file could not be read, or threads could not be started.
    #[error("the scene could not be baked: {0}")]
    Io(#[from] io::Error),
    /// The file is not as [`AssetBake`] describes it.
    #[error(
        "not a valid .shadow.ron: {0}; it should look like (scene: \"city.glb\", towards_sun: (0.5, 0.8, 0.35), resolution: 8192)"
    )]
    Settings(#[from] ron::error::SpannedError),
    /// The scene's name is not a valid path.
    #[error("the scene's name {0:?} is no path: {1}")]
    Name(String, ParseAssetPathError),
    /// The scene, or a file of it, could not be read.
    #[error("the scene {0} could not be read: {1}")]
    Read(AssetPath<'static>, Box<ReadAssetBytesError>),
    /// The scene is of another format.
    #[error("the scene {0:?} is not a .glb or .gltf; export it as one")]
    NotGltf(String),
    /// The scene is not valid.
    #[error("the scene, read from a copy: {0}")]
    Scene(#[from] adumbra_scene::Error),
    /// The scene could not be baked with these settings.
    #[error(transparent)]
    Bake(#[from] adumbra_bake::Error),
    /// A setting is out of range.
    #[error(transparent)]
    Unusable(#[from] Error),
    /// The threads of the bake ended without a result.
    #[error("the bake ended without a result; its memory may have run out")]
    Lost,
}

impl AssetLoader for AssetBakeLoader {
    type Asset = BakedShadowFile;
    type Settings = ();
    type Error = AssetBakeError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _settings: &(),
        load_context: &mut LoadContext<'_>,
    ) -> Result<BakedShadowFile, AssetBakeError> {
        let mut text = Vec::new();
        reader.read_to_end(&mut text).await?;
        let settings: AssetBake = ron::de::from_bytes(&text)?;
        let sun = Sun::from_direction(settings.towards_sun)?;
        let copy = Copy::new(&settings.scene, load_context).await?;
        let (sender, receiver) = async_channel::bounded(1);
        pool(0)?.spawn(move || {
            // The receiver may have been dropped; ignore it.
            let _ = sender.send_blocking(bake_copy(&copy, &settings, sun));
        });
        let file = receiver.recv().await.map_err(|_| AssetBakeError::Lost)??;
        Ok(BakedShadowFile::new(file, self.limits)?)
    }

    fn extensions(&self) -> &[&str] {
        &Self::EXTENSIONS
    }
}

/// A scene and the files that it names, in a temporary folder that is removed on drop.
struct Copy {
    scene: PathBuf,
    _folder: TempDir,
}

impl Copy {
    /// Copies a scene of any asset source. Each of its files becomes a dependency of the asset.
    async fn new(name: &str, load_context: &mut LoadContext<'_>) -> Result<Self, AssetBakeError> {
        let resolve = |base: &AssetPath<'static>, name: &str| {
            base.resolve_embed_str(name).map_err(|e| AssetBakeError::Name(name.to_owned(), e))
        };
        let path = resolve(load_context.path(), name)?;
        let is_gltf = |e: &OsStr| e.eq_ignore_ascii_case("glb") || e.eq_ignore_ascii_case("gltf");
        let file_name = path.path().file_name().filter(|_| path.path().extension().is_some_and(is_gltf));
        let file_name = file_name.ok_or_else(|| AssetBakeError::NotGltf(name.to_owned()))?;
        let bytes = load_context.read_asset_bytes(&path).await;
        let bytes = bytes.map_err(|e| AssetBakeError::Read(path.clone(), Box::new(e)))?;
        let folder = tempfile::tempdir()?;
        let scene = folder.path().join(file_name);
        for file in adumbra_scene::files_of_gltf(&scene, &bytes)? {
            let Some(name) = file.to_str() else { continue };
            // Skip a missing file: the scene's loader reports it if the scene needs it.
            let Ok(bytes) = load_context.read_asset_bytes(&resolve(&path, name)?).await else { continue };
            let copy = folder.path().join(&file);
            if let Some(parent) = copy.parent() {
                fs::create_dir_all(parent)?;
            }
            fs::write(copy, bytes)?;
        }
        fs::write(&scene, bytes)?;
        Ok(Self { scene, _folder: folder })
    }
}

fn bake_copy(copy: &Copy, settings: &AssetBake, sun: Sun) -> Result<ShadowFile, AssetBakeError> {
    let scene = adumbra_scene::load(&copy.scene, &LoadOptions::default())?;
    let options = BakeOptions::new(sun, Size::Resolution(settings.resolution))
        .with(|o| o.thickness_world = settings.thickness_world);
    Ok(Bake::with_options(&scene, &options).in_memory()?)
}

/// Saves a file as `.adumbra` bytes.
#[derive(TypePath, Clone, Copy, Debug, Default)]
pub struct ShadowFileSaver;

impl AssetSaver for ShadowFileSaver {
    type Asset = BakedShadowFile;
    type Settings = ();
    type OutputLoader = ShadowFileLoader;
    type Error = io::Error;

    async fn save(
        &self,
        writer: &mut Writer,
        asset: SavedAsset<'_, '_, BakedShadowFile>,
        _settings: &(),
        _asset_path: AssetPath<'_>,
    ) -> Result<ShadowFileSettings, io::Error> {
        let bytes = asset.file().to_bytes(Encoding::default()).map_err(io::Error::other)?;
        writer.write_all(&bytes).await?;
        Ok(ShadowFileSettings::default())
    }
}
