//! `convert`: one file, stored in two ways.

use std::fs;
use std::process::Command;

use adumbra::{Encoding, ShadowFile};
use adumbra_testing::{Folder, adumbra, json, program};

#[test]
fn converting_there_and_back_restores_the_bytes() {
    let folder = Folder::new();
    let scene = folder.generate("city");
    let [coded, raw] = [folder.path("coded.adumbra"), folder.path("raw.adumbra")];
    let bake = ["bake", &scene, "--resolution", "512", "--progress", "none"];
    assert_eq!(adumbra(&[&bake[..], &["-o", &coded]].concat()).0, 0);
    assert_eq!(adumbra(&[&bake[..], &["--encoding", "raw", "-o", &raw]].concat()).0, 0);
    let (coded_bytes, raw_bytes) = (fs::read(&coded).unwrap(), fs::read(&raw).unwrap());
    assert!(2 * coded_bytes.len() < raw_bytes.len(), "{} {}", coded_bytes.len(), raw_bytes.len());
    assert!(ShadowFile::from_bytes(&coded_bytes) == ShadowFile::from_bytes(&raw_bytes));

    let other = folder.path("other.adumbra");
    let raw_now = json(&["convert", &coded, "--encoding", "raw", "-o", &other, "--json"]);
    assert!(fs::read(&other).unwrap() == raw_bytes);
    assert_eq!(
        (raw_now["encoding"].as_str(), raw_now["bytes"].as_u64()),
        (Some("raw"), Some(raw_bytes.len() as u64))
    );
    // In place.
    let coded_now = json(&["convert", &other, "--encoding", "coded", "--json"]);
    assert!(fs::read(&other).unwrap() == coded_bytes);
    assert_eq!(coded_now["bytes_before"].as_u64(), Some(raw_bytes.len() as u64));
    for (file, encoding) in [(&coded, "coded"), (&raw, "raw")] {
        assert_eq!(json(&["info", file, "--json"])["encoding"], encoding);
    }
    assert!(folder.no_temporary_files());

    // A file that already has the encoding is copied unchanged.
    json(&["convert", &coded, "--encoding", "coded", "-o", &other, "--json"]);
    assert!(fs::read(&other).unwrap() == coded_bytes);
    let (code, error) = adumbra(&["convert", &coded]);
    assert!(code == 2 && error.contains("--encoding"), "{error}");
    let (code, error) =
        adumbra(&["convert", &coded, "--encoding", "raw", "-o", &folder.path("no/such/a.adumbra")]);
    assert!(code != 0 && error.contains("no/such"), "{error}");

    // A file that cannot be read stays unchanged.
    let broken = folder.write("broken.adumbra", &coded_bytes[..coded_bytes.len() - 1]);
    let (code, error) = adumbra(&["convert", &broken, "--encoding", "raw"]);
    assert_eq!((code, error.contains("cut off")), (3, true), "{error}");
    assert_eq!(fs::read(&broken).unwrap().len(), coded_bytes.len() - 1);
    let (code, error) = adumbra(&["convert", &scene, "--encoding", "raw", "-o", &other]);
    assert_eq!((code, error.contains("not a shadow file")), (3, true), "{error}");
    assert!(fs::read(&other).unwrap() == coded_bytes);
    assert_eq!(ShadowFile::read(&coded).unwrap().to_bytes(Encoding::Coded).unwrap(), coded_bytes);
}

#[test]
fn a_snippet_names_the_file_and_is_printed_alone() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let file = folder.path("p.adumbra");
    let bake = ["bake", &scene, "--resolution", "256", "--progress", "none", "-o", &file];
    assert_eq!(adumbra(&bake).0, 0);
    let printed = Command::new(program()).args(["info", &file, "--snippet", "three"]).output().unwrap();
    let text = String::from_utf8_lossy(&printed.stdout);
    assert!(text.starts_with("import {") && text.contains("loadAsync('p.adumbra')"), "{text}");
    let (code, error) = adumbra(&["info", &scene, "--snippet", "three"]);
    assert_eq!((code, error.contains("not a shadow file")), (3, true), "{error}");
}

#[cfg(feature = "render")]
#[test]
fn level_layer_needs_a_shadow_file() {
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
