//! Materials and the textures that they use.
//!
//! The base colour comes from KHR_materials_pbrSpecularGlossiness if the material has that extension,
//! otherwise from metallic-roughness. Both have alpha in the fourth channel.

use std::path::Path;

use ::gltf::json::Root;
use ::gltf::json::material::{AlphaMode as JsonAlpha, Material as Json};
use ::gltf::json::texture::Info;
use ::gltf::json::validation::Checked;
use serde_json::Value;

use crate::gltf::casting::Casting;
use crate::gltf::container::Buffers;
use crate::gltf::images::{Images, Problem};
use crate::gltf::numbers::make_whole;
use crate::sources::OUTSIDE;
use crate::{AlphaMode, Error, LoadNotes, LoadOptions, Material, Result, Texture};

/// The texture-coordinate set of a material's texture, and the KHR_texture_transform to apply to it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coordinates {
    /// The set: TEXCOORD_n.
    pub(super) set: u32,
    /// `uv' = m[..2] · uv + m[2]`, one row per component.
    rows: [[f32; 3]; 2],
}

impl Coordinates {
    /// Returns the transformed coordinates; a non-finite result becomes 0.
    pub(super) fn apply(&self, uv: [f32; 2]) -> [f32; 2] {
        self.rows.map(|row| {
            let value = row[0] * uv[0] + row[1] * uv[1] + row[2];
            if value.is_finite() { value } else { 0.0 }
        })
    }
}

/// All materials of the file, followed by a default one.
#[derive(Debug, Default)]
pub(super) struct Materials {
    /// The materials of the file in order, then the default.
    pub(super) list: Vec<Material>,
    /// The texture coordinates of each material, or `None` if it has no texture.
    pub(super) coordinates: Vec<Option<Coordinates>>,
    /// The textures that the materials reference.
    pub(super) textures: Vec<Texture>,
}

/// The material's name, or `material 7` if it is unnamed; `default` for a primitive without a material.
pub(super) fn name(root: &Root, index: usize) -> String {
    match root.materials.get(index) {
        Some(m) => m.name.clone().unwrap_or_else(|| format!("material {index}")),
        None => "default".to_owned(),
    }
}

/// The parts of KHR_materials_pbrSpecularGlossiness that are used.
#[derive(Default, serde::Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct SpecularGlossiness {
    diffuse_factor: Option<[f32; 4]>,
    diffuse_texture: Option<Info>,
}

/// Loads the materials, and the textures of those marked in `used`.
///
/// # Errors
/// Returns [`Error::Texture`] or [`Error::OutsideScene`] if a texture that affects opacity cannot be read;
/// for a colour-only texture this is a warning instead. Returns [`Error::SceneMemory`] if textures are too
/// large.
pub(super) fn load(
    root: &Root,
    buffers: &Buffers<'_>,
    options: &LoadOptions,
    used: &[bool],
    casting: &mut Casting,
    notes: &mut LoadNotes,
) -> Result<Materials> {
    let mut out = Materials::default();
    let mut images = Images::new(root, buffers, !options.color_textures);
    for (index, json) in root.materials.iter().enumerate() {
        let name = name(root, index);
        let (base_color, info) = base_color(json);
        let casts = casting.of(&json.extras, || format!("material {name:?}"));
        let mut material = Material { casts, ..describe(json, &name, base_color, options) };
        let mut coordinates = None;
        let cuts = material.alpha != AlphaMode::Opaque;
        if let Some(info) = info
            && used.get(index) == Some(&true)
            && (cuts || options.color_textures)
        {
            match images.load(info.index.value(), &mut out.textures)? {
                Ok(texture) => material.texture = texture,
                Err(problem) if cuts => return Err(problem.error(buffers.sources.scene, name)),
                Err(problem) => {
                    notes.outside_textures += u64::from(matches!(problem, Problem::Outside { .. }));
                    notes.warnings.push(problem.warning(&name));
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
    // Round trip through text, because the JSON types of extras can only be parsed from text.
    let read = |glossy: &Value| {
        let mut glossy = glossy.clone();
        make_whole(&mut glossy);
        serde_json::from_str::<SpecularGlossiness>(&glossy.to_string()).ok()
    };
    if let Some(glossy) = glossy.and_then(read) {
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
        transmissivity: transmission.map_or(0.0, |t| t.transmission_factor.0.clamp(0.0, 1.0)),
        casts: true,
    }
}

/// KHR_texture_transform: scale, then rotate counter-clockwise as seen with v down (as the Khronos sample
/// viewer and three.js do), then offset.
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
    /// The error if the texture affects opacity.
    fn error(self, path: &Path, material: String) -> Error {
        let path = path.to_owned();
        match self {
            Self::Unreadable { texture, what } => Error::Texture { path, material, texture, what },
            Self::Outside { place, named } => Error::OutsideScene { path, place, named },
        }
    }

    /// The warning if the texture is colour-only.
    fn warning(&self, material: &str) -> String {
        let (texture, what) = match self {
            Self::Unreadable { texture, what } => (texture, what.as_str()),
            Self::Outside { named, .. } => (named, OUTSIDE),
        };
        format!("material {material:?}: the colour texture {texture} is ignored: {what}")
    }
}
