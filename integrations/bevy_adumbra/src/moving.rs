//! The keys of a moving sun: how they get into the texture, and how look-ups find them there.
//!
//! Each key has a slot, which is a pool like that of a streamed file. Keys are written a few bytes per frame.
//! A new pair answers once both of its keys have been written; until then the previous pair answers, also for
//! the sun of the current frame.

use std::sync::Arc;

use adumbra::gpu::HEADER_WORDS;
use adumbra::query::MarchSlope;
use adumbra::stream::PoolWrite;
use adumbra::{Filter, PathSampler, Placement, ShadowFile};
use bevy::ecs::prelude::*;
use bevy::math::Vec3;

use crate::components::BakedShadow;
use crate::error::BakedShadowError;
use crate::in_use::{FileInUse, March, look_up};
use crate::shaders::Way;
use crate::stream::PoolUploads;
use crate::texels::{PoolTexels, Texels};
use crate::{DeviceLimits, StreamBudget};

/// Slots of a moving sun: two for the keys that answer, two for the next keys.
const SLOTS: usize = 4;
/// Size of a slot relative to the largest known key: later keys may be larger.
const ROOM: f64 = 1.25;
/// Word offset of the unit vector towards the sun in the header of a look-up texture.
const SUN_AT: usize = 8;

/// The keys that answer for a light that follows the sun. The plugin keeps this component on the lights of
/// [`BakedShadow::follow_sun`].
#[derive(Component, Default)]
pub struct SunKeys {
    moment: Option<Moment>,
    is_night: bool,
    slots: Vec<Slot>,
    /// Larger slots, which will be in use once the keys of the moment are in them.
    next: Vec<Slot>,
    /// The slots that answer.
    shown: Option<[usize; 2]>,
}

/// Two keys, in the order in which they are looked up, and the sun between them.
struct Moment {
    keys: [Arc<ShadowFile>; 2],
    towards_sun: [f64; 3],
}

/// A place for a key.
struct Slot {
    pool: PoolTexels,
    file: Option<Arc<ShadowFile>>,
    written_words: u64,
}

impl SunKeys {
    /// Returns look-ups on the CPU for the sun of this frame. `None` at night, and as long as there is no
    /// key.
    pub fn sampler(&self, filter: Filter) -> Option<PathSampler> {
        let Moment { keys, towards_sun } = self.moment.as_ref().filter(|_| !self.is_night)?;
        PathSampler::new(keys.each_ref().map(|key| &**key), *towards_sun, filter)
    }

    /// Whether the picture uses the current keys. Otherwise they are still being written.
    pub fn is_settled(&self) -> bool {
        let Some(moment) = &self.moment else { return false };
        self.shown.is_some_and(|shown| {
            shown
                .iter()
                .zip(&moment.keys)
                .all(|(slot, key)| self.slots.get(*slot).is_some_and(|slot| slot.has(key)))
        })
    }

    /// Whether the sun is at or below the horizon.
    pub(crate) fn is_night(&self) -> bool {
        self.is_night
    }

    /// Records that the sun is at or below the horizon. The keys stay.
    #[cfg(feature = "bake")]
    pub(crate) fn set_night(&mut self) {
        self.is_night = true;
    }

    /// Sets the keys that answer, and the sun.
    #[cfg(feature = "bake")]
    pub(crate) fn set(&mut self, keys: [Arc<ShadowFile>; 2], towards_sun: [f64; 3]) {
        self.is_night = false;
        self.moment = Some(Moment { keys, towards_sun });
    }

    /// Moves the sun if a march from both keys reaches it.
    #[cfg(feature = "bake")]
    pub(crate) fn turn(&mut self, towards_sun: [f64; 3]) {
        self.is_night = towards_sun[1] <= 0.0;
        if let Some(moment) = &mut self.moment
            && moment.keys.iter().all(|key| MarchSlope::new(&key.grid, towards_sun).is_some())
        {
            moment.towards_sun = towards_sun;
        }
    }

    /// Returns the pools of all slots.
    fn pools(&self) -> impl Iterator<Item = PoolTexels> {
        self.slots.iter().chain(&self.next).map(|slot| slot.pool)
    }

    /// Writes at most `max_words` words of the current keys, and shows both keys once they are written.
    fn write(&mut self, max_words: usize, limits: DeviceLimits) -> Vec<(PoolTexels, Vec<PoolWrite>)> {
        let Some(Moment { keys, .. }) = &self.moment else { return Vec::new() };
        let newest = if self.next.is_empty() { &self.slots } else { &self.next };
        if !keys.iter().all(|key| newest.first().is_some_and(|slot| slot.has_room(key))) {
            self.next = slots(keys, limits);
        }
        let kept = self.shown.filter(|_| self.next.is_empty());
        let slots = if self.next.is_empty() { &mut self.slots } else { &mut self.next };
        let mut writes = Vec::new();
        let mut left = max_words;
        for key in keys {
            let is_of_moment = |slot: &Slot| keys.iter().any(|key| slot.has(key));
            let known = slots.iter().position(|slot| slot.has(key));
            let free = || {
                (0..slots.len())
                    .find(|slot| !kept.iter().flatten().any(|k| k == slot) && !is_of_moment(&slots[*slot]))
            };
            let Some(slot) = known.or_else(free) else { continue };
            writes.extend(slots[slot].write(key, &mut left));
        }
        let written =
            |key| slots.iter().position(|slot| slot.has(key) && slot.written_words == words_of(key));
        if let [Some(first), Some(other)] = keys.each_ref().map(written) {
            if !self.next.is_empty() {
                self.slots = std::mem::take(&mut self.next);
            }
            self.shown = Some([first, other]);
        }
        writes
    }

    /// Returns the slots as files in use, with a light's settings. Slots that do not answer are not ready.
    /// Empty before the first key.
    pub(crate) fn files(
        &self,
        shadow: &BakedShadow,
        towards_light: Vec3,
    ) -> Result<Vec<FileInUse>, BakedShadowError> {
        let Some(moment) = &self.moment else { return Ok(Vec::new()) };
        let shown = self.shown.map(|shown| shown.map(|slot| &self.slots[slot]));
        let mut files = Vec::new();
        for slot in self.slots.iter().chain(&self.next) {
            let place = shown.and_then(|shown| shown.iter().position(|s| s.pool == slot.pool));
            files.push(match (place, shown, &slot.file) {
                (Some(place), Some([_, other]), Some(file)) => {
                    let header = file.gpu().texture_header(&look_up(shadow, Placement::BAKED));
                    let mut header = header.map_err(|error| BakedShadowError::Setting(error.into()))?;
                    // The other key is found through the first one, and must not match any light's sun.
                    let towards_sun = if place == 0 { towards_light } else { Vec3::ZERO };
                    let bytes = towards_sun.to_array().into_iter().flat_map(f32::to_le_bytes);
                    header.splice(4 * SUN_AT..4 * (SUN_AT + 3), bytes);
                    let slope =
                        MarchSlope::new(&file.grid, moment.towards_sun).map_or([0; 2], |slope| slope.v_fixed);
                    let march = March { slope, other: other.pool };
                    FileInUse { march: Some(march), ..slot.empty(header, towards_sun, true) }
                }
                _ => slot.empty(vec![0; 4 * HEADER_WORDS], Vec3::ZERO, false),
            });
        }
        Ok(files)
    }

    /// Whether keys answer.
    pub(crate) fn is_ready(&self) -> bool {
        self.shown.is_some()
    }
}

impl Slot {
    fn has(&self, key: &Arc<ShadowFile>) -> bool {
        self.file.as_ref().is_some_and(|file| Arc::ptr_eq(file, key))
    }

    fn has_room(&self, key: &ShadowFile) -> bool {
        let texels = u64::from(self.pool.width) * u64::from(self.pool.height);
        HEADER_WORDS as u64 + words_of(key) <= texels
    }

    /// Writes at most `left` words of a key, and subtracts them from `left`.
    fn write(&mut self, key: &Arc<ShadowFile>, left: &mut usize) -> Option<(PoolTexels, Vec<PoolWrite>)> {
        if !self.has(key) {
            (self.file, self.written_words) = (Some(Arc::clone(key)), 0);
        }
        let mut writes = Vec::new();
        let mut at = 0;
        for part in key.gpu().words().parts() {
            let done = self.written_words.saturating_sub(at).min(part.len() as u64) as usize;
            let rest = &part[done..];
            let now = &rest[..rest.len().min(*left)];
            if !now.is_empty() {
                writes.push(PoolWrite { at: at as u32 + done as u32, words: now.to_vec() });
                self.written_words += now.len() as u64;
                *left -= now.len();
            }
            at += part.len() as u64;
        }
        (!writes.is_empty()).then_some((self.pool, writes))
    }

    fn empty(&self, header: Vec<u8>, towards_sun: Vec3, is_ready: bool) -> FileInUse {
        FileInUse {
            texels: Texels::Pool(self.pool),
            placement: Placement::BAKED,
            grid: self.file.as_ref().filter(|_| is_ready).map(|file| file.grid),
            way: Way::March,
            header,
            towards_sun,
            is_ready,
            march: None,
        }
    }
}

/// Returns empty slots with room for keys like these.
fn slots(keys: &[Arc<ShadowFile>; 2], limits: DeviceLimits) -> Vec<Slot> {
    let largest = keys.iter().map(|key| words_of(key)).max().unwrap_or(0);
    let words = (ROOM * largest as f64) as u32;
    let slot =
        || Slot { pool: PoolTexels::new(words, limits.max_texture_side), file: None, written_words: 0 };
    std::iter::repeat_with(slot).take(SLOTS).collect()
}

fn words_of(file: &ShadowFile) -> u64 {
    file.gpu().words().count()
}

/// Writes a part of the keys that are not complete yet.
pub(crate) fn write_keys(
    mut lights: Query<&mut SunKeys>,
    (budget, limits): (Res<StreamBudget>, Res<DeviceLimits>),
    mut uploads: ResMut<PoolUploads>,
) {
    for mut keys in &mut lights {
        // Write nothing until earlier writes are taken: without a render world, nothing takes them.
        let is_taken = keys.pools().all(|pool| uploads.writes.iter().all(|(written, _)| *written != pool));
        let max_words = if is_taken { budget.upload_bytes_per_frame / 4 } else { 0 };
        let writes = keys.write(max_words, *limits);
        uploads.writes.extend(writes);
        uploads.pools.extend(keys.pools());
    }
}

#[cfg(all(test, feature = "bake"))]
mod tests {
    use adumbra::Sun;
    use adumbra_bake::{Bake, BakeOptions, FrameChoice, Size};
    use adumbra_scene::{GeneratedKind, generate};

    use super::*;

    fn key(degrees: f64, resolution: u64) -> Arc<ShadowFile> {
        let sun = Sun::from_direction(towards(degrees)).unwrap();
        let options =
            BakeOptions::new(sun, Size::Resolution(resolution)).with(|o| o.frame = FrameChoice::Oblique);
        Arc::new(Bake::with_options(&generate(GeneratedKind::City, 1), &options).in_memory().unwrap())
    }

    fn towards(degrees: f64) -> [f64; 3] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        [0.6 * cos, 0.8, 0.6 * sin]
    }

    /// Writes in steps until the moment is shown. Returns the words that were written, and in how many steps.
    fn settle(keys: &mut SunKeys) -> [usize; 2] {
        let mut written = [0, 0];
        while !keys.is_settled() {
            let writes = keys.write(10_000, DeviceLimits::default());
            let words: usize = writes.iter().flat_map(|(_, w)| w).map(|write| write.words.len()).sum();
            assert!(words <= 10_000);
            written = [written[0] + words, written[1] + 1];
            assert!(written[1] < 1000, "the moment does not come");
        }
        written
    }

    #[test]
    fn shows_a_pair_once_written_and_reuses_known_keys() {
        let [a, b, c] = [0.0, 8.0, 16.0].map(|degrees| key(degrees, 512));
        let shadow = BakedShadow::follow_sun();
        let light = Vec3::from_array(towards(4.0).map(|c| c as f32));
        let mut keys = SunKeys::default();
        keys.set([a.clone(), b.clone()], towards(4.0));
        assert!(!keys.is_ready() && keys.files(&shadow, light).unwrap().is_empty());
        let [words, _] = settle(&mut keys);
        assert_eq!(words as u64, words_of(&a) + words_of(&b));
        let ready = |keys: &SunKeys| -> Vec<bool> {
            keys.files(&shadow, light).unwrap().iter().map(|file| file.is_ready).collect()
        };
        assert_eq!(ready(&keys), [true, true, false, false]);
        let before: Vec<_> = keys.pools().collect();
        keys.set([b.clone(), c.clone()], towards(12.0));
        keys.write(10, DeviceLimits::default());
        assert_eq!(ready(&keys), [true, true, false, false], "the pair before it answers meanwhile");
        let [words, _] = settle(&mut keys);
        assert_eq!(words as u64, words_of(&c) - 10);
        assert_eq!(ready(&keys), [false, true, true, false]);
        assert_eq!(keys.pools().collect::<Vec<_>>(), before, "no texture is made anew");
        let first = &keys.files(&shadow, light).unwrap()[1];
        assert_eq!(first.towards_sun, light);
        assert_eq!(first.march.map(|march| march.other), Some(before[2]));
    }

    #[test]
    fn writes_a_larger_key_to_new_slots_while_old_keys_answer() {
        let [small, large] = [256, 1024].map(|resolution| key(0.0, resolution));
        let shadow = BakedShadow::follow_sun();
        let mut keys = SunKeys::default();
        keys.set([small.clone(), small], towards(0.0));
        settle(&mut keys);
        let before: Vec<_> = keys.pools().collect();
        keys.set([large.clone(), large], towards(1.0));
        keys.write(10, DeviceLimits::default());
        let files = keys.files(&shadow, Vec3::Y).unwrap();
        assert_eq!((files.len(), files[0].is_ready), (2 * SLOTS, true));
        settle(&mut keys);
        let after: Vec<_> = keys.pools().collect();
        assert!(after.len() == SLOTS && after.iter().all(|pool| !before.contains(pool)));
    }

    #[test]
    fn keeps_keys_but_has_no_look_ups_at_night() {
        let mut keys = SunKeys::default();
        keys.set([key(0.0, 256), key(0.0, 256)], towards(0.0));
        keys.set_night();
        assert!(keys.is_night() && keys.sampler(Filter::Nearest).is_none());
        keys.turn(towards(1.0));
        assert!(!keys.is_night() && keys.sampler(Filter::Nearest).is_some());
    }
}
