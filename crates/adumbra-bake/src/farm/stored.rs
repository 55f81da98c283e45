//! A plan as data, for `serde`: what it is made of, a format and a digest. A plan that was changed is
//! refused.

use std::collections::HashSet;

use adumbra::file::placement::{check_grid, check_settings};
use adumbra::file::{LEVEL_STEP, MAX_LEVELS};
use adumbra::query::MAX_FIXED_SIDE;
use adumbra::{Encoding, FileSettings, Frame, LightGrid, Region, Sun};
use blake3::Hasher;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::plan::{BakePlan, PlannedPart};
use crate::error::Error;
use crate::inputs::hash_each;
use crate::plan::Placement;

const FORMAT: &str = "adumbra plan 2";
/// Levels that root blocks may have.
const ROOT_LEVELS: std::ops::RangeInclusive<u32> = 5..=13;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StoredPlan {
    format: String,
    digest: String,
    scene: String,
    sun: Sun,
    frame: Frame,
    encoding: Encoding,
    settings: FileSettings,
    levels: Vec<StoredLevel>,
    parts: Vec<StoredPart>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StoredLevel {
    voxel_size: f64,
    corner: [f64; 3],
    size: [u32; 3],
    root_level: u32,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StoredPart {
    level: u32,
    number: u32,
    cost: u64,
    key: String,
}

impl Serialize for BakePlan {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let grid = self.levels[0].grid;
        let level = |Placement { grid, root_level, .. }: &Placement| StoredLevel {
            voxel_size: grid.voxel_size,
            corner: grid.corner,
            size: grid.size,
            root_level: *root_level,
        };
        let part = |&PlannedPart { level, number, cost, key }: &PlannedPart| StoredPart {
            level,
            number,
            cost,
            key: key.to_string(),
        };
        let stored = StoredPlan {
            format: FORMAT.to_owned(),
            digest: digest(self),
            scene: self.scene.to_string(),
            sun: grid.sun,
            frame: grid.frame,
            encoding: self.encoding,
            settings: self.settings,
            levels: self.levels.iter().map(level).collect(),
            parts: self.parts.iter().map(part).collect(),
        };
        stored.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for BakePlan {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let stored = StoredPlan::deserialize(deserializer)?;
        Self::try_from(stored).map_err(serde::de::Error::custom)
    }
}

impl TryFrom<StoredPlan> for BakePlan {
    type Error = Error;

    fn try_from(stored: StoredPlan) -> Result<Self, Error> {
        let refuse = |what: String| Err(Error::Plan(what));
        let StoredPlan { format, digest: found, scene, sun, frame, encoding, settings, levels, parts } =
            stored;
        if format != FORMAT {
            return refuse(format!("its format is \"{format}\", not \"{FORMAT}\""));
        }
        let invalid = |fault: adumbra::FormatError| Error::Plan(fault.to_string());
        check_settings(&settings).map_err(invalid)?;
        if !(1..=MAX_LEVELS as usize).contains(&levels.len()) {
            return refuse(format!("it has {} levels", levels.len()));
        }
        if let Some(region) = settings.region {
            Region::check_texels(region.texels)?;
        }
        let mut planned = Vec::with_capacity(levels.len());
        for (level, StoredLevel { voxel_size, corner, size, root_level }) in (0..).zip(levels) {
            let grid = LightGrid::new(sun, frame, voxel_size, corner, size);
            check_grid(&grid).map_err(invalid)?;
            if size[0].max(size[1]) > MAX_FIXED_SIDE {
                return refuse(format!("a grid has {} x {} texels", size[0], size[1]));
            }
            if !ROOT_LEVELS.contains(&root_level) {
                return refuse(format!("a root block has 2^{root_level} texels a side"));
            }
            let resolution = settings.resolution.div_ceil(LEVEL_STEP.pow(level));
            planned.push(Placement { grid, resolution, root_level });
        }
        let key = |text: &str| text.parse().map_err(|()| Error::Plan(format!("\"{text}\" is not a hash")));
        let part = |StoredPart { level, number, cost, key: text }: StoredPart| {
            Ok(PlannedPart { level, number, cost, key: key(&text)? })
        };
        let parts = parts.into_iter().map(part).collect::<Result<Vec<_>, Error>>()?;
        check_parts(&planned, &parts)?;
        let plan = Self { scene: key(&scene)?, settings, encoding, levels: planned, parts };
        if digest(&plan) != found {
            return refuse("it was changed after it was written".to_owned());
        }
        Ok(plan)
    }
}

/// Checks that each part of each level is there once.
fn check_parts(levels: &[Placement], parts: &[PlannedPart]) -> Result<(), Error> {
    let counts: Vec<usize> = levels.iter().map(|level| level.parts().count()).collect();
    let is_there = |part: &PlannedPart| {
        counts.get(part.level as usize).is_some_and(|&count| (part.number as usize) < count)
    };
    let distinct: HashSet<_> = parts.iter().map(|part| (part.level, part.number)).collect();
    let total: usize = counts.iter().sum();
    if parts.iter().all(is_there) && distinct.len() == parts.len() && total == parts.len() {
        return Ok(());
    }
    Err(Error::Plan("its parts are not those of its grids".to_owned()))
}

/// Returns a hash of everything in a plan.
fn digest(plan: &BakePlan) -> String {
    let BakePlan { scene, settings, encoding, levels, parts } = plan;
    let mut hasher = Hasher::new();
    hasher.update(FORMAT.as_bytes());
    hasher.update(scene.as_bytes());
    let FileSettings { bounds, bias, .. } = settings;
    let flags = adumbra::file::placement::flags(settings);
    let encoding = match encoding {
        Encoding::Raw => 0,
        Encoding::Coded => 1,
    };
    let numbers = [settings.resolution, flags, settings.switch_within_voxels, encoding];
    hash_each(&mut hasher, numbers.map(u32::to_le_bytes));
    let mut reals =
        |numbers: &[f64]| hash_each(&mut hasher, numbers.iter().map(|number| number.to_le_bytes()));
    reals(&[settings.thickness_world, bias.constant_texels, bias.slope_texels, bias.normal_offset_texels]);
    if let Some(Region { x, y, texels }) = settings.region {
        reals(&[f64::from(x), f64::from(y), f64::from(texels)]);
    }
    if let Some(bounds) = bounds {
        reals(&bounds.min);
        reals(&bounds.max);
    }
    for Placement { grid, .. } in levels {
        reals(&grid.sun.towards());
        let (frame, yaw) = adumbra::file::placement::frame_fields(grid.frame);
        reals(&[f64::from(frame), yaw, grid.voxel_size]);
        reals(&grid.corner);
    }
    for Placement { grid, root_level, .. } in levels {
        let [nx, ny, nz] = grid.size;
        hash_each(&mut hasher, [nx, ny, nz, *root_level].map(u32::to_le_bytes));
    }
    hash_each(
        &mut hasher,
        [settings.triangles, settings.instances, parts.len() as u64].map(u64::to_le_bytes),
    );
    for PlannedPart { level, number, cost, key } in parts {
        hash_each(&mut hasher, [u64::from(*level), u64::from(*number), *cost].map(u64::to_le_bytes));
        hasher.update(key.as_bytes());
    }
    hasher.finalize().to_string()
}
