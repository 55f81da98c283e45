//! `adumbra-lab bench gpu`: everything that only a real GPU can measure, in one command that needs no files
//! and no display. Scenes are generated and baked as needed. When its time is over, the benchmark lists all
//! remaining measurements as left out.

mod scenes;
mod sections;
mod tables;
mod timed;

use std::time::{Duration, Instant};

use adumbra_program::exit::Code;
use adumbra_program::output::make_folder;
use adumbra_render::Gpu;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::args::BenchGpu;
use adumbra_compare::Result;

/// All results.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "GpuDocument")]
pub(crate) struct GpuResults {
    /// Adapter and driver.
    adapter: String,
    /// Whether the adapter runs in software, so that its times say nothing about a GPU.
    software: bool,
    /// Width and height of the pictures in pixels.
    size: [u32; 2],
    /// Most frames that a median is taken over.
    frames: u32,
    /// Seconds after which nothing more was begun.
    seconds: u64,
    /// The tables.
    sections: Vec<Section>,
    /// What was not measured: name and reason.
    left_out: Vec<[String; 2]>,
}

/// One table.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "GpuSection")]
pub(crate) struct Section {
    /// Title.
    title: String,
    /// What was drawn.
    scene: String,
    /// Its triangles, instances counted apart.
    triangles: u64,
    /// One row per technique.
    rows: Vec<Row>,
}

/// One technique.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "GpuRow")]
pub(crate) struct Row {
    /// The technique, written as for `render`, with the file that it reads.
    technique: String,
    /// Bytes that it holds on the device.
    bytes: u64,
    /// One entry per view.
    views: Vec<View>,
}

/// The median times of one view.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "GpuView")]
pub(crate) struct View {
    /// Name of the view.
    view: String,
    /// Frames that the medians are taken over.
    frames: usize,
    /// Milliseconds of the technique's passes together.
    milliseconds: f64,
    /// Name and milliseconds of each pass that took any.
    passes: Vec<(String, f64)>,
    /// Whether these are wall-clock times, because the device has no timestamps.
    wall_time: bool,
}

/// The results so far, and the time at which measuring ends.
struct Bench<'a> {
    args: &'a BenchGpu,
    gpu: Gpu,
    end: Instant,
    document: GpuResults,
}

pub(super) fn run(args: &BenchGpu) -> Result<Code> {
    make_folder(&args.output)?;
    let gpu = Gpu::request(&args.device.gpu_options())?;
    let document = GpuResults {
        adapter: gpu.name(),
        software: gpu.is_software(),
        size: args.size,
        frames: args.frames,
        seconds: args.seconds,
        sections: Vec::new(),
        left_out: Vec::new(),
    };
    let end = Instant::now() + Duration::from_secs(args.seconds);
    let mut bench = Bench { args, gpu, end, document };
    sections::measure(&mut bench)?;
    bench.write()?;
    super::say_tables(&args.output, &bench.name());
    Ok(Code::Fine)
}

impl Bench<'_> {
    /// Returns the name of the tables: `gpu-` and the adapter's name.
    fn name(&self) -> String {
        let adapter = self.document.adapter.split(" (").next().unwrap_or_default().to_lowercase();
        let words = adapter.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
        format!("gpu-{}", words.collect::<Vec<_>>().join("-"))
    }

    fn write(&self) -> Result<()> {
        super::write(&self.args.output, &self.name(), &tables::markdown(&self.document), &self.document)
    }

    /// Whether the time for measuring is over. If so, lists `what` as left out.
    fn is_over(&mut self, what: &str) -> bool {
        let over = Instant::now() >= self.end;
        if over {
            self.leave_out(what, format!("the {} s were over", self.args.seconds));
        }
        over
    }

    fn leave_out(&mut self, what: &str, reason: String) {
        adumbra_program::note!("{what}: left out: {reason}");
        self.document.left_out.push([what.to_owned(), reason]);
    }
}
