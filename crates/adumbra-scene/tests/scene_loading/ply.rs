//! PLY as its definition has it, and as scanners and modelling programs write it.

use adumbra_scene::{Counts, EmptyReason, Error, LoadOptions, Result, Scene};

use crate::kit::{load_bytes, refused, world_triangles};
use crate::ply_kit::{CORNERS, FORMATS, Ply, XYZ};

const PLAIN: fn() -> LoadOptions = LoadOptions::default;

fn load(bytes: &[u8]) -> Result<Scene> {
    load_bytes("scene.ply", bytes, &PLAIN())
}

/// The triangles of a scene, in an order of their own, each from its least corner on.
fn triangles(scene: &Scene) -> Vec<[[f64; 3]; 3]> {
    let turned = |t: [[f64; 3]; 3]| {
        let least = (0..3).min_by(|&a, &b| t[a].partial_cmp(&t[b]).expect("finite")).expect("three");
        [t[least], t[(least + 1) % 3], t[(least + 2) % 3]]
    };
    let mut all: Vec<_> = world_triangles(scene).into_iter().map(turned).collect();
    all.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
    all
}

/// The two triangles of the square that most files here hold.
fn square() -> Vec<[[f64; 3]; 3]> {
    vec![[[0., 0., 0.], [1., 0., 0.], [1., 0., 1.]], [[0., 0., 0.], [1., 0., 1.], [0., 0., 1.]]]
}

fn assert_square(what: &str, bytes: &[u8]) -> Scene {
    let scene = load(bytes).unwrap_or_else(|error| panic!("{what}: {error}"));
    let mut expected = square();
    expected.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
    assert_eq!(triangles(&scene), expected, "{what}");
    scene
}

fn omitted(scene: &Scene) -> Vec<String> {
    scene.notes.omissions.iter().map(ToString::to_string).collect()
}

/// The message of a file that must be refused.
fn message(bytes: &[u8]) -> String {
    let error = refused(load(bytes));
    assert!(matches!(error, Error::SceneParse { .. }), "{error}");
    error.to_string()
}

const HEADER: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                      element face 1\nproperty list uchar int vertex_indices\nend_header\n";
const BODY: &str = "0 0 0\n1 0 0\n1 0 1\n0 0 1\n4 0 1 2 3\n";
const POINTS: [&[f64]; 4] = [&[0., 0., 0.], &[1., 0., 0.], &[1., 0., 1.], &[0., 0., 1.]];
const FACE: &[f64] = &[4., 0., 1., 2., 3.];

/// The file above with changes; each must occur in it.
fn changed(changes: &[(&str, &str)]) -> Vec<u8> {
    let mut text = format!("{HEADER}{BODY}");
    for (from, to) in changes {
        assert!(text.contains(from), "{from:?} is not in the file");
        text = text.replace(from, to);
    }
    text.into_bytes()
}

/// A square in the `xyz` properties, as a file of its own vertices.
fn points() -> Ply {
    Ply::default().with("vertex", &XYZ, &POINTS)
}

fn assert_square_in_all_formats(what: &str, ply: &Ply) -> Vec<String> {
    let notes = FORMATS.map(|format| {
        let what = format!("{what}, {format}");
        omitted(&assert_square(&what, &ply.bytes(format)))
    });
    assert!(notes[0] == notes[1] && notes[0] == notes[2], "{what}: {notes:?}");
    notes[0].clone()
}

#[test]
fn headers_as_programs_write_them() {
    let cases: [(&str, &[(&str, &str)]); 19] = [
        ("as defined", &[]),
        ("CRLF", &[("\n", "\r\n")]),
        ("CR", &[("\n", "\r")]),
        ("a header with LF and records with CRLF", &[("0 0\n", "0 0\r\n"), ("0 1\n", "0 1\r\n")]),
        ("a byte-order mark", &[("ply\n", "\u{feff}ply\n")]),
        ("blank lines", &[("ply\n", "\n\nply\n\n"), ("element", "\n \t\nelement"), ("end_h", "\nend_h")]),
        ("comments everywhere", &[("property", "comment property\nproperty"), ("format", "comment\nformat")]),
        ("a comment with a tab", &[("format", "comment\tformat\nformat")]),
        ("a stray CR in a comment", &[("format", "comment a\rb\nformat")]),
        ("obj_info", &[("element", "obj_info num_cols 512\nobj_info\nelement")]),
        ("several blanks", &[("property float x", "  property \t  float    x  "), ("t v", "t   v")]),
        ("blanks after the end", &[("end_header", "end_header \t ")]),
        ("the format later", &[("format ascii 1.0\n", ""), ("end_header", "format ascii 1.0\nend_header")]),
        ("a version without its zero", &[("ascii 1.0", "ascii 1")]),
        ("stated sizes", &[("float ", "float32 "), ("uchar int ", "uint8 int32 ")]),
        ("double", &[("float ", "double ")]),
        ("integers", &[("float ", "int ")]),
        ("vertex_index", &[("vertex_indices", "vertex_index")]),
        ("the only list of integers", &[("vertex_indices", "corners")]),
    ];
    for (what, changes) in cases {
        let scene = assert_square(what, &changed(changes));
        assert_eq!(omitted(&scene), [""; 0], "{what}");
        assert_eq!(scene.notes.read, Counts { meshes: 1, nodes: 0, faces: 1 }, "{what}");
    }
    let mut latin = b"ply\ncomment gr\xf6\xdfe \xff\nobj_info \xe9\n".to_vec();
    latin.extend(&changed(&[])[4..]);
    assert_square("a Latin-1 comment", &latin);
}

#[test]
fn binary_records_begin_after_the_header_of_each_line_end() {
    for format in FORMATS {
        let ply = points().with("face", &[CORNERS], &[FACE]);
        let header = ply.header(format);
        let records = &ply.bytes(format)[header.len()..];
        for (end, name) in [("\n", "LF"), ("\r\n", "CRLF"), ("\r", "CR"), (" \n", "blank and LF")] {
            let file = [header.replace('\n', end).as_bytes(), records].concat();
            assert_square(&format!("{format}, {name}"), &file);
        }
    }
    // The first record begins with the byte of a line feed.
    let ply = Ply::default()
        .with("mark", &["uchar mark"], &[&[10.], &[13.]])
        .with("vertex", &XYZ, &POINTS)
        .with("face", &[CORNERS], &[FACE]);
    for format in &FORMATS[1..] {
        let header = ply.header(format);
        let records = &ply.bytes(format)[header.len()..];
        for end in ["\n", "\r\n", "\r"] {
            let file = [header.replace('\n', end).as_bytes(), records].concat();
            assert_square(&format!("{format}, {end:?}"), &file);
        }
    }
}

#[test]
fn text_is_words_not_lines() {
    let cases: [(&str, &str); 9] = [
        ("one line", "0 0 0 1 0 0 1 0 1 0 0 1 4 0 1 2 3"),
        ("one word a line", "0\n0\n0\n1\n0\n0\n1\n0\n1\n0\n0\n1\n4\n0\n1\n2\n3\n"),
        ("a list over lines", "0 0 0\n1 0 0\n1 0 1\n0 0 1\n4\n0 1\n2 3\n"),
        ("a vertex over lines", "0 0\n0\n1 0 0\n1 0\n1\n0 0 1\n4 0 1 2 3\n"),
        ("two vertices a line", "0 0 0 1 0 0\n1 0 1 0 0 1\n4 0 1 2 3\n"),
        ("blank lines", "\n\n0 0 0\n\n1 0 0\n1 0 1\n \t\n0 0 1\n\n\n4 0 1 2 3\n\n"),
        ("tabs and blanks", "\t0\t0\t0\n 1  0 0 \n1\t \t0 1\n0 0 1\t\n4\t0 1\t2 3\t \n"),
        ("NUL and Ctrl-Z at the end", "0 0 0\n1 0 0\n1 0 1\n0 0 1\n4 0 1 2 3\n\0\0\x1a"),
        ("whole numbers as floats", "0.0 0 0\n1.0 0 0\n1e0 0 1.\n.0 0 +1\n4.0 0.0 1.0 2e0 +3\n"),
    ];
    for (what, body) in cases {
        for end in ["\n", "\r\n", "\r"] {
            let file = format!("{HEADER}{}", body.replace('\n', end));
            let scene = assert_square(what, file.as_bytes());
            assert_eq!(omitted(&scene), [""; 0], "{what}");
        }
    }
}

#[test]
fn values_that_no_face_needs_may_be_anything() {
    let odd = [
        "nan",
        "-nan",
        "nan(ind)",
        "-nan(ind)",
        "inf",
        "-Infinity",
        "1.#IND",
        "-1.#IND",
        "1.#QNAN",
        "1.#INF00",
    ];
    for word in odd {
        let normals = format!("property float nx\nproperty uchar red\nelement face");
        let file = changed(&[
            ("element face", &normals),
            ("0 0\n", &format!("0 0 {word} 0.5\n")),
            ("0 1\n", "0 1 0 300\n"),
        ]);
        assert_square(word, &file);
        let unused =
            changed(&[("vertex 4", "vertex 5"), ("0 0 1\n4", &format!("0 0 1\n{word} {word} 0\n4"))]);
        let scene = assert_square(word, &unused);
        assert_eq!(scene.meshes[0].positions.len(), 4, "{word}");
        let used = changed(&[("1 0 0\n", &format!("1 {word} 0\n"))]);
        let error = refused(load(&used));
        assert!(
            matches!(error, Error::NotFinite { .. }) && error.to_string().contains("vertex 1"),
            "{error}"
        );
    }
    for color in ["-1", "0.5", "300", "1e9", "4294967296", "12,5", "red"] {
        let file = changed(&[
            ("element face", "property uchar red\nelement face"),
            ("0 0\n", &format!("0 0 {color}\n")),
            ("0 1\n", "0 1 7\n"),
        ]);
        assert_square(color, &file);
    }
    // In binary files as well.
    let nan = f64::NAN;
    let ply = Ply::default()
        .with(
            "vertex",
            &["float x", "float y", "float z", "float nx"],
            &[
                &[0., 0., 0., nan],
                &[1., 0., 0., f64::INFINITY],
                &[1., 0., 1., nan],
                &[0., 0., 1., 0.],
                &[nan, nan, 5., 0.],
            ],
        )
        .with("face", &[CORNERS], &[FACE]);
    assert_eq!(assert_square_in_all_formats("normals", &ply), [""; 0]);
}

#[test]
fn vertices_have_x_y_and_z_among_any_properties() {
    let cases: [(&str, &[&str], [&[f64]; 4]); 6] = [
        (
            "another order",
            &["double z", "float x", "int y"],
            [&[0., 0., 0.], &[0., 1., 0.], &[1., 1., 0.], &[1., 0., 0.]],
        ),
        (
            "others around",
            &["uchar red", "float x", "short tag", "char y", "double quality", "ushort z", "uint64 id"],
            [
                &[7., 0., -9., 0., 0.5, 0., 1e18],
                &[7., 1., 9., 0., 0.5, 0., 1.],
                &[7., 1., 9., 0., 0.5, 1., 2.],
                &[7., 0., 9., 0., 0.5, 1., 3.],
            ],
        ),
        (
            "lists among them",
            &["list uchar int near", "float x", "float y", "list ushort double weights", "float z"],
            [
                &[0., 0., 0., 2., 0.5, 0.5, 0.],
                &[3., 7., 8., 9., 1., 0., 0., 0.],
                &[1., 5., 1., 0., 1., 2.5, 1.],
                &[0., 0., 0., 0., 1.],
            ],
        ),
        ("signed bytes", &["char x", "char y", "char z"], POINTS),
        ("64-bit integers", &["int64 x", "uint64 y", "int64 z"], POINTS),
        ("several types", &["float64 x", "uint8 y", "int16 z"], POINTS),
    ];
    for (what, properties, records) in cases {
        let ply = Ply::default().with("vertex", properties, &records).with("face", &[CORNERS], &[FACE]);
        assert_eq!(assert_square_in_all_formats(what, &ply), [""; 0], "{what}");
    }
    for missing in ["float u", "list uchar float x"] {
        let error = message(&changed(&[("float x", missing)]));
        assert!(error.contains("no x, y and z"), "{error}");
    }
}

#[test]
fn faces_have_one_list_of_corners_among_any_properties() {
    let cases: [(&str, &[&str], &[f64]); 9] = [
        ("tags", &["int flags", CORNERS, "uchar material_index"], &[9., 4., 0., 1., 2., 3., 5.]),
        (
            "texture coordinates",
            &[CORNERS, "list uchar float texcoord", "int texnumber"],
            &[4., 0., 1., 2., 3., 2., 0.5, 0.25, 0.],
        ),
        ("texture coordinates first", &["list int double texcoord", CORNERS], &[1., 0.5, 4., 0., 1., 2., 3.]),
        (
            "vertex_index after another list",
            &["list uchar int group", "list uchar int vertex_index"],
            &[2., 9., 9., 4., 0., 1., 2., 3.],
        ),
        (
            "another name beside texture indices",
            &["list uchar int texture_vertex_indices", "list uchar uint indices"],
            &[1., 9., 4., 0., 1., 2., 3.],
        ),
        (
            "another name beside floats",
            &["list uchar float weights", "list uchar ushort verts"],
            &[1., 9.5, 4., 0., 1., 2., 3.],
        ),
        ("a list of floats by the right name", &["list uchar float vertex_indices"], FACE),
        ("bytes", &["list char uchar vertex_indices"], FACE),
        ("64 bits", &["list uint64 int64 vertex_indices"], FACE),
    ];
    for (what, properties, record) in cases {
        let ply = points().with("face", properties, &[record]);
        assert_eq!(assert_square_in_all_formats(what, &ply), [""; 0], "{what}");
    }
    for count in
        ["char", "uchar", "short", "ushort", "int", "uint", "int8", "uint16", "int32", "int64", "uint64"]
    {
        let ply = points().with("face", &[&format!("list {count} short vertex_indices")], &[FACE]);
        assert_eq!(assert_square_in_all_formats(count, &ply), [""; 0], "{count}");
    }
    // Neither of two lists is that of the corners, or there is none.
    let unclear: [(&[&str], &[f64]); 2] = [
        (&["list uchar int a", "list uchar int b"], &[1., 0., 1., 0.]),
        (&["uchar red", "list uchar float a"], &[1., 1., 0.]),
    ];
    for (properties, record) in unclear {
        let ply = points().with("face", properties, &[record]).with(
            "tristrips",
            &[CORNERS],
            &[&[4., 1., 2., 0., 3.]],
        );
        assert_eq!(assert_square_in_all_formats("no list", &ply), ["1 faces without a list of vertices"]);
    }
}

#[test]
fn elements_come_in_any_order_and_unknown_ones_are_named() {
    let faces_first = Ply::default().with("face", &[CORNERS], &[FACE]).with("vertex", &XYZ, &POINTS);
    assert_eq!(assert_square_in_all_formats("faces first", &faces_first), [""; 0]);
    let ply = Ply::default()
        .with("camera", &["float view_px", "double view_py", "uchar viewport"], &[&[1., 2., 3.]])
        .with("vertex", &XYZ, &POINTS)
        .with("edge", &["int vertex1", "int vertex2"], &[&[0., 1.], &[1., 2.]])
        .with("range_grid", &["list uchar int vertex_indices"], &[&[0.], &[1., 3.], &[0.]])
        .with("multi_texture_vertex", &["uchar tx", "float u", "float v"], &[&[0., 0.5, 0.5]])
        .with("trifans", &["list int int vertex_indices"], &[&[4., 0., 1., 2., 3.]])
        .with("empty", &["float x"], &[])
        .with("face", &[CORNERS, "list uchar float texcoord"], &[&[4., 0., 1., 2., 3., 1., 0.5]])
        .with("material", &["int ambient", "list ushort double factors"], &[&[1., 3., 0.5, 1., 2.]]);
    let expected = [
        "1 elements \"camera\"",
        "2 elements \"edge\"",
        "3 elements \"range_grid\"",
        "1 elements \"multi_texture_vertex\"",
        "1 elements \"trifans\"",
        "1 elements \"material\"",
    ];
    assert_eq!(assert_square_in_all_formats("unknown elements", &ply), expected);
    let strict = LoadOptions { strict: true, ..PLAIN() };
    let error = refused(load_bytes("scene.ply", &ply.bytes("ascii"), &strict));
    assert!(
        matches!(error, Error::Omitted { .. }) && error.to_string().contains("2 elements \"edge\""),
        "{error}"
    );
}

/// The square as one strip: its second triangle is (0, 2, 3).
const STRIP: [f64; 4] = [1., 2., 0., 3.];

#[test]
fn strips_alternate_and_start_anew_at_each_separator() {
    let strips = |list: &str, records: &[&[f64]]| points().with("tristrips", &[list], records);
    let ints = "list int int vertex_indices";
    let end = -1.0;
    let [a, b, c, d] = STRIP;
    let cases: [(&str, Ply); 8] = [
        ("one strip", strips(ints, &[&[4., a, b, c, d]])),
        ("a separator at the end", strips(ints, &[&[5., a, b, c, d, end]])),
        ("two strips", strips(ints, &[&[7., 0., 1., 2., end, 0., 2., 3.]])),
        ("separators in a row", strips(ints, &[&[10., end, 0., 1., 2., end, end, 0., 2., 3., end]])),
        ("two records", strips(ints, &[&[3., 0., 1., 2.], &[3., 0., 2., 3.]])),
        ("bytes and another name", strips("list uchar char strip", &[&[7., 0., 1., 2., end, 0., 2., 3.]])),
        (
            "strips before their vertices",
            Ply::default().with("tristrips", &[ints], &[&[4., a, b, c, d]]).with("vertex", &XYZ, &POINTS),
        ),
        ("beside faces", strips(ints, &[&[3., 0., 1., 2.]]).with("face", &[CORNERS], &[&[3., 0., 2., 3.]])),
    ];
    for (what, ply) in cases {
        assert_eq!(assert_square_in_all_formats(what, &ply), [""; 0], "{what}");
        let read = load(&ply.bytes("ascii")).expect("loads").notes.read;
        assert_eq!(read, Counts { meshes: 1, nodes: 0, faces: 2 }, "{what}");
    }
    // An odd strip before: without a new start the second one would be turned over.
    let odd = strips(ints, &[&[9., 0., 1., 2., 0., 2., end, 0., 2., 3.]]);
    for format in FORMATS {
        let scene = assert_square(format, &odd.bytes(format));
        assert_eq!((scene.notes.read.faces, scene.notes.degenerate_triangles), (4, 2));
    }
    let unsigned =
        strips("list uint uint vertex_indices", &[&[7., 0., 1., 2., f64::from(u32::MAX), 0., 2., 3.]]);
    assert_eq!(assert_square_in_all_formats("unsigned", &unsigned), [""; 0]);
    let short = strips(ints, &[&[9., 0., 1., end, 2., end, a, b, c, d]]);
    let expected = ["2 triangle strips with fewer than three corners"];
    assert_eq!(assert_square_in_all_formats("short strips", &short), expected);
}

#[test]
fn corners_out_of_range_are_errors() {
    for (list, element) in [(CORNERS, "face"), ("list int int vertex_indices", "tristrips")] {
        for format in FORMATS {
            let with =
                |corner: f64| points().with(element, &[list], &[FACE, &[3., 0., 1., corner]]).bytes(format);
            let error = refused(load(&with(4.0)));
            assert!(
                matches!(error, Error::IndexOutOfRange { index: 4, vertices: 4, .. }),
                "{format}: {error}"
            );
            let error = message(&with(-2.0));
            assert!(error.contains(&format!("{element} 1 of 2 uses vertex -2")), "{error}");
        }
    }
    let huge = changed(&[("4 0 1 2 3", "4 0 1 2 5000000000")]);
    assert!(matches!(refused(load(&huge)), Error::IndexOutOfRange { index: 5_000_000_000, .. }));
    let without_vertices = Ply::default().with("face", &[CORNERS], &[FACE]).bytes("ascii");
    assert!(matches!(refused(load(&without_vertices)), Error::IndexOutOfRange { index: 0, vertices: 0, .. }));
    let error = message(&changed(&[("4 0 1 2 3", "4 0 1 2 -1")]));
    assert!(error.contains("face 0 of 1 uses vertex -1, which does not exist (line 14)"), "{error}");
}

#[test]
fn messages_name_the_record_the_property_and_the_line() {
    let cases: [(&[(&str, &str)], &str); 22] = [
        (
            &[("1 0 1\n", "1 zero 1\n")],
            "vertex 2 of 4: its property \"y\" needs a number, but has \"zero\" (line 12)",
        ),
        (&[("1 0 1\n", "1 0,5 1\n")], "but has \"0,5\" (line 12)"),
        (&[("\n", "\r\n"), ("1 0 1\r\n", "1 0x1 1\r\n")], "but has \"0x1\" (line 12)"),
        (&[("\n", "\r"), ("1 0 1\r", "1 0x1 1\r")], "but has \"0x1\" (line 12)"),
        (
            &[("4 0 1 2 3", "4 0 1 2.5 3")],
            "face 0 of 1: its property \"vertex_indices\" needs a whole number, but has \"2.5\" (line 14)",
        ),
        (&[("4 0 1 2 3", "nan 0 1 2 3")], "needs a whole number, but has \"nan\" (line 14)"),
        (&[("4 0 1 2 3", "-4 0 1 2 3")], "face 0 of 1: its list \"vertex_indices\" has -4 items (line 14)"),
        (
            &[("4 0 1 2 3", "4000000 0 1 2 3")],
            "face 0 of 1 is cut off: its list \"vertex_indices\" has 4000000 items, more than the file can hold",
        ),
        (&[("4 0 1 2 3", "4 0 1 2")], "face 0 of 1 is cut off"),
        (
            &[("vertex 4", "vertex 6")],
            "vertex 5 of 6 is cut off: the file ends before its property \"z\" does",
        ),
        (&[("vertex 4", "vertex 99999999999999")], "vertex 5 of 99999999999999 is cut off"),
        (
            &[("vertex 4", "vertex 99999999999999999999999")],
            "element \"vertex\" has \"99999999999999999999999\" records, which is no possible number (line 3, in the header)",
        ),
        (&[("face 1", "face -1")], "element \"face\" has \"-1\" records"),
        (&[("float y", "half y")], "there is no property type \"half\" (line 5, in the header)"),
        (&[("format ascii 1.0\n", "")], "no line \"format\""),
        (&[("ascii", "ascii_zip")], "there is no format \"ascii_zip\""),
        (&[("1.0\n", "2.0\n")], "there is no version \"2.0\""),
        (&[("format ascii 1.0\n", "format ascii 1.0\nformat ascii 1.0\n")], "states its format twice"),
        (&[("end_header\n", "")], "is no keyword of a PLY header (line 9, in the header)"),
        (&[("element vertex 4\n", "")], "a property is stated before any element (line 3"),
        (
            &[("element face 1\n", "element nothing 7\nelement face 1\n")],
            "element \"nothing\" has records but no properties",
        ),
        (&[("ply\n", "plywood\n")], "does not begin with a line \"ply\""),
    ];
    for (changes, part) in cases {
        let error = message(&changed(changes));
        assert!(error.contains(part), "{part:?} is not in {error:?}");
    }
    let many: String = (0..1001).map(|i| format!("element e{i} 0\n")).collect();
    let error = message(&changed(&[("element vertex", &format!("{many}element vertex"))]));
    assert!(error.contains("more than 1000 elements"), "{error}");
    assert!(message(b"ply\nformat ascii 1.0\nelement vertex 1\n").contains("no line \"end_header\""));
}

#[test]
fn binary_files_may_go_on_but_not_end_early() {
    let ply = points().with("face", &[CORNERS, "double quality"], &[&[4., 0., 1., 2., 3., 0.5]]);
    for format in &FORMATS[1..] {
        let bytes = ply.bytes(format);
        assert_square("trailing bytes", &[&bytes[..], b"trailing 1 2 3"].concat());
        let records = ply.header(format).len();
        let cut = |at: usize| message(&bytes[..records + at]);
        assert!(cut(0).contains("vertex 0 of 4 is cut off"), "{}", cut(0));
        assert!(
            cut(30).contains("vertex 2 of 4 is cut off: the file ends before its property \"y\""),
            "{}",
            cut(30)
        );
        assert!(cut(48).contains("face 0 of 1 is cut off: the file ends"), "{}", cut(48));
        assert!(
            cut(60).contains("face 0 of 1 is cut off: its list \"vertex_indices\" has 4 items"),
            "{}",
            cut(60)
        );
        assert!(
            cut(70).contains("face 0 of 1 is cut off: the file ends before its property \"quality\""),
            "{}",
            cut(70)
        );
    }
    let scene = assert_square("trailing words", &[&changed(&[])[..], b"5 6\n7"].concat());
    assert_eq!(omitted(&scene), ["3 values after the last record"]);
    for (count, part) in [(-1.0, "has -1 items"), (100.0, "has 100 items, more than the file can hold")] {
        let mut ply = points().with("face", &["char tag", "list char int vertex_indices"], &[&[0., 0.]]);
        for format in FORMATS {
            ply.elements[1].records[0] = vec![0., 0.];
            let mut bytes = ply.bytes(format);
            bytes.truncate(bytes.len() - if format == "ascii" { 2 } else { 1 });
            if format == "ascii" {
                bytes.extend(count.to_string().bytes());
            } else {
                bytes.push(count as i8 as u8);
            }
            let error = message(&bytes);
            assert!(error.contains("face 0 of 1") && error.contains(part), "{format}: {error}");
        }
    }
}

#[test]
fn files_without_faces_say_why() {
    let reason = |ply: &Ply| {
        let reasons = FORMATS.map(|format| match refused(load(&ply.bytes(format))) {
            Error::NoTriangles { reason, .. } => reason,
            other => panic!("{other}"),
        });
        assert!(reasons[0] == reasons[1] && reasons[0] == reasons[2], "{reasons:?}");
        reasons[0]
    };
    let lines: &[&[f64]] = &[&[2., 0., 1.], &[0.]];
    assert_eq!(reason(&points()), EmptyReason::PointCloud);
    assert_eq!(reason(&points().with("face", &[CORNERS], &[])), EmptyReason::PointCloud);
    assert_eq!(reason(&points().with("face", &[], &[])), EmptyReason::PointCloud);
    assert_eq!(reason(&points().with("tristrips", &[CORNERS], &[])), EmptyReason::PointCloud);
    assert_eq!(reason(&points().with("face", &[CORNERS], lines)), EmptyReason::NoneStored);
    assert_eq!(reason(&points().with("tristrips", &[CORNERS], lines)), EmptyReason::NoneStored);
    assert_eq!(reason(&points().with("edge", &["int a"], &[&[1.]])), EmptyReason::NoneStored);
    assert_eq!(reason(&Ply::default()), EmptyReason::NoneStored);
    let flat = points().with("face", &[CORNERS], &[&[3., 0., 1., 1.]]);
    assert_eq!(reason(&flat), EmptyReason::ZeroArea { triangles: 1 });
    let small = points().with("face", &[CORNERS], &[FACE, lines[0], lines[1]]);
    assert_eq!(
        assert_square_in_all_formats("small faces", &small),
        ["2 faces with fewer than three corners"]
    );
}

#[test]
fn only_used_vertices_decide_where_the_origin_is() {
    let far = [5_000_000.5, 0.0, 4_000_000.25];
    let place = |p: &[f64]| (0..3).map(|a| p[a] + far[a]).collect::<Vec<_>>();
    let mut records: Vec<Vec<f64>> = POINTS.iter().map(|p| place(p)).collect();
    records.push(vec![0.0; 3]);
    let records: Vec<&[f64]> = records.iter().map(Vec::as_slice).collect();
    let ply = Ply::default().with("vertex", &["double x", "double y", "double z"], &records).with(
        "face",
        &[CORNERS],
        &[FACE],
    );
    for format in FORMATS {
        let scene = load(&ply.bytes(format)).expect("loads");
        assert_eq!(scene.meshes[0].positions[2], [1.0, 0.0, 1.0], "{format}");
        assert_eq!(scene.instances[0].world_from_mesh.map(|row| row[3]), far, "{format}");
    }
}
