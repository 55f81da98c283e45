//! No verb replaces a file that it reads, and everything that a verb cannot answer is reported.

use std::fs;
use std::process::Command;

use adumbra_testing::{Folder, adumbra, json, program, read_f32, stderr};

/// A board of 4 × 4 m, 2 m above a floor of 20 × 20 m.
const BOARD: &str = "mtllib board.mtl\nv -10 0 -10\nv 10 0 -10\nv 10 0 10\nv -10 0 10\nv -2 2 -2\nv 2 2 -2\nv 2 2 2\nv -2 2 2\n\
    f 1 4 3\nf 1 3 2\nf 5 8 7\nf 5 7 6\n";

struct BakedBoard {
    folder: Folder,
    scene: String,
    file: String,
}

fn baked() -> BakedBoard {
    let folder = Folder::new();
    let scene = folder.write("board.obj", BOARD.as_bytes());
    folder.write("board.mtl", b"newmtl a\n");
    let file = folder.path("board.adumbra");
    let (code, error) = bake(&scene, &file, &[]);
    assert_eq!(code, 0, "{error}");
    BakedBoard { folder, scene, file }
}

fn bake(scene: &str, output: &str, more: &[&str]) -> (i32, String) {
    let base = ["bake", scene, "-o", output, "--sun", "0,1,0", "--progress", "none"];
    let resolution = if more.contains(&"--resolution") { &[][..] } else { &["--resolution", "256"] };
    adumbra(&[&base[..], resolution, more].concat())
}

/// Returns other names of a file: another spelling, a symbolic link, a hard link.
fn names(folder: &Folder, name: &str) -> Vec<String> {
    let path = folder.path(name);
    let mut all = vec![path.clone(), folder.path(&format!("./{name}"))];
    #[cfg(unix)]
    {
        let link = folder.path(&format!("soft-{name}"));
        std::os::unix::fs::symlink(name, &link).unwrap();
        all.push(link);
    }
    let link = folder.path(&format!("hard-{name}"));
    fs::hard_link(&path, &link).unwrap();
    all.push(link);
    all
}

/// Checks that every command is refused with this exit code and a message, and leaves the file unchanged.
fn is_kept(path: &str, code: i32, commands: &[Vec<&str>]) {
    let before = fs::read(path).unwrap();
    for command in commands {
        let (found, error) = adumbra(command);
        assert_eq!(found, code, "{command:?}: {error}");
        assert!(error.contains("give another path"), "{command:?}: {error}");
        assert_eq!(fs::read(path).unwrap(), before, "{command:?}");
    }
}

#[test]
fn bake_does_not_overwrite_its_scene_or_files_it_names() {
    let BakedBoard { folder, scene, .. } = baked();
    let library = folder.path("board.mtl");
    for name in names(&folder, "board.obj") {
        is_kept(&scene, 3, &[vec!["bake", &scene, "-o", &name]]);
    }
    for name in names(&folder, "board.mtl") {
        is_kept(&library, 3, &[vec!["bake", &scene, "-o", &name]]);
    }
    // From the scene's folder, with relative paths.
    let output = Command::new(program())
        .args(["bake", "board.obj", "-o", "./board.obj"])
        .current_dir(std::path::Path::new(&scene).parent().unwrap())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    assert_eq!(fs::read_to_string(&scene).unwrap(), BOARD);
}

#[test]
fn bake_does_not_overwrite_files_that_only_the_loader_finds() {
    let folder = Folder::new();
    let face = "v 0 0 0\nv 0 0 1\nv 1 0 0\nusemtl a\nf 1 2 3\n";
    let scene = folder.write("s.obj", format!("mtllib \\\n s.mtl\n{face}").as_bytes());
    let library = folder.write("s.mtl", b"newmtl a\nmap_Bump \\\n d.png\n");
    let texture = folder.write("d.png", b"a texture that no bake reads");
    for path in [&library, &texture] {
        is_kept(path, 3, &[vec!["bake", &scene, "-o", path]]);
    }
    // JSON that glTF allows but a general parser rejects, and a name that means another file on Windows.
    let positions: Vec<u8> = [0.0_f32, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0].map(f32::to_le_bytes).concat();
    let deep = format!("{}{}", "[".repeat(200), "]".repeat(200));
    let names: &[&str] = if cfg!(unix) { &["h.bin", "x\\g.bin"] } else { &["h.bin"] };
    for (name, extras) in
        names.iter().flat_map(|&name| ["1e999", &deep].map(|extras| (name, extras.to_owned())))
    {
        let buffer = folder.write(name, &positions);
        let json = format!(
            r#"{{"asset":{{"version":"2.0"}},"extras":{extras},"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
            "buffers":[{{"uri":{name:?},"byteLength":36}}],"bufferViews":[{{"buffer":0,"byteLength":36}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}]}}"#
        );
        let scene = folder.write("h.gltf", json.as_bytes());
        is_kept(&buffer, 3, &[vec!["bake", &scene, "-o", &buffer]]);
    }
}

#[test]
fn bake_does_not_overwrite_files_named_by_options() {
    let BakedBoard { folder, scene, .. } = baked();
    let gltf = folder.generate("primitives");
    let edits = folder.write("moves.json", b"{}");
    let (linked, edited) = (["bake", &scene, "--link-in", &gltf], ["bake", &scene, "--edit", &edits]);
    for name in names(&folder, "primitives.glb") {
        is_kept(&gltf, 3, &[[&linked[..], &["-o", &name]].concat()]);
    }
    is_kept(&edits, 3, &[[&edited[..], &["-o", &edits]].concat()]);
    // A folder that becomes the cache.
    let place = folder.path("place.adumbra");
    let (code, error) = adumbra(&["bake", &scene, "--cache", &place, "-o", &place]);
    assert!(code == 3 && error.contains("the cache"), "{code}: {error}");
    let suns = folder.write("suns.csv", b"2026-06-21T10:00:00Z 140 55\n");
    is_kept(&suns, 2, &[vec!["bake", &scene, "--suns", &suns, "-o", &suns]]);
    let plan = folder.path("a.plan.json");
    is_kept(&scene, 3, &[vec!["plan", &scene, "-o", &plan, "--export", "make", "--shadow-file", &scene]]);
    let (code, error) = adumbra(&["plan", &scene, "-o", &plan, "--export", "make", "--shadow-file", &plan]);
    assert!(code == 3 && error.contains("one file"), "{code}: {error}");
    assert_eq!(adumbra(&["plan", &scene, "-o", &plan, "--resolution", "256"]).0, 0);
    assert_eq!(adumbra(&["tile", "--plan", &plan]).0, 0);
    is_kept(&scene, 3, &[vec!["link", "--plan", &plan, "-o", &scene]]);
    is_kept(&plan, 3, &[vec!["link", "--plan", &plan, "-o", &plan]]);
}

#[test]
fn query_does_not_overwrite_its_inputs() {
    let BakedBoard { folder, file, .. } = baked();
    let points = folder.write_f32("p.f32", &[0.0, 0.0, 0.0]);
    let normals = folder.write_f32("n.f32", &[0.0, 1.0, 0.0]);
    let query = ["query", &file, "--points", &points, "--normals", &normals];
    for (path, name) in [(&file, "board.adumbra"), (&points, "p.f32"), (&normals, "n.f32")] {
        for other in names(&folder, name) {
            is_kept(path, 2, &[[&query[..], &["-o", &other]].concat()]);
        }
    }
    let doubles = folder.write("p.f64", &[0; 24]);
    is_kept(&doubles, 2, &[vec!["query", &file, "--points-f64", &doubles, "-o", &doubles]]);
}

#[test]
fn render_does_not_overwrite_its_inputs() {
    let BakedBoard { folder, scene, file } = baked();
    // Pictures have extensions of their own, but links can have any.
    let picture = folder.path("picture.png");
    for (path, name) in [(&scene, "scene"), (&file, "file")] {
        fs::hard_link(path, folder.path(&format!("{name}.png"))).unwrap();
        let output = folder.path(&format!("{name}.png"));
        let draw = ["render", &scene, "--shadow-file", &file, "--device", "cpu", "--size", "32x32", "-o"];
        is_kept(path, 2, &[[&draw[..], &[&output]].concat()]);
        let (code, error) = adumbra(&[&draw[..], &[&picture]].concat());
        assert_eq!(code, 0, "{error}");
    }
}

#[test]
fn compare_does_not_overwrite_inputs_in_its_folder() {
    let BakedBoard { folder, scene, file } = baked();
    let out = folder.path("out");
    fs::create_dir(&out).unwrap();
    fs::hard_link(&file, folder.path("out/report.md")).unwrap();
    let compare =
        ["compare", &scene, "--shadow-file", &file, "--shadow", "voxel", "--size", "32x32", "-o", &out];
    is_kept(&file, 2, &[compare.to_vec()]);
    let (code, error) = adumbra(&[&compare[..9], &[&folder.path("new")]].concat());
    assert_eq!(code, 0, "{error}");
}

#[test]
fn compare_does_not_overwrite_its_camera_or_path() {
    let BakedBoard { folder, scene, .. } = baked();
    let out = folder.path("out");
    fs::create_dir(&out).unwrap();
    let camera = folder.write(
        "out/report.json",
        br#"{"eye": [9, 9, 9], "target": [0, 0, 0], "fov_y": 45, "size": [32, 32]}"#,
    );
    let compare = ["compare", &scene, "--shadow", "none", "--size", "32x32", "--frames", "1", "-o", &out];
    is_kept(&camera, 2, &[[&compare[..], &["--camera", &camera]].concat()]);
    let key = r#"{"eye": [9, 9, 9], "target": [0, 0, 0], "fov": 45}"#;
    let path = folder
        .write("out/report.json", format!(r#"{{"frames": 2, "keyframes": [{key}, {key}]}}"#).as_bytes());
    is_kept(&path, 2, &[[&compare[..], &["--path", &path]].concat()]);
}

#[cfg(unix)]
#[test]
fn rejects_two_outputs_that_are_one_file() {
    use std::os::unix::fs::symlink;
    let BakedBoard { folder, scene, file } = baked();
    // Frames of a render, and tables of a comparison.
    let frames = [0, 1].map(|i| folder.path(&format!("r.000{i}.png")));
    symlink(&frames[0], &frames[1]).unwrap();
    let picture = folder.path("r.png");
    let render = ["render", &scene, "--shadow-file", &file, "--device", "cpu", "--size", "32x32", "--move"];
    let (code, error) = adumbra(
        &[&render[..], &["sphere:radius=1:from=5,1,5:to=6,1,6", "--frames", "2", "-o", &picture]].concat(),
    );
    assert_eq!((code, error.contains("are one file")), (2, true), "{error}");
    let out = folder.path("out");
    fs::create_dir(&out).unwrap();
    let tables = folder.write("out/report.md", b"earlier");
    symlink("report.md", folder.path("out/report.json")).unwrap();
    let (code, error) =
        adumbra(&["compare", &scene, "--shadow", "none", "--size", "32x32", "--frames", "1", "-o", &out]);
    assert_eq!((code, error.contains("are one file")), (2, true), "{error}");
    assert_eq!(fs::read(&tables).unwrap(), b"earlier");
    // The files that a demo leaves in its folder.
    let mine = folder.write("out/report.html", b"earlier");
    symlink("report.html", folder.path("out/city.adumbra")).unwrap();
    let (code, error) = adumbra(&["demo", "--out", &out]);
    assert_eq!(fs::read(&mine).unwrap(), b"earlier");
    assert_eq!((code, error.contains("are one file")), (2, true), "{error}");
}

#[test]
fn failed_convert_or_query_keeps_earlier_files() {
    let BakedBoard { folder, file, .. } = baked();
    let points = folder.write_f32("p.f32", &[0.0; 3]);
    let missing = folder.path("missing/v.f32");
    let (code, error) = adumbra(&["query", &file, "--points", &points, "-o", &missing]);
    assert_eq!((code, error.contains("create it first")), (3, true), "{error}");

    #[cfg(target_os = "linux")]
    {
        let raw = folder.write("raw.adumbra", b"earlier");
        let city = folder.path("city.adumbra");
        let (code, error) = bake(&folder.generate("city"), &city, &["--resolution", "512"]);
        assert_eq!(code, 0, "{error}");
        // A limit on file sizes has the effect of a full disk: the file is larger than one block of 512
        // bytes.
        let limited = "ulimit -f 1; exec \"$@\"";
        let convert = ["convert", &city, "--encoding", "raw", "-o", &raw];
        let output =
            Command::new("sh").args(["-c", limited, "sh"]).arg(program()).args(convert).output().unwrap();
        let said = stderr(&output);
        assert_eq!(
            (output.status.code(), said.contains("raise the file size limit")),
            (Some(4), true),
            "{said}"
        );
        assert_eq!(fs::read(&raw).unwrap(), b"earlier");
    }
    assert!(folder.no_temporary_files());
}

#[cfg(unix)]
#[test]
fn interrupts_leave_no_temporary_files() {
    let BakedBoard { folder, file, .. } = baked();
    let points = folder.write("p.f32", &vec![0; 12 * 2_000_000]);
    let answers = folder.path("v.f32");
    // The program may end before the signal arrives.
    let was_interrupted = (0..20).any(|_| {
        let mut run = Command::new(program())
            .args(["query", &file, "--points", &points, "-o", &answers])
            .spawn()
            .unwrap();
        while folder.no_temporary_files() && run.try_wait().unwrap().is_none() {}
        let signal = Command::new("kill").args(["-INT", &run.id().to_string()]).status();
        let code = run.wait().unwrap().code();
        assert!(folder.no_temporary_files(), "{code:?}");
        signal.is_ok() && code == Some(130)
    });
    assert!(was_interrupted);
}

#[cfg(unix)]
#[test]
fn bake_keeps_the_permissions_of_the_replaced_file() {
    use std::os::unix::fs::PermissionsExt;
    let BakedBoard { folder: _folder, scene, file } = baked();
    fs::set_permissions(&file, fs::Permissions::from_mode(0o600)).unwrap();
    let (code, error) = bake(&scene, &file, &[]);
    assert_eq!(code, 0, "{error}");
    assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
}

#[cfg(unix)]
#[test]
fn output_that_is_a_symbolic_link_is_followed() {
    let BakedBoard { folder, scene, file } = baked();
    let (link, target) = (folder.path("link.adumbra"), folder.path("store/target.adumbra"));
    fs::create_dir(folder.path("store")).unwrap();
    std::os::unix::fs::symlink("store/target.adumbra", &link).unwrap();
    // The target does not exist at first, then it does.
    for _ in 0..2 {
        let (code, error) = bake(&scene, &link, &[]);
        assert_eq!(code, 0, "{error}");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&target).unwrap(), fs::read(&file).unwrap());
        fs::write(&target, "earlier").unwrap();
    }
    let round = folder.path("round.adumbra");
    std::os::unix::fs::symlink(&round, &round).unwrap();
    let (code, error) = bake(&scene, &round, &[]);
    assert_eq!(code, 3, "{error}");
    assert!(error.contains("too many symbolic links"), "{error}");
    assert!(folder.no_temporary_files());
}

#[test]
fn query_reports_non_finite_points_and_normals() {
    let BakedBoard { folder, file, .. } = baked();
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    // Four invalid points, two in the board's shadow, one in the sun.
    let points = [
        [nan, 0.0, 0.0],
        [0.0, nan, 0.0],
        [inf, 0.0, 0.0],
        [0.0, -inf, 0.0],
        [0.0; 3],
        [1.0, 0.0, 1.0],
        [8.0, 0.0, 8.0],
    ];
    let points = folder.write_f32("p.f32", points.as_flattened());
    let answers = folder.path("v.f32");
    let query = ["query", &file, "--points", &points, "-o", &answers];
    let output = Command::new(program()).args(query).output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    let said = stderr(&output);
    assert_eq!((said.lines().count(), said.contains("4 of 7 points are not finite")), (1, true), "{said}");
    assert_eq!(read_f32(&answers), [1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 1.0]);
    let up = [0.0, 1.0, 0.0];
    let normals = [up, up, up, up, [nan; 3], [0.0, inf, 0.0], up];
    let normals = folder.write_f32("n.f32", normals.as_flattened());
    let with_normals = [&query[..], &["--normals", &normals]].concat();
    let found = json(&[&with_normals[..], &["--json"]].concat());
    assert_eq!((&found["points_not_finite"], &found["normals_not_finite"]), (&4.into(), &2.into()));
    // A normal that is not finite does not make a shadowed point lit.
    assert_eq!(read_f32(&answers), [1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 1.0]);
    let (_, said) = adumbra(&with_normals);
    assert!(said.contains("4 of 7 points") && said.contains("2 of 7 normals"), "{said}");
    // Nothing is printed if all points are valid.
    let one = folder.write_f32("one.f32", &[0.0; 3]);
    assert_eq!(adumbra(&["query", &file, "--points", &one, "-o", &answers]), (0, String::new()));
}

#[test]
fn warns_of_empty_bounds() {
    let BakedBoard { folder, scene, .. } = baked();
    let output = folder.path("b.adumbra");
    let beside = ["--bounds", "100,0,100,110,5,110"];
    let (code, error) = bake(&scene, &output, &beside);
    assert_eq!(code, 0);
    assert!(error.contains("--bounds contain no part of"), "{error}");
    for (bounds, empty) in [(beside, true), (["--bounds", "-1,-1,-1,1,1,1"], false)] {
        let base = ["bake", &scene, "-o", &output, "--resolution", "64", "--progress", "none", "--json"];
        let found = json(&[&base[..], &bounds].concat());
        assert_eq!(found["empty_bounds"], empty, "{bounds:?}");
    }
    let (code, error) = bake(&scene, &output, &[]);
    assert_eq!((code, error.as_str()), (0, ""));
    // A box inside the triangle's bounding box, but far from the triangle. A dry run reports it too.
    let slope = folder.write("slope.obj", b"v 0 0 0\nv 100 0 0\nv 0 100 100\nf 1 3 2\n");
    let run = ["bake", &slope, "--resolution", "64", "--dry-run", "--json", "--bounds"];
    assert_eq!(json(&[&run[..], &["90,80,90,95,95,95"]].concat())["empty_bounds"], true);
    assert_eq!(json(&[&run[..], &["30,30,30,31,31,31"]].concat())["empty_bounds"], false);
    let (code, error) = bake(&scene, &output, &["--bounds", "nan,0,0,1,1,1"]);
    assert_eq!((code, error.contains("warning")), (2, false), "{error}");
    assert!(error.contains("six finite numbers"), "{error}");
}

#[test]
fn options_out_of_range_are_usage_errors() {
    let BakedBoard { folder, scene, file } = baked();
    let output = folder.path("b.adumbra");
    for (options, says) in [
        (["--sun", "0,0,0"], "direction"),
        (["--sun", "0,-1,0"], "horizon"),
        (["--sun", "nan,1,0"], "direction"),
        (["--elevation", "-5"], "horizon"),
        (["--resolution", "1000"], "1024"),
        (["--resolution", "4"], "try 8"),
        (["--resolution", "524288"], "try 262144"),
    ] {
        let (code, error) = adumbra(&[&["bake", &scene, "-o", &output][..], &options].concat());
        assert_eq!((code, error.contains(says)), (2, true), "{options:?}: {error}");
    }
    for share in ["2", "nan", "-0.1"] {
        let (code, error) = adumbra(&["verify", &file, "--scene", &scene, "--min-interior", share]);
        assert_eq!((code, error.contains("from 0 to 1")), (2, true), "{share}: {error}");
    }
}

#[test]
fn points_of_64_bits_are_answered_far_from_the_origin() {
    let folder = Folder::new();
    // The board, 10,000 km to the east, where float32 has steps of one metre.
    let east: Vec<String> = BOARD
        .lines()
        .map(|line| match line.strip_prefix("v ").map(|v| v.split(' ').collect::<Vec<_>>()) {
            Some(v) => format!("v {} {} {}", v[0].parse::<f64>().unwrap() + 1e7, v[1], v[2]),
            None => line.to_owned(),
        })
        .collect();
    let scene = folder.write("east.obj", east.join("\n").as_bytes());
    let file = folder.path("east.adumbra");
    let (code, error) = bake(&scene, &file, &[]);
    assert_eq!(code, 0, "{error}");
    // Points across the shadow's border at x = 2, a tenth of a metre apart.
    let steps = (-5..5).map(|step| f64::from(step) * 0.1 + 0.05);
    let points: Vec<f64> = steps.flat_map(|step| [1e7 + 2.0 + step, 0.0, 0.0]).collect();
    let doubles = folder.write("p.f64", &points.iter().flat_map(|c| c.to_le_bytes()).collect::<Vec<_>>());
    let floats = folder.write_f32("p.f32", &points.iter().map(|&c| c as f32).collect::<Vec<_>>());
    let answers = folder.path("v.f32");
    let lit = |option: &str, points: &str| {
        let (code, error) = adumbra(&["query", &file, option, points, "-o", &answers]);
        assert_eq!(code, 0, "{error}");
        read_f32(&answers)
    };
    assert_eq!(lit("--points-f64", &doubles), [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0]);
    assert_ne!(lit("--points", &floats), lit("--points-f64", &doubles));
    // Exactly one of the two options must be given, and the file must hold whole triples.
    let odd = folder.write("odd", &[0; 16]);
    let none = folder.path("none.f32");
    for (points, code) in [
        (&[][..], 2),
        (&["--points", &floats, "--points-f64", &doubles], 2),
        (&["--points", &odd], 3),
        (&["--points-f64", &odd], 3),
    ] {
        let (found, error) = adumbra(&[&["query", &file, "-o", &none][..], points].concat());
        assert_eq!(found, code, "{error}");
        assert!(!folder.exists("none.f32"), "{points:?}");
    }
}
