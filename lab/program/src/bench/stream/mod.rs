//! `adumbra-lab bench stream`: a flight through a streamed file, compared with rays.
//!
//! The camera flies for some frames at 60 per second, as an engine would: it passes its view to the stream,
//! takes uploads within a budget, and never waits. In every frame, the level that answers at some visible
//! points is compared with the level that they need. At rest, the answers are compared with rays and with the
//! answers of the whole file. The source delays each answer as a server would.

mod flight;
mod source;

use std::time::{Duration, Instant};

use adumbra::stream::{FileSource, StreamCounts, StreamOptions, Streamer, View};
use adumbra::{Filter, ShadowFile};
use adumbra_compare::Result;
use adumbra_compare::truth::TruthTracer;
use adumbra_html::plot::{Along, Legend, Panel, Series, write_svg};
use adumbra_program::exit::{Code, Failure};
use adumbra_program::output::{make_folder, note_input};
use adumbra_program::scene::load_scene;
use adumbra_render::voxel::view_of;
use adumbra_scene::LoadOptions;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use self::flight::{Flight, SeenPoint};
use self::source::Delayed;
use crate::args::BenchStream;

const FRAME: Duration = Duration::from_nanos(16_666_667);
/// Time limit for the stream to settle while the camera is at rest.
const LIMIT: Duration = Duration::from_secs(30);
/// Places along the flight at which answers are compared with rays.
const STOPS: usize = 6;

/// All results of one file.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct StreamResults {
    /// Name of the scene.
    scene: String,
    /// Texels along the longest side.
    resolution: u32,
    /// Bytes of the file.
    file_bytes: u64,
    /// Bytes of the pool.
    budget_bytes: u64,
    /// Milliseconds before a request is answered.
    latency_ms: u64,
    /// What the first picture took.
    first: Opening,
    /// What full sharpness at the first camera took.
    sharp: Opening,
    /// One row per frame.
    frames: Vec<FrameRow>,
    /// From the end of the flight until everything was as sharp as wanted, seconds.
    rest_seconds: f64,
    /// Share of the pixels that a coarser level than wanted answers, at rest after the flight, percent.
    coarser_at_rest_percent: f64,
    /// Bytes and requests of the whole flight.
    counts: Counted,
    /// Longest and median time that a frame gave to streaming, milliseconds.
    frame_ms: [f64; 2],
    /// Comparisons with rays, at rest.
    stops: Vec<Stop>,
}

/// What it took to get somewhere.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
struct Opening {
    requests: u64,
    bytes: u64,
    /// Share of the file, percent.
    percent: f64,
    seconds: f64,
}

/// What a stream has read.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
struct Counted {
    requests: u64,
    bytes: u64,
    resident_bytes: u64,
}

/// A frame of the flight.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
struct FrameRow {
    /// Share of the pixels that a coarser level than wanted answers, percent.
    coarser_percent: f64,
    /// Bytes of the pool in use.
    resident_bytes: u64,
    /// Bytes that were read until then.
    read_bytes: u64,
}

/// Answers at one place, with everything resident that it needs.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
struct Stop {
    frame: usize,
    /// Visible points that face the sun.
    points: usize,
    /// Those whose answer is on the other side of one half than the rays', from the stream and from the whole
    /// file.
    wrong: usize,
    wrong_of_whole_file: usize,
    /// Those whose answers from stream and file are the same.
    equal: usize,
}

pub(super) fn run(args: &BenchStream) -> Result<Code> {
    make_folder(&args.output)?;
    note_input("scene", &args.scene);
    note_input("shadow file", &args.file);
    let scene = load_scene(&args.scene, &LoadOptions::default())?;
    let name = args.scene.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let whole = ShadowFile::read(&args.file)?;
    let tracer = TruthTracer::build(&scene, false);
    let flight = Flight::new(&tracer, &whole, args)?;
    let document = measure(args, &tracer, &whole, &flight, name)?;
    let name = format!("stream-{}", document.scene);
    super::write(&args.output, &name, &markdown(&document), &document)?;
    write_svg(&args.output.join(format!("{name}.svg")), &panels(&document))?;
    super::say_tables(&args.output, &name);
    Ok(Code::Fine)
}

/// Opens the file with the latency of a server.
fn open(args: &BenchStream) -> Result<Streamer> {
    let options = StreamOptions { budget_bytes: args.budget << 20, ..StreamOptions::default() };
    let latency = Duration::from_millis(args.latency);
    Ok(Streamer::new(Delayed::new(FileSource::open(&args.file)?, latency), options))
}

fn opening(begun: Instant, counts: StreamCounts) -> Opening {
    let StreamCounts { requests, bytes, file_bytes, .. } = counts;
    let percent = 100.0 * bytes as f64 / file_bytes.max(1) as f64;
    Opening { requests, bytes, percent, seconds: begun.elapsed().as_secs_f64() }
}

fn not_settled(what: &str, counts: StreamCounts) -> Failure {
    Failure::BadInput(format!("{what} took more than {} s: {counts:?}", LIMIT.as_secs()))
}

fn measure(
    args: &BenchStream,
    tracer: &TruthTracer<'_>,
    whole: &ShadowFile,
    flight: &Flight,
    scene: String,
) -> Result<StreamResults> {
    let views: Vec<View> = flight.cameras.iter().map(view_of).collect();
    // Measure the cost of the first picture and of full sharpness, starting with an empty stream.
    let begun = Instant::now();
    let mut streamer = open(args)?;
    if !streamer.settle(&[], LIMIT, |_| ()) {
        return Err(not_settled("the first picture", streamer.counts()).into());
    }
    let first = opening(begun, streamer.counts());
    if !streamer.settle(&views[..1], LIMIT, |_| ()) {
        return Err(not_settled("sharpness", streamer.counts()).into());
    }
    let sharp = opening(begun, streamer.counts());

    let mut streamer = open(args)?;
    if !streamer.settle(&[], LIMIT, |_| ()) {
        return Err(not_settled("the first picture", streamer.counts()).into());
    }
    let mut frames = Vec::new();
    let mut times_ms = Vec::new();
    for (view, seen) in views.iter().zip(&flight.seen) {
        let begun = Instant::now();
        streamer.update(std::slice::from_ref(view));
        streamer.take_writes(args.upload << 10);
        times_ms.push(1e3 * begun.elapsed().as_secs_f64());
        let counts = streamer.counts();
        if counts.resident_bytes > budget_bytes_of(args) {
            let what = format!("the pool has {} bytes, above its budget", counts.resident_bytes);
            return Err(Failure::BadInput(what).into());
        }
        frames.push(FrameRow {
            coarser_percent: coarser_percent(&streamer, seen),
            resident_bytes: counts.resident_bytes,
            read_bytes: counts.bytes,
        });
        std::thread::sleep(FRAME.saturating_sub(begun.elapsed()));
    }
    let last = views.len() - 1;
    let begun = Instant::now();
    while coarser_percent(&streamer, &flight.seen[last]) > 0.0 && begun.elapsed() < LIMIT {
        let frame = Instant::now();
        streamer.update(&views[last..]);
        streamer.take_writes(args.upload << 10);
        std::thread::sleep(FRAME.saturating_sub(frame.elapsed()));
    }
    let rest_seconds = begun.elapsed().as_secs_f64();
    let coarser_at_rest_percent = coarser_percent(&streamer, &flight.seen[last]);
    let StreamCounts { requests, bytes, resident_bytes, .. } = streamer.counts();

    let mut stops = Vec::new();
    for stop in 0..STOPS {
        let frame = stop * last / (STOPS - 1);
        if !streamer.settle(&views[frame..=frame], LIMIT, |_| ()) {
            return Err(not_settled("a stop", streamer.counts()).into());
        }
        stops.push(compare(&streamer, tracer, whole, flight, frame));
    }
    let longest_ms = times_ms.iter().copied().fold(0.0, f64::max);
    times_ms.sort_by(f64::total_cmp);
    Ok(StreamResults {
        scene,
        resolution: whole.settings.resolution,
        file_bytes: streamer.counts().file_bytes,
        budget_bytes: budget_bytes_of(args),
        latency_ms: args.latency,
        first,
        sharp,
        frames,
        rest_seconds,
        coarser_at_rest_percent,
        counts: Counted { requests, bytes, resident_bytes },
        frame_ms: [longest_ms, times_ms[times_ms.len() / 2]],
        stops,
    })
}

fn budget_bytes_of(args: &BenchStream) -> u64 {
    args.budget << 20
}

/// Returns the percentage of points whose answer comes from a coarser level than wanted.
fn coarser_percent(streamer: &Streamer, seen: &[SeenPoint]) -> f64 {
    let Some(sampler) = streamer.sampler(Filter::Box5) else { return 100.0 };
    let coarser = seen.iter().filter(|point| {
        sampler.look_up(streamer.words(), point.p_world, Some(point.normal)).level > point.wanted_level
    });
    100.0 * coarser.count() as f64 / seen.len().max(1) as f64
}

/// Compares the answers at a frame with rays and with the whole file.
fn compare(
    streamer: &Streamer,
    tracer: &TruthTracer<'_>,
    whole: &ShadowFile,
    flight: &Flight,
    frame: usize,
) -> Stop {
    let towards = whole.sun().towards();
    let of_file = whole.sampler(Filter::Box5);
    let Some(of_stream) = streamer.sampler(Filter::Box5) else {
        return Stop { frame, points: 0, wrong: 0, wrong_of_whole_file: 0, equal: 0 };
    };
    let points = flight.points(tracer, frame);
    let words = streamer.words();
    let judge = |point: &SeenPoint| {
        let truth = tracer.tracer().sun_visible(point.lifted, towards);
        let stream = of_stream.look_up(words, point.p_world, Some(point.normal)).visibility;
        let file = of_file.visibility(point.p_world, Some(point.normal));
        [(stream >= 0.5) != truth, (file >= 0.5) != truth, stream == file]
    };
    let counts = points
        .par_iter()
        .map(judge)
        .fold(|| [0; 3], |sums: [usize; 3], found| [0, 1, 2].map(|i| sums[i] + usize::from(found[i])));
    let [wrong, wrong_of_whole_file, equal] = counts.reduce(|| [0; 3], |a, b| [0, 1, 2].map(|i| a[i] + b[i]));
    Stop { frame, points: points.len(), wrong, wrong_of_whole_file, equal }
}

fn markdown(document: &StreamResults) -> String {
    let StreamResults {
        scene, resolution, first, sharp, frames, counts, frame_ms: [longest, median], ..
    } = document;
    let mega = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    let mean = frames.iter().map(|f| f.coarser_percent).sum::<f64>() / frames.len().max(1) as f64;
    let worst = frames.iter().map(|f| f.coarser_percent).fold(0.0, f64::max);
    let mut text = format!(
        "# Streaming {scene} at {resolution}\n\nA file of {:.1} MiB, a pool of {:.0} MiB, {} ms before each answer. {} \
         frames at 60 per second.\n\n| what | requests | MiB | share of the file | seconds |\n|---|---|---|---|---|\n",
        mega(document.file_bytes),
        mega(document.budget_bytes),
        document.latency_ms,
        frames.len(),
    );
    for (what, opening) in [("first picture", first), ("as sharp as wanted at the first camera", sharp)] {
        let Opening { requests, bytes, percent, seconds } = opening;
        text += &format!("| {what} | {requests} | {:.2} | {percent:.2} % | {seconds:.2} |\n", mega(*bytes));
    }
    text += &format!(
        "| whole flight | {} | {:.2} | {:.2} % | |\n\nPixels that a coarser level than wanted answers: {mean:.2} % of the \
         flight, {worst:.1} % at worst, {:.2} % at rest, {:.2} s after the last frame. Pool: {:.1} MiB at the end. \
         Streaming took {median:.2} ms of a frame, {longest:.2} ms at most.\n\n\
         | frame | points | wrong | wrong, whole file | same answer |\n|---|---|---|---|---|\n",
        counts.requests,
        mega(counts.bytes),
        100.0 * counts.bytes as f64 / document.file_bytes.max(1) as f64,
        document.coarser_at_rest_percent,
        document.rest_seconds,
        mega(counts.resident_bytes),
    );
    for stop in &document.stops {
        let percent = |n: usize| 100.0 * n as f64 / stop.points.max(1) as f64;
        text += &format!(
            "| {} | {} | {:.3} % | {:.3} % | {:.2} % |\n",
            stop.frame,
            stop.points,
            percent(stop.wrong),
            percent(stop.wrong_of_whole_file),
            percent(stop.equal),
        );
    }
    text
}

fn panels(document: &StreamResults) -> Vec<Panel> {
    let panel = |title: &str, y_label, name: &str, value: &dyn Fn(&FrameRow) -> f64| Panel {
        title: title.to_owned(),
        along: Along::Numbers("frame"),
        y_label,
        logarithmic: false,
        legend: Legend::UpperRight,
        series: vec![Series {
            name: name.to_owned(),
            points: document.frames.iter().enumerate().map(|(i, f)| (i as f64, value(f))).collect(),
        }],
    };
    let mega = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    vec![
        panel("Pixels coarser than wanted", "percent", &document.scene, &|f| f.coarser_percent),
        panel("Bytes read", "MiB", &document.scene, &|f| mega(f.read_bytes)),
    ]
}
