//! Baked sun shadows of a static world: one look-up for any point in space, sharp at every distance.
//!
//! This crate reads what a bake has written, and is the one that an engine links. It opens a file ([`ShadowFile`]),
//! looks up points on the CPU ([`Query`]), and provides the words and parameters that a shader needs ([`gpu`]). It
//! depends on no graphics library, so it works with any version of any of them. Files are baked by the crate
//! `adumbra-bake` or by the program `adumbra`.
//!
//! Data flows one way: [`grid`] → [`layout`] → [`mod@file`] → [`query`] and [`gpu`]. All results have one polarity,
//! *visibility*: 1 = unoccluded.
//!
//! ```no_run
//! use adumbra::{Query, ShadowFile};
//!
//! let file = ShadowFile::read("city.adumbra")?;
//! let query = Query::new(&file.grid, file.leaf_masks(), file.settings.bias, 5)?;
//! println!("{}", query.visibility([10.0, 1.8, 4.0], Some([0.0, 1.0, 0.0])));
//! # Ok::<(), adumbra::Error>(())
//! ```

mod error;
pub mod file;
pub mod gpu;
pub mod grid;
pub mod layout;
pub mod query;
mod settings;

pub use error::{Error, FormatError, IoError, RangeError, RangeField, Result};
pub use file::{Layout, LightBody, ShadowFile};
pub use grid::{Bounds, Frame, LightExtent, LightGrid, Sun};
pub use query::{Cursor, PointVisibility, Query};
pub use settings::{Bias, FileSettings, MAX_PLANE_SLOPE, MAX_SLOPE, Receivers};
