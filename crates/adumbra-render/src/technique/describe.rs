//! The parameters of a technique as it was called for, without a device: by the reading that it is built from, so neither knows one more.

use super::{Baked, Parameter, SpecReader, TECHNIQUES, TechniqueSpec};
use crate::error::Result;
use crate::hybrid::HybridSettings;
use crate::maps::MapSettings;
use crate::screen_blur::BlurSettings;
use crate::voxel::{CubesOptions, VoxelSettings};
use crate::voxel_csm::VoxelCsmSettings;

/// The parameters that apply to a technique of [`TECHNIQUES`] as it was called for, or to `truth`, which has none: with another word for one
/// others may apply. `baked` gives what comes from files, such as their biases; without one it is what bakes do by default. Another technique
/// within it, such as the `base` of `blur`, is checked and stands as one parameter: [`Parameter::nested`].
///
/// # Errors
/// [`crate::RenderError::Technique`] for a name, a parameter or a value that does not exist.
pub fn describe(spec: &TechniqueSpec, baked: Baked<'_>) -> Result<Vec<Parameter>> {
    let mut reader = spec.reader();
    read(&mut reader, baked)?;
    reader.finish()
}

/// A technique with another value of a parameter: what then applies no longer, and what is as it is by default, is not said. Of `voxel:soft:angle=2`
/// `voxel` remains for `shade=hard`.
///
/// # Errors
/// As [`describe`].
pub fn change(spec: &TechniqueSpec, baked: Baked<'_>, key: &str, value: &str) -> Result<TechniqueSpec> {
    changed(spec, key, value, |reader| read(reader, baked))
}

/// [`change`] by any reading.
pub(crate) fn changed(
    spec: &TechniqueSpec,
    key: &str,
    value: &str,
    read: impl Fn(&mut SpecReader<'_>) -> Result<()>,
) -> Result<TechniqueSpec> {
    let asked = spec.with(key, Some(value));
    let mut reader = asked.reader();
    read(&mut reader)?;
    let is_said = |k: &&str| reader.asked().iter().any(|p| p.key == *k && !p.is_default());
    if reader.asked().iter().all(|p| p.key != key) {
        // No such parameter: the reader knows which there are.
        reader.finish()?;
        return Ok(asked);
    }
    let dropped: Vec<&str> = asked.keys().filter(|k| !is_said(k)).collect();
    Ok(dropped.into_iter().fold(asked.clone(), |spec, key| spec.with(key, None)))
}

fn read(reader: &mut SpecReader<'_>, baked: Baked<'_>) -> Result<()> {
    let spec = reader.spec();
    match spec.name() {
        "none" | "truth" => {}
        "blur" | "blur-dilate" | "blur-bilateral" => {
            let (_, base) = BlurSettings::from_reader(reader)?;
            describe(&base, baked)?;
        }
        "hrsm" => drop(HybridSettings::from_reader(reader)?),
        "voxel" => drop(VoxelSettings::from_reader(reader, baked.light)?),
        "voxel+csm" => drop(VoxelCsmSettings::from_reader(reader)?),
        "voxel-cubes" | "voxel-texture" => drop(CubesOptions::from_reader(reader, baked.tree)?),
        _ => {
            if MapSettings::from_reader(reader)?.is_none() {
                return Err(unknown(spec));
            }
        }
    }
    Ok(())
}

/// The error for a name that is not in [`TECHNIQUES`].
pub(super) fn unknown(spec: &TechniqueSpec) -> crate::RenderError {
    let names: Vec<&str> = TECHNIQUES.iter().map(|(name, _)| *name).collect();
    spec.wrong(format!("there is no such technique; there are: {}", names.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::technique::parameter::tests::holds;

    fn keys(text: &str) -> Vec<&'static str> {
        let spec = text.parse().unwrap();
        describe(&spec, Baked::default()).unwrap().iter().map(|p| p.key).collect()
    }

    #[test]
    fn describe_gives_what_applies() {
        assert!(keys("none").is_empty() && keys("truth").is_empty());
        assert_eq!(keys("voxel"), ["shade", "filter", "layers", "bias", "slope", "normal"]);
        assert_eq!(keys("voxel:soft"), ["shade", "angle", "radius", "bias", "slope", "normal"]);
        assert_eq!(keys("voxel+csm"), ["filter", "layers", "csm"]);
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
        for name in TECHNIQUES.iter().map(|(name, _)| *name).chain(more) {
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
