//! Answers from a file of any size with a budget of bytes: pages are read where a camera needs them, and a
//! coarser level answers where they are missing. `spec/streaming.md` has the rules.
//!
//! ```text
//!  ShadowSource ──bytes──► Request::decode ──► Resident ──► PoolWrite ──► a buffer on the GPU
//!   file, memory, HTTP       any thread         decides        │
//!                                                              └────────► Vec<u32>, PoolSampler
//! ```
//!
//! [`Resident`] decides which bytes to read, holds the page tables, and does nothing slow, so it can run in
//! the frame loop. [`Streamer`] adds threads that read and decode. An engine that has its own threads or
//! futures runs [`Request`]s itself.
//!
//! ```no_run
//! use adumbra::Filter;
//! use adumbra::stream::{FileSource, StreamOptions, Streamer, View};
//!
//! let mut streamer = Streamer::new(FileSource::open("city.adumbra")?, StreamOptions::default());
//! let camera = View::perspective([10.0, 1.8, 4.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0], 60.0, [1280, 720]);
//! // Once per frame:
//! streamer.update(&[camera]);
//! for write in streamer.take_writes(1 << 18) {
//!     println!("{} words go to word {} of the buffer on the GPU", write.words.len(), write.at);
//! }
//! for fault in streamer.take_faults() {
//!     println!("{fault}");
//! }
//! if let Some(sampler) = streamer.sampler(Filter::Box5) {
//!     let answer = sampler.look_up(streamer.words(), [12.0, 0.0, 3.0], Some([0.0, 1.0, 0.0]));
//!     println!("{} from level {}", answer.visibility, answer.level);
//! }
//! # Ok::<(), adumbra::Error>(())
//! ```

mod choose;
mod decode;
mod open;
mod opening;
mod options;
mod pool;
mod request;
mod resident;
mod residents;
mod retry;
mod sampler;
mod source;
mod streamer;
mod view;

pub use options::{StreamCounts, StreamOptions};
pub use pool::PoolWrite;
pub use request::{Answer, Request};
pub use resident::Resident;
pub use retry::{StreamError, StreamFault};
pub use sampler::{LevelAnswer, PoolSampler};
pub use source::{BytesSource, FileSource, ShadowSource, SourceError};
pub use streamer::Streamer;
pub use view::View;
