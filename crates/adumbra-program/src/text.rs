//! Captions in pictures, in a bitmap font of 8 × 8 pixels, scaled by whole numbers. Characters beyond ASCII
//! are drawn as '?'.

use adumbra_truth::picture::Picture;
use font8x8::legacy::BASIC_LEGACY;

/// Edge of a character, pixels.
const SIDE: u32 = 8;

/// Returns the height of a line in pixels.
pub fn height(scale: u32) -> u32 {
    SIDE * scale
}

/// Draws `text` with its top left corner at `x`, `y`. Characters that do not fit into `width` pixels are
/// omitted.
pub fn draw(picture: &mut Picture, text: &str, [x, y]: [u32; 2], width: u32, scale: u32, color: [u8; 3]) {
    let fitting = (width / (SIDE * scale)) as usize;
    for (column, character) in (0_u32..).zip(text.chars().take(fitting)) {
        let glyph = BASIC_LEGACY.get(character as usize).unwrap_or(&BASIC_LEGACY['?' as usize]);
        for (row, bits) in (0_u32..).zip(glyph) {
            for bit in (0..SIDE).filter(|bit| bits >> bit & 1 == 1) {
                let corner = [x + (column * SIDE + bit) * scale, y + row * scale];
                fill(picture, corner, scale, color);
            }
        }
    }
}

fn fill(picture: &mut Picture, [x, y]: [u32; 2], side: u32, color: [u8; 3]) {
    for row in y..(y + side).min(picture.height) {
        for column in x..(x + side).min(picture.width) {
            let at = (row as usize * picture.width as usize + column as usize) * 3;
            picture.rgb[at..at + 3].copy_from_slice(&color);
        }
    }
}
