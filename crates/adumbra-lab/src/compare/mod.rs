//! Techniques beside the truth: each drawn by the renderer at one camera, and judged pixel by pixel.

mod boundary;
mod clear;
mod flips;
mod timing;
mod walk;

use adumbra::camera::{Camera, Projection};
use adumbra::picture::Picture;
use adumbra_render::{
    Answer, FrameTimes, Given, Prepared, Renderer, Shot, Stage, SurfaceImage, TechniqueSpec,
};
pub use boundary::{BoundaryGain, boundary_gain};
pub use clear::{CLEAR_TEXELS, clear_errors};
pub use flips::{errors_off_edges, near_flips};
pub use timing::{interleaved, median_ratio, median_time, ratio_range, take_turns};
pub use walk::walk;

use crate::error::Result;
use crate::metrics::{bands, factor_errors, flip, ssim};
use crate::pictures::{difference_picture, picture_of_rgba};
use crate::report::{CameraFigures, PixelCounts, TechniqueRow, TruthKind, median};
use crate::truth::{Cache, EdgeProbe, Key, SunShape, Surfaces, TruthTracer};

/// G-buffer and rays see the same surface where their view depths differ by no more than this share.
pub const SAME_SURFACE: f64 = 1e-3;
/// Pixels with a smaller cosine to the sun are not compared.
pub const MIN_N_DOT_L: f64 = adumbra::verify::MIN_N_DOT_L;

/// The truth's side of a comparison.
pub struct Judge<'a, 's> {
    /// The scene's rays.
    pub truth: &'a TruthTracer<'s>,
    /// Where traced pictures are kept.
    pub cache: &'a Cache,
    /// The scene's part of their keys.
    pub scene: &'a Key,
    /// Unit vector towards the sun.
    pub towards_sun: [f64; 3],
    /// The disc that soft techniques are judged by: full angle in degrees, rays a pixel.
    pub disc: (f64, u32),
}

/// A technique to compare.
pub struct Contender {
    /// As it was asked for.
    pub spec: TechniqueSpec,
    /// Its pipelines; none for `truth` itself, which is drawn with the factors that judge it: it shows how far the renderer's picture is
    /// from that of the rays without any technique's doing.
    pub prepared: Option<Prepared>,
    /// What judges it.
    pub truth: TruthKind,
}

/// A technique's figures and pictures.
pub struct Compared {
    /// Its row of the report.
    pub row: TechniqueRow,
    /// Shadow factors, one a pixel.
    pub factors: Vec<f32>,
    /// What it drew.
    pub picture: Picture,
    /// Where it is wrong.
    pub difference: Picture,
}

/// What one camera gave.
pub struct Comparison {
    /// Which pixels were compared.
    pub pixels: PixelCounts,
    /// The truths that judged a technique, as rays see them.
    pub truths: Vec<(TruthKind, Picture)>,
    /// One a contender.
    pub compared: Vec<Compared>,
}

/// What judges a technique by default: what it declares by [`TechniqueSpec::shows_disc`].
pub fn truth_for(spec: &TechniqueSpec) -> TruthKind {
    if spec.shows_disc() { TruthKind::Disc } else { TruthKind::Hard }
}

/// Draws every contender at `camera` and compares. The first frame of each is not timed; the medians are of the `frames` (at least 1) after it.
///
/// # Errors
/// What the renderer reports; [`crate::Error::PictureTooSmall`] for a camera of fewer than 11 pixels a side. Cost: the frames, the truth
/// where it is not kept yet, and about 3 µs a pixel and contender for the pictures' metrics.
pub fn compare(
    renderer: &mut Renderer,
    judge: &Judge<'_, '_>,
    camera: &Camera,
    contenders: &mut [Contender],
    frames: u32,
) -> Result<Comparison> {
    let shot = Shot { camera: *camera, towards_sun: judge.towards_sun, number: 0 };
    let surfaces = judge.cache.surfaces(judge.truth, judge.scene, camera);
    let mut truths: Vec<Truth> = Vec::new();
    for kind in [TruthKind::Hard, TruthKind::Disc] {
        if contenders.iter().any(|c| c.truth == kind) {
            truths.push(Truth::new(judge, camera, &surfaces, kind));
        }
    }
    let (pixels, counted) = judge.count(&surfaces, &drawn_surface(renderer, &shot)?);
    let mut compared = Vec::new();
    for contender in contenders.iter_mut() {
        let Some(truth) = truths.iter().find(|t| t.kind == contender.truth) else { continue };
        compared.push(draw_and_judge(
            renderer,
            judge,
            &shot,
            contender,
            frames,
            truth,
            (&surfaces, &counted),
        )?);
    }
    let truths = truths.into_iter().map(|t| (t.kind, t.picture)).collect();
    Ok(Comparison { pixels, truths, compared })
}

/// The G-buffer at the camera, which is the same for every technique.
fn drawn_surface(renderer: &mut Renderer, shot: &Shot) -> Result<SurfaceImage> {
    let lit = vec![1.0; shot.camera.width as usize * shot.camera.height as usize];
    draw_given(renderer, shot, &lit)?;
    Ok(renderer.read_surface(shot)?)
}

/// Draws the renderer's picture with these shadow factors.
fn draw_given(renderer: &mut Renderer, shot: &Shot, factors: &[f32]) -> Result<()> {
    let size = [shot.camera.width, shot.camera.height];
    let mut given = renderer.prepare(Box::new(Given::new(renderer.gpu(), "given", size, factors)?))?;
    renderer.draw(shot, &mut given, Answer::Visibility)?;
    Ok(())
}

/// One kind of truth at the camera.
struct Truth {
    kind: TruthKind,
    factors: Vec<f32>,
    picture: Picture,
}

impl Truth {
    fn new(judge: &Judge<'_, '_>, camera: &Camera, surfaces: &Surfaces, kind: TruthKind) -> Self {
        let (angle_degrees, samples) = judge.disc;
        let shape = match kind {
            TruthKind::Hard => SunShape::Hard,
            TruthKind::Disc => SunShape::Disc { angle_degrees, samples },
        };
        let towards = judge.towards_sun;
        let factors = judge.cache.factors(judge.truth, judge.scene, camera, surfaces, towards, shape);
        let picture = judge.truth.picture(camera, surfaces, &factors, towards);
        Self { kind, factors, picture }
    }
}

impl Judge<'_, '_> {
    /// Sorts the pixels by what rays and the G-buffer see there; true where they are compared.
    pub fn count(&self, surfaces: &Surfaces, drawn: &SurfaceImage) -> (PixelCounts, Vec<bool>) {
        let mut counts = PixelCounts::default();
        let compared = (0..surfaces.pixels()).map(|i| {
            let (traced, drawn) = (surfaces.view_depth[i], f64::from(drawn.view_depth[i]));
            let same = (traced - drawn).abs() <= SAME_SURFACE * traced.abs();
            let count = match (surfaces.is_valid(i), drawn.is_finite()) {
                (false, false) => &mut counts.sky,
                (true, true) if same && surfaces.n_dot_l(i, self.towards_sun) <= MIN_N_DOT_L => {
                    &mut counts.facing_away
                }
                (true, true) if same => {
                    counts.compared += 1;
                    return true;
                }
                _ => &mut counts.excluded,
            };
            *count += 1;
            false
        });
        let compared = compared.collect();
        (counts, compared)
    }
}

fn draw_and_judge(
    renderer: &mut Renderer,
    judge: &Judge<'_, '_>,
    shot: &Shot,
    contender: &mut Contender,
    frames: u32,
    truth: &Truth,
    (surfaces, counted): (&Surfaces, &[bool]),
) -> Result<Compared> {
    let size = [shot.camera.width, shot.camera.height];
    let (factors, picture, times, bytes, notes) = match &mut contender.prepared {
        Some(prepared) => {
            renderer.draw(shot, prepared, Answer::Visibility)?;
            let times: Vec<FrameTimes> = (0..frames.max(1))
                .map(|_| renderer.draw(shot, prepared, Answer::Visibility))
                .collect::<Result<_, _>>()?;
            let picture = picture_of_rgba(size, &renderer.read_picture()?);
            let technique = prepared.technique();
            (renderer.read_factor(prepared)?, picture, times, technique.bytes(), technique.notes())
        }
        None => {
            // What is left between its picture and that of the rays is the rasterizer's.
            draw_given(renderer, shot, &truth.factors)?;
            let picture = picture_of_rgba(size, &renderer.read_picture()?);
            (truth.factors.clone(), picture, Vec::new(), 0, Vec::new())
        }
    };
    let judged = |i: usize| counted[i];
    let errors = factor_errors(&factors, &truth.factors, judged)?;
    let probe = EdgeProbe::new(judge.truth, judge.towards_sun);
    let texel = |i: usize| {
        let prepared = contender.prepared.as_ref()?;
        prepared.technique().texel_world(surfaces.view_depth[i] as f32)
    };
    let clear = clear_errors(&probe, surfaces, (&factors, &truth.factors), judged, texel);
    // Of a picture of nothing no figure says anything, of factors or of colours.
    let pictures = match errors {
        Some(_) => Some((ssim(&truth.picture, &picture)?, flip(&truth.picture, &picture)?)),
        None => None,
    };
    let of = |what: &dyn Fn(&FrameTimes) -> f64| {
        (!times.is_empty()).then(|| median(times.iter().map(what).collect()))
    };
    let row = TechniqueRow {
        name: contender.spec.to_string(),
        gpu_ms: of(&FrameTimes::shadow),
        depth_ms: of(&|t| t.before_lookup()),
        lookup_ms: of(&|t| t.of(Stage::Lookup)),
        screen_ms: of(&|t| t.of(Stage::Screen)),
        wall_time: times.iter().any(|t| t.wall_time),
        bytes,
        truth: truth.kind,
        rmse: errors.map(|e| e.rmse),
        mean_difference: errors.map(|e| e.mean_difference),
        ssim: pictures.map(|p| p.0),
        flip: pictures.map(|p| p.1),
        wrong_lit: errors.map(|e| e.wrong_lit),
        wrong_shadowed: errors.map(|e| e.wrong_shadowed),
        clear,
        bands: bands(&factors, &truth.factors, &surfaces.view_depth, judged)?,
        notes,
    };
    let difference = difference_picture(size, &factors, &truth.factors, judged)?;
    Ok(Compared { row, factors, picture, difference })
}

/// A camera's figures for the report.
pub fn camera_figures(name: &str, camera: &Camera) -> CameraFigures {
    let (fov_degrees, height_world) = match camera.projection {
        Projection::Perspective { fov_degrees } => (Some(fov_degrees), None),
        Projection::Orthographic { height_world } => (None, Some(height_world)),
    };
    let Camera { eye, target, width, height, .. } = *camera;
    CameraFigures { name: name.to_owned(), eye, target, fov_degrees, height_world, width, height }
}
