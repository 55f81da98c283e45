//! Comparison of techniques with the truth: the renderer draws each at one camera, and every pixel is
//! compared.

mod boundary;
mod clear;
mod near_edges;
mod sweep;
mod timing;
mod walk;

use adumbra_render::{
    Answer, FrameTimes, Given, Prepared, Renderer, Shot, Stage, SurfaceImage, TechniqueSpec, Truth,
};
use adumbra_scene::{Camera, Projection};
use adumbra_truth::picture::Picture;
pub use boundary::{BoundaryGain, boundary_gain};
pub use clear::CLEAR_TEXELS;
pub(crate) use clear::clear_errors;
pub use near_edges::{errors_off_edges, near_edges};
pub use sweep::{Swept, sweep};
pub use timing::{interleaved, median_ratio, median_time, ratio_range, take_turns};
pub use walk::walk;

use crate::error::Result;
use crate::metrics::{bands, factor_errors, flip, median, ssim};
use crate::pictures::{difference_picture, picture_of_rgba};
use crate::report::{CameraFigures, PixelCounts, TechniqueRow, TruthKind};
use crate::truth::{Cache, EdgeProbe, Key, SunShape, Surfaces, TruthTracer};

/// Largest relative difference of the view depths of G-buffer and rays that counts as the same surface.
pub const SAME_SURFACE: f64 = 1e-3;
/// Pixels are compared if the cosine between normal and sun is above this.
pub const MIN_N_DOT_L: f64 = adumbra_truth::verify::MIN_N_DOT_L;

/// The reference of a comparison: ray-traced truth for a scene and a sun.
pub struct Reference<'a, 's> {
    /// The ray tracer of the scene.
    pub truth: &'a TruthTracer<'s>,
    /// Cache of ray-traced truth.
    pub cache: &'a Cache,
    /// The scene's part of the cache keys.
    pub scene: &'a Key,
    /// Unit vector towards the sun.
    pub towards_sun: [f64; 3],
    /// The sun's disc in the truth for soft techniques: angular diameter in degrees, rays per pixel.
    pub disc: (f64, u32),
}

/// A technique to compare.
pub struct Contender {
    /// The technique, as requested.
    pub spec: TechniqueSpec,
    /// Its pipelines. `None` for the technique `truth`, which is drawn with the true factors. It shows how
    /// far the renderer's picture is from the ray-traced one for reasons other than a shadow technique.
    pub prepared: Option<Prepared>,
    /// The truth that it is compared with.
    pub truth: TruthKind,
}

/// Results and pictures of a technique.
pub struct Compared {
    /// Its row of the report.
    pub row: TechniqueRow,
    /// Shadow factors, one per pixel.
    pub factors: Vec<f32>,
    /// The picture that it drew.
    pub picture: Picture,
    /// The difference picture of its shadow factors.
    pub difference: Picture,
}

/// The result of a comparison at one camera.
pub struct Comparison {
    /// Counts of compared and other pixels.
    pub pixels: PixelCounts,
    /// Ray-traced pictures of the truths that techniques were compared with.
    pub truths: Vec<(TruthKind, Picture)>,
    /// One result per contender.
    pub compared: Vec<Compared>,
}

/// Returns the truth that a technique is compared with by default: its [`TechniqueSpec::truth`].
pub fn truth_for(spec: &TechniqueSpec) -> TruthKind {
    match spec.truth() {
        Truth::HardSun => TruthKind::Hard,
        Truth::SunDisc => TruthKind::Disc,
    }
}

/// Draws every contender at `camera` and compares it with the truth. The first frame of each is not timed.
/// Median times are over the `frames` (at least 1) after it.
///
/// Cost: the frames, the truth unless it is cached, and about 3 µs per pixel and contender for the picture
/// metrics.
///
/// # Errors
/// Returns the errors of the renderer, and [`crate::Error::PictureTooSmall`] if the camera has fewer than 11
/// pixels in width or height.
pub fn compare(
    renderer: &mut Renderer,
    reference: &Reference<'_, '_>,
    camera: &Camera,
    contenders: &mut [Contender],
    frames: u32,
) -> Result<Comparison> {
    let shot = Shot { camera: *camera, towards_sun: reference.towards_sun, number: 0 };
    let surfaces = reference.cache.surfaces(reference.truth, reference.scene, camera);
    let mut truths: Vec<Traced> = Vec::new();
    for kind in [TruthKind::Hard, TruthKind::Disc] {
        if contenders.iter().any(|c| c.truth == kind) {
            truths.push(Traced::new(reference, camera, &surfaces, kind));
        }
    }
    let (pixels, counted) = reference.count(&surfaces, &drawn_surface(renderer, &shot)?);
    let mut compared = Vec::new();
    for contender in contenders.iter_mut() {
        let Some(truth) = truths.iter().find(|t| t.kind == contender.truth) else { continue };
        compared.push(draw_and_judge(
            renderer,
            reference,
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

/// Returns the G-buffer at the camera. It is the same for every technique.
fn drawn_surface(renderer: &mut Renderer, shot: &Shot) -> Result<SurfaceImage> {
    let lit = vec![1.0; shot.camera.width as usize * shot.camera.height as usize];
    draw_given(renderer, shot, &lit)?;
    Ok(renderer.read_surface(shot)?)
}

/// Draws the picture with the given shadow factors.
fn draw_given(renderer: &mut Renderer, shot: &Shot, factors: &[f32]) -> Result<()> {
    let size = [shot.camera.width, shot.camera.height];
    let mut given = renderer.prepare(Box::new(Given::new(renderer.gpu(), "given", size, factors)?))?;
    renderer.draw(shot, &mut given, Answer::Visibility)?;
    Ok(())
}

/// One kind of truth at a camera.
struct Traced {
    kind: TruthKind,
    factors: Vec<f32>,
    picture: Picture,
}

impl Traced {
    fn new(reference: &Reference<'_, '_>, camera: &Camera, surfaces: &Surfaces, kind: TruthKind) -> Self {
        let (sun_degrees, samples) = reference.disc;
        let shape = match kind {
            TruthKind::Hard => SunShape::Hard,
            TruthKind::Disc => SunShape::Disc { sun_degrees, samples },
        };
        let towards = reference.towards_sun;
        let factors =
            reference.cache.factors(reference.truth, reference.scene, camera, surfaces, towards, shape);
        let picture = reference.truth.picture(camera, surfaces, &factors, towards);
        Self { kind, factors, picture }
    }
}

impl Reference<'_, '_> {
    /// Counts the pixels by what rays and the G-buffer see there. Also returns for each pixel whether it is
    /// compared.
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
    reference: &Reference<'_, '_>,
    shot: &Shot,
    contender: &mut Contender,
    frames: u32,
    truth: &Traced,
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
            // The remaining difference from the ray-traced picture is due to the rasterizer.
            draw_given(renderer, shot, &truth.factors)?;
            let picture = picture_of_rgba(size, &renderer.read_picture()?);
            (truth.factors.clone(), picture, Vec::new(), 0, Vec::new())
        }
    };
    let is_compared = |i: usize| counted[i];
    let errors = factor_errors(&factors, &truth.factors, is_compared)?;
    let probe = EdgeProbe::new(reference.truth, reference.towards_sun);
    let texel = |i: usize| {
        let prepared = contender.prepared.as_ref()?;
        prepared.technique().texel_world(surfaces.view_depth[i] as f32)
    };
    let clear = clear_errors(&probe, surfaces, (&factors, &truth.factors), is_compared, texel);
    // Without compared pixels, metrics of the pictures are as meaningless as those of the factors.
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
        bands: bands(&factors, &truth.factors, &surfaces.view_depth, is_compared)?,
        notes,
    };
    let difference = difference_picture(size, &factors, &truth.factors, is_compared)?;
    Ok(Compared { row, factors, picture, difference })
}

/// Returns the camera's part of the report.
pub fn camera_figures(name: &str, camera: &Camera) -> CameraFigures {
    let (fov_degrees, height_world) = match camera.projection {
        Projection::Perspective { fov_degrees } => (Some(fov_degrees), None),
        Projection::Orthographic { height_world } => (None, Some(height_world)),
    };
    let Camera { eye, target, width, height, .. } = *camera;
    CameraFigures { name: name.to_owned(), eye, target, fov_degrees, height_world, width, height }
}
