//! A moving sun: the two keys around it on the device, and the march slopes towards it in each key.
//!
//! All keys are in one pool of words, each in its slot. A frame writes only a limited number of words.
//! Look-ups use a new pair of keys once both have been written. Until then they use the previous pair, with
//! the sun of the current frame.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};

use adumbra::gpu::{LookUp, Parameters};
use adumbra::query::MarchSlope;
use adumbra::{LightGrid, ShadowFile};
use adumbra_shaders::{Source, source};

use super::{VoxelBindings, WordBuffers};
use crate::error::{RenderError, Result};
use crate::gpu::Gpu;

/// Slots for a moving sun: two for the keys in use, two for the next pair.
const MOVING_SLOTS: usize = 4;
/// Size of a slot, relative to the largest known key. Later keys may be larger.
const ROOM: f64 = 1.25;

/// Grids and parameters of levels, or of keys.
pub(super) type Levels = Vec<(LightGrid, Parameters)>;

/// A moving sun, with the files of the keys around it. Techniques of one device share it. The caller sets the
/// moment between frames.
pub struct MovingLight {
    moment: Mutex<Moment>,
    /// Largest number of words that a frame writes to the device.
    upload_words: usize,
    /// Whether the last frame used the keys of the moment.
    is_settled: AtomicBool,
}

#[derive(Clone)]
struct Moment {
    keys: [ShadowFile; 2],
    towards_sun: [f64; 3],
}

impl MovingLight {
    /// Returns a sun at a moment. `keys` are the files of the keys around it: first the key that look-ups
    /// read first, then the other one. Both may be the same file. `towards_sun` is a unit vector. A frame
    /// writes up to `upload_bytes` to the device.
    pub fn new(keys: [&ShadowFile; 2], towards_sun: [f64; 3], upload_bytes: usize) -> Self {
        let moment = Moment { keys: keys.map(ShadowFile::clone), towards_sun };
        Self {
            moment: Mutex::new(moment),
            upload_words: (upload_bytes / 4).max(1),
            is_settled: AtomicBool::new(false),
        }
    }

    /// Sets the moment. The cost does not depend on the files.
    pub fn set(&self, keys: [&ShadowFile; 2], towards_sun: [f64; 3]) {
        let next = Moment { keys: keys.map(ShadowFile::clone), towards_sun };
        let mut moment = self.moment();
        if !are_same(&moment.keys, &next.keys) {
            self.is_settled.store(false, Ordering::Relaxed);
        }
        *moment = next;
    }

    /// Whether the last frame used the keys of the moment. If not, the next frames continue to write them to
    /// the device.
    pub fn is_settled(&self) -> bool {
        self.is_settled.load(Ordering::Relaxed)
    }

    /// The file that look-ups read first.
    pub fn first_key(&self) -> ShadowFile {
        self.moment().keys[0].clone()
    }

    fn moment(&self) -> MutexGuard<'_, Moment> {
        self.moment.lock().unwrap_or_else(|e| e.into_inner())
    }
}

/// The keys of a moment on the device.
pub(super) struct MovingKeys {
    light: Arc<MovingLight>,
    pool: KeyPool,
    /// A pool with larger slots. It replaces `pool` once the keys of the moment have been written to it.
    next: Option<KeyPool>,
    /// Slots of the keys in use.
    shown: [usize; 2],
    slopes: [MarchSlope; 2],
    look_up: LookUp,
    quick: bool,
}

impl MovingKeys {
    /// Uploads the keys of the current moment. With `is_still`, the pool has no room for other keys.
    pub(super) fn new(
        gpu: &Gpu,
        light: Arc<MovingLight>,
        (look_up, quick): (LookUp, bool),
        is_still: bool,
    ) -> Result<(Self, Levels)> {
        let moment = light.moment().clone();
        let mut pool = KeyPool::new(gpu, &moment, is_still)?;
        let shown = loop {
            if let Some(shown) = pool.write(gpu, &moment, &[], usize::MAX) {
                break shown;
            }
        };
        gpu.check()?;
        let slopes = slopes(&moment.keys, moment.towards_sun);
        let keys = Self { light, pool, next: None, shown, slopes, look_up, quick };
        let levels = keys.levels(moment.keys[0].grid.origin())?;
        Ok((keys, levels))
    }

    pub(super) fn words(&self) -> &WordBuffers {
        &self.pool.words
    }

    /// Writes the next words of the current moment's keys, and switches to these keys once they are complete.
    /// Returns the parameters of the keys if they changed, and whether the words are now in other buffers.
    pub(super) fn advance(&mut self, gpu: &Gpu, anchor_world: [f64; 3]) -> Result<Option<(Levels, bool)>> {
        let moment = self.light.moment().clone();
        let budget = self.light.upload_words;
        if !self.next.as_ref().unwrap_or(&self.pool).has_room(&moment) {
            self.next = Some(KeyPool::new(gpu, &moment, false)?);
        }
        let mut changed = None;
        if let Some(mut next) = self.next.take() {
            match next.write(gpu, &moment, &[], budget) {
                Some(shown) => {
                    (self.pool, self.shown) = (next, shown);
                    changed = Some((self.levels(anchor_world)?, true));
                }
                None => self.next = Some(next),
            }
        } else if let Some(shown) = self.pool.write(gpu, &moment, &self.shown, budget)
            && shown != self.shown
        {
            self.shown = shown;
            changed = Some((self.levels(anchor_world)?, false));
        }
        let files = self.files();
        self.light.is_settled.store(are_same(&files, &moment.keys), Ordering::Relaxed);
        self.slopes = slopes(&files, moment.towards_sun);
        Ok(changed)
    }

    /// Returns the uniform, as access/voxel_path.wgsl reads it.
    pub(super) fn uniform(&self, levels: &Levels) -> Vec<u8> {
        let mut bytes: Vec<u8> = levels.iter().flat_map(|(_, parameters)| parameters.to_bytes()).collect();
        let dark_after_voxels = self.pool.file(self.shown[0]).settings.dark_after_voxels.cast_signed();
        for MarchSlope { v_fixed: [x, y] } in self.slopes {
            let way = [x, y, self.quick.into(), dark_after_voxels];
            bytes.extend(way.iter().flat_map(|word| word.to_le_bytes()));
        }
        bytes
    }

    fn files(&self) -> [ShadowFile; 2] {
        self.shown.map(|slot| self.pool.file(slot).clone())
    }

    fn levels(&self, anchor_world: [f64; 3]) -> Result<Levels> {
        let level = |&slot: &usize| {
            let file = self.pool.file(slot);
            let mut parameters = Parameters::new(file, &self.look_up, anchor_world)?;
            let at = slot as u32 * self.pool.slot_words as u32;
            parameters.table_offset += at;
            parameters.code_offset += at;
            Ok((file.grid, parameters))
        };
        self.shown.iter().map(level).collect()
    }
}

/// The words of several keys in slots of equal size.
struct KeyPool {
    words: WordBuffers,
    slot_words: u64,
    slots: Vec<Option<Slot>>,
}

struct Slot {
    file: ShadowFile,
    written: u64,
}

impl KeyPool {
    fn new(gpu: &Gpu, moment: &Moment, is_still: bool) -> Result<Self> {
        let largest = moment.keys.iter().map(words_of).max().unwrap_or(0);
        let is_one = is_same(&moment.keys[0], &moment.keys[1]);
        let (count, slot_words) = match is_still {
            true => (if is_one { 1 } else { 2 }, largest),
            false => (MOVING_SLOTS, (largest as f64 * ROOM) as u64),
        };
        let words = WordBuffers::empty(gpu, "voxel::path", count as u64 * slot_words)?;
        Ok(Self { words, slot_words, slots: (0..count).map(|_| None).collect() })
    }

    fn has_room(&self, moment: &Moment) -> bool {
        moment.keys.iter().all(|key| words_of(key) <= self.slot_words)
    }

    /// Writes up to `budget` words of the keys of a moment. `kept` are the slots in use, which are not
    /// overwritten. Returns the slots of the keys once all their words have been written.
    fn write(&mut self, gpu: &Gpu, moment: &Moment, kept: &[usize], mut budget: usize) -> Option<[usize; 2]> {
        for key in &moment.keys {
            let Some(slot) = self.slot(key).or_else(|| self.free_slot(moment, kept)) else { continue };
            let Slot { file, written } =
                self.slots[slot].get_or_insert_with(|| Slot { file: key.clone(), written: 0 });
            if !is_same(file, key) {
                (*file, *written) = (key.clone(), 0);
            }
            let mut at = 0;
            let words = key.gpu().words();
            for part in words.parts() {
                let done = written.saturating_sub(at).min(part.len() as u64) as usize;
                let rest = &part[done..];
                let now = &rest[..rest.len().min(budget)];
                if !now.is_empty() {
                    self.words.write(gpu, slot as u64 * self.slot_words + at + done as u64, now);
                    *written += now.len() as u64;
                    budget -= now.len();
                }
                at += part.len() as u64;
            }
        }
        let [first, second] =
            moment.keys.each_ref().map(|key| self.slot(key).filter(|&slot| self.is_written(slot)));
        Some([first?, second?])
    }

    fn slot(&self, key: &ShadowFile) -> Option<usize> {
        self.slots.iter().position(|slot| slot.as_ref().is_some_and(|slot| is_same(&slot.file, key)))
    }

    fn is_written(&self, slot: usize) -> bool {
        self.slots[slot].as_ref().is_some_and(|slot| slot.written == words_of(&slot.file))
    }

    /// Returns a slot that is not in use and does not hold a key of the moment.
    fn free_slot(&self, moment: &Moment, kept: &[usize]) -> Option<usize> {
        let is_of_moment = |slot: &Slot| moment.keys.iter().any(|key| is_same(&slot.file, key));
        (0..self.slots.len())
            .find(|slot| !kept.contains(slot) && !self.slots[*slot].as_ref().is_some_and(is_of_moment))
    }

    fn file(&self, slot: usize) -> &ShadowFile {
        match &self.slots[slot] {
            Some(slot) => &slot.file,
            None => unreachable!("only slots that were written are shown"),
        }
    }
}

/// The WGSL files that march through two keys, with a filter.
pub(super) const FILTER: &[Source] = &[source::DEPTHS_MARCH, source::VOXEL_PATH, source::VOXEL_PATH_FILTER];
/// The WGSL files that march through two keys, towards the sun's disc.
pub(super) const DISC: &[Source] =
    &[source::DEPTHS_MARCH, source::DISC, source::VOXEL_PATH, source::VOXEL_PATH_DISC];

/// Returns the march slopes towards a sun in both files. If the march in either file cannot reach the sun,
/// both marches go to the sun of their own file.
fn slopes(files: &[ShadowFile; 2], towards_sun: [f64; 3]) -> [MarchSlope; 2] {
    let slopes = files.each_ref().map(|file| MarchSlope::new(&file.grid, towards_sun));
    match slopes {
        [Some(first), Some(second)] => [first, second],
        _ => [MarchSlope { v_fixed: [0; 2] }; 2],
    }
}

/// Returns an error if a sun is too far from a file's sun to be reached by marching.
pub(super) fn check_reach(files: [&ShadowFile; 2], towards_sun: [f64; 3]) -> Result<()> {
    let is_in_reach = files.iter().all(|file| MarchSlope::new(&file.grid, towards_sun).is_some());
    if is_in_reach { Ok(()) } else { Err(RenderError::SunTooFar { towards_sun }) }
}

fn words_of(file: &ShadowFile) -> u64 {
    file.gpu().words().count()
}

fn is_same(a: &ShadowFile, b: &ShadowFile) -> bool {
    Arc::ptr_eq(&a.tree, &b.tree)
}

fn are_same(a: &[ShadowFile; 2], b: &[ShadowFile; 2]) -> bool {
    is_same(&a[0], &b[0]) && is_same(&a[1], &b[1])
}

/// Creates the bindings of keys with their current uniform.
pub(super) fn bindings(gpu: &Gpu, keys: &MovingKeys, levels: &Levels) -> VoxelBindings {
    VoxelBindings::from_words(gpu, "voxel", &keys.uniform(levels), keys.words())
}
