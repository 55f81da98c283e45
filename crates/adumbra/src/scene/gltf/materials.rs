//! Materials and the textures that they need.
//!
//! The base colour comes from metallic-roughness, or from KHR_materials_pbrSpecularGlossiness where a material has
//! that; both carry alpha in their fourth channel.

use std::path::Path;

use ::gltf::json::Root;
use ::gltf::json::material::{AlphaMode as JsonAlpha, Material as Json};
use ::gltf::json::texture::{Info, MagFilter, WrappingMode};
use ::gltf::json::validation::Checked;
use hashbrown::HashMap;

use super::container::{Buffers, read_uri};
use super::nodes::casts;
use crate::error::{Error, Result};
use crate::scene::{AlphaMode, LoadNotes, LoadOptions, Material, Texture, Wrap};

/// Which texture coordinates a material's texture takes, and the KHR_texture_transform to apply.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coordinates {
    /// The set: TEXCOORD_n.
    pub(super) set: u32,
    /// `uv' = m[..2] · uv + m[2]`, one row a component.
    rows: [[f32; 3]; 2],
}

impl Coordinates {
    /// The transformed coordinates; 0 where they are not finite.
    pub(super) fn apply(&self, uv: [f32; 2]) -> [f32; 2] {
        self.rows.map(|row| {
            let value = row[0] * uv[0] + row[1] * uv[1] + row[2];
            if value.is_finite() { value } else { 0.0 }
        })
    }
}

/// All materials of the file, and a default one at the end.
#[derive(Debug, Default)]
pub(super) struct Materials {
    /// One for each material of the file, then the default.
    pub(super) list: Vec<Material>,
    /// Where a material samples its texture.
    pub(super) coordinates: Vec<Option<Coordinates>>,
    /// What the materials name.
    pub(super) textures: Vec<Texture>,
}

/// The material's name, or `material 7`; `default` for a primitive without one.
pub(super) fn name(root: &Root, index: usize) -> String {
    match root.materials.get(index) {
        Some(m) => m.name.clone().unwrap_or_else(|| format!("material {index}")),
        None => "default".to_owned(),
    }
}

/// The JSON of KHR_materials_pbrSpecularGlossiness that matters here.
#[derive(Default, serde::Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct SpecularGlossiness {
    diffuse_factor: Option<[f32; 4]>,
    diffuse_texture: Option<Info>,
}

/// Loads the materials, and the textures of those that `used` marks.
///
/// # Errors
/// [`Error::Texture`] where a texture that decides opacity cannot be read; one that only colours becomes a warning.
pub(super) fn load(
    path: &Path,
    root: &Root,
    buffers: &Buffers<'_>,
    options: &LoadOptions,
    used: &[bool],
    notes: &mut LoadNotes,
) -> Result<Materials> {
    let mut out = Materials::default();
    let mut images =
        Images { path, root, buffers, alpha_only: !options.color_textures, done: HashMap::new() };
    for (index, json) in root.materials.iter().enumerate() {
        let name = name(root, index);
        let (base_color, info) = base_color(json);
        let mut material = describe(json, &name, base_color, options);
        let mut coordinates = None;
        let cuts = material.alpha != AlphaMode::Opaque;
        if let Some(info) = info
            && used.get(index) == Some(&true)
            && (cuts || options.color_textures)
        {
            match images.load(info.index.value(), &mut out.textures) {
                Ok(texture) => material.texture = texture,
                Err((texture, what)) if cuts => {
                    return Err(Error::Texture { path: path.to_owned(), material: name, texture, what });
                }
                Err((texture, what)) => {
                    notes
                        .warnings
                        .push(format!("material {name:?} loses its colour texture {texture}: {what}"));
                }
            }
            coordinates = material.texture.map(|_| placing(&info));
        }
        out.list.push(material);
        out.coordinates.push(coordinates);
    }
    out.list.push(Material::opaque(&self::name(root, usize::MAX), [1.0; 4]));
    out.coordinates.push(None);
    Ok(out)
}

/// Base colour factor and texture.
fn base_color(json: &Json) -> ([f32; 4], Option<Info>) {
    let glossy = json.extensions.as_ref().and_then(|e| e.others.get("KHR_materials_pbrSpecularGlossiness"));
    // Through text, for the JSON types of extras are only read from text.
    if let Some(glossy) = glossy.and_then(|v| serde_json::from_str::<SpecularGlossiness>(&v.to_string()).ok())
    {
        return (glossy.diffuse_factor.unwrap_or([1.0; 4]), glossy.diffuse_texture);
    }
    let pbr = &json.pbr_metallic_roughness;
    (pbr.base_color_factor.0, pbr.base_color_texture.clone())
}

fn describe(json: &Json, name: &str, base_color: [f32; 4], options: &LoadOptions) -> Material {
    let mode = match json.alpha_mode {
        Checked::Valid(mode) => mode,
        Checked::Invalid => JsonAlpha::Opaque,
    };
    let transmission = json.extensions.as_ref().and_then(|e| e.transmission.as_ref());
    Material {
        name: name.to_owned(),
        base_color,
        texture: None,
        alpha: match mode {
            JsonAlpha::Mask if !options.ignore_alpha => {
                AlphaMode::Mask { cutoff: json.alpha_cutoff.map_or(0.5, |c| c.0) }
            }
            JsonAlpha::Blend if !options.ignore_alpha => AlphaMode::Mask { cutoff: 0.5 },
            _ => AlphaMode::Opaque,
        },
        blended: mode == JsonAlpha::Blend,
        transmissive: transmission.is_some_and(|t| t.transmission_factor.0 > 0.0),
        casts: casts(&json.extras),
    }
}

/// KHR_texture_transform: scale, then turn counter-clockwise as seen with v down (as the Khronos sample viewer and
/// three.js do), then offset.
fn placing(info: &Info) -> Coordinates {
    let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref());
    let Some(transform) = transform else {
        return Coordinates { set: info.tex_coord, rows: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] };
    };
    let (sin, cos) = (libm::sinf(transform.rotation.0), libm::cosf(transform.rotation.0));
    let ([sx, sy], [tx, ty]) = (transform.scale.0, transform.offset.0);
    Coordinates {
        set: transform.tex_coord.unwrap_or(info.tex_coord),
        rows: [[cos * sx, sin * sy, tx], [-sin * sx, cos * sy, ty]],
    }
}

/// What went wrong with a texture: which it is, and a clause.
type Trouble = (String, String);

/// An image as one sampler reads it: image, wrap, nearest.
type Sampled = (usize, [Wrap; 2], bool);

/// Loads each image once a sampler.
struct Images<'a> {
    path: &'a Path,
    root: &'a Root,
    buffers: &'a Buffers<'a>,
    alpha_only: bool,
    done: HashMap<Sampled, Result<Option<u32>, Trouble>>,
}

impl Images<'_> {
    /// The texture's index in `textures`; `None` where only alpha is wanted and it is full everywhere.
    fn load(&mut self, index: usize, textures: &mut Vec<Texture>) -> Result<Option<u32>, Trouble> {
        let json = self.root.textures.get(index);
        let json = json.ok_or_else(|| (index.to_string(), "it does not exist".to_owned()))?;
        let webp = json.extensions.as_ref().and_then(|e| e.others.get("EXT_texture_webp"));
        let webp = webp.and_then(|e| e.get("source")).and_then(serde_json::Value::as_u64);
        let image = webp.and_then(|i| usize::try_from(i).ok()).unwrap_or(json.source.value());
        let sampler = json.sampler.and_then(|s| self.root.samplers.get(s.value()));
        let wrap = sampler.map_or([Wrap::Repeat; 2], |s| [wrap(&s.wrap_s), wrap(&s.wrap_t)]);
        let nearest = sampler.is_some_and(|s| s.mag_filter == Some(Checked::Valid(MagFilter::Nearest)));
        let key = (image, wrap, nearest);
        if let Some(done) = self.done.get(&key) {
            return done.clone();
        }
        let result = self.decode(image).map(|mut texture| {
            if self.alpha_only && texture.is_fully_opaque() {
                return None;
            }
            (texture.wrap, texture.nearest) = (wrap, nearest);
            textures.push(texture);
            Some(textures.len() as u32 - 1)
        });
        self.done.insert(key, result.clone());
        result
    }

    fn decode(&self, index: usize) -> Result<Texture, Trouble> {
        let Some(json) = self.root.images.get(index) else {
            return Err(("of no image".to_owned(), "it names no image in a known format".to_owned()));
        };
        let uri = json.uri.as_deref();
        let file = uri.filter(|u| !u.starts_with("data:"));
        let label = file.map(str::to_owned).or_else(|| json.name.clone());
        let label = label.unwrap_or_else(|| format!("image {index}"));
        let trouble = |what: String| (label.clone(), what);
        let read;
        let bytes = match (uri, json.buffer_view) {
            (Some(uri), _) => {
                read = read_uri(self.path, uri).map_err(|e| trouble(e.to_string()))?;
                &read[..]
            }
            (None, Some(view)) => {
                self.buffers.view(self.root, view.value()).map_err(|e| trouble(e.to_string()))?.0
            }
            (None, None) => return Err(trouble("it has no data".to_owned())),
        };
        let ending = file.and_then(|f| f.rsplit_once('.')).map_or("", |(_, ending)| ending);
        Texture::decode(label.clone(), bytes, ending, self.alpha_only).map_err(trouble)
    }
}

fn wrap(mode: &Checked<WrappingMode>) -> Wrap {
    match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
        _ => Wrap::Repeat,
    }
}
