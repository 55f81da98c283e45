//! Plots as SVG: panels with lines over numbers or bars over names.

use std::ops::Range;
use std::path::Path;

use adumbra_program::exit::Failure;
use adumbra_program::output::write_whole;
use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

/// One line, or the bars of one colour.
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// x and y of each point. For bars, x is the index of the name.
    pub points: Vec<(f64, f64)>,
}

/// The x axis of a panel.
pub enum Along {
    /// Numbers, with points joined by lines. Holds the axis label.
    Numbers(&'static str),
    /// Binary logarithms of the numbers in the tick labels, with points joined by lines. Holds the axis
    /// label.
    Powers(&'static str),
    /// Names, with bars.
    Names(Vec<String>),
}

/// The position of a panel's legend.
#[derive(Clone, Copy)]
pub enum Legend {
    /// Top right.
    UpperRight,
    /// Bottom left.
    LowerLeft,
}

/// One diagram.
pub struct Panel {
    /// Title above the panel.
    pub title: String,
    /// The x axis.
    pub along: Along,
    /// Label of the y axis.
    pub y_label: &'static str,
    /// Whether y is logarithmic.
    pub logarithmic: bool,
    /// Position of the legend.
    pub legend: Legend,
    /// Lines or bars.
    pub series: Vec<Series>,
}

/// Largest number of tick labels along an axis of numbers.
const MAX_LABELS: usize = 12;
const PANEL_PIXELS: (u32, u32) = (440, 300);
const COLORS: [RGBColor; 6] = [
    RGBColor(31, 96, 170),
    RGBColor(214, 96, 28),
    RGBColor(40, 140, 70),
    RGBColor(150, 60, 150),
    RGBColor(120, 110, 20),
    RGBColor(90, 90, 90),
];

/// Writes an SVG of panels, two per row.
///
/// # Errors
///
/// Returns an error if the panels cannot be drawn or the file cannot be written.
pub fn write_svg(path: &Path, panels: &[Panel]) -> Result<(), Failure> {
    write_whole(path, draw_svg(path, panels)?.as_bytes())
}

/// Returns the text of an SVG of panels, two per row. `path` is for error messages only.
///
/// # Errors
///
/// Returns an error if the panels cannot be drawn.
pub fn draw_svg(path: &Path, panels: &[Panel]) -> Result<String, Failure> {
    let columns = panels.len().clamp(1, 2);
    let rows = panels.len().div_ceil(columns).max(1);
    let size = (PANEL_PIXELS.0 * columns as u32, PANEL_PIXELS.1 * rows as u32);
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
        let refused = |e: &dyn std::fmt::Display| {
            Failure::BadInput(format!("{}: cannot draw the plot: {e}", path.display()))
        };
        root.fill(&WHITE).map_err(|e| refused(&e))?;
        for (area, panel) in root.split_evenly((rows, columns)).iter().zip(panels) {
            let y = y_range(panel);
            let drawn = if panel.logarithmic {
                draw(area, panel, y.log_scale(), 1e-9)
            } else {
                draw(area, panel, y, 0.0)
            };
            drawn.map_err(|e| refused(&e))?;
        }
        root.present().map_err(|e| refused(&e))?;
    }
    Ok(text)
}

fn y_range(panel: &Panel) -> Range<f64> {
    let values = || panel.series.iter().flat_map(|s| s.points.iter().map(|p| p.1)).filter(|y| y.is_finite());
    let high = values().fold(f64::MIN_POSITIVE, f64::max);
    if panel.logarithmic {
        let low = values().filter(|y| *y > 0.0).fold(high, f64::min);
        // Room for the legend.
        let room = (high / low).powf(0.5);
        match panel.legend {
            Legend::UpperRight => low / 1.5..high * room.max(1.8),
            Legend::LowerLeft => low / room.max(1.5)..high * 1.8,
        }
    } else {
        // Room for the legend.
        let room = if matches!(panel.along, Along::Names(_)) { 1.5 } else { 1.3 };
        0.0..high * room
    }
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

fn draw<'a, Y>(
    area: &Area<'a>,
    panel: &Panel,
    y: Y,
    floor: f64,
) -> Result<(), Box<dyn std::error::Error + 'a>>
where
    Y: AsRangedCoord<Value = f64>,
    Y::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let xs = || panel.series.iter().flat_map(|s| s.points.iter().map(|p| p.0));
    let (low, high) = (xs().fold(f64::INFINITY, f64::min), xs().fold(f64::NEG_INFINITY, f64::max));
    let names = match &panel.along {
        Along::Numbers(_) | Along::Powers(_) => None,
        Along::Names(names) => Some(names),
    };
    let x = if names.is_some() { low - 0.6..high + 0.6 } else { low - 0.2..high + 0.2 };
    let mut chart = ChartBuilder::on(area)
        .caption(&panel.title, ("sans-serif", 15))
        .margin(8)
        .x_label_area_size(38)
        .y_label_area_size(62)
        .build_cartesian_2d(x, y)?;
    let label = |x: &f64| match names {
        Some(names) => {
            let whole = (x - x.round()).abs() < 0.01 && *x >= 0.0;
            names.get(x.round() as usize).filter(|_| whole).cloned().unwrap_or_default()
        }
        None if matches!(panel.along, Along::Powers(_)) => short(x.exp2()),
        None => format!("{x:.0}"),
    };
    let labels = if names.is_some() {
        2 * (high - low) as usize + 3
    } else {
        ((high - low) as usize + 1).min(MAX_LABELS)
    };
    chart
        .configure_mesh()
        .light_line_style(WHITE.mix(0.0))
        .x_labels(labels)
        .x_label_formatter(&label)
        .y_label_formatter(&|y| short(*y))
        .x_desc(match &panel.along {
            Along::Numbers(what) | Along::Powers(what) => *what,
            Along::Names(_) => "",
        })
        .y_desc(panel.y_label)
        .label_style(("sans-serif", 11))
        .draw()?;
    draw_series(&mut chart, panel, floor)?;
    chart
        .configure_series_labels()
        .position(match panel.legend {
            Legend::UpperRight => SeriesLabelPosition::UpperRight,
            Legend::LowerLeft => SeriesLabelPosition::LowerLeft,
        })
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.2))
        .label_font(("sans-serif", 11))
        .draw()?;
    Ok(())
}

/// Draws the lines or bars of a panel with values above `floor`.
fn draw_series<'a, Y>(
    chart: &mut ChartContext<'a, SVGBackend<'a>, Cartesian2d<RangedCoordf64, Y>>,
    panel: &Panel,
    floor: f64,
) -> Result<(), Box<dyn std::error::Error + 'a>>
where
    Y: Ranged<ValueType = f64>,
{
    let has_bars = matches!(panel.along, Along::Names(_));
    let width = 0.8 / panel.series.len() as f64;
    for (i, series) in panel.series.iter().enumerate() {
        let color = COLORS[i % COLORS.len()];
        let points: Vec<_> =
            series.points.iter().copied().filter(|p| p.1.is_finite() && p.1 > floor).collect();
        let drawn = if has_bars {
            let left = |x: f64| x - 0.4 + width * i as f64;
            chart.draw_series(points.iter().map(|&(x, y)| {
                Rectangle::new([(left(x), floor), (left(x) + width * 0.92, y)], color.filled())
            }))?
        } else {
            chart.draw_series(points.iter().map(|&p| Circle::new(p, 3, color.filled())))?;
            chart.draw_series(LineSeries::new(points, color.stroke_width(2)))?
        };
        drawn
            .label(&series.name)
            .legend(move |(x, y)| Rectangle::new([(x, y - 4), (x + 12, y + 4)], color.filled()));
    }
    Ok(())
}

/// Formats a number briefly: 1,234,567 as "1.2M", 12,345,678 as "12M", 0.00123 as "1.2e-3".
fn short(y: f64) -> String {
    let (scaled, unit) = match y.abs() {
        a if a >= 1e9 => (y / 1e9, "G"),
        a if a >= 1e6 => (y / 1e6, "M"),
        a if a >= 1e3 => (y / 1e3, "k"),
        a if a >= 0.01 || a == 0.0 => (y, ""),
        _ => return format!("{y:.1e}"),
    };
    let decimals =
        if scaled.abs() < 1.0 { 2 } else { usize::from(scaled.abs() < 10.0 && scaled.fract() != 0.0) };
    format!("{scaled:.decimals$}{unit}")
}
