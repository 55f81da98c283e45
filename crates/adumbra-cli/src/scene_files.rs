//! The files that a scene names: buffers, images, material libraries and their textures. Only paths are looked for; what cannot be read names
//! nothing, and what is named need not exist.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use percent_encoding::percent_decode_str;
use serde_json::Value;

/// Bytes before the JSON of a GLB file: its header, and the length and kind of its first chunk.
const GLB_JSON_AT: usize = 20;

/// Paths that a scene names, as they are found beside it.
pub(crate) fn named_by(scene: &Path) -> Vec<PathBuf> {
    let ending = scene.extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
    let names = match ending.as_str() {
        "gltf" | "glb" => gltf_names(scene).unwrap_or_default(),
        "obj" => {
            let libraries = names_after(scene, |word| word == "mtllib");
            let textures = libraries.iter().flat_map(|name| {
                let library = beside(scene, name);
                names_after(&library, |word| {
                    word.starts_with("map_") || ["bump", "disp", "decal", "refl", "norm"].contains(&word)
                })
            });
            let textures: Vec<_> = textures.collect();
            [libraries, textures].concat()
        }
        _ => Vec::new(),
    };
    names.iter().map(|name| beside(scene, name)).collect()
}

fn beside(scene: &Path, name: &str) -> PathBuf {
    scene.with_file_name("").join(name.replace('\\', "/"))
}

/// A file for reading; none where it is a folder, a device or a pipe.
fn regular(path: &Path) -> Option<File> {
    std::fs::metadata(path).ok()?.is_file().then(|| File::open(path).ok())?
}

fn gltf_names(scene: &Path) -> Option<Vec<String>> {
    let mut file = regular(scene)?;
    let mut json = Vec::new();
    (&mut file).take(GLB_JSON_AT as u64).read_to_end(&mut json).ok()?;
    if json.starts_with(b"glTF") {
        let length = u32::from_le_bytes(json.get(12..16)?.try_into().ok()?);
        json.clear();
        file.take(length.into()).read_to_end(&mut json).ok()?;
    } else {
        file.read_to_end(&mut json).ok()?;
    }
    let root: Value = serde_json::from_slice(&json).ok()?;
    let lists = [&root["buffers"], &root["images"]];
    let uris =
        lists.into_iter().filter_map(Value::as_array).flatten().filter_map(|entry| entry["uri"].as_str());
    let files = uris.filter(|uri| !uri.starts_with("data:"));
    Some(files.map(|uri| percent_decode_str(uri).decode_utf8_lossy().into_owned()).collect())
}

/// What lines name that begin with such a word: the rest of the line, for names with spaces, and each of its words, which may be one of
/// several names or follow options.
fn names_after(path: &Path, is_keyword: impl Fn(&str) -> bool) -> Vec<String> {
    let Some(file) = regular(path) else { return Vec::new() };
    let mut names = Vec::new();
    for line in BufReader::new(file).split(b'\n').map_while(Result::ok) {
        let line = String::from_utf8_lossy(&line);
        let Some((word, rest)) = line.trim().split_once(char::is_whitespace) else { continue };
        if is_keyword(word.to_lowercase().as_str()) {
            names.push(rest.trim().to_owned());
            names.extend(rest.split_whitespace().map(str::to_owned));
        }
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_name_their_buffers_images_libraries_and_textures() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let json = r#"{"buffers":[{"uri":"a%20b.bin"},{"uri":"data:,x"},{}],"images":[{"uri":"tex/c.png"}]}"#;
        std::fs::write(at("s.gltf"), json).unwrap();
        assert_eq!(named_by(&at("s.gltf")), [at("a b.bin"), at("tex/c.png")]);
        let glb = [
            &b"glTF\x02\0\0\0\0\0\0\0"[..],
            &(json.len() as u32).to_le_bytes(),
            b"JSON",
            json.as_bytes(),
            b"rest",
        ];
        std::fs::write(at("s.glb"), glb.concat()).unwrap();
        assert_eq!(named_by(&at("s.glb")), named_by(&at("s.gltf")));
        std::fs::write(at("s.obj"), "v 0 0 0\nmtllib my lib.mtl\nusemtl a\n").unwrap();
        std::fs::write(at("my lib.mtl"), "newmtl a\n\tmap_Kd -clamp on tex\\wood.png\n").unwrap();
        let named = named_by(&at("s.obj"));
        assert!(named.contains(&at("my lib.mtl")) && named.contains(&at("tex/wood.png")), "{named:?}");
        for name in ["s.ply", "missing.gltf", "missing.obj"] {
            assert!(named_by(&at(name)).is_empty(), "{name}");
        }
        std::fs::write(at("broken.gltf"), "{").unwrap();
        assert!(named_by(&at("broken.gltf")).is_empty());
    }
}
