//! Headers of look-up textures as the Rust crate makes them, which `tests/unit/look-up-texture.test.ts` compares with the
//! package's.

use std::path::Path;

use adumbra::gpu::{LookUp, LookUpTexture, Penumbra};
use adumbra::{Bias, Filter, ShadowFile};

use crate::Generated;

/// The files, below `test_vectors`: every frame and version.
const FILES: [&str; 6] = [
    "valid/cliff_depths",
    "valid/low_sun_tall_depths",
    "valid/odd_sizes_depths",
    "valid/slopes_depths",
    "valid/upright_turned_low_depths",
    "valid_v2/sphere_depths",
];

/// Returns a JSON object: for each file the size of its texture, and its 128 words with the file's own bias and a filter
/// of 5; with another bias and a filter of 9; and with penumbrae.
///
/// # Errors
/// Returns the crate's message if a file cannot be read or looked up.
pub fn golden(vectors: &Path) -> Result<Generated, String> {
    let rows: Result<Vec<String>, String> = FILES.iter().map(|name| row(vectors, name)).collect();
    Ok(Generated {
        name: "look_up_texture.json".to_owned(),
        text: format!("{{\n{}\n}}\n", rows?.join(",\n")),
    })
}

fn row(vectors: &Path, name: &str) -> Result<String, String> {
    let name = format!("{name}.adumbra");
    let file = ShadowFile::read(vectors.join(&name)).map_err(|e| e.to_string())?;
    let own = LookUp::default();
    let bias = Bias { constant_texels: 0.7, slope_texels: 1.3, normal_offset_texels: 0.1 };
    let other = LookUp { filter: Filter::Box9, bias: Some(bias), penumbra: None };
    let soft = LookUp { penumbra: Some(Penumbra { sun_degrees: 0.53, max_radius_texels: 20.5 }), ..other };
    let mut headers = Vec::new();
    let (mut width, mut height) = (0, 0);
    for look_up in [own, other, soft] {
        let texture = file.gpu().texture(&look_up, 4096).map_err(|e| e.to_string())?;
        (width, height) = (texture.width(), texture.height());
        headers.push(words(&texture));
    }
    Ok(format!("\"{name}\": {{\"size\": [{width}, {height}], \"headers\": [\n{}]}}", headers.join(",\n")))
}

fn words(texture: &LookUpTexture) -> String {
    let words = texture.header().as_chunks().0.iter().map(|b| u32::from_le_bytes(*b).to_string());
    format!("[{}]", words.collect::<Vec<_>>().join(","))
}
