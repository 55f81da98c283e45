//! Files of any size within a budget of bytes: the parts that cameras see are read, and coarser levels answer
//! elsewhere.
//!
//! ```text
//!  cameras ──views──► Stream ──requests──► tasks that read and decode
//!                       │  ▲                  │
//!                       │  └────answers───────┘
//!                       └──writes──► PoolUploads ──extract──► the texture with words
//! ```

mod asset;
mod budget;
mod bytes;
mod counters;
mod drive;
mod file;
mod open;
mod streams;
mod views;

pub use budget::StreamBudget;
pub use counters::StreamDiagnostics;
pub(crate) use drive::{PoolUploads, drive_streams};
pub use streams::ShadowStreams;
