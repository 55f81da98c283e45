// Prints the header of the look-up texture of files, as the Rust crate makes it: one JSON object with the 128 words of
// each. `look-up-texture.test.ts` compares. To make `look_up_texture.json` again, in the repository's root after
// `cargo build --release`:
//
//     rustc --edition 2024 -O -L target/release/deps --extern adumbra=target/release/deps/libadumbra-….rlib \
//         integrations/three/tests/golden/look_up_texture.rs -o /tmp/look_up_texture
//     /tmp/look_up_texture test_vectors/valid/{cliff_packed,low_sun_tall_depths,odd_sizes,slopes_packed}.adumbra \
//         test_vectors/valid/upright_turned_low{,_packed,_depths}.adumbra test_vectors/valid_v{1,2}/sphere.adumbra \
//         > integrations/three/tests/golden/look_up_texture.json

use adumbra::gpu::LookUpTexture;
use adumbra::{Bias, Layout, ShadowFile};

fn main() {
    let bias = Bias { constant_texels: 0.7, slope_texels: 1.3, normal_offset_texels: 0.1 };
    let rows: Vec<String> = std::env::args()
        .skip(1)
        .map(|path| {
            let file = ShadowFile::read(&path).unwrap();
            let mut texture = LookUpTexture::new(&file, file.settings.bias, 5, 4096).unwrap();
            let mut headers = vec![words(&texture)];
            texture.set_parameters(|p| (p.bias, p.filter_width) = (bias, 9));
            headers.push(words(&texture));
            if file.body.layout() == Layout::Depths {
                texture.set_parameters(|p| p.set_penumbrae(&file.grid, 0.53, 20.5).unwrap());
                headers.push(words(&texture));
            }
            let name = path.split("test_vectors/").last().unwrap();
            let size = (texture.width(), texture.height());
            format!("\"{name}\": {{\"size\": [{}, {}], \"headers\": [\n{}]}}", size.0, size.1, headers.join(",\n"))
        })
        .collect();
    println!("{{\n{}\n}}", rows.join(",\n"));
}

fn words(texture: &LookUpTexture) -> String {
    let words = texture.header().as_chunks().0.iter().map(|b| u32::from_le_bytes(*b).to_string());
    format!("[{}]", words.collect::<Vec<_>>().join(","))
}
