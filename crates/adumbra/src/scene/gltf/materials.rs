//! Materials and the textures that they need.
//!
//! The base colour comes from metallic-roughness, or from KHR_materials_pbrSpecularGlossiness where a material has
//! that; both carry alpha in their fourth channel.

use std::path::Path;

use ::gltf::json::Root;
use ::gltf::json::material::{AlphaMode as JsonAlpha, Material as Json};
use ::gltf::json::texture::Info;
use ::gltf::json::validation::Checked;

use super::container::Buffers;
use super::images::{Images, Problem};
use super::nodes::casts;
use crate::error::{Error, Result};
use crate::scene::sources::OUTSIDE;
use crate::scene::{AlphaMode, LoadNotes, LoadOptions, Material, Texture};

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
/// [`Error::Texture`] or [`Error::OutsideScene`] where a texture that decides opacity cannot be read; one that only colours becomes a
/// warning. [`Error::SceneMemory`] where textures are too large.
pub(super) fn load(
    root: &Root,
    buffers: &Buffers<'_>,
    options: &LoadOptions,
    used: &[bool],
    notes: &mut LoadNotes,
) -> Result<Materials> {
    let mut out = Materials::default();
    let mut images = Images::new(root, buffers, !options.color_textures);
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
            match images.load(info.index.value(), &mut out.textures)? {
                Ok(texture) => material.texture = texture,
                Err(problem) if cuts => return Err(problem.error(buffers.sources.scene, name)),
                Err(problem) => notes.warnings.push(problem.warning(&name)),
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

impl Problem {
    /// The error where the texture decides opacity.
    fn error(self, path: &Path, material: String) -> Error {
        let path = path.to_owned();
        match self {
            Self::Unreadable { texture, what } => Error::Texture { path, material, texture, what },
            Self::Outside { place, named } => Error::OutsideScene { path, place, named },
        }
    }

    /// The warning where the texture only colours.
    fn warning(&self, material: &str) -> String {
        let (texture, what) = match self {
            Self::Unreadable { texture, what } => (texture, what.as_str()),
            Self::Outside { named, .. } => (named, OUTSIDE),
        };
        format!("material {material:?} loses its colour texture {texture}: {what}")
    }
}
