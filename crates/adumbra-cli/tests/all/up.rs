//! Scenes in which Z points up.

use std::fs;

use adumbra_testing::{Folder, adumbra, json};

/// A town of 80 × 80 in which Z points up, a ground and two towers, as an OBJ file of its corners after
/// `turn`.
fn town(turn: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<u8> {
    let mut text = String::new();
    let mut count = 0;
    let mut quad = |corners: [[f64; 3]; 4]| {
        for [x, y, z] in corners.map(&turn) {
            text += &format!("v {x} {y} {z}\n");
        }
        text += &format!("f {} {} {} {}\n", count + 1, count + 2, count + 3, count + 4);
        count += 4;
    };
    let floor = |x: [f64; 2], y: [f64; 2], z: f64| {
        [[x[0], y[0], z], [x[1], y[0], z], [x[1], y[1], z], [x[0], y[1], z]]
    };
    quad(floor([-40.0, 40.0], [-40.0, 40.0], 0.0));
    for (x, y, height) in [(-20.0, -25.0, 20.0), (10.0, 15.0, 12.0)] {
        let [foot, roof] = [0.0, height].map(|z| floor([x, x + 9.0], [y, y + 6.0], z));
        quad(roof);
        for (i, j) in [(0, 1), (1, 2), (2, 3), (3, 0)] {
            quad([foot[i], foot[j], roof[j], roof[i]]);
        }
    }
    text.into_bytes()
}

#[test]
fn scene_with_z_up_bakes_and_verifies_like_one_with_y_up() {
    let folder = Folder::new();
    let z_up = folder.write("z.obj", &town(|p| p));
    let y_up = folder.write("y.obj", &town(|[x, y, z]| [x, z, 0.0 - y]));
    let bake = |scene: &str, name: &str, more: &[&str]| {
        let file = folder.path(name);
        let words = [&["bake", scene, "--resolution", "1024", "-o", &file], more].concat();
        let (code, said) = adumbra(&words);
        assert_eq!(code, 0, "{said}");
        (file, said)
    };
    let sun = ["--azimuth", "200", "--elevation", "35"];
    let (from_z, said) = bake(&z_up, "z.adumbra", &[&["--up", "z"], &sun[..]].concat());
    assert!(!said.contains("Z points up"), "{said}");
    let (from_y, said) = bake(&y_up, "y.adumbra", &sun);
    assert!(!said.contains("Z points up"), "{said}");
    // Only the flag differs, and with it the header's checksum.
    let [mut z, y] = [&from_z, &from_y].map(|file| fs::read(file).unwrap());
    assert_eq!((z[16] & 32, y[16] & 32), (32, 0));
    z[16] &= !32;
    z[252..256].copy_from_slice(&y[252..256]);
    assert!(z == y);
    assert_eq!(json(&["info", &from_z, "--json"])["settings"]["scene_is_z_up"], true);

    // The file records how its scene was loaded; an option overrides it.
    let verify = |more: &[&str]| {
        let words = ["verify", &from_z, "--scene", &z_up, "--samples", "20000"];
        adumbra(&[&words, more].concat())
    };
    assert_eq!([verify(&[]).0, verify(&["--up", "z"]).0], [0, 0]);
    // Loaded with Y up, the scene has the same casters, but looks like another scene.
    let (code, said) = verify(&["--up", "y"]);
    assert!(
        code == 1 && said.contains("is this the scene") && !said.contains("warning: the file was baked from"),
        "{said}"
    );
    // The file also fits the town with Y up.
    assert_eq!(adumbra(&["verify", &from_z, "--scene", &y_up, "--up", "y", "--samples", "20000"]).0, 0);

    // Machines that share a bake take the axis from the plan.
    let plan = folder.path("z.plan");
    let (code, said) =
        adumbra(&[&["plan", &z_up, "--up", "z", "--resolution", "1024", "-o", &plan], &sun[..]].concat());
    assert_eq!(code, 0, "{said}");
    let linked = folder.path("linked.adumbra");
    for words in [&["tile", "--plan", &plan][..], &["link", "--plan", &plan, "-o", &linked]] {
        let (code, said) = adumbra(words);
        assert_eq!(code, 0, "{said}");
    }
    assert!(fs::read(&linked).unwrap() == fs::read(&from_z).unwrap());
}

#[test]
fn warns_of_a_scene_that_seems_to_have_z_up() {
    let folder = Folder::new();
    let scene = folder.write("z.obj", &town(|p| p));
    let file = folder.path("z.adumbra");
    let bake = |more: &[&str]| {
        let words = ["bake", &scene, "--resolution", "256", "-o", &file];
        adumbra(&[&words, more].concat())
    };
    let (code, said) = bake(&[]);
    assert!(code == 0 && said.contains("--up z"), "{said}");
    let (code, said) = bake(&["--up", "y"]);
    assert!(code == 0 && !said.contains("--up z"), "{said}");

    // A sun from the south in coordinates with Z up. The options that the error suggests work.
    let (code, said) = bake(&["--sun", "0,-1,1"]);
    assert!(code == 2 && said.contains("if Z points up in the scene, give --up z --sun 0,1,1"), "{said}");
    assert_eq!(bake(&["--up", "z", "--sun", "0,1,1"]).0, 0);
    let (code, said) = bake(&["--up", "z", "--sun", "0,-1,1"]);
    assert!(code == 2 && said.contains("there the direction is 0,1,1"), "{said}");
    // The error does not suggest --up where it would not help.
    for words in [&["--up", "y", "--sun", "0,-1,1"][..], &["--sun", "0,-1,-1"], &["--elevation", "-5"]] {
        let (code, said) = bake(words);
        assert!(code == 2 && !said.contains("--up z"), "{said}");
    }
    let glb = folder.generate("city");
    let (code, said) = adumbra(&["bake", &glb, "--up", "z", "-o", &file]);
    assert!(code == 2 && said.contains("Y up by definition") && said.contains("(--up)"), "{said}");
    let (code, said) = adumbra(&["bake", &glb, "--sun", "0,-1,1", "-o", &file]);
    assert!(code == 2 && !said.contains("--up"), "{said}");
}
