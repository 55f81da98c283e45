//! A comparison's results, as JSON and as Markdown.
//!
//! The JSON is [`Report`], field by field. `adumbra schema compare` describes each field.

mod sweep;

use std::fmt::Write as _;

use adumbra_html::page::Table;
use adumbra_program::format::{escaped, figure, megabytes, percent};
use adumbra_program::sun::SunOrigin;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
pub use sweep::{SweepReport, SweepRow};

use crate::metrics::Band;
use crate::shimmer::Shimmer;

/// All results of one camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Report {
    /// The adapter that drew, with its driver.
    pub adapter: String,
    /// Whether the adapter is a software renderer.
    pub software: bool,
    /// The scene's file name.
    pub scene: String,
    /// The camera.
    pub camera: CameraFigures,
    /// Unit vector towards the sun.
    pub sun: [f64; 3],
    /// Where the sun comes from, in a report of `adumbra compare`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sun_origin: Option<SunOrigin>,
    /// Angular diameter in degrees of the sun's disc in the truth for soft techniques.
    pub sun_degrees: f64,
    /// Rays per pixel towards that disc.
    pub sun_samples: u32,
    /// Number of frames that each median is taken over.
    pub frames: u32,
    /// Counts of compared and other pixels.
    pub pixels: PixelCounts,
    /// Baked files that techniques used.
    pub baked: Vec<BakedFigures>,
    /// Features that the device lacks, each with its consequence.
    pub missing_features: Vec<String>,
    /// One row per technique, in the order requested.
    pub techniques: Vec<TechniqueRow>,
    /// Results over a camera path, if one was given.
    pub path: Option<PathReport>,
    /// Results while the sun moves, if a sweep was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sweep: Option<SweepReport>,
}

/// A camera, as requested and as resolved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CameraFigures {
    /// `given`, `street`, `overview`, or the name of a truth file.
    pub name: String,
    /// Position in world space.
    pub eye: [f64; 3],
    /// Point in world space at the middle of the picture.
    pub target: [f64; 3],
    /// Vertical field of view in degrees; `None` for an orthographic camera.
    pub fov_degrees: Option<f64>,
    /// Height of the picture in world units; `None` for a perspective camera.
    pub height_world: Option<f64>,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
}

/// Numbers of pixels by outcome. They add up to the picture's pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct PixelCounts {
    /// Pixels compared.
    pub compared: u64,
    /// Pixels without a surface in both G-buffer and ray-traced view.
    pub sky: u64,
    /// Pixels that face away from the sun: n·l <= 0.1.
    pub facing_away: u64,
    /// Pixels where G-buffer and rays see different surfaces: their view depths differ by more than 0.1 %.
    pub excluded: u64,
}

/// Largest share of excluded pixels among those with a surface.
///
/// With more of them, the compared pixels do not represent the picture.
pub const MAX_EXCLUDED: f64 = 0.01;

impl PixelCounts {
    /// Returns the excluded pixels as a share of those with a surface, 0 if there are none.
    pub fn excluded_share(&self) -> f64 {
        let surfaces = self.compared + self.facing_away + self.excluded;
        self.excluded as f64 / surfaces.max(1) as f64
    }
}

/// A baked file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BakedFigures {
    /// Alignment: `light` or `world`.
    pub frame: String,
    /// Voxels along the longest side.
    pub resolution: u64,
    /// Edge length of a voxel in world units.
    pub voxel_size: f64,
    /// Size of the file in bytes.
    pub file_bytes: u64,
}

/// The truth that a technique was compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum TruthKind {
    /// One ray towards the middle of the sun.
    Hard,
    /// Rays towards a disc of [`Report::sun_degrees`].
    Disc,
}

/// Errors at pixels more than two of the technique's own texels from an edge of the true shadow.
///
/// These are acne and leaks, without the errors due to the size of a texel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ClearErrors {
    /// Share of compared pixels at that distance. If more than 65,536 were compared, all shares are of a
    /// sample.
    pub pixels: f64,
    /// Share of those that are shadowed but called lit.
    pub wrong_lit: f64,
    /// Share of those that are lit but called shadowed.
    pub wrong_shadowed: f64,
}

/// One technique's results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TechniqueRow {
    /// Name as requested.
    pub name: String,
    /// Median milliseconds of all its passes: depth, look-up, screen. `None` for traced truth.
    pub gpu_ms: Option<f64>,
    /// Median milliseconds of its depth passes alone.
    pub depth_ms: Option<f64>,
    /// Median milliseconds of its look-up alone.
    pub lookup_ms: Option<f64>,
    /// Median milliseconds of its screen-space passes alone.
    pub screen_ms: Option<f64>,
    /// Whether the times are wall times, because the device has no timestamps or is a software renderer.
    pub wall_time: bool,
    /// GPU memory of its shadows in bytes.
    pub bytes: u64,
    /// The truth that it was compared with.
    pub truth: TruthKind,
    /// Root mean square error of the shadow factor, 0 to 1. This and the next five are `None` if no pixel was
    /// compared.
    pub rmse: Option<f64>,
    /// Mean absolute error of the shadow factor, 0 to 1.
    pub mean_difference: Option<f64>,
    /// Structural similarity of the composited picture; 1 means identical.
    pub ssim: Option<f64>,
    /// Mean FLIP of the composited picture, 0 to 1; 0 means identical.
    pub flip: Option<f64>,
    /// Share of compared pixels that are shadowed but called lit.
    pub wrong_lit: Option<f64>,
    /// Share of compared pixels that are lit but called shadowed.
    pub wrong_shadowed: Option<f64>,
    /// Errors away from edges; `None` if the technique has no texels or no pixel is away from edges.
    pub clear: Option<ClearErrors>,
    /// Errors by distance from the camera.
    pub bands: Vec<Band>,
    /// What it omits on this device.
    pub notes: Vec<String>,
}

impl TechniqueRow {
    /// Returns the share of compared pixels on the wrong side of 1/2, or `None` if no pixel was compared.
    pub fn wrong(&self) -> Option<f64> {
        Some(self.wrong_lit? + self.wrong_shadowed?)
    }

    /// Formats one of its times, with a star if it is a wall time.
    fn milliseconds(&self, time: Option<f64>) -> String {
        let star = if self.wall_time { "*" } else { "" };
        time.map_or_else(|| "–".to_owned(), |ms| format!("{ms:.3}{star}"))
    }
}

/// Results over a camera path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PathReport {
    /// Number of frames.
    pub frames: u32,
    /// One row per technique.
    pub techniques: Vec<PathRow>,
    /// Comparison of each voxel technique with the first `csm`.
    pub cheaper: Vec<Cheaper>,
}

/// One technique's results over a path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PathRow {
    /// Name as requested.
    pub name: String,
    /// Milliseconds of all its passes, per frame.
    pub gpu_ms: Vec<f64>,
    /// Milliseconds of its depth passes alone, per frame.
    pub depth_ms: Vec<f64>,
    /// Milliseconds of its look-up and its screen-space passes, per frame.
    pub lookup_ms: Vec<f64>,
    /// Whether the times are wall times.
    pub wall_time: bool,
    /// Changes at fixed points.
    ///
    /// `None` if the technique filters in screen space and so cannot be evaluated at points.
    /// Also `None` if no point stays in view from one frame to the next.
    pub shimmer: Option<Shimmer>,
}

/// The share of frames in which a voxel technique costs less than cascades.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Cheaper {
    /// The voxel technique.
    pub voxel: String,
    /// The cascades that it is compared with.
    pub csm: String,
    /// Share of the frames in which the voxel technique costs less.
    pub share: f64,
}

impl Report {
    /// Returns tables of all results.
    pub fn markdown(&self) -> String {
        let mut text = format!("# Shadows of {} compared with the truth\n\n", escaped(&self.scene));
        let c = &self.camera;
        let lens = match (c.fov_degrees, c.height_world) {
            (Some(fov), _) => format!("vertical field of view {fov}°"),
            (_, Some(height)) => format!("orthographic, {height} high"),
            _ => String::new(),
        };
        let p = &self.pixels;
        // Writing to a `String` never fails.
        let _ = writeln!(
            text,
            "Camera {}: eye ({}), target ({}), {lens}, {} x {}. Sun towards ({}). Drawn by {}{}.\n\n\
            {} pixels are compared; {} are sky, {} face away from the sun (n·l <= 0.1), and {} are excluded \
            because G-buffer and rays see different surfaces.\n",
            escaped(&c.name),
            triple(c.eye),
            triple(c.target),
            c.width,
            c.height,
            triple(self.sun),
            self.adapter,
            if self.software { ", a software renderer" } else { "" },
            p.compared,
            p.sky,
            p.facing_away,
            p.excluded
        );
        for b in &self.baked {
            let _ = writeln!(
                text,
                "Baked: {}-aligned, {} voxels on the longest side, voxel size {:.4}, {:.2} MB.\n",
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
        if let Some(sweep) = &self.sweep {
            text.push_str(&sweep.markdown());
        }
        for (name, note) in self.techniques.iter().flat_map(|t| t.notes.iter().map(move |n| (&t.name, n))) {
            let _ = writeln!(text, "- `{name}`: {note}");
        }
        for note in &self.missing_features {
            let _ = writeln!(text, "- {note}");
        }
        text
    }

    /// Returns a table with one row per technique.
    pub(crate) fn technique_table(&self) -> String {
        let table = Table::of(
            "",
            &self.techniques,
            &[
                ("technique", |t| format!("`{}`", t.name)),
                ("all ms", |t| t.milliseconds(t.gpu_ms)),
                ("depth", |t| t.milliseconds(t.depth_ms)),
                ("look-up", |t| t.milliseconds(t.lookup_ms)),
                ("screen", |t| t.milliseconds(t.screen_ms)),
                ("MB", |t| megabytes(t.bytes, 2)),
                ("truth", |t| match t.truth {
                    TruthKind::Hard => "hard".to_owned(),
                    TruthKind::Disc => "disc".to_owned(),
                }),
                ("RMSE", |t| figure(t.rmse, 4)),
                ("SSIM", |t| figure(t.ssim, 4)),
                ("FLIP", |t| figure(t.flip, 4)),
                ("wrong lit %", |t| percent(t.wrong_lit, 3)),
                ("wrong shadowed %", |t| percent(t.wrong_shadowed, 3)),
                ("clear of edges %", |t| {
                    let both =
                        |c: ClearErrors| [c.wrong_lit, c.wrong_shadowed].map(|s| percent(s, 3)).join(" + ");
                    t.clear.map_or_else(|| "–".to_owned(), both)
                }),
            ],
        );
        format!(
            "Times are medians of {} frames in milliseconds (*: wall time, because the device has no timestamps \
            or is a software renderer). Truth is traced towards the sun's centre (hard) or towards a disc of {}° \
            with {} rays per pixel (disc). RMSE and wrong shares are of the shadow factor, SSIM and FLIP (67 \
            pixels per degree) of the composited picture. Wrong lit: shadowed pixels called lit. Wrong shadowed: \
            lit pixels called shadowed. Clear of edges: the same two, counting only pixels more than two of the \
            technique's texels away from any edge of the true shadow.\n\n{}\n",
            self.frames,
            self.sun_degrees,
            self.sun_samples,
            table.markdown()
        )
    }

    /// Returns wrong pixels by distance, with one row per band and one column per technique.
    pub(crate) fn band_table(&self) -> String {
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
        let mut text =
            "## Wrong pixels by distance\n\nWrong lit + wrong shadowed, in % of the band's compared \
            pixels.\n\n\
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
    /// Returns a table with one row per technique, and how often voxels are cheaper.
    pub fn markdown(&self) -> String {
        let head = ["technique", "median ms", "min", "max", "shimmer %", "mean change"];
        let mut table = Table::new("", &head);
        for t in &self.techniques {
            let mut sorted = t.gpu_ms.clone();
            sorted.sort_by(f64::total_cmp);
            let at = |i: usize| figure(sorted.get(i).copied().unwrap_or(f64::NAN), 3);
            table.row([
                format!("`{}`", t.name),
                at(sorted.len() / 2),
                at(0),
                at(sorted.len().saturating_sub(1)),
                percent(t.shimmer.and_then(|s| s.edge_share), 3),
                figure(t.shimmer.and_then(|s| s.edge_mean), 5),
            ]);
        }
        let mut text = format!(
            "## Along a path of {} frames\n\nShimmer: share of the points near an edge of the true shadow whose \
            shadow factor changes by more than 0.05 from one frame to the next, and the mean change there.\n\n{}\n",
            self.frames,
            table.markdown()
        );
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

    /// Returns CSV with one line per frame: its number, then each technique's milliseconds.
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

fn triple(v: [f64; 3]) -> String {
    v.map(|c| format!("{}", (c * 1e4).round() / 1e4)).join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn excluded_share_ignores_the_sky() {
        let counts = PixelCounts { compared: 97, sky: 900, facing_away: 1, excluded: 2 };
        assert_eq!(counts.excluded_share(), 0.02);
        assert_eq!(PixelCounts { sky: 5, ..PixelCounts::default() }.excluded_share(), 0.0);
    }
}
