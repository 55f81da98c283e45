//! `adumbra plan`, `tile` and `link`: a bake in steps that many machines can share.

mod export;
mod link;
mod plan;
mod plan_file;
mod tile;

pub(super) use link::Linked;
pub(crate) use link::run as link;
pub(super) use plan::Planned;
pub(crate) use plan::run as plan;
pub(super) use tile::Tiled;
pub(crate) use tile::run as tile;
