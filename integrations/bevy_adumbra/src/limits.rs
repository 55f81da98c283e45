//! Limits of the device.

use bevy::ecs::prelude::*;
use bevy::reflect::prelude::*;
use bevy::render::renderer::RenderDevice;

/// Limits of the device for files in use. A resource of the main world and of the render world. It keeps its
/// default in an app without a device, and until plugins finish, when the device is known.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Resource, Default, Clone, Debug, PartialEq)]
pub struct DeviceLimits {
    /// The largest number of texels along a side of a texture.
    pub max_texture_side: u32,
}

/// The limits that every device supports.
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
