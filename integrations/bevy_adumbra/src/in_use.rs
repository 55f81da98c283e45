//! The files in use in an app, and how a light's files are added to them.

use std::iter::once;

use adumbra::gpu::{LookUp, Penumbra};
use adumbra::{LightGrid, Placement};
use bevy::ecs::entity::EntityHashSet;
use bevy::ecs::prelude::*;
use bevy::math::{UVec2, Vec3};

use crate::components::BakedShadow;
use crate::error::BakedShadowError;
use crate::layout::Layout;
use crate::placing::turned;
use crate::shaders::Way;
use crate::texels::{PoolTexels, Texels};
use crate::{BakedShadowFile, DeviceLimits};

/// Largest number of files in use at once.
pub(crate) const MAX_FILES: usize = 8;

/// A light matches a file's sun if the distance between their unit vectors is at most this, 0.05 degrees.
const SAME_SUN: f32 = 1e-3;

/// A file that is in use.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FileInUse {
    pub(crate) texels: Texels,
    /// Where the app has placed the file's world.
    pub(crate) placement: Placement,
    /// Its grid there. `None` for a slot of a moving sun that does not answer.
    pub(crate) grid: Option<LightGrid>,
    pub(crate) way: Way,
    /// The first texels: the headers of a look-up texture, with the light's filter and bias.
    pub(crate) header: Vec<u8>,
    pub(crate) towards_sun: Vec3,
    /// Whether every point has an answer. Otherwise the texture has room for the file, but the file is not
    /// looked up.
    pub(crate) is_ready: bool,
    /// For a key of a moving sun: the march towards that sun.
    pub(crate) march: Option<March>,
}

/// The march through a key towards a sun that differs from the key's sun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct March {
    /// Sideways texels per voxel towards the sun, in units of 2^-16.
    pub(crate) slope: [i32; 2],
    /// The key that is looked up where this key has no answer.
    pub(crate) other: PoolTexels,
}

impl FileInUse {
    /// A whole file in a place, with a light's settings.
    pub(crate) fn whole(
        file: &BakedShadowFile,
        placement: Placement,
        shadow: &BakedShadow,
    ) -> Result<Self, BakedShadowError> {
        let texture = file.texture().map_err(|error| BakedShadowError::File(error.clone()))?;
        let header = file.file().gpu().texture_header(&look_up(shadow, placement));
        Ok(Self {
            texels: Texels::Whole(texture.clone()),
            placement,
            grid: Some(file.grid().placed(&placement)),
            way: way(shadow),
            header: header.map_err(|error| BakedShadowError::Setting(error.into()))?,
            towards_sun: turned(&placement, file.file().sun().towards()),
            is_ready: true,
            march: None,
        })
    }

    /// Whether a point is inside of the file.
    pub(crate) fn contains(&self, p_world: Vec3) -> bool {
        self.grid.is_some_and(|grid| {
            let p = grid.to_grid(p_world.to_array().map(f64::from));
            p.iter().zip(grid.size).all(|(&p, size)| p >= 0.0 && p < f64::from(size))
        })
    }

    /// Whether no other file that is looked up has this sun.
    pub(crate) fn is_alone(&self, all: &[Self]) -> bool {
        let same_sun =
            |other: &&Self| other.is_ready && other.towards_sun.distance(self.towards_sun) <= 2.0 * SAME_SUN;
        all.iter().filter(same_sun).count() == 1
    }
}

/// Returns the look-up settings of a light for a file in this place.
pub(crate) fn look_up(shadow: &BakedShadow, placement: Placement) -> LookUp {
    let penumbra =
        shadow.sun_degrees.map(|angle| Penumbra { sun_degrees: angle.into(), ..Penumbra::default() });
    LookUp { filter: shadow.filter.into(), bias: shadow.bias.map(Into::into), penumbra, placement }
}

/// Returns the way in which a light's files are looked up.
pub(crate) fn way(shadow: &BakedShadow) -> Way {
    match shadow {
        BakedShadow { follow: true, .. } => Way::March,
        BakedShadow { sun_degrees: Some(_), .. } => Way::Soft,
        _ => Way::Filtered,
    }
}

/// The files in use.
#[derive(Resource, Default, PartialEq)]
pub(crate) struct FilesInUse {
    /// For the render world.
    pub(crate) files: Vec<FileInUse>,
    /// Lights with a file that is not looked up: it is loading, has another sun, or is missing. Meshes in
    /// that file cast through the cascades only.
    pub(crate) partial: EntityHashSet,
}

impl FilesInUse {
    /// Returns the files that are looked up for a light's sun.
    pub(crate) fn of_sun(&self, towards_light: Vec3) -> impl Iterator<Item = &FileInUse> + Clone {
        let is_of_sun = move |file: &&FileInUse| file.towards_sun.distance(towards_light) <= SAME_SUN;
        self.files.iter().filter(|file| file.is_ready).filter(is_of_sun)
    }
}

/// Adds a light's files to those in use.
pub(crate) struct LightFiles<'a> {
    pub(crate) in_use: &'a mut Vec<FileInUse>,
    pub(crate) limits: DeviceLimits,
    /// Unit vector towards the light.
    pub(crate) towards_light: Vec3,
    /// Files that are looked up.
    pub(crate) added: usize,
    /// Files that cannot be in use.
    pub(crate) missing: usize,
    /// Whether a file is loading.
    pub(crate) is_loading: bool,
    /// Angle to the nearest sun among the files that do not match the light.
    pub(crate) nearest_degrees: f32,
    /// Why a file is not in use.
    pub(crate) error: Option<BakedShadowError>,
}

impl LightFiles<'_> {
    /// Adds a file if its sun matches the light.
    pub(crate) fn add(
        &mut self,
        towards_sun: Vec3,
        file: impl FnOnce() -> Result<FileInUse, BakedShadowError>,
    ) {
        if towards_sun.distance(self.towards_light) > SAME_SUN {
            let degrees = towards_sun.angle_between(self.towards_light).to_degrees();
            self.nearest_degrees = self.nearest_degrees.min(degrees);
            return;
        }
        match file().and_then(|file| self.put(file)) {
            Ok(true) => self.added += 1,
            Ok(false) => self.is_loading = true,
            Err(error) => self.miss(error),
        }
    }

    /// Whether all files are looked up.
    pub(crate) fn is_complete(&self) -> bool {
        self.missing == 0 && !self.is_loading && self.nearest_degrees.is_infinite()
    }

    /// Counts a file that is not in use.
    pub(crate) fn miss(&mut self, error: BakedShadowError) {
        self.missing += 1;
        self.error.get_or_insert(error);
    }

    /// Puts a file in use. Returns whether it is looked up.
    pub(crate) fn put(&mut self, new: FileInUse) -> Result<bool, BakedShadowError> {
        let limit = self.limits.max_texture_side;
        let all = self.in_use.iter().chain(once(&new)).map(|file| &file.texels);
        let is_same = |other: &&FileInUse| (&other.texels, other.placement) == (&new.texels, new.placement);
        let listed = self.in_use.iter().filter(|file| file.is_ready).count();
        if let Some(known) = self.in_use.iter().find(is_same) {
            Ok(known.is_ready)
        } else if new.is_ready && listed == MAX_FILES {
            Err(BakedShadowError::TooManyFiles { limit: MAX_FILES })
        } else if Layout::below(UVec2::ZERO, all.clone(), limit).is_none() {
            Err(BakedShadowError::TooManyRows { rows: all.map(Texels::height).sum(), limit })
        } else {
            let is_ready = new.is_ready;
            self.in_use.push(new);
            Ok(is_ready)
        }
    }
}
