//! Arguments that concern the path of a sun.

use std::path::PathBuf;

use adumbra_solar::Day;

/// The path of a sun that is baked in place of one sun.
#[derive(clap::Args)]
pub(crate) struct PathArgs {
    /// Bake a day, with answers for any of its moments
    ///
    /// The file holds a few key suns, and look-ups march between them. DAY is a place, a date and hours by
    /// the local clock, such as lat=48,lon=11,date=2026-06-21,from=7,to=19. tz=Europe/Berlin or tz=+02:00 is
    /// its zone; without one, it is the whole hour nearest to the longitude. North is -Z, east is +X. The sun
    /// is where the standard atmosphere shows it; refraction=off leaves that out. Keys are in the oblique
    /// frame, and share their voxels.
    #[arg(
        long,
        value_name = "DAY",
        conflicts_with_all = ["sun", "azimuth", "elevation", "dry_run", "into", "watch", "regions", "cache", "bounds", "frame", "levels"]
    )]
    pub(crate) sun_path: Option<Day>,
    /// Bake a path of suns from a list
    ///
    /// A line each with time, azimuth and elevation. Times are seconds, or as in 2026-06-21T12:00:00+02:00,
    /// and ascend. Angles are in degrees. # begins a comment.
    #[arg(
        long,
        value_name = "FILE",
        conflicts_with_all = ["sun_path", "sun", "azimuth", "elevation", "dry_run", "into", "watch", "regions", "cache", "bounds", "frame", "levels"]
    )]
    pub(crate) suns: Option<PathBuf>,
    /// Path: how many points of a hundred may be wrong between two keys that a file of that very sun has
    /// right
    #[arg(long, value_name = "PERCENT", default_value_t = 0.1, hide_short_help = true)]
    pub(crate) path_error: f64,
    /// Path: the least elevation of a key; a lower sun is answered from the nearest one
    #[arg(long, value_name = "DEGREES", default_value_t = 3.0, hide_short_help = true)]
    pub(crate) lowest_sun: f64,
}

/// What is verified of a sun path.
#[derive(clap::Args)]
pub(crate) struct VerifyPathArgs {
    /// Sun path: every how many steps it is compared with rays
    #[arg(long, value_name = "STEPS", default_value_t = 15, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) every: u32,
    /// Sun path: how many points of a hundred may be wrong on the mean that the keys have right at their own
    /// suns
    #[arg(long, value_name = "PERCENT", default_value_t = 0.1)]
    pub(crate) max_excess: f64,
    /// Sun path: draw the errors over the day
    #[arg(long, value_name = "SVG")]
    pub(crate) plot: Option<PathBuf>,
}
