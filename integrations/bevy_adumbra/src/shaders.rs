//! The WGSL modules of look-ups, and the places in Bevy's own shaders that call them.
//!
//! Every material that calls `apply_pbr_lighting` asks `bevy_pbr::shadows` for the shadow of a directional
//! light. So one function there, and one line of the volumetric fog, serve all of them. [`PATCHES`] lists the
//! changes by the text that they replace. Each text must occur exactly once; otherwise Bevy's shader is left
//! as it is.

use std::collections::BTreeSet;

use adumbra_shaders::{Source, assemble, source};

use crate::error::BakedShadowError;

/// A way of looking up a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Way {
    /// With a filter.
    Filtered,
    /// With penumbrae.
    Soft,
    /// By a march through two keys of a sun that moves.
    March,
}

impl Way {
    pub(crate) const ALL: [Self; 3] = [Self::Filtered, Self::Soft, Self::March];

    /// Returns its number in the directory.
    pub(crate) fn code(self) -> u32 {
        self as u32
    }

    /// Returns the last part of its module's name.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Filtered => "filtered",
            Self::Soft => "soft",
            Self::March => "march",
        }
    }

    /// Returns its module, `adumbra::NAME`.
    pub(crate) fn module(self) -> String {
        let mut texts = [&[source::SURFACE], source::LOOK_UP].concat();
        // The texels come from `adumbra::words`.
        texts.extend([source::DEPTHS_BLEND, source::LOOK_UP_TEXTURE, source::LOOK_UP_PARAMETERS]);
        let of_plugin = |name, text| Source { name, text };
        texts.push(of_plugin("bevy_adumbra/selected_file.wgsl", include_str!("wgsl/selected_file.wgsl")));
        let levels = of_plugin("bevy_adumbra/levels.wgsl", include_str!("wgsl/levels.wgsl"));
        texts.extend(match self {
            Self::Filtered => {
                vec![levels, of_plugin("bevy_adumbra/taps.wgsl", include_str!("wgsl/taps.wgsl"))]
            }
            Self::Soft => {
                let penumbrae = of_plugin("bevy_adumbra/penumbrae.wgsl", include_str!("wgsl/penumbrae.wgsl"));
                vec![source::DISC, source::DEPTHS_SOFT, levels, penumbrae]
            }
            Self::March => {
                let march = of_plugin("bevy_adumbra/march.wgsl", include_str!("wgsl/march.wgsl"));
                vec![source::DEPTHS_MARCH, march]
            }
        });
        format!("#define_import_path adumbra::{}\n#import adumbra::words\n{}", self.name(), assemble(&texts))
    }
}

/// The module `adumbra::words`.
pub(crate) const WORDS: &str = include_str!("wgsl/words.wgsl");

/// Returns the module `adumbra::look_up`, which looks up files in any of these ways. Fewer ways compile
/// faster.
pub(crate) fn look_up_module(ways: &BTreeSet<Way>) -> String {
    let mut text = "#define_import_path adumbra::look_up\n#import adumbra::words\n".to_owned();
    for way in ways {
        text += &format!("#import adumbra::{}\n", way.name());
    }
    let functions = [
        ("texels_inside_file", "texels_inside", "p_world: vec3<f32>, towards_sun: vec3<f32>", "i32", "-1"),
        (
            "visibility_from_file",
            "visibility",
            "p_world: vec3<f32>, normal: vec3<f32>, towards_sun: vec3<f32>, pixel: vec2<f32>",
            "f32",
            "1.0",
        ),
    ];
    for (name, of_way, parameters, result, otherwise) in functions {
        let names: Vec<_> = parameters.split(", ").filter_map(|p| p.split(':').next()).collect();
        text += &format!("fn {name}(kind: u32, {parameters}) -> {result} {{\n");
        for way in ways {
            let call = format!("{}::{of_way}({})", way.name(), names.join(", "));
            text += &format!("    if (kind == {}u) {{\n        return {call};\n    }}\n", way.code());
        }
        text += &format!("    return {otherwise};\n}}\n");
    }
    text + include_str!("wgsl/look_up.wgsl")
}

/// A change of one of Bevy's shaders.
pub(crate) struct Patch {
    /// Path of the asset.
    pub(crate) asset: &'static str,
    /// Texts that must occur exactly once, each with its replacement.
    replacements: &'static [[&'static str; 2]],
    /// Text that is added at the end.
    end: &'static str,
}

/// Marks a text that is already patched.
const MARK: &str = "#import adumbra::";

/// The changes of Bevy 0.19's shaders.
pub(crate) const PATCHES: [Patch; 3] = [
    Patch {
        asset: "embedded://bevy_pbr/render/shadows.wgsl",
        replacements: &[
            ["fn fetch_directional_shadow(", "fn fetch_cascades("],
            ["const flip_z", "#import adumbra::look_up\nconst flip_z"],
        ],
        end: "
// The darker of the baked shadow and that of the cascades, which hold what moves.
fn fetch_directional_shadow(
    light_id: u32,
    frag_position: vec4<f32>,
    surface_normal: vec3<f32>,
    view_z: f32,
    frag_coord_xy: vec2<f32>,
) -> f32 {
    let towards_light = view_bindings::lights.directional_lights[light_id].direction_to_light;
    let baked = look_up::sun_visibility(towards_light, frag_position.xyz, surface_normal, frag_coord_xy);
    if (baked == 0.0) {
        return 0.0;
    }
    return min(baked, fetch_cascades(light_id, frag_position, surface_normal, view_z, frag_coord_xy));
}
",
    },
    Patch {
        asset: "embedded://bevy_pbr/volumetric_fog/volumetric_fog.wgsl",
        replacements: &[
            [
                "            if (local_light_attenuation != 0.0) {
                let light_attenuation",
                "            local_light_attenuation =
                look_up::fog_visibility(local_light_attenuation, light_local.w != 0.0, L, P_world);
            if (local_light_attenuation != 0.0) {
                let light_attenuation",
            ],
            [
                "#import bevy_pbr::lighting::getDistanceAttenuation;",
                "#import bevy_pbr::lighting::getDistanceAttenuation;\n#import adumbra::look_up",
            ],
        ],
        end: "",
    },
    // The texture holds the picture with the words below it. Without a picture, it holds the words alone.
    Patch {
        asset: "embedded://bevy_pbr/transmission/transmission.wgsl",
        replacements: &[
            [
                "    var background_color = textureSampleLevel(
        view_bindings::view_transmission_texture,
        view_bindings::view_transmission_sampler,
        offset_position,
        0.0
    );",
                "    var background_color = words::transmitted(offset_position);",
            ],
            [
                "        var sample = textureSampleLevel(
            view_bindings::view_transmission_texture,
            view_bindings::view_transmission_sampler,
            modified_offset_position,
            0.0
        );",
                "        var sample = words::transmitted(modified_offset_position);",
            ],
            [
                "vec2<f32>(textureDimensions(view_bindings::view_transmission_texture))",
                "words::picture_size()",
            ],
            ["#import bevy_render::maths::PI", "#import bevy_render::maths::PI\n#import adumbra::words"],
        ],
        end: "",
    },
];

impl Patch {
    /// Returns the patched text; `None` if it is patched already.
    ///
    /// # Errors
    /// Returns the first text that does not occur exactly once.
    pub(crate) fn apply(&self, text: &str) -> Result<Option<String>, BakedShadowError> {
        if text.contains(MARK) {
            return Ok(None);
        }
        let mut patched = text.to_owned();
        for &[before, after] in self.replacements {
            match patched.matches(before).count() {
                1 => patched = patched.replace(before, after),
                found => {
                    return Err(BakedShadowError::ShaderText { shader: self.asset, text: before, found });
                }
            }
        }
        Ok(Some(patched + self.end))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_patched_once_or_not_at_all() {
        let patch =
            Patch { asset: "", replacements: &[["one", "#import adumbra::look_up two"]], end: " end" };
        let patched = patch.apply("this one").unwrap().unwrap();
        assert_eq!(patched, "this #import adumbra::look_up two end");
        assert_eq!(patch.apply(&patched), Ok(None));
        let times = |found| Err(BakedShadowError::ShaderText { shader: "", text: "one", found });
        assert_eq!(patch.apply("one one"), times(2));
        assert_eq!(patch.apply("two"), times(0));
    }

    #[test]
    fn only_ways_in_use_are_imported() {
        let module = look_up_module(&BTreeSet::from([Way::Filtered]));
        assert!(module.contains("filtered::visibility(") && !module.contains("soft::"), "{module}");
    }
}
