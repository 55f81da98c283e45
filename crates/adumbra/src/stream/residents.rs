//! The bundles in the pool: how they arrive and leave, and their weights meanwhile.
//!
//! ```text
//!  add ──► waiting ──room──► arriving ──written──► weight rises to WHOLE
//!                                                        │ another bundle needs the room
//!                              gone ◄──── weight falls to 0, if levels fade
//! ```

use std::collections::{BTreeSet, HashMap, HashSet, VecDeque};
use std::sync::Arc;

use crate::file::Contents;
use crate::stream::decode::LoadedBundle;
use crate::stream::pool::{PlacedPages, Pool, PoolLayout, WHOLE};
use crate::stream::retry::BundleId;

/// The pool, and the bundles of all levels but the coarsest, which stays.
#[derive(Debug)]
pub(super) struct Residents {
    pub(super) pool: Pool,
    layout: Arc<PoolLayout>,
    bundles: HashMap<BundleId, ResidentBundle>,
    /// Chosen bundles that wait until others make room.
    waiting: VecDeque<(BundleId, LoadedBundle)>,
    /// Resident bundles whose weight changes.
    fading: BTreeSet<BundleId>,
    /// Chosen bundles that found no room since the last choice.
    refused: HashSet<BundleId>,
    /// The change of a weight in a frame; [`WHOLE`] if levels do not fade.
    step: u32,
    /// Counts choices.
    choice: u64,
    /// Chosen bundles.
    chosen: HashSet<BundleId>,
}

#[derive(Debug)]
struct ResidentBundle {
    pages: PlacedPages,
    /// The last choice that it was part of.
    last_choice: u64,
    weight: u32,
    /// Whether the bundle is leaving to make room for another.
    is_leaving: bool,
    /// The pool's words hold the whole bundle once this many writes have been taken.
    written_at: u64,
}

impl Residents {
    pub(super) fn new(layout: Arc<PoolLayout>, contents: &Contents, fade_frames: u32) -> Self {
        Self {
            pool: Pool::new(&layout, contents),
            layout,
            bundles: HashMap::new(),
            waiting: VecDeque::new(),
            fading: BTreeSet::new(),
            refused: HashSet::new(),
            step: WHOLE.div_ceil(fade_frames.max(1)),
            choice: 0,
            chosen: HashSet::new(),
        }
    }

    /// Sets the chosen bundles.
    pub(super) fn choose(&mut self, chosen: HashSet<BundleId>) {
        self.choice += 1;
        self.refused.clear();
        for id in &chosen {
            if let Some(bundle) = self.bundles.get_mut(id) {
                bundle.last_choice = self.choice;
            }
        }
        self.chosen = chosen;
    }

    /// Whether anything has been chosen.
    pub(super) fn has_choice(&self) -> bool {
        self.choice > 0
    }

    /// Returns the number of bundles that are resident.
    pub(super) fn len(&self) -> usize {
        self.bundles.len()
    }

    /// Returns the number of bundles that wait for room.
    pub(super) fn waiting(&self) -> usize {
        self.waiting.len()
    }

    pub(super) fn is_resident(&self, id: BundleId) -> bool {
        self.bundles.contains_key(&id)
    }

    /// Whether a bundle is chosen and has to be read.
    pub(super) fn is_missing(&self, id: BundleId) -> bool {
        self.chosen.contains(&id)
            && !self.is_resident(id)
            && !self.refused.contains(&id)
            && !self.waiting.iter().any(|(waiting, _)| *waiting == id)
    }

    /// Whether no bundle arrives, leaves or fades, and all writes have been taken.
    pub(super) fn are_settled(&self) -> bool {
        self.pool.queued_words() == 0
            && self.waiting.is_empty()
            && self.fading.is_empty()
            && self.chosen.iter().all(|id| self.is_resident(*id) || self.refused.contains(id))
    }

    /// Makes a bundle resident as soon as there is room. For a chosen bundle, those chosen least recently
    /// make room.
    pub(super) fn add(&mut self, id: BundleId, bundle: LoadedBundle) {
        if !self.is_resident(id) {
            self.waiting.push_back((id, bundle));
            self.place_waiting();
        }
    }

    /// Changes all fading weights by one frame's step.
    pub(super) fn fade(&mut self) {
        let fading: Vec<BundleId> = self.fading.iter().copied().collect();
        for id in fading {
            let (Some(bundle), Some(level)) = (self.bundles.get_mut(&id), self.layout.index_of(id.level))
            else {
                continue;
            };
            let is_written = self.pool.taken_writes() >= bundle.written_at;
            let weight = if bundle.is_leaving {
                bundle.weight.saturating_sub(self.step)
            } else if is_written {
                WHOLE.min(bundle.weight + self.step)
            } else {
                continue;
            };
            if weight != bundle.weight {
                bundle.weight = weight;
                self.pool.put_weight(&self.layout.levels[level], &bundle.pages, weight);
            }
            if bundle.is_leaving && weight == 0 {
                self.remove(id);
            } else if !bundle.is_leaving && weight == WHOLE {
                self.fading.remove(&id);
            }
        }
        self.place_waiting();
    }

    fn place_waiting(&mut self) {
        while let Some((id, mut bundle)) = self.waiting.pop_front() {
            let Some(level) = self.layout.index_of(id.level) else { continue };
            let places = &self.layout.levels[level];
            let is_chosen = self.chosen.contains(&id);
            if let Some(pages) = self.pool.place(&self.layout, places, &mut bundle) {
                let last_choice = if is_chosen { self.choice } else { 0 };
                let fades = places.fades;
                let weight = if fades { 0 } else { WHOLE };
                let written_at = self.pool.put_writes();
                let bundle = ResidentBundle { pages, last_choice, weight, is_leaving: false, written_at };
                self.bundles.insert(id, bundle);
                if fades {
                    self.fading.insert(id);
                }
            } else if is_chosen && self.make_room(&bundle) {
                self.waiting.push_front((id, bundle));
                if self.step < WHOLE {
                    return;
                }
            } else if is_chosen {
                self.refused.insert(id);
            }
        }
    }

    /// Lets the bundles that were chosen least recently leave, until `bundle` may find room. Returns whether
    /// any leaves.
    fn make_room(&mut self, bundle: &LoadedBundle) -> bool {
        let mut leaving: u32 = self.bundles.values().filter(|b| b.is_leaving).map(|b| b.pages.words()).sum();
        let needed = PlacedPages::words_of(bundle);
        while leaving == 0 || self.pool.free_words() + leaving < needed {
            let is_idle = |bundle: &ResidentBundle| bundle.last_choice < self.choice && !bundle.is_leaving;
            let idle = self.bundles.iter_mut().filter(|(_, bundle)| is_idle(bundle));
            let oldest = idle.min_by_key(|(id, bundle)| (bundle.last_choice, **id));
            let Some((&id, bundle)) = oldest else { break };
            leaving += bundle.pages.words().max(1);
            if self.step == WHOLE {
                self.remove(id);
                break;
            }
            bundle.is_leaving = true;
            self.fading.insert(id);
        }
        leaving > 0
    }

    fn remove(&mut self, id: BundleId) {
        self.fading.remove(&id);
        if let (Some(bundle), Some(level)) = (self.bundles.remove(&id), self.layout.index_of(id.level)) {
            self.pool.remove(&self.layout.levels[level], &bundle.pages);
        }
    }
}
