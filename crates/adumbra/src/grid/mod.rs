//! The sun of a bake, and the placement of its grid in the world.
//!
//! All values are computed with additions, products, quotients and square roots of `f64`, and with `libm`'s
//! sine and cosine, so that results are bit-identical on all machines.

mod bounds;
mod frame;
mod light_grid;
mod placement;
mod region;
mod sun;
pub mod vec3;

pub use bounds::Bounds;
pub use frame::Frame;
pub use light_grid::{LightExtent, LightGrid};
pub use placement::Placement;
pub use region::Region;
pub use sun::Sun;
