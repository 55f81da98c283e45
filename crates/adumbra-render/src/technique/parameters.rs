//! What techniques can be told, as help shows it; a test holds it against what they ask for.

/// Of every shadow map.
const MAP: &str = "size=2048 (256 to 16384), depth=32 or 16 (bits), bias=, slope=, normal= (texels, 0 to 16), static=redrawn or cached";
/// Of hybrid maps.
const HYBRID: &str = "START-TARGET or sizes=4096-1024 (START 256 to 8192, TARGET its half, quarter or eighth), test=plane or paper, \
    tolerance=0.5 (of test=plane, texels, 0 to 64), depth=32 or 16 (bits), layout=compact or paper, \
    build=blocks or sweep, filter=5, 1, 3 or 7, bias=, slope=, normal= (finest texels, 0 to 16), static=redrawn or cached";
/// Of cascades.
const CASCADES: &str = "cascades=4 (1 to 8), split=practical, uniform or log, lambda=0.5 (0 to 1), far=METRES, blend=0.1 (0 to 0.5)";
/// Of filters over comparisons.
const COMPARISONS: &str = "2, 3, 7 or poisson, radius=2 (of poisson, texels)";
/// Of variance.
const MOMENTS: &str =
    "blur=3 (texels, odd, 1 to 31), bleed= (share of the tail cut off, 0 to 0.9), deviation= (least, texels)";
const EXPONENTS: &str = "positive=40, negative=5 (1 to 42)";
const BLUR: &str = "base=pcf/filter=2 (a technique, / for :), samples=16 (8 to 64), sigma=PIXELS, passes=2 or 1, weights=table or shader, pairs=off or on, \
    half=off or on";
const VOXEL_BIAS: &str = "bias=, slope=, normal= (texels, 0 to 16; the file's)";

/// The parameters of a technique, the default first; empty where it has none, or there is no such technique.
pub fn parameters(name: &str) -> String {
    let parts: Vec<String> = match name {
        "sm" => vec![MAP.to_owned()],
        "pcf" => vec![format!("filter=5, {COMPARISONS}"), MAP.to_owned()],
        "pcss" => {
            vec!["angle=0.53 (degrees, 0.01 to 20), radius=32 (texels at most)".to_owned(), MAP.to_owned()]
        }
        "vsm" | "msm" => vec![MOMENTS.to_owned(), MAP.to_owned()],
        "evsm" => vec![EXPONENTS.to_owned(), MOMENTS.to_owned(), MAP.to_owned()],
        "csm" => vec![CASCADES.to_owned(), format!("filter=5, 1, {COMPARISONS}"), MAP.to_owned()],
        "csm-vsm" => vec![CASCADES.to_owned(), MOMENTS.to_owned(), MAP.to_owned()],
        "csm-evsm" => vec![CASCADES.to_owned(), EXPONENTS.to_owned(), MOMENTS.to_owned(), MAP.to_owned()],
        "hrsm" => vec![HYBRID.to_owned()],
        "blur" => vec![BLUR.to_owned()],
        "blur-dilate" => vec!["radius=2 (of the dilation, 1 to 16 pixels)".to_owned(), BLUR.to_owned()],
        "blur-bilateral" => {
            vec!["tolerance=1.5 (pixels off the surface's plane)".to_owned(), BLUR.to_owned()]
        }
        "voxel" => vec![
            "filter=9, 1, 3, 5 or 17".to_owned(),
            "soft with angle=0.53 (degrees, 0.01 to 20), radius=32 (texels at most, 1 to 64)".to_owned(),
            VOXEL_BIAS.to_owned(),
        ],
        "voxel+csm" => vec!["filter=9, 1, 3, 5 or 17, csm=PARAMETERS (of csm, / for :)".to_owned()],
        "voxel-cubes" => vec![cubes(), VOXEL_BIAS.to_owned()],
        "voxel-texture" => vec![cubes(), "read=texels or buffer".to_owned(), VOXEL_BIAS.to_owned()],
        _ => Vec::new(),
    };
    parts.join("; ")
}

fn cubes() -> String {
    "filter=3, 1 or 5, weights=mean or poisson, taps=front or all".to_owned()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::hybrid::HybridSettings;
    use crate::maps::MapSettings;
    use crate::screen_blur::BlurSettings;
    use crate::technique::{TECHNIQUES, TechniqueSpec};

    /// The keys that a technique asks for, from what it says of one that it does not know.
    fn asked(name: &str) -> BTreeSet<String> {
        let spec: TechniqueSpec = format!("{name}:zzz=1").parse().unwrap();
        let error = match name {
            "hrsm" => HybridSettings::from_spec(&spec).unwrap_err(),
            _ if name.starts_with("blur") => BlurSettings::read(&spec).unwrap_err(),
            _ => MapSettings::from_spec(&spec).unwrap_err(),
        };
        let text = error.to_string();
        let (_, keys) = text.split_once("it has: ").unwrap_or_else(|| panic!("{text}"));
        keys.split(", ").map(str::to_owned).collect()
    }

    #[test]
    fn help_names_the_parameters_that_techniques_ask_for() {
        for (name, _) in
            TECHNIQUES.iter().filter(|(n, _)| !n.starts_with("voxel") && !matches!(*n, "none" | "truth"))
        {
            let help = parameters(name);
            let mut named: BTreeSet<String> = help
                .split([' ', ';', ','])
                .filter_map(|word| word.split_once('=').map(|(key, _)| key.to_owned()))
                .filter(|key| !key.contains('/'))
                .collect();
            if !help.contains("radius=") || matches!(*name, "pcf" | "csm") {
                // Asked for by poisson alone.
                named.remove("radius");
            }
            assert_eq!(named, asked(name), "{name}: {help}");
        }
    }
}
