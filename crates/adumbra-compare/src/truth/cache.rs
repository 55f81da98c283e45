//! Cache of ray-traced truth on disk, keyed by everything that the truth depends on.
//!
//! An entry is a file named after its key. It holds `"adumbraT"`, the version, the key, the payload's length,
//! its BLAKE3 hash, and the payload. An entry that is truncated, changed, or of another version or key counts
//! as absent. Failure to write an entry is not an error. The modification time of an entry is the time of its
//! last use.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use adumbra_files::replace_file;
use adumbra_scene::{AlphaMode, Camera, Pixels, Projection, Scene, Texture};

use super::{SunShape, Surfaces, TruthTracer};

/// File extension of entries.
const ENDING: &str = "truth";
const MAGIC: &[u8; 8] = b"adumbraT";
/// Version of entries. Increase it whenever a change of the rays or of the format changes what an entry
/// holds.
const VERSION: u32 = 2;
const HEADER_BYTES: usize = 8 + 4 + 32 + 8 + 32;
/// Bytes per pixel of [`Surfaces`]: view depth, position, lift and normal.
const SURFACE_BYTES: usize = 8 + 24 + 8 + 12;

/// A hash of what an entry depends on.
#[derive(Clone, Debug)]
pub struct Key(blake3::Hasher);

/// Returns the scene's part of a key: everything that rays see of the scene, independent of its source file.
/// Colours and names are not included.
///
/// Cost: hashing the meshes and the alpha of masked textures.
pub fn scene_key(scene: &Scene, ignore_alpha: bool) -> Key {
    let mut key = Key::new().with(&[u8::from(ignore_alpha)]);
    for mesh in &scene.meshes {
        key = key.with_all(mesh.positions.iter().flatten().map(|c| c.to_bits()));
        key = key.with_all(mesh.triangles.iter().flatten().copied());
        key = key.with_all(mesh.triangle_materials.iter().copied());
        let uvs = if ignore_alpha { &[][..] } else { &mesh.uvs };
        key = key.with_all(uvs.iter().flatten().map(|c| c.to_bits()));
        if !ignore_alpha && !mesh.colors.is_empty() {
            key = key.with(&mesh.colors.iter().map(|c| c[3]).collect::<Vec<_>>());
        }
    }
    for instance in &scene.instances {
        key = key.with(&instance.mesh.to_le_bytes()).with(&[u8::from(instance.casts)]);
        key = key.with_numbers(instance.world_from_mesh.as_flattened());
    }
    for material in &scene.materials {
        key = key.with(&[u8::from(material.casts)]);
        if let (AlphaMode::Mask { cutoff }, false) = (material.alpha, ignore_alpha) {
            key = key.with_numbers(&[f64::from(cutoff), f64::from(material.base_color[3])]);
            if let Some(texture) = material.texture.and_then(|t| scene.textures.get(t as usize)) {
                key = key.with_alpha(texture);
            }
        }
    }
    key
}

impl Key {
    fn new() -> Self {
        Self(blake3::Hasher::new()).with(&VERSION.to_le_bytes())
    }

    /// Appends a part, preceded by its length, so that different sequences of parts do not have the same
    /// bytes.
    #[must_use]
    fn with(mut self, part: &[u8]) -> Self {
        self.0.update(&(part.len() as u64).to_le_bytes());
        self.0.update(part);
        self
    }

    fn with_all(self, numbers: impl Iterator<Item = u32>) -> Self {
        let bytes: Vec<u8> = numbers.flat_map(u32::to_le_bytes).collect();
        self.with(&bytes)
    }

    fn with_alpha(self, texture: &Texture) -> Self {
        let shape = format!("{} {} {:?} {}", texture.width, texture.height, texture.wrap, texture.nearest);
        let alpha: Vec<u8> = match &texture.pixels {
            Pixels::Alpha(bytes) => bytes.clone(),
            Pixels::Rgba(bytes) => bytes.as_chunks::<4>().0.iter().map(|p| p[3]).collect(),
        };
        self.with(shape.as_bytes()).with(&alpha)
    }

    fn with_numbers(self, numbers: &[f64]) -> Self {
        let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_bits().to_le_bytes()).collect();
        self.with(&bytes)
    }

    fn with_camera(self, camera: &Camera) -> Self {
        let (kind, extent) = match camera.projection {
            Projection::Perspective { fov_degrees } => (0.0, fov_degrees),
            Projection::Orthographic { height_world } => (1.0, height_world),
        };
        let size = [f64::from(camera.width), f64::from(camera.height)];
        self.with_numbers(&[camera.eye.as_slice(), &camera.target, &[kind, extent], &size].concat())
    }

    fn with_sun(self, towards: [f64; 3], shape: SunShape) -> Self {
        let shape = match shape {
            SunShape::Hard => [0.0, 1.0],
            SunShape::Disc { sun_degrees, samples } => [sun_degrees, f64::from(samples)],
        };
        self.with_numbers(&[towards.as_slice(), &shape].concat())
    }

    fn finish(&self) -> [u8; 32] {
        *self.0.finalize().as_bytes()
    }
}

/// A cache in a folder, or a disabled one.
#[derive(Clone, Debug)]
pub struct Cache {
    folder: Option<PathBuf>,
    limit_bytes: u64,
}

impl Cache {
    /// Default size limit in bytes: enough for about 20 cameras of 1280 × 720 pixels.
    pub const DEFAULT_LIMIT_BYTES: u64 = 1 << 30;

    /// Creates a cache in `folder`, which is created with the first entry. The entries take at most
    /// `limit_bytes`: the least recently used ones are removed first.
    pub fn in_folder(folder: PathBuf, limit_bytes: u64) -> Self {
        Self { folder: Some(folder), limit_bytes }
    }

    /// Creates a cache that stores nothing.
    pub fn none() -> Self {
        Self { folder: None, limit_bytes: 0 }
    }

    /// Returns [`TruthTracer::surfaces`], cached by `scene` (see [`scene_key`]) and camera.
    pub fn surfaces(&self, truth: &TruthTracer<'_>, scene: &Key, camera: &Camera) -> Surfaces {
        let key = scene.clone().with(b"surfaces").with_camera(camera).finish();
        let pixels = camera.width as usize * camera.height as usize;
        if let Some(bytes) = self.read(&key, pixels * SURFACE_BYTES) {
            return decode_surfaces(camera, &bytes);
        }
        let surfaces = truth.surfaces(camera);
        self.keep(&key, &encode_surfaces(&surfaces));
        surfaces
    }

    /// Returns [`TruthTracer::factors`] of the `surfaces` of the same camera, cached by `scene`, camera, sun
    /// and shape.
    pub fn factors(
        &self,
        truth: &TruthTracer<'_>,
        scene: &Key,
        camera: &Camera,
        surfaces: &Surfaces,
        towards_sun: [f64; 3],
        shape: SunShape,
    ) -> Vec<f32> {
        let key = scene.clone().with(b"factors").with_camera(camera).with_sun(towards_sun, shape);
        self.singles(&key, surfaces.pixels(), || truth.factors(surfaces, towards_sun, shape))
    }

    /// Returns [`TruthTracer::ambient`] of the `surfaces` of the same camera, cached by `scene`, camera,
    /// radius and rays.
    pub fn ambient(
        &self,
        truth: &TruthTracer<'_>,
        scene: &Key,
        camera: &Camera,
        surfaces: &Surfaces,
        radius_world: f64,
        rays: u32,
    ) -> Vec<f32> {
        let asked = [radius_world, f64::from(rays)];
        let key = scene.clone().with(b"ambient").with_camera(camera).with_numbers(&asked);
        self.singles(&key, surfaces.pixels(), || truth.ambient(surfaces, radius_world, rays))
    }

    /// Returns the entry of `count` numbers. Without a valid entry, stores and returns the result of `trace`.
    fn singles(&self, key: &Key, count: usize, trace: impl FnOnce() -> Vec<f32>) -> Vec<f32> {
        let key = key.finish();
        if let Some(bytes) = self.read(&key, count * 4) {
            return decode_singles(&bytes);
        }
        let traced = trace();
        self.keep(&key, &encode_singles(&traced));
        traced
    }

    fn path(&self, key: &[u8; 32]) -> Option<PathBuf> {
        let name: String = key.iter().take(16).map(|b| format!("{b:02x}")).collect();
        self.folder.as_ref().map(|folder| folder.join(format!("{name}.{ENDING}")))
    }

    /// Returns the payload if the entry exists, is valid, and its payload has `length` bytes.
    fn read(&self, key: &[u8; 32], length: usize) -> Option<Vec<u8>> {
        let path = self.path(key)?;
        let mut bytes = std::fs::read(&path).ok()?;
        if bytes.len() != HEADER_BYTES + length {
            return None;
        }
        let payload = bytes.split_off(HEADER_BYTES);
        if bytes != header(key, &payload) {
            return None;
        }
        // Records the last use. If that fails, the entry is only removed sooner.
        let _ = File::options().write(true).open(&path).and_then(|f| f.set_modified(SystemTime::now()));
        Some(payload)
    }

    fn keep(&self, key: &[u8; 32], payload: &[u8]) {
        let Some(path) = self.path(key) else { return };
        let bytes = (HEADER_BYTES + payload.len()) as u64;
        if bytes > self.limit_bytes {
            return;
        }
        self.make_room(bytes);
        let write = |file: &mut File| {
            file.write_all(&header(key, payload))?;
            file.write_all(payload)?;
            Ok(payload.len() as u64)
        };
        // If the cache cannot be written, later runs only take longer.
        let made = path.parent().is_none_or(|folder| std::fs::create_dir_all(folder).is_ok());
        if made {
            let _ = replace_file(&path, write);
        }
    }

    /// Removes the least recently used entries until `bytes` more fit within the limit.
    fn make_room(&self, bytes: u64) {
        let Some(listed) = self.folder.as_ref().and_then(|folder| std::fs::read_dir(folder).ok()) else {
            return;
        };
        let mut entries: Vec<_> = listed
            .flatten()
            .filter(|entry| Path::new(&entry.file_name()).extension().is_some_and(|e| e == ENDING))
            .filter_map(|entry| {
                let about = entry.metadata().ok()?;
                Some((about.modified().ok()?, entry.path(), about.len()))
            })
            .collect();
        entries.sort();
        let mut taken: u64 = entries.iter().map(|entry| entry.2).sum();
        for (_, path, length) in entries {
            if taken.saturating_add(bytes) <= self.limit_bytes {
                return;
            }
            // Another process may have removed it already.
            let _ = std::fs::remove_file(path);
            taken -= length;
        }
    }
}

fn header(key: &[u8; 32], payload: &[u8]) -> Vec<u8> {
    let length = (payload.len() as u64).to_le_bytes();
    let hash = blake3::hash(payload);
    [MAGIC.as_slice(), &VERSION.to_le_bytes(), key, &length, hash.as_bytes()].concat()
}

fn encode_singles(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn decode_singles(bytes: &[u8]) -> Vec<f32> {
    bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect()
}

fn encode_surfaces(s: &Surfaces) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(s.pixels() * SURFACE_BYTES);
    for i in 0..s.pixels() {
        bytes.extend(s.view_depth[i].to_le_bytes());
        s.position[i].iter().for_each(|c| bytes.extend(c.to_le_bytes()));
        bytes.extend(s.lift_world[i].to_le_bytes());
        s.normal[i].iter().for_each(|c| bytes.extend(c.to_le_bytes()));
    }
    bytes
}

fn decode_surfaces(camera: &Camera, bytes: &[u8]) -> Surfaces {
    let entries = bytes.as_chunks::<SURFACE_BYTES>().0;
    let double =
        |e: &[u8; SURFACE_BYTES], k: usize| f64::from_le_bytes(std::array::from_fn(|b| e[8 * k + b]));
    let single =
        |e: &[u8; SURFACE_BYTES], k: usize| f32::from_le_bytes(std::array::from_fn(|b| e[40 + 4 * k + b]));
    Surfaces {
        width: camera.width,
        height: camera.height,
        position: entries.iter().map(|e| [1, 2, 3].map(|k| double(e, k))).collect(),
        normal: entries.iter().map(|e| [0, 1, 2].map(|k| single(e, k))).collect(),
        view_depth: entries.iter().map(|e| double(e, 0)).collect(),
        lift_world: entries.iter().map(|e| double(e, 4)).collect(),
    }
}
