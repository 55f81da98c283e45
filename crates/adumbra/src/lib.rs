//! Baked sun shadows of a static world: one look-up for any point in space, sharp at every distance.
//!
//! This crate reads files that a bake has written. It is the crate that an engine links. It opens a file
//! ([`ShadowFile`]), looks up points on the CPU ([`Sampler`]), and provides the words and parameters that a
//! shader needs ([`gpu`]). It depends on no graphics library, so it works with any version of any of them.
//! Files are baked by the crate `adumbra-bake` or by the program `adumbra`. A [`SunPath`] has the suns of a
//! day, and answers for any moment of it.
//!
//! Data flows one way: grid → layout → file → look-ups, [`gpu`] → regions, [`stream`] → sun paths. All
//! results have one polarity, *visibility*: 1 = unoccluded. Modules that the documentation hides are for the
//! project's own crates, such as the bake: they may change in any version. `docs/api.txt` lists the rest.
//!
//! ```no_run
//! use adumbra::{Filter, ShadowFile};
//!
//! let file = ShadowFile::read("city.adumbra")?;
//! let shadow = file.sampler(Filter::Box5);
//! println!("{}", shadow.visibility([10.0, 1.8, 4.0], Some([0.0, 1.0, 0.0])));
//! # Ok::<(), adumbra::Error>(())
//! ```

#![forbid(unsafe_code)]

mod coder;
mod error;
#[doc(hidden)]
pub mod file;
pub mod gpu;
#[doc(hidden)]
pub mod grid;
#[doc(hidden)]
pub mod layout;
mod path;
#[doc(hidden)]
pub mod query;
#[cfg(feature = "regions")]
pub mod regions;
mod settings;
pub mod stream;

pub use error::{Error, FormatError, IoError, RangeError, RangeField, Result};
pub use file::ShadowFile;
pub use grid::{Bounds, Frame, LightExtent, LightGrid, Placement, Region, Sun};
pub use path::{PathSampler, SunPath, SunStep};
pub use query::{Filter, PointVisibility, Sampler};
pub use settings::{Bias, Encoding, FileSettings, MAX_PLANE_SLOPE, MAX_SLOPE, Receivers};
