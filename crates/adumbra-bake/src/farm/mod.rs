//! A bake in steps that many machines can share: a plan, its parts in any order, and the file that is linked
//! from them.
//!
//! | file | contents |
//! |---|---|
//! | `plan.rs` | what is to be baked: the grids, and the key and cost of each part |
//! | `stored.rs` | a plan as data |
//! | `parts.rs` | bakes parts, and keeps their entries |
//! | `link.rs` | makes the file from entries |
//!
//! Each step can be repeated, and ended at any moment: it does again what is missing. The file has the bytes
//! of a bake on one machine. Who bakes which part, and when, is left to a scheduler.

mod link;
mod parts;
mod plan;
mod stored;

pub(crate) use link::link_in_memory;
pub use parts::{BakedParts, PartBaker};
pub(crate) use plan::Prepared;
pub use plan::{BakePlan, PlannedPart};
