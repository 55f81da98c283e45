//! Name patterns that match nothing.

use std::fs;

use adumbra_scene::{EmptyReason, Error, LoadOptions, load};
use serde_json::json;

use crate::kit::{Glb, only};

fn town() -> Glb {
    let mut glb = Glb::triangle();
    glb.json["meshes"][0]["name"] = json!("house");
    glb.json["nodes"] =
        json!([{"mesh": 0, "name": "Tower [1]"}, {"mesh": 0, "name": "SkyDome"}, {"name": "Lights"}]);
    glb.json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    glb
}

#[test]
fn unmatched_patterns_are_noted_with_advice() {
    let glb = town();
    let unmatched = |names: &[&str], exclude: &[&str]| -> Vec<String> {
        let scene = glb.load_with(&only(names, exclude)).expect("loads");
        scene.notes.unmatched_patterns.iter().map(ToString::to_string).collect()
    };
    assert!(unmatched(&["house"], &["Sky*"]).is_empty() && unmatched(&[], &["Tower*"]).is_empty());
    // A name in another case, literal brackets, and a node without triangles.
    let said = unmatched(&["house", "default"], &["skydome", "Tower [1]", "Lights"]);
    assert_eq!(said.len(), 3, "{said:?}");
    assert!(
        said[0].contains("\"skydome\" matches no node, mesh or material; similar: \"SkyDome\""),
        "{said:?}"
    );
    assert!(
        said[1].contains("write Tower [[]1[]]") && said[2].contains("\"Lights\" matches only nodes without"),
        "{said:?}"
    );
    assert!(unmatched(&[], &["Tower [[]1[]]"]).is_empty());
}

#[test]
fn unmatched_patterns_are_errors_if_strict_or_nothing_is_kept() {
    let glb = town();
    let strict = |exclude: &[&str]| {
        let scene = glb.load_with(&LoadOptions { strict: true, ..only(&[], exclude) });
        scene.map(|scene| scene.instances.len())
    };
    assert_eq!(strict(&["SkyDome"]).unwrap(), 1);
    assert_eq!(strict(&["Lights"]).unwrap(), 2);
    let error = strict(&["SkyDome", "sky"]).unwrap_err();
    assert!(
        matches!(&error, Error::Unmatched { patterns, .. } if patterns.len() == 1 && patterns[0].excludes)
    );
    assert!(error.to_string().contains("\"sky\" matches no"), "{error}");
    let error = glb.load_with(&only(&["House"], &[])).unwrap_err();
    assert!(matches!(error, Error::NoTriangles { reason: EmptyReason::Filtered { .. }, .. }));
    assert!(error.to_string().contains("similar: \"house\""), "{error}");
    // The filter keeps nothing, although each pattern matches.
    let error = glb.load_with(&only(&["house"], &["house"])).unwrap_err().to_string();
    assert!(error.ends_with("names in the scene"), "{error}");
}

#[test]
fn patterns_match_names_in_obj_and_ply_files() {
    let folder = tempfile::tempdir().unwrap();
    let obj = "o Tower\nv 0 0 0\nv 1 0 0\nv 0 0 1\nusemtl brick\nf 1 2 3\no Sky\nf 1 2 3\n";
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 0 1\n3 0 1 2\n";
    for (name, text, met) in [("town.obj", obj, "Sky"), ("bunny.ply", ply, "bun?y")] {
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        let unmatched = |names: &[&str], exclude: &[&str]| {
            let scene = load(&path, &only(names, exclude)).unwrap();
            scene.notes.unmatched_patterns.into_iter().map(|u| u.pattern).collect::<Vec<_>>()
        };
        assert!(unmatched(&[met], &[]).is_empty());
        assert_eq!(unmatched(&[], &["sky", "brock"]), ["sky", "brock"], "{name}");
    }
}
