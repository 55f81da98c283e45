//! Loads small PLY files, most of which hold the same square.

use adumbra_scene::{Error, LoadOptions, Result, Scene};
pub(crate) use adumbra_testing::{PLY_FORMATS as FORMATS, Ply};

use crate::kit::{load_bytes, refused, world_triangles};

pub(crate) const XYZ: [&str; 3] = ["float x", "float y", "float z"];
pub(crate) const CORNERS: &str = "list uchar int vertex_indices";

pub(crate) fn load(bytes: &[u8]) -> Result<Scene> {
    load_bytes("scene.ply", bytes, &LoadOptions::default())
}

/// The triangles of a scene in sorted order, each starting at its smallest corner.
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

pub(crate) fn assert_square(what: &str, bytes: &[u8]) -> Scene {
    let scene = load(bytes).unwrap_or_else(|error| panic!("{what}: {error}"));
    let mut expected = square();
    expected.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
    assert_eq!(triangles(&scene), expected, "{what}");
    scene
}

pub(crate) fn omitted(scene: &Scene) -> Vec<String> {
    scene.notes.omissions.iter().map(ToString::to_string).collect()
}

pub(crate) const HEADER: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                      element face 1\nproperty list uchar int vertex_indices\nend_header\n";
const BODY: &str = "0 0 0\n1 0 0\n1 0 1\n0 0 1\n4 0 1 2 3\n";
pub(crate) const POINTS: [&[f64]; 4] = [&[0., 0., 0.], &[1., 0., 0.], &[1., 0., 1.], &[0., 0., 1.]];
pub(crate) const FACE: &[f64] = &[4., 0., 1., 2., 3.];

/// The file above with replacements. Each replaced text must occur in it.
pub(crate) fn changed(changes: &[(&str, &str)]) -> Vec<u8> {
    let mut text = format!("{HEADER}{BODY}");
    for (from, to) in changes {
        assert!(text.contains(from), "{from:?} is not in the file");
        text = text.replace(from, to);
    }
    text.into_bytes()
}

/// The vertices of the square in the `xyz` properties, without faces.
pub(crate) fn points() -> Ply {
    Ply::default().with("vertex", &XYZ, &POINTS)
}

pub(crate) fn assert_square_in_all_formats(what: &str, ply: &Ply) -> Vec<String> {
    let notes = FORMATS.map(|format| {
        let what = format!("{what}, {format}");
        omitted(&assert_square(&what, &ply.bytes(format)))
    });
    assert!(notes[0] == notes[1] && notes[0] == notes[2], "{what}: {notes:?}");
    notes[0].clone()
}

/// The error message of a file that must be rejected.
pub(crate) fn message(bytes: &[u8]) -> String {
    let error = refused(load(bytes));
    assert!(matches!(error, Error::SceneParse { .. }), "{error}");
    error.to_string()
}
