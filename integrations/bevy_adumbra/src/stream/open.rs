//! A streamed file that is open.

use adumbra::stream::Resident;
use adumbra::{LightGrid, Placement, Receivers};

use crate::components::BakedShadow;
use crate::error::BakedShadowError;
use crate::in_use::{FileInUse, look_up, way};
use crate::placing::turned;
use crate::texels::{PoolTexels, Texels};

/// A streamed file that is open.
pub(crate) struct OpenFile<'a> {
    pub(super) resident: &'a Resident,
    pub(super) pool: PoolTexels,
    pub(super) is_ready: bool,
    pub(super) grid: Option<LightGrid>,
    /// Unit vector towards the sun.
    pub(crate) towards_sun: [f64; 3],
}

impl OpenFile<'_> {
    /// Returns which receivers the file answers for.
    pub(crate) fn receivers(&self) -> Option<Receivers> {
        self.resident.settings().map(|settings| settings.receivers)
    }

    /// Returns the file in a place, with a light's settings.
    pub(crate) fn in_use(
        &self,
        placement: Placement,
        shadow: &BakedShadow,
    ) -> Result<FileInUse, BakedShadowError> {
        let header = self.resident.texture_headers(&look_up(shadow, placement));
        Ok(FileInUse {
            texels: Texels::Pool(self.pool),
            placement,
            grid: self.grid.map(|grid| grid.placed(&placement)),
            way: way(shadow),
            header: header.map_err(|error| BakedShadowError::Setting(error.into()))?,
            towards_sun: turned(&placement, self.towards_sun),
            is_ready: self.is_ready,
            march: None,
        })
    }
}
