//! The tracer compared with another renderer: every view in `shared/truth` (Mitsuba 3.9), traced again from
//! its stored positions and normals. `shared/truth/README.md` describes the contents of each array.
//!
//! CI tests every eighth pixel along x and y; `ADUMBRA_FULL=1` tests every pixel. The shared folder is
//! `ADUMBRA_SHARED`, or `shared` beside the checkout. Without it the test prints a message and passes.

use std::path::{Path, PathBuf};

use adumbra_scene::{LoadOptions, Scene, load};
use adumbra_testing::{full, npz_array, npz_camera, scene_file, shared};
use adumbra_truth::trace::{TraceOptions, Tracer};
use rayon::prelude::*;

/// Default step between tested pixels along x and y.
const STRIDE: usize = 8;
/// Occlusion rays per pixel, as in the truth data.
const AO_RAYS: u32 = 256;
/// Share of lit-side pixels whose hard shadow must agree.
const SUN_AGREEMENT: f64 = 0.996;
/// Bound on the mean signed difference of occlusion.
const AO_BIAS: f64 = 0.003;
/// Bound on the mean absolute difference of occlusion.
const AO_DIFFERENCE: f64 = 0.03;
/// Pixels with a smaller cosine to the sun are not compared.
const MIN_NDOTL: f32 = 0.1;
/// Offset of ray origins along the normal, as a fraction of the scene's diagonal.
const LIFT: f64 = 1e-5;

struct View {
    width: usize,
    pos: Vec<f32>,
    normal: Vec<f32>,
    ndotl: Vec<f32>,
    sun: Vec<f32>,
    ao: Vec<f32>,
    valid: Vec<bool>,
    towards: [f64; 3],
    ao_radius: f64,
}

impl View {
    fn open(path: &Path) -> Self {
        let [pos, normal, ndotl, sun, ao] =
            ["pos", "normal", "ndotl", "sun", "ao"].map(|name| npz_array(path, name));
        let valid = npz_array(path, "valid");
        let camera = npz_camera(path);
        let towards = std::array::from_fn(|a| camera["sun"][a].as_f64().unwrap());
        let ao_radius = camera["ao_radius"].as_f64().unwrap();
        let width = camera["size"][0].as_u64().unwrap() as usize;
        Self { width, pos, normal, ndotl, sun, ao, valid, towards, ao_radius }
    }

    /// The valid pixels, taking every `stride`-th one in x and y.
    fn pixels(&self, stride: usize) -> Vec<usize> {
        let looked_at =
            |i: usize| (i % self.width).is_multiple_of(stride) && (i / self.width).is_multiple_of(stride);
        (0..self.valid.len()).filter(|&i| self.valid[i] && looked_at(i)).collect()
    }

    /// The origin of a pixel's rays, and its normal.
    fn start(&self, pixel: usize, lift: f64) -> ([f64; 3], [f64; 3]) {
        let triple = |v: &[f32]| [0, 1, 2].map(|a| f64::from(v[pixel * 3 + a]));
        let (p, n) = (triple(&self.pos), triple(&self.normal));
        ([0, 1, 2].map(|a| p[a] + n[a] * lift), n)
    }
}

struct Figures {
    sun_pixels: usize,
    sun_agreement: f64,
    ao_pixels: usize,
    ao_bias: f64,
    ao_difference: f64,
}

impl Figures {
    fn hold(&self) -> bool {
        self.sun_agreement >= SUN_AGREEMENT
            && self.ao_bias.abs() <= AO_BIAS
            && self.ao_difference <= AO_DIFFERENCE
    }
}

fn compare(scene: &Scene, view: &View, stride: usize) -> Figures {
    let tracer = Tracer::build(scene, TraceOptions { ignore_alpha: true });
    let lift = LIFT * scene.bounds().diagonal();
    let pixels = view.pixels(stride);
    let checked: Vec<usize> = pixels.iter().copied().filter(|&i| view.ndotl[i] > MIN_NDOTL).collect();
    let agrees = |i: usize| tracer.sun_visible(view.start(i, lift).0, view.towards) == (view.sun[i] > 0.5);
    let agreeing = checked.par_iter().filter(|i| agrees(**i)).count();
    let ao_difference = |i: usize| {
        let (p, n) = view.start(i, lift);
        let ours = tracer.ambient_visibility(p, n, view.ao_radius, AO_RAYS, i as u64);
        f64::from(ours) - f64::from(view.ao[i])
    };
    let differences: Vec<f64> = pixels.par_iter().map(|&i| ao_difference(i)).collect();
    Figures {
        sun_pixels: checked.len(),
        sun_agreement: agreeing as f64 / checked.len() as f64,
        ao_pixels: pixels.len(),
        ao_bias: differences.iter().sum::<f64>() / pixels.len() as f64,
        ao_difference: differences.iter().map(|d| d.abs()).sum::<f64>() / pixels.len() as f64,
    }
}

#[test]
fn shared_trace_matches_another_renderer() {
    let (Some(truth), Some(scenes)) = (shared("truth"), shared("scenes")) else { return };
    let folder = std::fs::read_dir(&truth).unwrap();
    let mut files: Vec<PathBuf> = folder.map(|entry| entry.unwrap().path()).collect();
    files.retain(|p| p.extension().is_some_and(|e| e == "npz"));
    files.sort();
    assert!(!files.is_empty(), "no .npz in {}", truth.display());
    let stride = if full() { 1 } else { STRIDE };
    let options = LoadOptions { ignore_alpha: true, ..LoadOptions::default() };
    let mut missed = Vec::new();
    for file in files {
        let name = file.file_stem().unwrap().to_string_lossy().into_owned();
        let scene = load(&scene_file(&scenes, &name), &options).unwrap();
        let figures = compare(&scene, &View::open(&file), stride);
        eprintln!(
            "{name}: sun agrees on {:.3} % of {} pixels; ao off by {:+.5} in the mean, {:.5} in size, {} pixels",
            100.0 * figures.sun_agreement,
            figures.sun_pixels,
            figures.ao_bias,
            figures.ao_difference,
            figures.ao_pixels
        );
        if !figures.hold() {
            missed.push(name);
        }
    }
    assert!(missed.is_empty(), "out of bounds: {missed:?}");
}
