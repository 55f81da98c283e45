//! PLY as specified, and as scanners and modelling programs write it.

use adumbra_scene::{Counts, Error, LoadOptions};

use crate::kit::{load_bytes, refused};
use crate::ply_kit::{
    CORNERS, FACE, FORMATS, HEADER, POINTS, Ply, XYZ, assert_square, assert_square_in_all_formats, changed,
    load, message, omitted, points,
};

#[test]
fn reads_headers_as_programs_write_them() {
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
fn binary_records_follow_headers_with_any_line_end() {
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
fn text_records_need_not_match_lines() {
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
fn unused_values_may_be_anything() {
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
        let normals = "property float nx\nproperty uchar red\nelement face";
        let file = changed(&[
            ("element face", normals),
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
    // The same applies to binary files.
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

/// The records of four vertices.
type Square = [&'static [f64]; 4];

#[test]
fn finds_x_y_and_z_among_other_vertex_properties() {
    let cases: [(&str, &[&str], Square); 6] = [
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
fn finds_the_corner_list_among_other_face_properties() {
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
    // Either there are two lists that could hold the corners, or there is none.
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
fn elements_come_in_any_order_and_unknown_are_omissions() {
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
    let strict = LoadOptions { strict: true, ..LoadOptions::default() };
    let error = refused(load_bytes("scene.ply", &ply.bytes("ascii"), &strict));
    assert!(
        matches!(error, Error::Omitted { .. }) && error.to_string().contains("2 elements \"edge\""),
        "{error}"
    );
}

/// The square as one strip: its second triangle is (0, 2, 3).
const STRIP: [f64; 4] = [1., 2., 0., 3.];

#[test]
fn strips_alternate_winding_and_restart_at_separators() {
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
    // Strips may be joined by triangles without area. This strip has an even number of corners, so the
    // next strip begins at an odd position.
    let joined = strips(ints, &[&[8., 0., 1., 2., 2., end, 0., 2., 3.]]);
    for format in FORMATS {
        let scene = assert_square(format, &joined.bytes(format));
        assert_eq!((scene.notes.read.faces, scene.notes.degenerate_triangles), (3, 1));
    }
    let unsigned =
        strips("list uint uint vertex_indices", &[&[7., 0., 1., 2., f64::from(u32::MAX), 0., 2., 3.]]);
    assert_eq!(assert_square_in_all_formats("unsigned", &unsigned), [""; 0]);
    let short = strips(ints, &[&[9., 0., 1., end, 2., end, a, b, c, d]]);
    let expected = ["2 triangle strips with fewer than three corners"];
    assert_eq!(assert_square_in_all_formats("short strips", &short), expected);
}

#[test]
fn only_used_vertices_determine_the_origin() {
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
