//! `pack` and `unpack`: one file, stored in two ways.

use std::fs;

use adumbra::{AtRest, ShadowFile};
use adumbra_testing::{Folder, adumbra, json};

#[test]
fn pack_and_unpack_give_each_other_back() {
    let folder = Folder::new();
    let scene = folder.generate("city");
    let [coded, raw] = [folder.path("coded.adumbra"), folder.path("raw.adumbra")];
    let bake = ["bake", &scene, "--resolution", "512", "--progress", "none"];
    assert_eq!(adumbra(&[&bake[..], &["-o", &coded]].concat()).0, 0);
    assert_eq!(adumbra(&[&bake[..], &["--at-rest", "raw", "-o", &raw]].concat()).0, 0);
    let (coded_bytes, raw_bytes) = (fs::read(&coded).unwrap(), fs::read(&raw).unwrap());
    assert!(2 * coded_bytes.len() < raw_bytes.len(), "{} {}", coded_bytes.len(), raw_bytes.len());
    assert!(ShadowFile::from_bytes(&coded_bytes) == ShadowFile::from_bytes(&raw_bytes));

    let other = folder.path("other.adumbra");
    let unpacked = json(&["unpack", &coded, "-o", &other, "--json"]);
    assert!(fs::read(&other).unwrap() == raw_bytes);
    assert_eq!(
        (unpacked["at_rest"].as_str(), unpacked["bytes"].as_u64()),
        (Some("raw"), Some(raw_bytes.len() as u64))
    );
    // In place.
    let packed = json(&["pack", &other, "--json"]);
    assert!(fs::read(&other).unwrap() == coded_bytes);
    assert_eq!(packed["bytes_before"].as_u64(), Some(raw_bytes.len() as u64));
    for (file, at_rest) in [(&coded, "coded"), (&raw, "raw")] {
        assert_eq!(json(&["info", file, "--json"])["at_rest"], at_rest);
    }
    assert!(folder.no_temporary_files());

    // What cannot be read stays as it is.
    let broken = folder.write("broken.adumbra", &coded_bytes[..coded_bytes.len() - 1]);
    let (code, error) = adumbra(&["unpack", &broken]);
    assert_eq!((code, error.contains("cut off")), (3, true), "{error}");
    assert_eq!(fs::read(&broken).unwrap().len(), coded_bytes.len() - 1);
    assert_eq!(ShadowFile::read(&coded).unwrap().to_bytes(AtRest::Coded).unwrap(), coded_bytes);
}

#[cfg(feature = "render")]
#[test]
fn picture_of_levels_of_detail_needs_a_file() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let file = folder.path("p.adumbra");
    let bake = ["bake", &scene, "--resolution", "2048", "--progress", "none", "-o", &file];
    assert_eq!(adumbra(&bake).0, 0);
    let picture = folder.path("level.exr");
    let render = ["render", &scene, "--layer", "level", "--size", "64x48", "-o", &picture];
    let (code, error) = adumbra(&render);
    assert!(code == 2 && error.contains("--shadow-file"), "{error}");
    assert!(!folder.exists("level.exr"));
    assert_eq!(adumbra(&[&render[..], &["--shadow-file", &file]].concat()).0, 0);
    let levels = exr::prelude::read_first_flat_layer_from_file(&picture).unwrap().layer_data;
    let values: Vec<f32> = levels.channel_data.list[0].sample_data.values_as_f32().collect();
    assert!(values.iter().all(|v| [-1.0, 0.0, 1.0, 2.0].contains(v)), "{values:?}");
    assert!(
        values.iter().any(|&v| v > 0.0),
        "the whole scene does not need its finest texels in 64 x 48 pixels"
    );
}
