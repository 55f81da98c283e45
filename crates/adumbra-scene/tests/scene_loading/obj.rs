//! OBJ and MTL files as programs write them: encodings, comments, names, superseded statements, and
//! omissions.

use adumbra_scene::{AlphaMode, LoadOptions, Result, Scene, load};

use crate::kit::world_triangles;

/// A folder with `scene.obj` and other files; names are bytes.
pub(crate) struct Folder(tempfile::TempDir);

impl Folder {
    pub(crate) fn new(obj: impl AsRef<[u8]>) -> Self {
        let folder = Self(tempfile::tempdir().expect("a temporary folder"));
        folder.with("scene.obj", obj)
    }

    pub(crate) fn with(self, name: &str, content: impl AsRef<[u8]>) -> Self {
        std::fs::write(self.0.path().join(name), content).expect("writes");
        self
    }

    /// Adds a file whose name is not UTF-8.
    #[cfg(target_os = "linux")]
    fn with_bytes(self, name: &[u8], content: &str) -> Self {
        use std::os::unix::ffi::OsStrExt;
        std::fs::write(self.0.path().join(std::ffi::OsStr::from_bytes(name)), content).expect("writes");
        self
    }

    pub(crate) fn load_with(&self, options: &LoadOptions) -> Result<Scene> {
        load(&self.0.path().join("scene.obj"), options)
    }

    pub(crate) fn load(&self) -> Result<Scene> {
        self.load_with(&LoadOptions::default())
    }
}

/// The result of a load as text: the triangles of each used material, with its opacity if that is not 1, then
/// the omissions; or the error.
fn summary(result: Result<Scene>) -> String {
    let scene = match result {
        Ok(scene) => scene,
        Err(e) => {
            let text = e.to_string();
            assert!(text.contains("scene.obj") && !text.contains('\n'), "{text}");
            return format!("error: {}", text.split_once(": ").map_or("", |(_, what)| what));
        }
    };
    let mut parts = Vec::new();
    for (index, material) in scene.materials.iter().enumerate() {
        let all = scene.meshes.iter().flat_map(|m| &m.triangle_materials);
        let count = all.filter(|&&m| m as usize == index).count();
        if count > 0 {
            let mask = if material.alpha == AlphaMode::Opaque { "" } else { " masked" };
            let alpha = material.base_color[3];
            let alpha = if alpha == 1.0 { String::new() } else { format!(" {alpha:.2}") };
            parts.push(format!("{}{mask}{alpha}: {count}", material.name));
        }
    }
    let omissions: Vec<String> = scene.notes.omissions.iter().map(ToString::to_string).collect();
    if !omissions.is_empty() {
        parts.push(format!("without {}", omissions.join(", ")));
    }
    parts.join("; ")
}

/// Vertices of a square.
const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\n";

fn utf16(text: &str, little: bool, mark: bool) -> Vec<u8> {
    let mark = if mark { "\u{feff}" } else { "" };
    let units = mark.encode_utf16().chain(text.encode_utf16());
    units.flat_map(|u| if little { u.to_le_bytes() } else { u.to_be_bytes() }).collect()
}

#[test]
fn obj_texts_of_all_kinds_give_the_expected_triangles() {
    let whole = format!("{SQUARE}f 1 2 3 4\n");
    let square = |text: &str| format!("{SQUARE}{text}\n").into_bytes();
    let rows: Vec<(&str, Vec<u8>, &str)> = vec![
        ("plain", whole.clone().into(), "default: 2"),
        ("byte-order mark", format!("\u{feff}{whole}").into(), "default: 2"),
        ("UTF-16, little", utf16(&whole, true, true), "default: 2"),
        ("UTF-16, big", utf16(&whole, false, true), "default: 2"),
        ("UTF-16 without a mark, little", utf16(&whole, true, false), "default: 2"),
        ("UTF-16 without a mark, big", utf16(&whole, false, false), "default: 2"),
        (
            "UTF-32",
            [0xff, 0xfe, 0, 0, b'v', 0, 0, 0].into(),
            "error: not a valid OBJ file: its text is UTF-32, which is not read; save it as UTF-8; \
             export it again or check that it is complete",
        ),
        ("CR", whole.replace('\n', "\r").into(), "default: 2"),
        ("CR LF", whole.replace('\n', "\r\n").into(), "default: 2"),
        ("both kinds", whole.replacen('\n', "\r", 2).replacen('\n', "\r\n", 1).into(), "default: 2"),
        ("no end of line", whole.trim_end().into(), "default: 2"),
        ("NUL bytes at the end", format!("{whole}\0\0\0").into(), "default: 2"),
        ("NUL bytes in a line", whole.replace(" 4\n", " 4\0\0\n").into(), "default: 2"),
        ("tabs and trailing blanks", square("\tf\t1  2 \t3 \t "), "default: 1"),
        ("comment that ends in a backslash", format!("# C:\\models\\\n{whole}").into(), "default: 2"),
        ("comment behind a statement that does", square("f 1 2 3 # \\\nf 1 3 4"), "default: 2"),
        ("comment that begins with a blank", square(" # x\n\t#y\\\nf 1 2 3"), "default: 1"),
        ("comment behind a vertex", square("v 1 2 3 # x\nf 1 2 5#y"), "default: 1"),
        ("comment behind a face", square("f 1 2 3 # 4"), "default: 1"),
        ("comment joined to a face", square("f 1 2 3#c 4"), "default: 1"),
        (
            "comment before the third corner",
            square("f 1 2#c 3"),
            "error: not a valid OBJ file: line 5: a face needs three corners before its comment: \"1 2#c 3\"; \
             export it again or check that it is complete",
        ),
        ("comment behind usemtl", square("usemtl wood # oak\nf 1 2 3"), WOOD),
        ("number sign in a name", square("usemtl wood#2\nf 1 2 3"), WOOD_2),
        ("name in quotes", square("usemtl \"wood\"\nf 1 2 3"), WOOD),
        ("Latin-1 comment", [b"# caf\xe9\n", whole.as_bytes()].concat(), "default: 2"),
        ("continuation", square("f 1 2 \\\n3 4"), "default: 2"),
        ("continuation with trailing blanks", square("f 1 2 \\ \t\n3 4"), "default: 2"),
        ("continuation, CR", square("f 1 2 \\\r3 4"), "default: 2"),
        ("continuations", square("f\\\n 1\\\n 2\\\n 3"), "default: 1"),
        ("continuation into a comment", square("f 1 2 3 \\\n# 4\nf 1 3 4"), "default: 2"),
        ("continuation at the end", square("f 1 2 3 \\"), "default: 1"),
        (
            "upper case",
            square("F 1 2 3\nUSEMTL wood\nf 1 3 4"),
            "wood: 1; default: 1; without 1 materials that no library defines (\"wood\")",
        ),
        ("old face", square("fo 1 2 3"), "default: 1"),
        ("normals only", square("vn 0 1 0\nf 1//1 2//1 3//1"), "default: 1"),
        ("missing parts", square("f 1/ 2// 3/7/"), "default: 1"),
        ("negative", square("f -4 -3 -2\nv 9 9 9\nf -5 -3 -2"), "default: 2"),
        ("with w", "v 0 0 0 1\nv 1 0 0 1\nv 0 0 1 0\nf 1 2 3".into(), "default: 1"),
        ("with colours", "v 0 0 0 1 0 0\nv 1 0 0 .5 0 0\nv 0 0 1 1 1 1\nf 1 2 3".into(), "default: 1"),
        (
            "with w and colours",
            "v 0 0 0 1 1 0 0\nv 1 0 0 1 1 0 0\nv 0 0 1 1 0 0 0\nf 1 2 3".into(),
            "default: 1",
        ),
        ("no number, unused", square("v 1.#IND -1.#QNAN 0\nv -nan(ind) nan NaN\nf 1 2 3"), "default: 1"),
        (
            "no number, used",
            square("v 1.#IND 0 0\nf 1 2 5"),
            "error: vertex 5 of mesh \"unnamed_object\" is NaN or infinite; repair the mesh in the program that made it",
        ),
        ("too large, unused", square("v 1e39 inf -infinity\nf 1 2 3"), "default: 1"),
        ("no number in texture coordinates", square("vt nan 1.#IND\nvt\nvt x\nf 1/1 2/2 3/3"), "default: 1"),
        ("usemtl without a name", square("usemtl\nf 1 2 3"), "default: 1"),
        ("two groups", square("g a b\nf 1 2 3\ng\nf 1 3 4"), "default: 2"),
        (
            "display",
            square(
                "s 1\ns off\nlod 3\nbevel on\nmg 1 2\nc_interp on\nd_interp off\nusemap off\nmaplib m\ntrace_obj x\nf 1 2 3",
            ),
            "default: 1",
        ),
        (
            "lines and points",
            square("f 1 2 3\nl 1 2 3\np 1 2\np 3\nf 1 2"),
            "default: 1; without 1 lines, 2 points, 1 faces with fewer than three corners",
        ),
        (
            "curves",
            square("f 1 2 3\nvp 1 2\ncstype bezier\ndeg 3\ncurv 0 1 1 2 3 4\nparm u 0 1\nend\nbzp 1 2 3 4"),
            "default: 1; without 2 curves and surfaces",
        ),
        (
            "calls",
            square("f 1 2 3\ncall more.obj\ncsh -ls\nshadow_obj low.obj"),
            "default: 1; without 1 files to be inserted (call), 1 commands to be run (csh), 1 objects that cast in place of others (shadow_obj)",
        ),
        (
            "unknown",
            square("f 1 2 3\nmesh 7\na_keyword_that_is_too_long 1"),
            "default: 1; without 2 statements that OBJ does not have",
        ),
        (
            "only curves",
            square("cstype bezier\ndeg 3\ncurv 0 1 1 2 3 4\nsurf 0 1 0 1 1 2 3 4"),
            "error: contains no triangles; it holds only 2 curves and surfaces",
        ),
        (
            "only points",
            square("p 1 2 3 4"),
            "error: contains no triangles; a point cloud casts no shadow: give a file with faces",
        ),
        (
            "only vertices",
            square(""),
            "error: contains no triangles; a point cloud casts no shadow: give a file with faces",
        ),
        ("only lines", square("l 1 2 3"), "error: contains no triangles; it holds only 1 lines"),
        ("only blank", "\n# nothing\n".into(), "error: contains no triangles; check what was exported"),
    ];
    for (name, text, expected) in rows {
        assert_eq!(summary(Folder::new(&text).load()), expected, "{name}");
    }
}

const WOOD: &str = "wood: 1; without 1 materials that no library defines (\"wood\")";
const WOOD_2: &str = "wood#2: 1; without 1 materials that no library defines (\"wood#2\")";

#[test]
fn mtl_texts_of_all_kinds_give_the_expected_materials() {
    let glass = "newmtl glass\nd 0.7\n";
    let used = format!("mtllib a.mtl\n{SQUARE}usemtl glass\nf 1 2 3\n").into_bytes();
    let uses = |name: &str| format!("mtllib a.mtl\n{SQUARE}usemtl {name}\nf 1 2 3\n").into_bytes();
    let is = "glass masked 0.70: 1";
    let rows: Vec<(&str, Vec<u8>, Vec<u8>, &str)> = vec![
        ("plain", used.clone(), glass.into(), is),
        ("byte-order mark", used.clone(), format!("\u{feff}{glass}").into(), is),
        ("UTF-16, little", used.clone(), utf16(glass, true, true), is),
        ("UTF-16, big", used.clone(), utf16(glass, false, true), is),
        (
            "UTF-32",
            used.clone(),
            vec![0xff, 0xfe, 0, 0, b'n', 0, 0, 0],
            "glass: 1; without 1 material libraries (\"a.mtl\")",
        ),
        ("CR", used.clone(), glass.replace('\n', "\r").into(), is),
        ("tabs", used.clone(), "\tnewmtl\tglass \n\t\td\t0.7 \n".into(), is),
        ("comments", used.clone(), "newmtl glass # clear\n# d 0 \\\nd 0.7 # not 0.2\n".into(), is),
        ("comments without blanks", used.clone(), "newmtl glass #clear\nd 0.7#x\n".into(), is),
        ("comment in usemtl", uses("glass # of the window"), glass.into(), is),
        ("upper case", used.clone(), "NEWMTL glass\nD 0.7\nKD 1 0 0\n".into(), is),
        (
            "case of names",
            uses("Glass"),
            glass.into(),
            "Glass: 1; without 1 materials that no library defines (\"Glass\")",
        ),
        ("names with blanks", uses("my glass"), "newmtl my glass\nd 0.7\n".into(), "my glass masked 0.70: 1"),
        ("names in quotes", uses("\"glass\""), glass.into(), is),
        ("d behind Tr", used.clone(), "newmtl glass\nTr 0.9\nd 0.7\n".into(), is),
        ("d before Tr", used.clone(), "newmtl glass\nd 0.7\nTr 0.9\n".into(), is),
        ("Tr alone", used.clone(), "newmtl glass\ntr 0.3\n".into(), is),
        ("halo", used.clone(), "newmtl glass\nd -halo 0.7\n".into(), is),
        ("no number", used.clone(), "newmtl glass\nd 0.7\nd x\nd nan\nd\n".into(), is),
        ("out of range", used.clone(), "newmtl glass\nd 7\n".into(), "glass: 1"),
        (
            "illumination is no mask",
            used.clone(),
            "newmtl glass\nillum 4\nTf 0 0 0\nNi 1.5\n".into(),
            "glass: 1",
        ),
        ("before any material", used.clone(), format!("d 0.1\n{glass}").into(), is),
        ("continuation", used.clone(), "newmtl \\\nglass\nd \\\n 0.7\n".into(), is),
        ("defined twice: the last", used.clone(), format!("newmtl glass\nd 0.2\n{glass}").into(), is),
        (
            "numbers behind a number sign",
            uses("Material #26"),
            "newmtl Material #25\nd 0.2\nnewmtl Material #26\nd 0.7\n".into(),
            "Material #26 masked 0.70: 1",
        ),
        ("Latin-1", uses("X"), b"newmtl X\nd 0.7\nnewmtl X\xe9\nd 0.2\n".into(), "X masked 0.70: 1"),
        (
            "other opacity maps",
            used.clone(),
            "newmtl glass\nmap_Tr a.png\nmap_opacity b.png\n".into(),
            "glass: 1; without 2 opacity maps that are not stated by map_d (map_Tr, map_opacity)",
        ),
        (
            "of a material that is not used",
            used,
            format!("{glass}newmtl other\nmap_Tr a.png\nmap_d no.png\n").into(),
            is,
        ),
        (
            "usemtl before mtllib",
            format!("{SQUARE}usemtl glass\nf 1 2 3\nmtllib a.mtl").into(),
            glass.into(),
            is,
        ),
        (
            "no library",
            format!("{SQUARE}usemtl glass\nf 1 2 3\n").into(),
            glass.into(),
            "glass: 1; without 1 materials that no library defines (\"glass\")",
        ),
        (
            "lost library",
            format!("mtllib no.mtl\n{SQUARE}usemtl glass\nf 1 2 3\n").into(),
            glass.into(),
            "glass: 1; without 1 material libraries (\"no.mtl\")",
        ),
        (
            "material that is not used",
            format!("mtllib a.mtl\n{SQUARE}usemtl none\nusemtl glass\nf 1 2 3\n").into(),
            glass.into(),
            is,
        ),
    ];
    for (name, obj, mtl, expected) in rows {
        assert_eq!(summary(Folder::new(&obj).with("a.mtl", &mtl).load()), expected, "{name}");
    }
}

#[test]
fn control_characters_in_names_are_escaped_in_messages() {
    let obj = format!("mtllib \u{1b}[2J.mtl\n{SQUARE}f 1 2 3 4\n");
    let notes = Folder::new(obj).load().expect("loads").notes;
    let said = format!("{:?} {}", notes.omissions[0].what, notes.warnings.join(" "));
    assert!(notes.omissions[0].to_string().contains(r"\u{1b}[2J.mtl"), "{said}");
    assert!(!said.contains(char::is_control), "{said}");
}

#[test]
fn material_names_are_compared_as_bytes() {
    let start = format!("mtllib a.mtl\n{SQUARE}usemtl ");
    let obj = [start.as_bytes(), b"caf\xe9\nf 1 2 3\nusemtl caf\xe8\nf 1 3 4\n"];
    let folder = Folder::new(obj.concat()).with("a.mtl", b"newmtl caf\xe8\nd 0.7\nnewmtl caf\xe9\n");
    assert_eq!(summary(folder.load()), "caf\u{e8} masked 0.70: 1; caf\u{e9}: 1");
}

#[test]
fn first_library_wins_and_conflicting_definitions_are_warnings() {
    let obj = format!("mtllib a.mtl b.mtl\n{SQUARE}usemtl m\nf 1 2 3\n");
    let folder = Folder::new(obj).with("a.mtl", "newmtl m\nd 0.7\n").with("b.mtl", "newmtl m\nd 0.2\n");
    let scene = folder.load().expect("loads");
    assert_eq!((scene.notes.warnings.len(), summary(Ok(scene))), (0, "m masked 0.70: 1".to_owned()));
    for (second, warnings) in [("d 0.7", 0), ("d 0.2", 1)] {
        let obj = format!("mtllib a.mtl\n{SQUARE}usemtl m\nf 1 2 3\n");
        let folder = Folder::new(obj).with("a.mtl", format!("newmtl m\nd 0.7\nnewmtl m\n{second}\n"));
        assert_eq!(folder.load().expect("loads").notes.warnings.len(), warnings, "{second}");
    }
}

#[test]
fn libraries_are_found_by_the_names_that_programs_write() {
    let rows = [
        ("mtllib a.mtl", "a.mtl"),
        ("mtllib my mat.mtl", "my mat.mtl"),
        ("mtllib \"my mat.mtl\"", "my mat.mtl"),
        ("mtllib my mat.mtl # made here", "my mat.mtl"),
        ("mtllib my mat #2.mtl", "my mat #2.mtl"),
        ("mtllib A.MTL", "a.mtl"),
        ("mtllib MY Mat.mtl", "my mat.mtl"),
        ("mtllib .\\a.mtl", "a.mtl"),
        ("mtllib ./A.mtl", "a.mtl"),
        ("mtllib lost.mtl a.mtl", "a.mtl"),
        ("mtllib lost.mtl my mat.mtl", "my mat.mtl"),
        ("mtllib \"lost\" \"a.mtl\"", "a.mtl"),
        ("mtllib x a.mtl", "a.mtl"),
        ("MTLLIB a.mtl", "a.mtl"),
        ("mtllib caf\u{e9}.mtl", "caf\u{e9}.mtl"),
        ("mtllib CAF\u{c9}.mtl", "caf\u{e9}.mtl"),
    ];
    for (statement, file) in rows {
        let obj = format!("{statement}\n{SQUARE}usemtl m\nf 1 2 3\n");
        let folder = Folder::new(obj).with(file, "newmtl m\nd 0.7\n");
        let found = summary(folder.load());
        let lost = ["lost", "mtllib x"].iter().any(|part| statement.contains(part));
        assert!(found.starts_with("m masked 0.70: 1"), "{statement}: {found}");
        assert_eq!(found.contains("without 1 material libraries"), lost, "{statement}: {found}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn libraries_are_found_by_names_in_latin_1() {
    let obj = [b"mtllib caf\xe9.mtl\n", format!("{SQUARE}usemtl m\nf 1 2 3\n").as_bytes()].concat();
    let mtl = "newmtl m\nd 0.7\n";
    for folder in
        [Folder::new(&obj).with_bytes(b"caf\xe9.mtl", mtl), Folder::new(&obj).with("caf\u{e9}.mtl", mtl)]
    {
        assert_eq!(summary(folder.load()), "m masked 0.70: 1");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn case_insensitive_name_must_match_only_one_file() {
    let folder = Folder::new(format!("mtllib LIB.mtl\n{SQUARE}usemtl m\nf 1 2 3\n"))
        .with("lib.mtl", "newmtl m\nd 0.7\n")
        .with("Lib.mtl", "newmtl m\nd 0.2\n");
    assert_eq!(summary(folder.load()), "m: 1; without 1 material libraries (\"LIB.mtl\")");
    assert_eq!(summary(folder.with("LIB.mtl", "newmtl m\nd 0.6\n").load()), "m masked 0.60: 1");
}

#[test]
fn messages_list_up_to_five_undefined_materials() {
    let uses: String = (0..7).map(|i| format!("usemtl m{i}\nf 1 2 3\n")).collect();
    let found = summary(Folder::new(format!("{SQUARE}{uses}")).load());
    let omitted =
        "without 7 materials that no library defines (\"m0\", \"m1\", \"m2\", \"m3\", \"m4\", \u{2026})";
    assert!(found.ends_with(omitted), "{found}");
    let strict = LoadOptions { strict: true, ..LoadOptions::default() };
    let error = Folder::new(format!("{SQUARE}{uses}")).load_with(&strict).expect_err("strict");
    assert!(error.to_string().contains("7 materials that no library defines"), "{error}");
}

#[test]
fn meshes_and_faces_of_the_file_are_counted() {
    let text = format!("{SQUARE}o a\ng b\nf 1 2 3 4\nf 1 1 1\ng c\nl 1 2\ng b\nf 1 2 3\nf 1 2\n");
    let scene = Folder::new(text).load().expect("loads");
    let read = scene.notes.read;
    assert_eq!((read.meshes, read.nodes, read.faces), (1, 0, 3));
    assert_eq!((scene.stored_triangles(), scene.notes.degenerate_triangles), (3, 1));
}

#[test]
fn face_belongs_to_every_group_of_its_statement() {
    let text = format!("{SQUARE}g trunk tree\nf 1 2 3\ng leaf tree\nf 1 3 4\n");
    let count = |only: &[&str], exclude: &[&str]| {
        Folder::new(&text).load_with(&crate::kit::only(only, exclude)).map_or(0, |s| s.stored_triangles())
    };
    assert_eq!((count(&["tree"], &[]), count(&["leaf"], &[]), count(&["leaf tree"], &[])), (2, 1, 1));
    assert_eq!((count(&[], &["tree"]), count(&[], &["trunk"])), (0, 1));
}

#[test]
fn negative_indices_count_back_from_the_current_line() {
    let scene = Folder::new("v 0 0 0\nv 1 0 0\nv 0 0 1\nf -3 -2 -1\nv 5 0 0\nv 6 0 0\nv 5 0 1\nf -3 -2 -1\n");
    let triangles = world_triangles(&scene.load().expect("loads"));
    assert_eq!(triangles[1], [[5.0, 0.0, 0.0], [6.0, 0.0, 0.0], [5.0, 0.0, 1.0]]);
}
