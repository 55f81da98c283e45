//! Headers of look-up textures as the Rust crate makes them, which `tests/unit/look-up-texture.test.ts` compares with the
//! package's.

use std::path::Path;

use adumbra::gpu::LookUpTexture;
use adumbra::{Bias, Layout, ShadowFile};

use crate::Generated;

/// The files, below `test_vectors`: every layout, frame and version.
const FILES: [&str; 9] = [
    "valid/cliff_packed",
    "valid/low_sun_tall_depths",
    "valid/odd_sizes",
    "valid/slopes_packed",
    "valid/upright_turned_low",
    "valid/upright_turned_low_packed",
    "valid/upright_turned_low_depths",
    "valid_v1/sphere",
    "valid_v2/sphere",
];

/// Returns a JSON object: for each file the size of its texture, and its 128 words with the file's own bias and a filter
/// of 5; with another bias and a filter of 9; and in the layout depths with penumbrae too.
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
    let mut texture = LookUpTexture::new(&file, file.settings.bias, 5, 4096).map_err(|e| e.to_string())?;
    let mut headers = vec![words(&texture)];
    let bias = Bias { constant_texels: 0.7, slope_texels: 1.3, normal_offset_texels: 0.1 };
    texture.set_parameters(|p| (p.bias, p.filter_width) = (bias, 9));
    headers.push(words(&texture));
    if file.body.layout() == Layout::Depths {
        let mut set = Ok(());
        texture.set_parameters(|p| set = p.set_penumbrae(&file.grid, 0.53, 20.5));
        set.map_err(|e| e.to_string())?;
        headers.push(words(&texture));
    }
    let (width, height) = (texture.width(), texture.height());
    Ok(format!("\"{name}\": {{\"size\": [{width}, {height}], \"headers\": [\n{}]}}", headers.join(",\n")))
}

fn words(texture: &LookUpTexture) -> String {
    let words = texture.header().as_chunks().0.iter().map(|b| u32::from_le_bytes(*b).to_string());
    format!("[{}]", words.collect::<Vec<_>>().join(","))
}
