//! Warnings of `inspect`, `bake` and `verify` about scenes that would look wrong, although their files agree
//! with rays.

use adumbra_testing::{Folder, adumbra, json};

/// A ground of 60 × 60 with 40 posts on it, and more nodes in the same OBJ file.
fn town(posts: usize, more: &str) -> Vec<u8> {
    let mut text = String::from("o ground\nv -30 0 -30\nv -30 0 30\nv 30 0 30\nv 30 0 -30\nf -4 -3 -2 -1\n");
    for i in 0..posts {
        let (x, z) = (7 * (i % 8) as i32 - 25, 10 * (i / 8) as i32 - 21);
        text += &format!(
            "o post_{i}\nv {x} 0 {z}\nv {x} 6 {z}\nv {x}.5 6 {z}.5\nv {x}.5 0 {z}.5\nf -4 -3 -2 -1\n"
        );
    }
    (text + more).into_bytes()
}

#[test]
fn warns_of_sky_domes_and_strays_that_can_be_excluded() {
    let folder = Folder::new();
    let sky = "o SkyBox\nv -90 -90 -90\nv 90 -90 -90\nv 90 90 -90\nv -90 90 -90\nv -90 -90 90\nv 90 -90 90\nv 90 90 90\nv -90 90 90\n\
        f -8 -7 -6 -5\nf -4 -1 -2 -3\nf -8 -4 -3 -7\nf -5 -6 -2 -1\nf -8 -5 -1 -4\nf -7 -3 -2 -6\n";
    let stray = "o lost\nv 200000 0 0\nv 200001 0 0\nv 200000 1 1\nf -3 -2 -1\n";
    let (dome, wide) = (folder.write("sky.obj", &town(40, sky)), folder.write("wide.obj", &town(40, stray)));
    let file = folder.path("a.adumbra");
    let bake = |scene: &str, more: &[&str]| {
        let (code, said) = adumbra(&[&["bake", scene, "--resolution", "1024", "-o", &file], more].concat());
        assert_eq!(code, 0, "{said}");
        said
    };
    let hides = "\"SkyBox\" hides the sun from";
    assert!(bake(&dome, &[]).contains(hides) && bake(&dome, &["--dry-run"]).contains(hides));
    for words in [&["inspect", &dome][..], &["verify", &file, "--scene", &dome, "--samples", "20000"]] {
        let said = adumbra(words).1;
        assert!(said.contains(hides) && said.contains("--exclude 'SkyBox'"), "{said}");
    }
    assert!(!bake(&dome, &["--exclude", "SkyBox"]).contains("hides the sun"));

    let said = bake(&wide, &[]);
    assert!(said.contains("\"lost\" reaches 200001,1,1:") && said.contains("--exclude 'lost'"), "{said}");
    assert!(!bake(&wide, &["--exclude", "lost"]).contains("voxels of"));
    // The box in the warning can be given as an option.
    let given = said.split_ascii_whitespace().find(|word| word.starts_with("--bounds=")).unwrap();
    assert!(!bake(&wide, &[given]).contains("voxels of"), "{given}");
    let (code, said) = adumbra(&["verify", &file, "--scene", &wide, "--samples", "20000"]);
    assert!(code == 0 && !said.contains("voxels of"), "{said}");

    // The JSON output reports them too.
    let glance = &json(&["inspect", &dome, "--json"])["glance"];
    assert_eq!(glance["hide_the_sun"], serde_json::json!(["SkyBox"]));
    let glance = &json(&["bake", &wide, "--json", "--resolution", "256", "-o", &file])["glance"];
    assert_eq!(glance["stray"], "lost");
    assert!(
        glance["side"].as_f64().unwrap() < 100.0 && glance["ground_in_shadow"].as_f64().unwrap() > 0.01,
        "{glance}"
    );
    let verified = json(&["verify", &file, "--scene", &wide, "--samples", "20000", "--json"]);
    assert_eq!(verified["glance"]["stray"], "lost");
    assert!(verified["glance"]["standing_in_shadow"].is_number());
}

#[test]
fn verify_warns_that_a_file_omits_shadows_on_the_ground() {
    let folder = Folder::new();
    let (scene, file) = (folder.write("a.obj", &town(40, "")), folder.path("a.adumbra"));
    let said = |exclude: &[&str], assumed: &str| {
        let bake = ["bake", &scene, "--resolution", "256", "--assume-ground", assumed, "-o", &file];
        assert_eq!(adumbra(&[&bake, exclude].concat()).0, 0);
        let verify = ["verify", &file, "--scene", &scene, "--samples", "5000"];
        adumbra(&[&verify, exclude].concat()).1.contains("the scene has no ground of its own")
    };
    let alone = ["--exclude", "ground"];
    let kept =
        [said(&alone, "yes"), said(&alone, "auto"), said(&alone, "no"), said(&[], "auto"), said(&[], "yes")];
    assert_eq!(kept, [true, false, false, false, false]);
}

#[test]
fn verify_reports_that_the_casters_have_changed() {
    let folder = Folder::new();
    let (before, after) = (folder.write("a.obj", &town(40, "")), folder.write("b.obj", &town(37, "")));
    let file = folder.path("a.adumbra");
    assert_eq!(adumbra(&["bake", &before, "--resolution", "1024", "-o", &file]).0, 0);
    let verify = |scene: &str| adumbra(&["verify", &file, "--scene", scene, "--samples", "20000"]).1;
    let said = verify(&after);
    assert!(
        said.contains(
            "baked from 82 triangles in 41 instances that cast shadows, and the scene has 76 in 38"
        ),
        "{said}"
    );
    assert!(!verify(&before).contains("baked from"));
    let words = ["verify", &file, "--scene", &after, "--samples", "20000", "--json"];
    let verified = json(&words);
    assert_eq!([&verified["baked_triangles"], &verified["scene_triangles"]], [82, 76]);
}

#[test]
fn verify_distinguishes_a_coarse_grid_from_another_scene() {
    let folder = Folder::new();
    let (posts, city) = (folder.write("a.obj", &town(40, "")), folder.generate("city"));
    let file = folder.path("a.adumbra");
    let check = |scene: &str, of: &str, more: &[&str]| {
        assert_eq!(adumbra(&["bake", of, "--resolution", "64", "-o", &file]).0, 0);
        let words = ["verify", &file, "--scene", scene, "--samples", "50000", "--min-interior", "1"];
        adumbra(&[&words, more].concat())
    };
    // A coarse file of the right scene, checked against a stricter limit than it can meet.
    let (code, said) = check(&city, &city, &[]);
    assert!(
        code == 1 && said.contains("finer --resolution") && !said.contains("is this the scene"),
        "{said}"
    );
    // Another scene.
    let (code, said) = check(&city, &posts, &[]);
    assert!(code == 1 && said.contains("is this the scene"), "{said}");
}
