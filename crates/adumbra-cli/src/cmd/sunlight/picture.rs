//! A grid of hours as a picture with a legend. North is up.

use adumbra_program::text;
use adumbra_truth::picture::Picture;

use crate::cmd::scale::{color, difference_color};

/// Pixels that the longer side of a map has at least, if a cell is not larger than [`LARGEST_CELL`].
const LONGEST_SIDE: u32 = 1024;
/// Most pixels along each side of a cell.
const LARGEST_CELL: u32 = 64;
const PAPER: [u8; 3] = [248, 248, 246];
const INK: [u8; 3] = [24, 24, 28];
/// The colour of cells below which there is nothing.
const NOTHING: [u8; 3] = [205, 205, 202];
const MARGIN: u32 = 16;
/// Scale of the letters.
const LETTERS: u32 = 2;
/// Height of the legend's bar, pixels.
const BAR: u32 = 18;
/// Width of the legend, pixels.
const LEGEND_WIDTH: u32 = 640;

/// The meaning of the colours.
#[derive(Clone, Copy)]
pub(super) enum Legend {
    /// Hours, from 0 to this.
    Hours(f64),
    /// More or fewer hours, up to this.
    Difference(f64),
}

impl Legend {
    fn color(self, hours: f64) -> [u8; 3] {
        match self {
            Self::Hours(most) => color(hours / most.max(f64::MIN_POSITIVE)),
            Self::Difference(most) => difference_color(hours / most.max(f64::MIN_POSITIVE)),
        }
    }

    /// The least and the most.
    fn range(self) -> [f64; 2] {
        match self {
            Self::Hours(most) => [0.0, most],
            Self::Difference(most) => [-most, most],
        }
    }
}

/// Draws the cells of a grid, row by row from the north, below a title and above a legend.
pub(super) fn draw(cells: &[Option<f64>], [columns, rows]: [u32; 2], title: &str, legend: Legend) -> Picture {
    let side = (LONGEST_SIDE / columns.max(rows)).clamp(1, LARGEST_CELL);
    let line = text::height(LETTERS) + 8;
    let map = [columns * side, rows * side];
    let width = map[0].max(LEGEND_WIDTH) + 2 * MARGIN;
    let top = MARGIN + line;
    let below = top + map[1] + MARGIN;
    let height = below + BAR + 4 + line + MARGIN;
    let rgb = PAPER.repeat(width as usize * height as usize);
    let mut picture = Picture { width, height, rgb, difference_share: None };
    text::draw(&mut picture, title, [MARGIN, MARGIN], width - 2 * MARGIN, LETTERS, INK);
    for (number, hours) in (0..).zip(cells) {
        let corner = [MARGIN + number % columns * side, top + number / columns * side];
        fill(&mut picture, corner, [side; 2], hours.map_or(NOTHING, |hours| legend.color(hours)));
    }
    let [least, most] = legend.range();
    // Centred, so that the names of a pair of designs do not cover it.
    let left = (width - LEGEND_WIDTH) / 2;
    for x in 0..LEGEND_WIDTH {
        let hours = least + (most - least) * f64::from(x) / f64::from(LEGEND_WIDTH - 1);
        fill(&mut picture, [left + x, below], [1, BAR], legend.color(hours));
    }
    let letter = text::height(LETTERS);
    for (place, hours) in [0.0, 0.5, 1.0].into_iter().zip([least, 0.5 * (least + most), most]) {
        let words = format!("{hours:.1} h");
        let room = (LEGEND_WIDTH - words.len() as u32 * letter) as f64;
        let corner = [left + (place * room) as u32, below + BAR + 4];
        text::draw(&mut picture, &words, corner, LEGEND_WIDTH, LETTERS, INK);
    }
    picture
}

fn fill(picture: &mut Picture, [x, y]: [u32; 2], [width, height]: [u32; 2], color: [u8; 3]) {
    for row in y..y + height {
        let at = (row as usize * picture.width as usize + x as usize) * 3;
        picture.rgb[at..at + width as usize * 3].copy_from_slice(&color.repeat(width as usize));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn picture_has_a_square_for_each_cell_and_a_legend() {
        let cells = [Some(0.0), Some(6.0), None, Some(12.0), Some(3.0), Some(9.0)];
        let picture = draw(&cells, [3, 2], "2026-06-21", Legend::Hours(12.0));
        assert_eq!(picture.rgb.len(), (picture.width * picture.height * 3) as usize);
        let pixel = |x: u32, y: u32| {
            let at = (y * picture.width + x) as usize * 3;
            [picture.rgb[at], picture.rgb[at + 1], picture.rgb[at + 2]]
        };
        let top = MARGIN + text::height(LETTERS) + 8;
        let cell = |column: u32, row: u32| {
            let corners = [0, LARGEST_CELL - 1];
            let [a, b] =
                corners.map(|c| pixel(MARGIN + column * LARGEST_CELL + c, top + row * LARGEST_CELL + c));
            assert_eq!(a, b);
            a
        };
        assert_eq!([cell(0, 0), cell(1, 0), cell(0, 1)], [0.0, 0.5, 1.0].map(color));
        assert_eq!(cell(2, 0), NOTHING);
        let bar = top + 2 * LARGEST_CELL + MARGIN + 1;
        assert_eq!([pixel(MARGIN, bar), pixel(MARGIN + LEGEND_WIDTH - 1, bar)], [color(0.0), color(1.0)]);
        let ink = picture.rgb.chunks(3).filter(|pixel| **pixel == INK).count();
        assert!(ink > 500, "{ink}");
    }

    #[test]
    fn picture_of_large_grids_has_a_pixel_per_cell() {
        let picture = draw(&vec![Some(1.0); 3000], [3000, 1], "", Legend::Hours(2.0));
        assert_eq!(picture.width, 3000 + 2 * MARGIN);
    }
}
