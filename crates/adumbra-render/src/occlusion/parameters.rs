//! What ambient occlusion can be told, as help shows it: written from the estimators' own lists and defaults; a test holds
//! it against what they ask for.

use adumbra_shaders::constants::{OCCLUSION_MAX_SIDE, OCCLUSION_MAX_TAPS};

use super::estimator::{Estimator, Parameter};
use super::settings::{DEFAULT_RADIUS_SHARE, OcclusionSettings};

/// Every name that ambient occlusion goes by, and what it is.
pub const OCCLUSIONS: [(&str, &str); 7] = [
    ("ssao", "points in a hemisphere that lie behind what is seen (Mittring 2007)"),
    ("hbao", "horizons along a few directions (Bavoil, Sainz, Dimitrov 2008)"),
    ("alchemy", "what rises over the tangent plane, by its distance (McGuire et al. 2011)"),
    ("issao", "the same with an attenuation and a denser middle (Qiu et al. 2014)"),
    ("gtao", "horizons of slices, their arcs integrated (Jimenez et al. 2016)"),
    ("truth", "rays on the CPU, rays=256 (a pixel, 1 to 65536), radius="),
    ("none", "open sky everywhere"),
];

/// Parameters of an estimator alone, one an entry: `key=default (range or words): what it is`. Empty for any other name.
pub fn occlusion_parameters(name: &str) -> Vec<String> {
    let estimator = Estimator::ALL.into_iter().find(|e| e.name() == name);
    let mut lines: Vec<String> =
        estimator.map_or(&[][..], Estimator::parameters).iter().map(described).collect();
    if estimator == Some(Estimator::Issao) {
        lines.push("preset=none, fig3, fig4 or fig5: the settings published with these figures".to_owned());
    }
    lines
}

fn described(p: &Parameter) -> String {
    let Parameter { name, what, default, range: [least, most], .. } = p;
    match p.words.get(*default as usize) {
        None => format!("{name}={default} ({least} to {most}): {what}"),
        Some(first) => {
            let others: Vec<&str> = p.words.iter().copied().filter(|w| w != first).collect();
            format!("{name}={first} or {}: {what}", others.join(", "))
        }
    }
}

/// Parameters that every estimator has, as [`occlusion_parameters`].
pub fn occlusion_options() -> Vec<String> {
    let s = OcclusionSettings::new(Estimator::Issao, 1.0);
    let OcclusionSettings { samples, cap_texels, filter_side, sigma_texels, sigma_depth, frames, .. } = s;
    let share = 100.0 * DEFAULT_RADIUS_SHARE;
    vec![
        format!("radius= (world units, {share} % of the scene's diagonal): nothing further than this occludes"),
        format!("samples={samples} (1 to {OCCLUSION_MAX_TAPS}): taps a pixel"),
        format!("cap={cap_texels} (1 to 4096 texels): a radius that covers more shrinks to this"),
        "levels=on or off: fewer taps where the radius covers few texels (issao)".to_owned(),
        "normals=gbuffer or depth: whose normals, the G-buffer's or made of depth".to_owned(),
        "filter=bilateral, square, gauss or none: two lines that see depth, the square, two lines that do not"
            .to_owned(),
        format!("side={filter_side} (1 to {OCCLUSION_MAX_SIDE}): neighbours on either side that it takes"),
        format!("blur={sigma_texels} (0.1 to 16): its standard deviation, texels"),
        format!("sharpness={sigma_depth} (0.0001 to 100): the same in depth, radii"),
        "depth=plane or plain: how far depth is off, from the surface drawn on or from the pixel's".to_owned(),
        "edges=off or on: leave pixels that need no filter".to_owned(),
        "half=off or on: at half of width and height".to_owned(),
        "reuse=off or on: with what is still valid of the frames before".to_owned(),
        format!("frames={frames} (1 to 64): how many of them count"),
    ]
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::technique::TechniqueSpec;

    fn settings(text: &str) -> Result<OcclusionSettings, String> {
        let spec: TechniqueSpec = text.parse().unwrap();
        OcclusionSettings::from_spec(&spec, 1.0).map_err(|e| e.to_string())
    }

    /// Key and the rest of `key=rest: what it is`.
    fn split(line: &str) -> (&str, &str) {
        let (told, _) = line.split_once(": ").unwrap();
        told.split_once('=').unwrap()
    }

    #[test]
    fn help_names_every_occlusion() {
        let named: Vec<&str> = OCCLUSIONS.iter().map(|(name, _)| *name).collect();
        let estimators = Estimator::ALL.map(Estimator::name);
        assert_eq!(named, [&estimators[..], &["truth", "none"]].concat());
    }

    #[test]
    fn help_names_the_parameters_that_estimators_ask_for() {
        for estimator in Estimator::ALL {
            let lines = [occlusion_options(), occlusion_parameters(estimator.name())].concat();
            let named: BTreeSet<&str> = lines.iter().map(|l| split(l).0).collect();
            let error = settings(&format!("{estimator}:zzz=1")).unwrap_err();
            let (_, asked) = error.split_once("it has: ").unwrap();
            assert_eq!(named, asked.split(", ").collect(), "{estimator}");
        }
        assert!(occlusion_parameters("truth").is_empty());
    }

    #[test]
    fn help_gives_defaults_and_ranges_that_hold() {
        for estimator in Estimator::ALL {
            let plain = settings(estimator.name()).unwrap();
            for line in [occlusion_options(), occlusion_parameters(estimator.name())].concat() {
                let (key, rest) = split(&line);
                if key == "radius" {
                    continue;
                }
                if let Some((default, range)) = rest.split_once(" (") {
                    // A number, and the least and the most that it may be.
                    let range = range.split_once(')').unwrap().0.trim_end_matches(" texels");
                    let (least, most) = range.split_once(" to ").unwrap();
                    assert_eq!(settings(&format!("{estimator}:{key}={default}")), Ok(plain), "{line}");
                    for (value, beyond) in [(least, -1.0), (most, 1.0)] {
                        assert!(settings(&format!("{estimator}:{key}={value}")).is_ok(), "{line}");
                        let beyond = value.parse::<f64>().unwrap() + beyond;
                        assert!(settings(&format!("{estimator}:{key}={beyond}")).is_err(), "{line}");
                    }
                } else {
                    let words: Vec<&str> = rest.split(", ").flat_map(|w| w.split(" or ")).collect();
                    assert!(words.len() > 1, "{line}");
                    assert_eq!(settings(&format!("{estimator}:{key}={}", words[0])), Ok(plain), "{line}");
                    for word in words {
                        assert!(settings(&format!("{estimator}:{key}={word}")).is_ok(), "{line}");
                    }
                    let error = settings(&format!("{estimator}:{key}=zzz")).unwrap_err();
                    assert!(error.contains(": give "), "{error}");
                }
            }
        }
    }
}
