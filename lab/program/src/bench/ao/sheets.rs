//! Pictures side by side: every estimator next to the truth, and the parts of the Dragon shown in the paper's
//! figures 3 to 5.

use adumbra_render::occlusion::Estimator;
use adumbra_truth::picture::Picture;

use super::SceneFigures;
use super::measure::Pictures;
use super::variants::{FIG_3, FIG_4, FIG_5, WITHOUT_ATTENUATION, name};
use crate::occlusion::{TracedView, grey_picture};
use adumbra_compare::Result;
use adumbra_compare::pictures::{Cell, enlarged, sheet};

/// Maximum width of a picture on a scene's sheet, in pixels.
const WIDEST: u32 = 320;
/// Magnification of an enlarged part.
const TIMES: u32 = 2;

/// A file's stem, a caption and a sheet.
type Sheet = (String, String, Picture);

/// A part of the Dragon's picture. Corner and size are shares of the picture's width and height.
struct Part {
    file: &'static str,
    caption: &'static str,
    from: [f64; 2],
    size: [f64; 2],
    columns: usize,
    shows: &'static [&'static str],
}

const SIZE: [f64; 2] = [0.2, 0.26];
const PARTS: [Part; 4] = [
    Part {
        file: "ao-figure-3",
        caption: "The paper's figure 3, detail: the Dragon's head with filter. Truth, hbao, issao, and issao with the paper's settings.",
        from: [0.19, 0.14],
        size: SIZE,
        columns: 2,
        shows: &["truth", "hbao", "issao", FIG_3],
    },
    Part {
        file: "ao-figure-4",
        caption: "The paper's figure 4, self-occlusion: issao with and without attenuation, tuned and with the paper's settings.",
        from: [0.28, 0.64],
        size: SIZE,
        columns: 3,
        shows: &["truth", "issao", WITHOUT_ATTENUATION, FIG_4, "preset=fig4:attenuation=off"],
    },
    Part {
        file: "ao-figure-4-ssao",
        caption: "Self-occlusion compared with ssao, with filter and without.",
        from: [0.28, 0.64],
        size: SIZE,
        columns: 3,
        shows: &["truth", "ssao", "issao", "ssao:filter=none", "issao:filter=none"],
    },
    Part {
        file: "ao-figure-5",
        caption: "The paper's figure 5, edges after filtering: truth, alchemy and issao; issao with the paper's settings, and with a Gaussian filter.",
        from: [0.58, 0.50],
        size: SIZE,
        columns: 3,
        shows: &["truth", "alchemy", "issao", FIG_5, "filter=gauss"],
    },
];

/// Returns a scene's sheets.
pub(super) fn all(
    figures: &SceneFigures,
    traced_view: &TracedView,
    pictures: &Pictures,
) -> Result<Vec<Sheet>> {
    let size = [traced_view.surfaces.width, traced_view.surfaces.height];
    let mut shown = vec![("truth", grey_picture(size, &traced_view.truth)?, String::new())];
    for (name, visibility) in pictures {
        let rmse = traced_view.errors(visibility)?.rmse;
        shown.push((name, grey_picture(size, visibility)?, format!("RMSE {rmse:.4}")));
    }
    let find = |name: &str| shown.iter().find(|s| s.0 == name);
    let names = std::iter::once("truth").chain(Estimator::ALL.map(Estimator::name));
    let cells: Vec<Cell<'_>> = names
        .filter_map(find)
        .map(|(name, picture, error)| Cell { picture, caption: vec![(*name).to_owned(), error.clone()] })
        .collect();
    let caption = format!("{}: the truth, and every estimator with its filter.", figures.title);
    let mut sheets = vec![(format!("ao-{}", figures.name), caption, sheet(&cells, 3, WIDEST))];
    if figures.name == "dragon" {
        sheets.extend(PARTS.iter().map(|part| {
            let crops: Vec<(String, &String, Picture)> = part
                .shows
                .iter()
                .filter_map(|show| find(show).or_else(|| find(&name(show))))
                .map(|(name, picture, error)| ((*name).to_owned(), error, part.of(picture)))
                .collect();
            let cells: Vec<Cell<'_>> = crops
                .iter()
                .map(|(name, error, picture)| Cell { picture, caption: vec![name.clone(), (*error).clone()] })
                .collect();
            (part.file.to_owned(), part.caption.to_owned(), sheet(&cells, part.columns, u32::MAX))
        }));
    }
    Ok(sheets)
}

impl Part {
    fn of(&self, picture: &Picture) -> Picture {
        let whole = [picture.width, picture.height];
        let [from, size] =
            [self.from, self.size].map(|shares| [0, 1].map(|a| (shares[a] * f64::from(whole[a])) as u32));
        enlarged(picture, from, size, TIMES)
    }
}
