//! Lists the parameters of a technique, without a device. They are recorded by the same code that reads the settings
//! for building, so the list is complete.

use super::baked::Baked;
use super::blur::read_blur;
use super::registry::{Kind, unknown};
use crate::error::Result;
use crate::hybrid::HybridSettings;
use crate::maps::MapSettings;
use crate::technique::{Parameter, SpecReader, TechniqueSpec, changed};
use crate::voxel::{CubesOptions, VoxelSettings};
use crate::voxel_csm::VoxelCsmSettings;

/// Returns the parameters that apply to a technique of [`super::TECHNIQUES`] with these values. If one of them has
/// another word as its value, other parameters may apply. Defaults that depend on a file, such as the bias, come from
/// `baked`; without a file they are those of a default bake. A nested technique, such as the `base` of `blur`, is
/// checked and counts as one parameter: [`Parameter::nested`].
///
/// # Errors
/// Returns [`crate::RenderError::Technique`] for a name, parameter or value that does not exist.
pub fn describe(spec: &TechniqueSpec, baked: Baked<'_>) -> Result<Vec<Parameter>> {
    let mut reader = spec.reader();
    read(&mut reader, baked)?;
    reader.finish()
}

/// Returns a technique with one parameter changed. Parameters that no longer apply or have their default value are
/// omitted: `voxel:soft:angle=2` with `shade=hard` becomes `voxel`.
///
/// # Errors
/// Returns the errors of [`describe`].
pub fn change(spec: &TechniqueSpec, baked: Baked<'_>, key: &str, value: &str) -> Result<TechniqueSpec> {
    changed(spec, key, value, |reader| read(reader, baked))
}

/// Reads the parameters, which validates them and records what they accept.
fn read(reader: &mut SpecReader<'_>, baked: Baked<'_>) -> Result<()> {
    let spec = reader.spec();
    match spec.entry().ok_or_else(|| unknown(spec))?.kind {
        Kind::NoShadows | Kind::Truth => {}
        Kind::Map(kind) => drop(MapSettings::from_reader(reader, kind)?),
        Kind::Hybrid => drop(HybridSettings::from_reader(reader)?),
        Kind::Blur(name) => {
            let (_, base) = read_blur(reader, name)?;
            describe(&base, baked)?;
        }
        Kind::Voxel => drop(VoxelSettings::from_reader(reader, baked.light)?),
        Kind::VoxelCsm => drop(VoxelCsmSettings::from_reader(reader)?),
        Kind::Cubes { from_texture } => drop(CubesOptions::from_reader(reader, baked.tree, from_texture)?),
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::technique::parameter::tests::holds;
    use crate::techniques::TECHNIQUES;

    fn keys(text: &str) -> Vec<&'static str> {
        let spec = text.parse().unwrap();
        describe(&spec, Baked::default()).unwrap().iter().map(|p| p.key).collect()
    }

    #[test]
    fn describe_gives_what_applies() {
        assert!(keys("none").is_empty() && keys("truth").is_empty());
        assert_eq!(keys("voxel"), ["shade", "filter", "bias", "slope", "normal"]);
        assert_eq!(keys("voxel:soft"), ["shade", "angle", "radius", "bias", "slope", "normal"]);
        assert_eq!(keys("voxel+csm"), ["filter", "csm"]);
        assert!(keys("csm:filter=poisson").contains(&"radius") && !keys("csm").contains(&"radius"));
        assert!(keys("hrsm").contains(&"tolerance") && !keys("hrsm:test=paper").contains(&"tolerance"));
        assert_eq!(keys("voxel-texture").len(), keys("voxel-cubes").len() + 1);
        assert!(keys("blur:base=csm/cascades=2").contains(&"base"));
    }

    #[test]
    fn describe_gives_values_beside_defaults() {
        let spec = "blur:samples=32".parse().unwrap();
        let found = describe(&spec, Baked::default()).unwrap();
        let said: Vec<_> = found.iter().filter(|p| !p.is_default()).map(|p| p.key).collect();
        assert_eq!(said, ["samples"]);
        let sigma = found.iter().find(|p| p.key == "sigma").unwrap();
        assert_eq!((sigma.value.as_str(), sigma.default.as_str()), ("8", "8"));
    }

    #[test]
    fn describe_refuses_what_cannot_be_built() {
        for text in [
            "unknown",
            "none:size=3",
            "blur:base=blur",
            "blur:base=truth",
            "blur:base=pcf/filter=4",
            "blur:pairs=on:passes=1",
            "voxel:angle=2",
            "voxel+csm:csm=static=cached",
            "voxel+csm:csm=cascades=9",
            "voxel-cubes:read=buffer",
            "voxel:filter=7",
        ] {
            assert!(describe(&text.parse().unwrap(), Baked::default()).is_err(), "{text}");
        }
    }

    #[test]
    fn every_default_and_end_of_a_range_is_taken_and_nothing_beyond() {
        let more = ["csm:filter=poisson", "pcf:filter=poisson", "hrsm:test=paper", "voxel:soft"];
        for name in TECHNIQUES.iter().map(|t| t.name).chain(more) {
            holds(&name.parse().unwrap(), |spec| describe(spec, Baked::default()));
        }
    }

    #[test]
    fn change_says_no_more_than_it_must() {
        for (text, key, value, expected) in [
            ("voxel", "shade", "soft", "voxel:soft"),
            ("voxel:soft:angle=2:bias=0.5", "shade", "hard", "voxel:bias=0.5"),
            ("csm:filter=poisson:radius=3", "filter", "3", "csm:filter=3"),
            ("csm:filter=3", "filter", "5", "csm"),
            ("csm:lambda=0.7", "lambda", "0.50", "csm"),
            ("csm", "far", "90", "csm:far=90"),
            ("hrsm:2048-512", "sizes", "4096-1024", "hrsm"),
            ("blur", "base", "csm/cascades=2", "blur:base=csm/cascades=2"),
            ("voxel+csm", "csm", "filter=3", "voxel+csm:csm=filter=3"),
        ] {
            let spec: TechniqueSpec = text.parse().unwrap();
            let changed = change(&spec, Baked::default(), key, value).unwrap();
            assert_eq!(changed.to_string(), expected);
            describe(&changed, Baked::default()).unwrap();
        }
        let csm: TechniqueSpec = "csm".parse().unwrap();
        for (key, value) in [("taps", "3"), ("cascades", "9"), ("filter", "4")] {
            assert!(change(&csm, Baked::default(), key, value).is_err(), "{key}");
        }
    }
}
