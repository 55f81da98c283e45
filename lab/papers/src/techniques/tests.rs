//! Tests of the list of techniques: properties, parameters, and refused values.

use adumbra_render::technique::{Parameter, ParameterKind};
use adumbra_render::{Reads, TechniqueFiles, TechniqueSpec, Techniques, Truth};

use super::{GRAPH_FILE, TECHNIQUES, TREE_FILE};

fn parse(text: &str) -> adumbra_render::Result<TechniqueSpec> {
    Techniques::product().with(TECHNIQUES).parse(text)
}

fn describe(text: &str) -> Vec<Parameter> {
    parse(text).unwrap().describe(TechniqueFiles::default()).unwrap()
}

#[test]
fn technique_names_are_unique() {
    let all: Vec<_> = Techniques::product().with(TECHNIQUES).iter().collect();
    for (i, entry) in all.iter().enumerate() {
        assert!(all[..i].iter().all(|t| t.name != entry.name), "{}", entry.name);
        assert!(!entry.summary.is_empty() && !entry.summary.contains('\n'), "{}", entry.name);
        assert_eq!(parse(entry.name).unwrap().name(), entry.name);
    }
    assert_eq!(all.len(), Techniques::product().iter().count() + TECHNIQUES.len());
}

#[test]
fn techniques_report_file_kind_and_no_movers() {
    for (text, file) in [
        ("voxel-dag", GRAPH_FILE),
        ("voxel-cubes", TREE_FILE),
        ("voxel-texture", TREE_FILE),
        ("voxel-texture:read=buffer", TREE_FILE),
        ("blur-dilate:base=voxel-cubes/filter=5", TREE_FILE),
    ] {
        let spec = parse(text).unwrap();
        assert_eq!((spec.reads(), spec.shows_movers()), (Reads::Other(file), false), "{text}");
    }
}

#[test]
fn techniques_assume_hard_sun() {
    for entry in TECHNIQUES {
        let spec = parse(entry.name).unwrap();
        assert!(spec.truth() == Truth::HardSun && !spec.traits().takes_sun_degrees, "{}", entry.name);
        assert!(describe(entry.name).iter().all(|p| p.key != "sun-degrees"), "{}", entry.name);
    }
}

#[test]
fn describe_lists_only_applicable_parameters() {
    let keys = |text: &str| describe(text).iter().map(|p| p.key).collect::<Vec<_>>();
    assert_eq!(keys("voxel-dag"), ["filter", "bias", "slope", "normal"]);
    assert_eq!(keys("voxel-cubes"), ["filter", "weights", "taps", "bias", "slope", "normal"]);
    assert_eq!(keys("voxel-texture"), [&keys("voxel-cubes")[..], &["read"]].concat());
    assert!(parse("voxel-cubes:read=buffer").is_err());
}

#[test]
fn accepts_defaults_and_range_ends_and_rejects_values_beyond() {
    for entry in TECHNIQUES {
        let plain = describe(entry.name);
        for p in &plain {
            let parameter = format!("{}: {}: {}", entry.name, p.key, p.what);
            let takes = |value: &str| parse(&format!("{}:{}={value}", entry.name, p.key)).is_ok();
            assert!(!p.what.is_empty() && !p.what.contains('\n') && p.is_default(), "{parameter}");
            assert_eq!(describe(&format!("{}:{}={}", entry.name, p.key, p.default)), plain, "{parameter}");
            match &p.kind {
                ParameterKind::Number { range } => {
                    let (least, most) = (*range.start(), *range.end());
                    assert!(takes(&least.to_string()) && takes(&most.to_string()), "{parameter}");
                    let beyond = [least - 1.0, most * 1.01 + 1.0];
                    assert!(beyond.iter().all(|value| !takes(&value.to_string())), "{parameter}");
                }
                ParameterKind::Integer { choices } => {
                    assert!(choices.iter().all(|c| takes(&c.to_string())), "{parameter}");
                    assert!(!takes(&(choices.iter().max().unwrap() + 1).to_string()), "{parameter}");
                }
                ParameterKind::Word { choices } => {
                    assert!(choices.len() > 1 && choices.contains(&p.default.as_str()), "{parameter}");
                    assert!(choices.iter().all(|c| takes(c)), "{parameter}");
                }
                ParameterKind::Count { .. } | ParameterKind::Technique { .. } => panic!("{parameter}"),
            }
            assert!(!takes("zzz"), "{parameter}");
        }
    }
}
