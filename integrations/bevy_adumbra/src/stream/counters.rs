//! Counters of streams among an app's diagnostics.

use std::time::Instant;

use adumbra::stream::StreamCounts;
use bevy::app::App;
use bevy::diagnostic::{Diagnostic, DiagnosticPath, Diagnostics, RegisterDiagnostic};

/// Paths of the counters of all streamed files together, in Bevy's `DiagnosticsStore`.
#[derive(Clone, Copy, Debug)]
pub struct StreamDiagnostics;

impl StreamDiagnostics {
    /// Bytes of textures that are in use.
    pub const RESIDENT_BYTES: DiagnosticPath = DiagnosticPath::const_new("adumbra/resident_bytes");
    /// Bytes that have been read.
    pub const READ_BYTES: DiagnosticPath = DiagnosticPath::const_new("adumbra/read_bytes");
    /// Requests that have been answered.
    pub const REQUESTS: DiagnosticPath = DiagnosticPath::const_new("adumbra/requests");
    /// Bundles that cameras need, and that are not resident yet.
    pub const MISSING_BUNDLES: DiagnosticPath = DiagnosticPath::const_new("adumbra/missing_bundles");
    /// Bytes that a frame writes to textures.
    pub const UPLOAD_BYTES: DiagnosticPath = DiagnosticPath::const_new("adumbra/upload_bytes");
    /// Time of the system in the main world, milliseconds.
    pub const MAIN_TIME: DiagnosticPath = DiagnosticPath::const_new("adumbra/main_time");

    pub(crate) fn register(app: &mut App) {
        for (path, suffix) in [
            (Self::RESIDENT_BYTES, " B"),
            (Self::READ_BYTES, " B"),
            (Self::REQUESTS, ""),
            (Self::MISSING_BUNDLES, ""),
            (Self::UPLOAD_BYTES, " B"),
            (Self::MAIN_TIME, " ms"),
        ] {
            app.register_diagnostic(Diagnostic::new(path).with_suffix(suffix));
        }
    }

    /// Adds the measurements of a frame that began at `start`.
    pub(super) fn add(diagnostics: &mut Diagnostics, counts: &[StreamCounts], uploaded: u64, start: Instant) {
        let sum = |of: fn(&StreamCounts) -> u64| counts.iter().map(of).sum::<u64>() as f64;
        diagnostics.add_measurement(&Self::RESIDENT_BYTES, || sum(|c| c.resident_bytes));
        diagnostics.add_measurement(&Self::READ_BYTES, || sum(|c| c.bytes));
        diagnostics.add_measurement(&Self::REQUESTS, || sum(|c| c.requests));
        diagnostics.add_measurement(&Self::MISSING_BUNDLES, || sum(|c| c.missing_bundles.into()));
        diagnostics.add_measurement(&Self::UPLOAD_BYTES, || uploaded as f64);
        diagnostics.add_measurement(&Self::MAIN_TIME, || 1e3 * start.elapsed().as_secs_f64());
    }
}
