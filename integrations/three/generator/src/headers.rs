//! Look-up textures as the Rust crate makes them, in figures that `tests/unit/look-up-texture.test.ts`
//! compares with the package's.

use std::path::Path;

use adumbra::gpu::{LookUp, LookUpTexture, Penumbra};
use adumbra::{Bias, Filter, Placement, ShadowFile};

use crate::Generated;

/// The files, below `test_vectors`: every frame, and files of several pages and levels.
const FILES: [&str; 7] = [
    "valid/cliff_depths",
    "valid/levels_depths",
    "valid/low_sun_tall_depths",
    "valid/many_pages_depths",
    "valid/odd_sizes_depths",
    "valid/slopes_depths",
    "valid/upright_turned_low_depths",
];

/// Returns a JSON object. For each file, and within it for each level, it has the size of the texture; the
/// CRC-32 of all bytes; and the first 128 words: with the file's own bias and a filter of 5, as in the
/// CRC-32; with another bias and a filter of 9; with penumbrae; and placed.
///
/// # Errors
/// Returns the crate's message if a file cannot be read or looked up.
pub fn golden(vectors: &Path) -> Result<Generated, String> {
    let rows: Result<Vec<String>, String> = FILES.iter().map(|name| file(vectors, name)).collect();
    Ok(Generated {
        name: "look_up_texture.json".to_owned(),
        text: format!("{{\n{}\n}}\n", rows?.join(",\n")),
    })
}

fn file(vectors: &Path, name: &str) -> Result<String, String> {
    let name = format!("{name}.adumbra");
    let file = ShadowFile::read(vectors.join(&name)).map_err(|e| e.to_string())?;
    let levels: Result<Vec<String>, String> =
        (0..file.level_count()).filter_map(|n| file.level(n)).map(|file| level(&file)).collect();
    Ok(format!("\"{name}\": [{}]", levels?.join(",\n")))
}

fn level(file: &ShadowFile) -> Result<String, String> {
    let own = LookUp::default();
    let bias = Bias { constant_texels: 0.7, slope_texels: 1.3, normal_offset_texels: 0.1 };
    let other = LookUp { filter: Filter::Box9, bias: Some(bias), ..LookUp::default() };
    let soft = LookUp { penumbra: Some(Penumbra { sun_degrees: 0.53, max_radius_texels: 20.5 }), ..other };
    let texture = file.gpu().texture(&own, 4096).map_err(|e| e.to_string())?;
    let (width, height) = (texture.width(), texture.height());
    let checksum = crc32fast::hash(texture.bytes());
    let mut headers = vec![words(&texture)];
    let turned =
        [[0.0, 0.0, -0.5, 0.0], [0.0, 0.5, 0.0, 0.0], [0.5, 0.0, 0.0, 0.0], [12.5, -3.0, 40.25, 1.0]];
    let tilted = [[4.8, 6.4, 0.0, 0.0], [-6.4, 4.8, 0.0, 0.0], [0.0, 0.0, 8.0, 0.0], [-7.0, 0.25, 1e5, 1.0]];
    let placed = |matrix| -> Result<LookUp, String> {
        let placement = Placement::from_matrix(matrix).map_err(|e| e.to_string())?;
        Ok(LookUp { placement, ..own })
    };
    for look_up in [other, soft, placed(turned)?, placed(tilted)?] {
        headers.push(words(&file.gpu().texture(&look_up, 4096).map_err(|e| e.to_string())?));
    }
    let headers = headers.join(",\n");
    Ok(format!("{{\"size\": [{width}, {height}], \"checksum\": {checksum}, \"headers\": [\n{headers}]}}"))
}

fn words(texture: &LookUpTexture) -> String {
    let words = texture.header().as_chunks().0.iter().map(|b| u32::from_le_bytes(*b).to_string());
    format!("[{}]", words.collect::<Vec<_>>().join(","))
}
