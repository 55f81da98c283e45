//! What most apps need: `use bevy_adumbra::prelude::*;`.

pub use crate::AdumbraPlugin;
#[cfg(feature = "bake")]
pub use crate::bake::{BakeError, BakeProgress, BakeSettings, RuntimeBake, RuntimeBakeCommands};
pub use crate::components::{BakedShadow, ExcludeFromBake, FileRoot, ShadowBias, ShadowFilter, ShadowStatic};
pub use crate::error::BakedShadowError;
pub use crate::file::BakedShadowFile;
pub use crate::moving::SunKeys;
pub use crate::source::StreamSource;
pub use crate::status::{BakedShadowChanged, BakedShadowStatus};
pub use crate::stream::{ShadowStreams, StreamBudget};
pub use crate::systems::AdumbraSystems;
