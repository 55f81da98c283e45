//! Arguments of `sun-hours` and `sky`.

use std::path::PathBuf;

use adumbra_program::args::{RunArgs, SceneArgs};
use adumbra_program::exit::Failure;
use adumbra_program::progress::Style;
use adumbra_solar::{Clock, Date, Day, Location, Zone};
use clap::ValueEnum;

/// The points at which light is measured.
#[derive(clap::Args)]
pub(crate) struct PointArgs {
    #[command(flatten)]
    pub(crate) places: PlaceArgs,
    /// How far points of --points that have a normal are lifted along it, world units
    ///
    /// Enough to clear the surface that they were measured on.
    #[arg(long, value_name = "LENGTH", default_value_t = 0.01, requires = "points")]
    pub(crate) lift: f64,
}

/// Where points are.
#[derive(clap::Args)]
#[group(required = true, multiple = false)]
pub(crate) struct PlaceArgs {
    /// Points from a table: x,y,z on each line, or x,y,z,nx,ny,nz for a point on a surface with that normal
    #[arg(long, value_name = "CSV")]
    pub(crate) points: Option<PathBuf>,
    /// Points on the ground plan: the first surface below the sky, at the middle of square cells of this side
    #[arg(long, value_name = "SPACING")]
    pub(crate) grid: Option<f64>,
    /// Points on all surfaces, walls too, one for each square of this side
    #[arg(long, value_name = "SPACING")]
    pub(crate) surfaces: Option<f64>,
}

/// A day by the clock of a place.
#[derive(clap::Args)]
pub(crate) struct DayArgs {
    /// Latitude, degrees, positive in the north
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    lat: f64,
    /// Longitude, degrees, positive in the east
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    lon: f64,
    /// Date, such as 2026-06-21
    #[arg(long)]
    pub(crate) date: Date,
    /// Start by the local clock, such as 7 or 07:30
    #[arg(long, value_name = "TIME")]
    pub(crate) from: Clock,
    /// End by the local clock; before the start, it is on the next day, and 24 is the end of the day
    #[arg(long, value_name = "TIME")]
    pub(crate) to: Clock,
    /// Time zone of the clock: an IANA name such as Europe/Berlin, or an offset such as +02:00 [default: the
    /// nautical zone, the whole hour nearest to the longitude]
    #[arg(long, value_name = "ZONE", allow_hyphen_values = true)]
    pub(crate) tz: Option<Zone>,
    /// Leave out that the air bends light: by default 1013.25 hPa and 15 °C lift the sun
    #[arg(long)]
    no_refraction: bool,
}

impl DayArgs {
    /// Returns the day.
    pub(crate) fn day(&self) -> Result<Day, Failure> {
        let location = Location::new(self.lat, self.lon, 0.0);
        let location = location.map_err(|error| Failure::Usage(format!("{error} (--lat, --lon)")))?;
        let day = Day::new(location, self.date, self.from, self.to);
        let atmosphere = day.atmosphere.filter(|_| !self.no_refraction);
        Ok(Day { zone: self.tz.clone(), atmosphere, ..day })
    }
}

#[derive(clap::Args)]
pub(crate) struct SunHours {
    /// Scene: .glb, .gltf, .obj or .ply; north is -Z, east +X
    pub(crate) scene: PathBuf,
    #[command(flatten)]
    pub(crate) points: PointArgs,
    #[command(flatten)]
    pub(crate) day: DayArgs,
    /// Another design of the same place, for a page that compares both
    #[arg(long, value_name = "SCENE", requires = "grid")]
    pub(crate) compare: Option<PathBuf>,
    /// The files to write, each by its suffix: .csv, .ply or .json, and with --grid .png, .tif or .html
    #[arg(short, long, value_name = "FILE", required = true)]
    pub(crate) output: Vec<PathBuf>,
    /// Coordinate system of the .tif, a projected one in the scene's unit, by its EPSG number
    #[arg(long, value_name = "NUMBER", requires = "grid", value_parser = clap::value_parser!(u16).range(1024..=32766))]
    pub(crate) epsg: Option<u16>,
    /// Easting and northing of the scene's origin in the .tif
    #[arg(long, value_name = "E,N", requires = "grid", allow_hyphen_values = true, default_value = "0,0", value_parser = parse_pair)]
    pub(crate) origin: [f64; 2],
    /// How to show progress
    #[arg(long, value_enum, default_value = "auto")]
    pub(crate) progress: Style,
    #[command(flatten)]
    pub(crate) load: SceneArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

/// A division of the sky.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum SkyPatches {
    /// Tregenza's patches
    #[value(name = "145")]
    Tregenza,
    /// Reinhart's patches, a quarter as large
    #[value(name = "577")]
    Reinhart,
}

#[derive(clap::Args)]
pub(crate) struct Sky {
    /// Scene: .glb, .gltf, .obj or .ply; north is -Z, east +X
    pub(crate) scene: PathBuf,
    #[command(flatten)]
    pub(crate) points: PointArgs,
    /// Patches of the sky
    #[arg(long, value_enum, default_value = "145")]
    pub(crate) patches: SkyPatches,
    /// The files to write, each by its suffix: .csv or .json
    #[arg(short, long, value_name = "FILE", required = true)]
    pub(crate) output: Vec<PathBuf>,
    /// How to show progress
    #[arg(long, value_enum, default_value = "auto")]
    pub(crate) progress: Style,
    #[command(flatten)]
    pub(crate) load: SceneArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

fn parse_pair(text: &str) -> Result<[f64; 2], String> {
    let numbers: Vec<f64> = text.split(',').filter_map(|n| n.trim().parse().ok()).collect();
    match numbers[..] {
        [e, n] if text.split(',').count() == 2 && e.is_finite() && n.is_finite() => Ok([e, n]),
        _ => Err("give two numbers, such as 691000,5334000".to_owned()),
    }
}
