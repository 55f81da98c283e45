//! Tests of the list of techniques: properties, parameters, and rejected texts.

use super::{
    Design, Reads, Role, TECHNIQUES, TechniqueEntry, TechniqueFiles, TechniqueSpec, Techniques, Truth,
};
use crate::error::Result;
use crate::gpu::Gpu;
use crate::technique::parameter::tests::holds;
use crate::technique::{SpecReader, SpecText, Technique};

fn spec(text: &str) -> TechniqueSpec {
    text.parse().unwrap()
}

fn spec_of(text: &SpecText) -> Result<TechniqueSpec> {
    text.to_string().parse()
}

#[test]
fn sun_degrees_reach_every_technique_that_takes_one() {
    let of = |text: &str| text.parse::<TechniqueSpec>().unwrap().with_sun_degrees(3.0).to_string();
    for (text, expected) in [
        ("pcss", "pcss:sun-degrees=3"),
        ("pcss:sun-degrees=2", "pcss:sun-degrees=2"),
        ("voxel:soft", "voxel:soft:sun-degrees=3"),
        ("voxel:filter=5", "voxel:filter=5"),
        ("blur:base=pcss", "blur:base=pcss/sun-degrees=3"),
        ("voxel:shade=soft:bias=2", "voxel:shade=soft:bias=2:sun-degrees=3"),
        ("voxel:soft:sun-degrees=1", "voxel:soft:sun-degrees=1"),
        ("blur:base=voxel/soft", "blur:base=voxel/soft/sun-degrees=3"),
        ("blur:base=pcss/sun-degrees=1", "blur:base=pcss/sun-degrees=1"),
        ("blur:base=csm/size=1024", "blur:base=csm/size=1024"),
        ("blur", "blur"),
        ("csm", "csm"),
    ] {
        assert_eq!(of(text), expected);
    }
}

#[test]
fn traits_state_which_techniques_take_sun_degrees() {
    for name in TECHNIQUES.iter().map(|t| t.name).chain(["voxel:soft", "blur:base=voxel/soft"]) {
        let spec = spec(name);
        let parameters = spec.base().unwrap_or(&spec).describe(TechniqueFiles::default()).unwrap();
        let has_angle = parameters.iter().any(|p| p.key == "sun-degrees");
        assert_eq!(has_angle, spec.traits().takes_sun_degrees, "{name}");
        assert_eq!(spec.truth() == Truth::SunDisc, has_angle || spec.base().is_some(), "{name}");
    }
}

#[test]
fn reads_names_the_file_of_each_technique() {
    for (text, reads) in [
        ("csm", Reads::Nothing),
        ("truth", Reads::Nothing),
        ("blur", Reads::Nothing),
        ("voxel", Reads::LightFile),
        ("voxel:shade=hard", Reads::LightFile),
        ("voxel:soft", Reads::LightFile),
        ("voxel:path:filter=1", Reads::LightFile),
        ("voxel+csm:csm=cascades=2", Reads::LightFile),
        ("blur:base=voxel/soft", Reads::LightFile),
        ("blur-dilate:base=voxel/filter=5", Reads::LightFile),
    ] {
        assert_eq!(spec(text).reads(), reads, "{text}");
    }
}

#[test]
fn shows_movers_is_false_for_baked_shadows_alone() {
    for (text, shows) in [
        ("csm", true),
        ("none", true),
        ("truth", true),
        ("voxel", false),
        ("voxel:soft", false),
        ("voxel+csm", true),
        ("blur:base=voxel", false),
        ("blur:base=voxel+csm", true),
    ] {
        assert_eq!(spec(text).shows_movers(), shows, "{text}");
    }
}

#[test]
fn rejects_unknown_names_and_lists_the_known_ones() {
    let error = |text: &str| text.parse::<TechniqueSpec>().unwrap_err().to_string();
    assert!(error("unknown:sun-degrees=3").contains("voxel+csm"));
    assert!(error("blur:base=unknown").contains("voxel+csm"));
}

/// A technique of another crate: `pcf` by another name, with one parameter.
#[derive(Debug)]
struct Foreign;

impl Design for Foreign {
    fn read(&self, reader: &mut SpecReader<'_>, _baked: TechniqueFiles<'_>) -> Result<()> {
        reader.count("taps", "number of taps", 3, 1..=9).map(drop)
    }

    fn build(
        &self,
        _gpu: &Gpu,
        spec: &TechniqueSpec,
        _baked: TechniqueFiles<'_>,
    ) -> Result<Box<dyn Technique>> {
        Err(spec.wrong("it is not built".to_owned()))
    }
}

#[test]
fn list_accepts_techniques_of_another_crate() {
    const MORE: &[TechniqueEntry] =
        &[TechniqueEntry { name: "foreign", summary: "of a test", role: Role::Shadows, design: &Foreign }];
    let list = Techniques::product().with(MORE);
    let spec = list.parse("blur:base=foreign/taps=4").unwrap();
    assert_eq!(spec.base().map(ToString::to_string).as_deref(), Some("foreign:taps=4"));
    assert!(list.parse("foreign:taps=10").is_err() && list.parse("foreign:size=1").is_err());
    assert_eq!(list.parameters("foreign"), "taps=3 (1 to 9)");
    assert_eq!(spec.with("base", Some("foreign")).unwrap().to_string(), "blur:base=foreign");
    assert!("foreign".parse::<TechniqueSpec>().is_err());
    assert_eq!(list.iter().count(), TECHNIQUES.len() + 1);
}

fn keys(text: &str) -> Vec<&'static str> {
    spec(text).describe(TechniqueFiles::default()).unwrap().iter().map(|p| p.key).collect()
}

#[test]
fn describe_lists_the_parameters_that_apply() {
    assert!(keys("none").is_empty() && keys("truth").is_empty());
    assert_eq!(keys("voxel"), ["shade", "filter", "march", "bias", "slope", "normal"]);
    assert_eq!(keys("voxel:path"), keys("voxel"));
    assert_eq!(keys("voxel:soft"), ["shade", "sun-degrees", "radius", "bias", "slope", "normal"]);
    assert_eq!(keys("voxel+csm"), ["filter", "csm"]);
    assert!(keys("csm:filter=poisson").contains(&"radius") && !keys("csm").contains(&"radius"));
    assert!(keys("hrsm").contains(&"tolerance") && !keys("hrsm:test=paper").contains(&"tolerance"));
    assert!(keys("blur:base=csm/cascades=2").contains(&"base"));
}

#[test]
fn describe_gives_values_and_defaults() {
    let found = spec("blur:samples=32").describe(TechniqueFiles::default()).unwrap();
    let said: Vec<_> = found.iter().filter(|p| !p.is_default()).map(|p| p.key).collect();
    assert_eq!(said, ["samples"]);
    let sigma = found.iter().find(|p| p.key == "sigma").unwrap();
    assert_eq!((sigma.value.as_str(), sigma.default.as_str()), ("8", "8"));
}

#[test]
fn list_rejects_techniques_that_cannot_be_built() {
    for text in [
        "unknown",
        "none:size=3",
        "blur:base=blur",
        "blur:base=truth",
        "blur:base=pcf/filter=4",
        "blur:pairs=on:passes=1",
        "voxel:sun-degrees=2",
        "voxel+csm:csm=static=cached",
        "voxel+csm:csm=cascades=9",
        "voxel:filter=7",
    ] {
        assert!(text.parse::<TechniqueSpec>().is_err(), "{text}");
    }
}

#[test]
fn accepts_defaults_and_range_ends_but_nothing_beyond() {
    let more = ["csm:filter=poisson", "pcf:filter=poisson", "hrsm:test=paper", "voxel:soft"];
    for name in TECHNIQUES.iter().map(|t| t.name).chain(more) {
        holds(spec(name).text(), |text| spec_of(text)?.describe(TechniqueFiles::default()));
    }
}

#[test]
fn change_writes_the_shortest_text() {
    for (text, key, value, expected) in [
        ("voxel", "shade", "soft", "voxel:soft"),
        ("voxel:soft:sun-degrees=2:bias=0.5", "shade", "hard", "voxel:bias=0.5"),
        ("csm:filter=poisson:radius=3", "filter", "3", "csm:filter=3"),
        ("csm:filter=3", "filter", "5", "csm"),
        ("csm:lambda=0.7", "lambda", "0.50", "csm"),
        ("csm", "far", "90", "csm:far=90"),
        ("hrsm:2048-512", "sizes", "4096-1024", "hrsm"),
        ("blur", "base", "csm/cascades=2", "blur:base=csm/cascades=2"),
        ("voxel+csm", "csm", "filter=3", "voxel+csm:csm=filter=3"),
    ] {
        let changed = spec(text).change(TechniqueFiles::default(), key, value).unwrap();
        assert_eq!(changed.to_string(), expected);
    }
    for (key, value) in [("taps", "3"), ("cascades", "9"), ("filter", "4")] {
        assert!(spec("csm").change(TechniqueFiles::default(), key, value).is_err(), "{key}");
    }
}

#[test]
fn names_are_unique() {
    for (i, entry) in TECHNIQUES.iter().enumerate() {
        assert!(TECHNIQUES[..i].iter().all(|t| t.name != entry.name), "{}", entry.name);
        assert!(!entry.summary.is_empty() && !entry.summary.contains('\n'), "{}", entry.name);
        assert_eq!(spec(entry.name).name(), entry.name);
    }
}
