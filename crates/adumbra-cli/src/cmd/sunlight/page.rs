//! Hours of one design, or of two, on a page that needs no other file.

use std::path::Path;

use adumbra_html::page::{Body, Embedded, Page, Pair, PictureEncoding, Section, Table};
use adumbra_program::exit::Failure;
use adumbra_program::output::png;
use adumbra_sunlight::Grid;
use adumbra_truth::picture::Picture;

use super::picture::{Legend, draw};
use super::traced::Traced;

/// Pictures are scaled down to this width, pixels.
const WIDEST: u32 = 2048;
/// Hours of the table's first column.
const THRESHOLDS: [f64; 7] = [0.0, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0];

/// Returns the page, or `None` without a grid. Both designs have the same grid. `path` is only for errors.
pub(super) fn html(
    path: &Path,
    names: [&str; 2],
    design: &Traced,
    other: Option<&Traced>,
) -> Option<Result<String, Failure>> {
    let (grid, cells) = design.cells()?;
    let other = match other {
        Some(other) => Some((other.cells()?.1, other)),
        None => None,
    };
    Some(page(path, names, (grid, &cells, design), other.as_ref()))
}

fn page(
    path: &Path,
    [name, other_name]: [&str; 2],
    (grid, cells, design): (&Grid, &[Option<f64>], &Traced),
    other: Option<&(Vec<Option<f64>>, &Traced)>,
) -> Result<String, Failure> {
    let most = other.map_or(design.most_hours, |(_, o)| o.most_hours.max(design.most_hours));
    let map =
        |cells: &[Option<f64>], title: &str, legend| embed(path, &draw(cells, grid.size, title, legend));
    let own = map(cells, name, Legend::Hours(most))?;
    let when = design.when();
    let place = design.day.location;
    let mut opening = Body::default();
    opening.paragraph(&format!(
        "{when}, at {}° north, {}° east. The sun is above the horizon for {:.2} hours. Cells are {} wide in the unit of the scene; north is up.",
        place.latitude_degrees(),
        place.longitude_degrees(),
        design.most_hours,
        grid.spacing_world
    ));
    let mut maps = Body::default();
    let mut sections = Vec::new();
    let mut table = Table::new("", &["hours of sun", name]);
    if let Some((other_cells, traced)) = other {
        let theirs = map(other_cells, other_name, Legend::Hours(most))?;
        maps.pair(&Pair { left: (&own, name), right: (&theirs, other_name), caption: "Hours of direct sun" });
        let differences: Vec<Option<f64>> =
            cells.iter().zip(other_cells).map(|(a, b)| Some((*b)? - (*a)?)).collect();
        let largest = differences.iter().flatten().fold(0.0_f64, |most, hours| most.max(hours.abs()));
        let title = format!("{other_name} less {name}");
        let picture = map(&differences, &title, Legend::Difference(largest.max(0.1)))?;
        let mut body = Body::default();
        body.picture(&picture, &title, &format!("Red: more sun with {other_name}. Blue: less."));
        sections.push(Section { id: "difference".to_owned(), title: "Difference".to_owned(), body });
        table = Table::new("", &["hours of sun", name, other_name, "change"]);
        let [ours, theirs] = [design, *traced].map(|t| t.spread()[0]);
        table.row(["mean".to_owned(), hours(ours), hours(theirs), format!("{:+.2} h", theirs - ours)]);
    } else {
        maps.picture(&own, "Map of the hours of direct sun", "Hours of direct sun");
        table.row(["mean".to_owned(), hours(design.spread()[0])]);
    }
    for least in THRESHOLDS.into_iter().filter(|least| *least <= most) {
        let shares: Vec<f64> = [Some(cells), other.map(|(cells, _)| &**cells)]
            .into_iter()
            .flatten()
            .map(|c| share(c, least))
            .collect();
        let label = if least == 0.0 { "none".to_owned() } else { format!("at least {least:.0} h") };
        let change = (shares.len() == 2).then(|| format!("{:+.2} points", shares[1] - shares[0]));
        let cells = shares.iter().map(|share| format!("{share:.2} %"));
        table.row([label].into_iter().chain(cells).chain(change));
    }
    let mut shares = Body::default();
    shares.paragraph("Share of the cells, which are all surfaces that the sky sees from above.");
    shares.table(&table);
    sections.insert(0, Section { id: "maps".to_owned(), title: "Maps".to_owned(), body: maps });
    sections.push(Section { id: "shares".to_owned(), title: "Shares".to_owned(), body: shares });
    let page = Page {
        title: format!("Hours of sun, {}", design.day.date),
        description: format!("Hours of direct sun, {when}"),
        opening,
        sections,
    };
    Ok(page.html())
}

fn hours(hours: f64) -> String {
    format!("{hours:.2} h")
}

/// Percent of the cells that have at least this many hours. For 0 hours, percent of the cells that have none.
fn share(cells: &[Option<f64>], least: f64) -> f64 {
    let there: Vec<f64> = cells.iter().flatten().copied().collect();
    let counts = |hours: &&f64| if least == 0.0 { **hours == 0.0 } else { **hours >= least };
    100.0 * there.iter().filter(counts).count() as f64 / there.len().max(1) as f64
}

fn embed(path: &Path, picture: &Picture) -> Result<Embedded, Failure> {
    Embedded::from_png(&png(path, picture)?, None, WIDEST, PictureEncoding::Lossless)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn share_ignores_empty_cells() {
        let cells = [Some(0.0), Some(2.0), None, Some(5.0), Some(1.0)];
        assert_eq!([0.0, 1.0, 2.0, 6.0].map(|least| share(&cells, least)), [25.0, 75.0, 50.0, 0.0]);
    }
}
