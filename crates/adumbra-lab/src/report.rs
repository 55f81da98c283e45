//! A comparison's figures, as JSON and as Markdown.
//!
//! The JSON is [`Report`], field by field; `docs/json.md` says what each means.

use std::fmt::Write as _;

use serde::{Deserialize, Serialize};

use crate::metrics::Band;
use crate::shimmer::Shimmer;

/// All figures of one camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// The adapter that drew, with its driver.
    pub adapter: String,
    /// Whether the adapter is a program, not a GPU.
    pub software: bool,
    /// The scene's file name.
    pub scene: String,
    /// Where it was seen from.
    pub camera: CameraFigures,
    /// Unit vector towards the sun.
    pub sun: [f64; 3],
    /// Full angle of the disc that soft techniques are judged by, degrees.
    pub sun_angle_degrees: f64,
    /// Rays a pixel towards that disc.
    pub sun_samples: u32,
    /// Frames that each median is taken of.
    pub frames: u32,
    /// Which pixels were compared.
    pub pixels: PixelCounts,
    /// Baked files that techniques looked up in.
    pub baked: Vec<BakedFigures>,
    /// What the device lacks, and what that costs.
    pub left_out: Vec<String>,
    /// One row a technique, in the order asked for.
    pub techniques: Vec<TechniqueRow>,
    /// Over a camera path, where one was walked.
    pub path: Option<PathReport>,
}

/// A camera, as it was asked for and as it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraFigures {
    /// `given`, `street`, `overview`, or a truth file's name.
    pub name: String,
    /// World position.
    pub eye: [f64; 3],
    /// World point in the middle of the picture.
    pub target: [f64; 3],
    /// Vertical field of view; none for an orthographic camera.
    pub fov_degrees: Option<f64>,
    /// Height of the picture in the world; none for a perspective camera.
    pub height_world: Option<f64>,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
}

/// Pixels by what became of them; they sum up to the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PixelCounts {
    /// Compared.
    pub compared: u64,
    /// No surface there, for G-buffer and rays alike.
    pub sky: u64,
    /// n·l <= 0.1.
    pub facing_away: u64,
    /// G-buffer and rays see different surfaces: their view depths differ by more than 0.1 %.
    pub excluded: u64,
}

/// More excluded pixels than this share of those with a surface mean that what is compared is not what is there.
pub const MOST_EXCLUDED: f64 = 0.01;

impl PixelCounts {
    /// Excluded pixels, as a share of those with a surface; 0 where there is none.
    pub fn excluded_share(&self) -> f64 {
        let surfaces = self.compared + self.facing_away + self.excluded;
        self.excluded as f64 / surfaces.max(1) as f64
    }
}

/// A baked file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BakedFigures {
    /// `light` or `world`.
    pub frame: String,
    /// Voxels on the longest side.
    pub resolution: u64,
    /// Edge of a voxel, world units.
    pub voxel_size: f64,
    /// Bytes as a file.
    pub file_bytes: u64,
}

/// Which truth judged a technique.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TruthKind {
    /// One ray towards the middle of the sun.
    Hard,
    /// A disc of [`Report::sun_angle_degrees`].
    Disc,
}

/// Errors at pixels that lie more than two of the technique's own texels from an edge of the true shadow: acne and leaks, without what a
/// texel's size excuses.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClearErrors {
    /// Share of compared pixels that lie so; of more than 65,536 a sample is asked, here and below.
    pub pixels: f64,
    /// Share of those that are shadowed and called lit.
    pub wrong_lit: f64,
    /// Share of those that are lit and called shadowed.
    pub wrong_shadowed: f64,
}

/// One technique's figures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TechniqueRow {
    /// As it was asked for.
    pub name: String,
    /// Milliseconds of all its passes: depth, look-up, screen; the median. None for traced truth.
    pub gpu_ms: Option<f64>,
    /// Of its depth passes alone.
    pub depth_ms: Option<f64>,
    /// Of its look-up alone.
    pub lookup_ms: Option<f64>,
    /// Of its passes on the screen alone.
    pub screen_ms: Option<f64>,
    /// The times are wall times: the device has no timestamps.
    pub wall_time: bool,
    /// Bytes that it holds on the GPU for its shadows.
    pub bytes: u64,
    /// What judged it.
    pub truth: TruthKind,
    /// Root mean square error of the shadow factor, 0 to 1. This and the next five are none where no pixel was compared.
    pub rmse: Option<f64>,
    /// Mean size of the shadow factor's difference, 0 to 1.
    pub mean_difference: Option<f64>,
    /// Structural similarity of the composited picture; 1 is the same.
    pub ssim: Option<f64>,
    /// Mean FLIP of the composited picture, 0 to 1; 0 is the same.
    pub flip: Option<f64>,
    /// Share of compared pixels that are shadowed and called lit.
    pub wrong_lit: Option<f64>,
    /// Share of compared pixels that are lit and called shadowed.
    pub wrong_shadowed: Option<f64>,
    /// The errors that lie away from edges; none for what compares with no texels, and where no pixel lies so.
    pub clear: Option<ClearErrors>,
    /// The same errors by distance.
    pub bands: Vec<Band>,
    /// What it left out on this device.
    pub notes: Vec<String>,
}

impl TechniqueRow {
    /// Share of compared pixels on the wrong side of 1/2; none where no pixel was compared.
    pub fn wrong(&self) -> Option<f64> {
        Some(self.wrong_lit? + self.wrong_shadowed?)
    }
}

/// Figures over a camera path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PathReport {
    /// Frames walked.
    pub frames: u32,
    /// One a technique.
    pub techniques: Vec<PathRow>,
    /// Each voxel technique beside the first `csm`.
    pub cheaper: Vec<Cheaper>,
}

/// One technique over a path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PathRow {
    /// As it was asked for.
    pub name: String,
    /// Milliseconds of all its passes, a frame each.
    pub gpu_ms: Vec<f64>,
    /// Of its depth passes alone.
    pub depth_ms: Vec<f64>,
    /// Of its look-up and its passes on the screen.
    pub lookup_ms: Vec<f64>,
    /// The times are wall times.
    pub wall_time: bool,
    /// Changes at fixed points; none for a technique that filters on the screen, which answers no points, and where no point stays in
    /// view from one frame to the next.
    pub shimmer: Option<Shimmer>,
}

/// How often a voxel technique costs less than cascades.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cheaper {
    /// The voxel technique.
    pub voxel: String,
    /// The cascades that it stands beside.
    pub csm: String,
    /// Share of the frames.
    pub share: f64,
}

impl Report {
    /// Tables of everything.
    pub fn markdown(&self) -> String {
        let mut text = format!("# Shadows of {} beside the truth\n\n", escaped(&self.scene));
        let c = &self.camera;
        let lens = match (c.fov_degrees, c.height_world) {
            (Some(fov), _) => format!("{fov}° high"),
            (_, Some(height)) => format!("orthographic, {height} high"),
            _ => String::new(),
        };
        let p = &self.pixels;
        // Writing to a String does not fail.
        let _ = writeln!(
            text,
            "Camera {}: eye ({}), target ({}), {lens}, {} x {}. Sun towards ({}). Drawn by {}{}.\n\n\
            {} pixels are compared; {} are sky, {} face away from the sun (n·l <= 0.1), and {} are excluded: \
            G-buffer and rays see different surfaces there.\n",
            escaped(&c.name),
            triple(c.eye),
            triple(c.target),
            c.width,
            c.height,
            triple(self.sun),
            self.adapter,
            if self.software { ", a program and not a GPU" } else { "" },
            p.compared,
            p.sky,
            p.facing_away,
            p.excluded
        );
        for b in &self.baked {
            let _ = writeln!(
                text,
                "Baked: {}-aligned, {} voxels on the longest side, {:.4} each, {:.2} MB.\n",
                b.frame,
                b.resolution,
                b.voxel_size,
                b.file_bytes as f64 / 1e6
            );
        }
        text.push_str(&self.technique_table());
        text.push_str(&self.band_table());
        if let Some(path) = &self.path {
            text.push_str(&path.markdown());
        }
        for (name, note) in self.techniques.iter().flat_map(|t| t.notes.iter().map(move |n| (&t.name, n))) {
            let _ = writeln!(text, "- `{name}`: {note}");
        }
        for note in &self.left_out {
            let _ = writeln!(text, "- {note}");
        }
        text
    }

    /// A row a technique.
    pub fn technique_table(&self) -> String {
        let mut text = format!(
            "Times are medians of {} frames in milliseconds (* wall time: the device has no timestamps, or is a program). Truth is traced from the sun's middle \
            (hard) or from a disc of {}° with {} rays a pixel (disc). RMSE and wrong shares are of the shadow factor, SSIM and FLIP (67 pixels a \
            degree) of the composited picture. Wrong lit: shadowed called lit; wrong shadowed: lit called shadowed. Clear of edges: the same two at \
            pixels more than two of the technique's texels from an edge of the true shadow.\n\n\
            | technique | all ms | depth | look-up | screen | MB | truth | RMSE | SSIM | FLIP | wrong lit % | wrong shadowed % | clear of edges % |\n\
            |---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
            self.frames, self.sun_angle_degrees, self.sun_samples
        );
        for t in &self.techniques {
            let ms = |time: Option<f64>| {
                let star = if t.wall_time { "*" } else { "" };
                time.map_or_else(|| "–".to_owned(), |ms| format!("{ms:.3}{star}"))
            };
            let clear = t.clear.map_or_else(
                || "–".to_owned(),
                |c| format!("{:.3} + {:.3}", 100.0 * c.wrong_lit, 100.0 * c.wrong_shadowed),
            );
            let _ = writeln!(
                text,
                "| `{}` | {} | {} | {} | {} | {:.2} | {} | {} | {} | {} | {} | {} | {clear} |",
                t.name,
                ms(t.gpu_ms),
                ms(t.depth_ms),
                ms(t.lookup_ms),
                ms(t.screen_ms),
                t.bytes as f64 / 1e6,
                match t.truth {
                    TruthKind::Hard => "hard",
                    TruthKind::Disc => "disc",
                },
                figure(t.rmse, 4),
                figure(t.ssim, 4),
                figure(t.flip, 4),
                percent(t.wrong_lit, 3),
                percent(t.wrong_shadowed, 3)
            );
        }
        text + "\n"
    }

    /// Wrong pixels by distance: a row a band, a column a technique.
    pub fn band_table(&self) -> String {
        let mut ends: Vec<(f64, f64)> = Vec::new();
        for band in self.techniques.iter().flat_map(|t| &t.bands) {
            if !ends.contains(&(band.from_world, band.to_world)) {
                ends.push((band.from_world, band.to_world));
            }
        }
        if ends.is_empty() {
            return String::new();
        }
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut text = "## Wrong pixels by distance\n\nIn % of the band's compared pixels, wrong lit + wrong shadowed.\n\n\
            | view depth | pixels |"
            .to_owned();
        self.techniques.iter().for_each(|t| {
            let _ = write!(text, " `{}` |", t.name);
        });
        text.push_str("\n|---|---|");
        text.push_str(&"---|".repeat(self.techniques.len()));
        text.push('\n');
        for (from, to) in ends {
            let of =
                |t: &TechniqueRow| t.bands.iter().find(|b| (b.from_world, b.to_world) == (from, to)).copied();
            let pixels = self.techniques.iter().find_map(of).map_or(0, |b| b.errors.pixels);
            let _ = write!(text, "| {from} to {to} | {pixels} |");
            for t in &self.techniques {
                let cell = of(t).map_or_else(String::new, |b| {
                    format!("{:.3} + {:.3}", 100.0 * b.errors.wrong_lit, 100.0 * b.errors.wrong_shadowed)
                });
                let _ = write!(text, " {cell} |");
            }
            text.push('\n');
        }
        text + "\n"
    }
}

impl PathReport {
    /// A row a technique, and how often voxels are cheaper.
    pub fn markdown(&self) -> String {
        let mut text = format!(
            "## Along a path of {} frames\n\nShimmer: share of points near a true edge whose factor changes by more than 0.05 from one frame to the next, \
            and the mean change there.\n\n| technique | median ms | least | most | shimmer % | mean change |\n|---|---|---|---|---|---|\n",
            self.frames
        );
        for t in &self.techniques {
            let mut sorted = t.gpu_ms.clone();
            sorted.sort_by(f64::total_cmp);
            let at = |i: usize| sorted.get(i).copied().unwrap_or(f64::NAN);
            let shimmer = t.shimmer.map_or_else(
                || "– | –".to_owned(),
                |s| format!("{} | {}", percent(s.edge_share, 3), figure(s.edge_mean, 5)),
            );
            let _ = writeln!(
                text,
                "| `{}` | {:.3} | {:.3} | {:.3} | {shimmer} |",
                t.name,
                at(sorted.len() / 2),
                at(0),
                at(sorted.len().saturating_sub(1))
            );
        }
        text.push('\n');
        for c in &self.cheaper {
            let _ = writeln!(
                text,
                "`{}` is cheaper than `{}` in {:.1} % of the frames.\n",
                c.voxel,
                c.csm,
                100.0 * c.share
            );
        }
        text
    }

    /// One line a frame: its number, then each technique's milliseconds.
    pub fn csv(&self) -> String {
        let names = self.techniques.iter().flat_map(|t| {
            [("all", &t.name), ("depth", &t.name), ("lookup", &t.name)]
                .map(|(what, n)| format!("{n} {what} ms"))
        });
        let mut text = format!("frame,{}\n", names.collect::<Vec<_>>().join(","));
        for frame in 0..self.frames as usize {
            let _ = write!(text, "{frame}");
            for t in &self.techniques {
                for times in [&t.gpu_ms, &t.depth_ms, &t.lookup_ms] {
                    let _ = write!(text, ",{:.4}", times.get(frame).copied().unwrap_or(f64::NAN));
                }
            }
            text.push('\n');
        }
        text
    }
}

/// A name, such as a file's, as Markdown text: nothing of it is markup, and it stays on its line.
pub fn escaped(name: &str) -> String {
    let mut text = String::with_capacity(name.len());
    for c in name.chars() {
        match c {
            '&' => text.push_str("&amp;"),
            '<' => text.push_str("&lt;"),
            '>' => text.push_str("&gt;"),
            '\\' | '`' | '*' | '_' | '[' | ']' | '|' | '#' | '!' | '~' | '$' => text.extend(['\\', c]),
            c if c.is_control() => text.push(' '),
            c => text.push(c),
        }
    }
    text
}

/// A figure with so many digits after the point; a dash where there is none.
pub fn figure(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "–".to_owned(), |v| format!("{v:.digits$}"))
}

/// A share in percent, as [`figure`].
pub fn percent(share: Option<f64>, digits: usize) -> String {
    figure(share.map(|s| 100.0 * s), digits)
}

fn triple(v: [f64; 3]) -> String {
    v.map(|c| format!("{}", (c * 1e4).round() / 1e4)).join(", ")
}

/// The middle one; of an even number the upper. NaN of none.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// A number with its thousands apart: 2400000 as 2,400,000.
pub fn grouped(whole: u64) -> String {
    let digits = whole.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_no_markup() {
        assert_eq!(escaped("box-city-5k.glb"), "box-city-5k.glb");
        let name = "a<b&c`|d\n# e_f.obj";
        let text = escaped(name);
        assert!(!text.contains('\n'), "{text}");
        let mut html = String::new();
        let markdown = format!("# {text}\n");
        pulldown_cmark::html::push_html(&mut html, pulldown_cmark::Parser::new(&markdown));
        assert_eq!(html, "<h1>a&lt;b&amp;c`|d # e_f.obj</h1>\n");
    }

    #[test]
    fn figures_of_nothing_are_dashes() {
        assert_eq!((figure(None, 3), figure(Some(0.5), 3)), ("–".to_owned(), "0.500".to_owned()));
        assert_eq!(percent(Some(0.01234), 2), "1.23");
        let counts = PixelCounts { compared: 97, sky: 900, facing_away: 1, excluded: 2 };
        assert_eq!(counts.excluded_share(), 0.02);
        assert_eq!(PixelCounts { sky: 5, ..PixelCounts::default() }.excluded_share(), 0.0);
    }

    #[test]
    fn thousands_stand_apart() {
        for (number, text) in [(0, "0"), (999, "999"), (1000, "1,000"), (15_058_044, "15,058,044")] {
            assert_eq!(grouped(number), text);
        }
    }
}
