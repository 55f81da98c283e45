//! A bake that is kept, so that an edit of its scene costs the pages that the edit touches.

use std::collections::HashSet;
use std::io::{Seek, Write};
use std::path::Path;
use std::sync::Arc;

use adumbra::{LightGrid, ShadowFile};
use adumbra_files::StagedFile;
use adumbra_scene::{Edits, Scene};

use crate::bake::BakeSummary;
use crate::cache::{BakeCache, CacheKey, MemoryCache};
use crate::error::Result;
use crate::farm::{BakePlan, BakedParts, PartBaker, PlannedPart, Prepared, link_in_memory};
use crate::options::BakeOptions;
use crate::progress::Watch;
use crate::sink::depths::DepthsBlock;
use crate::sink::recent::RecentBlocks;

/// A scene, the options of its bake, and the pages that were baked. Unless the options limit the memory, it
/// also holds the root blocks of pages that have several, about half a kilobyte for each block of 8 × 8
/// texels that an outline crosses: such pages are those of coarse levels.
///
/// ```no_run
/// use adumbra_bake::{BakeOptions, Baker, Size, Watch};
/// use adumbra_scene::{Edits, LoadOptions, Moved, Which, load};
///
/// let scene = load("city.glb".as_ref(), &LoadOptions::default())?;
/// let sun = adumbra::Sun::from_direction([0.5, 0.8, 0.35])?;
/// let mut baker = Baker::new(scene, &BakeOptions::new(sun, Size::Resolution(8192)))?;
/// baker.bake(None, Watch::none())?;
/// let before = baker.in_memory()?;
/// let mut world_from_mesh = baker.scene().instances[7].world_from_mesh;
/// world_from_mesh[0][3] += 1.0;
/// let moved = vec![Moved { instance: Which::Number(7), world_from_mesh }];
/// baker.edit(&Edits { moved, ..Edits::default() })?;
/// let is_due = |part: &&_| !baker.is_baked(part);
/// println!("{} parts are to be baked", baker.plan().parts().iter().filter(is_due).count());
/// baker.bake(Some([0.0, 0.0, 0.0]), Watch::none())?;
/// let after = baker.in_memory()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Baker {
    scene: Scene,
    /// With the frame that was chosen first, and with the first decision on the ground.
    options: BakeOptions,
    cache: Arc<dyn BakeCache>,
    plan: BakePlan,
    /// Keys whose entries are there.
    known: HashSet<CacheKey>,
    /// What planning has found of the scene, unless memory is limited.
    prepared: Option<Prepared>,
    /// The root blocks of the pages that have several, unless memory is limited.
    recent: Option<Arc<RecentBlocks<DepthsBlock>>>,
}

impl Baker {
    /// Plans the bake of a scene, and keeps what is baked in memory. The frame that the options let the bake
    /// choose is chosen once, for all edits, and so is whether a ground is assumed.
    ///
    /// # Errors
    /// Returns the errors of [`BakePlan::new`].
    pub fn new(scene: Scene, options: &BakeOptions) -> Result<Self> {
        Self::with_cache(scene, options, MemoryCache::default())
    }

    /// Plans the bake of a scene, and keeps what is baked in `cache`. See [`Baker::new`].
    ///
    /// # Errors
    /// Returns the errors of [`BakePlan::new`].
    pub fn with_cache(scene: Scene, options: &BakeOptions, cache: impl BakeCache + 'static) -> Result<Self> {
        let cache: Arc<dyn BakeCache> = Arc::new(cache);
        let (plan, prepared) = BakePlan::prepared(&scene, options)?;
        let BakeOptions { frame, assume_ground, .. } = plan.options();
        let options = BakeOptions { frame, assume_ground, ..options.clone() };
        let is_unlimited = options.max_memory_bytes.is_none();
        let (prepared, recent) = (is_unlimited.then_some(prepared), is_unlimited.then(Arc::default));
        Ok(Self { scene, options, cache, plan, known: HashSet::new(), prepared, recent })
    }

    /// Returns the scene as it is now.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Returns options with which a bake of the scene writes the same bytes.
    pub fn options(&self) -> &BakeOptions {
        &self.options
    }

    /// Returns the placement of each level's voxels in the world, the finest first. An edit that makes the
    /// scene larger or smaller changes it.
    pub fn grids(&self) -> Vec<LightGrid> {
        self.plan.grids()
    }

    /// Edits the scene. Either all edits are made, or none.
    ///
    /// # Errors
    /// Returns [`Error::Scene`](crate::Error::Scene) if the edits cannot be made, and the errors of
    /// [`BakePlan::new`].
    pub fn edit(&mut self, edits: &Edits) -> Result<()> {
        let mut scene = self.scene.clone();
        scene.edit(edits)?;
        self.replace(scene)
    }

    /// Takes another scene in place of the one there is: what is equal in both stays baked.
    ///
    /// # Errors
    /// Returns the errors of [`BakePlan::new`]. The scene is as before then.
    pub fn replace(&mut self, scene: Scene) -> Result<()> {
        let (plan, prepared) = BakePlan::prepared(&scene, &self.options)?;
        (self.plan, self.prepared) = (plan, self.prepared.as_ref().map(|_| prepared));
        self.scene = scene;
        let keys: HashSet<CacheKey> = self.plan.parts().iter().map(|part| *part.key()).collect();
        self.known.retain(|key| keys.contains(key));
        Ok(())
    }

    /// Returns the plan of the scene as it is now.
    pub fn plan(&self) -> &BakePlan {
        &self.plan
    }

    /// Whether a part of the plan has been baked. The part must be one of [`Baker::plan`].
    pub fn is_baked(&self, part: &PlannedPart) -> bool {
        self.known.contains(part.key())
    }

    /// Bakes the pages that are not baked yet: coarse levels first, and of each level those nearest to
    /// `focus`, a point in the world, first. What was done before an error stays.
    ///
    /// # Errors
    /// Returns the errors of [`PartBaker::bake`].
    pub fn bake(&mut self, focus: Option<[f64; 3]>, watch: Watch<'_>) -> Result<BakedParts> {
        self.bake_from(0, focus, watch)
    }

    /// Bakes the pages of all levels but the finest that are not baked yet. See [`Baker::bake`].
    ///
    /// # Errors
    /// Returns the errors of [`PartBaker::bake`].
    pub fn bake_coarser(&mut self, focus: Option<[f64; 3]>, watch: Watch<'_>) -> Result<BakedParts> {
        self.bake_from(1, focus, watch)
    }

    fn bake_from(&mut self, level: u32, focus: Option<[f64; 3]>, watch: Watch<'_>) -> Result<BakedParts> {
        let parts = self.plan.parts();
        let is_due = |&id: &usize| parts[id].level() >= level && !self.known.contains(parts[id].key());
        let mut ids: Vec<usize> = (0..parts.len()).filter(is_due).collect();
        if let Some(focus) = focus {
            ids.sort_by_cached_key(|&id| self.plan.texels_from(id, focus));
        }
        if ids.is_empty() {
            return Ok(BakedParts::default());
        }
        let mut baker = match self.prepared.clone() {
            Some(prepared) => PartBaker::prepared(&self.scene, &self.plan, &self.options, prepared),
            None => PartBaker::new(&self.scene, &self.plan, &self.options)?,
        };
        if let Some(recent) = &self.recent {
            baker = baker.with_recent(Arc::clone(recent));
        }
        let done = baker.bake(&ids, &self.cache, watch)?;
        self.known.extend(ids.iter().map(|&id| *parts[id].key()));
        Ok(done)
    }

    /// Forgets which pages are baked. If linking misses some, because their entries could not be read again,
    /// the next bake makes them.
    pub fn forget(&mut self) {
        self.known.clear();
    }

    /// Links the pages to a file at `path`, which replaces an existing file when it is complete. What exceeds
    /// a memory limit goes to the folder of `path`, unless the options name another one.
    ///
    /// # Errors
    /// Returns the errors of [`Baker::in_memory`], and [`Error::Io`](crate::Error::Io) with the path of the
    /// file if it cannot be written.
    pub fn save(&self, path: impl AsRef<Path>, watch: Watch<'_>) -> Result<BakeSummary> {
        let summary = self.replace_file(&self.plan, path.as_ref(), watch)?;
        // Only earlier scenes needed the entries that were not read.
        self.cache.tidy();
        Ok(summary)
    }

    fn replace_file(&self, plan: &BakePlan, path: &Path, watch: Watch<'_>) -> Result<BakeSummary> {
        let (staged, summary) = plan.stage_link(&self.cache, &self.options, watch, path)?;
        StagedFile::place([staged])?;
        Ok(summary)
    }

    /// Links the pages of all levels but the finest to a file at `path`. See [`Baker::save`] and
    /// [`Baker::write_coarser_to`].
    ///
    /// # Errors
    /// Returns the errors of [`Baker::save`].
    pub fn save_coarser(&self, path: impl AsRef<Path>, watch: Watch<'_>) -> Result<BakeSummary> {
        let coarser = self.plan.without_finest();
        self.replace_file(coarser.as_ref().unwrap_or(&self.plan), path.as_ref(), watch)
    }

    /// Links the pages to a file in `out`, from its position on.
    ///
    /// # Errors
    /// Returns [`Error::MissingParts`](crate::Error::MissingParts) if pages are not baked, and the errors of
    /// [`BakePlan::link`].
    pub fn write_to(&self, out: impl Write + Seek, watch: Watch<'_>) -> Result<BakeSummary> {
        let written = self.plan.link(&self.cache, &self.options, watch, out)?;
        // Only earlier scenes needed the entries that were not read.
        self.cache.tidy();
        Ok(written)
    }

    /// Links the pages of all levels but the finest to a file in `out`; of a bake with one level, those of
    /// this level.
    ///
    /// # Errors
    /// Returns the errors of [`Baker::write_to`].
    pub fn write_coarser_to(&self, out: impl Write + Seek, watch: Watch<'_>) -> Result<BakeSummary> {
        let coarser = self.plan.without_finest();
        coarser.as_ref().unwrap_or(&self.plan).link(&self.cache, &self.options, watch, out)
    }

    /// Returns the file in memory.
    ///
    /// # Errors
    /// Returns the errors of [`Baker::write_to`].
    pub fn in_memory(&self) -> Result<ShadowFile> {
        let file = link_in_memory(&self.plan, &self.cache, &self.options)?;
        // Only earlier scenes needed the entries that were not read.
        self.cache.tidy();
        Ok(file)
    }
}
