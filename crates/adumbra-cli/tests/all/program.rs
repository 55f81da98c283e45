//! The program as its users see it: verbs, exit codes, JSON fields, and the files that remain when something
//! fails.

use std::fs;
use std::process::{Command, Stdio};

use adumbra_testing::{Folder, adumbra, json, program, stderr};
use serde_json::Value;

#[test]
fn bake_info_verify_query_and_render_work_together() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let file = folder.path("p.adumbra");
    let baked = json(&[
        "bake",
        &scene,
        "--sun",
        "-0.5,0.8,-0.35",
        "--resolution",
        "1024",
        "-o",
        &file,
        "--json",
        "--progress",
        "none",
    ]);
    for key in ["seconds", "peak_bytes", "file_bytes", "bits_per_texel", "levels"] {
        assert!(baked[key].as_f64().is_some_and(|v| v > 0.0), "bake says {key}: {baked}");
    }
    let info = json(&["info", &file, "--json"]);
    for key in ["file_bytes", "bits_per_texel"] {
        assert_eq!(info[key], baked[key], "{key}");
    }
    // 1024 and 256 texels; the next level would have 64.
    let levels = info["levels"].as_array().unwrap();
    assert_eq!((levels.len() as u64, baked["levels"].as_u64()), (2, Some(2)));
    let sum = |key: &str| levels.iter().map(|level| level[key].as_u64().unwrap()).sum::<u64>();
    let parts = ["table_bytes", "common_bytes", "bundle_bytes"].map(sum);
    let all = info["front_bytes"].as_u64().unwrap() + parts.iter().sum::<u64>();
    assert_eq!(Some(all), info["file_bytes"].as_u64(), "{info}");
    assert!(levels.iter().all(|level| level["leaves"].as_u64() > Some(0)), "{info}");
    assert_eq!(info["file_bytes"].as_u64(), Some(fs::metadata(&file).unwrap().len()));
    for (number, level) in levels.iter().enumerate() {
        let picture = folder.path("pages.png");
        adumbra(&["info", &file, "--picture", &picture, "--level", &number.to_string()]);
        let [width, height] = image::image_dimensions(&picture).map(<[u32; 2]>::from).unwrap();
        let [pages_x, pages_y] = [0, 1].map(|a| level["pages"][a].as_u64().unwrap() as u32);
        assert!(width % pages_x == 0 && width * pages_y == height * pages_x, "{width} x {height}: {level}");
        fs::remove_file(&picture).unwrap();
        let bytes = [0, 1, 2].map(|i| level["page_bytes"][i].as_u64().unwrap());
        assert!(0 < bytes[0] && bytes.is_sorted() && bytes[2] <= level["raw_bytes"].as_u64().unwrap());
    }
    assert_eq!(adumbra(&["info", &file, "--picture", &folder.path("pages.png"), "--level", "2"]).0, 2);
    assert_eq!(adumbra(&["info", &file, "--picture", &file]).0, 2);
    assert_eq!(info["settings"]["resolution"], 1024);
    assert!(info["sun"][0].as_f64().unwrap() < 0.0);

    let verified = json(&["verify", &file, "--scene", &scene, "--samples", "20000", "--json"]);
    let keys = ["samples", "agreement", "interior_agreement", "interior_share", "acne", "leak"];
    for key in keys {
        assert!(verified[key].is_number(), "verify says {key}: {verified}");
    }
    assert!(verified["interior_agreement"].as_f64().unwrap() >= 0.999, "{verified}");
    let of_level =
        |level| ["verify", &file, "--scene", &scene, "--samples", "20000", "--level", level, "--json"];
    let coarse = json(&of_level("1"));
    assert!(coarse["interior_agreement"].as_f64().unwrap() >= 0.999, "{coarse}");
    assert_ne!(coarse["agreement"], verified["agreement"]);
    let promised = [&verified, &coarse].map(|verified| {
        let classes = verified["classes"].as_array().unwrap();
        let class = |name| classes.iter().find(|class| class["class"] == name).unwrap();
        [
            ("interior", "promised_agreement"),
            ("grazing", "promised_agreement"),
            ("edge", "promised_misplaced"),
        ]
        .map(|(name, what)| class(name)[what].as_f64().unwrap())
    });
    assert_eq!(promised, [[0.999, 0.995, 0.005]; 2]);
    let (code, error) = adumbra(&of_level("2"));
    assert!(code == 2 && error.contains("are 0 to 1"), "{error}");

    // A point high above everything is lit, and so is one next to the grid, far beyond the edge of the
    // ground.
    let points = folder.write_f32("points.f32", &[0.0, 500.0, 0.0, 9000.0, 0.0, 0.0]);
    let normals = folder.write_f32("normals.f32", &[0.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
    let output = folder.path("v.f32");
    for filter in ["1", "3", "5", "9", "17"] {
        let answer = json(&[
            "query",
            &file,
            "--points",
            &points,
            "--normals",
            &normals,
            "--filter",
            filter,
            "-o",
            &output,
            "--json",
        ]);
        assert_eq!(answer["points"], 2);
        assert_eq!(adumbra_testing::read_f32(&output), [1.0, 1.0], "filter {filter}");
    }

    let picture = folder.path("p.png");
    for extra in [vec![], vec!["--diff"], vec!["--truth"]] {
        let mut arguments = vec!["render", &scene, "--shadow-file", &file, "--size", "64x48", "-o", &picture];
        arguments.extend(extra);
        assert_eq!(adumbra(&arguments).0, 0);
        assert!(fs::read(&picture).unwrap().starts_with(b"\x89PNG"));
    }
}

#[test]
#[ignore = "slow: bakes again and again"]
fn bake_writes_the_same_bytes_for_any_threads_and_memory() {
    let folder = Folder::new();
    let scene = folder.generate("city");
    let bytes_with = |name: &str, extra: &[&str]| {
        let file = folder.path(name);
        let mut arguments = vec!["bake", &scene, "--resolution", "1024", "--progress", "none", "-o", &file];
        arguments.extend(extra);
        assert_eq!(adumbra(&arguments).0, 0);
        fs::read(&file).unwrap()
    };
    let reference = bytes_with("a", &[]);
    assert!(reference == bytes_with("b", &["--threads", "1"]));
    assert!(reference == bytes_with("c", &["--threads", "3", "--max-memory", "400MiB"]));
    let lossless = bytes_with("d", &["--no-closed-regions", "--assume-ground", "no"]);
    assert!(lossless != reference);
}

#[test]
fn generate_makes_models_without_a_ground() {
    let folder = Folder::new();
    for (kind, triangles) in [("ball", 268_800), ("sphere-grid", 12_000), ("wires", 5_732)] {
        let said = json(&["inspect", &folder.generate(kind), "--json"]);
        assert_eq!(said["instanced_triangles"], triangles, "{kind}");
        assert_eq!((&said["bounds"]["min"][1], &said["solid_share"]), (&0.0.into(), &1.0.into()), "{kind}");
    }
}

#[test]
fn verify_exits_with_1_when_the_scene_is_another() {
    let folder = Folder::new();
    let (one, other) = (folder.generate("primitives"), folder.generate("spheres"));
    let file = folder.path("p.adumbra");
    assert_eq!(adumbra(&["bake", &one, "--resolution", "256", "-o", &file]).0, 0);
    for more in [&[][..], &["--json"]] {
        let verify = ["verify", &file, "--scene", &other, "--samples", "5000"];
        let (code, error) = adumbra(&[&verify[..], more].concat());
        assert_eq!(code, 1, "{error}");
        assert!(error.contains("is this the scene"), "{error}");
    }
}

#[test]
fn usage_errors_exit_with_2() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let file = folder.path("p.adumbra");
    let cases: &[&[&str]] = &[
        &[],
        &["fly"],
        &["bake"],
        &["bake", &scene, "--sun", "1,2"],
        &["bake", &scene, "--sun", "a,b,c"],
        &["bake", &scene, "--resolution", "many"],
        &["bake", &scene, "--azimuth", "10"],
        &["bake", &scene, "--yaw", "10"],
        &["bake", &scene, "--frame", "oblique", "--yaw", "200"],
        &["bake", &scene, "--thickness", "-1", "-o", &file],
        &["bake", &scene, "--switch-within", "65536", "-o", &file],
        &["bake", &scene, "--bounds", "1,0,0,0,1,1", "-o", &file],
        &["bake", &scene, "--voxel-size", "0", "-o", &file],
        &["bake", &scene, "--only", "[", "-o", &file],
        &["bake", &scene, "--max-memory", "lots"],
        &["render", &scene, "-o", &file],
        &["render", &scene, "--truth", "--size", "0x1", "-o", &file],
    ];
    for case in cases {
        let (code, error) = adumbra(case);
        assert_eq!(code, 2, "{case:?}: {error}");
    }
    assert!(!folder.exists("p.adumbra"));
}

#[test]
fn bad_inputs_exit_with_3_and_name_the_fault_and_the_fix() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let whole = fs::read(&scene).unwrap();
    let cut = folder.write("cut.glb", &whole[..whole.len() / 2]);
    let empty = folder.write("empty.glb", b"");
    let strange = folder.write("scene.xyz", b"?");
    let nan = folder.write("nan.obj", b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let point = folder.write("point.obj", b"v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n");
    let range = folder.write("range.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n");
    let nothing = folder.write("nothing.obj", b"v 0 0 0\n");
    let texture = folder.write("texture.gltf", adumbra_testing::MASKED_GLTF.as_bytes());
    let extension = folder.write("extension.gltf", adumbra_testing::REQUIRING_GLTF.as_bytes());
    let below = folder.path("nan.obj/below.adumbra");
    let folder_name = folder.path("");
    let missing = folder.path("missing.glb");
    let file = folder.path("out.adumbra");
    fs::write(&file, b"earlier").unwrap();
    let cases: &[(&[&str], &str)] = &[
        (&["bake", &missing], "check the name"),
        (&["bake", &folder_name], "scene format"),
        (&["bake", &empty], "empty.glb"),
        (&["bake", &cut], "cut.glb"),
        (&["bake", &strange], ".glb"),
        (&["bake", &nan], "nan.obj"),
        (&["bake", &point], "point.obj"),
        (&["bake", &range], "range.obj"),
        (&["bake", &nothing], "no triangles"),
        (&["bake", &texture], "--ignore-alpha"),
        (&["bake", &extension], "EXT_not_supported"),
        (&["bake", &scene, "--only", "nothing-has-this-name"], "no triangles"),
        (&["bake", &scene, "-o", &below], "below.adumbra"),
        (&["bake", &scene, "-o", &folder_name], "folder"),
        (&["info", &scene], "shadow file"),
        (&["info", &missing], "check the name"),
        (&["info", &folder_name], "name a file in it"),
        (&["verify", &empty, "--scene", &scene], "empty.glb"),
    ];
    for (case, says) in cases {
        let mut arguments = case.to_vec();
        if case[0] == "bake" && !case.contains(&"-o") {
            arguments.extend(["-o", &file]);
        }
        let (code, error) = adumbra(&arguments);
        assert_eq!(code, 3, "{case:?}: {error}");
        assert!(error.starts_with("error: ") || error.contains("\nerror: "), "{case:?}: {error}");
        assert!(error.contains(says), "{case:?} should mention {says}: {error}");
    }
    assert_eq!(fs::read(&file).unwrap(), b"earlier");
    assert!(folder.no_temporary_files());
}

#[test]
fn ignore_alpha_needs_no_texture() {
    let folder = Folder::new();
    let texture = folder.write("texture.gltf", adumbra_testing::MASKED_GLTF.as_bytes());
    let file = folder.path("t.adumbra");
    let (code, error) = adumbra(&["bake", &texture, "--ignore-alpha", "--resolution", "64", "-o", &file]);
    assert_eq!(code, 0, "{error}");
    assert_eq!(json(&["info", &file, "--json"])["settings"]["ignore_alpha"], true);
}

#[test]
fn damaged_shadow_files_exit_with_3() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let file = folder.path("p.adumbra");
    assert_eq!(adumbra(&["bake", &scene, "--resolution", "256", "-o", &file]).0, 0);
    let good = fs::read(&file).unwrap();
    let mut flipped = good.clone();
    // The first byte of the section `top`.
    flipped[384] ^= 1;
    let mut future = good.clone();
    future[8] = 99;
    for (bytes, says) in
        [(&good[..good.len() - 5], "bytes"), (&flipped[..], "checksum"), (&future[..], "version 99")]
    {
        fs::write(&file, bytes).unwrap();
        let (code, error) = adumbra(&["info", &file]);
        assert_eq!(code, 3, "{error}");
        assert!(error.contains("p.adumbra") && error.contains(says), "{error}");
    }
}

#[test]
fn too_little_memory_exits_with_4_and_leaves_the_earlier_file() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let file = folder.write("p.adumbra", b"earlier");
    let (code, error) =
        adumbra(&["bake", &scene, "--resolution", "1024", "--max-memory", "1MiB", "-o", &file]);
    assert_eq!(code, 4, "{error}");
    assert!(error.contains("--max-memory"), "{error}");
    assert_eq!(fs::read(&file).unwrap(), b"earlier");
}

#[cfg(target_os = "linux")]
#[test]
fn full_disk_exits_with_4_and_leaves_the_earlier_file() {
    let folder = Folder::new();
    let scene = folder.generate("city");
    let file = folder.write("p.adumbra", b"earlier");
    // A file-size limit simulates a full disk: 16 blocks are a few KiB, the bake is larger.
    let line = "ulimit -f 16; exec \"$0\" bake \"$1\" --resolution 1024 --progress none -o \"$2\"";
    let output = Command::new("sh").args(["-c", line]).arg(program()).args([&scene, &file]).output().unwrap();
    assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
    assert!(stderr(&output).contains("p.adumbra"), "{}", stderr(&output));
    assert_eq!(fs::read(&file).unwrap(), b"earlier");
    assert!(folder.no_temporary_files());
}

#[cfg(unix)]
#[test]
fn interrupt_exits_with_130_and_leaves_the_earlier_file() {
    let folder = Folder::new();
    let scene = folder.generate("city");
    let file = folder.write("p.adumbra", b"earlier");
    let mut child = Command::new(program())
        .args(["bake", &scene, "--resolution", "32768", "--progress", "json", "-o", &file])
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // The first progress line shows that the bake is under way.
    let mut lines = std::io::BufRead::lines(std::io::BufReader::new(child.stderr.take().unwrap()));
    let first: Value = serde_json::from_str(&lines.next().unwrap().unwrap()).unwrap();
    assert!(first["done"].as_u64().unwrap() >= 1 && first["total"].as_u64().unwrap() > 100);
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let rest: Vec<String> = lines.map_while(Result::ok).collect();
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(rest.iter().any(|l| l.contains("interrupted")), "{rest:?}");
    assert_eq!(fs::read(&file).unwrap(), b"earlier");
    assert!(folder.no_temporary_files());
}

#[cfg(target_os = "linux")]
#[test]
fn verify_exits_with_130_when_interrupted() {
    let folder = Folder::new();
    let scene = folder.generate("city");
    let file = folder.path("p.adumbra");
    assert_eq!(adumbra(&["bake", &scene, "--resolution", "256", "-o", &file]).0, 0);
    let mut child = Command::new(program())
        .args(["verify", &file, "--scene", &scene, "--samples", "1000000000"])
        .spawn()
        .unwrap();
    crate::interrupts::wait_for_handler(child.id());
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
}

#[test]
fn dry_run_writes_nothing_and_forecasts_the_file() {
    let folder = Folder::new();
    let scene = folder.generate("city");
    let file = folder.path("p.adumbra");
    let settings = ["bake", &scene, "--resolution", "2048", "-o", &file, "--json", "--progress", "none"];
    let forecast = json(&[&settings[..], &["--dry-run"]].concat());
    assert!(!folder.exists("p.adumbra"));
    let baked = json(&settings);
    let range = |key: &str| [0, 1].map(|i| forecast[key][i].as_f64().unwrap());
    let bytes = baked["file_bytes"].as_f64().unwrap();
    let [low, high] = range("file_bytes");
    assert!(low <= bytes && bytes <= high, "{low} <= {bytes} <= {high}");
    assert_eq!(forecast["root_blocks"], baked["root_blocks"]);
    assert!(range("memory_bytes")[0] > 0.0 && range("seconds")[1] > 0.0);
}

#[test]
fn inspect_says_what_a_scene_holds() {
    let folder = Folder::new();
    let scene = folder.generate("city");
    let said = json(&["inspect", &scene, "--json"]);
    for key in ["triangles", "instanced_triangles", "instances", "closed_share", "suggested_resolution"] {
        assert!(said[key].as_f64().is_some_and(|v| v > 0.0), "{key}: {said}");
    }
    assert_eq!(said["masked_materials"], 0);
    assert!(said["closed_share"].as_f64().unwrap() > 0.9);
    assert!(said["bounds"]["max"][1].as_f64().unwrap() > said["bounds"]["min"][1].as_f64().unwrap());
}

#[test]
fn every_verb_shows_an_example() {
    for verb in ["generate", "inspect", "bake", "info", "verify", "query", "convert", "render", "demo"] {
        let output = Command::new(program()).args([verb, "--help"]).output().unwrap();
        assert_eq!(output.status.code(), Some(0));
        let text = String::from_utf8(output.stdout).unwrap();
        assert!(text.contains(&format!("Example: adumbra {verb}")), "{verb}: {text}");
    }
}

#[test]
#[ignore = "slow: the whole demo"]
fn demo_leaves_the_file_pictures_and_a_report() {
    let folder = Folder::new();
    let out = folder.path("demo");
    let (code, error) = adumbra(&["demo", "--resolution", "1024", "--out", &out]);
    assert_eq!(code, 0, "{error}");
    for name in
        ["city.glb", "city.adumbra", "city.png", "street.png", "street-truth.png", "street-difference.png"]
    {
        assert!(folder.exists(&format!("demo/{name}")), "{name}");
    }
    let report = fs::read_to_string(folder.path("demo/report.html")).unwrap();
    assert!(report.contains("interior agreement"));
    assert_eq!(report.matches("<figure class=\"pair\"").count(), 2);
    assert_eq!(report.matches("src=\"data:image/").count(), 6, "pictures are embedded in the page");
}

#[test]
fn link_in_names_the_file_and_keeps_the_scene_loadable() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let before = json(&["inspect", &scene, "--json"]);
    let file = folder.path("p.adumbra");
    let bake = ["bake", &scene, "--resolution", "64", "--progress", "none"];
    let (code, message) = adumbra(&[&bake[..], &["-o", &file, "--link-in", &scene]].concat());
    assert_eq!(code, 0, "{message}");
    let text = String::from_utf8_lossy(&fs::read(&scene).unwrap()).into_owned();
    assert!(text.contains(r#""extras":{"adumbra":{"shadow":"p.adumbra"}}"#), "the scene names the file");
    let after = json(&["inspect", &scene, "--json"]);
    assert_eq!([&after["triangles"], &after["instances"]], [&before["triangles"], &before["instances"]]);
    // A second bake changes nothing but the file.
    let named = fs::read(&scene).unwrap();
    assert_eq!(adumbra(&[&bake[..], &["-o", &file, "--link-in", &scene]].concat()).0, 0);
    assert_eq!(fs::read(&scene).unwrap(), named);
    let elsewhere = Folder::new();
    for (into, output) in [(&*scene, elsewhere.path("p.adumbra")), (&file, file.clone())] {
        let (code, message) = adumbra(&[&bake[..], &["-o", &output, "--link-in", into]].concat());
        assert_eq!(code, 2, "{message}");
        assert!(message.contains("--link-in"), "{message}");
    }
    assert_eq!(fs::read(&scene).unwrap(), named);
}
