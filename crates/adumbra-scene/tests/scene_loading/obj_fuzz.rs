//! Random OBJ and MTL files, and damaged ones: a load never panics, gives a valid scene or an error, and uses
//! no more memory than a multiple of the size of its files.
//!
//! `ADUMBRA_FUZZ_SECONDS=600` runs for that many seconds. Each file depends only on its seed.

use std::time::Instant;

use adumbra_scene::random::Random;
use adumbra_scene::{Error, LoadOptions, Result, Scene};
use adumbra_testing::fuzz_time;

use crate::kit::png;
use crate::obj::Folder;

/// Files of the quick test.
const SEEDS: u64 = 4000;
/// The memory that a load may hold, in multiples of the bytes of its files.
const MULTIPLE: u64 = 64;
/// Additional memory that a load may hold, bytes.
const BASE: u64 = 1 << 16;

struct Writer {
    random: Random,
    out: Vec<u8>,
}

impl Writer {
    fn below(&mut self, count: usize) -> usize {
        ((self.random.unit() * count as f64) as usize).min(count - 1)
    }

    fn one<'c>(&mut self, choices: &[&'c str]) -> &'c str {
        choices[self.below(choices.len())]
    }

    fn chance(&mut self, of: usize) -> bool {
        self.below(of) == 0
    }

    fn put(&mut self, text: &str) {
        self.out.extend_from_slice(text.as_bytes());
    }

    fn blank(&mut self) {
        let blank = match self.below(24) {
            0 => "\t",
            1 => "  ",
            2 => " \\\n",
            3 => "\0",
            _ => " ",
        };
        self.put(blank);
    }

    fn end(&mut self) {
        if self.chance(12) {
            let comment = self.one(&[" # x", "#", " #\\", " \\", "\t# C:\\"]);
            self.put(comment);
        }
        let end = match self.below(8) {
            0 => "\r",
            1 => "\r\n",
            _ => "\n",
        };
        self.put(end);
    }

    fn number(&mut self) -> String {
        if self.chance(20) {
            let odd = [
                "nan",
                "-nan(ind)",
                "1.#IND",
                "inf",
                "1e39",
                "1e400",
                "x",
                "",
                "-0",
                "1e-50",
                "#",
                "999999999999",
            ];
            return self.one(&odd).to_owned();
        }
        format!("{}", (self.random.unit() * 16.0).floor() - 4.0)
    }

    fn index(&mut self) -> String {
        if self.chance(300) {
            let odd = ["0", "-99", "99", "9223372036854775807", "-9223372036854775808", "1.5", "", "+1"];
            return self.one(&odd).to_owned();
        }
        format!("{}", self.below(8) + 1)
    }

    fn corner(&mut self) -> String {
        let v = self.index();
        match self.below(6) {
            0 | 1 => v,
            2 => format!("{v}//{}", self.index()),
            3 => format!("{v}/{}/{}", self.index(), self.index()),
            _ => format!("{v}/{}", self.index()),
        }
    }

    /// Returns `a` at least half of the time, so that materials are found.
    fn name(&mut self) -> &'static str {
        if self.chance(2) {
            return "a";
        }
        self.one(&[
            "a",
            "b",
            "a b",
            "\"a\"",
            "caf\u{e9}",
            "a#1",
            "a #1",
            "",
            "#",
            "A",
            "a.mtl",
            "m.png",
            "../a",
            "\\a",
        ])
    }

    fn words(&mut self, keyword: &str, count: usize, word: fn(&mut Self) -> String) {
        self.put(keyword);
        for _ in 0..count {
            self.blank();
            let word = word(self);
            self.put(&word);
        }
        self.end();
    }

    fn named(&mut self, keyword: &str) {
        self.put(keyword);
        self.blank();
        let name = self.name();
        self.put(name);
        self.end();
    }

    fn obj(&mut self, statements: usize) {
        for _ in 0..8 {
            self.words("v", 3, |w| format!("{}", w.below(9)));
        }
        for _ in 0..statements {
            match self.below(24) {
                0..=2 => {
                    let count = if self.chance(10) { self.below(8) } else { 3 };
                    self.words("v", count, Self::number);
                }
                3..=4 => self.words("vt", 2, Self::number),
                5..=14 => {
                    let count = if self.chance(4) { self.below(9) } else { 3 };
                    self.words("f", count, Self::corner);
                }
                15 => self.words("fo", 3, Self::corner),
                16..=17 => self.named("usemtl"),
                18 => self.named("g"),
                19 => self.named("o"),
                20 => self.named("mtllib"),
                21 => self.words("l", 2, Self::corner),
                _ => {
                    let other =
                        ["surf 1", "curv 2", "p 1", "s off", "call x", "\\", "#\\", "zzz", "V 1 2 3", "vn 1"];
                    let other = self.one(&other);
                    self.put(other);
                    self.end();
                }
            }
        }
    }

    fn mtl(&mut self, statements: usize) {
        for _ in 0..statements {
            match self.below(8) {
                0..=1 => self.named("newmtl"),
                2 => self.words("Kd", 3, Self::number),
                3 => self.words("d", 1, Self::number),
                4 => self.words("Tr", 1, Self::number),
                5 => self.put("map_d m.png\n"),
                6 => {
                    let option =
                        ["-s", "-o", "-clamp on", "-imfchan r", "-imfchan z", "-mm", "-t", "-x", "-"];
                    let option = self.one(&option).to_owned();
                    let keyword = self.one(&["map_d", "map_Kd", "map_Tr", "bump"]).to_owned();
                    let count = self.below(4);
                    let values: Vec<String> = (0..count).map(|_| self.number()).collect();
                    let file =
                        self.one(&["m.png", "M.png", "m.png # x", "m.png", "m.png", "m.png", "", "no.png"]);
                    self.put(&format!("{keyword} {option} {} {file}\n", values.join(" ")));
                }
                _ => self.named("map_Kd"),
            }
        }
    }

    /// Changes, removes and repeats bytes, or changes the encoding.
    fn damage(&mut self) {
        for _ in 0..self.below(4) {
            let length = self.out.len().max(1);
            let at = self.below(length).min(self.out.len());
            match self.below(6) {
                0 => self.out.truncate(at),
                1 => {
                    let byte = self.below(256) as u8;
                    self.out.insert(at, byte);
                }
                2 => {
                    let end = (at + self.below(20)).min(self.out.len());
                    let part = self.out[at..end].to_vec();
                    self.out.splice(at..at, part);
                }
                3 if at < self.out.len() => self.out[at] ^= 1 << self.below(8),
                4 => {
                    let mark = [&b"\xef\xbb\xbf"[..], b"\xff\xfe", b"\xfe\xff", b"\0"][self.below(4)];
                    self.out.splice(0..0, mark.iter().copied());
                }
                _ => {
                    if self.chance(4) {
                        let text = String::from_utf8_lossy(&self.out).into_owned();
                        let units = std::iter::once(0xfeff).chain(text.encode_utf16());
                        self.out = units.flat_map(u16::to_le_bytes).collect();
                    }
                }
            }
        }
    }
}

/// The files of a seed, and the options to load them with.
fn case(seed: u64) -> (Vec<u8>, Vec<u8>, LoadOptions) {
    let mut writer = Writer { random: Random::new(seed, 0), out: Vec::new() };
    if !writer.chance(4) {
        writer.put("mtllib a.mtl\n");
    }
    let statements = 1 + writer.below(60);
    writer.obj(statements);
    if writer.chance(2) {
        writer.damage();
    }
    let obj = std::mem::take(&mut writer.out);
    if writer.chance(2) {
        writer.put("newmtl a\nmap_d m.png\n");
    }
    let statements = writer.below(30);
    writer.mtl(statements);
    if writer.chance(2) {
        writer.damage();
    }
    let mtl = std::mem::take(&mut writer.out);
    let options = LoadOptions {
        color_textures: writer.chance(2),
        ignore_alpha: writer.chance(4),
        ..LoadOptions::default()
    };
    (obj, mtl, options)
}

fn check(seed: u64, result: &Result<Scene>) {
    let scene = match result {
        Ok(scene) => scene,
        Err(e) => {
            let text = e.to_string();
            assert!(!text.contains('\n') && text.contains("scene.obj"), "seed {seed}: {text}");
            assert!(!matches!(e, Error::SceneMemory { .. }), "seed {seed}: {text}");
            return;
        }
    };
    for mesh in &scene.meshes {
        let vertices = mesh.positions.len();
        assert!(mesh.uvs.is_empty() || mesh.uvs.len() == vertices, "seed {seed}");
        assert_eq!(mesh.triangles.len(), mesh.triangle_materials.len(), "seed {seed}");
        assert!(mesh.triangles.iter().flatten().all(|&v| (v as usize) < vertices), "seed {seed}");
        assert!(mesh.positions.iter().flatten().chain(mesh.uvs.iter().flatten()).all(|c| c.is_finite()));
        for &m in &mesh.triangle_materials {
            let texture = scene.materials[m as usize].texture;
            assert!(texture.is_none_or(|t| (t as usize) < scene.textures.len()), "seed {seed}");
            assert!(texture.is_none() || !mesh.uvs.is_empty(), "seed {seed}");
        }
    }
    assert!(scene.stored_triangles() > 0, "seed {seed}");
}

#[test]
fn random_obj_files_give_a_scene_or_an_error() {
    let (started, time) = (Instant::now(), fuzz_time());
    let image = png(&[0, 255, 40]);
    let (mut loaded, mut masked, mut seed) = (0_u64, 0_u64, 0_u64);
    while time.map_or(seed < SEEDS, |time| started.elapsed() < time) {
        let (obj, mtl, options) = case(seed);
        let bytes = (obj.len() + mtl.len() + image.len()) as u64;
        let options = LoadOptions { max_memory_bytes: Some(MULTIPLE * bytes + BASE), ..options };
        let folder = Folder::new(&obj).with("a.mtl", &mtl).with("m.png", &image);
        let result = folder.load_with(&options);
        check(seed, &result);
        loaded += u64::from(result.is_ok());
        masked += u64::from(result.is_ok_and(|scene| !scene.textures.is_empty()));
        seed += 1;
    }
    println!("{seed} files: {loaded} loaded, {masked} of them with textures");
    assert!(loaded * 4 > seed && masked * 50 > seed, "{loaded} and {masked} of {seed} files");
}

/// The statements that cost most memory for each byte of a file.
#[test]
fn dense_obj_files_stay_within_the_memory_multiple() {
    let triangle = "v 0 0 0\nv 0 0 1\nv 1 0 0\nvt 0 0\nf 1 2 3\n";
    let repeat = |line: &str| (0..4_000).map(|i| line.replace('@', &format!("{i:x}"))).collect::<String>();
    let library = "mtllib a.mtl\n";
    let rows = [
        ("vertices", repeat("v 0 0 0\n"), String::new()),
        (
            "texture coordinates",
            repeat("vt 0\n") + library + "usemtl a\nf 1/1 2/2 3/3\n",
            "newmtl a\nmap_d m.png\n".into(),
        ),
        ("faces", repeat("f 1 2 3\n"), String::new()),
        (
            "masked faces",
            library.to_owned() + "usemtl a\n" + &repeat("f 1/1 2/1 3/1\n"),
            "newmtl a\nmap_d m.png\n".into(),
        ),
        ("corners", format!("f{}\n", " 1".repeat(40_000)), String::new()),
        ("objects", repeat("o @\n"), String::new()),
        ("objects with faces", repeat("o @\nf 1 2 3\n"), String::new()),
        ("names of materials", repeat("usemtl @\n"), String::new()),
        ("runs", repeat("usemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\n"), String::new()),
        ("materials", library.into(), repeat("newmtl @\n")),
        ("maps", library.into(), repeat("newmtl @\nmap_d @\n")),
        ("libraries", repeat("mtllib @\n"), String::new()),
        ("statements", repeat("p\n"), String::new()),
    ];
    for (name, obj, mtl) in rows {
        let (obj, image) = (format!("{triangle}{obj}"), png(&[0, 255]));
        let bytes = (obj.len() + mtl.len() + image.len()) as u64;
        let options =
            LoadOptions { max_memory_bytes: Some(MULTIPLE * bytes + BASE), ..LoadOptions::default() };
        let folder = Folder::new(obj).with("a.mtl", mtl).with("m.png", image);
        if let Err(e) = folder.load_with(&options) {
            panic!("{name}: {e}");
        }
    }
}
