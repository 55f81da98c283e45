//! Points as JSON.

use std::fmt::Write as _;
use std::path::Path;

use adumbra_sunlight::{Patches, Receiver, SkyView};
use schemars::JsonSchema;
use serde::Serialize;

use super::traced::Traced;

/// A file of `sun-hours`.
#[derive(Serialize, JsonSchema)]
pub(in crate::cmd) struct HoursFile {
    /// The scene's file.
    scene: String,
    /// Latitude, degrees, positive in the north.
    latitude_degrees: f64,
    /// Longitude, degrees, positive in the east.
    longitude_degrees: f64,
    /// The date on which the span begins.
    date: String,
    /// Start by the local clock.
    from: String,
    /// End by the local clock.
    to: String,
    /// Time zone of the clock: an IANA name, or an offset.
    time_zone: String,
    /// Whether the air bends light.
    refraction: bool,
    /// How long the sun is above the horizon, hours.
    most_hours: f64,
    /// The points, in the order of the table, of the grid's rows from north to south, or of the scene's
    /// surfaces.
    points: Vec<PointHours>,
}

/// A point and its hours.
#[derive(Serialize, JsonSchema)]
struct PointHours {
    /// World position.
    position: [f64; 3],
    /// Unit normal. Null for a point in space.
    normal: Option<[f64; 3]>,
    /// How long it sees the sun, hours.
    hours: f64,
    /// Start and end of each span in which it sees the sun, seconds after 1970-01-01T00:00Z.
    intervals: Vec<[f64; 2]>,
}

impl HoursFile {
    pub(super) fn new(scene: &Path, traced: &Traced) -> Self {
        let day = &traced.day;
        let points = traced.receivers().map(|(number, point)| PointHours {
            position: point.p_world,
            normal: point.normal(),
            hours: traced.hours_of(number),
            intervals: traced.hours.spans(number).to_vec(),
        });
        Self {
            scene: scene.display().to_string(),
            latitude_degrees: day.location.latitude_degrees(),
            longitude_degrees: day.location.longitude_degrees(),
            date: day.date.to_string(),
            from: day.from.to_string(),
            to: day.to.to_string(),
            time_zone: traced.zone.name().to_owned(),
            refraction: day.atmosphere.is_some(),
            most_hours: traced.most_hours,
            points: points.collect(),
        }
    }
}

/// A file of `sky`.
#[derive(Serialize, JsonSchema)]
pub(in crate::cmd) struct SkyFile {
    /// The scene's file.
    scene: String,
    /// Unit vectors towards the middles of the patches, from the horizon up, and in each row clockwise from
    /// north.
    patch_centers: Vec<[f64; 3]>,
    /// Solid angles of the patches, steradians.
    patch_solid_angles: Vec<f64>,
    /// The points, in the order of the table, of the grid's rows from north to south, or of the scene's
    /// surfaces.
    points: Vec<PointSky>,
}

/// A point and its sky.
#[derive(Serialize, JsonSchema)]
struct PointSky {
    /// World position.
    position: [f64; 3],
    /// Unit normal. Null for a point in space.
    normal: Option<[f64; 3]>,
    /// Share of the light of an evenly bright sky that arrives, 0 to 1.
    sky_view_factor: f64,
    /// Share of the sky's solid angle that is hidden, 0 to 1.
    shade_fraction: f64,
    /// A bit for each patch, 1 if it is seen: bytes as two hexadecimal digits each, whose lowest bit is the
    /// first patch.
    patches: String,
}

impl SkyFile {
    pub(super) fn new(scene: &Path, patches: &Patches, receivers: &[Receiver], views: &[SkyView]) -> Self {
        let points = receivers.iter().zip(views).map(|(point, view)| PointSky {
            position: point.p_world,
            normal: point.normal(),
            sky_view_factor: view.sky_view_factor,
            shade_fraction: view.shade_fraction,
            patches: hex(&view.bits),
        });
        Self {
            scene: scene.display().to_string(),
            patch_centers: patches.centers().to_vec(),
            patch_solid_angles: patches.solid_angles().to_vec(),
            points: points.collect(),
        }
    }
}

/// Bytes as two hexadecimal digits each.
pub(super) fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a String does not fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}
