//! `adumbra-lab bench blur`: cost of the screen-space blur by samples, passes and weights, and the bleeding
//! it causes.

use std::fmt::Write as _;

use adumbra::Sun;
use adumbra_program::exit::Code;
use adumbra_program::output::{make_folder, print_json};
use adumbra_render::frame::frame;
use adumbra_render::readback::read_floats;
use adumbra_render::screen_blur::twin::{Surfaces, bleeding};
use adumbra_render::{Answer, Gpu, Renderer, SceneOptions, Shot, Stage, TechniqueFiles, build};
use adumbra_scene::{Camera, GeneratedKind, generate};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::args::BenchBlur;
use adumbra_compare::Result;
use adumbra_html::page::Table;
use adumbra_html::plot::{Along, Legend, Panel, Series, write_svg};

/// Name, and technique with its parameters; the number of samples is appended.
const TWO_PASSES: [(&str, &str); 6] = [
    ("weights in the shader", "blur:weights=shader"),
    ("weights once", "blur"),
    ("pairs", "blur:pairs=on"),
    ("half size", "blur:half=on"),
    ("half size, pairs", "blur:half=on:pairs=on"),
    ("within surfaces", "blur-bilateral"),
];
const ONE_PASS: [(&str, &str); 3] = [
    ("weights in the shader", "blur:passes=1:weights=shader"),
    ("weights once", "blur:passes=1"),
    ("within surfaces", "blur-bilateral:passes=1"),
];
/// Name and technique of each variant whose bleeding across silhouettes is counted.
const SPOILS: [(&str, &str); 6] = [
    ("blur", "blur"),
    ("dilated by 1", "blur-dilate:radius=1"),
    ("dilated by 2", "blur-dilate:radius=2"),
    ("dilated by 4", "blur-dilate:radius=4"),
    ("within surfaces", "blur-bilateral"),
    ("within surfaces, half size", "blur-bilateral:half=on"),
];
const SPOIL_SAMPLES: u32 = 32;
const SCENE_SEED: u64 = 1;

/// All results.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct BlurResults {
    /// Name of the device that drew.
    device: String,
    /// Width and height in pixels.
    size: [u32; 2],
    /// Number of frames that each time is the median of.
    runs: usize,
    /// Whether times are wall times because the device has no timestamps.
    wall_time: bool,
    /// Costs of the blurs in two passes.
    pub(crate) two_passes: Vec<Cost>,
    /// Costs of the blurs in one pass.
    pub(crate) one_pass: Vec<Cost>,
    /// What each variant changes wrongly.
    pub(crate) bleeding: Vec<Bleeding>,
}

/// The cost of a variant.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct Cost {
    /// Name.
    name: String,
    /// Technique as given to `--shadow`.
    technique: String,
    /// Samples along a line.
    pub(crate) samples: Vec<u32>,
    /// Median times, one for each entry of `samples`.
    pub(crate) milliseconds: Vec<f64>,
}

/// The pixels that a variant wrongly changes by blurring across silhouettes.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct Bleeding {
    /// Name.
    pub(crate) name: String,
    /// Technique as given to `--shadow`.
    technique: String,
    /// Samples along a line.
    samples: u32,
    /// Lit pixels made darker: a halo around a shadow on another surface.
    pub(crate) halo: u32,
    /// Shadowed pixels made lighter: a gap between an object and its shadow.
    pub(crate) gap: u32,
    /// Largest change of a pixel's visibility.
    pub(crate) largest: f64,
}

struct Bench<'a> {
    args: &'a BenchBlur,
    renderer: Renderer,
    shot: Shot,
}

pub(super) fn run(args: &BenchBlur) -> Result<Code> {
    make_folder(&args.output)?;
    let gpu = Gpu::request(&args.device.gpu_options())?;
    let device = gpu.name();
    let scene = generate(GeneratedKind::Primitives, SCENE_SEED);
    let towards_sun = Sun::from_direction([0.5, 0.8, 0.35])?.towards();
    let [width, height] = args.size;
    let camera = Camera { width, height, ..Camera::overview(&scene.bounds(), 45.0) };
    let renderer = Renderer::new(gpu, &scene, SceneOptions::default())?;
    let mut bench = Bench { args, renderer, shot: Shot { camera, towards_sun, number: 0 } };
    let (two_passes, wall_time) = bench.costs(&TWO_PASSES)?;
    let (one_pass, _) = bench.costs(&ONE_PASS)?;
    let bleeding = bench.bleeding()?;
    let (size, runs) = (args.size, args.runs);
    let document = BlurResults { device, size, runs, wall_time, two_passes, one_pass, bleeding };
    super::write(&args.output, "blur", &document.markdown(), &document)?;
    let panels = document.parts().map(|(title, costs)| Panel {
        title: title.to_owned(),
        along: Along::Numbers("samples"),
        y_label: "ms",
        logarithmic: true,
        legend: Legend::LowerLeft,
        series: costs.iter().map(Cost::series).collect(),
    });
    write_svg(&args.output.join("blur.svg"), &panels)?;
    if args.json {
        print_json(&document)?;
    } else {
        super::say_tables(&args.output, "blur");
    }
    Ok(Code::Fine)
}

impl Bench<'_> {
    /// Measures median milliseconds by variant and samples, and returns with them whether they are wall
    /// times.
    fn costs(&mut self, variants: &[(&str, &str)]) -> Result<(Vec<Cost>, bool)> {
        let mut rows = Vec::new();
        let mut wall_time = false;
        for (name, technique) in variants {
            let mut milliseconds = Vec::new();
            for samples in &self.args.samples {
                let spec = format!("{technique}:samples={samples}").parse()?;
                let built = build(self.renderer.gpu(), &spec, TechniqueFiles::default())?;
                let mut prepared = self.renderer.prepare(built)?;
                let mut times = Vec::new();
                // The first frame is not timed: it creates resources that later frames reuse.
                for run in 0..=self.args.runs {
                    let drawn = self.renderer.draw(&self.shot, &mut prepared, Answer::Visibility)?;
                    wall_time = drawn.wall_time;
                    if run > 0 {
                        times.push(drawn.of(Stage::Screen));
                    }
                }
                times.sort_by(f64::total_cmp);
                milliseconds.push(times[times.len() / 2]);
                adumbra_program::note!("{spec}: {:.2} ms", times[times.len() / 2]);
            }
            rows.push(Cost {
                name: (*name).to_owned(),
                technique: (*technique).to_owned(),
                samples: self.args.samples.clone(),
                milliseconds,
            });
        }
        Ok((rows, wall_time))
    }

    /// Counts the pixels that each variant changes by blurring across silhouettes.
    fn bleeding(&mut self) -> Result<Vec<Bleeding>> {
        let mut rows = Vec::new();
        for (name, technique) in SPOILS {
            let spec = format!("{technique}:samples={SPOIL_SAMPLES}").parse()?;
            let built = build(self.renderer.gpu(), &spec, TechniqueFiles::default())?;
            let mut prepared = self.renderer.prepare(built)?;
            self.renderer.draw(&self.shot, &mut prepared, Answer::Visibility)?;
            let blurred = self.renderer.read_factor(&prepared)?;
            let Some(targets) = self.renderer.targets() else { continue };
            let gpu = self.renderer.gpu();
            let factor = read_floats(gpu, &targets.factor.texture, 0, 0)?;
            let depth = read_floats(gpu, &targets.depth.texture, 0, 0)?;
            let normal = self.renderer.read_surface(&self.shot)?.normal;
            let frame = frame(&self.shot.camera, &self.renderer.bounds(), self.shot.towards_sun, 0);
            let surfaces = Surfaces { frame, depth: &depth, normal: &normal };
            let found = bleeding(&factor, &blurred, &surfaces, SPOIL_SAMPLES / 2 + 4);
            rows.push(Bleeding {
                name: name.to_owned(),
                technique: technique.to_owned(),
                samples: SPOIL_SAMPLES,
                halo: found.halo,
                gap: found.gap,
                largest: found.largest.into(),
            });
        }
        Ok(rows)
    }
}

impl BlurResults {
    fn parts(&self) -> [(&'static str, &[Cost]); 2] {
        [("Two passes", &self.two_passes), ("One pass", &self.one_pass)]
    }

    fn markdown(&self) -> String {
        let clock = if self.wall_time { "wall times" } else { "GPU timestamps" };
        let ([width, height], runs) = (self.size, self.runs);
        let mut text = format!(
            "# Screen-space blur\n\n{}, {width} × {height} pixels. Times are of the blur's own passes, medians \
             of {runs} ({clock}). Each of two passes reads one line of samples per pixel; a single pass reads \
             their square. Weights computed in the shader cost one exponential per sample. Made by `adumbra-lab bench \
             blur --size {width}x{height} --runs {runs} -o docs/bench`.\n\n![Milliseconds by samples](blur.svg)\n",
            self.device,
        );
        for (title, costs) in self.parts() {
            let samples = costs.first().map_or(&[][..], |c| &c.samples);
            let head: Vec<String> = samples.iter().map(u32::to_string).collect();
            let head: Vec<&str> = [""].into_iter().chain(head.iter().map(String::as_str)).collect();
            let mut table = Table::new("", &head);
            for cost in costs {
                let cells = cost.milliseconds.iter().map(|ms| format!("{ms:.2}"));
                table.row([cost.name.clone()].into_iter().chain(cells));
            }
            // Writing to a `String` never fails.
            let _ = write!(text, "\n## {title}, milliseconds by samples\n\n{}", table.markdown());
        }
        let mut table = Table::new("", &["", "halo", "gap", "largest change"]);
        for bleed in &self.bleeding {
            table.row(bleed.cells());
        }
        let _ = write!(
            text,
            "\n## Bleeding across silhouettes\n\nPixels that a blur of {SPOIL_SAMPLES} samples changes by more \
             than 0.02 although their own surface is uniform within its reach. *Halo*: lit pixels darkened by a \
             shadow on a surface in front or behind. *Gap*: shadowed pixels lightened, which leaves a gap \
             between an object and its shadow.\n\n{}",
            table.markdown()
        );
        text
    }
}

impl Cost {
    fn series(&self) -> Series {
        let samples = self.samples.iter().map(|samples| f64::from(*samples));
        Series { name: self.name.clone(), points: samples.zip(self.milliseconds.iter().copied()).collect() }
    }
}

impl Bleeding {
    /// Returns the cells of its table row: name, halo, gap, largest change.
    pub(crate) fn cells(&self) -> [String; 4] {
        [self.name.clone(), self.halo.to_string(), self.gap.to_string(), format!("{:.3}", self.largest)]
    }
}
