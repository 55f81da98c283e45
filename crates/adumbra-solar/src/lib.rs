//! The position of the sun at a place and a time.
//!
//! [`position`] computes azimuth and elevation with NREL's Solar Position Algorithm (Reda, Andreas, *Solar
//! Position Algorithm for Solar Radiation Applications*, NREL/TP-560-34302, 2008), as implemented by the
//! crate `solar-positioning`. Its error is below 0.001° in the centuries around ours. [`Day`] is a span of a
//! day by the local clock: it gives one [`SunStep`] for each minute, or for any other step, and the
//! [`SunArc`]s in which the sun is up. [`read_suns`]
//! reads such steps from text. Trigonometry is `libm`'s and time zones are bundled, so the results are the
//! same on any machine.
//!
//! *Axes.* North is −Z, east is +X and up is +Y, as for [`Sun::from_angles`](adumbra::Sun::from_angles).
//!
//! *Refraction.* The atmosphere lifts the sun by half a degree at the horizon and by a hundredth at 80°. By
//! default, this is a standard atmosphere of 1013.25 hPa and 15 °C; it can be replaced or disabled. Suns more
//! than 50' below the horizon are not lifted.
//!
//! ```
//! use adumbra_solar::Day;
//!
//! let day: Day = "lat=48.14,lon=11.58,date=2026-06-21,from=7,to=19,tz=Europe/Berlin".parse()?;
//! let steps = day.steps()?;
//! assert_eq!(steps.len(), 12 * 60 + 1);
//! assert!(steps.iter().all(|step| step.sun.is_some()));
//! # Ok::<(), adumbra_solar::Error>(())
//! ```

mod arcs;
mod clock;
mod day;
mod error;
mod list;
mod location;
mod parse;
mod position;
mod zone;

pub use arcs::{ARC_STEP_SECONDS, SunArc, sun_arcs};
pub use clock::{Clock, Date};
pub use day::{Day, SunStep};
pub use error::{Error, Result};
pub use list::read_suns;
pub use location::Location;
pub use position::{Atmosphere, Position, position, positions};
pub use zone::Zone;
