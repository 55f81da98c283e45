//! What the device allows.

use bevy::ecs::prelude::*;
use bevy::reflect::prelude::*;
use bevy::render::renderer::RenderDevice;

/// What the device allows of files in use. A resource of the main world and of the render world. It has its default in an
/// app without a device, and before the device is known, which is when plugins finish.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Resource, Default, Clone, Debug, PartialEq)]
pub struct DeviceLimits {
    /// The largest number of texels along a side of a texture.
    pub max_texture_side: u32,
}

/// What every device allows.
impl Default for DeviceLimits {
    fn default() -> Self {
        Self { max_texture_side: 8192 }
    }
}

impl From<&RenderDevice> for DeviceLimits {
    fn from(device: &RenderDevice) -> Self {
        Self { max_texture_side: device.limits().max_texture_dimension_2d }
    }
}
