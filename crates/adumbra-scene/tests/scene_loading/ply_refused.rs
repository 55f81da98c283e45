//! PLY files that cannot be loaded, or only in part. Errors name the record, the property and the line.

use adumbra_scene::{EmptyReason, Error};

use crate::kit::refused;
use crate::ply_kit::{
    CORNERS, FACE, FORMATS, Ply, assert_square, assert_square_in_all_formats, changed, load, message,
    omitted, points,
};

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
fn binary_files_may_have_trailing_bytes_but_not_be_truncated() {
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
fn files_without_faces_are_errors_with_a_reason() {
    let reason = |ply: &Ply| {
        let reasons = FORMATS.map(|format| match refused(load(&ply.bytes(format))) {
            Error::NoTriangles { reason, .. } => reason,
            other => panic!("{other}"),
        });
        assert!(reasons[0] == reasons[1] && reasons[0] == reasons[2], "{reasons:?}");
        reasons[0].clone()
    };
    let lines: &[&[f64]] = &[&[2., 0., 1.], &[0.]];
    assert_eq!(reason(&points()), EmptyReason::PointCloud);
    assert_eq!(reason(&points().with("face", &[CORNERS], &[])), EmptyReason::PointCloud);
    assert_eq!(reason(&points().with("face", &[], &[])), EmptyReason::PointCloud);
    assert_eq!(reason(&points().with("tristrips", &[CORNERS], &[])), EmptyReason::PointCloud);
    let left_out = |ply: &Ply| match reason(ply) {
        EmptyReason::OnlyOmitted { omissions } => {
            omissions.iter().map(ToString::to_string).collect::<Vec<_>>()
        }
        other => panic!("{other}"),
    };
    let faces = points().with("face", &[CORNERS], lines);
    assert_eq!(left_out(&faces), ["2 faces with fewer than three corners"]);
    let strips = points().with("tristrips", &[CORNERS], lines);
    assert_eq!(left_out(&strips), ["1 triangle strips with fewer than three corners"]);
    let others = points().with("face", &["int a"], &[&[1.]]).with("edge", &["int a"], &[&[1.], &[2.]]);
    assert_eq!(left_out(&others), ["1 faces without a list of vertices", "2 elements \"edge\""]);
    let error = refused(load(&others.bytes("ascii"))).to_string();
    assert!(
        error.contains("no triangles; it holds only 1 faces without a list of vertices, 2 elements"),
        "{error}"
    );
    assert_eq!(reason(&Ply::default()), EmptyReason::NoneStored);
    let flat = points().with("face", &[CORNERS], &[&[3., 0., 1., 1.]]);
    assert_eq!(reason(&flat), EmptyReason::ZeroArea { triangles: 1 });
    let small = points().with("face", &[CORNERS], &[FACE, lines[0], lines[1]]);
    assert_eq!(
        assert_square_in_all_formats("small faces", &small),
        ["2 faces with fewer than three corners"]
    );
}
