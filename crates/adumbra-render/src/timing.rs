//! Times of each stage of a frame: GPU timestamps if available, else the wall-clock time of the stage's
//! submission.

use wgpu::{BufferUsages, Features};

use crate::error::Result;
use crate::gpu::Gpu;
use crate::readback::read_buffer;

/// The stages of a frame, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Depth, normals and base colour.
    GBuffer,
    /// A technique's depth passes.
    Depth,
    /// What a technique derives from that depth before its look-up.
    Build,
    /// The look-up for every pixel.
    Lookup,
    /// A technique's screen-space passes.
    Screen,
    /// View depth, and normals if ambient occlusion computes its own.
    AmbientSurface,
    /// The estimator of ambient occlusion.
    AmbientEstimate,
    /// The mean of the estimate and earlier frames.
    AmbientHistory,
    /// The filter of the estimate, and upsampling to the frame's size.
    AmbientFilter,
    /// Composition of sun, sky, shadow and ambient occlusion.
    Composite,
}

const STAGES: usize = 10;
/// Bytes per stage in the resolve buffer. It holds the stage's two ticks; the size is the alignment that
/// resolving queries requires.
const RESOLVED_BYTES: u64 = wgpu::QUERY_RESOLVE_BUFFER_ALIGNMENT;

/// Times of a frame's stages, milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameTimes {
    /// Milliseconds, indexed by [`Stage`].
    pub milliseconds: [f64; STAGES],
    /// Whether these are wall-clock times, because the device has no timestamps or is a software adapter.
    pub wall_time: bool,
}

impl FrameTimes {
    /// Time of one stage, milliseconds.
    pub fn of(&self, stage: Stage) -> f64 {
        self.milliseconds[stage as usize]
    }

    /// Time of the shadow stages before the look-up, milliseconds: depth passes, and what is derived from
    /// them.
    pub fn before_lookup(&self) -> f64 {
        self.of(Stage::Depth) + self.of(Stage::Build)
    }

    /// Time of the shadows, milliseconds: depth passes, what is derived from them, look-up and screen-space
    /// passes.
    pub fn shadow(&self) -> f64 {
        self.before_lookup() + self.of(Stage::Lookup) + self.of(Stage::Screen)
    }

    /// Time of ambient occlusion, milliseconds.
    pub fn ambient(&self) -> f64 {
        use Stage::{AmbientEstimate, AmbientFilter, AmbientHistory, AmbientSurface};
        [AmbientSurface, AmbientEstimate, AmbientHistory, AmbientFilter]
            .map(|stage| self.of(stage))
            .iter()
            .sum()
    }

    /// Keeps only the times that do not depend on the technique: G-buffer and ambient occlusion.
    pub(crate) fn without_shadows(mut self) -> Self {
        for stage in [Stage::Depth, Stage::Build, Stage::Lookup, Stage::Screen, Stage::Composite] {
            self.milliseconds[stage as usize] = 0.0;
        }
        self
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.milliseconds.iter_mut().zip(other.milliseconds).for_each(|(sum, more)| *sum += more);
    }
}

/// Measures the stages of a frame.
pub(crate) struct StageTimer {
    queries: Option<(wgpu::QuerySet, wgpu::Buffer)>,
    wall: [f64; STAGES],
    encoded: [bool; STAGES],
}

impl StageTimer {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        // A software adapter does not write timestamps on the threads that do the work, so they are
        // unreliable.
        let has = gpu.has(Features::TIMESTAMP_QUERY | Features::TIMESTAMP_QUERY_INSIDE_ENCODERS)
            && !gpu.is_software();
        let queries = has.then(|| {
            let count = 2 * STAGES as u32;
            let bytes = STAGES * RESOLVED_BYTES as usize;
            let set = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("frame::times"),
                ty: wgpu::QueryType::Timestamp,
                count,
            });
            let usage = BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC;
            (set, gpu.buffer("frame::times", &vec![0; bytes], usage))
        });
        Self { queries, wall: [0.0; STAGES], encoded: [false; STAGES] }
    }

    /// Encodes and submits one stage, and waits for it if there are no timestamps.
    pub(crate) fn stage(
        &mut self,
        gpu: &Gpu,
        stage: Stage,
        encode: impl FnOnce(&mut wgpu::CommandEncoder),
    ) -> Result<()> {
        self.encoded[stage as usize] = true;
        let mut encoder = gpu.encoder("frame");
        let first = 2 * stage as u32;
        if let Some((set, _)) = &self.queries {
            encoder.write_timestamp(set, first);
            encode(&mut encoder);
            encoder.write_timestamp(set, first + 1);
            gpu.queue.submit([encoder.finish()]);
            return gpu.check();
        }
        encode(&mut encoder);
        let commands = encoder.finish();
        gpu.wait()?;
        let start = std::time::Instant::now();
        gpu.finish(commands)?;
        self.wall[stage as usize] = start.elapsed().as_secs_f64() * 1e3;
        Ok(())
    }

    /// Waits for the frame and returns its times; 0 for stages that were not encoded.
    pub(crate) fn finish(&self, gpu: &Gpu) -> Result<FrameTimes> {
        let Some((set, buffer)) = &self.queries else {
            return Ok(FrameTimes { milliseconds: self.wall, wall_time: true });
        };
        let mut encoder = gpu.encoder("frame::times");
        for stage in (0..STAGES).filter(|&s| self.encoded[s]) {
            let first = 2 * stage as u32;
            encoder.resolve_query_set(set, first..first + 2, buffer, stage as u64 * RESOLVED_BYTES);
        }
        gpu.queue.submit([encoder.finish()]);
        let bytes = read_buffer(gpu, buffer)?;
        let period = f64::from(gpu.queue.get_timestamp_period()) * 1e-6;
        let milliseconds = std::array::from_fn(|stage| {
            let ticks = bytes[stage * RESOLVED_BYTES as usize..].as_chunks::<8>().0;
            let [start, end] = [0, 1].map(|i| u64::from_le_bytes(ticks[i]));
            end.saturating_sub(start) as f64 * period
        });
        Ok(FrameTimes { milliseconds, wall_time: false })
    }
}
