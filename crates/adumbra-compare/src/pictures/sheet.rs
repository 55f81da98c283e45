//! Contact sheets: pictures in a grid, each above its caption.

use adumbra_program::text;
use adumbra_truth::picture::Picture;

const PAPER: [u8; 3] = [248, 248, 246];
const INK: [u8; 3] = [24, 24, 28];
/// Space between pictures, in pixels.
const GAP: u32 = 12;
/// Captions are twice as large if the widest picture has at least this many pixels.
const WIDE: u32 = 560;

/// A picture of a sheet.
pub struct Cell<'a> {
    /// The picture. Wide ones are scaled down by a whole number.
    pub picture: &'a Picture,
    /// Lines of text below it.
    pub caption: Vec<String>,
}

/// Returns a sheet of the cells in rows of `columns` (at least 1), with no picture wider than `widest`
/// pixels.
pub fn sheet(cells: &[Cell<'_>], columns: usize, widest: u32) -> Picture {
    let columns = columns.max(1).min(cells.len().max(1));
    let small: Vec<Picture> = cells.iter().map(|c| smaller(c.picture, widest)).collect();
    let cell_width = small.iter().map(|p| p.width).max().unwrap_or(0);
    let lines = cells.iter().map(|c| c.caption.len()).max().unwrap_or(0) as u32;
    let scale = if cell_width < WIDE { 1 } else { 2 };
    let line = text::height(scale) + 4;
    let cell_height = small.iter().map(|p| p.height).max().unwrap_or(0) + 4 + lines * line;
    let rows = cells.len().div_ceil(columns) as u32;
    let width = columns as u32 * (cell_width + GAP) + GAP;
    let height = rows * (cell_height + GAP) + GAP;
    let rgb = PAPER.repeat(width as usize * height as usize);
    let mut whole = Picture { width, height, rgb, difference_share: None };
    for (number, (cell, picture)) in cells.iter().zip(&small).enumerate() {
        let x = GAP + (number % columns) as u32 * (cell_width + GAP);
        let y = GAP + (number / columns) as u32 * (cell_height + GAP);
        place(&mut whole, picture, [x, y]);
        for (i, words) in (0..).zip(&cell.caption) {
            text::draw(&mut whole, words, [x, y + picture.height + 4 + i * line], cell_width, scale, INK);
        }
    }
    whole
}

fn place(whole: &mut Picture, part: &Picture, [x, y]: [u32; 2]) {
    let width = part.width as usize * 3;
    for (row, line) in part.rgb.chunks_exact(width.max(1)).enumerate() {
        let at = ((y as usize + row) * whole.width as usize + x as usize) * 3;
        whole.rgb[at..at + width].copy_from_slice(line);
    }
}

/// Scales a picture down to at most `widest` pixels of width. Each pixel is the mean of n × n pixels, for the
/// smallest n possible.
fn smaller(picture: &Picture, widest: u32) -> Picture {
    let n = picture.width.div_ceil(widest.max(1)).max(1);
    let [width, height] = [picture.width / n, picture.height / n];
    let mut rgb = Vec::with_capacity(width as usize * height as usize * 3);
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        for c in 0..3 {
            let taps = (0..n).flat_map(|j| (0..n).map(move |i| (x * n + i, y * n + j)));
            let sum: u32 = taps
                .map(|(x, y)| {
                    u32::from(picture.rgb[(y as usize * picture.width as usize + x as usize) * 3 + c])
                })
                .sum();
            rgb.push((sum / (n * n)) as u8);
        }
    }
    Picture { width, height, rgb, difference_share: None }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(width: u32, height: u32, value: u8) -> Picture {
        Picture { width, height, rgb: vec![value; (width * height * 3) as usize], difference_share: None }
    }

    #[test]
    fn sheet_holds_its_pictures_and_captions() {
        let (a, b) = (plain(100, 50, 10), plain(100, 50, 200));
        let cell = |picture, text: &str| Cell { picture, caption: vec![text.to_owned()] };
        let s = sheet(&[cell(&a, "sm"), cell(&b, "voxel \u{3bb}"), cell(&a, "csm")], 2, 200);
        let at = |x: u32, y: u32| s.rgb[((y * s.width + x) * 3) as usize];
        assert_eq!(s.width, 2 * 112 + 12);
        assert_eq!((at(60, 40), at(170, 40)), (10, 200));
        let below = (12..112).filter(|x| (66..76).any(|y| at(*x, y) == INK[0])).count();
        assert!(below > 6, "a caption of {below} columns");
        assert_eq!(s.rgb, sheet(&[cell(&a, "sm"), cell(&b, "voxel ?"), cell(&a, "csm")], 2, 200).rgb);
    }

    #[test]
    fn sheet_makes_large_pictures_smaller() {
        let s = sheet(&[Cell { picture: &plain(1280, 720, 9), caption: Vec::new() }], 1, 640);
        assert_eq!((s.width, s.height), (640 + 24, 360 + 28));
    }

    #[test]
    fn sheet_cuts_captions_to_the_picture() {
        let picture = plain(40, 10, 0);
        let long = sheet(&[Cell { picture: &picture, caption: vec!["MMMMMMMMMM".to_owned()] }], 1, 64);
        let short = sheet(&[Cell { picture: &picture, caption: vec!["MMMMM".to_owned()] }], 1, 64);
        assert_eq!(long.rgb, short.rgb);
    }
}
