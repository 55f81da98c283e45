//! `adumbra sun-hours` and `adumbra sky`: light at points of a scene.

mod csv;
mod format;
mod geotiff;
mod hours;
mod json;
mod page;
mod picture;
mod ply;
mod sky;
mod study;
mod traced;

pub(super) use hours::{SunHoursFound, run as hours};
pub(super) use json::{HoursFile, SkyFile};
pub(super) use sky::{SkyFound, run as sky};
