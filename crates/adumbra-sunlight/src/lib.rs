//! Hours of direct sun and the visible sky at points of a scene, by ray tracing.
//!
//! [`points`] finds the points: on the ground plan, on all surfaces, or from a table. [`hours`] finds for
//! every point the times of a day at which it sees the sun. [`sky`] finds the patches of the sky that it
//! sees. Both trace rays to the centre of the sun or patch with [`Tracer`](adumbra_truth::trace::Tracer), on
//! the current rayon pool. The same input gives the same answers for any number of threads.
//!
//! ```
//! use adumbra_sunlight::{Grid, Suns, Watch};
//! use adumbra_truth::trace::{TraceOptions, Tracer};
//!
//! let scene = adumbra_scene::generate(adumbra_scene::GeneratedKind::Primitives, 1);
//! let tracer = Tracer::build(&scene, TraceOptions::default());
//! let found = Grid::over(&[scene.bounds()], 1.0)?.receivers(&tracer)?;
//! let day: adumbra_solar::Day = "lat=48.14,lon=11.58,date=2026-06-21,from=7,to=19".parse()?;
//! let hours = Suns::new(&day.arcs()?).hours(&tracer, &found.receivers, Watch::none())?;
//! assert!((0..hours.len()).all(|point| hours.seconds(point) <= 12.0 * 3600.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod error;
pub mod hours;
pub mod points;
pub mod sky;

pub use adumbra_bake::{Progress, Watch};
pub use error::{Error, Result};
pub use hours::{Hours, Suns};
pub use points::{Grid, GridPoints, Receiver, read_csv, surface_points};
pub use sky::{Patches, SkyView, sky_views};
